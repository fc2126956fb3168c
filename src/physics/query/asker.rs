//! The shape that a question is asked with.

use std::cell::OnceCell;

use bevy::prelude::*;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::index::box_at;
use super::solid::{Solid, axes_of, solid_at};
use crate::physics::collision::PlacedCollider;
use crate::physics::{Body, BoundingBox, Geometry};

/// A shape where it is asked with, and a body with it once somebody wants one: most questions end without.
pub(super) struct Asker {
    /// Whose shape it is, or [`Entity::PLACEHOLDER`].
    pub entity: Entity,
    pub position: Vector3<f64>,
    pub axes: Matrix3<f64>,
    pub geometry: Geometry,
    /// Bounding radius.
    pub radius: f64,
    rotation: UnitQuaternion<f64>,
    body: OnceCell<Box<Body>>,
}

impl Asker {
    /// None: its rotation is none.
    // Else it is copied where it is returned, which takes a tenth of an overlap of balls.
    #[inline(always)]
    pub fn new(placed: &PlacedCollider) -> Option<Self> {
        let (geometry, radius) = (placed.collider.geometry(), placed.collider.bounding_radius());
        Some(Self::at(Entity::PLACEHOLDER, placed.pose()?, geometry, radius))
    }

    /// Of a body; none without a shape.
    pub fn of(body: &Body) -> Option<Self> {
        Some(Self::at(body.entity, (body.position, body.rotation), body.geometry.clone()?, body.radius))
    }

    #[inline(always)]
    fn at(
        entity: Entity,
        (position, rotation): (Vector3<f64>, UnitQuaternion<f64>),
        geometry: Geometry,
        radius: f64,
    ) -> Self {
        let axes = axes_of(&geometry, &rotation);
        Self { entity, position, axes, geometry, radius, rotation, body: OnceCell::new() }
    }

    /// A body of that shape there.
    pub fn body(&self) -> &Body {
        self.body.get_or_init(|| {
            Box::new(Body {
                position: self.position,
                rotation: self.rotation,
                geometry: Some(self.geometry.clone()),
                radius: self.radius,
                ..Body::new(self.entity)
            })
        })
    }

    /// A box that holds it for certain; none of a half-space.
    pub fn bounds(&self) -> Option<BoundingBox> {
        box_at(&self.geometry, (self.position, self.axes), self.radius)
    }

    /// The shape, or that part of it, from a place, as [`solid_at`] has it.
    pub fn solid(&self, part: u32, from: &Vector3<f64>) -> Option<Solid<'_>> {
        solid_at(&self.geometry, (self.position - from, self.axes), self.radius, part)
    }
}
