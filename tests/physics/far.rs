//! A scene 10 000 km away moves as at the origin.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

/// A pendulum, a box that lands on another, and a ball that rolls; `origin` is where it all is.
fn scene(settings: SolverSettings, origin: DVec3) -> (World, Vec<Entity>) {
    let mut world = world_with(settings);
    world.spawn((RigidBody::Static, Collider::half_space(), Position(origin)));
    let post = world.spawn((RigidBody::Static, Position(origin + DVec3::new(5.0, 2.0, 0.0)))).id();
    let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), origin + DVec3::new(5.5, 2.0, 0.0));
    world.spawn(BallJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::X * -0.5));
    let below = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), origin + DVec3::Y * 0.5);
    let above = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), origin + DVec3::new(0.25, 1.625, 0.125));
    let ball = body(&mut world, Collider::sphere(0.5), origin + DVec3::new(-4.0, 0.5, 0.0));
    world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::new(-3.0, 0.0, 1.0);
    (world, vec![rod, below, above, ball])
}

#[test]
fn ten_thousand_kilometres_away_all_moves_as_at_the_origin() {
    for settings in [SolverSettings::steady(), SolverSettings::game()] {
        moves_as_at_the_origin(settings);
    }
}

fn moves_as_at_the_origin(settings: SolverSettings) {
    // Not along an axis, and exact in f64 together with the scene's own coordinates.
    let far = DVec3::new(8e6, -4e6, 5e6);
    let ((mut near_world, near), (mut far_world, distant)) = (scene(settings, DVec3::ZERO), scene(settings, far));
    for _ in 0..60 {
        step(&mut near_world);
        step(&mut far_world);
        for (&here, &there) in near.iter().zip(&distant) {
            assert_near(position(&far_world, there) - far, position(&near_world, here), 1e-5);
        }
    }
    let moved = near.iter().map(|&body| velocity(&near_world, body).length()).fold(0.0, f64::max);
    assert!(moved > 1.0, "a scene at rest proves nothing");
}
