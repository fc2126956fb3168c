//! Collision detection: which bodies may touch, where, along which normal and how deep.
//!
//! Broad phase ([`sweep_and_sort`]) → candidate pairs → narrow phase ([`narrow_phase`]) →
//! [`Contacts`]. Everything here is `f64` and computed relative to body A of each pair, so that
//! it does not depend on the distance from the origin.

pub(crate) mod vector_set;

use bevy::prelude::*;
use nalgebra::Vector3;

/// Two bodies that may touch, as indices into [`super::bodies::Bodies`]. A is the one found
/// first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
}

/// Identifies a contact point of a pair from one step to the next: which features of A and B
/// (faces, edges, vertices) made it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct FeatureId(pub u32);

/// One point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPoint {
    /// World position. Clipped points lie half-way between the two surfaces.
    pub point: Vector3<f64>,
    /// Overlap along the manifold's normal, m; ≥ 0.
    pub depth: f64,
    pub feature: FeatureId,
}

/// How two bodies touch: a normal and a run of points in [`Contacts::points`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Manifold {
    pub pair: Pair,
    /// Unit, from A to B, world axes.
    pub normal: Vector3<f64>,
    /// Range in [`Contacts::points`].
    pub first_point: u32,
    pub point_count: u32,
    /// μ of the pair.
    pub friction: f64,
    /// e of the pair.
    pub restitution: f64,
}

/// The contacts of one step, in the order in which the broad phase found the pairs (half-space
/// pairs first).
#[derive(Resource, Default, Clone)]
pub(crate) struct Contacts {
    pub manifolds: Vec<Manifold>,
    pub points: Vec<ContactPoint>,
    /// Simulation time of the poses they were found at, s.
    pub time: f64,
}

impl Contacts {
    pub fn points_of(&self, manifold: &Manifold) -> &[ContactPoint] {
        let first = manifold.first_point as usize;
        &self.points[first..first + manifold.point_count as usize]
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Contacts>();
}
