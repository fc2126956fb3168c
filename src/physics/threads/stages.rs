//! Many short stages on several threads, in one scope.
//!
//! Opening a scope costs some 60 µs of waking; a step has a hundred stages of a few microseconds.
//! So workers enter one scope and walk the stages together: each claims chunks of the present stage
//! by an atomic counter, and spins until all its chunks are done before it goes on. The calling
//! thread can do every chunk of every stage itself, so that nobody waits for a worker that starts
//! late or never; a late one joins at the stage the others are at.

use std::sync::atomic::{AtomicUsize, Ordering};

use bevy::tasks::ComputeTaskPool;

/// Spins before a worker lets others have its core: the operating system may have more threads
/// than cores.
const SPINS: u32 = 2000;

/// Where everybody is in one stage.
#[derive(Default)]
struct Progress {
    claimed: AtomicUsize,
    done: AtomicUsize,
}

/// Calls `work(stage, chunk)` once for every chunk of every stage; a stage begins when the one
/// before it is done. `chunks[s]` is the number of chunks of stage s. With one thread, everything
/// runs in order on the calling thread.
pub(crate) fn walk_stages(threads: u32, chunks: &[usize], work: impl Fn(usize, usize) + Sync) {
    let most = chunks.iter().copied().max().unwrap_or(0);
    let workers = (threads as usize).min(most);
    let pool = if workers > 1 { ComputeTaskPool::try_get() } else { None };
    let Some(pool) = pool else {
        for (stage, &count) in chunks.iter().enumerate() {
            (0..count).for_each(|chunk| work(stage, chunk));
        }
        return;
    };
    let progress: Vec<Progress> = chunks.iter().map(|_| Progress::default()).collect();
    let walk = || {
        for (stage, (&count, progress)) in chunks.iter().zip(&progress).enumerate() {
            loop {
                let chunk = progress.claimed.fetch_add(1, Ordering::Relaxed);
                if chunk >= count {
                    break;
                }
                work(stage, chunk);
                // Whoever sees the stage done sees what was written in it.
                progress.done.fetch_add(1, Ordering::Release);
            }
            let mut spins = 0;
            while progress.done.load(Ordering::Acquire) < count {
                spins += 1;
                if spins < SPINS {
                    std::hint::spin_loop();
                } else {
                    std::thread::yield_now();
                }
            }
        }
    };
    pool.scope(|scope| {
        for _ in 1..workers {
            scope.spawn(async { walk() });
        }
        walk();
    });
}

#[cfg(test)]
mod tests {
    use super::walk_stages;
    use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_chunk_is_done_once_and_after_the_stage_before() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        let chunks = [3, 0, 40, 1, 7, 100, 2];
        for threads in [1, 2, 4, 9] {
            let counts: Vec<AtomicUsize> = chunks.iter().map(|_| AtomicUsize::new(0)).collect();
            walk_stages(threads, &chunks, |stage, chunk| {
                assert!(chunk < chunks[stage]);
                for before in 0..stage {
                    assert_eq!(counts[before].load(Ordering::SeqCst), chunks[before], "stage {stage}");
                }
                counts[stage].fetch_add(1, Ordering::SeqCst);
            });
            let counts: Vec<usize> = counts.iter().map(|count| count.load(Ordering::SeqCst)).collect();
            assert_eq!(counts, chunks, "{threads} threads");
        }
    }
}
