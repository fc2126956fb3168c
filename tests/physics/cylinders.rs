//! Cylinders: how they roll, slip, stand, fall and are stopped.

use std::f64::consts::FRAC_PI_2;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

const RADIUS: f64 = 0.25;
const HEIGHT: f64 = 0.5;

fn cylinder(world: &mut World, at: DVec3, turned: DQuat) -> Entity {
    let own = body(world, Collider::cylinder(RADIUS, HEIGHT), at);
    world.entity_mut(own).insert(Rotation(turned));
    own
}

#[test]
fn volume_and_moments_are_the_closed_forms() {
    let of_mass = Collider::cylinder(2.0, 3.0).mass_properties_of_mass(10.0);
    // Axis m r²/2; across m (3 r² + h²)/12.
    assert_eq!((of_mass.mass, of_mass.inertia), (10.0, DVec3::new(17.5, 20.0, 17.5)));
    assert_close(Collider::cylinder(2.0, 3.0).volume(), 12.0 * std::f64::consts::PI, 1e-12);
}

/// With a slope's angle θ and a friction μ it rolls with 2/3 g sin θ as long as tan θ ≤ 3 μ, else its middle slides with
/// g (sin θ − μ cos θ).
#[test]
fn it_rolls_down_a_slope_or_slips_as_its_friction_says() {
    let slope = 30.0_f64.to_radians();
    for (name, settings) in presets() {
        if name == "classic" {
            continue; // a polygon
        }
        for friction in [0.5, 0.22, 0.1] {
            let mut world = world_with(settings);
            world.insert_resource(Gravity(DVec3::new(slope.sin(), -slope.cos(), 0.0) * G));
            let material = SurfaceMaterial { friction, ..default() };
            let ground = ground(&mut world);
            world.entity_mut(ground).insert(material);
            let own = cylinder(&mut world, DVec3::Y * RADIUS, DQuat::from_rotation_x(FRAC_PI_2));
            world.entity_mut(own).insert(material);
            run(&mut world, 2.0);
            let rolls = slope.tan() <= 3.0 * friction;
            let expected = if rolls { 2.0 / 3.0 * G * slope.sin() } else { G * (slope.sin() - friction * slope.cos()) };
            let found = velocity(&world, own).x / 2.0;
            assert!((found / expected - 1.0).abs() < 0.01, "{name}, μ = {friction}: {found} m/s², not {expected}");
            let aside = position(&world, own).z.abs();
            assert!(aside < 1e-3, "{name}, μ = {friction}: {aside} m aside");
        }
    }
}

#[test]
fn one_that_stood_falls_over_without_a_gain_and_lies() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        world.init_resource::<Diagnostics>();
        ground(&mut world);
        let (radius, height) = (0.15, 1.0);
        let lean = DQuat::from_rotation_z(-0.32); // its middle is beyond its rim
        let own = body(&mut world, Collider::cylinder(radius, height), DVec3::Y * 0.53);
        world.entity_mut(own).insert(Rotation(lean));
        step(&mut world);
        let mass = world.get::<Mass>(own).unwrap().0;
        // The pushing apart of classic works on what it pushes.
        let gain = |most: f64| if name == "classic" { 0.05 * most } else { 0.02 * mass * G * 0.2 };
        assert_gains_nothing(&mut world, 480, name, gain);
        let lies = position(&world, own).y;
        // The polygon that stands for it in classic is narrower.
        assert!((lies - radius).abs() < if name == "classic" { 0.03 } else { 5e-3 }, "{name}: {lies}");
    }
}

#[test]
fn columns_and_rollers_stay_where_they_are() {
    for (name, settings) in presets() {
        if name == "classic" {
            continue; // a polygon rocks
        }
        let mut world = world_with(settings);
        ground(&mut world);
        let mut all = Vec::new();
        for layer in 0..4 {
            all.push(cylinder(&mut world, DVec3::Y * (HEIGHT * (f64::from(layer) + 0.5)), DQuat::IDENTITY));
        }
        // A roller between two others would part them: three in a trough of boxes.
        for side in [-1.0, 1.0] {
            let wall = world.spawn((RigidBody::Static, Collider::cuboid(0.2, 1.0, 2.0))).id();
            world.entity_mut(wall).insert(Position(DVec3::new(3.0 + side * 0.6, 0.5, 0.0)));
            let lying = DQuat::from_rotation_x(FRAC_PI_2);
            all.push(cylinder(&mut world, DVec3::new(3.0 + side * RADIUS, RADIUS, 0.0), lying));
        }
        let top = RADIUS * (1.0 + 3_f64.sqrt());
        all.push(cylinder(&mut world, DVec3::new(3.0, top, 0.0), DQuat::from_rotation_x(FRAC_PI_2)));
        let starts: Vec<_> = all.iter().map(|&own| position(&world, own)).collect();
        run(&mut world, 4.0);
        // The springs of steady give way under four more than under one.
        let most = if name == "steady" { 1e-2 } else { 5e-3 };
        for (&own, start) in all.iter().zip(&starts) {
            let moved = position(&world, own).distance(*start);
            assert!(moved < most, "{name}: {moved} m from {start}");
        }
    }
}

#[test]
fn none_that_is_shot_passes_a_sheet() {
    assert_none_passes_a_sheet(&Collider::cylinder(0.1, 0.3), 19);
}

/// Heaps of rollers and columns, dropped into a bin, which what rolls would leave: they come to rest, in nothing, and on any
/// number of threads alike.
#[test]
fn a_heap_comes_to_rest() {
    let ends = [1, 4].map(|threads| {
        let mut world = world_with(SolverSettings { threads, ..SolverSettings::game() });
        ground(&mut world);
        for (side, along) in
            [(DVec3::X, DVec3::Z), (DVec3::NEG_X, DVec3::Z), (DVec3::Z, DVec3::X), (DVec3::NEG_Z, DVec3::X)]
        {
            let size = side.abs() * 0.5 + along * 4.0 + DVec3::Y * 3.0;
            let wall = world.spawn((RigidBody::Static, Collider::cuboid(size.x, size.y, size.z))).id();
            world.entity_mut(wall).insert(Position(DVec3::new(0.3, 1.5, 0.3) + side * 1.25));
        }
        let mut dice = Pcg64Mcg::seed_from_u64(29);
        let all: Vec<_> = (0..24)
            .map(|index| {
                let at = DVec3::new(
                    f64::from(index % 2) * 0.6,
                    0.6 + 0.7 * f64::from(index / 4),
                    f64::from(index / 2 % 2) * 0.6,
                );
                let axis = DVec3::from_array(std::array::from_fn(|_| dice.random_range(-1.0..1.0)));
                cylinder(&mut world, at, DQuat::from_scaled_axis(axis))
            })
            .collect();
        run(&mut world, 8.0);
        for &own in &all {
            assert!(velocity(&world, own).length() < 0.05, "{own} still moves");
            assert!(clearance(&world, own) > -0.01, "{own} is in the ground");
        }
        all.iter().map(|&own| position(&world, own)).collect::<Vec<_>>()
    });
    assert_eq!(ends[0], ends[1]);
}

/// A third of it is beside the box, and what is over that is a little deeper or less deep than the end that reaches over the
/// edge, by rounding.
#[test]
fn a_cylinder_rolls_along_the_edge_of_a_box() {
    for place in [0.3, 0.35] {
        let mut world = world_with(SolverSettings::accurate());
        let below = body(&mut world, Collider::cuboid(0.8, 1.0, 2.0), DVec3::Y * 0.5);
        world.entity_mut(below).insert(RigidBody::Static);
        let cylinder = body(&mut world, Collider::cylinder(0.2, 0.5), DVec3::new(place, 1.2, -0.1));
        let rolls = Velocity { linear: DVec3::Z * 0.3, angular: DVec3::X * 1.5 };
        world.entity_mut(cylinder).insert((Rotation(DQuat::from_rotation_arc(DVec3::Y, DVec3::X)), rolls));
        for _ in 0..60 {
            steps(&mut world, 1);
            assert_eq!(world.resource::<StepStats>().cuts, 0, "{place}");
        }
        assert_near(velocity(&world, cylinder), rolls.linear, 1e-8);
        assert_near(spin(&world, cylinder), rolls.angular, 1e-8);
    }
}
