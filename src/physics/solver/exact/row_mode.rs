//! What rows whose λ is bounded do at a time.
//!
//! A *limit* pushes only, with any force: C σ ≥ 0 and λ σ ≥ 0, one of them zero, where σ is the side that it is on. Any
//! other row with bounds (friction, a motor with a largest force) is *boxed*: it brings its speed s = Ċ + C/τ to zero as
//! far as λ may; above, λ is at its lower bound, below, at its upper one. Rows of friction and of a speed have C = 0, so
//! that s is their Ċ; what is to be in a place, and lags behind while its force does not do, comes back to it with the
//! time constant τ.

use super::constants::RETURN_TIME;
use crate::physics::joint::{Bound, JointRow};

/// The law of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RowLaw {
    /// Rigid, or a spring.
    Unbounded,
    /// A limit that is on that side, 1 or −1.
    Limit(f64),
    /// λ is within these.
    Boxed(f64, f64),
}

/// What a row does at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowMode {
    /// What it says, whatever its bounds.
    Rigid,
    /// It holds as if it had no bounds.
    Held,
    /// λ is its lower bound.
    Lower,
    /// λ is its upper bound.
    Upper,
}

impl RowLaw {
    pub fn of(row: &JointRow<f64>) -> Self {
        match row.bound {
            Bound::Within(0.0, f64::INFINITY) => Self::Limit(1.0),
            Bound::Within(f64::NEG_INFINITY, 0.0) => Self::Limit(-1.0),
            Bound::Within(lower, upper) => Self::Boxed(lower, upper),
            Bound::None | Bound::Norm { .. } => Self::Unbounded,
        }
    }

    /// What λ may be, N or N·m; zero of a spring, which is no matter of rows that hold.
    pub fn forces(self, row: &JointRow<f64>) -> (f64, f64) {
        match self {
            Self::Unbounded if row.spring.is_some() => (0.0, 0.0),
            Self::Unbounded => (f64::NEG_INFINITY, f64::INFINITY),
            Self::Limit(side) if side > 0.0 => (0.0, f64::INFINITY),
            Self::Limit(_) => (f64::NEG_INFINITY, 0.0),
            Self::Boxed(lower, upper) => (lower, upper),
        }
    }

    /// What an impulse may be: a bounded force has none.
    pub fn impulses(self, row: &JointRow<f64>) -> (f64, f64) {
        let (lower, upper) = self.forces(row);
        let unbounded = |bound: f64| if bound.is_finite() { 0.0 } else { bound };
        (unbounded(lower), unbounded(upper))
    }

    /// The speed that it brings to zero, for its C and Ċ; with Ċ and C̈, the acceleration.
    pub fn speed(self, error: f64, rate: f64) -> f64 {
        match self {
            Self::Boxed(..) => rate + error / RETURN_TIME,
            Self::Unbounded | Self::Limit(_) => rate,
        }
    }

    /// The part of that speed that is of its C alone: what velocities are to gain along the row.
    pub fn bias(self, row: &JointRow<f64>) -> f64 {
        match self {
            Self::Boxed(..) => self.speed(row.error, 0.0),
            Self::Unbounded | Self::Limit(_) => 0.0,
        }
    }

    /// The mode while it is open, or of no force.
    pub fn open(self) -> RowMode {
        match self {
            Self::Unbounded => RowMode::Rigid,
            Self::Limit(side) if side > 0.0 => RowMode::Lower,
            Self::Limit(_) => RowMode::Upper,
            Self::Boxed(..) => RowMode::Held,
        }
    }
}

impl RowMode {
    /// Whether λ is one of its bounds.
    pub fn is_at_bound(self) -> bool {
        matches!(self, Self::Lower | Self::Upper)
    }

    /// Makes of a row one that holds, or one with a given λ.
    pub fn apply(self, row: &mut JointRow<f64>) {
        row.bound = match (self, RowLaw::of(row), row.bound) {
            (Self::Lower, _, Bound::Within(lower, _)) if lower.is_finite() => Bound::Within(lower, lower),
            (Self::Upper, _, Bound::Within(_, upper)) if upper.is_finite() => Bound::Within(upper, upper),
            (_, RowLaw::Boxed(..), _) => {
                row.time_rate += row.error / RETURN_TIME;
                row.velocity_term += row.rate / RETURN_TIME;
                row.rate += row.error / RETURN_TIME;
                row.error = 0.0;
                Bound::None
            }
            (_, RowLaw::Limit(_), _) => Bound::None,
            (_, RowLaw::Unbounded, bound) => bound,
        };
    }
}
