//! Many short stages on several threads, in one scope.
//!
//! Opening a scope costs some 60 µs of waking; a step has a hundred stages of a few microseconds.
//! So workers enter one scope and walk the stages together: each claims chunks of the present stage
//! by an atomic counter, and spins until all its chunks are done before it goes on. The calling
//! thread can do every chunk of every stage itself, so that nobody waits for a worker that starts
//! late or never; a late one joins at the stage the others are at.
//!
//! The chunks of a stage are cut into as many runs as there are workers. Each has a run of its own, and takes from
//! those of others what is left when it is through: where chunks of all stages lie in the same order, most of what a
//! worker writes stays in its own cache from stage to stage.

use std::sync::atomic::{AtomicUsize, Ordering};

use bevy::tasks::ComputeTaskPool;

/// Spins before a worker lets others have its core: the operating system may have more threads
/// than cores.
const SPINS: u32 = 2000;

/// A counter that shares its cache line with no other.
#[derive(Debug, Default)]
#[repr(align(64))]
struct Counter(AtomicUsize);

/// Where everybody is. Kept from step to step for its memory.
#[derive(Debug, Default)]
pub(crate) struct Stages {
    /// Of each stage.
    chunks: Vec<usize>,
    /// Of each stage, chunks done.
    done: Vec<Counter>,
    /// Of each stage, and in it of each worker's run, chunks claimed.
    claimed: Vec<Counter>,
}

impl Stages {
    /// Calls `work(stage, chunk)` once for every chunk of every stage, of which so many are told for each; a stage
    /// begins when the one before it is done. With one thread, everything runs in order on the calling thread.
    pub fn walk(&mut self, threads: u32, chunks: impl Iterator<Item = usize>, work: impl Fn(usize, usize) + Sync) {
        let pool = if threads > 1 { ComputeTaskPool::try_get() } else { None };
        let Some(pool) = pool else {
            for (stage, chunks) in chunks.enumerate() {
                (0..chunks).for_each(|chunk| work(stage, chunk));
            }
            return;
        };
        self.chunks.clear();
        self.chunks.extend(chunks);
        let workers = (threads as usize).min(self.chunks.iter().copied().max().unwrap_or(0)).max(1);
        self.done.clear();
        self.done.resize_with(self.chunks.len(), Counter::default);
        self.claimed.clear();
        self.claimed.resize_with(self.chunks.len() * workers, Counter::default);
        let stages = &*self;
        let walk_along = |worker| stages.walk_along(worker, workers, &work);
        pool.scope(|scope| {
            for worker in 1..workers {
                scope.spawn(async move { walk_along(worker) });
            }
            walk_along(0);
        });
    }

    /// One worker's way.
    fn walk_along(&self, worker: usize, workers: usize, work: &impl Fn(usize, usize)) {
        let runs = self.claimed.chunks_exact(workers);
        for (index, ((&chunks, Counter(done)), runs)) in self.chunks.iter().zip(&self.done).zip(runs).enumerate() {
            let mut mine = 0;
            for run in (worker..workers).chain(0..worker) {
                let Counter(claimed) = &runs[run];
                let (start, end) = (chunks * run / workers, chunks * (run + 1) / workers);
                loop {
                    let chunk = start + claimed.fetch_add(1, Ordering::Relaxed);
                    if chunk >= end {
                        break;
                    }
                    work(index, chunk);
                    mine += 1;
                }
            }
            // Whoever sees the stage done sees what was written in it.
            done.fetch_add(mine, Ordering::Release);
            let mut spins = 0;
            while done.load(Ordering::Acquire) < chunks {
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
            stages.walk(threads, chunks.into_iter(), |stage, chunk| {
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
