//! The state of a world between two steps.

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

use super::bury::empty;
use super::kinds::{AnyValue, Column, Kinds, LastStep, Removals, Ticks};
use crate::physics::body::{Bodies, BodySlot};
use crate::physics::collision::{ContactGraph, Contacts};
use crate::physics::joint::Joints;

/// What a body, a slot of a pair, a contact point that is found anew in each step, and a joint take in the resources, bytes,
/// on average: counted, within a factor of two (`rewind`).
const BODY_BYTES: usize = 1500;
const SLOT_BYTES: usize = 900;
const POINT_BYTES: usize = 700;
const JOINT_BYTES: usize = 4000;

/// A copy of all that the next step depends on.
pub(super) struct Keyframe {
    /// Steps made before.
    pub step: u64,
    /// One for each kind.
    columns: Vec<Box<dyn Column>>,
    resources: Vec<Option<AnyValue>>,
    /// About what the resources take, bytes.
    hidden: usize,
    /// The entities that have any of these components, ascending.
    entities: Vec<Entity>,
}

impl Keyframe {
    /// Of a world that has made so many steps.
    pub fn of(world: &mut World, kinds: &mut Kinds, step: u64) -> Self {
        let last = LastStep::of(world);
        let columns: Vec<_> = kinds.components.iter_mut().map(|kind| kind.copy(world, &last)).collect();
        let mut entities: Vec<Entity> = columns.iter().flat_map(|column| column.entities()).collect();
        entities.sort_unstable();
        entities.dedup();
        let resources = kinds.resources.iter().map(|kind| (kind.copy)(world)).collect();
        let hidden = hidden_bytes(world);
        Self { step, columns, resources, hidden, entities }
    }

    /// An entity that is gone for good, if there is one: the world cannot be brought back then.
    pub fn missing(&self, world: &World) -> Option<Entity> {
        self.entities.iter().copied().find(|&entity| world.get_entity(entity).is_err())
    }

    /// Has the world be as it was. Entities that were not there are emptied.
    pub fn bring_back(&self, world: &mut World, kinds: &mut Kinds) {
        for (kind, column) in kinds.components.iter_mut().zip(&self.columns) {
            let had_one = column.entities();
            for holder in kind.holders(world) {
                if self.entities.binary_search(&holder).is_err() {
                    empty(world, holder);
                } else if had_one.binary_search(&holder).is_err()
                    && let Ok(mut entity) = world.get_entity_mut(holder)
                {
                    kind.remove(&mut entity);
                }
            }
        }
        self.columns.iter().for_each(|column| column.put_on(world));
        Removals::dress(world, kinds);
        let written_back = world.increment_change_tick();
        let new = world.change_tick();
        // So old that it is news to nobody, however long ago a system ran.
        let known = Tick::new(new.get().wrapping_sub(Tick::MAX.get()));
        let ticks = Ticks { known, written_back, new };
        self.columns.iter().for_each(|column| column.set(world, &ticks));
        for (kind, value) in kinds.resources.iter().zip(&self.resources) {
            if let Some(value) = value {
                (kind.put_back)(world, value, known);
            }
        }
        let mut bodies = world.resource_mut::<Bodies>();
        let bodies = bodies.bypass_change_detection();
        bodies.written_back = bodies.written_back.and(Some(written_back));
        bodies.ended = bodies.ended.and(Some(new));
        // Who draws looks at what is new. Their bits are those that Plumb wrote last: nobody takes them for a user's.
        let mut transforms = world.query_filtered::<&mut Transform, With<BodySlot>>();
        transforms.iter_mut(world).for_each(|mut transform| transform.set_changed());
    }

    /// About what it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.columns.iter().map(|column| column.bytes()).sum::<usize>() + self.hidden
    }
}

fn hidden_bytes(world: &World) -> usize {
    let bodies = world.resource::<Bodies>().list.len();
    let (slots, joints) = (world.resource::<ContactGraph>().slots.len(), world.resource::<Joints>().list.len());
    let points = world.resource::<Contacts>().points.len();
    BODY_BYTES * bodies + SLOT_BYTES * slots + POINT_BYTES * points + JOINT_BYTES * joints
}
