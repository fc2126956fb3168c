use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use simba::simd::WideF32x8;

use super::bodies::{ClaimedBody, ClaimedPairs, Ends, GroupBodies, SharedBodies};
use super::coloring::Coloring;
use super::contact::{ContactBlock, ContactInput};
use super::joint::{JointBlock, JointInput};
use super::stage::Sweep;
use crate::physics::body::{Body, RigidBody, world_inverse_inertia};
use crate::physics::collision::{ContactGeometry, ContactState};
use crate::physics::lanes::{Lanes, READ_ONLY, Record};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};
use crate::physics::testing::Random;
#[cfg(debug_assertions)]
use crate::physics::threads::Division;
use bevy::prelude::Entity;

#[test]
fn colours_share_no_body_and_hold_every_constraint_once() {
    let mut random = Random::new(5);
    // A hub with 100 constraints runs out of colours; body 40 does not move.
    let mut pairs: Vec<(u32, u32)> = (1..40).chain(1..40).chain(1..23).map(|body| (0, body)).collect();
    pairs.extend((0..200).map(|_| {
        let body = |random: &mut Random| (random.unit() * 40.0) as u32;
        let (a, b) = (body(&mut random), body(&mut random));
        (a, if a == b { 40 | READ_ONLY } else { b })
    }));
    let mut coloring = Coloring::default();
    coloring.set(41, &pairs, [150, pairs.len() - 150], 8);
    let key = |constraint: u32| constraint % 5;
    coloring.sort_colors(5, key);
    let mut order = coloring.order.clone();
    order.sort_unstable();
    assert_eq!(order, (0..pairs.len() as u32).collect::<Vec<_>>());
    let mut blocks = 0;
    for &(first, last) in &coloring.stages {
        assert_eq!(first, blocks);
        blocks = last;
        let (start, end) = (coloring.blocks[first as usize].0, coloring.blocks[last as usize - 1].1);
        assert!(coloring.order[start as usize..end as usize].is_sorted_by_key(|&constraint| key(constraint)));
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
    let shared = group.share(false);
    for (index, body) in bodies.iter().enumerate() {
        one_body(&shared, index).gather(body, STEP, STEP);
    }
    group
}

/// A body of which nothing else is claimed.
fn one_body<'b, 'a, S: Scalar + Default>(shared: &'b SharedBodies<'a, S>, index: usize) -> ClaimedBody<'b, 'a, S> {
    // SAFETY: one thread, and one claim at a time.
    #[allow(unsafe_code)]
    unsafe {
        shared.claim(index)
    }
}

/// The pairs of a block of which nothing else is claimed.
fn pairs<'b, 'a, L: Lanes>(shared: &'b SharedBodies<'a, L::Scalar>, ends: Ends) -> ClaimedPairs<'b, 'a, L> {
    // SAFETY: one thread, and one claim at a time.
    #[allow(unsafe_code)]
    unsafe {
        shared.claim_pairs(ends)
    }
}

/// Velocities as the bodies would have them after the step.
fn velocities<L: Lanes>(group: &mut GroupBodies<L::Scalar>, bodies: &[Body]) -> Vec<Body> {
    let shared = group.share(false);
    let mut after = bodies.to_vec();
    for (index, body) in after.iter_mut().enumerate().filter(|(_, body)| body.kind == RigidBody::Dynamic) {
        one_body(&shared, index).scatter(body);
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

/// The bodies A and B of the constraint of that index.
fn pair_of(index: usize) -> [usize; 2] {
    [index, index + 8]
}

/// The bodies of a block of the constraints from that index on.
fn ends_from(first: usize) -> Ends {
    [0, 1].map(|end| std::array::from_fn(|lane| read_only(pair_of((first + lane) % 8)[end])))
}

fn joint_inputs(bodies: &[Body], random: &mut Random) -> Vec<JointInput> {
    (0..8)
        .map(|index| JointInput {
            anchors: [random.vector(), random.vector()],
            offset: bodies[pair_of(index)[1]].position - bodies[pair_of(index)[0]].position,
            impulse: Vector3::zeros(),
            softness: None,
        })
        .collect()
}

/// The velocity at which a joint's anchors part.
fn parting(bodies: &[Body], index: usize, input: &JointInput) -> Vector3<f64> {
    let [a, b] = pair_of(index).map(|body| &bodies[body]);
    b.point_velocity(&(b.rotation * input.anchors[1])) - a.point_velocity(&(a.rotation * input.anchors[0]))
}

/// Does something with blocks of all joints.
fn with_joint_blocks<L: Lanes>(
    group: &mut GroupBodies<L::Scalar>,
    inputs: &[JointInput],
    mut work: impl FnMut(&mut JointBlock<L>, &mut ClaimedPairs<L>),
) {
    for (chunk, inputs) in inputs.chunks(L::COUNT).enumerate() {
        let mut block = JointBlock::<L>::idle();
        block.ends = ends_from(chunk * L::COUNT);
        let shared = group.share(false);
        let mut pairs = pairs(&shared, block.ends);
        block.take_in(inputs, &pairs, STEP);
        work(&mut block, &mut pairs);
    }
}

fn joints_in<L: Lanes>(tolerance: f64) {
    let mut random = Random::new(3);
    let bodies = bodies(&mut random);
    let inputs = joint_inputs(&bodies, &mut random);
    let mut group = gather::<L>(&bodies);
    with_joint_blocks::<L>(&mut group, &inputs, |block, pairs| block.solve(pairs, None));
    let after = velocities::<L>(&mut group, &bodies);
    for (index, input) in inputs.iter().enumerate() {
        assert!(parting(&bodies, index, input).norm() > 0.1);
        assert!(parting(&after, index, input).norm() < tolerance, "{:?}", parting(&after, index, input));
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
    let mut random = Random::new(4);
    let bodies = bodies(&mut random);
    let states: Vec<ContactState> = (0..8).map(|lane| contact(&bodies, lane, &mut random)).collect();
    let inputs: Vec<ContactInput> = states
        .iter()
        .enumerate()
        .map(|(index, state)| ContactInput {
            geometry: &state.geometry,
            impulses: &state.impulses,
            offset: bodies[pair_of(index)[1]].position - bodies[pair_of(index)[0]].position,
        })
        .collect();
    let mut group = gather::<L>(&bodies);
    for (chunk, inputs) in inputs.chunks(L::COUNT).enumerate() {
        let mut block = ContactBlock::<L>::idle();
        block.ends = ends_from(chunk * L::COUNT);
        let shared = group.share(false);
        let mut pairs = pairs(&shared, block.ends);
        block.take_in(inputs, &pairs);
        block.solve(&mut pairs, &SoftTerms::rigid(0.0, UNLIMITED, 0.0, 1.0), Sweep::Relax);
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

/// How much the velocities of two bodies change in one update of their contact, and in two more, with friction; the
/// contact is in the middle or, seen from there, at `arm`.
fn changes_in_updates(arm: Vector3<f64>) -> [f64; 2] {
    let mut random = Random::new(9);
    let mut bodies: Vec<Body> = (0..16).map(|_| body(&mut random, RigidBody::Dynamic)).collect();
    let states: Vec<ContactState> = (0..8)
        .map(|lane| {
            let normal = (bodies[lane + 8].position - bodies[lane].position).normalize();
            for index in [lane, lane + 8] {
                bodies[index].inverse_inertia_body = Vector3::repeat(2.0);
            }
            bodies[lane].linear += 3.0 * normal;
            let (a, b) = (&bodies[lane], &bodies[lane + 8]);
            let point = (a.position + b.position) * 0.5 + arm;
            let on_a = a.rotation.inverse_transform_vector(&(point - a.position));
            let on_b = b.rotation.inverse_transform_vector(&(point - b.position));
            let [normal, tangent] = [normal, normal.cross(&random.direction()).normalize()]
                .map(|vector| a.rotation.inverse_transform_vector(&vector));
            let geometry = ContactGeometry::new(&normal, &tangent, 0.5, 1, std::iter::once((on_a, on_b)));
            ContactState { geometry, ..ContactState::default() }
        })
        .collect();
    let inputs: Vec<ContactInput> = states
        .iter()
        .enumerate()
        .map(|(lane, ContactState { geometry, impulses })| ContactInput {
            geometry,
            impulses,
            offset: bodies[lane + 8].position - bodies[lane].position,
        })
        .collect();
    let mut group = gather::<WideF32x8>(&bodies);
    let mut block = ContactBlock::<WideF32x8>::idle();
    block.ends = [std::array::from_fn(|lane| lane as u32), std::array::from_fn(|lane| lane as u32 + 8)];
    let mut before = velocities::<WideF32x8>(&mut group, &bodies);
    [1, 2].map(|updates| {
        {
            let shared = group.share(false);
            let mut pairs = pairs(&shared, block.ends);
            if updates == 1 {
                block.take_in(&inputs, &pairs);
            }
            for _ in 0..updates {
                block.solve(&mut pairs, &SoftTerms::rigid(0.0, UNLIMITED, 0.0, 1.0), Sweep::Relax);
            }
        }
        let after = velocities::<WideF32x8>(&mut group, &bodies);
        let change =
            before.iter().zip(&after).map(|(b, a)| (a.linear - b.linear).norm().max((a.angular - b.angular).norm()));
        let change = change.fold(0.0, f64::max);
        before = after;
        change
    })
}

#[test]
fn a_push_through_the_centres_is_right_at_once_and_any_other_nearly() {
    let [once, after] = changes_in_updates(Vector3::zeros());
    assert!(once > 1.0 && after < 1e-5 * once, "{once}, then {after}");
    let [once, after] = changes_in_updates(Vector3::new(0.3, 0.2, -0.4));
    assert!(once > 1.0 && after < 0.1 * once, "{once}, then {after}");
}

#[test]
fn one_update_stops_points_that_approach_in_any_lanes() {
    contacts_in::<f64>(1e-5);
    contacts_in::<WideF32x8>(1e-4);
}

/// Two chunks of one stage update the velocities of a pair each, of which the second bodies are given.
#[cfg(debug_assertions)]
fn two_chunks_of_one_stage(seconds: [u32; 2]) {
    let bodies = bodies(&mut Random::new(7));
    let mut group = gather::<f64>(&bodies);
    let shared = group.share(false);
    let division = Division::of_stages(1);
    for (chunk, second) in seconds.into_iter().enumerate() {
        division.work_as(chunk, || {
            let mut pairs = pairs::<f64>(&shared, [[2 + chunk as u32; 8], [second; 8]]);
            let velocities = pairs.velocities();
            pairs.set_velocities(velocities);
        });
    }
}

#[test]
#[cfg(debug_assertions)]
fn chunks_of_a_stage_may_share_what_does_not_move() {
    two_chunks_of_one_stage([READ_ONLY, READ_ONLY]);
}

#[test]
#[cfg(debug_assertions)]
#[should_panic(expected = "claimed twice in one stage")]
fn chunks_of_a_stage_that_share_a_body_that_moves_are_found() {
    two_chunks_of_one_stage([9, 9]);
}

fn projection<L: Lanes>(share: f64) -> Projection<L> {
    Projection { contact_share: L::of(share), joint_share: L::of(share), max_correction: L::of(1e3), slop: L::of(0.0) }
}

/// How far each joint's anchors are apart, by the rows of where the bodies were gathered.
fn separations_after<L: Lanes>(share: f64) -> Vec<(f64, f64)> {
    let mut random = Random::new(6);
    let bodies = bodies(&mut random);
    let inputs = joint_inputs(&bodies, &mut random);
    let mut group = gather::<L>(&bodies);
    with_joint_blocks::<L>(&mut group, &inputs, |block, pairs| block.project(pairs, &projection(share)));
    let after = velocities::<L>(&mut group, &bodies);
    // Moves are added to poses, with all of a turn in the first order of their rows.
    let apart = |bodies: &[Body], index: usize, arms: [Vector3<f64>; 2]| {
        let [a, b] = pair_of(index).map(|body| &bodies[body]);
        (b.position + arms[1] - a.position - arms[0]).norm()
    };
    inputs
        .iter()
        .enumerate()
        .map(|(index, input)| {
            let [a, b] = pair_of(index);
            let arms = [bodies[a].rotation * input.anchors[0], bodies[b].rotation * input.anchors[1]];
            let turned = |body: usize, arm: &Vector3<f64>| {
                let turn = (after[body].rotation * bodies[body].rotation.inverse()).scaled_axis();
                arm + turn.cross(arm)
            };
            assert_eq!(after[b].linear, velocities::<L>(&mut gather::<L>(&bodies), &bodies)[b].linear);
            (apart(&bodies, index, arms), apart(&after, index, [turned(a, &arms[0]), turned(b, &arms[1])]))
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
        let shared = group.share(false);
        let input = ContactInput { geometry: &state.geometry, impulses: &state.impulses, offset: ball.position };
        bodies.iter().enumerate().for_each(|(index, body)| one_body(&shared, index).gather(body, h, h));
        let mut block = ContactBlock::<f64>::idle();
        block.ends = [[READ_ONLY; 8], [1; 8]];
        block.take_in(&[input], &pairs(&shared, block.ends));
        one_body(&shared, 1).begin_substep(true);
        let mut pairs = pairs(&shared, block.ends);
        block.warm_start(&mut pairs);
        block.solve(&mut pairs, &soft, Sweep::Soft);
        one_body(&shared, 1).drift(h);
        block.solve(&mut pairs, &soft, Sweep::Relax);
        one_body(&shared, 1).end_substep();
        one_body(&shared, 1).scatter(&mut ball);
        let impulses: [Record<f32>; 8] = block.impulses(0.0);
        state.impulses = impulses[0];
    }
    let sunk = 1.0 - ball.position.y;
    let expected = 10.0 / (std::f64::consts::TAU * frequency).powi(2);
    assert!((sunk / expected - 1.0).abs() < 0.05, "{sunk} {expected}");
    assert!(ball.linear.norm() < 1e-6);
    assert!((f64::from(state.impulses.0[0]) / (20.0 * h) - 1.0).abs() < 1e-3);
    assert_eq!(ball.rotation, UnitQuaternion::identity());
}
