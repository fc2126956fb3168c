//! Tests of collision detection, one module a piece, and the random bodies they share.

mod bounding_tree;
mod broad_phase;
mod cones;
mod feature_sat;
mod gaps;
mod hulls;
mod manifolds;
mod persistent_pairs;
mod room;
mod sat;
mod systems;
mod vector_set;

use bevy::prelude::Entity;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::manifold::{ContactPoint, Overlap};
use super::narrow_phase::{self, Buffers};
use crate::physics::body::Body;
use crate::physics::body::RigidBody;
use crate::physics::settings::{ContactModel, SolverSettings, SweepSettings};
use crate::physics::shape::Collider;

/// All candidate axes, so that depths are the least.
fn exact(contacts: ContactModel) -> SolverSettings {
    let classic = SolverSettings::classic();
    SolverSettings { sweeps: SweepSettings { axis_epsilon: 0.0, contacts, ..classic.sweeps }, ..classic }
}

fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

fn random_vector(random: &mut Pcg64Mcg, reach: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-reach..=reach))
}

/// Uniform on the sphere, by rejection.
fn random_direction(random: &mut Pcg64Mcg) -> Vector3<f64> {
    loop {
        let vector = random_vector(random, 1.0);
        if (0.01..=1.0).contains(&vector.norm_squared()) {
            return vector.normalize();
        }
    }
}

fn random_rotation(random: &mut Pcg64Mcg) -> UnitQuaternion<f64> {
    loop {
        let quaternion = Quaternion::from(nalgebra::Vector4::from_fn(|_, _| random.random_range(-1.0..=1.0)));
        if (0.01..=1.0).contains(&quaternion.norm_squared()) {
            return UnitQuaternion::from_quaternion(quaternion);
        }
    }
}

fn random_size(random: &mut Pcg64Mcg) -> f64 {
    random.random_range(0.2..2.0)
}

const KINDS: [fn(&mut Pcg64Mcg) -> Collider; 3] = [
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
fn random_pair(random: &mut Pcg64Mcg, kinds: [usize; 2]) -> [Body; 2] {
    let [a, b] = kinds.map(|kind| {
        let collider = KINDS[kind](random);
        body(&collider, random_vector(random, 5.0), random_rotation(random))
    });
    let distance = (a.radius + b.radius) * random.random_range(0.2..1.1);
    let position = a.position + random_direction(random) * distance;
    [a, Body { position, ..b }]
}

fn touch(a: &Body, b: &Body, settings: &SolverSettings) -> Option<(Overlap, Vec<ContactPoint>)> {
    let mut points = Vec::new();
    let overlap = narrow_phase::touch(a, b, settings, &mut Buffers::default(), &mut points)?;
    Some((overlap, points))
}

fn assert_close(a: Vector3<f64>, b: Vector3<f64>, tolerance: f64) {
    assert!((a - b).norm() <= tolerance, "{a:?} is not {b:?} to {tolerance}");
}

fn deepest(points: &[ContactPoint]) -> f64 {
    points.iter().map(|point| point.depth).fold(0.0, f64::max)
}

/// A small seeded generator (Marsaglia's xorshift64).
struct Xorshift(u64);

impl Xorshift {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [−1, 1)³.
    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0)
    }

    fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }
}
