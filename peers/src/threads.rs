//! Pools of threads that engines share with the whole process: sized once, before any engine runs.

use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};

/// Gives every engine `threads` threads, the calling one included where the pool allows.
///
/// Rapier: the global rayon pool, of which the calling thread is one, so that nothing is handed
/// over at each step. Bevy's compute pool: Plumb caps itself at `threads`, its caller included;
/// Avian splits its work by the number of workers, so it gets as many, one more than Bevy itself
/// would make. Box3D makes its own threads.
pub fn size_pools(threads: u32) {
    let threads = threads as usize;
    // Both are set once in a process; a second call keeps the first.
    _ = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global();
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads).build());
}
