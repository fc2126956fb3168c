//! A user's own constraint: a bead on a hoop that turns.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{AddConstraint, BodyState, Constraint, ConstraintRow, ConstraintRows};
use plumb::prelude::*;

use crate::rig::*;

const RADIUS: f64 = 0.8;
/// Of the hoop about the vertical axis, rad/s.
const SPEED: f64 = 6.0;

#[derive(Component, Clone)]
struct OnHoop {
    hub: Entity,
    bead: Entity,
    bounds: (f64, f64),
}

impl Constraint for OnHoop {
    fn bodies(&self) -> [Entity; 2] {
        [self.hub, self.bead]
    }

    fn rows(&self, [hub, bead]: &[BodyState; 2], time: f64) -> ConstraintRows {
        let (sin, cos) = (SPEED * time).sin_cos();
        let from_hub = bead.position - hub.position;
        let normal = DVec3::new(-sin, 0.0, cos);
        let turning = DVec3::new(-cos, 0.0, -sin) * SPEED;
        let outwards = from_hub.normalize();
        [
            ConstraintRow {
                linear: [-normal, normal],
                error: normal.dot(from_hub),
                time_rate: turning.dot(from_hub),
                bounds: self.bounds,
                ..default()
            },
            ConstraintRow { linear: [-outwards, outwards], error: from_hub.length() - RADIUS, ..default() },
        ]
        .into()
    }
}

/// A world with a bead of 2 kg that starts with the hoop, a quarter of its circle above the lowest point.
fn hoop(settings: SolverSettings, bounds: (f64, f64)) -> (World, Entity, Entity) {
    start_pool();
    let mut app = headless_app();
    app.add_constraint::<OnHoop>();
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(settings);
    let hub = world.spawn((RigidBody::Static, Transform::default())).id();
    let bead = body(&mut world, Collider::sphere(0.1), DVec3::X * RADIUS);
    let moving = Velocity { linear: DVec3::Z * (SPEED * RADIUS), ..default() };
    world.entity_mut(bead).insert((Mass(2.0), moving));
    let own = world.spawn((OnHoop { hub, bead, bounds }, JointLoad::default())).id();
    (world, bead, own)
}

/// Where the bead is after a time: θ from the lowest point, θ̈ = (ω² cos θ − g/R) sin θ, by the classical Runge–Kutta
/// method in steps of 0.1 ms, 1e-13 off.
fn truth(time: f64) -> DVec3 {
    let change = |[angle, speed]: [f64; 2]| [speed, (SPEED * SPEED * angle.cos() - G / RADIUS) * angle.sin()];
    let [angle, _] = runge_kutta([std::f64::consts::FRAC_PI_2, 0.0], time, (time * 1e4).round() as u32, change);
    let turned = SPEED * time;
    DVec3::new(angle.sin() * turned.cos(), -angle.cos(), angle.sin() * turned.sin()) * RADIUS
}

const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn force_level() -> [SolverSettings; 3] {
    [Method::ProjectedGaussSeidel, Method::PrimedGaussSeidel, Method::NonsmoothConjugateGradient]
        .map(|method| SolverSettings { method, ..SolverSettings::steady() })
}

fn error_after(settings: SolverSettings, seconds: f64) -> f64 {
    let (mut world, bead, _) = hoop(settings, ANY);
    run(&mut world, seconds);
    (position(&world, bead) - truth(seconds)).length()
}

#[test]
fn a_bead_on_a_hoop_that_turns_follows_its_equation() {
    let classic = SolverSettings { precision: Precision::F64, ..SolverSettings::classic() };
    for settings in force_level().into_iter().chain([classic]) {
        let errors = [240.0, 480.0].map(|hz| error_after(SolverSettings { hz, ..settings }, 0.5));
        let message = format!("{:?}: {errors:?} m", settings.method);
        println!("{message}");
        // Of first order in the step, as these methods are: both rows are independent, so a few sweeps solve them.
        assert!(errors[0] < 0.1 && errors[1] < 0.65 * errors[0], "{message}");
    }
}

#[test]
fn its_load_is_what_the_rows_carry() {
    let settings = SolverSettings { precision: Precision::F64, iterations: 50, ..SolverSettings::classic() };
    let (mut world, bead, own) = hoop(settings, ANY);
    let before = velocity(&world, bead);
    step(&mut world);
    let load = *world.get::<JointLoad>(own).unwrap();
    // Mass times the velocity gained, less the weight: the solve to 50 sweeps, drag none.
    let gained = (velocity(&world, bead) - before) * world.resource::<SolverSettings>().hz;
    assert_near(load.force, (gained + DVec3::Y * G) * 2.0, 1e-6);
    assert_eq!(load.torque, DVec3::ZERO);
    assert!((load.lambda - load.force.length()).abs() < 1e-12);
}

#[test]
fn its_bounds_bound_what_it_carries() {
    let impulse = [SolverSettings::game(), SolverSettings::sequential_impulses(), SolverSettings::xpbd()];
    for settings in impulse.into_iter().chain([SolverSettings::classic()]) {
        // One substep, so that both rows have one direction a step.
        let settings = SolverSettings { precision: Precision::F64, substeps: 1, ..settings };
        let (mut world, bead, own) = hoop(settings, (-0.5, 0.5));
        steps(&mut world, 12);
        let outwards = position(&world, bead).normalize();
        step(&mut world);
        let load = world.get::<JointLoad>(own).unwrap().force;
        // Across the hoop's radius acts the row with the bounds alone, nearly square to it; by then the Coriolis force is
        // some newtons.
        let across = (load - outwards * load.dot(outwards)).length();
        assert!((0.35..0.5 + 1e-9).contains(&across), "{:?}: {across} N", settings.method);
    }
}

/// Rows of a bead's place: along an axis each, with how far it is from there, and bounds.
#[derive(Component, Clone)]
struct Held {
    bodies: [Entity; 2],
    /// Unit axis, place along it, bounds.
    rows: Vec<(DVec3, f64, (f64, f64))>,
}

impl Constraint for Held {
    fn bodies(&self) -> [Entity; 2] {
        self.bodies
    }

    fn rows(&self, [ground, bead]: &[BodyState; 2], _: f64) -> ConstraintRows {
        let rows: Vec<ConstraintRow> = self
            .rows
            .iter()
            .map(|&(axis, place, bounds)| {
                let error = axis.dot(bead.position - ground.position) - place;
                ConstraintRow { linear: [-axis, axis], error, bounds, ..default() }
            })
            .collect();
        match rows[..] {
            [one] => [one].into(),
            [one, other] => [one, other].into(),
            _ => unreachable!("one or two"),
        }
    }
}

/// A bead of 2 kg at a place, held so.
fn held(settings: SolverSettings, at: DVec3, rows: Vec<(DVec3, f64, (f64, f64))>) -> (World, Entity, Entity) {
    start_pool();
    let mut app = headless_app();
    app.add_constraint::<Held>();
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(settings);
    let ground = world.spawn((RigidBody::Static, Transform::default())).id();
    let bead = body(&mut world, Collider::sphere(0.1), at);
    world.entity_mut(bead).insert(Mass(2.0));
    let own = world.spawn((Held { bodies: [ground, bead], rows }, JointLoad::default())).id();
    (world, bead, own)
}

fn with_bounds() -> [SolverSettings; 6] {
    let classic = SolverSettings { precision: Precision::F64, ..SolverSettings::classic() };
    let impulse = [SolverSettings::game(), SolverSettings::sequential_impulses(), SolverSettings::xpbd()];
    let [game, impulses, xpbd] = impulse;
    [game, impulses, xpbd, classic, SolverSettings::steady(), SolverSettings::accurate()]
}

const PUSHES: (f64, f64) = (0.0, f64::INFINITY);

#[test]
fn a_row_that_only_pushes_is_a_floor() {
    for settings in with_bounds() {
        let (mut world, bead, own) = held(settings, DVec3::Y, vec![(DVec3::Y, 0.0, PUSHES)]);
        // It falls freely, to the share that a step of first order is off.
        run(&mut world, 0.3);
        let fallen = 1.0 - position(&world, bead).y;
        assert!((fallen - 0.5 * G * 0.09).abs() < 0.07 * fallen, "{:?}: {fallen} m", settings.method);
        let lowest = (0..60).map(|_| {
            step(&mut world);
            position(&world, bead).y
        });
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        assert!(lowest > -0.05 && world.get::<JointLoad>(own).unwrap().force.y >= 0.0, "{:?}", settings.method);
        run(&mut world, 1.0);
        let (at, load) = (position(&world, bead).y, world.get::<JointLoad>(own).unwrap().force.y);
        println!("{:?}: lowest {lowest:.1e} m, then {at:.1e} m with {load:.3} N", settings.method);
        assert!(at.abs() < 2e-3 && (load - 2.0 * G).abs() < 0.02 * G, "{:?}: {at} m, {load} N", settings.method);
        // Thrown up, it flies.
        world.get_mut::<Velocity>(bead).unwrap().linear.y = 2.0;
        run(&mut world, 0.1);
        assert!(position(&world, bead).y > 0.1, "{:?}", settings.method);
    }
}

#[test]
fn a_row_that_has_no_force_leaves_the_others_alone() {
    // At rest at a height, and half a metre above a slope, to which no row pulls.
    let slope = DVec3::new(0.6, 0.8, 0.0);
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    for settings in with_bounds() {
        let (mut world, bead, own) = held(settings, DVec3::ZERO, vec![(DVec3::Y, 0.0, any), (slope, -0.5, PUSHES)]);
        run(&mut world, 0.5);
        let (at, load) = (position(&world, bead), world.get::<JointLoad>(own).unwrap().force);
        assert!(at.length() < 1e-3, "{:?}: {at}", settings.method);
        assert!((load - DVec3::Y * (2.0 * G)).length() < 0.02 * G, "{:?}: {load}", settings.method);
    }
}

#[test]
fn what_is_too_weak_to_hold_gives_way() {
    for settings in with_bounds() {
        let (mut world, bead, own) = held(settings, DVec3::ZERO, vec![(DVec3::Y, 0.0, (-5.0, 5.0))]);
        run(&mut world, 0.5);
        let (fallen, load) = (-position(&world, bead).y, world.get::<JointLoad>(own).unwrap().force);
        let expected = 0.5 * (G - 2.5) * 0.25;
        assert!((fallen - expected).abs() < 0.05 * expected, "{:?}: {fallen} m, not {expected}", settings.method);
        assert!((load - DVec3::Y * 5.0).length() < 1e-3, "{:?}: {load}", settings.method);
    }
}

#[test]
fn bounds_that_make_no_sense_are_no_panic() {
    for bounds in [(1.0, -1.0), (f64::NAN, 3.0), (-3.0, f64::NAN), (f64::INFINITY, f64::NEG_INFINITY)] {
        for settings in with_bounds() {
            let (mut world, bead, _) = held(settings, DVec3::ZERO, vec![(DVec3::Y, 0.0, bounds)]);
            steps(&mut world, 3);
            assert!(position(&world, bead).is_finite(), "{:?}: {bounds:?}", settings.method);
        }
    }
}

#[test]
fn a_constraint_in_the_place_of_a_joint_is_taken_for_what_it_is() {
    for settings in with_bounds() {
        let (mut world, bead, own) = held(settings, DVec3::Y, vec![(DVec3::Y, 0.0, PUSHES)]);
        let held_so = world.get::<Held>(own).unwrap().clone();
        world.entity_mut(own).despawn();
        let ball = BallJoint::new(held_so.bodies[0], bead).with_anchors(DVec3::Y, DVec3::ZERO);
        let ball = world.spawn(ball).id();
        run(&mut world, 0.2);
        assert!((position(&world, bead) - DVec3::Y).length() < 0.02, "{:?}", settings.method);
        // In one and the same step.
        world.entity_mut(ball).despawn();
        world.spawn(held_so);
        run(&mut world, 1.5);
        let at = position(&world, bead);
        assert!(at.y.abs() < 0.02, "{:?}: {at}", settings.method);
    }
}

#[test]
fn joint_space_holds_several_of_two_rows() {
    let settings = SolverSettings { method: Method::JointSpace, ..SolverSettings::steady() };
    let (mut world, bead, own) = hoop(settings, ANY);
    let other = body(&mut world, Collider::sphere(0.1), DVec3::NEG_X * RADIUS);
    let moving = Velocity { linear: DVec3::NEG_Z * (SPEED * RADIUS), ..default() };
    world.entity_mut(other).insert((Mass(1.0), moving));
    let first = world.get::<OnHoop>(own).unwrap().clone();
    world.spawn(OnHoop { bead: other, ..first });
    run(&mut world, 0.5);
    let (expected, mirrored) = (truth(0.5), truth(0.5) * DVec3::new(-1.0, 1.0, -1.0));
    let errors = [(bead, expected), (other, mirrored)].map(|(bead, truth)| (position(&world, bead) - truth).length());
    assert!(errors.into_iter().all(|error| error < 0.1), "{errors:?} m");
}

#[test]
fn taken_off_it_holds_no_more() {
    let (mut world, bead, own) = hoop(SolverSettings { precision: Precision::F64, ..SolverSettings::classic() }, ANY);
    step(&mut world);
    world.entity_mut(own).remove::<OnHoop>();
    step(&mut world);
    let before = velocity(&world, bead);
    step(&mut world);
    let fallen = DVec3::NEG_Y * (G / world.resource::<SolverSettings>().hz);
    assert_near(velocity(&world, bead) - before, fallen, 1e-12);
}
