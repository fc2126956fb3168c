//! What steps cost: by the clock, and in counts that no clock spoils.

use serde::Serialize;

use crate::physics::StepStats;

/// Wall-clock time, ms, of the physics step alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StepMilliseconds {
    /// Half of the steps took at most this.
    pub median: f64,
    /// 95 of 100 steps took at most this.
    pub p95: f64,
    /// All steps together.
    pub total: f64,
}

/// Work of the last step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StepCounts {
    /// Row updates: rows × iterations × solves.
    pub row_updates: u64,
    /// Pairs that the narrow phase tested.
    pub pairs: u32,
    /// Axes along which it measured pairs.
    pub axes_tested: u64,
}

/// What the exact method had to do beside its steps, over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ExactCounts {
    /// Parts into which steps were cut: at impacts, and where they were too long.
    pub cuts: u64,
    /// Solves and parts that did not come to their laws, however many tries they were given.
    pub unsettled: u64,
    /// Sliding points at which no rigid motion exists (Painlevé), once for each part of a step: an impulse stops them.
    pub jammed: u64,
}

impl ExactCounts {
    pub(super) fn add(&mut self, stats: &StepStats) {
        self.cuts += u64::from(stats.cuts);
        self.unsettled += u64::from(stats.unsettled);
        self.jammed += u64::from(stats.jammed);
    }
}

impl StepCounts {
    pub(super) fn of(stats: &StepStats) -> Self {
        Self { row_updates: stats.row_updates, pairs: stats.pairs, axes_tested: stats.axes_tested }
    }
}

impl StepMilliseconds {
    /// From the time of each step, s.
    pub(in crate::lab) fn of(mut seconds: Vec<f64>) -> Self {
        let total = 1e3 * seconds.iter().sum::<f64>();
        seconds.sort_unstable_by(f64::total_cmp);
        // Nearest rank: the smallest time that this share of the steps did not exceed.
        let rank = |share: f64| {
            let rank = (share * seconds.len() as f64).ceil() as usize;
            seconds.get(rank.max(1) - 1).map_or(0.0, |&seconds| 1e3 * seconds)
        };
        Self { median: rank(0.5), p95: rank(0.95), total }
    }
}

/// The widest vector instructions that the compiler was allowed.
pub(super) const fn simd() -> &'static str {
    if cfg!(target_feature = "avx512f") {
        "avx512"
    } else if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        "avx2+fma"
    } else if cfg!(target_feature = "avx2") {
        "avx2"
    } else if cfg!(target_feature = "sse2") {
        "sse2"
    } else if cfg!(target_feature = "neon") {
        "neon"
    } else {
        "none"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let ms = StepMilliseconds::of((1..=100).rev().map(|n| f64::from(n) * 1e-3).collect());
        assert!((ms.median - 50.0).abs() < 1e-9 && (ms.p95 - 95.0).abs() < 1e-9 && (ms.total - 5050.0).abs() < 1e-9);
        let one = StepMilliseconds::of(vec![0.002]);
        assert!((one.median - 2.0).abs() < 1e-9 && one.median == one.p95);
    }
}
