//! Islands that rest fall asleep, cost nothing, and go on as they were when something disturbs them.

use std::time::Duration;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::time::{TimePlugin, TimeUpdateStrategy};
use plumb::physics::{ContactForces, Diagnostics};
use plumb::prelude::*;

use crate::rig::*;

const GAME: fn() -> SolverSettings = SolverSettings::game;

fn block(world: &mut World, x: f64, y: f64) -> Entity {
    body(world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::new(x, y, 0.0))
}

/// Blocks one upon the other.
fn stack(world: &mut World, x: f64, count: u32) -> Vec<Entity> {
    (0..count).map(|row| block(world, x, f64::from(row) + 0.5)).collect()
}

fn sleeps(world: &World, body: Entity) -> bool {
    world.get::<Sleeping>(body).is_some()
}

#[track_caller]
fn assert_asleep(world: &World, bodies: &[Entity], expected: bool, what: &str) {
    for (index, &body) in bodies.iter().enumerate() {
        assert_eq!(sleeps(world, body), expected, "{what}: body {index}");
    }
}

fn stats(world: &World) -> StepStats {
    *world.resource::<StepStats>()
}

/// Two blocks stacked, and one far away, all asleep on the ground.
fn sleepers() -> (World, Entity, Vec<Entity>, Entity) {
    let mut world = world_with(GAME());
    let floor = ground(&mut world);
    let pile = stack(&mut world, 0.0, 2);
    let far = block(&mut world, 20.0, 0.5);
    run(&mut world, 2.0);
    assert_asleep(&world, &pile, true, "after two seconds");
    assert!(sleeps(&world, far));
    (world, floor, pile, far)
}

#[test]
fn what_rests_falls_asleep_after_half_a_second_of_calm() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let pile = stack(&mut world, 0.0, 3);
    let dropped = block(&mut world, 9.0, 1.5);
    let mut calm_since = None;
    while !sleeps(&world, pile[0]) {
        let before: Vec<DVec3> = pile.iter().map(|&body| velocity(&world, body)).collect();
        let is_calm = before.iter().all(|speed| speed.length() < 0.02);
        calm_since = if is_calm { calm_since.or(Some(stats(&world).steps)) } else { None };
        step(&mut world);
        assert!(stats(&world).steps < 120, "it never sleeps");
    }
    let calm = stats(&world).steps - calm_since.unwrap();
    assert!((30..=32).contains(&calm), "after {calm} steps of calm");
    assert_asleep(&world, &pile, true, "as one");
    assert!(!sleeps(&world, dropped), "it lay for a tenth of a second by then");
    assert_eq!(stats(&world).sleeping, 3);
    pile.iter().for_each(|&body| assert_eq!(*world.get::<Velocity>(body).unwrap(), Velocity::default()));
    run(&mut world, 1.0);
    assert!(sleeps(&world, dropped));
}

#[test]
fn nothing_of_a_sleeping_world_is_looked_at_or_touched() {
    let (mut world, _, pile, far) = sleepers();
    let ticks = |world: &World| {
        let of = |&body: &Entity| {
            let body = world.entity(body);
            let changed = [
                body.get_change_ticks::<Position>(),
                body.get_change_ticks::<Rotation>(),
                body.get_change_ticks::<Velocity>(),
                body.get_change_ticks::<Transform>(),
                body.get_change_ticks::<Mass>(),
            ];
            changed.map(|ticks| ticks.unwrap().changed.get())
        };
        pile.iter().chain([&far]).map(of).collect::<Vec<_>>()
    };
    let (before, hash) = (ticks(&world), state_hash(&world));
    steps(&mut world, 10);
    assert_eq!(ticks(&world), before);
    assert_eq!(state_hash(&world), hash);
    let StepStats { rows, row_updates, pairs, axes_tested, islands, sleeping, manifolds, .. } = stats(&world);
    assert_eq!((rows, row_updates, pairs, axes_tested, islands), (0, 0, 0, 0, 0));
    assert_eq!((sleeping, manifolds), (3, 3), "they are there, even so");
}

#[test]
fn sleeping_steps_allocate_nothing() {
    let (mut world, ..) = sleepers();
    steps(&mut world, 3);
    let used = allocation_counter::measure(|| world.run_schedule(PhysicsSchedule));
    assert_eq!(used.count_total, 0, "{used:?}");
}

#[test]
fn a_tower_that_slept_stays_exactly_where_it_was() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let tower = stack(&mut world, 0.0, 10);
    world.insert_resource(Diagnostics::default());
    run(&mut world, 4.0);
    assert_asleep(&world, &tower, true, "the tower");
    let pose = |world: &World| {
        tower.iter().map(|&body| (position(world, body), world.get::<Rotation>(body).unwrap().0)).collect::<Vec<_>>()
    };
    let (before, energy) = (pose(&world), world.resource::<Diagnostics>().energy());
    run(&mut world, 10.0);
    assert_eq!(pose(&world), before);
    // Σ m g y of what sleeps counts like that of what does not.
    let mass = 1000.0;
    let potential: f64 = before.iter().map(|(position, _)| mass * 9.81 * position.y).sum();
    assert_close(energy, potential, 1e-9 * potential);
    assert_eq!(world.resource::<Diagnostics>().energy(), energy);
}

/// What somebody may do to the lower of two blocks, or to all the world.
type Edit = (&'static str, fn(&mut World, Entity));

const EDITS: [Edit; 18] = [
    ("velocity", |world, body| world.get_mut::<Velocity>(body).unwrap().linear.x = 0.001),
    ("spin", |world, body| world.get_mut::<Velocity>(body).unwrap().angular.y = 0.001),
    ("position", |world, body| world.get_mut::<Position>(body).unwrap().0.x += 0.001),
    ("rotation", |world, body| world.get_mut::<Rotation>(body).unwrap().0 = DQuat::from_rotation_y(0.01)),
    ("transform", |world, body| world.get_mut::<Transform>(body).unwrap().translation.x += 0.01),
    ("force", |world, body| _ = world.entity_mut(body).insert(ExternalForce { force: DVec3::X, ..default() })),
    ("mass", |world, body| world.get_mut::<Mass>(body).unwrap().0 *= 2.0),
    ("inertia", |world, body| world.get_mut::<Inertia>(body).unwrap().0 *= 2.0),
    ("density", |world, body| _ = world.entity_mut(body).insert(Density(500.0))),
    ("shape", |world, body| _ = world.entity_mut(body).insert(Collider::cuboid(1.1, 1.0, 1.0))),
    ("layers", |world, body| _ = world.entity_mut(body).insert(CollisionLayers { memberships: 1, filters: u32::MAX })),
    ("material", |world, body| _ = world.entity_mut(body).insert(SurfaceMaterial { friction: 0.1, restitution: 0.0 })),
    ("gravity scale", |world, body| _ = world.entity_mut(body).insert(GravityScale(0.5))),
    ("drag", |world, body| _ = world.entity_mut(body).insert(Damping { linear: 1.0, angular: 0.0 })),
    ("locks", |world, body| _ = world.entity_mut(body).insert(LockedAxes { rotation: [true; 3], ..default() })),
    ("kind", |world, body| *world.get_mut::<RigidBody>(body).unwrap() = RigidBody::Static),
    ("end", |world, body| _ = world.despawn(body)),
    ("wake-up call", |world, body| _ = world.entity_mut(body).remove::<Sleeping>()),
];

#[test]
fn whoever_writes_to_a_body_wakes_its_island_and_no_other() {
    for (what, edit) in EDITS {
        let (mut world, _, pile, far) = sleepers();
        edit(&mut world, pile[0]);
        step(&mut world);
        assert_asleep(&world, &pile[1..], false, what);
        assert!(world.get_entity(pile[0]).is_err() || !sleeps(&world, pile[0]), "{what}");
        assert!(sleeps(&world, far), "{what}");
        assert_eq!(stats(&world).sleeping, 1, "{what}");
    }
}

#[test]
fn whoever_wakes_is_moved_in_the_same_step() {
    let (mut world, _, pile, _) = sleepers();
    let before = position(&world, pile[1]);
    world.get_mut::<Velocity>(pile[1]).unwrap().linear.y = 3.0;
    step(&mut world);
    assert_close(position(&world, pile[1]).y - before.y, 3.0 / 60.0, 0.003);
    // Under the one that wakes of itself, too: nothing holds it any more.
    let (mut world, _, pile, _) = sleepers();
    let before = position(&world, pile[1]);
    world.despawn(pile[0]);
    step(&mut world);
    assert_close(velocity(&world, pile[1]).y, -9.81 / 60.0, 1e-9);
    assert!(position(&world, pile[1]).y < before.y);
}

#[test]
fn gravity_and_settings_wake_everybody() {
    let edits: [(&str, fn(&mut World)); 4] = [
        ("gravity", |world| world.resource_mut::<Gravity>().0.x = 0.1),
        ("drag", |world| world.resource_mut::<SolverSettings>().drag = 0.1),
        ("iterations", |world| world.resource_mut::<SolverSettings>().iterations = 2),
        ("another method", |world| *world.resource_mut::<SolverSettings>() = SolverSettings::steady()),
    ];
    for (what, edit) in edits {
        let (mut world, _, pile, far) = sleepers();
        edit(&mut world);
        step(&mut world);
        assert_asleep(&world, &[pile[0], pile[1], far], false, what);
        assert_eq!(stats(&world).sleeping, 0, "{what}");
    }
}

/// A block asleep on a slab.
fn on_a_slab(kind: RigidBody) -> (World, Entity, Entity) {
    let mut world = world_with(GAME());
    let slab = world.spawn((kind, Collider::cuboid(4.0, 1.0, 4.0), Position(DVec3::Y * 10.0))).id();
    let block = block(&mut world, 0.0, 11.0);
    run(&mut world, 2.0);
    assert!(sleeps(&world, block));
    (world, slab, block)
}

#[test]
fn what_becomes_of_the_ground_wakes_what_lies_on_it() {
    let (mut world, slab, block) = on_a_slab(RigidBody::Static);
    world.despawn(slab);
    step(&mut world);
    assert!(!sleeps(&world, block));
    assert_close(velocity(&world, block).y, -9.81 / 60.0, 1e-9);

    let (mut world, slab, block) = on_a_slab(RigidBody::Static);
    world.get_mut::<Position>(slab).unwrap().0.y -= 1.0;
    run(&mut world, 0.25);
    assert_close(velocity(&world, block).y, -9.81 / 4.0, 0.1);

    // Something put beside it, a little into it.
    let (mut world, _, block) = on_a_slab(RigidBody::Static);
    let wall = (RigidBody::Static, Collider::cuboid(1.0, 1.0, 1.0), Position(DVec3::new(0.95, 11.0, 0.0)));
    world.spawn(wall);
    step(&mut world);
    assert!(!sleeps(&world, block));
    run(&mut world, 1.0);
    assert!(position(&world, block).x < -0.03, "it was pushed out");
}

#[test]
fn a_kinematic_body_wakes_what_it_carries_only_while_it_moves() {
    let (mut world, lift, block) = on_a_slab(RigidBody::Kinematic);
    world.get_mut::<Velocity>(lift).unwrap().linear.y = 0.5;
    let start = position(&world, block).y;
    steps(&mut world, 60);
    assert!(!sleeps(&world, block));
    assert_close(position(&world, block).y, start + 0.5, 0.01);
    world.get_mut::<Velocity>(lift).unwrap().linear.y = 0.0;
    run(&mut world, 2.0);
    assert!(sleeps(&world, block), "on a lift that stands");
    // Slower than what counts as calm: by itself, and by hand.
    let start = position(&world, block).y;
    world.get_mut::<Velocity>(lift).unwrap().linear.y = 0.01;
    for _ in 0..120 {
        step(&mut world);
        assert!(!sleeps(&world, block));
    }
    assert_close(position(&world, block).y, start + 0.02, 1e-3);
    world.get_mut::<Velocity>(lift).unwrap().linear.y = 0.0;
    run(&mut world, 2.0);
    assert!(sleeps(&world, block), "again on a lift that stands");
    for _ in 0..90 {
        world.get_mut::<Position>(lift).unwrap().0.y += 1e-4;
        step(&mut world);
        assert!(!sleeps(&world, block));
    }
    assert_close(position(&world, block).y, position(&world, lift).y + 1.0, 0.002);
}

#[test]
fn a_kinematic_body_that_comes_along_wakes_what_it_comes_near() {
    let (mut world, _, pile, far) = sleepers();
    let pusher = (RigidBody::Kinematic, Collider::cuboid(1.0, 1.0, 1.0), Position(DVec3::new(-2.0, 0.5, 0.0)));
    let pusher = world.spawn(pusher).id();
    steps(&mut world, 5);
    assert_asleep(&world, &pile, true, "it stands, and not near");
    world.get_mut::<Velocity>(pusher).unwrap().linear.x = 1.0;
    run(&mut world, 1.5);
    assert!(position(&world, pile[0]).x > 0.4, "pushed along");
    assert!(sleeps(&world, far));
}

#[test]
fn a_ball_that_lands_on_a_sleeping_stack_wakes_all_of_it_and_only_it() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let (hit, spared) = (stack(&mut world, 0.0, 4), stack(&mut world, 3.0, 4));
    run(&mut world, 3.0);
    let ball = body(&mut world, Collider::sphere(0.3), DVec3::new(0.0, 6.0, 0.0));
    let mut had_touched = false;
    while !had_touched {
        step(&mut world);
        assert!(velocity(&world, ball).y < 0.0, "it falls until then");
        had_touched = hit.iter().any(|&body| !sleeps(&world, body));
        assert_asleep(&world, &hit, !had_touched, "all or none");
        assert_asleep(&world, &spared, true, "the other stack");
        assert!(had_touched || position(&world, ball).y > 4.3, "it fell into what sleeps");
    }
    assert!(position(&world, ball).y < 4.6, "woken from afar");
    // One island by now: asleep together.
    run(&mut world, 0.4);
    assert_asleep(&world, &hit, false, "half a second has not passed");
    let all = [&hit[..], &[ball]].concat();
    for _ in 0..600 {
        step(&mut world);
        let sleeping = all.iter().filter(|&&body| sleeps(&world, body)).count();
        let is_off = position(&world, ball).y < 4.0;
        assert!(is_off || sleeping == 0 || sleeping == all.len(), "{sleeping} of {}", all.len());
    }
    assert_asleep(&world, &hit, true, "in the end");
    assert_asleep(&world, &spared, true, "all the while");
}

#[test]
fn a_row_without_its_middle_falls_asleep_in_two_halves() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let row: Vec<Entity> = (0..5).map(|index| block(&mut world, f64::from(index), 0.5)).collect();
    run(&mut world, 2.0);
    assert_asleep(&world, &row, true, "one row");
    world.despawn(row[2]);
    step(&mut world);
    let (left, right) = (&row[..2], &row[3..]);
    assert_asleep(&world, &[left, right].concat(), false, "without the middle");
    run(&mut world, 2.0);
    assert_asleep(&world, &[left, right].concat(), true, "two halves");
    world.get_mut::<Velocity>(row[0]).unwrap().linear.y = 0.5;
    step(&mut world);
    assert_asleep(&world, left, false, "the left half");
    assert_asleep(&world, right, true, "the right half");
}

/// Two bobs, one below the other, asleep on joints to a post.
fn hanging() -> (World, Entity, [Entity; 2], [Entity; 2]) {
    let mut world = world_with(GAME());
    let post = world.spawn((RigidBody::Static, Position(DVec3::Y * 10.0))).id();
    let bobs = [9.0, 8.0].map(|y| body(&mut world, Collider::sphere(0.2), DVec3::Y * y));
    let upper = world.spawn((BallJoint::new(post, bobs[0]).with_anchors(DVec3::ZERO, DVec3::Y), JointLoad::default()));
    let upper = upper.id();
    let lower = BallJoint::new(bobs[0], bobs[1]).with_anchors(-DVec3::Y * 0.5, DVec3::Y * 0.5);
    let lower = world.spawn(lower).id();
    run(&mut world, 1.5);
    assert_asleep(&world, &bobs, true, "hanging");
    (world, post, bobs, [upper, lower])
}

#[test]
fn a_joint_that_comes_changes_or_goes_wakes_both_sides() {
    let (mut world, post, bobs, _) = hanging();
    world.spawn(BallJoint::new(post, bobs[1]).with_anchors(-DVec3::Y * 2.0, DVec3::ZERO));
    step(&mut world);
    assert_asleep(&world, &bobs, false, "another joint");

    let (mut world, _, bobs, [_, lower]) = hanging();
    world.get_mut::<BallJoint>(lower).unwrap().anchor_a.x += 0.01;
    step(&mut world);
    assert_asleep(&world, &bobs, false, "another anchor");

    let (mut world, _, bobs, [upper, _]) = hanging();
    world.despawn(upper);
    step(&mut world);
    assert_asleep(&world, &bobs, false, "a joint less");
    assert_close(velocity(&world, bobs[1]).y, -9.81 / 60.0, 1e-6);

    let (mut world, _, bobs, _) = hanging();
    world.despawn(bobs[1]);
    step(&mut world);
    assert!(!sleeps(&world, bobs[0]), "without its partner");

    let (mut world, post, bobs, _) = hanging();
    world.despawn(post);
    step(&mut world);
    assert_asleep(&world, &bobs, false, "without the post");
    assert_close(velocity(&world, bobs[0]).y, -9.81 / 60.0, 1e-6);
}

#[test]
fn a_handle_that_pulls_keeps_its_island_awake() {
    // As the sandbox drags: by a soft joint to a kinematic body that is put where the pointer is.
    let (mut world, _, pile, far) = sleepers();
    let handle = world.spawn((RigidBody::Kinematic, Position(DVec3::Y * 1.5))).id();
    let softness = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: 1e5 };
    world.spawn(BallJoint::new(handle, pile[1]).with_softness(softness));
    run(&mut world, 2.0);
    assert_asleep(&world, &pile, true, "held, and still");
    world.get_mut::<Position>(handle).unwrap().0.y += 1.0;
    step(&mut world);
    assert_asleep(&world, &pile, false, "pulled");
    run(&mut world, 1.0);
    assert_close(position(&world, pile[1]).y, 2.5, 0.1);
    assert!(sleeps(&world, far));
}

#[test]
fn neither_sleep_nor_waking_is_a_contact_that_ends_or_starts() {
    let (mut world, _, pile, _) = sleepers();
    let nothing = |world: &mut World, what: &str| {
        let (started, ended) = (take::<ContactStarted>(world).len(), take::<ContactEnded>(world).len());
        assert_eq!((started, ended), (0, 0), "{what}");
    };
    assert_eq!(take::<ContactStarted>(&mut world).len(), 0, "long told");
    steps(&mut world, 20);
    nothing(&mut world, "asleep");
    world.get_mut::<Velocity>(pile[0]).unwrap().set_changed();
    for _ in 0..20 {
        step(&mut world);
        nothing(&mut world, "awake");
    }
    assert!(!sleeps(&world, pile[0]));
    for _ in 0..60 {
        step(&mut world);
        nothing(&mut world, "asleep again");
    }
    assert!(sleeps(&world, pile[0]));
    // What ends does end.
    world.despawn(pile[1]);
    step(&mut world);
    assert_eq!(take::<ContactEnded>(&mut world).len(), 1);
}

#[test]
fn who_wakes_goes_on_with_the_forces_it_slept_with() {
    let (mut world, _, pile, _) = sleepers();
    let resting = position(&world, pile[1]).y;
    world.get_mut::<Velocity>(pile[0]).unwrap().set_changed();
    let mut lowest = resting;
    for _ in 0..20 {
        step(&mut world);
        lowest = lowest.min(position(&world, pile[1]).y);
    }
    // From forces of zero the springs would give way by far more.
    assert!(resting - lowest < 1e-6, "it sank by {}", resting - lowest);
}

#[test]
fn loads_of_what_sleeps_keep_their_last_values() {
    let (mut world, _, pile, _) = sleepers();
    let weight = 1000.0 * 9.81;
    // Asked for when all is asleep already, and when it is not.
    world.insert_resource(ContactForces::default());
    for what in ["asleep", "awake", "asleep again"] {
        step(&mut world);
        let forces = &world.resource::<ContactForces>().0;
        let lift: DVec3 = forces
            .iter()
            .filter(|force| !pile.contains(&force.a) || !pile.contains(&force.b))
            .map(|force| if force.normal.y > 0.0 { force.force } else { -force.force })
            .sum();
        assert_near(lift, DVec3::Y * 3.0 * weight, 0.01 * weight);
        if what == "asleep" {
            world.get_mut::<Velocity>(pile[0]).unwrap().set_changed();
        } else {
            run(&mut world, 2.0);
        }
    }
    let (mut world, _, bobs, [upper, _]) = hanging();
    let weight = 9.81 * (world.get::<Mass>(bobs[0]).unwrap().0 + world.get::<Mass>(bobs[1]).unwrap().0);
    steps(&mut world, 5);
    assert_near(world.get::<JointLoad>(upper).unwrap().force, DVec3::Y * weight, 1e-3 * weight);
}

/// Stacks and hanging things at rest, and a ball that comes among them.
fn quarter(settings: SolverSettings) -> World {
    let mut world = world_with(settings);
    ground(&mut world);
    for index in 0..6 {
        stack(&mut world, 3.0 * f64::from(index), 3);
        let post = world.spawn((RigidBody::Static, Position(DVec3::new(3.0 * f64::from(index), 9.0, 0.0)))).id();
        let bob = body(&mut world, Collider::sphere(0.2), DVec3::new(3.0 * f64::from(index), 8.0, 0.0));
        world.spawn(BallJoint::new(post, bob).with_anchors(DVec3::ZERO, DVec3::Y));
    }
    world
}

#[test]
fn sleep_and_waking_are_the_same_bits_on_any_number_of_threads() {
    let hashes: Vec<Vec<u64>> = [1, 2, 4, 1]
        .into_iter()
        .map(|threads| {
            let mut world = quarter(SolverSettings { threads, ..GAME() });
            let mut asleep = Vec::new();
            let hashes = (0..8).map(|round| {
                if round == 3 {
                    let ball = body(&mut world, Collider::sphere(0.5), DVec3::new(-3.0, 2.0, 0.0));
                    world.get_mut::<Velocity>(ball).unwrap().linear.x = 12.0;
                }
                steps(&mut world, 25);
                asleep.push(stats(&world).sleeping);
                state_hash(&world)
            });
            let hashes = hashes.collect();
            assert!(asleep.contains(&24) && asleep[4] < 24 && asleep[4] > 0, "{asleep:?}");
            hashes
        })
        .collect();
    assert!(hashes.iter().all(|of_run| *of_run == hashes[0]), "{hashes:?}");
}

#[test]
fn until_the_first_island_sleeps_nothing_tells_that_it_may() {
    let (mut one, mut other) = (quarter(GAME()), quarter(awake_game()));
    let mut same = 0;
    while stats(&one).sleeping == 0 {
        assert_eq!(state_hash(&one), state_hash(&other), "after {same} steps");
        step(&mut one);
        step(&mut other);
        same += 1;
    }
    assert!(same > 30, "{same} steps");
    run(&mut other, 5.0);
    assert_eq!(stats(&other).sleeping, 0);
}

#[test]
fn what_is_slow_but_speeds_up_stays_awake() {
    // Released horizontally: at rest for an instant, and again at each turning point.
    let swing = |gravity: f64, seconds: f64| {
        let mut world = world_with(GAME());
        world.insert_resource(Gravity(DVec3::NEG_Y * gravity));
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let bob = body(&mut world, Collider::sphere(0.2), DVec3::X);
        world.spawn(BallJoint::new(post, bob).with_anchors(DVec3::ZERO, -DVec3::X));
        run(&mut world, seconds);
        assert!(!sleeps(&world, bob), "under {gravity} m/s²");
        let height = position(&world, bob).y;
        (velocity(&world, bob).length_squared() / 2.0 + gravity * height) / gravity
    };
    // In the open, half the energy stays the other's: v²/2 + g y = 0.
    assert_close(swing(9.81, 20.0), 0.0, 0.02);
    assert_close(swing(1e-3, 30.0), 0.0, 0.02);

    let mut world = world_with(GAME());
    world.insert_resource(Gravity(DVec3::NEG_Y * 1e-5));
    let falling = body(&mut world, Collider::sphere(0.2), DVec3::ZERO);
    run(&mut world, 60.0);
    assert_close(position(&world, falling).y, -0.5e-5 * 3600.0, 1e-3);
}

#[test]
fn what_turns_back_on_a_slow_spring_stays_awake() {
    let mut world = world_with(GAME());
    world.insert_resource(Gravity(DVec3::ZERO));
    let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
    let bob = world.spawn((RigidBody::Dynamic, Mass(1.0), Inertia(DVec3::ONE), Position(1.2 * DVec3::X))).id();
    let (omega, rest) = (0.3_f64, 1.0);
    world.spawn(DistanceJoint::spring(post, bob, rest, omega * omega, 0.0));
    for second in 1..=25 {
        run(&mut world, 1.0);
        assert!(!sleeps(&world, bob), "after {second} s");
        let at = rest + 0.2 * (omega * f64::from(second)).cos();
        assert_close(position(&world, bob).x, at, 2e-3);
    }
}

#[test]
fn what_creeps_faster_than_the_limit_stays_awake() {
    let mut world = world_with(GAME());
    let floor = ground(&mut world);
    world.entity_mut(floor).insert(SurfaceMaterial { friction: 0.0, restitution: 0.0 });
    let [slow, quick] = [0.0, 5.0].map(|x| block(&mut world, x, 0.5));
    run(&mut world, 0.2);
    world.get_mut::<Velocity>(slow).unwrap().linear.z = 0.019;
    world.get_mut::<Velocity>(quick).unwrap().linear.z = 0.021;
    run(&mut world, 5.0);
    assert!(sleeps(&world, slow));
    assert!(!sleeps(&world, quick));
    assert_close(velocity(&world, quick).z, 0.021, 1e-6);
}

#[test]
fn what_nothing_holds_sleeps_only_where_nothing_moves_it() {
    let mut world = weightless(GAME());
    let [still, drifting, turning] = [0.0, 5.0, 10.0].map(|x| block(&mut world, x, 0.0));
    world.get_mut::<Velocity>(drifting).unwrap().linear.y = 0.001;
    world.get_mut::<Velocity>(turning).unwrap().angular.y = 0.001;
    // Two that only hold each other.
    let pair = [block(&mut world, 20.0, 0.0), block(&mut world, 22.0, 0.0)];
    world.spawn(BallJoint::new(pair[0], pair[1]).with_anchors(DVec3::X, -DVec3::X));
    pair.iter().for_each(|&body| world.get_mut::<Velocity>(body).unwrap().linear.y = 0.001);
    run(&mut world, 3.0);
    assert!(sleeps(&world, still));
    assert_asleep(&world, &[drifting, turning, pair[0], pair[1]], false, "they move");
    assert_close(position(&world, drifting).y, 0.003, 1e-9);
    assert_close(position(&world, pair[1]).y, 0.003, 1e-9);
}

#[test]
fn nobody_sleeps_where_contacts_do_not_last_or_sleep_is_off() {
    let on = |settings| SolverSettings { impulse: GAME().impulse, ..settings };
    for settings in [SolverSettings::classic(), SolverSettings::steady(), on(SolverSettings::steady()), awake_game()] {
        let mut world = world_with(settings);
        ground(&mut world);
        let pile = stack(&mut world, 0.0, 2);
        run(&mut world, 2.0);
        assert_asleep(&world, &pile, false, "awake");
    }
}

#[test]
fn a_sleeper_that_makes_no_sense_is_quarantined_and_sleeps_again_when_it_does() {
    let (mut world, _, pile, far) = sleepers();
    world.get_mut::<Velocity>(pile[1]).unwrap().linear.x = f64::NAN;
    step(&mut world);
    assert!(world.get::<Quarantined>(pile[1]).is_some());
    assert_asleep(&world, &pile, false, "one is quarantined");
    run(&mut world, 2.0);
    assert!(sleeps(&world, pile[0]) && !sleeps(&world, pile[1]), "what does not move does not sleep");
    world.entity_mut(pile[1]).remove::<Quarantined>();
    step(&mut world);
    assert_asleep(&world, &pile, false, "let go");
    run(&mut world, 2.0);
    assert_asleep(&world, &pile, true, "again");
    assert!(sleeps(&world, far));
}

#[test]
fn a_mark_that_somebody_else_puts_on_comes_off() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let falling = block(&mut world, 0.0, 5.0);
    world.entity_mut(falling).insert(Sleeping);
    step(&mut world);
    assert!(!sleeps(&world, falling));
    world.entity_mut(falling).insert(Sleeping);
    step(&mut world);
    assert!(!sleeps(&world, falling));
    assert_close(velocity(&world, falling).y, -9.81 / 30.0, 1e-9);
}

#[test]
fn who_is_no_body_any_more_does_not_sleep() {
    let (mut world, _, pile, far) = sleepers();
    world.entity_mut(far).remove::<RigidBody>();
    step(&mut world);
    assert!(!sleeps(&world, far));
    assert_eq!(stats(&world).sleeping, 2);
    assert_asleep(&world, &pile, true, "others");
    // Others have other places in the list now, and still wake.
    world.get_mut::<Velocity>(pile[1]).unwrap().linear.y = 2.0;
    step(&mut world);
    assert_asleep(&world, &pile, false, "others");
    world.entity_mut(far).insert(RigidBody::Dynamic);
    step(&mut world);
    assert!(!sleeps(&world, far));
    run(&mut world, 2.0);
    assert_asleep(&world, &[pile[0], pile[1], far], true, "all");
}

#[test]
fn bodies_after_one_that_is_gone_sleep_on() {
    let mut world = world_with(GAME());
    ground(&mut world);
    let (first, second) = (stack(&mut world, 0.0, 2), stack(&mut world, 5.0, 2));
    run(&mut world, 2.0);
    world.despawn(first[1]);
    step(&mut world);
    assert!(!sleeps(&world, first[0]));
    assert_asleep(&world, &second, true, "the other stack");
    let ball = body(&mut world, Collider::sphere(0.3), DVec3::new(5.0, 3.0, 0.0));
    run(&mut world, 0.6);
    assert_asleep(&world, &second, false, "hit");
    assert!(position(&world, ball).y > 2.2);
}

#[test]
fn what_sleeps_is_drawn_where_it_lies() {
    start_pool();
    let mut app = App::new();
    // Frames of 7 ms against steps of 1/60 s, and poses drawn in between.
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin, PhysicsPlugin::default()))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(7)))
        .insert_resource(GAME());
    app.finish();
    app.cleanup();
    let floor = ground(app.world_mut());
    app.world_mut().entity_mut(floor).insert(SurfaceMaterial { friction: 0.0, restitution: 0.0 });
    let body = block(app.world_mut(), 0.0, 0.5);
    // It glides until it sleeps, 0.17 mm a step.
    app.world_mut().get_mut::<Velocity>(body).unwrap().linear.x = 0.01;
    (0..150).for_each(|_| app.update());
    let drawn = |app: &App| app.world().get::<Transform>(body).unwrap().translation;
    assert!(sleeps(app.world(), body));
    assert_eq!(drawn(&app), position(app.world(), body).as_vec3());
    app.insert_resource(RenderOrigin(DVec3::X * 4.0));
    app.update();
    assert_eq!(drawn(&app), (position(app.world(), body) - DVec3::X * 4.0).as_vec3());
    assert!(sleeps(app.world(), body));
}
