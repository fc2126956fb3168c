//! Collisions: restitution.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

fn bouncy(restitution: f64) -> SurfaceMaterial {
    SurfaceMaterial { friction: 0.0, restitution }
}

#[test]
fn a_ball_bounces_to_e_squared_of_its_height() {
    for e in [0.5, 0.8, 1.0] {
        let settings = SolverSettings { hz: 960.0, ..SolverSettings::steady() };
        let mut world = world_with(settings);
        ground(&mut world);
        let ball = body(&mut world, Collider::sphere(0.1), DVec3::Y * 5.0);
        world.entity_mut(ball).insert(bouncy(e));
        let (mut bounced, mut apex) = (false, 0.0);
        while !(bounced && velocity(&world, ball).y < 0.0) {
            step(&mut world);
            bounced |= velocity(&world, ball).y > 0.0;
            apex = position(&world, ball).y;
            assert!(world.resource::<StepStats>().time < 5.0, "it does not come back");
        }
        // It turns round up to v h = 1 cm below the surface, which it does not get back whole.
        let expected = 0.1 + 4.9 * e * e;
        assert_close(apex, expected, 0.02);
    }
}

#[test]
fn what_does_not_bounce_stays_down() {
    // It is found up to v h deep in the ground, and pushed out again without being thrown up.
    for height in [0.1, 0.5, 1.0, 3.0, 3.05, 3.1] {
        for (shape, radius) in [(Collider::cuboid(1.0, 1.0, 1.0), 0.5), (Collider::sphere(0.3), 0.3)] {
            let mut world = world_with(SolverSettings::steady());
            ground(&mut world);
            let dropped = body(&mut world, shape, DVec3::Y * (radius + height));
            let mut landed = false;
            for _ in 0..180 {
                step(&mut world);
                landed |= velocity(&world, dropped).y > -1e-3;
                let above = position(&world, dropped).y - radius;
                assert!(!landed || above < 2e-3, "dropped from {height} m it rises to {above} m");
            }
            assert!(landed);
        }
    }
}

#[test]
fn slow_approaches_do_not_bounce() {
    for (speed, rebound) in [(0.4, 0.0), (0.6, 0.6)] {
        let mut world = weightless(SolverSettings { slop: 0.0, ..SolverSettings::steady() });
        ground(&mut world);
        let ball = body(&mut world, Collider::sphere(0.1), DVec3::Y * 0.1);
        world.entity_mut(ball).insert((bouncy(1.0), Velocity { linear: DVec3::Y * -speed, ..default() }));
        run(&mut world, 0.2);
        assert_close(velocity(&world, ball).y, rebound, 1e-3);
    }
}

#[test]
fn a_head_on_collision_of_equals_exchanges_velocities() {
    let mut world = weightless(SolverSettings::steady());
    let first = body(&mut world, Collider::sphere(0.5), DVec3::X * -2.0);
    let second = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    world.entity_mut(first).insert((bouncy(1.0), Velocity { linear: DVec3::X * 4.0, ..default() }));
    world.entity_mut(second).insert(bouncy(1.0));
    run(&mut world, 1.0);
    // What overlap is left after the hit may be pushed out besides.
    assert_near(velocity(&world, first), DVec3::ZERO, 1e-3);
    assert_near(velocity(&world, second), DVec3::X * 4.0, 1e-3);
}
