//! The tuning constants of trees of joints, each with its unit, its reason, and what notices a change: a test beside
//! this file, or a number that a scene gives.

/// A pivot under this part of the diagonal it was left from has lost all its digits: its row is
/// redundant. Rounding leaves some 1e-16 per joint; a mass ratio of r leaves 1/r (`tests::singular`).
pub(super) const LEAST_PIVOT: f64 = 1e-12;

/// How many lengths of a step of the projection are tried, each half the one before (`tests::position`).
pub(super) const STEP_LENGTHS: usize = 6;

/// β. Stability asks for over ¼ (`tests::velocity`).
pub(super) const ADDED_INERTIA: f64 = 0.5;

/// δ where ω²h² is of order 1: keeps `chain 1000` at 1/240 s without a gain of energy, for a loss of
/// 2 % in 10 s.
pub(super) const DAMPING: f64 = 0.2;

/// δ for ω²h² over [`STRONG`]: with less, `chain 1000000` parts (ω²h² = 6000); with this it loses 4 %
/// in 10 s.
pub(super) const STRONG_DAMPING: f64 = 0.6;
pub(super) const STRONG: f64 = 100.0;

/// ω²h² over which arms must be those of the pose to the last digit: a turn of δθ between them and
/// the pose acts like a kick of ω²h δθ. Arms are then to be set after projection, too, and inertias
/// and factors where that turn is not small (`chain 1000`).
pub(crate) const UNRESOLVED: f64 = 1.0;

/// ω²h² under which the step resolves the oscillation: both terms would be under 1e-4 of the inertia.
pub(super) const RESOLVED: f64 = 0.05;
