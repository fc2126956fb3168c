//! Some threads of the pool, and this one, on the same work.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, PoisonError};

use bevy::tasks::TaskPool;

use super::crew::help;

/// What a panic carries.
type Payload = Box<dyn Any + Send>;

/// Calls `work` with 0 on this thread and with other numbers below `workers` on threads of the pool, as many as come
/// before it is through, and comes back when all are done. The first panic of any of them goes on from here.
pub(super) fn on_workers(pool: &TaskPool, workers: usize, work: impl Fn(usize) + Sync) {
    let panicked: Mutex<Option<Payload>> = Mutex::new(None);
    help(pool, workers, &|worker| {
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| work(worker))) {
            panicked.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(payload);
        }
    });
    if let Some(payload) = panicked.into_inner().unwrap_or_else(PoisonError::into_inner) {
        resume_unwind(payload);
    }
}
