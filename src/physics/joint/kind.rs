//! What makes a component a joint.

use bevy::ecs::component::Mutable;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::system::SystemChangeTick;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use super::definition::JointDefinition;

/// A component that is a joint: a builder of a definition, which it requires, and which [`forget`] takes away with it.
pub(crate) trait JointKind: Component<Mutability = Mutable> {
    /// What it holds.
    fn definition(&self) -> JointDefinition;
}

/// Takes the definition away from what is no joint any more.
pub(super) fn forget(mut world: DeferredWorld, context: HookContext) {
    world.commands().entity(context.entity).try_remove::<JointDefinition>();
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
    all.contiguous_iter().expect("joints are stored in tables").any(|column| {
        // Without a branch, for the vectorizer.
        let changed = column.changed_ticks_slice().iter();
        changed.fold(false, |any, tick| any | tick.is_newer_than(last_run, this_run))
    })
}
