//! What is heavy on what is light, in motion: it lands without sinking in, goes through what it is thrown at, and nothing
//! of it gains energy.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

/// A unit cube of that mass, kg.
fn cube(world: &mut World, place: DVec3, mass: f64) -> Entity {
    let cube = body(world, Collider::cuboid(1.0, 1.0, 1.0), place);
    world.entity_mut(cube).insert(Mass(mass));
    cube
}

/// A ball of radius 1 m.
fn ball(world: &mut World, place: DVec3, mass: f64) -> Entity {
    let ball = body(world, Collider::sphere(1.0), place);
    world.entity_mut(ball).insert(Mass(mass));
    ball
}

/// Rows of n, n − 1, … cubes of 1 kg.
fn wall(world: &mut World, n: u32) -> Vec<Entity> {
    let places = (0..n).flat_map(|row| {
        (0..n - row).map(move |i| DVec3::new(f64::from(i) - 0.5 * f64::from(n - row - 1), 0.5 + f64::from(row), 0.0))
    });
    places.map(|place| cube(world, place, 1.0)).collect()
}

/// Level ground.
fn game() -> World {
    let mut world = world_with(awake_game());
    world.insert_resource(Gravity(-10.0 * DVec3::Y));
    world.init_resource::<Diagnostics>();
    ground(&mut world);
    world
}

fn fastest(world: &World, bodies: &[Entity]) -> f64 {
    bodies.iter().map(|&body| velocity(world, body).length()).fold(0.0, f64::max)
}

/// A ball thrown level at a wall. Its speed behind the wall, the greatest of a cube on the way, over the ball's, and the
/// deepest overlap from a second after on.
fn throw(n: u32, mass: f64, speed: f64) -> [f64; 3] {
    let mut world = game();
    let cubes = wall(&mut world, n);
    let ball = ball(&mut world, DVec3::new(0.0, f64::max(1.0, 0.5 * f64::from(n)), -2.5), mass);
    world.get_mut::<Velocity>(ball).unwrap().linear = speed * DVec3::Z;
    let (mut kept, mut flung, mut deep) = (None, 0.0_f64, 0.0_f64);
    let mut through = f64::INFINITY;
    for index in 0..180 {
        step(&mut world);
        let time = f64::from(index + 1) / 60.0;
        flung = flung.max(fastest(&world, &cubes) / speed);
        if kept.is_none() && position(&world, ball).z > 1.5 {
            kept = Some(velocity(&world, ball).z);
            through = time;
        }
        if time > through + 1.0 {
            deep = deep.max(world.resource::<Diagnostics>().penetration);
        }
    }
    [kept.unwrap_or(0.0), flung, deep]
}

#[test]
fn a_ball_thrown_at_a_wall_of_light_cubes_goes_through() {
    for (n, mass, speed) in [(10, 1e4, 10.0), (6, 1e4, 20.0), (8, 1e3, 10.0), (8, 100.0, 10.0)] {
        let [kept, flung, deep] = throw(n, mass, speed);
        let least = speed * mass / (mass + f64::from(n * (n + 1) / 2));
        let what = format!("{n} rows, {mass} kg at {speed} m/s");
        assert!(kept >= least, "{what}: {kept} m/s are left, less than {least}");
        // One may be squeezed out between others, faster than what squeezes it.
        assert!(flung < 4.0, "{what}: a cube is {flung} times as fast");
        assert!(deep < 0.1, "{what}: {deep} m overlap a second later");
    }
}

/// Boxes of any size and turn, with masses from 1 to `heaviest` kg, that fall on each other. The rise of the energy over
/// what it was at most before, over its first, and the fastest of a body over what it may have from its fall.
fn drop_heap(count: u32, heaviest: f64, seed: u64) -> [f64; 3] {
    let mut world = game();
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let side = 4;
    let mut boxes = Vec::new();
    for i in 0..count {
        let (layer, row, column) = (i / (side * side), i / side % side, i % side);
        let size = DVec3::from_array([0, 1, 2].map(|_| random.random_range(0.4..0.9)));
        let place = DVec3::new(f64::from(column), 0.8 + f64::from(layer), f64::from(row));
        let thing = body(&mut world, Collider::cuboid(size.x, size.y, size.z), place);
        let axis = DVec3::from_array([0, 1, 2].map(|_| random.random_range(-1.0..1.0))).normalize();
        let turn = DQuat::from_axis_angle(axis, random.random_range(0.0..3.0));
        let mass = heaviest.powf(random.random_range(0.0..1.0));
        world.entity_mut(thing).insert((Rotation(turn), Mass(mass)));
        boxes.push(thing);
    }
    let height = 0.8 + f64::from(count / (side * side));
    let most = (2.0 * 10.0 * height).sqrt();
    let mut energy: Option<f64> = None;
    let (mut rise, mut first, mut fast) = (0.0_f64, 0.0, 0.0_f64);
    for _ in 0..300 {
        step(&mut world);
        let now = world.resource::<Diagnostics>().energy();
        if energy.is_none() {
            first = now;
        }
        rise = rise.max(now - energy.unwrap_or(now));
        energy = Some(energy.unwrap_or(now).min(now));
        fast = fast.max(fastest(&world, &boxes) / most);
    }
    let far = boxes.iter().map(|&thing| position(&world, thing).length()).fold(0.0, f64::max);
    [rise / first, fast, far]
}

#[test]
fn a_heap_of_unequal_boxes_gains_no_energy() {
    for (count, heaviest, seed) in [(200, 1e3, 1), (50, 1e3, 2), (20, 1e4, 4)] {
        let [rise, fast, far] = drop_heap(count, heaviest, seed);
        let what = format!("{count} boxes of up to {heaviest} kg");
        // What sweeps leave inside each other is lifted out again; were all of it swept, it would be three times as much.
        assert!(rise < 1e-3, "{what}: energy rises by {rise} of what it was");
        assert!(fast < 1.5, "{what}: one is {fast} times as fast as it may fall");
        assert!(far < 40.0, "{what}: one ends {far} m away");
    }
}

/// How far bodies get under where they come to rest and beside it within a time, s, m.
fn sunk(world: &mut World, bodies: &[(Entity, DVec3)], seconds: f64) -> [f64; 2] {
    let (mut deep, mut aside) = (0.0_f64, 0.0_f64);
    for _ in 0..(60.0 * seconds) as u32 {
        step(world);
        for &(body, rest) in bodies {
            let moved = position(world, body) - rest;
            deep = deep.max(-moved.y);
            aside = aside.max(moved.x.hypot(moved.z));
        }
    }
    [deep, aside]
}

#[test]
fn a_heavy_slab_that_falls_on_light_cubes_does_not_sink() {
    for (n, mass, drop) in [(2, 1e3, 0.05), (2, 1e5, 2.0), (7, 1e4, 1.0), (20, 10.0, 0.5)] {
        let mut world = game();
        let mut bodies: Vec<_> = (0..n)
            .map(|i| DVec3::new(2.0 * f64::from(i) - f64::from(n - 1), 0.5, 0.0))
            .map(|place| (cube(&mut world, place, 1.0), place))
            .collect();
        let slab = body(&mut world, Collider::cuboid(2.0 * f64::from(n), 2.0, 2.0), (2.0 + drop) * DVec3::Y);
        world.entity_mut(slab).insert(Mass(mass));
        bodies.push((slab, 2.0 * DVec3::Y));
        let [deep, aside] = sunk(&mut world, &bodies, 2.0);
        let what = format!("{mass} kg from {drop} m on {n} cubes");
        assert!(deep < 0.01 && aside < 0.01, "{what}: sinks by {deep} m, moves by {aside} m");
        let speed = fastest(&world, &[slab]);
        assert!(speed < 1e-3, "{what}: moves at {speed} m/s");
    }
}

#[test]
fn a_heavy_slab_that_may_bounce_comes_to_rest_on_light_cubes() {
    let mut world = game();
    let cubes = [-1.0, 1.0].map(|x| cube(&mut world, DVec3::new(x, 0.5, 0.0), 1.0));
    let slab = body(&mut world, Collider::cuboid(4.0, 2.0, 2.0), 2.05 * DVec3::Y);
    world.entity_mut(slab).insert((Mass(1e3), SurfaceMaterial { friction: 0.6, restitution: 0.5 }));
    let mut highest = f64::NEG_INFINITY;
    for index in 0..240 {
        step(&mut world);
        if index > 10 {
            highest = highest.max(position(&world, slab).y);
        }
    }
    assert!(highest < 2.05, "it bounces up to {highest} m");
    let sunk = 2.0 - position(&world, slab).y;
    let speed = fastest(&world, &[cubes[0], cubes[1], slab]);
    assert!(sunk < 0.01 && speed < 1e-3, "it ends {sunk} m too deep, at {speed} m/s");
}

#[test]
fn a_column_of_light_and_heavy_cubes_lands_and_stands() {
    let columns = [
        (15, 100.0, 0.01),
        (20, 1e3, 0.02),
        (6, 1e5, 0.1),
        (9, 10.0, 0.01),
        (10, 1.0, 0.02),
        (20, 1.0, 0.01),
        (25, 3.0, 0.01),
    ];
    for (n, heavy, gap) in columns {
        let mut world = game();
        let bodies: Vec<_> = (0..n)
            .map(|i| {
                let (rest, mass) = ((f64::from(i) + 0.5) * DVec3::Y, if i % 2 == 0 { 1.0 } else { heavy });
                (cube(&mut world, rest + f64::from(i + 1) * gap * DVec3::Y, mass), rest)
            })
            .collect();
        let [deep, aside] = sunk(&mut world, &bodies, 2.0);
        let what = format!("{n} cubes of 1 and {heavy} kg, gaps of {gap} m");
        assert!(deep < 0.01 && aside < 0.02, "{what}: sinks by {deep} m, moves by {aside} m");
    }
}

#[test]
fn a_heavy_ball_that_falls_on_a_wall_of_light_cubes_stays_on_it() {
    for (n, mass, drop) in [(10, 1e4, 1.0), (4, 1e3, 0.3), (7, 1e5, 2.0), (14, 1e4, 1.0), (12, 300.0, 3.0)] {
        let mut world = game();
        let mut bodies: Vec<_> = wall(&mut world, n).into_iter().map(|cube| (cube, position(&world, cube))).collect();
        let rest = (f64::from(n) + 1.0) * DVec3::Y;
        let ball = ball(&mut world, rest + drop * DVec3::Y, mass);
        bodies.push((ball, rest));
        let [deep, aside] = sunk(&mut world, &bodies, 2.0);
        let what = format!("{mass} kg from {drop} m on {n} rows");
        assert!(deep < 0.01 && aside < 0.01, "{what}: sinks by {deep} m, moves by {aside} m");
    }
}

#[test]
fn a_wall_of_fifteen_rows_stands_with_one_substep() {
    let mut world = world_with(SolverSettings { substeps: 1, ..awake_game() });
    ground(&mut world);
    let bodies: Vec<_> = wall(&mut world, 15).into_iter().map(|cube| (cube, position(&world, cube))).collect();
    let [deep, aside] = sunk(&mut world, &bodies, 2.0);
    assert!(deep < 1e-3 && aside < 1e-3, "sinks by {deep} m, moves by {aside} m");
}
