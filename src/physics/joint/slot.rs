//! Where a joint stands in the packed arrays.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use crate::physics::body::BirthCounter;

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

pub(super) fn number_joint(mut world: DeferredWorld, context: HookContext) {
    let born = world.get_resource_mut::<BirthCounter>().map_or(0, |mut counter| counter.next());
    if let Some(mut slot) = world.get_mut::<JointSlot>(context.entity) {
        *slot = JointSlot { born, ..default() };
    }
}
