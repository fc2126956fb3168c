//! Contacts on their way from collision to the solvers: the laws of surfaces, rows, where friction acts, and what is carried from one step
//! to the next.

mod footing;
mod laws;
mod rows;
mod warm_start;

pub(crate) use footing::shares;
pub(crate) use laws::{may_bounce, rebound, restitution_threshold, surface};
pub(crate) use rows::{PointConstraint, penetration_bias, tangents};
pub(crate) use warm_start::{KEPT_SHARE, namesake, predecessors};
