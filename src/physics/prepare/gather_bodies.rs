//! Bodies enter and leave the packed array; those that others wrote to are gathered.

use bevy::ecs::system::{SystemChangeTick, SystemParam};
use bevy::prelude::*;

use super::gather_body::{Terms, freeze, gather_body, teleport};
use super::table::{BodyQuery, BodyTable, Watch};
use crate::physics::{
    Bodies, Body, BodyQuarantined, BodySlot, ContactGraph, GatheredWith, Gravity, Joints, LaggedContacts, NearPairs,
    QuarantineReason, Refill, RenderOrigin, RigidBody, Sleep, Sleeping, SolverSettings, StepStats, set_aside,
};

/// Why contiguous iteration cannot fail: all components of a body are stored in tables.
const IN_TABLES: &str = "a disabling component stored as a sparse set hides bodies from physics: store it in tables";

/// What is kept from step to step.
#[derive(Default)]
pub(super) struct Gathering {
    /// Bodies without a place in the list.
    new: Vec<(u64, Entity)>,
    /// Of each table: whether optional components came to some row of it, or went.
    regrouped: Vec<bool>,
    /// Rows of the table at hand that others wrote to.
    stale: Vec<bool>,
}

/// Gravity and drag that went into all forces and drags.
#[derive(Resource, Clone, Copy, Default)]
pub(super) struct Summed(Option<Terms>);

/// The bodies of the world, and what a jump of a pose, or the end of a body, makes worthless.
#[derive(SystemParam)]
pub(super) struct Known<'w, 's> {
    query: Query<'w, 's, BodyQuery>,
    commands: Commands<'w, 's>,
    lagged: ResMut<'w, LaggedContacts>,
    near: ResMut<'w, NearPairs>,
    graph: ResMut<'w, ContactGraph>,
    joints: ResMut<'w, Joints>,
    sleep: ResMut<'w, Sleep>,
}

pub(super) fn gather_bodies(
    mut bodies: ResMut<Bodies>,
    mut known: Known,
    gravity: Res<Gravity>,
    settings: Res<SolverSettings>,
    origin: Res<RenderOrigin>,
    mut stats: ResMut<StepStats>,
    mut summed: ResMut<Summed>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut gathering: Local<Gathering>,
    ticks: SystemChangeTick,
) {
    let Gathering { new, regrouped, stale } = &mut *gathering;
    let bodies = &mut *bodies;
    bodies.renewed.clear();
    if !is_list_complete(&mut known.query, bodies, regrouped) {
        update_list(&mut known, bodies, new);
        regrouped.fill(true);
    }
    stats.bodies = bodies.list.len() as u32;
    stats.quarantined = 0;
    let last_run = ticks.last_run();
    let written_back = bodies.written_back.unwrap_or(last_run);
    let watch = Watch { last_run, this_run: ticks.this_run(), written_back };
    let terms = Terms { gravity: gravity.0, drag: settings.drag };
    let all = summed.0.replace(terms) != Some(terms);
    for (mut table, &regrouped) in known.query.contiguous_iter_mut().expect(IN_TABLES).zip(&*regrouped) {
        if all {
            stale.reset(table.entity.len(), true);
        } else if !table.find_stale(&watch, regrouped, stale) {
            continue;
        }
        for row in (0..stale.len()).filter(|&row| stale[row]) {
            let index = table.slot.as_ref()[row].index;
            if teleport(&mut table, row, origin.0) {
                known.lagged.drop_body(index);
                bodies.renewed.push(index);
            }
            if table.sleeping && !bodies.asleep.contains(index) {
                known.sleep.is_no_sleeper(table.entity[row]);
            }
            known.sleep.disturb(index, bodies);
            if let Some(reason) = gather_row(&mut table, row, bodies, &watch, terms, &mut known.commands) {
                stats.quarantined += 1;
                if table.quarantined.is_none() {
                    set_aside(table.entity[row], reason, &mut known.commands, &mut quarantine);
                }
            }
        }
    }
    // Before the broad phase, that must see what has moved.
    known.sleep.wake_disturbed(bodies, &mut known.graph, &known.near);
}

/// Gathers one body, or freezes it and says why.
fn gather_row(
    table: &mut BodyTable,
    row: usize,
    bodies: &mut Bodies,
    watch: &Watch,
    terms: Terms,
    commands: &mut Commands,
) -> Option<QuarantineReason> {
    let presence = table.presence();
    let slot = table.slot.as_ref()[row];
    let body = &mut bodies.list[slot.index as usize];
    debug_assert_eq!(body.entity, table.entity[row]);
    // One that does not move is looked at again by the broad phase only if somebody else moves it.
    let known = |body: &Body| {
        let place = (body.kind == RigidBody::Static).then_some((body.position, body.rotation));
        (body.kind, body.layers, body.is_sensor, body.material, body.changes, place)
    };
    let before = known(body);
    body.mass_is_stale |= presence.lost_density(table.gathered_with.as_ref()[row]);
    let verdict = gather_body(table, row, watch, body, terms, commands);
    let reason = table.quarantined.map(|column| column[row].reason).or(verdict.err());
    if reason.is_some() {
        freeze(table, row, body);
    }
    if body.kind == RigidBody::Static {
        // Nothing to interpolate: it is where it was put.
        table.history.bypass_change_detection()[row].previous = None;
    }
    // Looked at again in the next step, even if somebody lets it go without mending it.
    let gathered_with = if reason.is_some() { GatheredWith::NOTHING } else { GatheredWith(presence.0) };
    table.gathered_with.bypass_change_detection()[row] = gathered_with;
    bodies.fixed.set(slot.index, body.kind == RigidBody::Static);
    bodies.version += u64::from(body.kind != before.0);
    if known(body) != before {
        bodies.renewed.push(slot.index);
    }
    reason
}

/// Whether the list holds exactly the bodies that there are; and of each table, whether it is `regrouped`. Of many bodies the
/// caches hold little: no slot is read of what was gathered before with the same components, which has a place.
fn is_list_complete(query: &mut Query<BodyQuery>, bodies: &Bodies, regrouped: &mut Vec<bool>) -> bool {
    regrouped.clear();
    let (mut placed, mut count) = (0, 0);
    for table in query.contiguous_iter_mut().expect(IN_TABLES) {
        let present = GatheredWith(table.presence().0);
        let slots: &[BodySlot] = table.slot.as_ref();
        // Without a branch, for the vectorizer.
        let other = table.gathered_with.as_ref().iter().fold(false, |other, with| other | (*with != present));
        count += slots.len();
        placed += if other { slots.iter().filter(|slot| slot.index != u32::MAX).count() } else { slots.len() };
        regrouped.push(other);
    }
    // A body that leaves loses its place, so that nobody has another's.
    placed == count && placed == bodies.list.len()
}

/// Drops bodies that are gone and appends new ones in the order in which they became bodies.
fn update_list(known: &mut Known, bodies: &mut Bodies, new: &mut Vec<(u64, Entity)>) {
    bodies.version += 1;
    new.clear();
    for table in known.query.contiguous_iter().expect(IN_TABLES) {
        let rows = table.slot.iter().zip(table.entity).filter(|(slot, _)| slot.index == u32::MAX);
        new.extend(rows.map(|(slot, &entity)| (slot.born, entity)));
    }
    let is_at = |body: &Body, index| known.query.get(body.entity).is_ok_and(|item| item.slot.index == index);
    let seen: Vec<bool> = (0..).zip(&bodies.list).map(|(index, body)| is_at(body, index)).collect();
    if seen.contains(&false) {
        drop_gone_bodies(&seen, bodies, known);
    }
    new.sort_unstable();
    for &(_, entity) in new.iter() {
        if let Ok(mut body) = known.query.get_mut(entity) {
            body.slot.index = bodies.list.len() as u32;
            *body.gathered_with = GatheredWith::NOTHING;
            bodies.renewed.push(bodies.list.len() as u32);
            bodies.list.push(Body::new(entity));
        }
    }
}

/// Packs the living bodies again, in their order.
fn drop_gone_bodies(seen: &[bool], bodies: &mut Bodies, known: &mut Known) {
    let mut places = 0..;
    let new_index: Vec<Option<u32>> = seen.iter().map(|&alive| if alive { places.next() } else { None }).collect();
    known.lagged.remap(&new_index);
    known.near.remap(&new_index);
    known.graph.remap(&new_index);
    known.joints.remap(&new_index);
    known.sleep.remap(&new_index, bodies);
    bodies.fixed.remap(&new_index);
    for (body, _) in bodies.list.iter().zip(seen).filter(|(_, seen)| !**seen) {
        if !known.query.contains(body.entity) {
            forget_place(body.entity, &mut known.commands);
        }
    }
    let mut alive = seen.iter();
    bodies.list.retain(|_| *alive.next().expect("one flag a body"));
    for (index, body) in bodies.list.iter().enumerate() {
        if let Ok(mut item) = known.query.get_mut(body.entity) {
            item.slot.index = index as u32;
        }
    }
}

/// One that is a body no more, or is disabled, may come back, and then as a new one.
fn forget_place(entity: Entity, commands: &mut Commands) {
    commands.entity(entity).queue_silenced(|mut entity: EntityWorldMut| {
        if let Some(mut slot) = entity.get_mut::<BodySlot>() {
            slot.index = u32::MAX;
            entity.insert(GatheredWith::NOTHING);
        }
        entity.remove::<Sleeping>();
    });
}
