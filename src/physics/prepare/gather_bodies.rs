//! Bodies enter and leave the packed array; those that others wrote to are gathered.

use bevy::ecs::system::SystemChangeTick;
use bevy::math::DVec3;
use bevy::prelude::*;

use super::gather_body::{freeze, gather_body, teleport};
use super::table::{BodyQuery, BodyTable, Watch};
use crate::physics::body::{Bodies, Body, BodySlot, QuarantineReason, RenderOrigin, RigidBody, Sleeping};
use crate::physics::collision::{ContactGraph, LaggedContacts, NearPairs};
use crate::physics::joint::Joints;
use crate::physics::messages::{BodyQuarantined, set_aside};
use crate::physics::settings::{Gravity, SolverSettings};
use crate::physics::sleep::Sleep;
use crate::physics::stats::StepStats;

/// Why contiguous iteration cannot fail: all components of a body are stored in tables.
const IN_TABLES: &str = "a disabling component stored as a sparse set hides bodies from physics: store it in tables";

/// What is kept from step to step.
#[derive(Default)]
pub(super) struct Gathering {
    /// Bodies without a place in the list.
    new: Vec<(u64, Entity)>,
    /// Rows of the table at hand that others wrote to.
    stale: Vec<bool>,
    /// Gravity and drag that went into all forces and drags.
    summed: Option<(DVec3, f64)>,
}

/// What a jump of a body's pose, or its end, makes worthless.
struct Known<'a> {
    lagged: &'a mut LaggedContacts,
    near: &'a mut NearPairs,
    graph: &'a mut ContactGraph,
    joints: &'a mut Joints,
    sleep: &'a mut Sleep,
}

pub(super) fn gather_bodies(
    mut query: Query<BodyQuery>,
    mut bodies: ResMut<Bodies>,
    mut lagged: ResMut<LaggedContacts>,
    (mut near, mut graph): (ResMut<NearPairs>, ResMut<ContactGraph>),
    (mut joints, mut sleep): (ResMut<Joints>, ResMut<Sleep>),
    gravity: Res<Gravity>,
    settings: Res<SolverSettings>,
    origin: Res<RenderOrigin>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
    mut gathering: Local<Gathering>,
    ticks: SystemChangeTick,
) {
    let Gathering { new, stale, summed } = &mut *gathering;
    let bodies = &mut *bodies;
    bodies.renewed.clear();
    if !is_list_complete(&query, bodies, new) {
        let mut known =
            Known { lagged: &mut lagged, near: &mut near, graph: &mut graph, joints: &mut joints, sleep: &mut sleep };
        update_list(&mut query, bodies, new, &mut known, &mut commands);
    }
    stats.bodies = bodies.list.len() as u32;
    stats.quarantined = 0;
    let last_run = ticks.last_run();
    let written_back = bodies.written_back.unwrap_or(last_run);
    let watch = Watch { last_run, this_run: ticks.this_run(), written_back };
    let terms = Some((gravity.0, settings.drag));
    let all = *summed != terms;
    *summed = terms;
    for mut table in query.contiguous_iter_mut().expect(IN_TABLES) {
        if all {
            stale.clear();
            stale.resize(table.entity.len(), true);
        } else if !table.find_stale(&watch, stale) {
            continue;
        }
        for row in (0..stale.len()).filter(|&row| stale[row]) {
            let index = table.slot.as_ref()[row].index;
            if teleport(&mut table, row, origin.0) {
                lagged.drop_body(index);
                bodies.renewed.push(index);
            }
            if table.sleeping && !bodies.asleep.contains(index) {
                sleep.is_no_sleeper(table.entity[row]);
            }
            sleep.disturb(index, bodies);
            let Some(reason) = gather_row(&mut table, row, bodies, &watch, &gravity, &settings, &mut commands) else {
                continue;
            };
            stats.quarantined += 1;
            if table.quarantined.is_none() {
                set_aside(table.entity[row], reason, &mut commands, &mut quarantine);
            }
        }
    }
    // Before the broad phase, that must see what has moved.
    sleep.wake_disturbed(bodies, &mut graph, &near);
}

/// Gathers one body, or freezes it and says why.
fn gather_row(
    table: &mut BodyTable,
    row: usize,
    bodies: &mut Bodies,
    watch: &Watch,
    gravity: &Gravity,
    settings: &SolverSettings,
    commands: &mut Commands,
) -> Option<QuarantineReason> {
    let presence = table.presence();
    let slot = table.slot.as_ref()[row];
    let body = &mut bodies.list[slot.index as usize];
    debug_assert_eq!(body.entity, table.entity[row]);
    // One that does not move is looked at again by the broad phase only if somebody else moves it.
    let known = |body: &Body| {
        let place = (body.kind == RigidBody::Static).then_some((body.position, body.rotation));
        (body.kind, body.layers, body.material, body.changes, place)
    };
    let before = known(body);
    body.mass_is_stale |= presence.lost_density(slot.gathered_with);
    let components = table.components(row, watch);
    let verdict = gather_body(&components, body, gravity, settings, commands);
    let reason = components.quarantined.or(verdict.err());
    if reason.is_some() {
        freeze(table, row, body);
    }
    if body.kind == RigidBody::Static {
        // Nothing to interpolate: it is where it was put.
        table.history.bypass_change_detection()[row].previous = None;
    }
    // Looked at again in the next step, even if somebody lets it go without mending it.
    let gathered_with = if reason.is_some() { BodySlot::TO_GATHER } else { presence.0 };
    table.slot.bypass_change_detection()[row].gathered_with = gathered_with;
    bodies.version += u64::from(body.kind != before.0);
    if known(body) != before {
        bodies.renewed.push(slot.index);
    }
    reason
}

/// Whether the list holds exactly the bodies that there are. Collects those without a place.
fn is_list_complete(query: &Query<BodyQuery>, bodies: &Bodies, new: &mut Vec<(u64, Entity)>) -> bool {
    new.clear();
    let mut placed = 0;
    for table in query.contiguous_iter().expect(IN_TABLES) {
        let here = table.slot.iter().filter(|slot| slot.index != u32::MAX).count();
        placed += here;
        if here < table.slot.len() {
            let rows = table.slot.iter().zip(table.entity).filter(|(slot, _)| slot.index == u32::MAX);
            new.extend(rows.map(|(slot, &entity)| (slot.born, entity)));
        }
    }
    // A body that leaves loses its place, so that nobody has another's.
    new.is_empty() && placed == bodies.list.len()
}

/// Drops bodies that are gone and appends new ones in the order in which they became bodies.
fn update_list(
    query: &mut Query<BodyQuery>,
    bodies: &mut Bodies,
    new: &mut [(u64, Entity)],
    known: &mut Known,
    commands: &mut Commands,
) {
    bodies.version += 1;
    let seen: Vec<bool> = (0..)
        .zip(&bodies.list)
        .map(|(index, body)| query.get(body.entity).is_ok_and(|item| item.slot.index == index))
        .collect();
    if seen.contains(&false) {
        drop_gone_bodies(&seen, bodies, known, query, commands);
    }
    new.sort_unstable();
    for &(_, entity) in new.iter() {
        if let Ok(mut body) = query.get_mut(entity) {
            *body.slot = BodySlot { index: bodies.list.len() as u32, gathered_with: BodySlot::TO_GATHER, ..*body.slot };
            bodies.renewed.push(bodies.list.len() as u32);
            bodies.list.push(Body::new(entity));
        }
    }
}

/// Packs the living bodies again, in their order.
fn drop_gone_bodies(
    seen: &[bool],
    bodies: &mut Bodies,
    known: &mut Known,
    query: &mut Query<BodyQuery>,
    commands: &mut Commands,
) {
    let mut next = 0;
    let new_index: Vec<Option<u32>> = seen
        .iter()
        .map(|&alive| {
            alive.then(|| {
                next += 1;
                next - 1
            })
        })
        .collect();
    known.lagged.remap(&new_index);
    known.near.remap(&new_index);
    known.graph.remap(&new_index);
    known.joints.remap(&new_index);
    known.sleep.remap(&new_index, bodies);
    for (body, _) in bodies.list.iter().zip(seen).filter(|(_, seen)| !**seen) {
        if !query.contains(body.entity) {
            forget_place(body.entity, commands);
        }
    }
    let mut alive = seen.iter();
    bodies.list.retain(|_| *alive.next().expect("one flag a body"));
    for (index, body) in bodies.list.iter().enumerate() {
        if let Ok(mut item) = query.get_mut(body.entity) {
            item.slot.index = index as u32;
        }
    }
}

/// One that is a body no more, or is disabled, may come back, and then as a new one.
fn forget_place(entity: Entity, commands: &mut Commands) {
    commands.entity(entity).queue_silenced(|mut entity: EntityWorldMut| {
        if let Some(mut slot) = entity.get_mut::<BodySlot>() {
            slot.index = u32::MAX;
        }
        entity.remove::<Sleeping>();
    });
}
