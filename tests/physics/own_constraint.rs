//! A user's own constraint: a bead on a hoop that turns.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{AddConstraint, BodyState, Constraint, ConstraintRow, ConstraintRows, QuarantineReason};
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
    let h = 1e-4;
    let mut state = [std::f64::consts::FRAC_PI_2, 0.0];
    for _ in 0..(time / h).round() as u32 {
        let at = |slope: [f64; 2], by: f64| [state[0] + slope[0] * by, state[1] + slope[1] * by];
        let first = change(state);
        let second = change(at(first, h / 2.0));
        let third = change(at(second, h / 2.0));
        let last = change(at(third, h));
        for k in 0..2 {
            state[k] += h / 6.0 * (first[k] + 2.0 * second[k] + 2.0 * third[k] + last[k]);
        }
    }
    let (turned, angle) = (SPEED * time, state[0]);
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

/// A floor made of a row: it pushes the bead up, and holds nothing down.
#[derive(Component, Clone)]
struct Floor([Entity; 2]);

impl Constraint for Floor {
    fn bodies(&self) -> [Entity; 2] {
        self.0
    }

    fn rows(&self, [ground, bead]: &[BodyState; 2], _: f64) -> ConstraintRows {
        let error = bead.position.y - ground.position.y;
        [ConstraintRow { linear: [-DVec3::Y, DVec3::Y], error, bounds: (0.0, f64::INFINITY), ..default() }].into()
    }
}

#[test]
fn a_row_that_only_pushes_is_a_floor() {
    let classic = SolverSettings { precision: Precision::F64, ..SolverSettings::classic() };
    let impulse = [SolverSettings::game(), SolverSettings::sequential_impulses(), SolverSettings::xpbd()];
    for settings in impulse.into_iter().chain([classic, SolverSettings::steady()]) {
        start_pool();
        let mut app = headless_app();
        app.add_constraint::<Floor>();
        let mut world = std::mem::take(app.world_mut());
        world.insert_resource(settings);
        let ground = world.spawn((RigidBody::Static, Transform::default())).id();
        let bead = body(&mut world, Collider::sphere(0.1), DVec3::Y);
        world.entity_mut(bead).insert(Mass(2.0));
        let own = world.spawn((Floor([ground, bead]), JointLoad::default())).id();
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
fn impulse_methods_follow_it_too() {
    let (game, impulses, xpbd) =
        (SolverSettings::game(), SolverSettings::sequential_impulses(), SolverSettings::xpbd());
    for (settings, most) in [(game, 7e-4), (impulses, 7e-3), (xpbd, 2e-4)] {
        for precision in [Precision::F32, Precision::F64] {
            let errors = [240.0, 480.0].map(|hz| error_after(SolverSettings { hz, precision, ..settings }, 0.5));
            let message = format!("{:?} {precision:?}: {errors:?} m", settings.method);
            println!("{message}");
            // Of first order, with a tenth more than was measured.
            assert!(errors[0] < most && errors[1] < 0.6 * errors[0], "{message}");
        }
    }
}

#[test]
fn the_exact_method_holds_it_with_the_order_of_its_integrator() {
    // From about 1e-11 m on, rounding in the differences that make its velocity terms is more than the integrator's own
    // error.
    for (integrator, hz, order) in [(ExactIntegrator::Rattle, 480.0, 2.0), (ExactIntegrator::Gauss, 20.0, 6.0)] {
        let exact = ExactSettings { integrator };
        let errors =
            [hz, 2.0 * hz].map(|hz| error_after(SolverSettings { hz, exact, ..SolverSettings::accurate() }, 0.5));
        let found = (errors[0] / errors[1]).log2();
        println!("{integrator:?}: {errors:?} m");
        // Steps long enough for that are too long for the order to a digit.
        assert!((found - order).abs() < 0.6, "{integrator:?}: order {found} from {errors:?} m");
    }
    // As the preset comes, at 60 Hz.
    let error = error_after(SolverSettings { hz: 60.0, ..SolverSettings::accurate() }, 0.5);
    assert!(error < 1e-10, "{error} m");
}

/// A plate that goes up and down without turning.
#[derive(Component, Clone)]
struct Lift {
    base: Entity,
    plate: Entity,
}

impl Lift {
    /// Of half the way, m.
    const WAY: f64 = 0.1;
    /// rad/s.
    const PACE: f64 = 6.0;

    fn height(time: f64) -> f64 {
        Self::WAY * (1.0 - (Self::PACE * time).cos())
    }

    fn acceleration(time: f64) -> f64 {
        Self::WAY * Self::PACE * Self::PACE * (Self::PACE * time).cos()
    }
}

impl Constraint for Lift {
    fn bodies(&self) -> [Entity; 2] {
        [self.base, self.plate]
    }

    fn rows(&self, [base, plate]: &[BodyState; 2], time: f64) -> ConstraintRows {
        let apart = plate.position - base.position - DVec3::Y * Self::height(time);
        let rate = Self::WAY * Self::PACE * (Self::PACE * time).sin();
        let place = |axis: DVec3| ConstraintRow {
            linear: [-axis, axis],
            error: axis.dot(apart),
            time_rate: -axis.y * rate,
            ..default()
        };
        // Of small turns.
        let turn = |axis: DVec3| ConstraintRow {
            angular: [-axis, axis],
            error: 2.0 * axis.dot(plate.rotation.xyz() - base.rotation.xyz()),
            ..default()
        };
        let [x, y, z] = DVec3::AXES;
        [place(x), place(y), place(z), turn(x), turn(y), turn(z)].into()
    }
}

#[test]
fn what_moves_in_time_carries_what_lies_on_it() {
    start_pool();
    let mut app = headless_app();
    app.add_constraint::<Lift>();
    let mut world = std::mem::take(app.world_mut());
    let settings = SolverSettings { hz: 240.0, ..SolverSettings::accurate() };
    world.insert_resource(settings);
    let base = world.spawn((RigidBody::Static, Transform::default())).id();
    let plate = body(&mut world, Collider::cuboid(2.0, 0.2, 2.0), DVec3::ZERO);
    let load = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::new(0.25, 0.6, 0.0));
    world.entity_mut(plate).insert(Mass(3.0));
    world.entity_mut(load).insert(Mass(2.0));
    let own = world.spawn((Lift { base, plate }, JointLoad::default())).id();
    for index in 0..240 {
        step(&mut world);
        let time = f64::from(index + 1) / 240.0;
        let carried = *world.get::<JointLoad>(own).unwrap();
        // Mean of a second-order step: (ωh)²/24 of the acceleration off.
        let up = G + Lift::acceleration(time - 0.5 / 240.0);
        assert_near(carried.force, DVec3::Y * (5.0 * up), 5e-3);
        assert_near(carried.torque, DVec3::new(0.25, 0.6, 0.0).cross(DVec3::Y * (2.0 * up)), 1e-2);
        assert_near(position(&world, plate), DVec3::Y * Lift::height(time), 1e-9);
        assert_near(position(&world, load) - position(&world, plate), DVec3::new(0.25, 0.6, 0.0), 1e-9);
    }
}

#[test]
fn methods_that_cannot_hold_it_say_so() {
    // The exact method has no rows of a user's own that push only.
    let settings = SolverSettings::accurate();
    let (mut world, _, own) = hoop(settings, (0.0, f64::INFINITY));
    step(&mut world);
    let reason = world.get::<Quarantined>(own).map(|quarantined| quarantined.reason);
    assert_eq!(reason, Some(QuarantineReason::NotOfMethod), "{:?}", settings.method);
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
