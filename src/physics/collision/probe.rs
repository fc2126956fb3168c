//! How deep two placed colliders overlap, outside a step.

use bevy::prelude::*;

use super::narrow_phase::{Buffers, touch};
use crate::physics::body::Body;
use crate::physics::settings::SolverSettings;
use crate::physics::shape::{Collider, Geometry};
use crate::physics::{Position, Rotation};

/// A collider at a pose, to ask what it overlaps without a step.
#[derive(Clone, Copy, Debug)]
pub struct PlacedCollider<'a> {
    /// The shape.
    pub collider: &'a Collider,
    /// Its centre of mass, m.
    pub position: Position,
    /// Its orientation.
    pub rotation: Rotation,
}

impl PlacedCollider<'_> {
    /// How deep two overlap, m, along the direction in which that is least (over a half-space: its
    /// normal); 0 where they only touch. None: they are apart, or one has a size that makes no sense.
    pub fn overlap(&self, other: &Self) -> Option<f64> {
        if !self.collider.is_valid() || !other.collider.is_valid() {
            return None;
        }
        let reach = self.collider.bounding_radius() + other.collider.bounding_radius();
        if self.position.distance(other.position.0) > reach {
            return None; // before a hull is built for nothing
        }
        let (mut a, mut b) = (self.body(), other.body());
        if matches!(b.geometry, Some(Geometry::HalfSpace)) {
            std::mem::swap(&mut a, &mut b); // as in every pair of the broad phase
        }
        let overlap = touch(&a, &b, &SolverSettings::steady(), &mut Buffers::default(), &mut Vec::new())?;
        (overlap.depth >= 0.0).then_some(overlap.depth)
    }

    fn body(&self) -> Body {
        let mut body = Body::new(Entity::PLACEHOLDER);
        body.position = self.position.0.into();
        body.rotation = nalgebra::UnitQuaternion::new_normalize(self.rotation.0.into());
        body.geometry = Some(self.collider.geometry());
        body.radius = self.collider.bounding_radius();
        body
    }
}
