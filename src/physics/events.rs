//! `Events`: what began and ended to touch, and collisions for those who asked.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::{
    Bodies, Collision, ContactEnded, ContactGraph, ContactStarted, Contacts, Keep, Manifold, ObserveContacts,
    PhysicsSchedule, PhysicsSystems, ReportCollisions, ToldPairs, contacts_last,
};

pub(super) fn plugin(app: &mut App) {
    // Before the solve, while velocities are those at which the contacts were found.
    let found = report_collisions.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands);
    let changes = (report_changes.run_if(not(contacts_last)), report_starts_and_ends.run_if(contacts_last));
    app.init_resource::<Touching>().keep_resource::<Touching>().add_systems(
        PhysicsSchedule,
        (found.run_if(any_with_component::<ReportCollisions>), changes.in_set(PhysicsSystems::Events)),
    );
}

/// The pairs that touched in the last step, the lower entity first.
#[derive(Resource, Default, Clone)]
struct Touching(ToldPairs);

/// Tells all who listen that bodies began or ceased to touch.
#[derive(SystemParam)]
struct Teller<'w, 's> {
    started: MessageWriter<'w, ContactStarted>,
    ended: MessageWriter<'w, ContactEnded>,
    observers: Query<'w, 's, (), With<ObserveContacts>>,
    commands: Commands<'w, 's>,
}

impl Teller<'_, '_> {
    fn start(&mut self, a: Entity, b: Entity) {
        self.started.write(ContactStarted { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if self.observers.contains(a) {
                self.commands.trigger(ContactStarted { a, b });
            }
        }
    }

    fn end(&mut self, a: Entity, b: Entity) {
        self.ended.write(ContactEnded { a, b });
        for (a, b) in [(a, b), (b, a)] {
            if self.observers.contains(a) {
                self.commands.trigger(ContactEnded { a, b });
            }
        }
    }
}

/// Contacts that last touch when they push; bodies with parts, when any of their pairs do.
fn report_starts_and_ends(
    mut graph: ResMut<ContactGraph>,
    mut changes_of_parts: Local<Vec<((Entity, Entity), i32)>>,
    mut teller: Teller,
) {
    let ordered = |(a, b): (Entity, Entity)| (a.min(b), a.max(b));
    let graph = graph.bypass_change_detection();
    for (entities, is_of_parts) in graph.parted.drain(..) {
        let (a, b) = ordered(entities);
        if is_of_parts { changes_of_parts.push(((a, b), -1)) } else { teller.end(a, b) }
    }
    let all = std::mem::take(&mut graph.starts_changed);
    let mut changed = std::mem::take(&mut graph.fell_asleep);
    if all {
        changed.extend(graph.touching_or_started());
    }
    for index in changed.drain(..) {
        // What does not touch has no impulse.
        let pushes = graph.states[index as usize].pushes();
        if pushes == graph.started.contains(index) {
            continue;
        }
        let slot = &graph.slots[index as usize];
        let (Some(entities), is_of_parts) = (slot.entities, slot.is_of_parts) else { continue };
        graph.started.set(index, pushes);
        let (a, b) = ordered(entities);
        if is_of_parts {
            changes_of_parts.push(((a, b), if pushes { 1 } else { -1 }));
        } else if pushes {
            teller.start(a, b);
        } else {
            teller.end(a, b);
        }
    }
    graph.fell_asleep = changed;
    changes_of_parts.sort_unstable();
    for changes in changes_of_parts.chunk_by(|one, other| one.0 == other.0) {
        let (a, b) = changes[0].0;
        let count = graph.started_parts.entry((a, b)).or_default();
        let before = *count;
        *count += changes.iter().map(|(_, change)| change).sum::<i32>();
        let now = *count;
        if now == 0 {
            graph.started_parts.remove(&(a, b));
        }
        match (before > 0, now > 0) {
            (false, true) => teller.start(a, b),
            (true, false) => teller.end(a, b),
            _ => {}
        }
    }
    changes_of_parts.clear();
}

fn report_changes(bodies: Res<Bodies>, contacts: Res<Contacts>, mut touching: ResMut<Touching>, mut teller: Teller) {
    let touches = |manifold: &&Manifold| contacts.points_of(manifold).iter().any(|point| point.depth >= 0.0);
    let present = contacts.manifolds.iter().filter(touches).map(|manifold| {
        let a = bodies.list[manifold.pair.a as usize].entity;
        let b = bodies.list[manifold.pair.b as usize].entity;
        (a.min(b), a.max(b))
    });
    touching.0.update(present, |came, (a, b)| if came { teller.start(a, b) } else { teller.end(a, b) });
}

fn report_collisions(bodies: Res<Bodies>, contacts: Res<Contacts>, mut collisions: MessageWriter<Collision>) {
    for manifold in &contacts.manifolds {
        let a = &bodies.list[manifold.pair.a as usize];
        let b = &bodies.list[manifold.pair.b as usize];
        let is_moved = [manifold.pair.a, manifold.pair.b].into_iter().any(|body| bodies.is_awake_dynamic(body));
        if (!a.reports && !b.reports) || !is_moved {
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
