//! How far a long command is.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on standard error for runs that a person waits for.
pub struct Progress {
    started: Instant,
    steps: u64,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Runs shorter than this are over before a bar is read.
    const PATIENCE: Duration = Duration::from_secs(1);

    /// Of a run of so many steps.
    pub fn new(steps: u64) -> Self {
        Self { started: Instant::now(), steps, bar: None }
    }

    /// So many of them are done.
    pub fn show(&mut self, step: u64) {
        if self.bar.is_none() && self.started.elapsed() > Self::PATIENCE && std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %, {eta} left");
            let bar = ProgressBar::new(self.steps).with_elapsed(self.started.elapsed());
            self.bar = Some(bar.with_style(style.expect("a template of this file")));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(step);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
