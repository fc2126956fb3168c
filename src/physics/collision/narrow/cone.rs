//! The true circular cone, as clipped contacts see it: no polygon but where faces are clipped.
//!
//! In its body axes, apex up +y, centre of mass at the origin, it is the convex hull of its apex
//! (0, ¾h, 0) and its base disc of radius r at y = −¼h. So its support function is exact and
//! short:
//!
//!   h(u) = max(¾h u_y, −¼h u_y + r √(u_x² + u_z²)).
//!
//! On the Gauss map the base is one point, −y; the *flank* is the circle of normals
//! (cos γ ρ, sin γ), ρ any unit vector across the axis and tan γ = r/h, each normal that of a
//! generator line from the apex to the *rim*; the apex has the cap above that circle, and each
//! point of the rim the meridian below it.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use super::{Convex, Faced, Plane};
use crate::physics::collision::constants::{RIM_CORNERS, SQUARE_TILT};

/// A solid circular cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub radius: f64,
    /// Height of the apex over the centre of mass.
    pub apex: f64,
    /// Height of the base, negative.
    pub base: f64,
    /// sin γ: height of the flank's normals.
    pub sine: f64,
    /// cos γ: their reach across the axis.
    pub cosine: f64,
}

/// The parts of a cone that face a direction, by number.
const BASE: u32 = 0;
const FLANK: u32 = 1;

impl Cone {
    pub fn new(radius: f64, height: f64) -> Self {
        let slant = (radius * radius + height * height).sqrt();
        Self { radius, apex: 0.75 * height, base: -0.25 * height, sine: radius / slant, cosine: height / slant }
    }

    pub fn apex_point(&self) -> Vector3<f64> {
        Vector3::new(0.0, self.apex, 0.0)
    }

    pub fn base_normal() -> Vector3<f64> {
        -Vector3::y()
    }

    /// The rim's point in the direction of a unit vector (x, z) across the axis.
    pub fn rim_point(&self, [x, z]: [f64; 2]) -> Vector3<f64> {
        Vector3::new(self.radius * x, self.base, self.radius * z)
    }

    /// The flank's normal over that point.
    pub fn flank_normal(&self, [x, z]: [f64; 2]) -> Vector3<f64> {
        Vector3::new(self.cosine * x, self.sine, self.cosine * z)
    }

    /// Distance of the flank's tangent planes from the centre of mass.
    pub fn flank_offset(&self) -> f64 {
        self.sine * self.apex
    }

    /// The farthest point along a direction.
    pub fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let across = length_across(direction);
        if self.apex * direction.y > self.base * direction.y + self.radius * across {
            self.apex_point()
        } else {
            self.rim_point(unit_across(direction))
        }
    }

    /// Adds points of the rim, evenly spread, counter-clockwise seen from below. See
    /// [`SQUARE_TILT`] for where the first one is. A multiple of four of them.
    pub fn rim_corners(&self, direction: &Vector3<f64>, count: usize, corners: &mut Vec<Vector3<f64>>) {
        let tilt = length_across(direction);
        let share = (tilt / SQUARE_TILT - 1.0).clamp(0.0, 1.0);
        let mut corner = if share >= 1.0 {
            [direction.x / tilt, direction.z / tilt]
        } else if share > 0.0 {
            let foremost = f64::atan2(direction.z, direction.x);
            let quarter = (foremost / FRAC_PI_2).round() * FRAC_PI_2;
            let (sin, cos) = (quarter + (foremost - quarter) * share).sin_cos();
            [cos, sin]
        } else {
            [1.0, 0.0]
        };
        let (sin, cos) = (TAU / count as f64).sin_cos();
        corners.extend((0..count).map(|_| {
            let [x, z] = corner;
            corner = [x * cos - z * sin, z * cos + x * sin];
            self.rim_point([x, z])
        }));
    }
}

/// The part of a direction across the axis, as a unit vector (x, z); any if there is none.
pub(crate) fn unit_across(direction: &Vector3<f64>) -> [f64; 2] {
    let across = length_across(direction);
    if across > 0.0 { [direction.x / across, direction.z / across] } else { [1.0, 0.0] }
}

/// Of the part of a direction across the axis. The care of hypot is not needed, and costs more than all else here.
pub(crate) fn length_across(direction: &Vector3<f64>) -> f64 {
    (direction.x * direction.x + direction.z * direction.z).sqrt()
}

impl Convex for Cone {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let across = length_across(direction);
        (self.apex * direction.y).max(self.base * direction.y + self.radius * across)
    }

    fn inner_radius(&self) -> f64 {
        self.flank_offset().min(-self.base)
    }
}

/// Its one face is the base.
impl Faced for Cone {
    fn reference(&self, _: u32, corners: &mut Vec<Vector3<f64>>) -> Plane {
        self.incident(&Self::base_normal(), corners);
        Plane { normal: Self::base_normal(), offset: -self.base }
    }

    /// The base, as a polygon, or a generator line.
    fn incident(&self, direction: &Vector3<f64>, corners: &mut Vec<Vector3<f64>>) -> u32 {
        corners.clear();
        let across = length_across(direction);
        if -direction.y < self.cosine * across + self.sine * direction.y {
            corners.extend([self.apex_point(), self.rim_point(unit_across(direction))]);
            return FLANK;
        }
        self.rim_corners(direction, RIM_CORNERS, corners);
        BASE
    }
}
