//! How deep bodies overlap, from their states alone: the same code for every engine.

use std::collections::HashSet;

use bevy::math::DVec3;
use plumb::lab::BodyState;
use plumb::physics::{Collider, PlacedCollider, Position, RigidBody, Rotation};

use crate::scene::Scene;

/// The deepest overlap of two bodies that may touch, m; 0 where none do.
pub fn deepest(scene: &Scene, states: &[BodyState]) -> f64 {
    let order = |a: usize, b: usize| (a.min(b), a.max(b));
    let joined: HashSet<(usize, usize)> =
        scene.joints.iter().filter(|joint| !joint.collide).map(|joint| order(joint.a, joint.b)).collect();
    let moves = |index: usize| scene.bodies[index].kind == RigidBody::Dynamic;
    let mut radii = vec![0.0; scene.bodies.len()];
    let mut spans: Vec<(f64, f64, usize)> = Vec::new();
    let mut planes = Vec::new();
    for (index, (body, state)) in scene.bodies.iter().zip(states).enumerate() {
        match &body.collider {
            None => {}
            Some(collider) if *collider == Collider::half_space() => planes.push(index),
            Some(collider) => {
                let radius = collider.bounding_radius();
                radii[index] = radius;
                spans.push((state.position.x - radius, state.position.x + radius, index));
            }
        }
    }
    spans.sort_by(|one, other| one.0.total_cmp(&other.0));
    let placed = |index: usize| {
        let collider = scene.bodies[index].collider.as_ref()?;
        Some(PlacedCollider {
            collider,
            position: Position(states[index].position),
            rotation: Rotation(states[index].rotation),
        })
    };
    let overlap = |a: usize, b: usize| {
        let (one, other) = (&scene.bodies[a], &scene.bodies[b]);
        let is_pair = one.layers.interact(other.layers) && !joined.contains(&order(a, b));
        if is_pair { placed(a)?.overlap(&placed(b)?) } else { None }
    };
    let mut deepest = 0.0_f64;
    for (place, &(_, end, a)) in spans.iter().enumerate() {
        let near = spans[place + 1..].iter().take_while(|(start, ..)| *start <= end);
        let near = near.map(|&(.., b)| b).filter(|&b| moves(a) || moves(b));
        let near = near.filter(|&b| DVec3::distance(states[a].position, states[b].position) <= radii[a] + radii[b]);
        for b in near.chain(planes.iter().copied().filter(|_| moves(a))) {
            deepest = deepest.max(overlap(a, b).unwrap_or(0.0));
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_of_all_pairs_is_told_and_what_is_joined_is_left_out() {
        let scene = Scene::parse("pyramid 3").unwrap();
        let states = |lift: f64| -> Vec<BodyState> {
            let mut states = scene.at_rest();
            for (state, body) in states.iter_mut().zip(&scene.bodies) {
                if body.kind == RigidBody::Dynamic {
                    state.position.y += lift;
                }
            }
            states
        };
        assert!(deepest(&scene, &states(0.5)) < 1e-9);
        assert!((deepest(&scene, &states(-0.03)) - 0.03).abs() < 1e-9);
        let mut moved = states(0.5);
        let last = moved.len() - 1;
        let below = moved[1].position;
        moved[last].position = below + DVec3::X * 0.95;
        assert!(deepest(&scene, &moved) > 0.01);
        let joined = Scene::parse("ragdolls 1").unwrap();
        assert!(deepest(&joined, &joined.at_rest()) < 0.01);
    }
}
