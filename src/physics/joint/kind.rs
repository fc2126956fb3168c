//! What makes a component a joint.

use bevy::ecs::component::Mutable;
use bevy::ecs::query::ArchetypeFilter;
use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;

use super::axes::JointAxes;
use super::constraint::{Constraint, RowFunction};
use super::definition::JointDefinition;
use crate::physics::body::Rotation;

/// A component that is a joint: a builder of the definition beside it on its entity.
pub(crate) trait JointKind: Component<Mutability = Mutable> + Clone {
    /// What it holds.
    fn definition(&self) -> JointDefinition;

    /// Its axes, if they may have to be made frames of.
    fn axes_mut(&mut self) -> Option<&mut JointAxes> {
        None
    }
}

impl<T: Constraint> JointKind for T {
    fn definition(&self) -> JointDefinition {
        let function = Some(RowFunction::new(self));
        JointDefinition { bodies: self.bodies(), function, collide: self.collide(), ..default() }
    }
}

/// Whether joints of a kind are new or changed.
pub(crate) fn kind_changed<J: JointKind>(kinds: Query<Ref<J>>, ticks: SystemChangeTick) -> bool {
    any_changed(&kinds, &ticks)
}

/// Defines the joints of a kind that are new or changed; axes become frames from the poses at hand.
pub(crate) fn define_joints<J: JointKind>(
    mut joints: Query<(&mut J, &mut JointDefinition)>,
    rotations: Query<&Rotation>,
) {
    for (mut joint, mut definition) in joints.iter_mut().filter(|(joint, _)| joint.is_changed()) {
        let bodies = joint.definition().bodies;
        if let [Ok(a), Ok(b)] = bodies.map(|body| rotations.get(body))
            && let Some(axes) = joint.bypass_change_detection().axes_mut()
            && axes.is_valid()
        {
            let [a, b] = axes.frames([a.0, b.0]);
            *axes = JointAxes::Frames(a, b);
        }
        *definition = joint.definition();
    }
}

/// Whether one of the components is new or changed.
pub(crate) fn any_changed<C: Component, F: ArchetypeFilter>(all: &Query<Ref<C>, F>, ticks: &SystemChangeTick) -> bool {
    let (last_run, this_run) = (ticks.last_run(), ticks.this_run());
    // A user's own need not be stored in tables.
    let Ok(mut columns) = all.contiguous_iter() else { return true };
    columns.any(|column| {
        // Without a branch, for the vectorizer.
        let changed = column.changed_ticks_slice().iter();
        changed.fold(false, |any, tick| any | tick.is_newer_than(last_run, this_run))
    })
}
