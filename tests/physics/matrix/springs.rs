//! A joint that gives pulls with no more than its largest force, whatever the direction.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use super::ENGINES;
use super::Engine::{self, *};
use crate::rig::*;

/// How far force and change of velocity may be off, in shares of the largest force.
fn expected(engine: Engine) -> f64 {
    match engine {
        // The bound is met in f32, and the velocities of 60 to 480 substeps add what each rounds: measured 3e-6.
        Classic | Steady | Primed | Nonsmooth | Game | Sequential | Xpbd => 2e-5,
        // f64 throughout.
        Accurate => 1e-12,
    }
}

/// Every method, and the other integrator of the exact one: they bound a spring each by itself.
fn ways() -> impl Iterator<Item = (Engine, SolverSettings)> {
    let exact = ExactSettings { integrator: ExactIntegrator::Rattle, time_budget: None };
    let rattle = SolverSettings { exact, ..Accurate.settings() };
    ENGINES.into_iter().map(|engine| (engine, engine.settings())).chain([(Accurate, rattle)])
}

/// A soft joint from an immovable point to a body's anchor.
fn pull(world: &mut World, from: DVec3, body: Entity, anchor: DVec3, max_force: f64) -> Entity {
    let hand = world.spawn((RigidBody::Static, Position(from))).id();
    let softness = Softness { frequency: 4.0, damping_ratio: 1.0, max_force };
    let joint = BallJoint::new(hand, body).with_anchors(DVec3::ZERO, anchor).with_softness(softness);
    world.spawn((joint, JointLoad::default())).id()
}

/// A spring far beyond its largest force pulls with that, as a vector: along its stretch, no harder aslant than along
/// an axis.
#[test]
fn a_spring_pulls_with_its_largest_force_and_no_more() {
    const LARGEST: f64 = 3.0;
    const MASS: f64 = 2.0;
    for (engine, settings) in ways() {
        let tolerance = expected(engine) * LARGEST;
        for along in [DVec3::X, DVec3::ONE, DVec3::new(3.0, -2.0, 1.0)] {
            let along = along.normalize();
            let case = format!("{engine:?}, {:?}, along {along}", settings.exact.integrator);
            let mut world = weightless(settings);
            let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
            world.entity_mut(ball).insert(Mass(MASS));
            let joint = pull(&mut world, along * 1e3, ball, DVec3::ZERO, LARGEST);
            for _ in 0..60 {
                step(&mut world);
                let load = world.get::<JointLoad>(joint).unwrap();
                assert!((load.force - LARGEST * along).length() <= tolerance, "{case}: {} N", load.force);
                assert!((load.lambda - LARGEST).abs() <= tolerance, "{case}: {} N", load.lambda);
            }
            // Within its reach it pulls at its bound all the time; kicks by halves are one of them behind.
            let behind =
                if settings.exact.integrator == ExactIntegrator::Rattle { 0.5 * LARGEST / settings.hz } else { 0.0 };
            let gained = velocity(&world, ball) * MASS;
            assert!((gained - LARGEST * along).length() <= tolerance + behind, "{case}: {gained} Ns in a second");
        }
    }
}

/// Also one that hangs on a body's end and turns it, and one on what rests on the ground.
#[test]
fn the_largest_force_bounds_springs_on_what_turns_and_on_what_rests() {
    for (_, settings) in ways() {
        let mut world = weightless(settings);
        let rod = body(&mut world, Collider::cuboid(1.0, 0.2, 0.1), DVec3::ZERO);
        world.entity_mut(rod).insert(Mass(1.0));
        let turning = pull(&mut world, DVec3::new(400.0, 500.0, -300.0), rod, DVec3::X * 0.5, 2.0);
        let mut least = f64::INFINITY;
        for _ in 0..30 {
            step(&mut world);
            let lambda = world.get::<JointLoad>(turning).unwrap().lambda;
            // A mean over a step in which the direction turns a little is a little less.
            assert!(lambda < 2.0 * (1.0 + 1e-5), "{:?}, {:?}: {lambda} N", settings.method, settings.exact.integrator);
            least = least.min(lambda);
        }
        assert!(least > 1.98, "{:?}, {:?}: {least} N", settings.method, settings.exact.integrator);

        let impulse = ImpulseSettings { sleep_speed: None, ..settings.impulse };
        let mut world = world_with(SolverSettings { impulse, ..settings });
        ground(&mut world);
        let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
        world.entity_mut(cube).insert(Mass(2.0));
        let along = DVec3::new(2.0, 1.0, -2.0) / 3.0;
        // 3 N aslant: friction holds with 0.6 (19.6 N − 1 N).
        let resting = pull(&mut world, along * 1e3, cube, DVec3::ZERO, 3.0);
        run(&mut world, 1.0);
        let load = world.get::<JointLoad>(resting).unwrap().force;
        // The cube has its centre half a metre of a kilometre above where the spring was laid out.
        assert!((load - along * 3.0).length() < 3e-3, "{:?}: {load} N", settings.method);
    }
}
