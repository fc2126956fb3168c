//! Contacts on their way from collision to the solvers: the laws of surfaces, rows, and what is carried from one step
//! to the next.

mod laws;
mod rows;
mod warm_start;

pub(crate) use laws::{may_bounce, rebound, restitution_threshold, surface};
pub(crate) use rows::{PointConstraint, penetration_bias, tangents};
pub(crate) use warm_start::{KEPT_SHARE, namesake, predecessors};
