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

use nalgebra::Vector3;

use super::place::Place;
use super::revolved::{End, Revolved};
use super::{Convex, Faced, Plane, Rim, Segment, length_across, unit_across};
use crate::physics::collision::constants::RIM_CORNERS;

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

    /// Its base.
    pub fn bottom(&self) -> End {
        End { face: 0, level: self.base, outward: -1.0, radius: self.radius }
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
        self.bottom().corners(direction, RIM_CORNERS, corners);
        BASE
    }

    fn rim(&self, _: u32) -> Option<Rim> {
        Some(self.bottom().rim())
    }
}

impl Revolved for Cone {
    fn ends(&self) -> [Option<End>; 2] {
        [Some(self.bottom()), None]
    }

    fn tip(&self) -> Option<Vector3<f64>> {
        Some(self.apex_point())
    }

    fn slant(&self) -> [f64; 2] {
        [self.sine, self.cosine]
    }

    fn flank_offset(&self) -> f64 {
        self.sine * self.apex
    }

    fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        Self::foremost(self, direction)
    }

    fn generator(&self, toward: [f64; 2]) -> Segment {
        Segment([self.apex_point(), self.rim_point(toward)])
    }

    /// All in the half-plane of the axis and the point.
    fn place(&self, point: &Vector3<f64>, size: f64) -> Place {
        let [x, z] = unit_across(point);
        let across = point.x.hypot(point.z);
        let over_base = Place { normal: Self::base_normal(), height: self.base - point.y };
        let flank = self.flank_normal([x, z]);
        let over_flank = Place { normal: flank, height: flank.dot(point) - self.flank_offset() };
        if over_base.height <= 0.0 && over_flank.height <= 0.0 {
            return if over_base.height > over_flank.height { over_base } else { over_flank };
        }
        if over_base.height > 0.0 && across <= self.radius {
            return over_base;
        }
        // Else the nearest point of the generator line: the apex and the rim are its ends.
        let apex = self.apex_point();
        let line = self.rim_point([x, z]) - apex;
        let share = ((point - apex).dot(&line) / line.norm_squared()).clamp(0.0, 1.0);
        Place::outside(point, &(apex + line * share), size).unwrap_or(over_flank)
    }
}
