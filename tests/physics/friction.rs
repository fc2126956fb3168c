//! Coulomb friction against closed forms.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

const G: f64 = 9.81;

/// Level ground under gravity turned by an angle, and a box at rest on it.
fn incline(degrees: f64) -> (World, Entity) {
    let mut world = world_with(SolverSettings::steady());
    let (sin, cos) = degrees.to_radians().sin_cos();
    world.insert_resource(Gravity(DVec3::new(sin, -cos, 0.0) * G));
    ground(&mut world);
    let slider = body(&mut world, Collider::cuboid(2.0, 0.5, 1.0), DVec3::Y * 0.25);
    (world, slider)
}

#[test]
fn a_box_sticks_to_an_incline_flatter_than_its_friction() {
    // tan 30° = 0.577 < 0.6.
    for degrees in [10.0, 20.0, 30.0] {
        let (mut world, slider) = incline(degrees);
        run(&mut world, 2.0);
        // It settles into the slop of 2 mm and no more.
        assert!(position(&world, slider).x.abs() < 2e-3, "{degrees}°: {}", position(&world, slider).x);
    }
}

#[test]
fn a_box_slides_down_a_steeper_incline() {
    // tan 32° = 0.625 > 0.6.
    for degrees in [32.0_f64, 40.0, 60.0] {
        let (mut world, slider) = incline(degrees);
        run(&mut world, 1.0);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let acceleration = G * (sin - 0.6 * cos);
        // Euler is ½ a t h early, h = 1/240 s; another 1 % of m g sin θ for the solver.
        let tolerance = acceleration / 480.0 + 0.01 * 0.5 * G * sin;
        assert_close(position(&world, slider).x, 0.5 * acceleration, tolerance);
        assert_close(velocity(&world, slider).x, acceleration, 0.01 * G * sin);
    }
}

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

/// A box thrown along the ground goes on as it was thrown, whatever the method.
#[test]
fn without_friction_nothing_slows_down() {
    for settings in every_method() {
        let mut world = world_with(SolverSettings { friction: FrictionModel::Off, ..settings });
        ground(&mut world);
        let slider = body(&mut world, Collider::cuboid(1.0, 0.5, 1.0), DVec3::Y * 0.25);
        let thrown = DVec3::new(3.0, 0.0, 0.5);
        world.entity_mut(slider).insert(Velocity { linear: thrown, ..default() });
        run(&mut world, 1.0);
        // Normals are level to rounding in `f32`, 1e-7 of what carries the weight in each of up to 480 solves.
        let left = velocity(&world, slider).with_y(0.0);
        assert!((left - thrown).length() < 1e-4, "{:?}: {left} m/s", settings.method);
        assert_near(spin(&world, slider), DVec3::ZERO, 1e-3);
    }
}

#[test]
fn without_friction_nothing_holds() {
    let (mut world, slider) = incline(20.0);
    world.resource_mut::<SolverSettings>().friction = FrictionModel::Off;
    run(&mut world, 1.0);
    let acceleration = G * 20.0_f64.to_radians().sin();
    assert_close(velocity(&world, slider).x, acceleration, 1e-3);
}
