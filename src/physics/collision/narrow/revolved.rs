//! Solids of revolution about y with a straight flank, a cone or a cylinder, as clipped contacts see them: no polygon but
//! where faces are clipped.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use super::place::Place;
use super::{ClipBuffers, Faced, Least, Overlap, Rim, Segment, ShapePair, edge_contact, length_across, unit_across};
use crate::physics::collision::constants::{ON_FLANK, SQUARE_TILT};
use crate::physics::{ContactPoint, FeatureId};

/// A solid of revolution about y with a straight flank.
pub(crate) trait Revolved: Faced {
    /// Its flat ends.
    fn ends(&self) -> [Option<End>; 2];
    /// The point that it ends in, if it does.
    fn tip(&self) -> Option<Vector3<f64>>;
    /// sin γ and cos γ: how much of the flank's normals lies along the axis, and across.
    fn slant(&self) -> [f64; 2];
    /// Distance of the flank's tangent planes from the centre of mass.
    fn flank_offset(&self) -> f64;
    /// The farthest point along a direction.
    fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64>;
    /// The straight line of the flank in the direction of a unit vector (x, z) across the axis.
    fn generator(&self, toward: [f64; 2]) -> Segment;
    /// Where a point is, of a shape about that size.
    fn place(&self, point: &Vector3<f64>, size: f64) -> Place;

    /// Whether a unit normal is one of the flank.
    fn has_on_flank(&self, normal: &Vector3<f64>) -> bool {
        let [sine, _] = self.slant();
        (normal.y - sine).abs() < ON_FLANK
    }

    /// The end of which a unit normal is, if it is one's.
    fn end_of(&self, normal: &Vector3<f64>) -> Option<End> {
        self.ends().into_iter().flatten().find(|end| normal.y * end.outward > 1.0 - ON_FLANK * ON_FLANK)
    }

    /// The normal of the flank over that line.
    fn flank_normal(&self, [x, z]: [f64; 2]) -> Vector3<f64> {
        let [sine, cosine] = self.slant();
        Vector3::new(cosine * x, sine, cosine * z)
    }
}

impl<A: Revolved, B: Revolved> ShapePair<'_, A, B> {
    /// Leaves the points where the smooth surfaces touch in the buffers: along two lines, or where one of them has one
    /// foremost point.
    pub fn points_of_flanks(&self, least: &Least, buffers: &mut ClipBuffers) {
        let Least { normal, depth, .. } = *least;
        let toward_a = -self.b_in_a.enter(&normal);
        let (line_a, line_b) = (self.a.has_on_flank(&normal), self.b.has_on_flank(&toward_a));
        let feature = FeatureId::of_vertex(false, u32::from(line_a) << 1 | u32::from(line_b));
        buffers.found.clear();
        if line_a && line_b {
            let on_a = self.a.generator(unit_across(&normal));
            let on_b = Segment(self.b.generator(unit_across(&toward_a)).0.map(|end| self.b_in_a.place(&end)));
            edge_contact::touch(&on_a, &on_b, &Overlap { normal, depth }, feature, self.scale, &mut buffers.found);
            return;
        }
        // Of a line or an end no point is foremost of all.
        let point = if line_a || self.a.end_of(&normal).is_some() {
            self.b_in_a.place(&self.b.foremost(&toward_a)) + normal * (depth / 2.0)
        } else {
            self.a.foremost(&normal) - normal * (depth / 2.0)
        };
        buffers.found.push(ContactPoint { point, depth, feature });
    }
}

/// A disc that ends a solid of revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// By number.
    pub face: u32,
    /// Its height, y.
    pub level: f64,
    /// Of its normal along y: 1 or −1.
    pub outward: f64,
    pub radius: f64,
}

impl End {
    pub fn normal(&self) -> Vector3<f64> {
        Vector3::y() * self.outward
    }

    pub fn center(&self) -> Vector3<f64> {
        Vector3::y() * self.level
    }

    /// The rim's point in the direction of a unit vector (x, z).
    pub fn rim_point(&self, [x, z]: [f64; 2]) -> Vector3<f64> {
        Vector3::new(self.radius * x, self.level, self.radius * z)
    }

    /// Its rim, in the solid's axes.
    pub fn rim(&self) -> Rim {
        Rim { center: self.center(), axis: -self.normal(), radius: self.radius }
    }

    /// Adds points of the rim, evenly spread, counter-clockwise seen from outside. See [`SQUARE_TILT`] for where the first one
    /// is. A multiple of four of them.
    pub fn corners(&self, direction: &Vector3<f64>, count: usize, corners: &mut Vec<Vector3<f64>>) {
        let tilt = length_across(direction);
        let share = (tilt / SQUARE_TILT - 1.0).clamp(0.0, 1.0);
        let mut corner = if share >= 1.0 {
            unit_across(direction)
        } else if share > 0.0 {
            let foremost = f64::atan2(direction.z, direction.x);
            let quarter = (foremost / FRAC_PI_2).round() * FRAC_PI_2;
            let (sin, cos) = (quarter + (foremost - quarter) * share).sin_cos();
            [cos, sin]
        } else {
            [1.0, 0.0]
        };
        let (sin, cos) = (TAU / count as f64).sin_cos();
        let sin = -self.outward * sin;
        corners.extend((0..count).map(|_| {
            let [x, z] = corner;
            corner = [x * cos - z * sin, z * cos + x * sin];
            self.rim_point([x, z])
        }));
    }
}
