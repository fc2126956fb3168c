//! Work split over Bevy's compute pool, at most one scope a phase.

mod shared;
mod stages;

pub(crate) use shared::Shared;
pub(crate) use stages::Stages;

use std::sync::Mutex;

use bevy::tasks::ComputeTaskPool;

/// Calls `work` once on every block. Up to `threads` threads, the calling one included, claim
/// blocks in order; what a block holds must not depend on who works on it, and then the result
/// does not depend on the number of threads.
///
/// The calling thread works too and can finish alone: a worker that starts late finds nothing
/// left to claim.
pub(crate) fn for_each_block<T: Send>(threads: u32, blocks: &mut [T], work: impl Fn(&mut T) + Sync) {
    for_each_of(threads, blocks.iter_mut(), work);
}

/// As [`for_each_block`], of blocks that are made as they are claimed.
pub(crate) fn for_each_of<T: Send>(
    threads: u32,
    blocks: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(T) + Sync,
) {
    let workers = (threads as usize).min(blocks.len());
    let pool = if workers > 1 { ComputeTaskPool::try_get() } else { None };
    let Some(pool) = pool else {
        blocks.for_each(work);
        return;
    };
    let unclaimed = Mutex::new(blocks);
    let claim = || unclaimed.lock().expect("a worker panicked").next();
    let work_through = || {
        while let Some(block) = claim() {
            work(block);
        }
    };
    pool.scope(|scope| {
        for _ in 1..workers {
            scope.spawn(async { work_through() });
        }
        work_through();
    });
}

#[cfg(test)]
mod tests {
    use super::for_each_block;
    use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
    use std::collections::HashSet;
    use std::sync::{Condvar, Mutex};

    #[test]
    fn every_block_is_worked_on_once() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        for threads in [1, 2, 4, 9] {
            let mut blocks: Vec<u32> = (0..100).collect();
            for_each_block(threads, &mut blocks, |block| *block += 1000);
            assert_eq!(blocks, (1000..1100).collect::<Vec<_>>(), "{threads} threads");
        }
    }

    #[test]
    fn two_threads_work_at_once() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        let seen = Mutex::new(HashSet::new());
        let second = Condvar::new();
        for_each_block(2, &mut [(); 2], |()| {
            // Each block waits until the other has been claimed, by another thread.
            let mut seen = seen.lock().unwrap();
            seen.insert(std::thread::current().id());
            second.notify_all();
            while seen.len() < 2 {
                seen = second.wait(seen).unwrap();
            }
        });
        assert_eq!(seen.lock().unwrap().len(), 2);
    }
}
