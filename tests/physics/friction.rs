//! Coulomb friction against closed forms.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

#[test]
fn a_thrown_ball_slides_and_then_rolls_at_five_sevenths() {
    let mut world = world_with(SolverSettings::steady());
    let surface = SurfaceMaterial { friction: 0.3, ..default() };
    let floor = ground(&mut world);
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::Y * 0.5);
    world.entity_mut(floor).insert(surface);
    world.entity_mut(ball).insert((surface, Velocity { linear: DVec3::X * 5.0, ..default() }));
    run(&mut world, 0.4);
    // Sliding until t* = 2v₀/(7μg) = 0.485 s.
    assert_close(velocity(&world, ball).x, 5.0 - 0.3 * G * 0.4, 0.02);
    run(&mut world, 0.6);
    assert_close(velocity(&world, ball).x, 25.0 / 7.0, 0.01);
    assert_close(spin(&world, ball).z, -25.0 / 7.0 / 0.5, 0.05);
}

#[test]
fn two_tangent_friction_is_the_same_in_every_direction() {
    let stopping = |degrees: f64, turned: f64| {
        let mut world = world_with(SolverSettings::steady());
        ground(&mut world);
        let slider = body(&mut world, Collider::cuboid(1.0, 0.2, 1.0), DVec3::Y * 0.1);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let velocity = Velocity { linear: DVec3::new(cos, 0.0, sin) * 4.0, ..default() };
        world.entity_mut(slider).insert((velocity, Rotation(DQuat::from_rotation_y(turned))));
        run(&mut world, 1.5);
        assert_close(world.get::<Velocity>(slider).unwrap().linear.length(), 0.0, 1e-3);
        let way = position(&world, slider).with_y(0.0);
        assert_close(way.dot(DVec3::new(-sin, 0.0, cos)), 0.0, 0.02);
        way.length()
    };
    // v²/(2 μ g)
    let expected = 16.0 / (2.0 * 0.6 * G);
    for degrees in [0.0, 30.0, 45.0, 90.0] {
        assert_close(stopping(degrees, 0.0), expected, 0.02 * expected);
        assert_close(stopping(degrees, 0.4), expected, 0.02 * expected);
    }
}
