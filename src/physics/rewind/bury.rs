//! Taking an entity out of the world such that it can come back.

use bevy::prelude::*;

use super::kinds::Removals;

/// Takes a body or a joint out of the world: it is despawned, or emptied where a [`History`](super::History) may bring it
/// back. Whether it was there.
pub fn bury(world: &mut World, entity: Entity) -> bool {
    let is_kept = world.get_resource::<Removals>().is_some_and(|removals| removals.is_read);
    let Ok(mut body) = world.get_entity_mut(entity) else { return false };
    if is_kept {
        let was_there = !body.archetype().components().is_empty();
        body.clear();
        world.resource_mut::<Removals>().buried.push(entity);
        was_there
    } else {
        body.despawn();
        true
    }
}
