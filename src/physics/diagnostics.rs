//! What a step did and how true it was: counts, times, energy, momentum, errors, forces.
//!
//! [`StepStats`] is always there. [`Diagnostics`], [`ContactForces`] and [`JointForces`] are filled
//! in only while the resource exists: insert it to read it.

use std::hash::Hasher;
use std::time::{Duration, Instant};

use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::bodies::{Bodies, Joints};
use super::body::{GravityScale, Position, Rotation, Velocity};
use super::collision::{ContactGraph, Contacts};
use super::settings::{Gravity, Method, SolverSettings};
use super::solver::{ContactCache, ExactGroups, IslandSolvers, LaggedContacts};
use super::{PhysicsSchedule, PhysicsSystems};

/// Counts and times of the last step.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct StepStats {
    /// Steps since the world was made.
    pub steps: u64,
    /// Simulation time, s: steps × h.
    pub time: f64,
    /// Wall-clock time of the last step, s, without what was spent on measuring it.
    pub step_seconds: f64,
    /// Bodies, all kinds.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// Pairs that the broad phase handed to the narrow phase.
    pub pairs: u32,
    /// Axes along which the separating axis test measured how far two shapes overlap.
    pub axes_tested: u64,
    /// Pairs that touch, sleeping ones included.
    pub manifolds: u32,
    /// Contact points, sleeping ones included.
    pub contact_points: u32,
    /// Scalar rows solved, in one substep.
    pub rows: u32,
    /// Row updates: rows × iterations × solves, over all substeps.
    pub row_updates: u64,
    /// Groups of bodies that touch or are joined, sleeping ones left out.
    pub islands: u32,
    /// Bodies of islands at rest, which were solved directly or had nothing to solve.
    pub resting: u32,
    /// Parts into which the exact method cut steps that were too long for it, beyond those asked for.
    pub cuts: u32,
    /// Parts of the last step that it could not solve however short it cut them: what they held is not exact.
    pub unsettled: u32,
    /// Sliding points at which it found no rigid motion to exist (Painlevé), once for each part of the last step: an
    /// impulse stops them.
    pub jammed: u32,
    /// Bodies quarantined now.
    pub quarantined: u32,
    /// Bodies asleep now.
    pub sleeping: u32,
    /// Where `time` was when the step last changed, and the step.
    since: (u64, f64, f64),
}

impl StepStats {
    /// Steps × h, without the drift of a running sum; a change of the step starts a new product.
    pub(super) fn count_step(&mut self, settings: &SolverSettings) {
        let h = settings.step();
        if self.since.2 != h {
            self.since = (self.steps, self.time, h);
        }
        self.steps += 1;
        self.time = self.since.1 + (self.steps - self.since.0) as f64 * h;
    }
}

/// Conserved quantities and errors of the state after the last step. Filled in while present.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct Diagnostics {
    /// Σ ½mv² + ½ωᵀIω of dynamic bodies, J.
    pub kinetic_energy: f64,
    /// −Σ m g·x of dynamic bodies (with their gravity scale), J, relative to the world's origin.
    pub potential_energy: f64,
    /// Σ m v of dynamic bodies, kg·m/s.
    pub linear_momentum: DVec3,
    /// Σ x × m v + I ω of dynamic bodies about the world's origin, kg·m²/s.
    pub angular_momentum: DVec3,
    /// Largest distance between the two anchors of a rigid joint, m.
    pub joint_error: f64,
    /// Largest depth of a contact found in the last step, m.
    pub penetration: f64,
}

impl Diagnostics {
    /// Kinetic plus potential, J.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy + self.potential_energy
    }
}

/// The contact points of the last step with the forces that the solver found. Filled in while
/// present.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct ContactForces(pub Vec<ContactForce>);

/// One contact point and the force through it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// One body.
    pub a: Entity,
    /// The other.
    pub b: Entity,
    /// World position, m, where the step found it; with the exact method, where it is at the step's end.
    pub point: DVec3,
    /// Unit normal from A to B.
    pub normal: DVec3,
    /// Overlap, m.
    pub depth: f64,
    /// Force on B: normal and friction, N, world axes; mean over the step's substeps.
    pub force: DVec3,
    /// Force on B that the step's last solve found, N, world axes; none where that was not of this point.
    pub last_force: Option<DVec3>,
}

/// The joints with the forces that the last step's solves found. Filled in while present.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct JointForces(pub Vec<JointForce>);

/// One joint and the force through it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct JointForce {
    /// The joint.
    pub joint: Entity,
    /// Force on its body B, N, world axes; mean over the step's substeps.
    pub force: DVec3,
}

/// How long the last step's measuring took.
#[derive(Resource, Default)]
pub(super) struct MeasuringTime {
    started: Option<Instant>,
    pub spent: Duration,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<MeasuringTime>().add_systems(
        PhysicsSchedule,
        (
            start_clock,
            measure.run_if(resource_exists::<Diagnostics>),
            collect_contact_forces.run_if(resource_exists::<ContactForces>),
            collect_joint_forces.run_if(resource_exists::<JointForces>),
            stop_clock,
        )
            .chain()
            .in_set(Measuring),
    );
    app.configure_sets(PhysicsSchedule, Measuring.in_set(PhysicsSystems::Diagnose).run_if(somebody_reads));
}

/// All that is measured: one condition for the lot, for the many steps in which nobody reads it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Measuring;

fn somebody_reads(
    diagnostics: Option<Res<Diagnostics>>,
    contacts: Option<Res<ContactForces>>,
    joints: Option<Res<JointForces>>,
) -> bool {
    diagnostics.is_some() || contacts.is_some() || joints.is_some()
}

fn start_clock(mut time: ResMut<MeasuringTime>) {
    time.started = Some(Instant::now());
}

fn stop_clock(mut time: ResMut<MeasuringTime>) {
    time.spent = time.started.take().map_or(Duration::ZERO, |started| started.elapsed());
}

fn measure(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    contacts: Res<Contacts>,
    gravity: Res<Gravity>,
    scales: Query<&GravityScale>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let mut sum = Diagnostics::default();
    let g = Vector3::from(gravity.0);
    let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
    for body in bodies.list.iter().filter(|body| body.is_dynamic()) {
        // Body axes, where the inertia is diagonal; about a locked axis nothing turns.
        let spin = body.rotation.inverse() * body.angular;
        let inertia = body.inverse_inertia_body.map(f64::recip);
        let body_momentum = inertia.component_mul(&spin);
        let scale = scales.get(body.entity).map_or(1.0, |scale| scale.0);
        sum.kinetic_energy += 0.5 * (body.mass * body.linear.norm_squared() + spin.dot(&body_momentum));
        sum.potential_energy -= body.mass * scale * g.dot(&body.position);
        linear += body.linear * body.mass;
        angular += body.position.cross(&(body.linear * body.mass)) + body.rotation * body_momentum;
    }
    sum.linear_momentum = linear.into();
    sum.angular_momentum = angular.into();
    for joint in joints.list.iter().filter(|joint| joint.softness.is_none()) {
        let (a, b) = (&bodies.list[joint.a as usize], &bodies.list[joint.b as usize]);
        let error = b.position - a.position + b.rotation * joint.anchor_b - a.rotation * joint.anchor_a;
        sum.joint_error = sum.joint_error.max(error.norm());
    }
    sum.penetration = contacts.points.iter().fold(0.0, |deepest, point| point.depth.max(deepest));
    *diagnostics = sum;
}

fn collect_contact_forces(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    lagged: Res<LaggedContacts>,
    settings: Res<SolverSettings>,
    solvers: Res<IslandSolvers>,
    graph: Res<ContactGraph>,
    groups: Res<ExactGroups>,
    mut forces: ResMut<ContactForces>,
) {
    forces.0.clear();
    if settings.method.keeps_contacts() {
        let h = settings.step();
        forces.collect(&bodies, &contacts, graph.contact_forces(&contacts, h, h / f64::from(settings.substeps)));
    } else if settings.method == Method::Exact {
        let entity = |body: u32| bodies.list[body as usize].entity;
        forces.0.extend(groups.point_forces().map(|found| ContactForce {
            a: entity(found.pair.a),
            b: entity(found.pair.b),
            point: found.point.into(),
            normal: found.normal.into(),
            depth: found.depth,
            force: found.force.into(),
            last_force: found.last_force.map(DVec3::from),
        }));
    } else {
        let contacts = lagged.active(&settings, &contacts);
        let found = solvers.list[..solvers.used].iter().flat_map(|solver| solver.contact_forces());
        forces.collect(&bodies, contacts, found);
    }
}

impl ContactForces {
    fn collect(
        &mut self,
        bodies: &Bodies,
        contacts: &Contacts,
        found: impl Iterator<Item = (u32, usize, [Vector3<f64>; 2])>,
    ) {
        for (manifold, index, [force, last_force]) in found {
            let manifold = &contacts.manifolds[manifold as usize];
            let point = contacts.points_of(manifold)[index];
            self.0.push(ContactForce {
                a: bodies.list[manifold.pair.a as usize].entity,
                b: bodies.list[manifold.pair.b as usize].entity,
                point: point.point.into(),
                normal: manifold.normal.into(),
                depth: point.depth,
                force: force.into(),
                last_force: Some(last_force.into()),
            });
        }
    }
}

fn collect_joint_forces(joints: Res<Joints>, mut forces: ResMut<JointForces>) {
    forces.0.clear();
    forces.0.extend(joints.list.iter().map(|joint| JointForce { joint: joint.entity, force: joint.force.into() }));
}

/// Feeds every bit that the next step depends on to a hasher: poses and velocities of all bodies
/// in the order in which they became bodies, who sleeps (not how long others have been calm), the
/// warm-start cache, and contacts that wait for a lagged solve.
pub fn hash_state<H: Hasher>(world: &World, hasher: &mut H) {
    let mut feed = |value: f64| hasher.write_u64(value.to_bits());
    let Some(bodies) = world.get_resource::<Bodies>() else { return };
    for body in &bodies.list {
        if let (Some(position), Some(rotation), Some(velocity)) =
            (world.get::<Position>(body.entity), world.get::<Rotation>(body.entity), world.get::<Velocity>(body.entity))
        {
            position.0.to_array().into_iter().for_each(&mut feed);
            rotation.0.to_array().into_iter().for_each(&mut feed);
            velocity.linear.to_array().into_iter().for_each(&mut feed);
            velocity.angular.to_array().into_iter().for_each(&mut feed);
        }
    }
    bodies.asleep.iter().map(f64::from).for_each(&mut feed);
    if let Some(cache) = world.get_resource::<ContactCache>() {
        cache.points().iter().flat_map(|(_, force)| force.iter().copied()).for_each(&mut feed);
    }
    if let Some(groups) = world.get_resource::<ExactGroups>() {
        groups.memory().for_each(&mut feed);
    }
    if let Some(graph) = world.get_resource::<ContactGraph>() {
        for (slot, state) in graph.slots.iter().zip(&graph.states).filter(|(slot, _)| slot.touching) {
            feed(f64::from(slot.pair.a));
            state.impulses.0.iter().map(|&impulse| f64::from(impulse)).for_each(&mut feed);
        }
    }
    if let Some(lagged) = world.get_resource::<LaggedContacts>() {
        for manifold in &lagged.pending().manifolds {
            manifold.normal.iter().copied().for_each(&mut feed);
            for point in lagged.pending().points_of(manifold) {
                point.point.iter().copied().for_each(&mut feed);
                feed(point.depth);
            }
        }
    }
}
