//! The rim of a flat end.

use nalgebra::Vector3;

use super::Frame;
use crate::physics::collision::constants::NEAR_AXIS;
use crate::physics::contact::tangents;

/// The rim of a flat end at its place, in a pair's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rim {
    pub center: Vector3<f64>,
    /// Unit, from the end into the body.
    pub axis: Vector3<f64>,
    pub radius: f64,
}

impl Rim {
    /// In other axes.
    pub fn placed(&self, frame: &Frame) -> Self {
        Self { center: frame.place(&self.center), axis: frame.rotation * self.axis, ..*self }
    }

    /// Unit, across the axis, toward where a direction points; any if that is the axis.
    #[inline]
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let across = self.across(direction);
        let square = across.norm_squared();
        if square > NEAR_AXIS * direction.norm_squared() { across / square.sqrt() } else { self.near_axis(&across) }
    }

    /// Of a direction that rounding has left partly along the axis.
    #[cold]
    fn near_axis(&self, across: &Vector3<f64>) -> Vector3<f64> {
        let unit = across.try_normalize(0.0).map(|unit| self.across(&unit));
        unit.and_then(|unit| unit.try_normalize(0.5)).unwrap_or_else(|| tangents(&self.axis)[0])
    }

    pub fn across(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        direction - self.axis * self.axis.dot(direction)
    }

    /// How far along the way from a point of its disc to another point, 0 to 1, the rim or the other point is, all seen along the
    /// axis.
    pub fn share_within(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
        let (start, way) = (self.across(&(from - self.center)), self.across(&(to - from)));
        let (square, along) = (way.norm_squared(), start.dot(&way));
        let inside = self.radius * self.radius - start.norm_squared();
        let root = (along * along + square * inside).max(0.0).sqrt();
        let share = (root - along) / square;
        if share < 1.0 { share.max(0.0) } else { 1.0 }
    }

    /// The point in the direction of a unit vector across the axis.
    pub fn point(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.center + direction * self.radius
    }
}
