//! A cone where it lies to another: in the axes of their pair, by its axis, apex and rim.

use nalgebra::Vector3;

use super::{Cone, Frame, Rim};

/// A solid cone at its place, in a pair's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedCone {
    pub apex: Vector3<f64>,
    /// Of the base; its axis points to the apex.
    pub rim: Rim,
    /// sin γ and cos γ of the flank's normals, see [`Cone`].
    pub sine: f64,
    pub cosine: f64,
}

impl PlacedCone {
    pub fn new(cone: &Cone, frame: &Frame) -> Self {
        let axis = frame.rotation.column(1).into_owned();
        Self {
            apex: frame.center + axis * cone.apex,
            rim: Rim { center: frame.center + axis * cone.base, axis, radius: cone.radius },
            sine: cone.sine,
            cosine: cone.cosine,
        }
    }

    /// In its own axes.
    pub fn upright(cone: &Cone) -> Self {
        Self { apex: cone.apex_point(), rim: cone.bottom().rim(), sine: cone.sine, cosine: cone.cosine }
    }

    /// The flank's normal over the rim's point in the direction of a unit vector across the axis.
    pub fn flank_normal(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        direction * self.cosine + self.rim.axis * self.sine
    }

    /// How far it reaches along a direction from the origin of the pair's axes.
    pub fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let across = self.rim.across(direction);
        self.apex.dot(direction).max(self.rim.center.dot(direction) + self.rim.radius * across.norm())
    }

    /// The farthest point along a direction.
    pub fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let on_rim = self.rim.point(&self.rim.direction(direction));
        if self.apex.dot(direction) > on_rim.dot(direction) { self.apex } else { on_rim }
    }

    /// How deep a point lies behind the flank, extended downward without end.
    pub fn flank_depth(&self, point: &Vector3<f64>) -> f64 {
        let arm = point - self.apex;
        let along = arm.dot(&self.rim.axis);
        -(self.sine * along + self.cosine * (arm - self.rim.axis * along).norm())
    }

    /// Whether it holds a point.
    pub fn holds(&self, point: &Vector3<f64>) -> bool {
        self.holds_about(point, 0.0)
    }

    /// Whether a point lies beyond no surface by more than a distance.
    pub fn holds_about(&self, point: &Vector3<f64>, distance: f64) -> bool {
        (point - self.rim.center).dot(&self.rim.axis) >= -distance && self.flank_depth(point) >= -distance
    }

    /// Its apex, centre of mass and centre of the base.
    pub fn axis_points(&self) -> [Vector3<f64>; 3] {
        [self.apex, self.rim.center.lerp(&self.apex, 0.25), self.rim.center]
    }
}
