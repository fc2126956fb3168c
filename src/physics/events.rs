//! `Events`: what began and ended to touch, and collisions for those who asked.

use bevy::prelude::*;

use super::bodies::Bodies;
use super::body::ObserveContacts;
use super::collision::{ContactGraph, Contacts, Manifold};
use super::messages::{Collision, ContactEnded, ContactStarted};
use super::settings::SolverSettings;
use super::{PhysicsSchedule, PhysicsSystems};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Touching>()
        .add_systems(
            PhysicsSchedule,
            // Before the solve, while velocities are those at which the contacts were found.
            report_collisions.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands),
        )
        .add_systems(
            PhysicsSchedule,
            (report_changes.run_if(not(contacts_last)), report_presses.run_if(contacts_last))
                .in_set(PhysicsSystems::Events),
        );
}

/// The pairs that touched in the last step, sorted, the lower entity first.
#[derive(Resource, Default)]
struct Touching {
    pairs: Vec<(Entity, Entity)>,
    present: Vec<(Entity, Entity)>,
}

fn contacts_last(settings: Res<SolverSettings>) -> bool {
    settings.method.keeps_contacts()
}

/// Contacts that last touch when they push.
fn report_presses(
    mut graph: ResMut<ContactGraph>,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    observers: Query<(), With<ObserveContacts>>,
    mut commands: Commands,
) {
    let mut end = |a, b, commands: &mut Commands| {
        ended.write(ContactEnded { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if observers.contains(a) {
                commands.trigger(ContactEnded { a, b });
            }
        }
    };
    let ordered = |(a, b): (Entity, Entity)| (a.min(b), a.max(b));
    let graph = graph.bypass_change_detection();
    for (a, b) in graph.parted.drain(..).map(ordered) {
        end(a, b, &mut commands);
    }
    if !std::mem::take(&mut graph.presses_changed) {
        return;
    }
    for (slot, state) in graph.slots.iter_mut().zip(&graph.states) {
        let pushes = slot.touching && state.pushes();
        if pushes == slot.is_pressed {
            continue;
        }
        slot.is_pressed = pushes;
        let (a, b) = ordered(slot.entities);
        if !pushes {
            end(a, b, &mut commands);
            continue;
        }
        started.write(ContactStarted { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if observers.contains(a) {
                commands.trigger(ContactStarted { a, b });
            }
        }
    }
}

fn report_changes(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    mut touching: ResMut<Touching>,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    observers: Query<(), With<ObserveContacts>>,
    mut commands: Commands,
) {
    let Touching { pairs, present } = &mut *touching;
    present.clear();
    let touching = |manifold: &&Manifold| contacts.points_of(manifold).iter().any(|point| point.depth >= 0.0);
    present.extend(contacts.manifolds.iter().filter(touching).map(|manifold| {
        let a = bodies.list[manifold.pair.a as usize].entity;
        let b = bodies.list[manifold.pair.b as usize].entity;
        (a.min(b), a.max(b))
    }));
    present.sort_unstable();
    for &(a, b) in present.iter().filter(|pair| pairs.binary_search(pair).is_err()) {
        started.write(ContactStarted { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if observers.contains(a) {
                commands.trigger(ContactStarted { a, b });
            }
        }
    }
    for &(a, b) in pairs.iter().filter(|pair| present.binary_search(pair).is_err()) {
        ended.write(ContactEnded { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if observers.contains(a) {
                commands.trigger(ContactEnded { a, b });
            }
        }
    }
    std::mem::swap(pairs, present);
}

fn report_collisions(bodies: Res<Bodies>, contacts: Res<Contacts>, mut collisions: MessageWriter<Collision>) {
    for manifold in &contacts.manifolds {
        let a = &bodies.list[manifold.pair.a as usize];
        let b = &bodies.list[manifold.pair.b as usize];
        if !a.reports && !b.reports {
            continue;
        }
        for point in contacts.points_of(manifold).iter().filter(|point| point.depth >= 0.0) {
            collisions.write(Collision {
                a: a.entity,
                b: b.entity,
                point: point.point.into(),
                normal: manifold.normal.into(),
                depth: point.depth,
                relative_velocity: (b.point_velocity(&(point.point - b.position))
                    - a.point_velocity(&(point.point - a.position)))
                .into(),
                time: contacts.time,
            });
        }
    }
}
