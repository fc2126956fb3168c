//! What a step did and how true it was: counts, times, energy, momentum, errors, forces.
//!
//! [`StepStats`] is always there. [`Diagnostics`], [`ContactForces`] and [`JointForces`] are filled
//! in only while the resource exists: insert it to read it.

use std::time::{Duration, Instant};

use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::{
    Bodies, ContactForce, ContactForces, ContactGraph, Contacts, Diagnostics, ExactGroups, Gravity, GravityScale,
    IslandSolvers, Joint, JointForce, JointForces, Joints, Keep, LaggedContacts, Method, PhysicsSchedule,
    PhysicsSystems, Refill, SolverSettings, StepStats,
};

/// How long the last step's measuring took.
#[derive(Resource, Default)]
pub(super) struct MeasuringTime {
    started: Option<Instant>,
    pub spent: Duration,
}

pub(super) fn plugin(app: &mut App) {
    app.keep_resource::<Diagnostics>().keep_resource::<ContactForces>().keep_resource::<JointForces>();
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
    let is_read = resource_exists::<Diagnostics>
        .or_else(resource_exists::<ContactForces>)
        .or_else(resource_exists::<JointForces>);
    app.configure_sets(PhysicsSchedule, Measuring.in_set(PhysicsSystems::Diagnose).run_if(is_read));
}

/// All that is measured: one condition for the lot, for the many steps in which nobody reads it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Measuring;

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
    (stats, settings, groups): (Res<StepStats>, Res<SolverSettings>, Res<ExactGroups>),
    scales: Query<&GravityScale>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let mut sum = Diagnostics::default();
    let g = Vector3::from(gravity.0);
    let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
    let unfixed = bodies.fixed.in_neither(&bodies.fixed, 0..bodies.list.len() as u32);
    for body in unfixed.map(|index| &bodies.list[index as usize]).filter(|body| body.is_dynamic()) {
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
    for joint in &joints.list {
        let ends = [&bodies.list[joint.a as usize], &bodies.list[joint.b as usize]];
        sum.joint_error = sum.joint_error.max(joint.definition.separation(ends, stats.time));
    }
    sum.penetration = if settings.method == Method::Exact {
        // Other methods find contacts by axes that are preferred though bodies overlap less along others.
        groups.overlap()
    } else {
        contacts.points.iter().fold(0.0, |deepest, point| point.depth.max(deepest))
    };
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
    let of = |pieces: &[Joint]| {
        let sum = |of: fn(&Joint) -> Vector3<f64>| pieces.iter().map(of).sum::<Vector3<f64>>().into();
        JointForce {
            joint: pieces[0].entity,
            force: sum(|piece| piece.load().linear),
            torque: sum(|piece| piece.load().angular),
        }
    };
    forces.0.refill(joints.list.chunk_by(|one, next| one.entity == next.entity).map(of));
}
