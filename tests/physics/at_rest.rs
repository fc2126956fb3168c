//! Islands at rest are solved directly: they bear any load, do not creep, and begin to move when they should.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::ContactForces;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

/// Nothing sleeps, so that all that stands still is held by the solver.
fn game() -> World {
    let mut world = world_with(awake_game());
    ground(&mut world);
    world
}

/// Unit cubes one on the other, each shifted by up to `jitter`, m.
fn column(world: &mut World, count: u32, jitter: f64) -> Vec<Entity> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut shift = || jitter * random.random_range(-1.0..1.0);
    let places = (0..count).map(|index| DVec3::new(shift(), f64::from(index) + 0.5, shift()));
    places.map(|place| body(world, Collider::cuboid(1.0, 1.0, 1.0), place)).collect()
}

/// The farthest any of these bodies is from where it was.
fn farthest(world: &World, bodies: &[Entity], start: &[DVec3]) -> f64 {
    let way = bodies.iter().zip(start).map(|(&body, start)| (position(world, body) - *start).length());
    way.fold(0.0, f64::max)
}

fn places(world: &World, bodies: &[Entity]) -> Vec<DVec3> {
    bodies.iter().map(|&body| position(world, body)).collect()
}

#[test]
fn a_column_of_a_hundred_stands_for_a_minute() {
    let mut world = game();
    let cubes = column(&mut world, 100, 1e-3);
    let start = places(&world, &cubes);
    run(&mut world, 60.0);
    let moved = farthest(&world, &cubes, &start);
    assert!(moved < 1e-4, "moved by {moved} m");
}

#[test]
fn light_boxes_bear_a_slab_of_a_million_times_their_mass() {
    for ratio in [1e3, 1e6] {
        let mut world = game();
        for side in [-1.0, 1.0] {
            let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::new(side, 0.5, 0.0));
            world.entity_mut(cube).insert(Mass(1.0));
        }
        let slab = body(&mut world, Collider::cuboid(4.0, 2.0, 2.0), DVec3::Y * 2.0);
        world.entity_mut(slab).insert(Mass(ratio));
        run(&mut world, 10.0);
        assert_near(position(&world, slab), DVec3::Y * 2.0, 1e-4);
    }
}

#[test]
fn contact_forces_carry_the_weight_above() {
    let mut world = game();
    let cubes = column(&mut world, 10, 1e-3);
    world.insert_resource(ContactForces::default());
    run(&mut world, 1.0);
    for (index, &cube) in cubes.iter().enumerate() {
        let forces = world.resource::<ContactForces>().0.iter();
        let below = index.checked_sub(1).map(|index| cubes[index]);
        let up: f64 = forces
            .filter(|force| below.is_none_or(|below| force.a == below || force.b == below))
            .filter(|force| force.a == cube || force.b == cube)
            .filter(|force| (force.point.y - index as f64).abs() < 0.1)
            .map(|force| if force.b == cube { force.force.y } else { -force.force.y })
            .sum();
        let weight = 1000.0 * G * (10 - index) as f64;
        assert_close(up / weight, 1.0, 1e-5);
    }
}

/// A column of three that has stood for a second, so that nothing changes any more.
fn standing() -> (World, Vec<Entity>) {
    let mut world = game();
    let cubes = column(&mut world, 3, 0.0);
    run(&mut world, 1.0);
    (world, cubes)
}

#[test]
fn what_rests_moves_when_it_is_pushed() {
    // Against μ m g = 5886 N for the topmost.
    let (mut world, cubes) = standing();
    world.entity_mut(cubes[2]).insert(ExternalForce { force: DVec3::X * 7000.0, torque: DVec3::ZERO });
    let start = places(&world, &cubes);
    run(&mut world, 0.5);
    let slid = position(&world, cubes[2]).x - start[2].x;
    assert_close(slid, 0.5 * (7000.0 - 0.6 * 1000.0 * G) / 1000.0 * 0.25, 0.01);
    world.entity_mut(cubes[2]).insert(ExternalForce { force: DVec3::X * 3000.0, torque: DVec3::ZERO });
    // Depths from the time of sliding close by a tenth a step.
    run(&mut world, 4.0);
    let start = places(&world, &cubes);
    run(&mut world, 1.0);
    let crept = farthest(&world, &cubes, &start);
    assert!(crept < 1e-5, "friction bears 3000 N, and the cubes crept by {crept} m");
}

#[test]
fn what_rests_moves_when_it_is_thrown_or_hit() {
    let (mut world, cubes) = standing();
    world.get_mut::<Velocity>(cubes[2]).unwrap().linear = DVec3::new(0.0, 3.0, 0.0);
    run(&mut world, 0.3);
    assert!(position(&world, cubes[2]).y > 2.9, "{}", position(&world, cubes[2]).y);

    let (mut world, cubes) = standing();
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::new(-3.0, 2.5, 0.0));
    world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::X * 10.0;
    run(&mut world, 1.0);
    assert!(position(&world, cubes[2]).x > 0.1, "{}", position(&world, cubes[2]).x);
}

#[test]
fn what_rests_falls_when_its_support_goes() {
    for gone in [0, 1] {
        let (mut world, cubes) = standing();
        world.despawn(cubes[gone]);
        run(&mut world, 1.0);
        assert_close(position(&world, cubes[2]).y, 1.5, 1e-2);
    }
}

#[test]
fn what_rests_follows_gravity_mass_and_friction() {
    let (mut world, cubes) = standing();
    world.insert_resource(Gravity(DVec3::new(8.0, -G, 0.0)));
    run(&mut world, 0.5);
    assert!(position(&world, cubes[0]).x > 0.1, "tan of the slope is 0.82, over μ = 0.6");

    let (mut world, cubes) = standing();
    world.insert_resource(Gravity(DVec3::new(2.0, -G, 0.0)));
    run(&mut world, 0.5);
    assert!(position(&world, cubes[0]).x.abs() < 1e-3, "tan of the slope is 0.2");
    for &cube in &cubes {
        world.entity_mut(cube).insert(SurfaceMaterial { friction: 0.0, restitution: 0.0 });
    }
    run(&mut world, 0.5);
    assert!(position(&world, cubes[0]).x > 0.1, "it slides on ice");

    let (mut world, cubes) = standing();
    world.entity_mut(cubes[2]).insert(Mass(1e5));
    world.insert_resource(ContactForces::default());
    run(&mut world, 0.5);
    let forces = &world.resource::<ContactForces>().0;
    let on_ground: f64 = forces.iter().filter(|force| force.point.y.abs() < 0.1).map(|force| force.force.y.abs()).sum();
    assert_close(on_ground / ((2000.0 + 1e5) * G), 1.0, 1e-4);
}

#[test]
fn what_rests_goes_along_with_its_floor() {
    let mut world = world_with(awake_game());
    let floor = world.spawn((RigidBody::Kinematic, Collider::cuboid(10.0, 1.0, 10.0), Position(-DVec3::Y * 0.5))).id();
    let cubes = column(&mut world, 3, 0.0);
    run(&mut world, 1.0);
    for speed in [DVec3::Y * 0.02, DVec3::X * 0.03, DVec3::Y * 0.5, DVec3::NEG_Y * 0.5] {
        let start = places(&world, &cubes);
        world.get_mut::<Velocity>(floor).unwrap().linear = speed;
        run(&mut world, 1.0);
        for (&cube, start) in cubes.iter().zip(&start) {
            assert_near(position(&world, cube) - *start, speed, 0.02);
        }
    }
}

#[test]
fn a_slope_just_steeper_than_friction_is_slid_down() {
    // μ = 0.6; from rest, so that it begins in an island at rest.
    for (tangent, slides) in [(0.597, false), (0.603, true)] {
        let mut world = game();
        let angle = f64::atan(tangent);
        world.insert_resource(Gravity(DVec3::new(angle.sin(), -angle.cos(), 0.0) * G));
        let slider = body(&mut world, Collider::cuboid(2.0, 0.5, 1.0), DVec3::Y * 0.25);
        run(&mut world, 4.0);
        let way = position(&world, slider).x;
        let expected = if slides { 0.5 * G * (angle.sin() - 0.6 * angle.cos()) * 16.0 } else { 0.0 };
        assert_close(way, expected, 0.02);
    }
}

#[test]
fn a_joined_pair_that_leans_on_the_ground_stays() {
    // Two rods joined at the top like a tent, their feet held apart by friction: 20° from upright.
    let mut world = game();
    let lean = 20_f64.to_radians();
    let rods = [-1.0, 1.0].map(|side: f64| {
        let rotation = bevy::math::DQuat::from_rotation_z(side * lean);
        let up = rotation * DVec3::Y;
        let foot = DVec3::new(side * lean.sin() * 1.0, 0.05 * lean.sin(), 0.0);
        let place = foot + up * 0.5;
        world.spawn((RigidBody::Dynamic, Collider::cuboid(0.1, 1.0, 0.5), Position(place), Rotation(rotation))).id()
    });
    let anchor = DVec3::Y * 0.5;
    world.spawn(BallJoint::new(rods[0], rods[1]).with_anchors(anchor, anchor));
    run(&mut world, 2.0);
    let start = places(&world, &rods);
    run(&mut world, 20.0);
    let moved = farthest(&world, &rods, &start);
    assert!(moved < 1e-5, "the tent crept by {moved} m");
    assert!(position(&world, rods[0]).y > 0.4, "the tent stands");
}

#[test]
fn effort_that_is_not_fitted_gives_the_same_to_what_sweeps_can_bear() {
    let places = [true, false].map(|fitted_effort| {
        let mut world = world_with(with_effort(awake_game(), fitted_effort));
        ground(&mut world);
        let cubes = column(&mut world, 3, 1e-3);
        run(&mut world, 2.0);
        (position(&world, cubes[2]), world.resource::<StepStats>().resting)
    });
    assert_near(places[0].0, places[1].0, 2e-3);
    assert_eq!((places[0].1, places[1].1), (3, 0));
}
