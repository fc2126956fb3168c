//! Whether a run held: the borders that failure maps draw.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::metrics::{Metrics, TruthMetrics};

/// A run fails where the scene's own condition breaks ([`TruthMetrics::fails_above`]), a joint parts
/// by over this share of its limb, …
const JOINT_SHARE: f64 = 0.1;

/// … energy rises by over this share of its scale, …
const ENERGY_SHARE: f64 = 0.05;

/// … a body sinks by over this share of its size, or moves that far where it should stay.
const SINK_SHARE: f64 = 0.1;

/// A run degrades from this share of what makes it fail.
const DEGRADES_FROM: f64 = 0.1;

/// How a run went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every measure is under a tenth of what fails a run.
    Holds,
    /// None fails it, one is over a tenth of that.
    Degrades,
    /// A state is not finite, a joint parts, energy rises, a body sinks or leaves its place, or the
    /// scene's own condition breaks.
    Fails,
    /// It was given up before its end.
    Unknown,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::Holds => "holds",
            Self::Degrades => "degrades",
            Self::Fails => "fails",
            Self::Unknown => "not finished",
        })
    }
}

/// A verdict and, unless the run holds, the measure that decided it.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// What decided, in a few words.
    pub reason: String,
}

/// Judges a run by its worst measure.
pub fn judge(metrics: &Metrics) -> Judgement {
    if let Some(body) = metrics.quarantined.first() {
        let reason = format!("{} was set aside: {}", body.body, body.reason);
        return Judgement { verdict: Verdict::Fails, reason };
    }
    let shares = &metrics.shares;
    let percent = |share: f64, of: &str| format!("{:.2} % of {of}", 100.0 * share);
    let measures = [
        (Some(shares.joint_of_limb), JOINT_SHARE, "a joint parts by", "its limb"),
        (shares.energy_rise, ENERGY_SHARE, "energy rises by", "its scale"),
        (Some(shares.sunk_of_size), SINK_SHARE, "a body sinks by", "its size"),
        (shares.moved_of_size, SINK_SHARE, "a body that should stay moves by", "its size"),
    ];
    let measures = measures
        .into_iter()
        .filter_map(|(share, limit, what, of)| Some((share? / limit, format!("{what} {}", percent(share?, of)))));
    let truths = metrics.truth.iter().chain(&metrics.further_truths);
    let conditions = truths.filter_map(|truth| {
        let TruthMetrics { name, error, unit, fails_above, .. } = truth;
        Some((error / (*fails_above)?, format!("{name}: off by {error:.2e} {unit}")))
    });
    let worst = measures.chain(conditions).max_by(|(one, _), (other, _)| one.total_cmp(other));
    match worst {
        Some((ratio, reason)) if ratio > 1.0 || ratio.is_nan() => Judgement { verdict: Verdict::Fails, reason },
        Some((ratio, reason)) if ratio > DEGRADES_FROM => Judgement { verdict: Verdict::Degrades, reason },
        _ => Judgement { verdict: Verdict::Holds, reason: String::new() },
    }
}
