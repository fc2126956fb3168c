//! Tests of collision detection, one module a piece, and the random bodies they share.

mod bounding_tree;
mod broad_phase;
mod cones;
mod feature_sat;
mod gaps;
mod hulls;
mod manifolds;
mod parts;
mod persistent_pairs;
mod room;
mod sat;
mod systems;
mod vector_set;

use bevy::prelude::Entity;
use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::manifold::{ContactPoint, Overlap, PartPair};
use super::narrow_phase::{self, Buffers};
use crate::physics::body::{Body, RigidBody};
use crate::physics::settings::{ContactModel, SolverSettings, SweepSettings};
use crate::physics::shape::Collider;
use crate::physics::testing::Random;

/// All candidate axes, so that depths are the least.
fn exact(contacts: ContactModel) -> SolverSettings {
    let classic = SolverSettings::classic();
    SolverSettings { sweeps: SweepSettings { axis_epsilon: 0.0, contacts, ..classic.sweeps }, ..classic }
}

fn random_size(random: &mut Random) -> f64 {
    random.random_range(0.2..2.0)
}

const KINDS: [fn(&mut Random) -> Collider; 3] = [
    |random| Collider::sphere(random_size(random)),
    |random| Collider::cuboid(random_size(random), random_size(random), random_size(random)),
    |random| Collider::cone(random_size(random), random_size(random)),
];

fn body(collider: &Collider, position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Body {
    Body {
        kind: RigidBody::Dynamic,
        position,
        rotation,
        geometry: Some(collider.geometry()),
        radius: collider.bounding_radius(),
        ..Body::new(Entity::PLACEHOLDER)
    }
}

fn upright(collider: &Collider, position: [f64; 3]) -> Body {
    body(collider, Vector3::from(position), UnitQuaternion::identity())
}

/// Two bodies of random shapes of those kinds, turned at random, near enough to touch often.
fn random_pair(random: &mut Random, kinds: [usize; 2]) -> [Body; 2] {
    let [a, b] = kinds.map(|kind| {
        let collider = KINDS[kind](random);
        body(&collider, random.vector() * 5.0, random.rotation())
    });
    let distance = (a.radius + b.radius) * random.random_range(0.2..1.1);
    let position = a.position + random.direction() * distance;
    [a, Body { position, ..b }]
}

fn touch(a: &Body, b: &Body, settings: &SolverSettings) -> Option<(Overlap, Vec<ContactPoint>)> {
    let mut points = Vec::new();
    let overlap = narrow_phase::touch([a, b], PartPair::default(), settings, &mut Buffers::default(), &mut points)?;
    Some((overlap, points))
}

fn assert_close(a: Vector3<f64>, b: Vector3<f64>, tolerance: f64) {
    assert!((a - b).norm() <= tolerance, "{a:?} is not {b:?} to {tolerance}");
}

fn deepest(points: &[ContactPoint]) -> f64 {
    points.iter().map(|point| point.depth).fold(0.0, f64::max)
}
