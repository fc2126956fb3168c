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
#[derive(Debug, Default)]
struct Stage {
    chunks: usize,
    claimed: AtomicUsize,
    done: AtomicUsize,
}

/// Stages to walk, each of so many chunks. Kept from step to step for its memory.
#[derive(Debug, Default)]
pub(crate) struct Stages(Vec<Stage>);

impl Stages {
    /// Begins anew, with the number of chunks of each stage.
    pub fn begin(&mut self, chunks: impl Iterator<Item = usize>) {
        self.0.clear();
        self.0.extend(chunks.map(|chunks| Stage { chunks, ..Stage::default() }));
    }

    /// Calls `work(stage, chunk)` once for every chunk of every stage; a stage begins when the one
    /// before it is done. With one thread, everything runs in order on the calling thread.
    pub fn walk(&self, threads: u32, work: impl Fn(usize, usize) + Sync) {
        let most = self.0.iter().map(|stage| stage.chunks).max().unwrap_or(0);
        let workers = (threads as usize).min(most);
        let pool = if workers > 1 { ComputeTaskPool::try_get() } else { None };
        let Some(pool) = pool else {
            for (stage, &Stage { chunks, .. }) in self.0.iter().enumerate() {
                (0..chunks).for_each(|chunk| work(stage, chunk));
            }
            return;
        };
        pool.scope(|scope| {
            for _ in 1..workers {
                scope.spawn(async { self.walk_along(&work) });
            }
            self.walk_along(&work);
        });
    }

    /// One worker's way.
    fn walk_along(&self, work: &impl Fn(usize, usize)) {
        for (index, stage) in self.0.iter().enumerate() {
            loop {
                let chunk = stage.claimed.fetch_add(1, Ordering::Relaxed);
                if chunk >= stage.chunks {
                    break;
                }
                work(index, chunk);
                // Whoever sees the stage done sees what was written in it.
                stage.done.fetch_add(1, Ordering::Release);
            }
            let mut spins = 0;
            while stage.done.load(Ordering::Acquire) < stage.chunks {
                spins += 1;
                if spins < SPINS {
                    std::hint::spin_loop();
                } else {
                    std::thread::yield_now();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Stages;
    use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_chunk_is_done_once_and_after_the_stage_before() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        let chunks = [3, 0, 40, 1, 7, 100, 2];
        let mut stages = Stages::default();
        for threads in [1, 2, 4, 9] {
            let counts: Vec<AtomicUsize> = chunks.iter().map(|_| AtomicUsize::new(0)).collect();
            stages.begin(chunks.into_iter());
            stages.walk(threads, |stage, chunk| {
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
