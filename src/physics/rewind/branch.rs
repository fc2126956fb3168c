//! What was to come, where something else was done.

use std::collections::BTreeMap;

use super::acts::Acts;
use super::keyframe::Keyframe;

/// What was to come, of a moment at which somebody did something else; or, where that was taken back, what was done
/// instead.
pub(super) struct Branch {
    /// Which cut made it.
    pub cut: u64,
    /// Where it begins, and how many of the acts there are those of both.
    pub at: u64,
    pub acts_at: usize,
    /// Its own acts there, after those.
    pub own: Vec<Acts>,
    pub frames: Vec<Keyframe>,
    pub acts: BTreeMap<u64, Vec<Acts>>,
    pub last: u64,
    /// Those that began in it, the last last.
    pub inner: Vec<Branch>,
}

impl Branch {
    /// About what it takes, bytes.
    pub fn bytes(&self) -> usize {
        let frames: usize = self.frames.iter().map(Keyframe::bytes).sum();
        let acts: usize = self.acts.values().flatten().chain(&self.own).map(Acts::bytes).sum();
        frames + acts + self.inner.iter().map(Self::bytes).sum::<usize>()
    }
}
