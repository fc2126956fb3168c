//! Going back to any step and on again: the same bits, whatever happened in between.

use std::collections::BTreeMap;

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BrokenJoint, GoError, History, Mark, bury, go_to, swap_cut, take_back_since, uncut};
use plumb::prelude::*;
use plumb::scene::{catalog, load};

use crate::matrix::{ENGINES, Engine};
use crate::rig::*;

/// More than any test keeps, bytes.
const ENOUGH: usize = 1 << 30;

/// A scene whose history is kept from its start.
fn kept(settings: SolverSettings, scene: &str, parameters: &[(&str, f64)]) -> World {
    let mut world = world_with(settings);
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(scene, &parameters).unwrap().spawn(&mut world);
    History::begin(&mut world, ENOUGH);
    world
}

/// Makes so many steps, with what `act` does after each, and tells the hash of the state after that.
fn play(world: &mut World, count: u64, mut act: impl FnMut(&mut World, u64)) -> BTreeMap<u64, u64> {
    let mut hashes = BTreeMap::new();
    for _ in 0..count {
        step(world);
        let made = world.resource::<StepStats>().steps;
        act(world, made);
        hashes.insert(made, state_hash(world));
    }
    hashes
}

/// Goes back to some of the steps and on from there, and compares what comes out.
fn check_all(world: &mut World, hashes: &BTreeMap<u64, u64>, stops: impl IntoIterator<Item = u64>, what: &str) {
    let last = *hashes.keys().last().unwrap();
    for stop in stops {
        go_to(world, stop).unwrap();
        assert_eq!(world.resource::<StepStats>().steps, stop, "{what}");
        for made in stop + 1..=last {
            step(world);
            assert_eq!(state_hash(world), hashes[&made], "{what}: back to {stop}, on to {made}");
        }
        assert_eq!(world.resource::<History>().reach()[1], last, "{what}: nothing new happened");
    }
}

fn nothing(_: &mut World, _: u64) {}

#[test]
fn every_scene_goes_on_from_where_it_went_back_to() {
    for scene in catalog() {
        let mut world = kept(SolverSettings::game(), scene.name, &[]);
        let hashes = play(&mut world, 60, nothing);
        check_all(&mut world, &hashes, [37, 0, 52], scene.name);
    }
}

#[test]
fn every_method_goes_on_from_where_it_went_back_to() {
    let lagging = {
        let mut settings = SolverSettings::classic();
        settings.sweeps.contact_lag = 1;
        settings
    };
    let double = SolverSettings { precision: Precision::F64, ..SolverSettings::game() };
    for settings in ENGINES.map(Engine::settings).into_iter().chain([lagging, double]) {
        for (scene, parameters, count) in [("limbs", &[][..], 60), ("ragdolls", &[("n", 1.0)][..], 40)] {
            let what = format!("{settings:?}, {scene}");
            let mut world = kept(settings, scene, parameters);
            let hashes = play(&mut world, count, nothing);
            check_all(&mut world, &hashes, [count / 2, 3], &what);
        }
    }
}

#[test]
fn what_falls_asleep_does_so_again_in_the_same_step() {
    let mut world = kept(SolverSettings::game(), "stack", &[("n", 4.0)]);
    let mut sleepers = BTreeMap::new();
    let hashes = play(&mut world, 200, |world, made| _ = sleepers.insert(made, world.resource::<StepStats>().sleeping));
    assert_eq!(sleepers[&200], 4, "it sleeps in the end");
    let first = *sleepers.iter().find(|(_, count)| **count > 0).unwrap().0;
    for stop in [0, first - 20, first, 190] {
        go_to(&mut world, stop).unwrap();
        for made in stop + 1..=200 {
            step(&mut world);
            assert_eq!(world.resource::<StepStats>().sleeping, sleepers[&made], "back to {stop}, on to {made}");
            assert_eq!(state_hash(&world), hashes[&made], "back to {stop}, on to {made}");
        }
    }
}

/// Everything that a user can do to a world, at one step or another.
fn meddle(world: &mut World, made: u64) {
    let named = |world: &mut World, name: &str| {
        let mut names = world.query::<(Entity, &Name)>();
        names.iter(world).find(|(_, found)| found.as_str() == name).map(|(entity, _)| entity)
    };
    let head = |world: &mut World| named(world, "ann head").unwrap();
    match made {
        5 => {
            let at = DVec3::new(0.3, 3.0, 0.2);
            world.spawn((Name::new("box"), RigidBody::Dynamic, Collider::cuboid(0.4, 0.4, 0.4), Position(at)));
            let hand = world.spawn((Name::new("hand"), RigidBody::Kinematic, Position(at))).id();
            let softness = Softness { frequency: 5.0, damping_ratio: 1.0, max_force: 500.0 };
            let head = head(world);
            world.spawn((Name::new("grip"), BallJoint::new(hand, head).with_softness(softness)));
        }
        6..=20 => {
            let hand = named(world, "hand").unwrap();
            world.get_mut::<Position>(hand).unwrap().0.x -= 0.05;
        }
        21 => {
            for name in ["grip", "hand"] {
                let entity = named(world, name).unwrap();
                assert!(bury(world, entity));
            }
        }
        25 => {
            let head = head(world);
            world.entity_mut(head).insert(ExternalForce { force: DVec3::Y * 300.0, torque: DVec3::ZERO });
        }
        30 => {
            let entity = head(world);
            world.entity_mut(entity).remove::<ExternalForce>();
            world.get_mut::<Velocity>(entity).unwrap().linear.x = 4.0;
        }
        33 => world.resource_mut::<SolverSettings>().substeps = 6,
        36 => world.resource_mut::<Gravity>().0 = DVec3::new(1.0, -9.0, 0.0),
        40 => {
            let joints: Vec<Entity> = world.query_filtered::<Entity, With<BallJoint>>().iter(world).take(2).collect();
            assert_eq!(joints.len(), 2);
            joints.into_iter().for_each(|joint| _ = bury(world, joint));
        }
        44 => {
            let entity = named(world, "box").unwrap();
            world.get_mut::<Transform>(entity).unwrap().translation = Vec3::new(0.0, 4.0, 0.0);
        }
        48 => {
            let entity = named(world, "box").unwrap();
            world
                .entity_mut(entity)
                .insert((Collider::sphere(0.3), SurfaceMaterial { friction: 0.1, restitution: 0.5 }));
        }
        // A body whose joints go with it.
        55 => {
            let entity = named(world, "bo chest").unwrap();
            assert!(bury(world, entity));
        }
        _ => {}
    }
}

#[test]
fn what_was_done_is_done_again() {
    for settings in [SolverSettings::game(), SolverSettings::classic()] {
        let mut world = kept(settings, "limbs", &[]);
        let mut plain = world_with(settings);
        load("limbs", &[]).unwrap().spawn(&mut plain);
        let hashes = play(&mut world, 80, meddle);
        // Who keeps a history has the same one.
        let despawned = play(&mut plain, 80, meddle);
        assert_eq!(hashes, despawned, "{:?}", settings.method);
        let entities = world.query::<&RigidBody>().iter(&world).count();
        check_all(&mut world, &hashes, [79, 40, 20, 5, 0, 54, 56, 33], &format!("{:?}", settings.method));
        assert_eq!(world.query::<&RigidBody>().iter(&world).count(), entities);
        // It is as it is told, on the way back as well.
        go_to(&mut world, 20).unwrap();
        assert_eq!(world.resource::<SolverSettings>().substeps, settings.substeps);
        let names: Vec<_> = world.query::<&Name>().iter(&world).map(Name::as_str).collect();
        assert!(["box", "hand", "grip", "bo chest"].iter().all(|name| names.contains(name)));
        // At the place of an act it has been done.
        go_to(&mut world, 21).unwrap();
        assert!(world.query::<&Name>().iter(&world).all(|name| name.as_str() != "hand"));
    }
}

#[test]
fn what_broke_is_whole_again() {
    let mut world = kept(SolverSettings::game(), "tower", &[("n", 3.0), ("f", 200.0)]);
    let hashes = play(&mut world, 90, nothing);
    let broken = |world: &mut World| world.query::<&BrokenJoint>().iter(world).count();
    assert!(broken(&mut world) > 0);
    check_all(&mut world, &hashes, [70, 30], "tower");
    go_to(&mut world, 0).unwrap();
    assert_eq!(broken(&mut world), 0);
}

#[test]
fn what_is_done_in_the_past_ends_what_was_to_come() {
    let mut world = kept(SolverSettings::game(), "limbs", &[]);
    let hashes = play(&mut world, 60, meddle);
    go_to(&mut world, 31).unwrap();
    world.resource_mut::<Gravity>().0 = DVec3::X;
    let others = play(&mut world, 10, nothing);
    assert_eq!(world.resource::<History>().reach(), [0, 41]);
    assert_ne!(others[&32], hashes[&32]);
    check_all(&mut world, &others, [31, 32], "the new future");
    // And back into what was to come first: all as it was.
    let last_of_others = others.keys().last().copied().unwrap();
    go_to(&mut world, last_of_others).unwrap();
    let cut = world.resource::<History>().cuts();
    assert_eq!((cut, world.resource::<History>().turns()), (1, 1));
    uncut(&mut world, cut).unwrap();
    assert_eq!(world.resource::<History>().turns(), 2);
    assert_eq!((world.resource::<StepStats>().steps, world.resource::<History>().reach()), (31, [0, 60]));
    check_all(&mut world, &hashes, [31, 20, 58], "what was to come");
    assert_eq!(uncut(&mut world, cut), Err(GoError::NoHistory));
    go_to(&mut world, 31).unwrap();
    world.resource_mut::<Gravity>().0 = DVec3::X;
    assert_eq!(play(&mut world, 10, nothing), others);
    // Who only looks does nothing.
    go_to(&mut world, 35).unwrap();
    let joints: Vec<Entity> = world.query_filtered::<Entity, With<BallJoint>>().iter(&world).collect();
    joints.into_iter().for_each(|joint| _ = world.entity_mut(joint).insert(JointLoad::default()));
    step(&mut world);
    assert_eq!(state_hash(&world), others[&36]);
    assert_eq!(world.resource::<History>().reach(), [0, 41]);
    assert_eq!(world.resource::<History>().turns(), 3);
    let before: BTreeMap<_, _> = hashes.range(..=31).map(|(step, hash)| (*step, *hash)).collect();
    go_to(&mut world, 0).unwrap();
    for (made, hash) in before {
        step(&mut world);
        assert_eq!(state_hash(&world), hash, "step {made} of what was before");
    }
}

#[test]
fn what_was_done_in_the_past_and_what_was_to_come_change_places() {
    let mut world = kept(SolverSettings::game(), "limbs", &[]);
    let hashes = play(&mut world, 60, meddle);
    let turn = |world: &mut World, back_to: u64, down: DVec3| {
        go_to(world, back_to).unwrap();
        world.resource_mut::<Gravity>().0 = down;
        play(world, 10, nothing)
    };
    let others = turn(&mut world, 31, DVec3::X);
    let inner = turn(&mut world, 35, DVec3::Z);
    for _ in 0..2 {
        check_all(&mut world, &inner, [36, 40], "what was done in what was done instead");
        swap_cut(&mut world, 2).unwrap();
        check_all(&mut world, &others, [33, 38], "what was done instead");
        swap_cut(&mut world, 1).unwrap();
        assert_eq!(world.resource::<StepStats>().steps, 31);
        check_all(&mut world, &hashes, [31, 20, 58], "what was to come");
        // What was done within it is not there meanwhile.
        assert_eq!(swap_cut(&mut world, 2), Err(GoError::NoHistory));
        swap_cut(&mut world, 1).unwrap();
        swap_cut(&mut world, 2).unwrap();
    }
}

#[test]
fn what_was_done_since_a_mark_is_as_if_it_had_never_been() {
    let mut world = kept(SolverSettings::game(), "limbs", &[]);
    let hashes = play(&mut world, 60, meddle);
    for step in [60, 47, 15] {
        go_to(&mut world, step).unwrap();
        let mark = Mark::of(&mut world).unwrap();
        assert_eq!(Mark::of(&mut world), Some(mark));
        for _ in 0..2 {
            world.resource_mut::<Gravity>().0 = DVec3::X;
            let body = world.query_filtered::<Entity, With<RigidBody>>().iter(&world).last().unwrap();
            bury(&mut world, body);
            assert_ne!(Mark::of(&mut world), Some(mark));
            assert_eq!(world.resource::<History>().reach()[1], step, "what was to come is not");
        }
        take_back_since(&mut world, mark).unwrap();
        assert_eq!((state_hash(&world), world.resource::<History>().reach()), (hashes[&step], [0, 60]));
        check_all(&mut world, &hashes, [step.min(59), 10], "as if nothing had been done");
    }
    go_to(&mut world, 20).unwrap();
    let mark = Mark::of(&mut world).unwrap();
    step(&mut world);
    assert_eq!(take_back_since(&mut world, mark), Err(GoError::NoHistory));
}

#[test]
fn what_is_out_of_reach_is_said_and_nothing_changes() {
    let mut world = kept(SolverSettings::game(), "stack", &[("n", 3.0)]);
    let hashes = play(&mut world, 40, nothing);
    assert_eq!(go_to(&mut world, 41), Err(GoError::OutOfReach { step: 41, first: 0, last: 40 }));
    assert_eq!(state_hash(&world), hashes[&40]);
    let body = world.query_filtered::<Entity, With<Collider>>().iter(&world).last().unwrap();
    world.despawn(body);
    assert_eq!(go_to(&mut world, 10), Err(GoError::Gone(body)));
    assert_eq!(world.resource::<StepStats>().steps, 40);
    History::end(&mut world);
    assert_eq!(go_to(&mut world, 10), Err(GoError::NoHistory));
}

#[test]
fn old_keyframes_thin_out_and_no_emptied_entity_stays_behind() {
    let mut world = world_with(SolverSettings::game());
    load("limbs", &[]).unwrap().spawn(&mut world);
    steps(&mut world, 30);
    History::begin(&mut world, ENOUGH);
    History::end(&mut world);
    let entities = world.entities().count_spawned();
    History::begin(&mut world, ENOUGH);
    let limit = 3 * world.resource::<History>().bytes();
    History::begin(&mut world, limit);
    play(&mut world, 200, |world, made| {
        if made % 10 == 0 {
            let body = world.spawn((RigidBody::Dynamic, Collider::sphere(0.1), Position(DVec3::Y * 9.0))).id();
            step(world);
            bury(world, body);
        }
    });
    let made = world.resource::<StepStats>().steps;
    let history = world.resource::<History>();
    assert!(history.bytes() <= limit, "{} of {limit}", history.bytes());
    let frames: Vec<u64> = history.keyframes().collect();
    assert!((2..=3).contains(&frames.len()) && frames[0] == 30, "{frames:?}");
    assert_eq!(history.reach(), [30, made]);
    // What is emptied by going back goes, too.
    world.spawn((RigidBody::Dynamic, Collider::sphere(0.1), Position(DVec3::Y * 9.0)));
    step(&mut world);
    go_to(&mut world, made - 1).unwrap();
    History::end(&mut world);
    assert_eq!(world.entities().count_spawned(), entities);
}

#[test]
fn what_a_history_takes_is_about_what_it_says() {
    start_pool();
    for (scene, parameters, settings) in [
        ("heap", &[("n", 200.0)][..], SolverSettings::game()),
        ("limbs", &[][..], SolverSettings::game()),
        ("joint_grid", &[("n", 12.0)][..], SolverSettings::game()),
        ("pyramid", &[][..], SolverSettings::classic()),
    ] {
        let mut world = world_with(settings);
        let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        load(scene, &parameters).unwrap().spawn(&mut world);
        steps(&mut world, 120);
        let used = allocation_counter::measure(|| History::begin(&mut world, ENOUGH));
        let (takes, says) = (used.bytes_current as f64, world.resource::<History>().bytes() as f64);
        println!("{scene}: {takes} bytes, told as {says}");
        assert!((0.5..2.0).contains(&(says / takes)), "{scene}: {takes} bytes, told as {says}");
    }
}
