//! Joints: entities of their own that hold two bodies together. One file a kind, each a builder of a
//! [definition](definition), from which all that solvers need is made.

mod attached;
mod attachments;
mod axes;
mod ball;
mod breakable;
mod constraint;
mod definition;
mod distance;
mod framed;
mod kind;
mod law;
mod load;
mod motion;
mod packed;
mod pairs;
mod rows;
mod slot;
mod softness;
#[cfg(test)]
mod tests;

pub(crate) use attached::Attached;
pub use attachments::{JointCoordinate, JointFriction, JointLimits, JointMotor, LimitRange, MotorTarget};
pub use axes::JointAxes;
pub use ball::BallJoint;
pub use breakable::{Breakable, BrokenJoint};
pub use constraint::{BodyState, Constraint, ConstraintRow, ConstraintRows};
#[cfg(test)]
pub(crate) use definition::{Frame, Laws};
pub(crate) use definition::{Hold, JointDefinition, JointHolds};
pub use distance::{DistanceJoint, DistanceLaw};
pub use framed::{FixedJoint, GenericJoint, HingeJoint, SliderJoint};
pub(crate) use kind::{JointKind, any_changed, define_joints, kind_changed};
pub use law::JointAxis;
pub(crate) use law::{CoordinateLaw, LawAxis, LawPart};
pub use load::JointLoad;
pub use motion::PrescribedMotion;
pub(crate) use packed::{Joint, Joints};
pub(crate) use pairs::JoinedPairs;
#[cfg(test)]
pub(crate) use rows::point_jacobian;
pub(crate) use rows::{Bound, JointRow, nearest_turn};
pub(crate) use slot::JointSlot;
pub use softness::Softness;
pub(crate) use softness::SpringConstants;
