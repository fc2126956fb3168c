//! Joints: entities of their own that hold two bodies together. One file a kind, each a builder of a
//! [definition](definition), from which all that solvers need is made.

mod ball;
mod constraint;
mod definition;
mod kind;
mod load;
mod packed;
mod pairs;
mod rows;
mod slot;
mod softness;
#[cfg(test)]
mod tests;

pub use ball::BallJoint;
pub use constraint::{BodyState, Constraint, ConstraintRow, ConstraintRows};
pub(crate) use definition::JointDefinition;
#[cfg(test)]
pub(crate) use definition::{Frame, Hold, Laws};
pub(crate) use kind::{JointKind, any_changed, define_joints};
pub use load::JointLoad;
pub(crate) use packed::{Joint, Joints};
pub(crate) use pairs::JoinedPairs;
#[cfg(test)]
pub(crate) use rows::point_jacobian;
pub(crate) use rows::{Bound, JointRow};
pub(crate) use slot::JointSlot;
pub use softness::Softness;
