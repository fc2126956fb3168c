//! The start scene under rough hands, at the default settings: nothing sinks through the ground,
//! explodes or is quarantined, and the joints are whole again afterwards.

use bevy::math::{DVec3, Vec2};
use bevy::prelude::*;
use plumb::physics::{Collider, Diagnostics, Position, Quarantined, RigidBody, Velocity};
use plumb::sandbox::SandboxAction;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::stage::{SIZE, Stage};

/// Frames of 1/60 s: half a minute. (Five minutes pass too; they take too long for every run.)
const FRAMES: usize = 1_800;
/// How far from the middle bodies are in the picture, m: a cone that was thrown out of it may roll on for long.
const IN_PICTURE: f64 = 12.0;
/// The pointer's window: what the panel leaves free.
const FREE: Vec2 = Vec2::new(SIZE.x - 350.0, SIZE.y);

/// A dynamic body that is in the picture, at random.
fn victim(stage: &mut Stage, random: &mut Pcg64Mcg) -> Vec2 {
    let world = stage.world();
    let mut bodies = world.query_filtered::<(&RigidBody, &Position), With<Collider>>();
    let places: Vec<DVec3> = bodies
        .iter(world)
        .filter(|(kind, position)| **kind == RigidBody::Dynamic && position.0.length() < IN_PICTURE)
        .map(|(_, position)| position.0)
        .collect();
    let place = stage.try_seen_at(places[random.random_range(0..places.len())]);
    place.unwrap_or(0.5 * FREE).clamp(Vec2::splat(5.0), FREE - 5.0)
}

/// The fastest dynamic body with a shape within so far from the middle, m, and the lowest of all.
fn worst(stage: &mut Stage, within: f64) -> (f64, f64) {
    let world = stage.world();
    let mut bodies = world.query_filtered::<(&RigidBody, &Position, &Velocity, &Collider), Without<Quarantined>>();
    bodies.iter(world).filter(|(kind, ..)| **kind == RigidBody::Dynamic).fold(
        (0.0, f64::INFINITY),
        |(fastest, lowest), (_, position, velocity, collider)| {
            let speed = velocity.linear.length();
            assert!(position.is_finite() && speed.is_finite());
            // How far the bounding sphere's centre lies over the ground: below it, the body sank.
            let sunk = position.y / collider.bounding_radius();
            (if position.length() < within { speed.max(fastest) } else { fastest }, sunk.min(lowest))
        },
    )
}

#[test]
fn the_start_scene_survives_rough_hands() {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: "limbs".to_owned(), parameters: Vec::new() });
    stage.world().insert_resource(Diagnostics::default());
    stage.frames(60);
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut drags = 0;
    for frame in 0..FRAMES {
        match frame % 60 {
            0 => {
                let place = victim(&mut stage, &mut random);
                stage.jump_to(place);
                stage.frames(2);
                stage.press();
                drags += 1;
            }
            55 => stage.release(),
            phase if phase % 6 == 0 => {
                let place = Vec2::new(random.random_range(0.0..FREE.x), random.random_range(0.0..FREE.y));
                stage.jump_to(place);
                if random.random_bool(0.2) {
                    stage.wheel(random.random_range(-2.0..2.0));
                }
            }
            _ => {}
        }
        stage.frames(1);
        let (fastest, lowest) = worst(&mut stage, f64::INFINITY);
        assert!(fastest < 100.0, "frame {frame}, drag {drags}: a body flies at {fastest} m/s");
        // Not buried: its bounding sphere still meets the ground.
        assert!(lowest > -1.0, "frame {frame}, drag {drags}: a body sank {lowest} radii into the ground");
    }
    stage.frames(600);
    let (fastest, lowest) = worst(&mut stage, IN_PICTURE);
    assert!(lowest > 0.0 && fastest < 5.0, "ten seconds later: {lowest} radii over the ground, {fastest} m/s");
    let world = stage.world();
    assert_eq!(world.query::<&Quarantined>().iter(world).count(), 0);
    let joint_error = world.resource::<Diagnostics>().joint_error;
    assert!(joint_error < 0.02, "ten seconds later a joint is still {joint_error} m apart");
}
