use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use simba::simd::WideF32x8;

use super::bodies::GroupBodies;
use super::coloring::Coloring;
use super::contact::{ContactBlock, ContactSite};
use super::joint::{JointBlock, JointSite};
use super::stage::Sweep;
use crate::physics::bodies::{Body, world_inverse_inertia};
use crate::physics::body::RigidBody;
use crate::physics::collision::{ContactGeometry, ContactState};
use crate::physics::lanes::{Lanes, READ_ONLY, Record};
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};
use crate::physics::testing::Random;
use bevy::prelude::Entity;

#[test]
fn colours_share_no_body_and_hold_every_constraint_once() {
    let mut random = Random(5);
    // A hub with 100 constraints runs out of colours; body 40 does not move.
    let mut pairs: Vec<(u32, u32)> = (1..40).chain(1..40).chain(1..23).map(|body| (0, body)).collect();
    pairs.extend((0..200).map(|_| {
        let body = |random: &mut Random| (random.unit() * 40.0) as u32;
        let (a, b) = (body(&mut random), body(&mut random));
        (a, if a == b { 40 | READ_ONLY } else { b })
    }));
    let mut coloring = Coloring::default();
    coloring.add(41, 0, &pairs[..150], 8);
    coloring.add(41, 150, &pairs[150..], 8);
    let mut order = coloring.order.clone();
    order.sort_unstable();
    assert_eq!(order, (0..pairs.len() as u32).collect::<Vec<_>>());
    let mut blocks = 0;
    for &(first, last) in &coloring.stages {
        assert_eq!(first, blocks);
        blocks = last;
        let mut used = Vec::new();
        for &(start, end) in &coloring.blocks[first as usize..last as usize] {
            assert!(end - start <= 8 && end > start);
            for &index in &coloring.order[start as usize..end as usize] {
                let (a, b) = pairs[index as usize];
                used.extend([a, b].into_iter().filter(|body| body & READ_ONLY == 0));
            }
        }
        let count = used.len();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), count);
    }
    assert_eq!(blocks as usize, coloring.blocks.len());
}

fn body(random: &mut Random, kind: RigidBody) -> Body {
    let moves = f64::from(u8::from(kind == RigidBody::Dynamic));
    Body {
        kind,
        position: random.vector(),
        rotation: random.rotation(),
        linear: random.vector(),
        angular: random.vector(),
        inverse_mass: Vector3::repeat(moves * random.within(0.2, 5.0)),
        inverse_inertia_body: Vector3::from_fn(|_, _| moves * random.within(0.5, 10.0)),
        ..Body::new(Entity::PLACEHOLDER)
    }
}

/// Sixteen bodies, of which one is static and one kinematic.
fn bodies(random: &mut Random) -> Vec<Body> {
    let kind = |index| match index {
        0 => RigidBody::Static,
        1 => RigidBody::Kinematic,
        _ => RigidBody::Dynamic,
    };
    (0..16).map(|index| body(random, kind(index))).collect()
}

/// A step so short that nothing turns.
const STEP: f64 = 1e-6;

fn gather<L: Lanes>(bodies: &[Body]) -> GroupBodies<L::Scalar> {
    let mut group = GroupBodies::default();
    group.resize(bodies.len());
    let shared = group.share();
    for (index, body) in bodies.iter().enumerate() {
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        unsafe {
            shared.gather(index, body, STEP, STEP);
        }
    }
    group
}

/// Velocities as the bodies would have them after the step.
fn velocities<L: Lanes>(group: &mut GroupBodies<L::Scalar>, bodies: &[Body]) -> Vec<Body> {
    let shared = group.share();
    let mut after = bodies.to_vec();
    for (index, body) in after.iter_mut().enumerate().filter(|(_, body)| body.kind == RigidBody::Dynamic) {
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        unsafe {
            shared.scatter(index, body);
        }
    }
    after
}

fn inverse_inertia(body: &Body) -> Matrix3<f64> {
    match body.kind {
        RigidBody::Dynamic => world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom),
        _ => Matrix3::zeros(),
    }
}

fn read_only(body: usize) -> u32 {
    if body < 2 { body as u32 | READ_ONLY } else { body as u32 }
}

fn joint_sites(bodies: &[Body], random: &mut Random) -> Vec<JointSite> {
    (0..8)
        .map(|lane| JointSite {
            a: read_only(lane),
            b: read_only(lane + 8),
            anchor_a: random.vector(),
            anchor_b: random.vector(),
            apart: bodies[lane + 8].position - bodies[lane].position,
            impulse: Vector3::zeros(),
            softness: None,
        })
        .collect()
}

/// The velocity at which a joint's anchors part.
fn parting(bodies: &[Body], site: &JointSite) -> Vector3<f64> {
    let [a, b] = [site.a, site.b].map(|body| &bodies[(body & !READ_ONLY) as usize]);
    b.point_velocity(&(b.rotation * site.anchor_b)) - a.point_velocity(&(a.rotation * site.anchor_a))
}

fn joints_in<L: Lanes>(tolerance: f64) {
    let mut random = Random(3);
    let bodies = bodies(&mut random);
    let sites = joint_sites(&bodies, &mut random);
    let mut group = gather::<L>(&bodies);
    for sites in sites.chunks(L::COUNT) {
        let shared = group.share();
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        unsafe {
            let mut block = JointBlock::<L>::new(sites, shared.frames, STEP);
            block.solve(shared.velocity, shared.moved, None);
        }
    }
    let after = velocities::<L>(&mut group, &bodies);
    for site in &sites {
        assert!(parting(&bodies, site).norm() > 0.1);
        assert!(parting(&after, site).norm() < tolerance, "{:?}", parting(&after, site));
    }
    // What one body gained the other lost, but for those that nothing moves.
    for (a, b) in (2..8).map(|index| (index, index + 8)) {
        let gained = |body: usize| (after[body].linear - bodies[body].linear) / bodies[body].inverse_mass.x;
        assert!((gained(a) + gained(b)).norm() < tolerance);
    }
}

#[test]
fn one_update_closes_joints_in_any_lanes() {
    joints_in::<f64>(1e-9);
    joints_in::<WideF32x8>(1e-4);
}

/// A contact with one point, without friction.
fn contact(bodies: &[Body], lane: usize, random: &mut Random) -> ContactState {
    let (a, b) = (&bodies[lane], &bodies[lane + 8]);
    let normal = random.direction();
    let point = (a.position + b.position) * 0.5;
    let on_a = a.rotation.inverse_transform_vector(&(point - a.position));
    let on_b = b.rotation.inverse_transform_vector(&(point - b.position));
    let tangent = normal.cross(&random.direction()).normalize();
    ContactState {
        geometry: ContactGeometry::new(&normal, &tangent, 0.0, 1, std::iter::once((on_a, on_b))),
        ..ContactState::default()
    }
}

fn contacts_in<L: Lanes>(tolerance: f64) {
    let mut random = Random(4);
    let bodies = bodies(&mut random);
    let states: Vec<ContactState> = (0..8).map(|lane| contact(&bodies, lane, &mut random)).collect();
    let sites: Vec<ContactSite> = states
        .iter()
        .enumerate()
        .map(|(lane, state)| ContactSite {
            a: read_only(lane),
            b: read_only(lane + 8),
            geometry: &state.geometry,
            impulses: &state.impulses,
            apart: bodies[lane + 8].position - bodies[lane].position,
        })
        .collect();
    let mut group = gather::<L>(&bodies);
    for sites in sites.chunks(L::COUNT) {
        let shared = group.share();
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        unsafe {
            let mut block = ContactBlock::<L>::new(sites, shared.frames);
            block.solve(shared.velocity, shared.moved, &SoftTerms::rigid(0.0, UNLIMITED, 0.0, 1.0), Sweep::Relax);
        }
    }
    let after = velocities::<L>(&mut group, &bodies);
    let mut pushed = 0;
    for (lane, state) in states.iter().enumerate() {
        let (a, b) = (&bodies[lane], &bodies[lane + 8]);
        let normal = a.rotation * state.geometry.normal();
        let (arm_a, arm_b) = ((b.position - a.position) * 0.5, (a.position - b.position) * 0.5);
        let approach = |bodies: &[Body]| {
            normal.dot(&(bodies[lane + 8].point_velocity(&arm_b) - bodies[lane].point_velocity(&arm_a)))
        };
        let (before, left) = (approach(&bodies), approach(&after));
        // By the plain formula of one rigid row.
        let effect = |body: &Body, arm: &Vector3<f64>| {
            let turn = arm.cross(&normal);
            normal.dot(&body.inverse_mass.component_mul(&normal)) + turn.dot(&(inverse_inertia(body) * turn))
        };
        let impulse = (-before / (effect(a, &arm_a) + effect(b, &arm_b))).max(0.0);
        let gained = normal.dot(&(after[lane + 8].linear - b.linear)) / b.inverse_mass.x;
        assert!((gained - impulse).abs() < tolerance, "{gained} {impulse}");
        if before < 0.0 {
            pushed += 1;
            assert!(left.abs() < tolerance, "{left}");
        } else {
            assert!((left - before).abs() < tolerance, "nothing holds them together");
        }
    }
    assert!((2..=6).contains(&pushed), "{pushed} of 8 push: the test sees both sides");
}

#[test]
fn one_update_stops_points_that_approach_in_any_lanes() {
    contacts_in::<f64>(1e-5);
    contacts_in::<WideF32x8>(1e-4);
}

fn projection<L: Lanes>(share: f64) -> Projection<L> {
    Projection { contact: L::of(share), joint: L::of(share), most: L::of(1e3), slop: L::of(0.0) }
}

/// How far each joint's anchors are apart, by the rows of where the bodies were gathered.
fn separations_after<L: Lanes>(share: f64) -> Vec<(f64, f64)> {
    let mut random = Random(6);
    let bodies = bodies(&mut random);
    let sites = joint_sites(&bodies, &mut random);
    let mut group = gather::<L>(&bodies);
    for sites in sites.chunks(L::COUNT) {
        let shared = group.share();
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        unsafe {
            let block = JointBlock::<L>::new(sites, shared.frames, STEP);
            block.project(shared.moved, &projection(share));
        }
    }
    let after = velocities::<L>(&mut group, &bodies);
    // Moves are added to poses, with all of a turn in the first order of their rows.
    let apart = |bodies: &[Body], site: &JointSite, arms: [Vector3<f64>; 2]| {
        let [a, b] = [site.a, site.b].map(|body| &bodies[(body & !READ_ONLY) as usize]);
        (b.position + arms[1] - a.position - arms[0]).norm()
    };
    sites
        .iter()
        .map(|site| {
            let [a, b] = [site.a, site.b].map(|body| (body & !READ_ONLY) as usize);
            let arms = [bodies[a].rotation * site.anchor_a, bodies[b].rotation * site.anchor_b];
            let turned = |body: usize, arm: &Vector3<f64>| {
                let turn = (after[body].rotation * bodies[body].rotation.inverse()).scaled_axis();
                arm + turn.cross(arm)
            };
            assert_eq!(after[b].linear, velocities::<L>(&mut gather::<L>(&bodies), &bodies)[b].linear);
            (apart(&bodies, site, arms), apart(&after, site, [turned(a, &arms[0]), turned(b, &arms[1])]))
        })
        .collect()
}

#[test]
fn projection_takes_its_share_of_a_joints_error_and_leaves_velocities() {
    for (share, left) in [(1.0, 0.0), (0.25, 0.75)] {
        let double = separations_after::<f64>(share);
        let wide = separations_after::<WideF32x8>(share);
        for (results, tolerance) in [(double, 1e-9), (wide, 1e-4)] {
            for (before, after) in results {
                assert!(before > 0.1 && (after - left * before).abs() < tolerance, "{share}: {before} {after}");
            }
        }
    }
}

#[test]
fn a_soft_contact_settles_where_its_spring_holds_the_weight() {
    // A ball of 2 kg with its lowest point on a plane, g = 10, substeps of 1/240 s: with the effective mass m
    // the spring's stiffness is m ω², and it gives by g/ω².
    let h = 1.0 / 240.0;
    let plane = Body::new(Entity::PLACEHOLDER);
    let mut ball = Body {
        kind: RigidBody::Dynamic,
        position: Vector3::y(),
        inverse_mass: Vector3::repeat(0.5),
        inverse_inertia_body: Vector3::repeat(1.0),
        force: Vector3::y() * -20.0,
        mass: 2.0,
        ..Body::new(Entity::PLACEHOLDER)
    };
    let frequency = 45.0;
    let soft = SoftTerms::<f64>::new(frequency, 5.0, UNLIMITED, 0.0, h);
    let mut state = ContactState::default();
    let point = (Vector3::zeros(), -Vector3::y());
    state.geometry = ContactGeometry::new(&Vector3::y(), &Vector3::x(), 0.0, 1, std::iter::once(point));
    for _ in 0..600 {
        let bodies = [plane.clone(), ball.clone()];
        let mut group = GroupBodies::<f64>::default();
        group.resize(2);
        let shared = group.share();
        let site = ContactSite {
            a: READ_ONLY,
            b: 1,
            geometry: &state.geometry,
            impulses: &state.impulses,
            apart: ball.position,
        };
        // SAFETY: one thread.
        #[allow(unsafe_code)]
        let impulses: [Record<f32>; 8] = unsafe {
            bodies.iter().enumerate().for_each(|(index, body)| shared.gather(index, body, h, h));
            let mut block = ContactBlock::<f64>::new(&[site], shared.frames);
            shared.begin_substep(1, true);
            block.warm_start(shared.velocity);
            block.solve(shared.velocity, shared.moved, &soft, Sweep::Springs);
            shared.drift(1, h);
            block.solve(shared.velocity, shared.moved, &soft, Sweep::Relax);
            shared.end_substep(1);
            shared.scatter(1, &mut ball);
            block.impulses()
        };
        state.impulses = impulses[0];
    }
    let sunk = 1.0 - ball.position.y;
    let expected = 10.0 / (std::f64::consts::TAU * frequency).powi(2);
    assert!((sunk / expected - 1.0).abs() < 0.05, "{sunk} {expected}");
    assert!(ball.linear.norm() < 1e-6);
    assert!((f64::from(state.impulses.0[0]) / (20.0 * h) - 1.0).abs() < 1e-3);
    assert_eq!(ball.rotation, UnitQuaternion::identity());
}
