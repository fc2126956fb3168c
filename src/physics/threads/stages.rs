//! Many short stages on several threads, as one piece of work.
//!
//! A step has a hundred stages of a few microseconds. So workers walk them together: each claims chunks of the present stage
//! by an atomic counter, and spins until all its chunks are done before it goes on. The calling
//! thread can do every chunk of every stage itself, so that nobody waits for a worker that starts
//! late or never; a late one joins at the stage the others are at.
//!
//! The chunks of a stage are cut into as many runs as there are workers. Each has a run of its own, and takes from
//! those of others what is left when it is through: where chunks of all stages lie in the same order, most of what a
//! worker writes stays in its own cache from stage to stage.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bevy::tasks::ComputeTaskPool;

use super::spin::wait_a_little;
use super::workers::on_workers;
use crate::physics::Refill;

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
    /// Whether a worker has panicked: its stage will never be done.
    is_broken: AtomicBool,
}

/// Nobody is anywhere.
impl Clone for Stages {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Tells the other workers of a panic that passes by.
struct Alarm<'a>(&'a AtomicBool);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

impl Stages {
    /// Calls `work(stage, chunk)` once for every chunk of every stage, of which so many are told for each; a stage
    /// begins when the one before it is done. With one thread, everything runs in order on the calling thread. A panic
    /// of `work` goes on from here, when all workers have come to the end of its stage.
    pub fn walk(&mut self, threads: u32, chunks: impl Iterator<Item = usize>, work: impl Fn(usize, usize) + Sync) {
        let pool = if threads > 1 { ComputeTaskPool::try_get() } else { None };
        let Some(pool) = pool else {
            for (stage, chunks) in chunks.enumerate() {
                (0..chunks).for_each(|chunk| work(stage, chunk));
            }
            return;
        };
        self.chunks.refill(chunks);
        let workers = (threads as usize).min(self.chunks.iter().copied().max().unwrap_or(0)).max(1);
        self.done.clear();
        self.done.resize_with(self.chunks.len(), Counter::default);
        self.claimed.clear();
        self.claimed.resize_with(self.chunks.len() * workers, Counter::default);
        *self.is_broken.get_mut() = false;
        let stages = &*self;
        on_workers(pool, workers, |worker| stages.walk_along(worker, workers, &work));
    }

    /// One worker's way.
    fn walk_along(&self, worker: usize, workers: usize, work: &impl Fn(usize, usize)) {
        let _alarm = Alarm(&self.is_broken);
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
            let mut looks = 0;
            while done.load(Ordering::Acquire) < chunks {
                if self.is_broken.load(Ordering::Relaxed) {
                    return;
                }
                wait_a_little(&mut looks);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Stages;
    use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

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

    /// Who panics in its chunk: the calling thread or another.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Who {
        Caller,
        Worker,
    }

    #[test]
    fn a_panic_reaches_the_caller_and_leaves_all_in_order() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        let caller = std::thread::current().id();
        let mut stages = Stages::default();
        for (threads, who) in [(2, Who::Caller), (2, Who::Worker), (4, Who::Caller), (4, Who::Worker)] {
            let after = AtomicUsize::new(0);
            let is_here = AtomicBool::new(false);
            let walk = AssertUnwindSafe(|| {
                stages.walk(threads, [8, 8, 8].into_iter(), |stage, chunk| {
                    if stage == 1 {
                        let is_caller = std::thread::current().id() == caller;
                        if is_caller == (who == Who::Caller) {
                            is_here.store(true, Ordering::SeqCst);
                            panic!("chunk {chunk} is broken");
                        }
                        // Others leave a chunk to the one that panics.
                        while !is_here.load(Ordering::SeqCst) {
                            std::thread::yield_now();
                        }
                    }
                    after.fetch_add(usize::from(stage == 2), Ordering::SeqCst);
                });
            });
            let payload = catch_unwind(walk).expect_err("it must not get lost");
            let said = payload.downcast_ref::<String>().expect("a formatted message");
            assert!(said.starts_with("chunk ") && said.ends_with(" is broken"), "{threads}, {who:?}: {said}");
            assert_eq!(after.load(Ordering::SeqCst), 0, "{threads}, {who:?}: went on after a stage that is not done");

            // All of it can be used again.
            let count = AtomicUsize::new(0);
            stages.walk(threads, [5, 50].into_iter(), |_, _| {
                count.fetch_add(1, Ordering::SeqCst);
            });
            assert_eq!(count.load(Ordering::SeqCst), 55, "{threads}, {who:?}");
        }
    }
}
