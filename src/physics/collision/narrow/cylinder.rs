//! The true circular cylinder, as clipped contacts see it.
//!
//! In its body axes it is the convex hull of two discs of radius r at y = ±½h, so its support function is
//!
//!   h(u) = ½h |u_y| + r √(u_x² + u_z²).
//!
//! On the Gauss map its ends are the points ±y, its *flank* is the equator, each normal that of a generator line, and each
//! point of a rim has the meridian between.

use nalgebra::Vector3;

use super::place::Place;
use super::revolved::{End, Revolved};
use super::{Convex, Faced, Plane, Rim, Segment, length_across, unit_across};
use crate::physics::collision::constants::RIM_CORNERS;

/// A solid circular cylinder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cylinder {
    pub radius: f64,
    /// Half the height.
    pub half: f64,
}

/// What faces a direction, by number: an end, or the flank.
const BOTTOM: u32 = 0;
const TOP: u32 = 1;
const FLANK: u32 = 2;

impl Cylinder {
    fn end(&self, face: u32) -> End {
        let outward = if face == TOP { 1.0 } else { -1.0 };
        End { face, level: outward * self.half, outward, radius: self.radius }
    }

    /// The end that a direction points to.
    fn end_toward(&self, direction: &Vector3<f64>) -> End {
        self.end(if direction.y > 0.0 { TOP } else { BOTTOM })
    }
}

impl Convex for Cylinder {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.half * direction.y.abs() + self.radius * length_across(direction)
    }

    fn inner_radius(&self) -> f64 {
        self.radius.min(self.half)
    }
}

/// Its faces are its ends.
impl Faced for Cylinder {
    fn reference(&self, face: u32, corners: &mut Vec<Vector3<f64>>) -> Plane {
        let end = self.end(face);
        corners.clear();
        end.corners(&end.normal(), RIM_CORNERS, corners);
        Plane { normal: end.normal(), offset: self.half }
    }

    /// An end, as a polygon, or a generator line.
    fn incident(&self, direction: &Vector3<f64>, corners: &mut Vec<Vector3<f64>>) -> u32 {
        corners.clear();
        if direction.y.abs() < length_across(direction) {
            corners.extend(self.generator(unit_across(direction)).0);
            return FLANK;
        }
        let end = self.end_toward(direction);
        end.corners(direction, RIM_CORNERS, corners);
        end.face
    }

    fn rim(&self, face: u32) -> Option<Rim> {
        Some(self.end(face).rim())
    }
}

impl Revolved for Cylinder {
    fn ends(&self) -> [Option<End>; 2] {
        [Some(self.end(BOTTOM)), Some(self.end(TOP))]
    }

    fn tip(&self) -> Option<Vector3<f64>> {
        None
    }

    fn slant(&self) -> [f64; 2] {
        [0.0, 1.0]
    }

    fn flank_offset(&self) -> f64 {
        self.radius
    }

    fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.end_toward(direction).rim_point(unit_across(direction))
    }

    fn generator(&self, toward: [f64; 2]) -> Segment {
        Segment([self.end(BOTTOM), self.end(TOP)].map(|end| end.rim_point(toward)))
    }

    /// All in the half-plane of the axis and the point.
    fn place(&self, point: &Vector3<f64>, size: f64) -> Place {
        let [x, z] = unit_across(point);
        let beside = point.x.hypot(point.z) - self.radius;
        let above = point.y.abs() - self.half;
        let over_flank = Place { normal: Vector3::new(x, 0.0, z), height: beside };
        if beside > 0.0 && above > 0.0 {
            let rim = self.end_toward(point).rim_point([x, z]);
            return Place::outside(point, &rim, size).unwrap_or(over_flank);
        }
        let over_end = Place { normal: self.end_toward(point).normal(), height: above };
        if beside > above { over_flank } else { over_end }
    }
}
