//! What a monkey does.

use std::collections::HashSet;
use std::path::Path;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::physics::{
    Breakable, Collider, History, Method, Position, RigidBody, Rotation, SolverSettings, StepStats, Velocity,
};
use crate::sandbox::any_joint::IsJoint;
use crate::sandbox::timeline::head_and_reach;
use crate::sandbox::{Blueprint, Hands, JoinKind, JointChange, Picked, Placement, Playback, SandboxAction, Selection};
use crate::scene::{MeshSpec, ShapeSpec};

/// How far one goes back at most, steps.
const BACK: u64 = 40;
/// The window, logical pixels.
pub(super) const SIZE: UVec2 = UVec2::new(1280, 720);
/// What panel and strip take of it at the right and at the bottom.
const COVERED: Vec2 = Vec2::new(350.0, 80.0);
/// Of bodies that are picked beside the first two, as many are duplicated.
const MOST_COPIED: usize = 4;
/// What a joint that is made brittle bears, N.
const BRITTLE: f64 = 200.0;

/// Kinds of deeds, and how often each comes.
const KINDS: [(Kind, u32); 24] = [
    (Kind::Drag, 4),
    (Kind::Throw, 2),
    (Kind::Add, 2),
    (Kind::Join, 4),
    (Kind::Pin, 2),
    (Kind::Cut, 2),
    (Kind::Delete, 2),
    (Kind::Undo, 4),
    (Kind::Redo, 3),
    (Kind::Preset, 1),
    (Kind::Setting, 1),
    (Kind::GoBack, 2),
    (Kind::PlayBackwards, 2),
    (Kind::Push, 2),
    (Kind::MakeBrittle, 1),
    (Kind::Teleport, 1),
    (Kind::Mark, 1),
    (Kind::SelectBox, 2),
    (Kind::Duplicate, 2),
    (Kind::Paste, 2),
    (Kind::Place, 3),
    (Kind::MakeOne, 2),
    (Kind::TakeApart, 2),
    (Kind::Wait, 1),
];

#[derive(Clone, Copy, Debug)]
enum Kind {
    Drag,
    Throw,
    Add,
    Join,
    Pin,
    Cut,
    Delete,
    Undo,
    Redo,
    Preset,
    Setting,
    GoBack,
    PlayBackwards,
    Push,
    MakeBrittle,
    Teleport,
    Mark,
    SelectBox,
    Duplicate,
    Paste,
    Place,
    MakeOne,
    TakeApart,
    Wait,
}

/// Does something; what, in words. Settings that it changes are the scene's own again after it; `methods` is told of those by
/// which steps were made meanwhile.
pub(super) fn do_something(
    hands: &mut Hands,
    random: &mut Pcg64Mcg,
    own: &SolverSettings,
    methods: &mut Vec<Method>,
) -> String {
    let free = SIZE.as_vec2() - COVERED;
    let place = Vec2::new(random.random_range(5.0..free.x), random.random_range(5.0..free.y));
    match any_kind(random) {
        Kind::Drag => drag(hands, random, place),
        Kind::Throw => at(hands, place, SandboxAction::ThrowBall, "threw a ball"),
        Kind::Add => {
            hands.world().resource_mut::<Blueprint>().shape = any_shape(random);
            at(hands, place, SandboxAction::SpawnBody, "added a body")
        }
        Kind::Join => {
            let (kind, name, _) = JoinKind::ALL[random.random_range(0..JoinKind::ALL.len())];
            hands.world().insert_resource(kind);
            pick(hands, random, true);
            hands.act(SandboxAction::JoinPicked);
            format!("joined two bodies by a {name}")
        }
        Kind::Pin => with_picked(hands, random, SandboxAction::PinPicked, "pinned a body"),
        Kind::Cut => with_picked(hands, random, SandboxAction::CutPicked, "cut a joint"),
        Kind::Delete => with_picked(hands, random, SandboxAction::DeletePicked, "deleted a body"),
        Kind::Undo => {
            hands.act(SandboxAction::Undo);
            "undid something".into()
        }
        Kind::Redo => {
            hands.act(SandboxAction::Redo);
            "redid something".into()
        }
        Kind::Preset => {
            let presets = SolverSettings::PRESETS;
            let (name, preset) = presets[random.random_range(0..presets.len())];
            methods.push(preset().method);
            for_a_while(hands, random, preset(), own);
            format!("chose {name} for a while")
        }
        Kind::Setting => {
            let mut settings = *own;
            let said = change(&mut settings, random);
            for_a_while(hands, random, settings, own);
            format!("chose {said} for a while")
        }
        Kind::GoBack => {
            let world = hands.app.world();
            let (_, [_, last]) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
            let to = moment_up_to(hands, random, last);
            hands.act(SandboxAction::GoTo { step: to });
            pause(hands, false);
            format!("went to step {to}")
        }
        Kind::PlayBackwards => {
            hands.act(SandboxAction::TogglePlayBackwards);
            hands.frames(random.random_range(1..15));
            hands.act(SandboxAction::TogglePause);
            pause(hands, false);
            "played backwards".into()
        }
        Kind::Push => {
            if let Some(body) = any_body(hands, random)
                && let Some(mut velocity) = hands.world().get_mut::<Velocity>(body)
            {
                let [x, y, z] = [-3.0..3.0, 0.0..4.0, -3.0..3.0].map(|range| random.random_range(range));
                velocity.linear += DVec3::new(x, y, z);
            }
            "pushed a body".into()
        }
        Kind::MakeBrittle => {
            if let Some(joint) = any_joint(hands, random) {
                let change = JointChange::Strength(Some(Breakable::at_force(BRITTLE).at_once()));
                hands.act(SandboxAction::ChangeJoint { joint, change, continues: false });
            }
            "made a joint brittle".into()
        }
        Kind::Teleport => {
            if let Some(body) = any_body(hands, random)
                && let Some(mut pose) = hands.world().get_mut::<Transform>(body)
            {
                pose.translation += Vec3::Y * random.random_range(0.0..2.0);
            }
            "lifted a body up at once".into()
        }
        Kind::Mark => {
            hands.act(SandboxAction::ToggleMark);
            "marked a moment".into()
        }
        Kind::SelectBox => select_box(hands, random, place),
        Kind::Duplicate => {
            if random.random_bool(0.5) {
                select_box(hands, random, place);
            } else {
                pick(hands, random, true);
            }
            thin_out(hands);
            hands.act(SandboxAction::Duplicate);
            "duplicated what was picked".into()
        }
        Kind::Paste => {
            pick(hands, random, true);
            hands.act(if random.random_bool(0.3) { SandboxAction::CutOut } else { SandboxAction::Copy });
            at(hands, place, SandboxAction::Paste, "pasted two bodies")
        }
        Kind::Place => put(hands, random),
        Kind::MakeOne => {
            pick(hands, random, true);
            hands.act(SandboxAction::MakeOneBody);
            "made one body of two".into()
        }
        Kind::TakeApart => {
            // One that can be, of a few.
            for _ in 0..3 {
                pick(hands, random, false);
                hands.act(SandboxAction::TakeApart);
            }
            "took apart what could be".into()
        }
        Kind::Wait => {
            hands.act(SandboxAction::Escape);
            hands.frames(random.random_range(1..30));
            "waited".into()
        }
    }
}

fn any_kind(random: &mut Pcg64Mcg) -> Kind {
    let all = KINDS.iter().map(|(_, often)| often).sum();
    let mut drawn = random.random_range(0..all);
    let kind = KINDS.iter().find(|(_, often)| {
        let is_it = drawn < *often;
        drawn = drawn.saturating_sub(*often);
        is_it
    });
    kind.map_or(Kind::Wait, |(kind, _)| *kind)
}

/// Presses at a place, moves about, and mostly lets go.
fn drag(hands: &mut Hands, random: &mut Pcg64Mcg, place: Vec2) -> String {
    hands.jump_to(place);
    hands.press();
    let held = random.random_range(2..20);
    for _ in 0..held {
        let by = Vec2::new(random.random_range(-200.0..200.0), random.random_range(-200.0..200.0));
        hands.jump_to(place + by);
        hands.frames(1);
    }
    // Now and then the hand stays where it is.
    if random.random_bool(0.8) {
        hands.release();
    }
    format!("dragged from {place} for {held} frames")
}

fn select_box(hands: &mut Hands, random: &mut Pcg64Mcg, from: Vec2) -> String {
    let to = from + Vec2::new(random.random_range(-300.0..300.0), random.random_range(-300.0..300.0));
    hands.act(SandboxAction::SelectBox { from, to, adds: random.random_bool(0.3) });
    format!("drew a box from {from} to {to}")
}

/// Of many that are picked, few stay so: the scene is not to double with each deed.
fn thin_out(hands: &mut Hands) {
    let mut selection = hands.world().resource_mut::<Selection>();
    selection.others.truncate(MOST_COPIED);
}

/// Puts a body and another somewhere else, as by a handle: at once, or over some frames.
fn put(hands: &mut Hands, random: &mut Pcg64Mcg) -> String {
    pick(hands, random, true);
    let bodies: HashSet<Entity> = hands.world().resource::<Selection>().bodies().collect();
    let mut bodies: Vec<Entity> = bodies.into_iter().collect();
    bodies.sort_unstable();
    let [x, z] = [0, 1].map(|_| random.random_range(-0.5..0.5));
    let (way, frames) = (DVec3::new(x, random.random_range(0.0..1.0), z), random.random_range(1..10));
    let turn = DQuat::from_scaled_axis(DVec3::new(x, 0.5, z));
    for frame in 0..frames {
        let world = hands.world();
        let placements = bodies.iter().filter_map(|&body| {
            let (position, rotation) = (world.get::<Position>(body)?.0, world.get::<Rotation>(body)?.0);
            let position = position + way / f64::from(frames);
            Some(Placement { body, position, rotation: (turn * rotation).normalize(), shape: None })
        });
        let placements = placements.collect();
        hands.act(SandboxAction::PlaceBodies { placements, continues: frame > 0 });
    }
    format!("put {} bodies elsewhere in {frames} frames", bodies.len())
}

fn at(hands: &mut Hands, place: Vec2, action: SandboxAction, said: &str) -> String {
    hands.jump_to(place);
    hands.act(action);
    format!("{said} at {place}")
}

fn any_shape(random: &mut Pcg64Mcg) -> ShapeSpec {
    let size = random.random_range(0.1..0.4);
    match random.random_range(0..6) {
        5 => ShapeSpec::Cylinder { radius: size, height: 1.5 * size },
        4 => ShapeSpec::Capsule { radius: 0.5 * size, length: size },
        0 => ShapeSpec::Sphere { radius: size },
        1 => ShapeSpec::Cone { radius: size, height: 2.0 * size },
        2 => MeshSpec::load("plumb:gem.obj", Path::new(""), size)
            .map_or(ShapeSpec::Sphere { radius: size }, ShapeSpec::Mesh),
        _ => ShapeSpec::Cuboid { size: DVec3::new(size, 2.0 * size, 1.5 * size) },
    }
}

fn with_picked(hands: &mut Hands, random: &mut Pcg64Mcg, action: SandboxAction, said: &str) -> String {
    pick(hands, random, false);
    hands.act(action);
    said.into()
}

fn pick(hands: &mut Hands, random: &mut Pcg64Mcg, two: bool) {
    let mut one = |hands: &mut Hands| {
        let entity = any_body(hands, random)?;
        let point = DVec3::from_array([0, 1, 2].map(|_| random.random_range(-0.1..0.1)));
        Some(Picked { entity, point, normal: Some(DVec3::Y) })
    };
    let body = one(hands);
    let partner = if two { one(hands) } else { None };
    hands.world().insert_resource(Selection { body, partner, ..default() });
}

/// A body that moves.
fn any_body(hands: &mut Hands, random: &mut Pcg64Mcg) -> Option<Entity> {
    let world = hands.world();
    let mut bodies = world.query_filtered::<(Entity, &RigidBody), With<Collider>>();
    let all = bodies.iter(world).filter(|(_, kind)| **kind == RigidBody::Dynamic).map(|(entity, _)| entity);
    one_of(all.collect(), random)
}

fn any_joint(hands: &mut Hands, random: &mut Pcg64Mcg) -> Option<Entity> {
    let world = hands.world();
    let all = world.query_filtered::<Entity, IsJoint>().iter(world).collect();
    one_of(all, random)
}

fn one_of(mut all: Vec<Entity>, random: &mut Pcg64Mcg) -> Option<Entity> {
    all.sort_unstable();
    (!all.is_empty()).then(|| all[random.random_range(0..all.len())])
}

/// A step that is kept, not long before that one.
pub(super) fn moment_up_to(hands: &Hands, random: &mut Pcg64Mcg, last: u64) -> u64 {
    let first = hands.app.world().get_resource::<History>().map_or(last, |history| history.reach()[0]);
    random.random_range(first.max(last.saturating_sub(BACK))..=last)
}

fn for_a_while(hands: &mut Hands, random: &mut Pcg64Mcg, settings: SolverSettings, own: &SolverSettings) {
    // An exact step of a heap that another method left overlapping takes seconds.
    let most = if settings.method == Method::Exact && own.method != Method::Exact { 3 } else { 20 };
    hands.world().insert_resource(SolverSettings { threads: own.threads, ..settings });
    hands.frames(random.random_range(1..most));
    hands.world().insert_resource(*own);
}

/// Changes one setting; which, in words.
fn change(settings: &mut SolverSettings, random: &mut Pcg64Mcg) -> String {
    match random.random_range(0..6) {
        0 => {
            settings.hz = [30.0, 60.0, 120.0, 240.0][random.random_range(0..4)];
            format!("{} Hz", settings.hz)
        }
        1 => {
            settings.substeps = random.random_range(1..9);
            format!("{} substeps", settings.substeps)
        }
        2 => {
            settings.iterations = random.random_range(1..21);
            format!("{} iterations", settings.iterations)
        }
        3 => {
            settings.sweeps.warm_starting = !settings.sweeps.warm_starting;
            format!("warm starting {}", settings.sweeps.warm_starting)
        }
        4 => {
            settings.restitution_speed = Some(random.random_range(0.0..1.0));
            "another speed from which things bounce".into()
        }
        _ => {
            settings.impulse.sleep_speed = settings.impulse.sleep_speed.xor(Some(0.05));
            format!("sleep below {:?} m/s", settings.impulse.sleep_speed)
        }
    }
}

/// Time stands still, or runs, from this frame on.
pub(super) fn pause(hands: &mut Hands, paused: bool) {
    hands.world().resource_mut::<Playback>().paused = paused;
    let mut time = hands.world().resource_mut::<Time<Virtual>>();
    if paused { time.pause() } else { time.unpause() }
}
