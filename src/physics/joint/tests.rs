//! Joints of any definition under every method.

use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::definition::{Frame, Hold, JointDefinition, Laws};
use super::load::JointLoad;
use super::softness::Softness;
use crate::physics::body::{Inertia, LockedAxes, Mass, Position, Quarantined, RigidBody, Rotation, Velocity};
use crate::physics::joint::BodyState;
use crate::physics::settings::{Method, Precision, SolverSettings};
use crate::physics::testing::runge_kutta;
use crate::physics::{headless_app, step};

const G: f64 = 9.81;
const MASS: f64 = 2.0;
const INERTIA: DVec3 = DVec3::new(0.1, 0.2, 0.3);
/// From the hinge to the centre of mass, m.
const LENGTH: f64 = 0.6;

/// Each with how far a row may be off where bodies are thrown about, m or rad, and a pendulum of 240 Hz after a second,
/// rad: twice what was measured.
fn methods() -> [(SolverSettings, f64, f64); 6] {
    let f64_of = |settings: SolverSettings| SolverSettings { precision: Precision::F64, ..settings };
    [
        (f64_of(SolverSettings::classic()), 1.3e-2, 3.6e-3),
        (SolverSettings::steady(), 1e-3, 1e-3),
        (SolverSettings::game(), 3e-4, 2.2e-3),
        (SolverSettings::sequential_impulses(), 1e-3, 4e-2),
        (f64_of(SolverSettings::xpbd()), 6e-4, 4e-4),
        (SolverSettings::accurate(), 1e-10, 1e-9),
    ]
}

fn locked(hold: [bool; 3]) -> Laws {
    Laws { hold: hold.map(|is_locked| if is_locked { Hold::Locked } else { Hold::Free }), spring: None }
}

/// Of these laws, its x axes along the world's z, at the origin: a body whose centre is [`LENGTH`] away along x.
fn definition(bodies: [Entity; 2], translation: [bool; 3], rotation: [bool; 3]) -> JointDefinition {
    let rotation_of_frames = UnitQuaternion::rotation_between(&Vector3::x(), &Vector3::z()).unwrap();
    let frame = |anchor: Vector3<f64>| Frame { anchor, rotation: rotation_of_frames };
    JointDefinition {
        bodies,
        frames: [frame(Vector3::zeros()), frame(Vector3::x() * -LENGTH)],
        translation: locked(translation),
        rotation: locked(rotation),
        ..default()
    }
}

/// A post and a body that the joint holds to it.
fn held(settings: SolverSettings, translation: [bool; 3], rotation: [bool; 3]) -> (World, Entity, Entity) {
    let mut world = std::mem::take(headless_app().world_mut());
    world.insert_resource(settings);
    let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
    let at = Position(DVec3::X * LENGTH);
    let body = world.spawn((RigidBody::Dynamic, Mass(MASS), Inertia(INERTIA), at)).id();
    let joint = world.spawn((definition([post, body], translation, rotation), JointLoad::default())).id();
    (world, body, joint)
}

/// The largest row of all joints, m or rad.
fn error(world: &mut World) -> f64 {
    let joints: Vec<JointDefinition> = world.query::<&JointDefinition>().iter(world).cloned().collect();
    let state = |entity: Entity| BodyState {
        position: world.get::<Position>(entity).unwrap().0,
        rotation: world.get::<Rotation>(entity).unwrap().0,
        linear: world.get::<Velocity>(entity).unwrap().linear,
        angular: world.get::<Velocity>(entity).unwrap().angular,
    };
    let mut rows = Vec::new();
    for joint in joints {
        joint.rows_at(&joint.bodies.map(state), 0.0, &mut rows);
    }
    rows.iter().filter(|row| row.spring.is_none()).fold(0.0, |most: f64, row| most.max(row.error.abs()))
}

fn run(world: &mut World, seconds: f64) {
    let steps = (seconds * world.resource::<SolverSettings>().hz).round() as u32;
    (0..steps).for_each(|_| step(world));
}

const YES: [bool; 3] = [true; 3];
const NO: [bool; 3] = [false; 3];
const HINGE: [bool; 3] = [false, true, true];

#[test]
fn a_hinge_swings_as_its_equation_says() {
    // θ̈ = −m g L cos θ/(I_z + m L²), from level.
    let acceleration = |angle: f64| -MASS * G * LENGTH * angle.cos() / (INERTIA.z + MASS * LENGTH * LENGTH);
    let [angle, _] = runge_kutta([0.0; 2], 1.0, 10_000, |[angle, speed]| [speed, acceleration(angle)]);
    // What has a locked axis is swept by `game`, too.
    let swept = (SolverSettings::game(), 3e-4, 1.9e-2);
    let all = methods().map(|method| (method, false)).into_iter().chain([(swept, true)]);
    for ((settings, apart, most), is_locked) in all {
        let settings = SolverSettings { hz: 240.0, ..settings };
        let (mut world, body, joint) = held(settings, YES, HINGE);
        if is_locked {
            world.entity_mut(body).insert(LockedAxes { translation: [false, false, true], rotation: NO });
        }
        run(&mut world, 1.0);
        assert!(!world.entity(joint).contains::<Quarantined>());
        let at = world.get::<Position>(body).unwrap().0;
        let off = (DVec3::new(angle.cos(), angle.sin(), 0.0) * LENGTH - at).length() / LENGTH;
        let message = format!("{:?}: {off:.1e} rad, rows {:.1e}", settings.method, error(&mut world));
        println!("{message}");
        assert!(off < most && error(&mut world) < apart, "{message}");
    }
}

#[test]
fn joints_of_all_laws_hold_their_rows() {
    let laws = [
        ("ball", YES, NO),
        ("hinge", YES, HINGE),
        ("universal", YES, [false, true, false]),
        ("constant velocity", YES, [true, false, false]),
        ("fixed", YES, YES),
        ("slider", [false, true, true], YES),
        ("slider that turns", [false, true, true], HINGE),
        ("plane", [true, false, false], NO),
        ("rotation alone", NO, YES),
    ];
    for (settings, apart, _) in methods() {
        for (name, translation, rotation) in laws {
            let (mut world, body, joint) = held(settings, translation, rotation);
            // And one more after it, on the same joint.
            let at = Position(DVec3::X * (2.0 * LENGTH));
            let next = world.spawn((RigidBody::Dynamic, Mass(0.5 * MASS), Inertia(INERTIA), at)).id();
            world.spawn(definition([body, next], translation, rotation));
            world.get_mut::<Velocity>(body).unwrap().angular = DVec3::new(1.0, -1.0, 2.0);
            let mut worst = 0.0_f64;
            for _ in 0..30 {
                run(&mut world, 1.0 / 60.0);
                worst = worst.max(error(&mut world));
            }
            assert!(!world.entity(joint).contains::<Quarantined>());
            let message = format!("{:?}, {name}: {worst:.1e}", settings.method);
            println!("{message}");
            assert!(worst < apart, "{message}");
        }
    }
}

#[test]
fn a_beam_that_is_fixed_tells_its_load() {
    for (settings, ..) in methods() {
        let settings = SolverSettings { hz: 240.0, ..settings };
        let (mut world, _, joint) = held(settings, YES, YES);
        run(&mut world, 1.0);
        let load = world.get::<JointLoad>(joint).unwrap();
        let weight = MASS * G;
        let message = format!("{:?}: {load:?}", settings.method);
        println!("{message}");
        // What carries the weight at its end turns B about the anchor against it.
        let share = if settings.method == Method::ProjectedGaussSeidel { 0.05 } else { 0.02 };
        assert!((load.force - DVec3::Y * weight).length() < share * weight, "{message}");
        assert!((load.torque - DVec3::Z * (weight * LENGTH)).length() < share * weight, "{message}");
    }
}

#[test]
fn a_soft_hinge_gives_as_its_spring_says() {
    // Held as a beam, but with a spring against turning: where it rests ω² θ I = m g L cos θ, I the row's own mass
    // without the point's, and no more torque than the largest.
    for (settings, ..) in methods() {
        let spring = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: 1e3 };
        let (mut world, body, joint) = held(SolverSettings { hz: 240.0, ..settings }, YES, YES);
        world.get_mut::<JointDefinition>(joint).unwrap().rotation.spring = Some(spring);
        run(&mut world, 3.0);
        let at = world.get::<Position>(body).unwrap().0;
        let sag = -(at.y / LENGTH).asin();
        let omega = std::f64::consts::TAU * spring.frequency;
        let torque = omega * omega * INERTIA.z * 2.0 * (0.5 * sag).sin();
        let weight = MASS * G * LENGTH * sag.cos();
        let message = format!("{:?}: {sag:.4} rad, {torque:.3} N m, not {weight:.3}", settings.method);
        println!("{message}");
        assert!((torque - weight).abs() < 0.03 * weight, "{message}");
        world.get_mut::<JointDefinition>(joint).unwrap().rotation.spring = Some(Softness { max_force: 5.0, ..spring });
        run(&mut world, 0.05);
        let load = world.get::<JointLoad>(joint).unwrap().torque.length();
        assert!((load - 5.0).abs() < 0.01, "{:?}: {load} N m of 5", settings.method);
    }
}
