use std::collections::BTreeSet;

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::{KINDS, body, upright};
use crate::physics::body::{Body, CollisionLayers, RigidBody};
use crate::physics::collision::classic::sweep_and_sort::SweepAndSort;
use crate::physics::collision::manifold::Pair;
use crate::physics::joint::JoinedPairs;
use crate::physics::settings::{SolverSettings, SweepSettings};
use crate::physics::shape::Collider;
use crate::physics::testing::Random;

fn settings(prune_y: bool) -> SolverSettings {
    let classic = SolverSettings::classic();
    SolverSettings { sweeps: SweepSettings { prune_y, ..classic.sweeps }, ..classic }
}

fn found(sweep: &mut SweepAndSort, bodies: &[Body], joined: &JoinedPairs, prune_y: bool) -> Vec<Pair> {
    let mut pairs = Vec::new();
    sweep.find_pairs(bodies, joined, &settings(prune_y), &mut pairs);
    pairs
}

fn as_set(pairs: &[Pair]) -> BTreeSet<(u32, u32)> {
    pairs.iter().map(|pair| (pair.a, pair.b)).collect()
}

/// Every pair, tested by itself.
fn expected(bodies: &[Body], joined: &[(u32, u32)], prune_y: bool) -> BTreeSet<(u32, u32)> {
    let pairs = (0..bodies.len()).flat_map(|a| (a + 1..bodies.len()).map(move |b| (a, b)));
    pairs
        .filter(|&(a, b)| {
            let (one, other) = (&bodies[a], &bodies[b]);
            let overlap = |axis: usize| (one.position[axis] - other.position[axis]).abs() <= one.radius + other.radius;
            one.geometry.is_some()
                && other.geometry.is_some()
                && (one.kind == RigidBody::Dynamic || other.kind == RigidBody::Dynamic)
                && one.layers.interact(other.layers)
                && !joined.contains(&(a as u32, b as u32))
                && overlap(0)
                && overlap(2)
                && (!prune_y || overlap(1))
        })
        .map(|(a, b)| (a as u32, b as u32))
        .collect()
}

fn random_bodies(random: &mut Random, count: usize) -> Vec<Body> {
    (0..count)
        .map(|_| {
            let collider = KINDS[random.random_range(0..3)](random);
            let mut body = body(&collider, random.vector() * 12.0, random.rotation());
            body.kind = [RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Static, RigidBody::Kinematic]
                [random.random_range(0..4)];
            match random.random_range(0..10) {
                0 => body.layers = CollisionLayers { memberships: 0b01, filters: 0b10 },
                1 => body.layers = CollisionLayers { memberships: 0b10, filters: 0b11 },
                2 => body.layers = CollisionLayers::NONE,
                3 => (body.geometry, body.radius) = (None, 0.0),
                _ => {}
            }
            body
        })
        .collect()
}

#[test]
fn finds_exactly_the_pairs_that_overlap() {
    let mut random = Random::new(11);
    for count in [0, 1, 2, 3, 40, 300, 1100] {
        let bodies = random_bodies(&mut random, count);
        let joined: Vec<(u32, u32)> = (1..count as u32).step_by(2).map(|b| (b - 1, b)).collect();
        let mut joined_pairs = JoinedPairs::default();
        joined_pairs.rebuild(joined.iter().copied());
        for prune_y in [false, true] {
            let pairs = found(&mut SweepAndSort::default(), &bodies, &joined_pairs, prune_y);
            let set = as_set(&pairs);
            assert_eq!(set.len(), pairs.len(), "a pair found twice");
            assert_eq!(set, expected(&bodies, &joined, prune_y), "{count} bodies, prune_y {prune_y}");
        }
    }
}

#[test]
fn order_kept_from_step_to_step_gives_what_a_new_sort_gives() {
    let mut random = Random::new(12);
    let mut bodies = random_bodies(&mut random, 400);
    let mut sweep = SweepAndSort::default();
    for step in 0..60 {
        match step % 6 {
            // Small motions, a teleport of all, one gone with the last in its place, one more,
            // one that comes into play and one that leaves it.
            0 => bodies.iter_mut().for_each(|body| body.position = random.vector() * 12.0),
            1 => drop(bodies.swap_remove(random.random_range(0..bodies.len()))),
            2 => bodies.extend(random_bodies(&mut random, 1)),
            3 => {
                let last = bodies.len() - 1;
                let (gone, come) = (random.random_range(0..last), last);
                bodies[come] = upright(&Collider::sphere(3.0), [0.0; 3]);
                (bodies[gone].geometry, bodies[gone].radius) = (None, 0.0);
            }
            _ => bodies.iter_mut().for_each(|body| body.position += random.vector() * 0.05),
        }
        let kept = found(&mut sweep, &bodies, &JoinedPairs::default(), false);
        assert_eq!(kept, found(&mut SweepAndSort::default(), &bodies, &JoinedPairs::default(), false), "step {step}");
        assert_eq!(as_set(&kept), expected(&bodies, &[], false), "step {step}");
    }
}

#[test]
fn first_bodies_are_in_order_of_x_with_ties_by_body() {
    let ball = Collider::sphere(0.6);
    let at = |x: f64| upright(&ball, [x, 0.0, 0.0]);
    let bodies = [at(2.0), at(1.0), at(0.0), at(1.0)];
    let pairs = found(&mut SweepAndSort::default(), &bodies, &JoinedPairs::default(), false);
    let pairs: Vec<_> = pairs.iter().map(|pair| (pair.a, pair.b)).collect();
    assert_eq!(pairs, [(1, 2), (2, 3), (1, 3), (0, 1), (0, 3)]);
}

#[test]
fn column_makes_every_pair_unless_pruned_on_y() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let column: Vec<_> = (0..10).map(|i| upright(&cube, [0.0, f64::from(i), 0.0])).collect();
    let count = |prune_y| found(&mut SweepAndSort::default(), &column, &JoinedPairs::default(), prune_y).len();
    assert_eq!(count(false), 10 * 9 / 2);
    assert_eq!(count(true), 9, "spheres of radius 0.87 reach the next cube only");
}

#[test]
fn balls_that_just_touch_are_a_pair() {
    let ball = Collider::sphere(0.1);
    for index in 0..50 {
        // Sums that rounding makes a little larger or smaller than the gap.
        let start = f64::from(index) * 0.3;
        let balls = [upright(&ball, [start, 0.0, 0.0]), upright(&ball, [start + 0.2, 0.0, 0.0])];
        assert_eq!(found(&mut SweepAndSort::default(), &balls, &JoinedPairs::default(), true).len(), 1);
    }
}

#[test]
fn half_spaces_come_first_and_reach_only_what_is_near() {
    let mut random = Random::new(13);
    let mut bodies = random_bodies(&mut random, 200);
    let tilted = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.0, 0.5));
    for index in [20, 90] {
        bodies[index] = body(&Collider::half_space(), random.vector() * 4.0, tilted);
        bodies[index].kind = RigidBody::Static;
    }
    let pairs = found(&mut SweepAndSort::default(), &bodies, &JoinedPairs::default(), false);
    let count = pairs.iter().take_while(|pair| [20, 90].contains(&pair.a)).count();
    let (pairs, swept) = pairs.split_at(count);
    let near = |plane: usize| {
        let bodies = &bodies;
        let normal = tilted * Vector3::y();
        (0..bodies.len()).filter(move |&index| {
            let body = &bodies[index];
            body.kind == RigidBody::Dynamic
                && body.geometry.is_some()
                && body.layers.interact(bodies[plane].layers)
                && (body.position - bodies[plane].position).dot(&normal) <= body.radius
        })
    };
    let expected: Vec<_> =
        [20, 90].into_iter().flat_map(|a| near(a).map(move |b| Pair { a: a as u32, b: b as u32 })).collect();
    assert_eq!(pairs, expected);
    assert!(pairs.len() > 50);
    assert!(swept.iter().all(|pair| ![20, 90].contains(&pair.a) && ![20, 90].contains(&pair.b)));
}
