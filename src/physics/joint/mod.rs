//! Joints: entities of their own that hold two bodies together. One file a kind.

mod ball;
mod load;
mod packed;
mod pairs;
mod slot;

pub use ball::{BallJoint, Softness};
pub use load::JointLoad;
pub(crate) use packed::{Joint, Joints};
pub(crate) use pairs::JoinedPairs;
pub(crate) use slot::JointSlot;
