//! Joints that give, under the exact method: at their bounds, in contact, and on what cannot follow. However hard
//! something is pulled, a step ends.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{Diagnostics, PlacedCollider};
use plumb::prelude::*;
use plumb::scene::load;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

/// A joint from an immovable point to one of a body.
fn pull(world: &mut World, from: DVec3, body: Entity, anchor: DVec3, softness: Softness) {
    let hand = world.spawn((RigidBody::Static, Position(from))).id();
    world.spawn(BallJoint::new(hand, body).with_anchors(DVec3::ZERO, anchor).with_softness(softness));
}

/// At its bound a joint that gives is a force along its stretch, no more: on a loop, whose rows may be redundant, and on
/// what slides. From so far the direction is the same, within 1e-12, however the body moves.
#[test]
fn a_pull_at_its_bound_is_a_constant_force() {
    let bound = 5.0;
    let along = DVec3::new(5.0, 4.0, 3.0).normalize();
    let loop_of_three = |world: &mut World| {
        let rod = |world: &mut World, at: DVec3, size: DVec3| {
            let collider = (Collider::cuboid(size.x, size.y, size.z), CollisionLayers::NONE);
            world.spawn((RigidBody::Dynamic, collider, Position(at), Mass(1.0))).id()
        };
        let [left, right] = [0.0, 1.0].map(|x| rod(world, DVec3::new(x, 0.5, 0.0), DVec3::new(0.1, 1.0, 0.1)));
        let top = rod(world, DVec3::new(0.5, 1.0, 0.0), DVec3::new(1.0, 0.1, 0.1));
        let ground = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let up = DVec3::Y * 0.5;
        for (a, b, anchor_a, anchor_b) in [
            (ground, left, DVec3::ZERO, -up),
            (ground, right, DVec3::X, -up),
            (left, top, up, -DVec3::X * 0.5),
            (right, top, up, DVec3::X * 0.5),
        ] {
            world.spawn(BallJoint::new(a, b).with_anchors(anchor_a, anchor_b));
        }
        top
    };
    let cube_on_the_ground = |world: &mut World| {
        ground(world);
        let cube = body(world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
        world.entity_mut(cube).insert((Mass(0.5), SurfaceMaterial { friction: 0.3, restitution: 0.0 }));
        cube
    };
    let scenes: [&dyn Fn(&mut World) -> Entity; 2] = [&loop_of_three, &cube_on_the_ground];
    for scene in scenes {
        let end = |is_pulled: bool| {
            let mut world = world_with(SolverSettings::accurate());
            let body = scene(&mut world);
            if is_pulled {
                pull(
                    &mut world,
                    along * 1e12,
                    body,
                    DVec3::ZERO,
                    Softness { frequency: 8.0, damping_ratio: 1.0, max_force: bound },
                );
            } else {
                world.entity_mut(body).insert(ExternalForce { force: along * bound, torque: DVec3::ZERO });
            }
            let mut most = 0;
            for _ in 0..30 {
                step(&mut world);
                let stats = world.resource::<StepStats>();
                most = most.max(stats.row_updates / u64::from(stats.rows));
                assert_eq!((stats.cuts, stats.unsettled), (0, 0));
            }
            assert!(most < 100, "{most} solves");
            position(&world, body)
        };
        assert_near(end(true), end(false), 1e-9);
    }
}

/// A cube on ice: at rest the spring carries what pushes the cube, whatever the step; one that is far too stiff for the
/// step, or damped far too much, does not throw it.
#[test]
fn springs_of_what_touches_something_find_their_rest() {
    for (frequency, damping_ratio) in [(1.0, 1.0), (10.0, 0.3), (500.0, 0.0), (500.0, 1.0), (5.0, 100.0)] {
        let mut world = world_with(SolverSettings::accurate());
        ground(&mut world);
        let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
        let push = ExternalForce { force: DVec3::X * 4.0, torque: DVec3::ZERO };
        world.entity_mut(cube).insert((Mass(2.0), push, SurfaceMaterial { friction: 0.0, restitution: 0.0 }));
        let softness = Softness { frequency, damping_ratio, max_force: 1e9 };
        pull(&mut world, DVec3::Y * 0.5, cube, DVec3::ZERO, softness);
        let rest = 4.0 / (2.0 * (std::f64::consts::TAU * frequency).powi(2));
        let mut farthest = 0.0_f64;
        for _ in 0..600 {
            step(&mut world);
            farthest = farthest.max(position(&world, cube).x.abs());
        }
        let end = position(&world, cube).x;
        assert!(farthest < 2.0 * rest + 5e-3, "{frequency} Hz, {damping_ratio}: {farthest} m");
        if frequency < 13.0 && damping_ratio < 10.0 {
            assert_close(end, rest, 1e-9);
        }
    }
}

/// The scene with somebody pulled towards a point, for so many steps: the most solves of one, the greatest separation of
/// a joint, m, and how much nearer came what is pulled, m. `touches`: bodies collide.
fn dragged(name: &str, to: DVec3, softness: Softness, touches: bool, count: u32) -> (u64, f64, f64) {
    let mut world = world_with(SolverSettings::accurate());
    world.init_resource::<Diagnostics>();
    load("limbs", &[]).unwrap().spawn(&mut world);
    if !touches {
        let mut layers = world.query_filtered::<Entity, With<Collider>>();
        let all: Vec<Entity> = layers.iter(&world).collect();
        all.into_iter().for_each(|body| _ = world.entity_mut(body).insert(CollisionLayers::NONE));
    }
    let mut names = world.query::<(Entity, &Name)>();
    let body = names.iter(&world).find(|(_, found)| found.as_str() == name).expect("it is there").0;
    pull(&mut world, to, body, DVec3::new(0.05, 0.0, 0.03), softness);
    let distance = |world: &World| position(world, body).distance(to);
    let before = distance(&world);
    let (mut solves, mut parted) = (0, 0.0_f64);
    for _ in 0..count {
        step(&mut world);
        let stats = world.resource::<StepStats>();
        solves = solves.max(stats.row_updates / u64::from(stats.rows));
        parted = parted.max(world.resource::<Diagnostics>().joint_error);
    }
    (solves, parted, before - distance(&world))
}

#[test]
fn figures_dragged_against_their_strings_come_along_as_far_as_they_can() {
    let softness = Softness { frequency: 8.0, damping_ratio: 1.0, max_force: 800.0 };
    for (name, to) in [
        ("ann chest", DVec3::new(-1.0, 2.3, 0.1)),
        ("ann head", DVec3::new(-0.8, 1.78, 0.5)),
        ("bo chest", DVec3::new(2.4, 1.2, 0.8)),
    ] {
        for touches in [true, false] {
            let (solves, parted, nearer) = dragged(name, to, softness, touches, 30);
            assert!(solves < 10_000, "{name}, {touches}: {solves} solves");
            assert!(parted < 3e-3, "{name}, {touches}: {parted} m");
            assert!(nearer > 0.3, "{name}, {touches}: {nearer} m nearer");
        }
    }
}

/// Over the bar and the strings, until it is taut: contacts and joints that no cone solve brings together in one
/// flight, and limits of the figures that it takes along.
#[test]
fn a_garland_thrown_over_a_bar_stays_whole() {
    let softness = Softness { frequency: 15.0, damping_ratio: 1.0, max_force: 1400.0 };
    for to in [DVec3::new(-0.2, 3.5, -1.7), DVec3::new(1.0, 2.6, -0.5)] {
        let (solves, parted, nearer) = dragged("link 8", to, softness, true, 48);
        assert!(solves < 10_000, "to {to}: {solves} solves");
        assert!(parted < 1e-5, "to {to}: {parted} m");
        assert!(nearer > 0.5, "to {to}: {nearer} m nearer");
    }
}

#[test]
fn a_step_ends_however_hard_something_is_pulled() {
    for (frequency, max_force) in [(50.0, 1e6), (500.0, 1e9)] {
        let softness = Softness { frequency, damping_ratio: 1.0, max_force };
        for touches in [true, false] {
            let (solves, parted, nearer) = dragged("ann chest", DVec3::new(-1.0, 2.3, 0.1), softness, touches, 4);
            assert!(solves < 30_000, "{max_force} N, {touches}: {solves} solves");
            assert!(parted < 5.0, "{max_force} N, {touches}: {parted} m");
            assert!(nearer > 0.5, "{max_force} N, {touches}: {nearer} m nearer");
        }
    }
}

/// In `game`, by a hand that jumps about: every tenth of a second to another place within its reach. Where the figures hit
/// a heap at 50 m/s their joints may part, but come together again.
#[test]
fn figures_jerked_about_do_not_fly_and_are_whole_in_the_end() {
    let softness = Softness { frequency: 12.0, damping_ratio: 1.0, max_force: 3000.0 };
    for (name, seed) in
        [("ann left hand", 1), ("ann chest", 2), ("bo right foot", 3), ("cy head", 4), ("cy left shin", 5)]
    {
        let mut world = world_with(SolverSettings::game());
        world.init_resource::<Diagnostics>();
        load("limbs", &[]).unwrap().spawn(&mut world);
        let mut names = world.query::<(Entity, &Name)>();
        let body = names.iter(&world).find(|(_, found)| found.as_str() == name).expect("it is there").0;
        let hand = world.spawn((RigidBody::Static, Position(position(&world, body)))).id();
        let grip = world.spawn(BallJoint::new(hand, body).with_softness(softness)).id();
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut bodies = world.query_filtered::<&Velocity, With<Collider>>();
        let mut fastest =
            |world: &World| bodies.iter(world).map(|velocity| velocity.linear.length()).fold(0.0, f64::max);
        let mut most: f64 = 0.0;
        for frame in 0..300 {
            if frame % 6 == 0 {
                let to = DVec3::from_array([0, 1, 2].map(|_| random.random_range(-2.0..2.0)));
                world.get_mut::<Position>(hand).unwrap().0 = to + 1.5 * DVec3::Y;
            }
            step(&mut world);
            most = most.max(fastest(&world));
        }
        assert!(most < 150.0, "{name}: {most} m/s");
        world.despawn(grip);
        (0..240).for_each(|_| step(&mut world));
        let (fastest, parted) = (fastest(&world), world.resource::<Diagnostics>().joint_error);
        println!("{name}: {most} m/s, then {fastest} m/s, {parted} m");
        assert!(fastest < 5.0, "{name}: {fastest} m/s in the end");
        assert!(parted < 1e-3, "{name}: {parted} m apart in the end");
    }
}

/// A fixed body that others are pulled at, and how deep they get into it.
struct Post {
    entity: Entity,
    others: Vec<Entity>,
}

impl Post {
    /// One of that shape beside a point, in that direction from it, as near as it overlaps nothing.
    fn beside(world: &mut World, from: DVec3, direction: DVec3, shape: Collider) -> Self {
        let mut bodies = world.query_filtered::<(Entity, &RigidBody), With<Collider>>();
        let dynamic = bodies.iter(world).filter(|(_, kind)| **kind == RigidBody::Dynamic);
        let others = dynamic.map(|(body, _)| body).collect();
        let entity = world.spawn((RigidBody::Static, shape, Position(from))).id();
        let post = Self { entity, others };
        while post.overlap(world) > 0.0 {
            world.get_mut::<Position>(entity).unwrap().0 += 0.01 * direction;
        }
        post
    }

    /// The deepest overlap with any other body, m.
    fn overlap(&self, world: &World) -> f64 {
        let placed = |body: Entity| PlacedCollider {
            collider: world.get(body).unwrap(),
            position: *world.get(body).unwrap(),
            rotation: *world.get(body).unwrap(),
        };
        let post = placed(self.entity);
        self.others.iter().filter_map(|&body| placed(body).overlap(&post)).fold(0.0, f64::max)
    }

    /// The same of all of so many steps, in which a hand that holds a body goes away from where it is by 0.3 m a step, up
    /// to 3 m, and pulls with no more than that force, N.
    fn deepest(&self, world: &mut World, body: Entity, direction: DVec3, max_force: f64, count: u32) -> f64 {
        let from = position(world, body);
        let hand = world.spawn((RigidBody::Kinematic, Position(from))).id();
        let softness = Softness { frequency: 12.0, damping_ratio: 1.0, max_force };
        world.spawn(BallJoint::new(hand, body).with_softness(softness));
        let overlaps = (1..=count).map(|frame| {
            world.get_mut::<Position>(hand).unwrap().0 = from + direction * (0.3 * f64::from(frame)).min(3.0);
            step(world);
            self.overlap(world)
        });
        overlaps.fold(0.0, f64::max)
    }
}

fn posts() -> [(&'static str, Collider); 3] {
    [
        ("pole", Collider::cuboid(0.1, 3.0, 0.1)),
        ("ball", Collider::sphere(0.2)),
        ("wall", Collider::cuboid(0.4, 1.0, 0.4)),
    ]
}

/// From rest, within the first step: 800 N make 7 cm of it with 3 kg.
#[test]
fn what_a_hand_pulls_at_a_post_from_rest_meets_it_in_time() {
    for settings in [SolverSettings::game(), SolverSettings::sequential_impulses()] {
        for (what, post) in posts() {
            for force in [800.0, 3000.0] {
                let mut world = world_with(settings);
                ground(&mut world);
                let ball = body(&mut world, Collider::sphere(0.11), DVec3::Y * 1.4);
                world.entity_mut(ball).insert(Mass(3.0));
                let direction = DVec3::new(0.8, 0.0, 0.6);
                let from = position(&world, ball);
                let post = Post::beside(&mut world, from, direction, post.clone());
                let deepest = post.deepest(&mut world, ball, direction, force, 60);
                println!("{:?} at a {what} with {force} N: {deepest:.5} m", settings.method);
                assert!(deepest < 1e-5 * force, "{:?} at a {what} with {force} N: {deepest} m", settings.method);
            }
        }
    }
}

/// By a limb, with 30 times its weight: half of the pulls get no deeper than 1 cm. Where a limb is jammed between others and
/// the post, iterations may not end.
#[test]
fn figures_dragged_at_a_post_stay_out_of_it() {
    let mut overlaps = Vec::new();
    for (name, seed) in
        [("ann left hand", 1), ("ann left forearm", 2), ("bo right shin", 3), ("cy head", 4), ("cy chest", 5)]
    {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for (what, post) in posts() {
            let mut world = world_with(SolverSettings::game());
            load("limbs", &[]).unwrap().spawn(&mut world);
            run(&mut world, 1.0);
            let mut names = world.query::<(Entity, &Name)>();
            let limb = names.iter(&world).find(|(_, found)| found.as_str() == name).expect("it is there").0;
            let mut along = |range: std::ops::Range<f64>| random.random_range(range);
            let direction = DVec3::new(along(-1.0..1.0), along(0.0..0.3), along(-1.0..1.0)).normalize();
            let (from, force) = (position(&world, limb), 30.0 * 9.81 * world.get::<Mass>(limb).unwrap().0);
            let post = Post::beside(&mut world, from, direction, post);
            let deepest = post.deepest(&mut world, limb, direction, force, 60);
            println!("{name} at a {what}: {deepest:.4} m");
            assert!(deepest < 0.03, "{name} at a {what}: {deepest} m");
            overlaps.push(deepest);
        }
    }
    overlaps.sort_by(f64::total_cmp);
    let median = overlaps[overlaps.len() / 2];
    assert!(median < 1e-2, "{median} m in the middle of {overlaps:?}");
}
