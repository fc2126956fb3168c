//! Joints: entities of their own that hold two bodies together. One file a kind.

mod ball;
mod pairs;

pub use ball::{BallJoint, Softness};
pub(crate) use pairs::JoinedPairs;

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::math::DVec3;
use bevy::prelude::*;

use super::body::BirthCounter;

/// What a joint carried in the last step, measured from its multipliers λ. Add it to a joint
/// entity to have it filled in.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct JointLoad {
    /// Force on body B at the joint, N, world axes.
    pub force: DVec3,
    /// Torque on body B about the joint, N·m, world axes (zero for a ball joint).
    pub torque: DVec3,
    /// Euclidean norm |λ| of the joint's multipliers, N.
    pub lambda: f64,
}

/// Where the joint stands in the solver's packed array.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct JointSlot {
    /// Index; `u32::MAX` while it is not there.
    pub index: u32,
    /// When it was made: joints are packed in this order.
    pub born: u64,
}

impl Default for JointSlot {
    fn default() -> Self {
        Self { index: u32::MAX, born: 0 }
    }
}

fn number_joint(mut world: DeferredWorld, context: HookContext) {
    let born = world.get_resource_mut::<BirthCounter>().map_or(0, |mut counter| counter.next());
    if let Some(mut slot) = world.get_mut::<JointSlot>(context.entity) {
        *slot = JointSlot { born, ..default() };
    }
}
