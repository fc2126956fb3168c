//! What makes a component a joint.

use bevy::ecs::component::Mutable;
use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;

use super::constraint::{Constraint, RowFunction};
use super::definition::JointDefinition;

/// A component that is a joint: a builder of the definition beside it on its entity.
pub(crate) trait JointKind: Component<Mutability = Mutable> {
    /// What it holds.
    fn definition(&self) -> JointDefinition;
}

impl<T: Constraint> JointKind for T {
    fn definition(&self) -> JointDefinition {
        let function = Some(RowFunction::new(self));
        JointDefinition { bodies: self.bodies(), function, collide: self.collide(), ..default() }
    }
}

/// Defines the joints of a kind that are new or changed.
pub(crate) fn define_joints<J: JointKind>(
    mut joints: Query<(Ref<J>, &mut JointDefinition)>,
    kinds: Query<Ref<J>>,
    ticks: SystemChangeTick,
) {
    if any_changed(&kinds, &ticks) {
        joints.iter_mut().filter(|(joint, _)| joint.is_changed()).for_each(|(joint, mut definition)| {
            *definition = joint.definition();
        });
    }
}

/// Whether one of the components is new or changed.
pub(crate) fn any_changed<C: Component>(all: &Query<Ref<C>>, ticks: &SystemChangeTick) -> bool {
    let (last_run, this_run) = (ticks.last_run(), ticks.this_run());
    // A user's own need not be stored in tables.
    let Ok(mut columns) = all.contiguous_iter() else { return true };
    columns.any(|column| {
        // Without a branch, for the vectorizer.
        let changed = column.changed_ticks_slice().iter();
        changed.fold(false, |any, tick| any | tick.is_newer_than(last_run, this_run))
    })
}
