//! A joint that gives pulls with no more than its largest force, whatever the direction.

use bevy::math::DVec3;
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

#[test]
fn a_spring_pulls_with_its_largest_force_and_no_more() {
    const LARGEST: f64 = 3.0;
    const MASS: f64 = 2.0;
    for engine in ENGINES {
        let tolerance = expected(engine) * LARGEST;
        for direction in [DVec3::X, DVec3::ONE, DVec3::new(3.0, -2.0, 1.0)] {
            let direction = direction.normalize();
            let mut world = weightless(engine.settings());
            let post = world.spawn((RigidBody::Static, Position(direction * 100.0))).id();
            let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
            world.entity_mut(ball).insert(Mass(MASS));
            let softness = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: LARGEST };
            let joint = world.spawn((BallJoint::new(post, ball).with_softness(softness), JointLoad::default())).id();
            for _ in 0..60 {
                step(&mut world);
                let load = world.get::<JointLoad>(joint).unwrap().force;
                let along = load.length() - LARGEST;
                assert!(along.abs() <= tolerance, "{engine:?} along {direction}: a load of {load}, {along} N too much");
            }
            // Far away it pulls at its bound all the time.
            let gained = velocity(&world, ball) * MASS;
            let off = (gained - LARGEST * direction).length();
            assert!(off <= tolerance, "{engine:?} along {direction}: {gained} Ns in a second");
        }
    }
}
