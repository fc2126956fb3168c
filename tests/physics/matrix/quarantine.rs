//! A body whose state is not a number is put aside, and what touches it and what is joined to it goes on.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::QuarantineReason;
use plumb::prelude::*;

use super::ENGINES;
use super::Engine::{self, *};
use crate::rig::*;

/// How far what the frozen body holds up or is joined to may be from where it belongs a second later, m.
fn expected(engine: Engine) -> f64 {
    match engine {
        // A column trembles under friction along one tangent: measured 7 cm.
        Classic => 0.15,
        // Each of three interfaces sinks by the slop of 2 mm.
        Steady | Primed | Nonsmooth => 0.01,
        // Springs of 60 Hz give: measured 0.04 mm.
        Game => 2e-4,
        // Contacts settle within the slop of 5 mm.
        Sequential => 5e-3,
        // Without warm starting it creeps: measured 1.2 mm.
        Xpbd => 3e-3,
        // No gap is left open: measured 1.2e-12 m.
        Accurate => 1e-11,
    }
}

#[test]
fn what_is_not_a_number_is_put_aside_and_the_rest_goes_on() {
    for engine in ENGINES {
        let mut world = world_with(engine.settings());
        ground(&mut world);
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
        let [below, bad, above] = [0.5, 1.5, 2.5].map(|y| body(&mut world, cube.clone(), DVec3::Y * y));
        // Swings from the one in the middle, and would fall for ever without it.
        let hung = body(&mut world, Collider::sphere(0.2), DVec3::new(2.0, 1.5, 0.0));
        world.entity_mut(hung).insert(Mass(1.0));
        world.spawn(BallJoint::new(bad, hung).with_anchors(DVec3::X, -DVec3::X));
        let witness = body(&mut world, Collider::sphere(0.5), DVec3::new(100.0, 100.0, 0.0));
        run(&mut world, 0.5);
        take::<BodyQuarantined>(&mut world);
        let (place, falling) = (position(&world, bad), velocity(&world, witness).y);

        world.get_mut::<Velocity>(bad).unwrap().linear.y = f64::NAN;
        let mut told = Vec::new();
        for _ in 0..60 {
            step(&mut world);
            told.extend(take::<BodyQuarantined>(&mut world));
        }
        assert_eq!(told, [BodyQuarantined { entity: bad, reason: QuarantineReason::NotFinite }], "{engine:?}");
        assert_eq!(world.resource::<StepStats>().quarantined, 1, "{engine:?}");
        assert_eq!(position(&world, bad), place, "{engine:?}: frozen where it was");
        assert_close(velocity(&world, witness).y, falling - G, 1e-9);

        for (what, off) in [
            ("below", position(&world, below).distance(DVec3::Y * 0.5)),
            ("above", position(&world, above).distance(DVec3::Y * 2.5)),
            ("joined", (position(&world, hung).distance(place + DVec3::X) - 1.0).abs()),
        ] {
            assert!(off <= expected(engine), "{engine:?}: what is {what} is {off} m off");
        }
        assert!(velocity(&world, hung).length() > 0.1, "{engine:?}: what is joined stands still");
    }
}
