//! The scenes after Box3D's benchmark do what they say, at sizes that are quick to run.

use bevy::app::App;
use bevy::math::DVec3;
use plumb::lab::BodyState;
use plumb::physics::{JointCoordinate, JointLimits, LimitRange, Position, Rotation, Velocity, headless_app, step};
use plumb::scene::{SceneSpec, SpawnedScene, load};

/// A scene after some steps.
struct Ran {
    app: App,
    spec: SceneSpec,
    spawned: SpawnedScene,
}

fn run(name: &str, parameters: &[(&str, f64)], steps: u32) -> Ran {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let spec = load(name, &parameters).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless_app();
    let spawned = spec.spawn(app.world_mut());
    for _ in 0..steps {
        step(app.world_mut());
    }
    Ran { app, spec, spawned }
}

impl Ran {
    /// The bodies whose names begin so.
    fn named(&self, start: &str) -> Vec<BodyState> {
        let bodies = self.spec.bodies.iter().zip(&self.spawned.bodies);
        let found = bodies.filter(|(body, _)| body.name.starts_with(start)).map(|(_, &entity)| {
            let body = self.app.world().entity(entity);
            let (position, rotation, velocity) = body.components::<(&Position, &Rotation, &Velocity)>();
            BodyState { position: position.0, rotation: rotation.0, linear: velocity.linear, angular: velocity.angular }
        });
        let found: Vec<BodyState> = found.collect();
        assert!(!found.is_empty() && found.iter().all(|state| state.position.is_finite()), "{start}");
        found
    }
}

#[test]
fn cubes_stay_in_the_drum_and_are_carried_up_by_it() {
    let ran = run("washer", &[("n", 4.0)], 300);
    // A fifth of Box3D's: 3.2 m inside, its axis at 4.2 m, 4 m long.
    let cubes = ran.named("cube");
    for cube in &cubes {
        let from_axis = (cube.position - 4.2 * DVec3::Y) * DVec3::new(1.0, 1.0, 0.0);
        assert!(from_axis.length() < 3.2 && cube.position.z.abs() < 2.0, "{}", cube.position);
    }
    let turned = 300.0 / 60.0 * 25_f64.to_radians();
    let drum = ran.named("drum")[0].rotation * ran.spec.bodies[1].principal_rotation().inverse();
    assert!((drum * DVec3::X).distance(DVec3::new(turned.cos(), turned.sin(), 0.0)) < 1e-6, "{drum}");
    // Turning counter-clockwise, it holds them up on the right.
    let middle = cubes.iter().map(|cube| cube.position.x).sum::<f64>() / cubes.len() as f64;
    assert!(middle > 0.3, "{middle}");
}

#[test]
fn trees_fall_to_both_sides_and_lie_on_the_waves() {
    let ran = run("trees", &[("n", 2.0), ("cell", 2.0)], 900);
    let sides: Vec<f64> = ran.named("tree").iter().map(|tree| tree.position.x.signum()).collect();
    assert_eq!(sides, [1.0, -1.0]);
    for tree in ran.named("tree") {
        // Lying, the middle of a trunk is about its radius above waves of 0.4 m.
        assert!((-0.4..1.5).contains(&tree.position.y), "{}", tree.position);
        assert!(tree.linear.length() < 1.0, "{}", tree.linear);
    }
}

#[test]
fn ragdolls_rain_on_tiles_and_nothing_falls_through() {
    let ran = run("rain", &[("n", 1.0)], 240);
    // On the arch, 4.75 m high, or beside it.
    for part in ran.named("doll") {
        assert!((0.0..7.0).contains(&part.position.y), "{}", part.position);
    }
    let mut limited = 0;
    for &joint in &ran.spawned.joints {
        let joint = ran.app.world().entity(joint);
        let (Some(limits), Some(angle)) = (joint.get::<JointLimits>(), joint.get::<JointCoordinate>()) else {
            continue;
        };
        if let LimitRange::Range { min, max } = limits.range {
            assert!((min - 0.02..max + 0.02).contains(&angle.value), "{} {min} {max}", angle.value);
            limited += 1;
        }
    }
    // Elbows and knees.
    assert_eq!(limited, 3 * 4);
}

#[test]
fn rocks_stay_in_the_yard_while_pushers_go_round() {
    let ran = run("junkyard", &[("n", 4.0), ("layers", 2.0)], 480);
    let half = 50.0 * 4.0 / 21.0;
    for rock in ran.named("rock") {
        let DVec3 { x, y, z } = rock.position;
        assert!(x.abs() < half && z.abs() < half && y > 0.5, "{}", rock.position);
    }
    let turned = 480.0 / 60.0 * 6_f64.to_radians();
    let pushers = ran.named("pushers")[0].rotation * ran.spec.bodies[5].principal_rotation().inverse();
    assert!((pushers * DVec3::X).distance(DVec3::new(turned.cos(), 0.0, -turned.sin())) < 1e-6, "{pushers}");
}

#[test]
fn stones_come_down_to_a_pile() {
    let ran = run("convex_pile", &[("layers", 3.0)], 300);
    let stones = ran.named("stone");
    for stone in &stones {
        // None is thinner than 1.5 m; the top layer starts at 10 m.
        assert!((0.75..10.0).contains(&stone.position.y), "{}", stone.position);
    }
    let lowest = stones.iter().filter(|stone| stone.position.y < 2.5).count();
    assert!(lowest > 64, "{lowest} of {} on the ground, where one layer started", stones.len());
}

#[test]
fn balls_rest_on_the_slabs() {
    for ball in run("large_world", &[("n", 3.0)], 120).named("ball") {
        assert!((ball.position.y - 0.75).abs() < 1e-3, "{}", ball.position);
    }
}
