//! When a step is to look for no better solution.

use std::time::{Duration, Instant};

/// A time by the clock; none by default.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deadline(Option<Instant>);

impl Deadline {
    /// So many ms from now; none without a number, or with one that no clock tells.
    pub fn after(ms: Option<f64>) -> Self {
        let time = ms.and_then(|ms| Duration::try_from_secs_f64(ms / 1e3).ok());
        Self(time.and_then(|time| Instant::now().checked_add(time)))
    }

    /// Whether it has passed.
    pub fn is_over(self) -> bool {
        self.0.is_some_and(|end| Instant::now() >= end)
    }
}
