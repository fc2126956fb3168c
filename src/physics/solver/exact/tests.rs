//! Joints that hold rotations, too.

use std::f64::consts::{FRAC_PI_2, TAU};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::body::{Inertia, Mass, Position, RigidBody, Rotation, Velocity};
use crate::physics::joint::{Frame, Hold, JointDefinition, JointLoad, Joints, Laws, Softness};
use crate::physics::settings::{ExactIntegrator, ExactSettings, Gravity, SolverSettings};
use crate::physics::shape::Collider;
use crate::physics::stats::StepStats;
use crate::physics::testing::runge_kutta;
use crate::physics::{headless_app, step};

const G: f64 = 9.81;
/// Both swings, so that a frame turns about its x alone.
const HINGED: Laws = Laws { hold: [Hold::Free, Hold::Locked, Hold::Locked], spring: None };

fn world(integrator: ExactIntegrator, hz: f64) -> World {
    let mut world = std::mem::take(headless_app().world_mut());
    world.insert_resource(SolverSettings {
        hz,
        exact: ExactSettings { integrator, time_budget: None },
        ..SolverSettings::accurate()
    });
    world
}

fn body(world: &mut World, position: DVec3, rotation: DQuat, mass: f64, inertia: DVec3) -> Entity {
    let pose = (Position(position), Rotation(rotation));
    world.spawn((RigidBody::Dynamic, pose, Mass(mass), Inertia(inertia))).id()
}

fn pose(world: &World, body: Entity) -> (DVec3, DQuat) {
    (world.get::<Position>(body).unwrap().0, world.get::<Rotation>(body).unwrap().0)
}

/// A joint whose frames are both at `point`, with the world's axes turned by `axes`.
fn join(world: &mut World, bodies: [Entity; 2], point: DVec3, axes: DQuat, laws: [Laws; 2]) -> Entity {
    let frames = bodies.map(|body| {
        let (position, rotation) = pose(world, body);
        let turned = UnitQuaternion::from_quaternion((rotation.inverse() * axes).into());
        Frame { anchor: (rotation.inverse() * (point - position)).into(), rotation: turned }
    });
    let [translation, rotation] = laws;
    let definition = JointDefinition { bodies, frames, translation, rotation, ..default() };
    world.spawn((definition, JointLoad::default())).id()
}

/// About z.
fn hinge(world: &mut World, bodies: [Entity; 2], point: DVec3) -> Entity {
    join(world, bodies, point, DQuat::from_rotation_y(-FRAC_PI_2), [Laws::LOCKED, HINGED])
}

fn pin(world: &mut World, position: DVec3) -> Entity {
    world.spawn((RigidBody::Static, Position(position), Rotation::default())).id()
}

fn steps(world: &mut World, count: u32) {
    (0..count).for_each(|_| step(world));
    assert_eq!(world.resource::<StepStats>().unsettled, 0);
}

const MASS: f64 = 2.0;
const INERTIA: DVec3 = DVec3::new(0.1, 0.2, 0.4);
/// The axes of its inertia are not those that it turns about.
const TILT: DQuat = DQuat::from_xyzw(0.36, 0.48, 0.0, 0.8);

/// About the axis z of the hinge.
fn inertia_about_hinge() -> f64 {
    let axis = TILT.inverse() * DVec3::Z;
    MASS + axis.dot(INERTIA * axis)
}

/// A body on a hinge at 1 m from its centre of mass, level and at rest.
fn pendulum(integrator: ExactIntegrator, hz: f64) -> (World, Entity, Entity) {
    let mut world = world(integrator, hz);
    let bob = body(&mut world, DVec3::X, TILT, MASS, INERTIA);
    let post = pin(&mut world, DVec3::ZERO);
    let hinge = hinge(&mut world, [post, bob], DVec3::ZERO);
    (world, bob, hinge)
}

/// Its angle below the horizontal after a time, s: θ̈ = m g cos θ/I, by the classical Runge–Kutta method in steps of
/// 0.1 ms, 1e-13 off.
fn swung(time: f64) -> f64 {
    let change = |[angle, speed]: [f64; 2]| [speed, MASS * G * angle.cos() / inertia_about_hinge()];
    runge_kutta([0.0; 2], time, (time * 1e4).round() as u32, change)[0]
}

#[test]
fn a_hinged_body_swings_with_the_order_of_its_integrator() {
    let angle = swung(1.0);
    let error = |integrator, hz: f64| {
        let (mut world, bob, _) = pendulum(integrator, hz);
        steps(&mut world, hz as u32);
        let (position, rotation) = pose(&world, bob);
        assert!(position.z.abs() < 1e-13, "the hinge lets go of its plane by {} m", position.z);
        assert!((rotation * TILT.inverse() * DVec3::Z).distance(DVec3::Z) < 1e-13);
        position.distance(DVec3::new(angle.cos(), -angle.sin(), 0.0))
    };
    for (integrator, hz, order) in [(ExactIntegrator::Rattle, 240.0, 2.0), (ExactIntegrator::Gauss, 20.0, 6.0)] {
        let errors = [error(integrator, hz), error(integrator, 2.0 * hz)];
        let found = (errors[0] / errors[1]).log2();
        assert!((found - order).abs() < 0.4, "{integrator:?}: order {found} from {errors:?} m");
    }
}

#[test]
fn a_hinge_tells_the_torque_that_turns_the_axes_of_inertia() {
    let (mut world, bob, hinge) = pendulum(ExactIntegrator::Gauss, 960.0);
    steps(&mut world, 480);
    let momentum = |world: &World| {
        let (position, rotation) = pose(world, bob);
        let Velocity { linear, angular } = *world.get(bob).unwrap();
        position.cross(linear * MASS) + rotation * (INERTIA * (rotation.inverse() * angular))
    };
    let before = momentum(&world);
    step(&mut world);
    let (arm, torque) = (pose(&world, bob).0, world.get::<JointLoad>(hinge).unwrap().torque);
    step(&mut world);
    // Central differences about the step's end.
    let gained = (momentum(&world) - before) * (0.5 * 960.0);
    let expected = gained - arm.cross(DVec3::NEG_Y * (MASS * G));
    assert!(torque.distance(expected) < 1e-4, "{torque} instead of {expected}");
    assert!(torque.length() > 1.0 && torque.z.abs() < 1e-9, "{torque}");
}

/// Four bars on four parallel hinges, of which three of the 20 rows are redundant. The crank goes round.
#[test]
fn a_loop_of_hinges_keeps_its_energy() {
    for (integrator, hz, most) in [(ExactIntegrator::Rattle, 480.0, 2e-3), (ExactIntegrator::Gauss, 240.0, 1e-7)] {
        let mut world = world(integrator, hz);
        // Crank of 1 m, rocker of 1.5 m, coupler of 2.2 m.
        let (left, right) = (DVec3::ZERO, DVec3::X * 2.5);
        let top = DVec3::Y;
        let apart = right - top;
        let along = (apart.length_squared() + 2.2 * 2.2 - 1.5 * 1.5) / (2.0 * apart.length());
        let across = (2.2 * 2.2 - along * along).sqrt();
        let unit = apart.normalize();
        let far = top + unit * along + DVec3::new(-unit.y, unit.x, 0.0) * across;
        let ground = pin(&mut world, DVec3::ZERO);
        let bars = [(left, top), (top, far), (far, right)].map(|(from, to): (DVec3, DVec3)| {
            let rotation = DQuat::from_rotation_arc(DVec3::X, (to - from).normalize());
            body(&mut world, (from + to) / 2.0, rotation, 1.0, DVec3::new(0.01, 0.1, 0.1))
        });
        let links = [([ground, bars[0]], left), ([bars[0], bars[1]], top), ([bars[1], bars[2]], far)];
        let joints: Vec<_> = links.into_iter().chain([([bars[2], ground], right)]).collect();
        for (ends, point) in joints {
            hinge(&mut world, ends, point);
        }
        let energy = |world: &World| -> f64 {
            let of = |&bar: &Entity| {
                let Velocity { linear, angular } = *world.get(bar).unwrap();
                0.5 * (linear.length_squared() + 0.1 * angular.z * angular.z) + G * pose(world, bar).0.y
            };
            bars.iter().map(of).sum()
        };
        let start = energy(&world);
        let mut lost: f64 = 0.0;
        for _ in 0..3 * hz as u32 {
            steps(&mut world, 1);
            lost = lost.max((energy(&world) - start).abs());
            let (crank, turned) = pose(&world, bars[0]);
            // The crank's hinge: to the rounding of a metre, and of a radian.
            assert!((crank + turned * DVec3::NEG_X * 0.5).length() < 1e-12);
            assert!((turned * DVec3::Z).distance(DVec3::Z) < 1e-12);
        }
        // Some 20 J are in motion. RATTLE keeps them to the second order of the step; Gauss, to what the method of
        // multipliers leaves of accelerations where rows are redundant.
        assert!(lost < most * 20.0, "{integrator:?}: {lost} J");
    }
}

/// A box on the floor holds another out over its side by six rows.
#[test]
fn a_rigid_joint_carries_a_torque_while_its_body_lies_on_the_floor() {
    let mut world = world(ExactIntegrator::Gauss, 60.0);
    world.spawn((RigidBody::Static, Collider::half_space(), Transform::default()));
    let cuboid = |world: &mut World, size: DVec3, position: DVec3, mass: f64| {
        let shape = Collider::cuboid(size.x, size.y, size.z);
        world.spawn((RigidBody::Dynamic, shape, Position(position), Rotation::default(), Mass(mass))).id()
    };
    let low = cuboid(&mut world, DVec3::new(2.0, 1.0, 1.0), DVec3::Y * 0.5, 4.0);
    let out = cuboid(&mut world, DVec3::ONE, DVec3::new(1.5, 1.5, 0.25), 1.0);
    let joint = join(&mut world, [low, out], DVec3::new(1.0, 1.0, 0.0), DQuat::IDENTITY, [Laws::LOCKED; 2]);
    steps(&mut world, 60);
    let load = *world.get::<JointLoad>(joint).unwrap();
    let weight = DVec3::Y * G;
    // The residual that the cone solver is asked for is 1e-10 m/s, over a step of 1/60 s some 1e-8 of the load.
    assert!(load.force.distance(weight) < 1e-6, "{}", load.force);
    let torque = DVec3::new(0.5, 0.5, 0.25).cross(weight);
    assert!(load.torque.distance(torque) < 1e-6, "{} instead of {torque}", load.torque);
    assert!(pose(&world, out).0.distance(DVec3::new(1.5, 1.5, 0.25)) < 1e-9);
}

/// A body by its centre of mass on a spring of torsion, turning slowly.
#[test]
fn a_spring_of_torsion_has_its_frequency_and_its_largest_torque() {
    let (frequency, speed) = (2.0, 0.02);
    for integrator in [ExactIntegrator::Gauss, ExactIntegrator::Rattle] {
        for (max_force, time) in [(1e9, 0.3), (1e-4, 0.05)] {
            let mut world = world(integrator, 480.0);
            world.insert_resource(Gravity(DVec3::ZERO));
            let post = pin(&mut world, DVec3::ZERO);
            let wheel = body(&mut world, DVec3::ZERO, DQuat::IDENTITY, 1.0, INERTIA);
            world.entity_mut(wheel).insert(Velocity { linear: DVec3::ZERO, angular: DVec3::Z * speed });
            let spring = Some(Softness { frequency, damping_ratio: 0.0, max_force });
            let laws = [Laws::LOCKED, Laws { spring, ..Laws::LOCKED }];
            let joint = join(&mut world, [post, wheel], DVec3::ZERO, DQuat::IDENTITY, laws);
            steps(&mut world, (time * 480.0) as u32);
            let angle = 2.0 * pose(&world, wheel).1.z;
            let load = world.get::<JointLoad>(joint).unwrap();
            if max_force > 1.0 {
                let omega = TAU * frequency;
                let expected = speed / omega * (omega * time).sin();
                // RATTLE's phase: (ωh)²/24 of some 4 rad.
                assert!((angle - expected).abs() < 1e-3 * speed / omega, "{integrator:?}: {angle} not {expected}");
            } else {
                // By 0.05 s the spring would ask for some hundred times its largest torque. Its rows are cos θ/2 long.
                assert!((load.torque.length() - max_force).abs() < 1e-6 * max_force, "{}", load.torque);
                let lost = speed - world.get::<Velocity>(wheel).unwrap().angular.z;
                assert!(lost > 0.0 && lost < max_force / INERTIA.z * time, "{lost}");
            }
            assert!(load.force.length() < 1e-12);
        }
    }
}

/// Ten rods of 1 m and 1 kg with a ball of that mass, kg, at their end, let go level. The greatest error of their energy
/// over the greatest kinetic energy, and the substeps beyond one in each step, over 1.5 s.
fn swing_a_load(mass: f64, hz: f64) -> [f64; 2] {
    let mut world = world(ExactIntegrator::Gauss, hz);
    world.insert_resource(Gravity(-G * DVec3::Y));
    let mut before = pin(&mut world, DVec3::ZERO);
    let mut bodies = Vec::new();
    for index in 0..11 {
        let (middle, own_mass, inertia) = match index {
            10 => (10.0, mass, DVec3::splat(0.1 * mass)),
            _ => (f64::from(index) + 0.5, 1.0, DVec3::new(0.005, 0.085, 0.085)),
        };
        let next = body(&mut world, DVec3::X * middle, DQuat::IDENTITY, own_mass, inertia);
        join(&mut world, [before, next], DVec3::X * f64::from(index), DQuat::IDENTITY, [Laws::LOCKED, Laws::FREE]);
        bodies.push((next, own_mass, inertia));
        before = next;
    }
    let (mut error, mut fastest, mut cuts) = (0.0_f64, 0.0_f64, 0);
    let count = (1.5 * hz) as u32;
    for _ in 0..count {
        steps(&mut world, 1);
        cuts += world.resource::<StepStats>().cuts;
        let [mut kinetic, mut potential] = [0.0, 0.0];
        for &(body, mass, inertia) in &bodies {
            let (position, rotation) = pose(&world, body);
            let velocity = world.get::<Velocity>(body).unwrap();
            let spin = rotation.inverse() * velocity.angular;
            kinetic += 0.5 * (mass * velocity.linear.length_squared() + spin.dot(inertia * spin));
            potential += mass * G * position.y;
        }
        fastest = fastest.max(kinetic);
        error = error.max((kinetic + potential).abs());
    }
    [error / fastest, f64::from(cuts) / f64::from(count)]
}

/// Its rods swing a thousand times as fast as it does: no step resolves that, and none has to.
#[test]
fn a_load_of_a_million_on_light_rods_takes_few_substeps() {
    for (mass, hz) in [(1e4, 60.0), (1e6, 60.0), (1e6, 240.0), (1e6, 960.0)] {
        let [error, cuts] = swing_a_load(mass, hz);
        assert!(error < 2e-5, "{mass} kg at {hz} Hz: {error} of its energy strayed");
        assert!(cuts < 2.0, "{mass} kg at {hz} Hz: {cuts} cuts a step");
    }
}

/// Held at two posts further apart than it is long: no other method is to start from what its joints carried.
#[test]
fn what_was_not_settled_is_doubtful() {
    for (distance, is_held) in [(0.2, true), (3.0, false)] {
        let mut world = world(ExactIntegrator::Gauss, 60.0);
        let rod = body(&mut world, DVec3::ZERO, DQuat::IDENTITY, 1.0, DVec3::splat(0.01));
        for side in [-1.0, 1.0] {
            let post = pin(&mut world, DVec3::X * (0.5 * distance * side));
            let frames = [0.0, 0.1 * side].map(|x| Frame::at(Vector3::x() * x));
            world.spawn(JointDefinition { bodies: [post, rod], frames, translation: Laws::LOCKED, ..default() });
        }
        step(&mut world);
        assert_eq!(world.resource::<StepStats>().unsettled == 0, is_held, "{distance} m");
        let joints = &world.resource::<Joints>().list;
        assert_eq!(joints.len(), 2);
        assert!(joints.iter().all(|joint| joint.is_doubtful != is_held), "{distance} m");
    }
}
