//! Anything that hands can do, at random: nothing breaks, and going back and on again is always the same, and so is a recording of all of it.

use std::hash::{DefaultHasher, Hasher};
use std::path::Path;

use bevy::math::{DVec3, Vec2};
use bevy::prelude::*;
use plumb::lab::recording::{Numbers, Print, Recording, Replay};
use plumb::physics::{Breakable, History, Position, RigidBody, StepStats, Velocity, hash_state};
use plumb::prelude::{Collider, SolverSettings};
use plumb::sandbox::{CurrentScene, JoinKind, Picked, Playback, SandboxAction, Selection};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::stage::{SIZE, Stage};

/// Steps of a run.
const STEPS: u64 = 2_000;
/// Of those, how many one goes back at most.
const BACK: u64 = 40;

fn hash(stage: &Stage) -> u64 {
    let mut hasher = DefaultHasher::new();
    hash_state(stage.app.world(), &mut hasher);
    hasher.finish()
}

fn step(stage: &Stage) -> u64 {
    stage.app.world().resource::<StepStats>().steps
}

fn pause(stage: &mut Stage, paused: bool) {
    stage.world().resource_mut::<Playback>().paused = paused;
    let mut time = stage.world().resource_mut::<Time<Virtual>>();
    if paused { time.pause() } else { time.unpause() }
}

/// A body that moves, at random, and a point of it.
fn any_body(stage: &mut Stage, random: &mut Pcg64Mcg) -> Option<Picked> {
    let world = stage.world();
    let mut bodies = world.query_filtered::<(Entity, &RigidBody), With<Collider>>();
    let mut all: Vec<Entity> =
        bodies.iter(world).filter(|(_, kind)| **kind == RigidBody::Dynamic).map(|(entity, _)| entity).collect();
    all.sort_unstable();
    let entity = *all.get(random.random_range(0..all.len().max(1)))?;
    let point = DVec3::from_array([0, 1, 2].map(|_| random.random_range(-0.1..0.1)));
    Some(Picked { entity, point, normal: Some(DVec3::Y) })
}

fn pick(stage: &mut Stage, random: &mut Pcg64Mcg, two: bool) {
    let body = any_body(stage, random);
    let partner = if two { any_body(stage, random) } else { None };
    *stage.world().resource_mut::<Selection>() = Selection { body, partner };
}

/// Does something, and tells what.
fn deed(stage: &mut Stage, random: &mut Pcg64Mcg) -> String {
    let place = Vec2::new(random.random_range(5.0..SIZE.x - 350.0), random.random_range(5.0..SIZE.y - 80.0));
    match random.random_range(0..16) {
        0 | 1 => {
            stage.jump_to(place);
            stage.press();
            let held = random.random_range(2..20);
            for _ in 0..held {
                let to = place + Vec2::new(random.random_range(-200.0..200.0), random.random_range(-200.0..200.0));
                stage.jump_to(to);
                stage.frames(1);
            }
            // Now and then the hand stays where it is.
            if random.random_bool(0.8) {
                stage.release();
            }
            format!("dragged from {place} for {held} frames")
        }
        2 => {
            stage.jump_to(place);
            stage.act(SandboxAction::ThrowBall);
            "threw a ball".into()
        }
        3 => {
            stage.jump_to(place);
            stage.act(SandboxAction::SpawnBody);
            "added a body".into()
        }
        4 | 5 => {
            let kind = JoinKind::ALL[random.random_range(0..JoinKind::ALL.len())];
            stage.world().insert_resource(kind.0);
            pick(stage, random, true);
            stage.act(SandboxAction::JoinPicked);
            format!("joined by a {}", kind.1)
        }
        6 => {
            pick(stage, random, false);
            stage.act(SandboxAction::PinPicked);
            "pinned".into()
        }
        7 => {
            pick(stage, random, false);
            stage.act(SandboxAction::CutPicked);
            "cut".into()
        }
        8 => {
            pick(stage, random, false);
            stage.act(SandboxAction::DeletePicked);
            "deleted".into()
        }
        9 | 10 => {
            stage.act(SandboxAction::Undo);
            "undid".into()
        }
        11 => {
            let (name, preset) = SolverSettings::PRESETS[random.random_range(0..3)];
            let preset = SolverSettings { threads: 1, ..preset() };
            stage.world().insert_resource(preset);
            format!("chose {name}")
        }
        12 => {
            let [first, last] = stage.app.world().resource::<History>().reach();
            let to = random.random_range(first.max(last.saturating_sub(BACK))..=last);
            stage.act(SandboxAction::GoTo { step: to });
            pause(stage, false);
            format!("went to {to}")
        }
        13 => {
            stage.act(SandboxAction::TogglePlayBackwards);
            stage.frames(random.random_range(1..15));
            stage.act(SandboxAction::TogglePause);
            pause(stage, false);
            "played backwards".into()
        }
        14 => {
            if let Some(Picked { entity, .. }) = any_body(stage, random)
                && let Some(mut velocity) = stage.world().get_mut::<Velocity>(entity)
            {
                velocity.linear += DVec3::new(random.random_range(-3.0..3.0), random.random_range(0.0..4.0), 0.0);
            }
            "pushed".into()
        }
        _ => {
            let world = stage.world();
            let joints: Vec<Entity> =
                world.query_filtered::<Entity, With<plumb::physics::BallJoint>>().iter(world).collect();
            if !joints.is_empty() {
                let joint = joints[random.random_range(0..joints.len())];
                world.entity_mut(joint).insert(Breakable::at_force(200.0).at_once());
            }
            "made a joint brittle".into()
        }
    }
}

/// All is finite; back and on again is the same, and nothing is left over.
fn check(stage: &mut Stage, random: &mut Pcg64Mcg, told: &[String]) {
    let last_deeds = || told.iter().rev().take(12).rev().cloned().collect::<Vec<_>>().join("; ");
    let world = stage.world();
    let mut bodies = world.query::<(&Position, &Velocity)>();
    let is_finite = |(at, v): (&Position, &Velocity)| at.is_finite() && v.linear.is_finite() && v.angular.is_finite();
    assert!(bodies.iter(world).all(is_finite), "not finite after {}", last_deeds());
    pause(stage, true);
    stage.frames(1);
    let (head, before) = (step(stage), hash(stage));
    let [first, _] = stage.app.world().resource::<History>().reach();
    let to = random.random_range(first.max(head.saturating_sub(BACK))..=head);
    stage.act(SandboxAction::GoTo { step: to });
    assert_eq!(step(stage), to, "after {}", last_deeds());
    while step(stage) < head {
        stage.act(SandboxAction::StepOnce);
    }
    assert_eq!(hash(stage), before, "back to {to} and on to {head}, after {}", last_deeds());
    pause(stage, false);
}

#[test]
fn a_monkey_breaks_nothing_and_every_moment_can_be_gone_back_to() {
    for (scene, seed) in [("limbs", 1), ("limbs", 2), ("car", 3)] {
        let mut stage = Stage::open("(bodies: [])");
        stage.act(SandboxAction::LoadScene { scene: scene.to_owned(), parameters: Vec::new() });
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut told = Vec::new();
        let mut made = 0;
        while made < STEPS / 3 {
            let before = step(&stage);
            told.push(format!("{before}: {}", deed(&mut stage, &mut random)));
            stage.frames(random.random_range(1..12));
            made += step(&stage).abs_diff(before).max(1);
            if told.len().is_multiple_of(3) {
                stage.release();
                check(&mut stage, &mut random, &told);
            }
        }
        stage.release();
        stage.frames(1);
        let current = stage.app.world().resource::<CurrentScene>().clone();
        let before = hash(&stage);
        let recording = Recording::of_world(stage.world(), &current.spec, &current.entities).unwrap();
        assert_eq!(hash(&stage), before);
        let now = Print::of(stage.app.world(), &Numbers::of_scene(&current.entities)).world;
        assert_eq!(
            recording.prints[(step(&stage) - stage.app.world().resource::<History>().begun()) as usize].world,
            now
        );
        let replay = recording.replay(Path::new("monkey.plumb"), |_| ()).unwrap();
        if replay.differs.is_some() {
            recording.write(&std::env::temp_dir().join("plumb-monkey.plumb")).unwrap();
        }
        assert_eq!(replay, Replay { steps: recording.steps(), differs: None }, "{scene}, {seed}");
    }
}
