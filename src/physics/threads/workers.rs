//! Some threads of the pool, and this one, on the same work.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, PoisonError};

use bevy::tasks::TaskPool;

/// What a panic carries.
type Payload = Box<dyn Any + Send>;

/// Calls `work` with 0 on this thread and with each number up to `workers` on threads of the pool, and comes back when
/// all are done. The first panic of any of them goes on from here: one that left the pool's scope by itself would drop
/// what the other workers still use.
pub(super) fn on_workers(pool: &TaskPool, workers: usize, work: impl Fn(usize) + Sync) {
    let panicked: Mutex<Option<Payload>> = Mutex::new(None);
    let work = |worker| {
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| work(worker))) {
            panicked.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(payload);
        }
    };
    let work = &work;
    pool.scope(|scope| {
        for worker in 1..workers {
            scope.spawn(async move { work(worker) });
        }
        work(0);
    });
    if let Some(payload) = panicked.into_inner().unwrap_or_else(PoisonError::into_inner) {
        resume_unwind(payload);
    }
}
