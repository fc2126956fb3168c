//! Blocks of work, each for whichever thread comes first.

use std::sync::Mutex;

use bevy::tasks::ComputeTaskPool;

use super::Division;
use super::workers::on_workers;

/// Calls `work` once on every block; a panic of it goes on from here. Up to `threads` threads, the calling one
/// included, claim blocks in order; what a block holds must not depend on who works on it, and then the result
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
    let division = Division::of_blocks();
    let work = |(index, block)| division.work_as(index, || work(block));
    let blocks = blocks.enumerate();
    let Some(pool) = pool else {
        blocks.for_each(work);
        return;
    };
    let unclaimed = Mutex::new(blocks);
    // Nothing is left to claim once making a block has panicked.
    let claim = || unclaimed.lock().ok()?.next();
    on_workers(pool, workers, |_| {
        while let Some(block) = claim() {
            work(block);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::{for_each_block, for_each_of};
    use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
    use std::collections::HashSet;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicBool, Ordering};
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

    /// Whoever panics, over a block or where the next is made, its message comes to the caller, and the pool works on.
    #[test]
    fn a_panic_arrives_as_it_was() {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        let caller = std::thread::current().id();
        let said = |run: &dyn Fn()| {
            let payload = catch_unwind(AssertUnwindSafe(run)).expect_err("it must not get lost");
            payload.downcast_ref::<String>().expect("a formatted message").clone()
        };
        for (threads, by_caller) in [(2, true), (2, false), (4, true), (4, false)] {
            let is_here = AtomicBool::new(false);
            let message = said(&|| {
                for_each_of(threads, 0..8, |block| {
                    if (std::thread::current().id() == caller) == by_caller {
                        is_here.store(true, Ordering::SeqCst);
                        panic!("block {block} is broken");
                    }
                    // Others leave a block to the one that panics.
                    while !is_here.load(Ordering::SeqCst) {
                        std::thread::yield_now();
                    }
                });
            });
            assert!(message.ends_with(" is broken"), "{threads}, {by_caller}: {message}");
            let message = said(&|| {
                let blocks = (0..8).inspect(|block| assert!(*block < 3, "block {block} cannot be made"));
                for_each_of(threads, blocks, |_| std::thread::yield_now());
            });
            assert_eq!(message, "block 3 cannot be made", "{threads}");
            let mut blocks = [0; 20];
            for_each_block(threads, &mut blocks, |block| *block += 1);
            assert_eq!(blocks, [1; 20]);
        }
    }
}
