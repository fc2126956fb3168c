//! A steady step allocates nothing: all that a step needs is kept from the steps before. And what is
//! kept, by body, contact and joint.
//!
//! Steady is a step in which no contact begins or ends: where one does, the trees of joints of its
//! group are planned anew, which allocates.
//!
//! With more threads than one, a helper is a task of Bevy's pool, which it allocates when one is called, and every 31st
//! task a block of the queue that the pool's threads take them from. A helper that is there stays for the next work, so that
//! most steps call none.

use std::process::Command;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use plumb::prelude::*;
use plumb::scene::load;

use crate::matrix::ENGINES;
use crate::matrix::Engine::{self, *};
use crate::rig::*;

/// What the call of a helper allocates at most.
const OF_CALL: u64 = 2;

/// A scene after that many steps.
fn by(settings: SolverSettings, scene: &str, parameters: &[(&str, f64)], steps: u32) -> World {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let mut world = std::mem::take(headless_app().world_mut());
    world.insert_resource(settings);
    load(scene, &parameters).unwrap().spawn(&mut world);
    (0..steps).for_each(|_| step(&mut world));
    world
}

fn settled(scene: &str, parameters: &[(&str, f64)], threads: u32, steps: u32) -> World {
    let settings = SolverSettings { threads, ..awake_game() };
    by(settings, scene, parameters, steps)
}

/// The scenes, with the steps after which they are steady, and how often a step of theirs asks for help
/// with two threads: two to look at bodies where there is more than one chunk of them, one to find contacts where
/// there is more than one chunk of pairs, one for islands at rest where there are several groups, one for each large group of bodies, one for the small groups
/// with something left to do where there are several.
const SCENES: [(&str, &[(&str, f64)], u32, u64); 6] = [
    ("stack", &[("n", 10.0)], 300, 0),
    ("pyramid", &[("n", 12.0)], 400, 1),
    ("pyramids", &[("n", 2.0)], 400, 2),
    ("joint_grid", &[("n", 30.0)], 100, 3),
    ("chain", &[], 100, 0),
    ("limbs", &[], 1500, 0),
];

/// Allocations of this thread in each steady one of a hundred steps.
fn of_steady_steps(world: &mut World) -> Vec<u64> {
    let counts = (0..100).filter_map(|_| {
        let mut started = world.resource::<Messages<ContactStarted>>().get_cursor_current();
        let mut ended = world.resource::<Messages<ContactEnded>>().get_cursor_current();
        let used = allocation_counter::measure(|| step(world));
        let is_steady = started.read(world.resource::<Messages<ContactStarted>>()).next().is_none()
            && ended.read(world.resource::<Messages<ContactEnded>>()).next().is_none();
        is_steady.then_some(used.count_total)
    });
    counts.collect()
}

#[test]
fn a_steady_step_allocates_nothing() {
    start_pool();
    for (scene, parameters, steps, _) in SCENES {
        let counts = of_steady_steps(&mut settled(scene, parameters, 1, steps));
        assert!(counts.len() > 20, "{scene}: only {} steps were steady", counts.len());
        assert!(counts.iter().all(|&count| count == 0), "{scene}: {counts:?}");
    }
}

/// In a process of its own: with the pool for itself.
#[test]
fn a_steady_step_of_two_threads_allocates_its_tasks_alone() {
    let me = std::env::current_exe().unwrap();
    let alone = Command::new(me).args(["--exact", "allocations::of_two_threads", "--ignored"]).output().unwrap();
    let said = String::from_utf8_lossy(&alone.stdout);
    assert!(alone.status.success() && said.contains("1 passed"), "{said}");
}

#[test]
#[ignore = "run by the test above, alone"]
fn of_two_threads() {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(1).build());
    for (scene, parameters, steps, asked) in SCENES {
        let counts = of_steady_steps(&mut settled(scene, parameters, 2, steps));
        assert!(counts.len() > 20, "{scene}: only {} steps were steady", counts.len());
        let most = OF_CALL * asked + u64::from(asked > 0);
        assert!(counts.iter().all(|&count| count <= most), "{scene}: {counts:?}");
    }
}

/// A box that slides without friction and a ball that rolls.
fn gliding(settings: SolverSettings) -> World {
    let mut world = world_with(settings);
    ground(&mut world);
    let smooth = SurfaceMaterial { friction: 0.0, restitution: 0.0 };
    let along = Velocity { linear: DVec3::X, ..default() };
    let slider = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
    world.entity_mut(slider).insert((smooth, along));
    let roller = body(&mut world, Collider::sphere(0.5), DVec3::new(0.0, 0.5, 3.0));
    world.entity_mut(roller).insert(along);
    world
}

/// Whether a method steps without allocating where something touches.
fn expected(engine: Engine) -> bool {
    match engine {
        Classic | Steady | Primed | Nonsmooth | Game | Sequential | Xpbd => true,
        // Its contacts are found, and the system of their impulses is made, anew in each step.
        Accurate => false,
    }
}

#[test]
fn no_method_allocates_in_a_steady_step() {
    start_pool();
    for engine in ENGINES {
        let mut settings = engine.settings();
        settings.impulse.sleep_speed = None;
        // In which contacts come and go now and then, in those of `classic` most.
        for (what, touches, least, mut world) in [
            ("chain", false, 90, by(settings, "chain", &[], 60)),
            ("column", true, 50, by(settings, "stack", &[("n", 5.0)], 180)),
            ("gliding", true, 90, gliding(settings)),
            ("limbs", true, 5, by(settings, "limbs", &[], 1200)),
        ] {
            if touches && !expected(engine) {
                continue;
            }
            steps(&mut world, 60);
            let counts = of_steady_steps(&mut world);
            assert!(counts.len() >= least, "{engine:?}, {what}: only {} steps were steady", counts.len());
            // Buffers of rows may grow once more where they come and go: those of contacts, and six of a system of joints
            // whose limits are met.
            let grown = 8 * u64::from(what == "limbs");
            assert!(counts.iter().sum::<u64>() <= grown, "{engine:?}, {what}: {counts:?}");
        }
    }
}

/// Bytes allocated, and not freed again, to make a world of that many bodies and to take ten steps.
fn kept(bodies: u32, make: impl Fn(&mut World, u32)) -> f64 {
    let mut world = None;
    let used = allocation_counter::measure(|| {
        let world = world.insert(weightless(SolverSettings::game()));
        (0..bodies).for_each(|index| make(world, index));
        steps(world, 10);
    });
    used.bytes_current as f64
}

/// Bytes more for each more body of that kind. Powers of two: that many fill what grows by doubling.
fn bytes_per_body(make: impl Fn(&mut World, u32) + Copy) -> f64 {
    (kept(8192, make) - kept(4096, make)) / 4096.0
}

/// At most a tenth more than `docs/performance.md` states under *Memory*.
#[test]
fn memory_by_body_contact_and_joint_is_bounded() {
    let apart = |index: u32| DVec3::new(3.0 * f64::from(index), 0.0, 0.0);
    let alone = |world: &mut World, index| _ = body(world, Collider::sphere(0.5), apart(index));
    // Each in contact with one that does not move, or held by it.
    let fixed = |world: &mut World, index| {
        alone(world, index);
        world.spawn((RigidBody::Static, Collider::sphere(0.5), Position(apart(index) + DVec3::Y * 1.5)));
    };
    let touching = |world: &mut World, index| {
        alone(world, index);
        world.spawn((RigidBody::Static, Collider::sphere(0.5), Position(apart(index) + DVec3::Y * 0.999)));
    };
    let held = |world: &mut World, index| {
        let ball = body(world, Collider::sphere(0.5), apart(index));
        let post =
            world.spawn((RigidBody::Static, Collider::sphere(0.5), Position(apart(index) + DVec3::Y * 1.5))).id();
        world.spawn(BallJoint::new(post, ball).with_anchors(DVec3::ZERO, DVec3::Y * 1.5));
    };
    // Two joints between two bodies are a loop.
    let looped = |world: &mut World, index| {
        let [one, other] = [0.0, 1.5].map(|y| body(world, Collider::sphere(0.5), apart(index) + DVec3::Y * y));
        for x in [-0.1, 0.1] {
            let anchors = [DVec3::new(x, 0.75, 0.0), DVec3::new(x, -0.75, 0.0)];
            world.spawn(BallJoint::new(one, other).with_anchors(anchors[0], anchors[1]));
        }
    };
    let of_body = bytes_per_body(alone);
    let of_fixed = bytes_per_body(fixed) - of_body;
    let of_contact = bytes_per_body(touching) - of_body - of_fixed;
    let of_tree_joint = bytes_per_body(held) - of_body - of_fixed;
    let of_loop_joint = (bytes_per_body(looped) - 2.0 * of_body) / 2.0;
    for (what, bytes, at_most) in [
        ("body", of_body, 2250.0),
        ("fixed body", of_fixed, 1600.0),
        ("contact, an island at rest of its own", of_contact, 9400.0),
        ("joint of a tree", of_tree_joint, 4350.0),
        ("joint of a loop, an island of its own", of_loop_joint, 6300.0),
    ] {
        assert!(bytes <= at_most, "{bytes} bytes a {what}, more than {at_most}");
    }
}
