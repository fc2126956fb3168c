//! Sleeping: islands that rest drop out of the step until something disturbs them.
//!
//! **When.** A body is *calm* while |v| + |ω| R < s, the speed that no point of it exceeds (R its bounding radius, s
//! [`SolverSettings::sleep_speed`]). An island falls asleep once all its bodies have been calm for [`DELAY`] and have
//! not gained more than [`GAIN`] s of speed in that time: a pendulum at its turning point, or what is let go in a weak
//! field, is slow too, but speeds up. What nothing holds or touches, and islands that only touch each other, fall
//! or drift: they sleep only where no force acts and nothing moves at all.
//!
//! **What.** The bodies of a sleeping island stand still ([`Bodies::asleep`]). Gathering looks only at whether somebody
//! wrote to them; broad phase, narrow phase, islands, solver and write-back leave them out. Their pairs, contacts and
//! impulses stay as they are, so that an island that wakes goes on as if it had never slept. Nothing that sleeps
//! touches, or is joined to, an awake body that contacts and joints can move: both would be one island.
//!
//! **Waking.** Always whole islands, at three places of the step:
//! 1. `Prepare`: somebody wrote to a body ([`Sleep::disturb`]), or a joint came, changed or went;
//! 2. after the broad phase ([`wake_near`]): a pair came or went with something that does not fall itself (a floor was
//!    moved, added or removed), a kinematic body moves nearby or pulls at a joint, settings changed;
//! 3. `Islands` ([`wake_touched`]): something awake touches it.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::island::find_islands;
use super::{
    BitSet, Bodies, Body, ContactGraph, GONE, GatheredWith, Islands, Joints, Keep, NearPairs, PhysicsSchedule,
    PhysicsSystems, Presence, Refill, RigidBody, Sleeping, SolverSettings, StepStats, contacts_last,
};

#[cfg(test)]
mod tests;

/// How long an island must be calm to fall asleep, s.
const DELAY: f64 = 0.5;

/// Speed that a calm body may gain in [`DELAY`], as a share of the speed under which it counts as calm. With the
/// default of that, 0.02 m/s, what accelerates by more than 0.4 mm/s² never sleeps.
const GAIN: f64 = 0.01;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Sleep>()
        .keep_resource::<Sleep>()
        .add_systems(PhysicsSchedule, wake_near.after(PhysicsSystems::BroadPhase).before(PhysicsSystems::NarrowPhase))
        .add_systems(
            PhysicsSchedule,
            (wake_touched, find_islands, fall_asleep, find_islands.run_if(contacts_last), mark_sleepers)
                .chain()
                .in_set(PhysicsSystems::Islands),
        );
}

/// Who sleeps, with whom, and how long the others have been calm.
#[derive(Resource, Default, Clone)]
pub(crate) struct Sleep {
    /// The bodies of each sleeping island; none: the place is free.
    islands: Vec<Vec<u32>>,
    free: Vec<u32>,
    /// One of each per body.
    island_of: Vec<u32>,
    calm: Vec<Calm>,
    /// Islands that are to wake.
    disturbed: Vec<u32>,
    /// Bodies that woke in this step, and then those that fell asleep.
    marks: Vec<(Entity, bool)>,
    /// Whether somebody woke or fell asleep in this step.
    pub has_changed: bool,
    /// Kinematic bodies, and the bodies that joints hold to them: as of these versions of bodies and joints.
    kinematic: Vec<u32>,
    held: Vec<(u32, u32)>,
    kinematic_of: Option<(u64, u64)>,
    /// Kinematic bodies that somebody wrote to.
    pushed: Vec<u32>,
    settings: Option<SolverSettings>,
    /// Version of the contacts in which what sleeps was last looked for.
    touched_of: u64,
    /// Of the islands that are awake, by their roots: whether one of its bodies keeps it so.
    restless: Vec<bool>,
    /// The roots of those that are about to fall asleep.
    resting: Vec<u32>,
}

/// How calm a body is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Calm {
    /// Step since which it has been, and its motion then; none: not looked at yet.
    since: Option<(u64, Motion)>,
}

/// How a body moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Motion {
    /// No point of it is faster, m/s.
    speed: f64,
    /// Of the centre of mass and of a point of the rim about it, m/s.
    velocities: [Vector3<f64>; 2],
}

impl Motion {
    fn of(body: &Body) -> Self {
        let reach = if body.radius > 0.0 { body.radius } else { gyration(body) };
        // One root instead of two: (√a + √b)² = a + b + 2 √(a b).
        let (linear, angular) = (body.linear.norm_squared(), body.angular.norm_squared() * reach * reach);
        let speed = (linear + angular + 2.0 * (linear * angular).sqrt()).sqrt();
        Self { speed, velocities: [body.linear, body.angular * reach] }
    }

    /// By how much it has got faster since, m/s; where it hangs on a spring, by how much it has changed: what turns back
    /// there is as fast after as before.
    fn gained_since(&self, before: &Self, is_sprung: bool) -> f64 {
        if is_sprung {
            (0..2).map(|one| (self.velocities[one] - before.velocities[one]).norm()).sum()
        } else {
            self.speed - before.speed
        }
    }
}

impl Calm {
    /// Takes in a body's motion. Returns whether it has been calm, and gained no speed, for so many steps.
    fn observe(&mut self, motion: Motion, is_sprung: bool, limit: f64, step: u64, delay: u64) -> bool {
        let is_calm = motion.speed < limit;
        match self.since {
            Some((since, _)) if is_calm && step < since + delay => false,
            Some((_, before)) if is_calm && motion.gained_since(&before, is_sprung) <= GAIN * limit => true,
            _ => {
                self.since = Some((step, motion));
                false
            }
        }
    }
}

/// Not in a sleeping island.
const AWAKE: u32 = u32::MAX;

impl Sleep {
    /// To be called when a body, or what holds it, was changed by anything but the step: its island wakes with the
    /// next [`wake_disturbed`](Self::wake_disturbed), or stays awake.
    pub fn disturb(&mut self, body: u32, bodies: &Bodies) {
        if bodies.asleep.contains(body) {
            self.disturbed.push(self.island_of[body as usize]);
        } else if let Some(calm) = self.calm.get_mut(body as usize) {
            *calm = Calm::default();
        }
        if bodies.list[body as usize].kind == RigidBody::Kinematic {
            self.pushed.push(body);
        }
    }

    /// The body of lowest index in the island of a body that sleeps.
    pub fn root_of(&self, body: u32) -> Option<u32> {
        self.islands.get(*self.island_of.get(body as usize)? as usize)?.first().copied()
    }

    /// How much of [`DELAY`] a body that is awake has been calm for, 0 to 1, at a step of that number and length, s.
    pub fn calm_share(&self, body: u32, step: u64, h: f64) -> f64 {
        let since = self.calm.get(body as usize).and_then(|calm| calm.since);
        since.map_or(0.0, |(since, _)| (step.saturating_sub(since) as f64 * h / DELAY).min(1.0))
    }

    /// To be called for one that is marked as asleep by somebody else.
    pub fn is_no_sleeper(&mut self, entity: Entity) {
        self.marks.push((entity, false));
    }

    /// Wakes the islands that were disturbed.
    pub fn wake_disturbed(&mut self, bodies: &mut Bodies, graph: &mut ContactGraph, near: &NearPairs) {
        while let Some(island) = self.disturbed.pop() {
            let members = std::mem::take(&mut self.islands[island as usize]);
            if members.is_empty() {
                continue;
            }
            self.free.push(island);
            bodies.sleep_version += 1;
            for &body in &members {
                bodies.asleep.set(body, false);
                self.island_of[body as usize] = AWAKE;
                self.calm[body as usize] = Calm::default();
                self.marks.push((bodies.list[body as usize].entity, false));
                near.of_body(body).for_each(|(slot, _)| graph.set_active(slot, true));
            }
        }
    }

    /// Follows bodies to their new indices. What touched, or was joined to, one that is gone wakes by the end of that
    /// pair or joint.
    pub fn remap(&mut self, new_index: &[Option<u32>], bodies: &mut Bodies) {
        bodies.asleep.remap(new_index);
        let of = |body: u32| new_index.get(body as usize).copied().flatten();
        for (place, island) in (0..).zip(&mut self.islands).filter(|(_, island)| !island.is_empty()) {
            *island = island.iter().filter_map(|&body| of(body)).collect();
            if island.is_empty() {
                self.free.push(place);
            }
        }
        let mut kept = new_index.iter();
        self.island_of.retain(|_| kept.next().is_some_and(Option::is_some));
        let mut kept = new_index.iter();
        self.calm.retain(|_| kept.next().is_some_and(Option::is_some));
        self.pushed = self.pushed.iter().filter_map(|&body| of(body)).collect();
    }

    /// Wakes everything with the next [`wake_disturbed`](Self::wake_disturbed), and looks anew at who is calm.
    fn start_over(&mut self) {
        self.calm.fill(Calm::default());
        self.disturbed
            .extend((0..).zip(&self.islands).filter(|(_, island)| !island.is_empty()).map(|(place, _)| place));
    }

    /// What was near or pulled by kinematic bodies that move.
    fn disturb_by_kinematic(&mut self, bodies: &Bodies, joints: &Joints, near: &NearPairs) {
        if self.kinematic_of != Some((bodies.version, joints.version)) {
            self.kinematic_of = Some((bodies.version, joints.version));
            let is_kinematic = |body: u32| bodies.list[body as usize].kind == RigidBody::Kinematic;
            self.kinematic.refill((0..bodies.list.len() as u32).filter(|&body| is_kinematic(body)));
            self.held.clear();
            let ends = joints.list.iter().flat_map(|joint| [(joint.a, joint.b), (joint.b, joint.a)]);
            self.held.extend(ends.filter(|&(a, _)| is_kinematic(a)));
        }
        let mut pushed = std::mem::take(&mut self.pushed);
        let moves = |body: &Body| body.linear != Vector3::zeros() || body.angular != Vector3::zeros();
        pushed.extend(self.kinematic.iter().filter(|&&body| moves(&bodies.list[body as usize])));
        if !pushed.is_empty() {
            pushed.sort_unstable();
            for &body in &pushed {
                near.of_body(body).for_each(|(_, other)| self.disturb(other, bodies));
            }
            let held = std::mem::take(&mut self.held);
            for &(_, other) in held.iter().filter(|(holder, _)| pushed.binary_search(holder).is_ok()) {
                self.disturb(other, bodies);
            }
            self.held = held;
            self.pushed.clear();
            pushed.clear();
        }
        self.pushed = pushed;
    }

    /// What lost or found a neighbour that does not fall itself.
    fn disturb_by_pairs(&mut self, bodies: &Bodies, near: &NearPairs, graph: &ContactGraph) {
        // Under the indices that bodies have now, unlike those of the changes.
        let removed = near.changes.removed.iter().filter_map(|(slot, _)| graph.slots.get(slot.0 as usize));
        let removed = removed.filter(|slot| slot.touching).map(|slot| slot.pair);
        let added = near.changes.added.iter().filter_map(|&slot| near.pair(slot));
        for pair in removed.chain(added) {
            for (body, other) in [(pair.a, pair.b), (pair.b, pair.a)] {
                let sleeps = body != GONE && bodies.asleep.contains(body);
                if sleeps && (other == GONE || !bodies.is_awake_dynamic(other)) {
                    self.disturb(body, bodies);
                }
            }
        }
    }

    /// Looks at all bodies that are awake, and finds the islands of which none keeps the others awake.
    fn find_resting(&mut self, bodies: &Bodies, islands: &Islands, sprung: &BitSet, limit: f64, step: u64, delay: u64) {
        let count = bodies.list.len();
        self.calm.resize(count, Calm::default());
        self.island_of.resize(count, AWAKE);
        self.restless.resize(count, false);
        self.resting.clear();
        for index in bodies.awake() {
            let body = &bodies.list[index as usize];
            if !body.is_dynamic() {
                continue;
            }
            let root = islands.root_of(index);
            if root == index {
                // The lowest of its island: the others come after.
                self.restless[root as usize] = false;
                self.resting.push(root);
            }
            let is_sprung = sprung.contains(index);
            let rests = self.calm[index as usize].observe(Motion::of(body), is_sprung, limit, step, delay);
            self.restless[root as usize] |= !rests || !(islands.is_grounded(root) || is_left_alone(body));
        }
        self.resting.retain(|&root| !self.restless[root as usize]);
    }

    /// Puts the islands found to sleep.
    fn lay_down(&mut self, bodies: &mut Bodies, islands: &Islands, graph: &mut ContactGraph, near: &NearPairs) {
        bodies.sleep_version += 1;
        let falls_asleep =
            |&body: &u32| bodies.list[body as usize].is_dynamic() && !self.restless[islands.root_of(body) as usize];
        let fallen: Vec<u32> = bodies.awake().filter(falls_asleep).collect();
        for &index in &fallen {
            let root = islands.root_of(index);
            if root == index {
                self.island_of[root as usize] = self.free.pop().unwrap_or_else(|| {
                    self.islands.push(Vec::new());
                    self.islands.len() as u32 - 1
                });
            }
            let island = self.island_of[root as usize];
            self.island_of[index as usize] = island;
            self.islands[island as usize].push(index);
            bodies.asleep.set(index, true);
            let body = &mut bodies.list[index as usize];
            (body.linear, body.angular) = (Vector3::zeros(), Vector3::zeros());
            self.marks.push((body.entity, true));
        }
        for &body in &fallen {
            for (slot, other) in near.of_body(body) {
                if graph.is_active(slot) && !bodies.is_awake_dynamic(other) {
                    graph.set_active(slot, false);
                    graph.fell_asleep.push(slot.0);
                }
            }
        }
    }
}

fn wake_near(
    mut sleep: ResMut<Sleep>,
    mut bodies: ResMut<Bodies>,
    joints: Res<Joints>,
    near: Res<NearPairs>,
    mut graph: ResMut<ContactGraph>,
    settings: Res<SolverSettings>,
) {
    if sleep.settings != Some(*settings) {
        sleep.settings = Some(*settings);
        sleep.start_over();
    }
    if settings.method.keeps_contacts() && settings.impulse.sleep_speed.is_some() {
        sleep.disturb_by_kinematic(&bodies, &joints, &near);
        if !bodies.asleep.is_empty() {
            sleep.disturb_by_pairs(&bodies, &near, &graph);
        }
    } else {
        sleep.pushed.clear();
    }
    sleep.wake_disturbed(&mut bodies, graph.bypass_change_detection(), &near);
}

/// Wakes what awake bodies touch.
fn wake_touched(
    mut sleep: ResMut<Sleep>,
    mut bodies: ResMut<Bodies>,
    near: Res<NearPairs>,
    mut graph: ResMut<ContactGraph>,
) {
    if sleep.touched_of == graph.version || bodies.asleep.is_empty() {
        return;
    }
    sleep.touched_of = graph.version;
    for (_, (a, b)) in graph.touching() {
        for (body, other) in [(a, b), (b, a)] {
            if bodies.asleep.contains(body) && bodies.is_awake_dynamic(other) {
                sleep.disturb(body, &bodies);
            }
        }
    }
    sleep.wake_disturbed(&mut bodies, graph.bypass_change_detection(), &near);
}

/// Puts to sleep the islands that have come to rest.
fn fall_asleep(
    mut sleep: ResMut<Sleep>,
    mut bodies: ResMut<Bodies>,
    joints: Res<Joints>,
    islands: Res<Islands>,
    near: Res<NearPairs>,
    mut graph: ResMut<ContactGraph>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
) {
    let limit = settings.impulse.sleep_speed.filter(|_| settings.method.keeps_contacts());
    let Some(limit) = limit else { return };
    let delay = (DELAY * settings.hz).ceil() as u64;
    sleep.find_resting(&bodies, &islands, &joints.sprung, limit, stats.steps, delay);
    if !sleep.resting.is_empty() {
        sleep.lay_down(&mut bodies, &islands, graph.bypass_change_detection(), &near);
    }
}

/// Puts the component on those that fell asleep and takes it from those that woke, at the end of the step.
fn mark_sleepers(mut sleep: ResMut<Sleep>, bodies: Res<Bodies>, mut stats: ResMut<StepStats>, mut commands: Commands) {
    stats.sleeping = bodies.asleep.len();
    sleep.has_changed = !sleep.marks.is_empty();
    if sleep.marks.is_empty() {
        return;
    }
    let marks = std::mem::take(&mut sleep.marks);
    commands.queue(move |world: &mut World| {
        for (entity, sleeps) in marks {
            let Ok(mut body) = world.get_entity_mut(entity) else { continue };
            if sleeps {
                body.insert(Sleeping)
            } else {
                body.remove::<Sleeping>()
            };
            // No reason to gather the body: nobody else did it.
            let gathered_with = body.get_mut::<GatheredWith>();
            if let Some(mut gathered_with) = gathered_with.filter(|with| **with != GatheredWith::NOTHING) {
                gathered_with.0 = Presence(gathered_with.0).with_sleeping(sleeps).0;
            }
        }
    });
}

/// The greatest radius of gyration, m: stands for the size of a body without a shape.
fn gyration(body: &Body) -> f64 {
    let least = body.inverse_inertia_body.min();
    if least > 0.0 { (1.0 / (least * body.mass)).sqrt() } else { 0.0 }
}

/// Whether nothing moves a body, or will.
fn is_left_alone(body: &Body) -> bool {
    [body.linear, body.angular, body.force, body.torque].iter().all(|vector| *vector == Vector3::zeros())
}
