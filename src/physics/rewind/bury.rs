//! Taking an entity out of the world such that it can come back.

use bevy::prelude::*;

use super::kinds::Removals;

/// Takes a body or a joint out of the world: it is despawned, or emptied where a [`History`](super::History) may bring it
/// back. Whether it was there.
pub fn bury(world: &mut World, entity: Entity) -> bool {
    let is_kept = world.get_resource::<Removals>().is_some_and(|removals| removals.is_read);
    if is_kept { empty(world, entity) } else { world.despawn(entity) }
}

/// Whether an entity is there with nothing on it, as [`bury`] leaves it.
pub fn is_empty(world: &World, entity: Entity) -> bool {
    world.get_entity(entity).is_ok_and(|entity| entity.archetype().components().is_empty())
}

/// Takes all off an entity, and remembers what it looked like. Whether there was something.
pub(super) fn empty(world: &mut World, entity: Entity) -> bool {
    if world.get_entity(entity).is_err() || is_empty(world, entity) {
        return false;
    }
    let mut removals = world.resource_mut::<Removals>();
    removals.buried.insert(entity);
    removals.is_emptying = true;
    world.entity_mut(entity).clear();
    world.resource_mut::<Removals>().is_emptying = false;
    true
}
