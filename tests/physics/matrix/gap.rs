//! What is apart does not touch, and what comes together touches before it overlaps.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;

use super::ENGINES;
use super::Engine::{self, *};
use crate::rig::*;

/// Speed of approach, m/s: 8.3 cm in a step.
const SPEED: f64 = 5.0;

/// Starts that divide the way of a step, so that bodies meet at any time of it.
const STARTS: u32 = 5;

const SMOOTH: SurfaceMaterial = SurfaceMaterial { friction: 0.0, restitution: 0.0 };

/// What is expected of bodies that come together at [`SPEED`], and of those that do not.
struct Expected {
    /// Overlap of a body with the ground, m, at most.
    in_ground: f64,
    /// Overlap of two balls, m, at most.
    in_each_other: f64,
    /// Distance between two bodies at which neither stops before it touches, m.
    short_of: f64,
    /// Distance at which two balls pass each other without a touch, m.
    past_balls: f64,
    /// Distance at which a body passes an edge without a touch, m.
    past_edges: f64,
}

fn expected(engine: Engine) -> Expected {
    let step = SPEED / 60.0 + 1e-9;
    // What overlap alone makes a contact.
    let after = Expected { in_ground: step, in_each_other: step, short_of: 0.0, past_balls: 1e-4, past_edges: 1e-4 };
    // Of bodies that come near each other within a step, the gap is bounded along one normal, that of its start. The
    // tangent planes of spheres of 0.5 m that pass each other are nearer to each other than they are by up to
    // (v h)²/2(r + r) = 3.5 mm; before an edge the normal may point along the way, and the gap is that of a wall: what
    // passes nearer than the way of a step loses up to half of its speed.
    let before = |overlap: f64, short_of: f64| Expected {
        in_ground: overlap,
        in_each_other: overlap,
        short_of,
        past_balls: 5e-3,
        past_edges: 1.2 * step,
    };
    match engine {
        // A contact is found once it overlaps, which is up to the way of a step deep.
        Classic => after,
        // The gap to a plane is known, and closed up to the slop of 2 mm; other pairs as in 2009.
        Steady | Primed | Nonsmooth => Expected { in_ground: 0.002 + 1e-6, ..after },
        // Springs of 60 Hz give: measured 1.4 mm. What lands on a corner has the arm of the start of the step while it
        // turns: measured 1.9 mm short, with one substep 0.2 mm.
        Game => before(3e-3, 4e-3),
        // Rows are f32: measured 6e-8.
        Sequential => before(1e-6, 1e-3),
        Xpbd => before(1e-6, 4e-3),
        // Contacts hold to 1e-10 m/s, over a second.
        Accurate => before(1e-9, 1e-9),
    }
}

/// The least and the greatest of the deepest overlaps that the starts lead to, m.
fn deepest(settings: SolverSettings, make: impl Fn(&mut World, f64) -> Box<dyn Fn(&World) -> f64>) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for start in 0..STARTS {
        let mut world = weightless(settings);
        let distance = 0.3 + SPEED * settings.step() * f64::from(start) / f64::from(STARTS);
        let overlap = make(&mut world, distance);
        let mut most = f64::NEG_INFINITY;
        for _ in 0..60 {
            step(&mut world);
            most = most.max(overlap(&world));
        }
        range = [range[0].min(most), range[1].max(most)];
    }
    range
}

#[track_caller]
fn assert_touching(engine: Engine, what: &str, [least, most]: [f64; 2], in_it: f64) {
    let short_of = expected(engine).short_of;
    assert!(most <= in_it, "{engine:?}: {what} overlaps by {most} m");
    assert!(least >= -short_of, "{engine:?}: {what} stops {} m before it is there", -least);
}

#[test]
fn what_comes_to_the_ground_touches_before_it_overlaps() {
    for engine in ENGINES {
        let corner = DQuat::from_euler(bevy::math::EulerRot::XYZ, 0.7, 0.2, 0.4);
        for (what, collider, turn) in [
            ("a ball", Collider::sphere(0.5), DQuat::IDENTITY),
            ("a cube", Collider::cuboid(1.0, 1.0, 1.0), DQuat::IDENTITY),
            ("a cube on its corner", Collider::cuboid(1.0, 1.0, 1.0), corner),
            ("a cone on its rim", Collider::cone(0.4, 0.9), corner),
        ] {
            let range = deepest(engine.settings(), |world, distance| {
                ground(world);
                let thrown = Velocity { linear: DVec3::Y * -SPEED, ..default() };
                let falling = body(world, collider.clone(), DVec3::ZERO);
                world.entity_mut(falling).insert((Rotation(turn), thrown, SMOOTH));
                let below = clearance(world, falling);
                world.entity_mut(falling).insert(Position(DVec3::Y * (distance - below)));
                Box::new(move |world| -clearance(world, falling))
            });
            assert_touching(engine, what, range, expected(engine).in_ground);
        }
    }
}

#[test]
fn balls_that_meet_touch_before_they_overlap() {
    for engine in ENGINES {
        let range = deepest(engine.settings(), |world, distance| {
            let [left, right] = [-1.0, 1.0].map(|side| {
                let ball = body(world, Collider::sphere(0.5), DVec3::X * side * (0.5 + 0.5 * distance));
                let thrown = Velocity { linear: DVec3::X * side * -0.5 * SPEED, ..default() };
                world.entity_mut(ball).insert((thrown, SMOOTH));
                ball
            });
            Box::new(move |world| 1.0 - position(world, left).distance(position(world, right)))
        });
        assert_touching(engine, "a ball", range, expected(engine).in_each_other);
    }
}

#[test]
fn what_flies_past_is_not_touched() {
    let (ball, cube) = (Collider::sphere(0.5), Collider::cuboid(1.0, 1.0, 1.0));
    for engine in ENGINES {
        let Expected { past_balls, past_edges, .. } = expected(engine);
        for (what, flying, fixed, distance) in [
            ("a ball over a plane", &ball, None, 1e-4),
            ("a cube over a plane", &cube, None, 1e-4),
            ("a ball past a ball", &ball, Some(&ball), past_balls),
            ("a cube over a cube", &cube, Some(&cube), past_edges),
            ("a ball over a cube", &ball, Some(&cube), past_edges),
            ("a cube over a ball", &cube, Some(&ball), past_edges),
        ] {
            for start in 0..STARTS {
                let mut world = weightless(engine.settings());
                let height = match fixed {
                    Some(fixed) => {
                        world.spawn((RigidBody::Static, fixed.clone(), Position(DVec3::ZERO)));
                        1.0 + distance
                    }
                    None => {
                        ground(&mut world);
                        0.5 + distance
                    }
                };
                let from = -2.0 - SPEED / 60.0 * f64::from(start) / f64::from(STARTS);
                let flying = body(&mut world, flying.clone(), DVec3::new(from, height, 0.0));
                let thrown = Velocity { linear: DVec3::X * SPEED, ..default() };
                world.entity_mut(flying).insert(thrown);
                run(&mut world, 0.8);
                let after = *world.get::<Velocity>(flying).unwrap();
                assert!(position(&world, flying).x > 1.5, "{engine:?}: {what} is held up");
                assert_eq!(after, thrown, "{engine:?}: {what} is touched");
            }
        }
    }
}
