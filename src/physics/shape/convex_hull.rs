//! Any convex polyhedron, made from points.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::Vector3;

use super::hull::Face;
use super::principal_axes::principal_axes;
use super::quick_hull::{self, Degenerate};
use super::volume_integrals::VolumeIntegrals;
use super::{Hull, Measures, merge_facets};

/// Half the largest extent that a hull may have, m: its volume and moments are well within the
/// range of `f64`.
const HALF_EXTENTS: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// Of the extent: a centre of mass this near the middle of the extents is in it but for rounding.
const CENTER_ROUNDING: f64 = 1e-14;

/// Why some points have no convex hull that a body could have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// Fewer than four points.
    #[error("{count} points have no volume; give at least 4 that are not in one plane")]
    TooFewPoints {
        /// How many.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} (counted from 0) is not finite; give finite coordinates")]
    NotFinite {
        /// Of the first such point.
        index: usize,
    },
    /// All points are one.
    #[error("all {count} points are the same; give at least 4 that are not in one plane")]
    Coincident {
        /// How many.
        count: usize,
    },
    /// All points lie on a line, up to a millionth of their extent.
    #[error("all {count} points lie on one line; add points beside it")]
    Collinear {
        /// How many.
        count: usize,
    },
    /// All points lie in a plane, up to a millionth of their extent.
    #[error("all {count} points lie in one plane; add points beside it to give it a thickness")]
    Flat {
        /// How many.
        count: usize,
    },
    /// So large or so small that volume or inertia would leave the range of `f64`.
    #[error("the points reach over {extent:e} m; scale them to something from 1e-59 to 1e60 m")]
    Extent {
        /// The largest extent, m.
        extent: f64,
    },
}

/// The convex hull of points, about its centre of mass, in principal axes. Cheap to clone.
///
/// Vertices are reduced as in the 2009 engine: where one would be within 1 % of half the largest
/// extent of another (L1 distance), the outer one is kept; where the points lie flatter than a
/// tenth of that half extent, 1 % becomes a tenth of how thick they lie. Faces that bend by less
/// than a tenth of this merge. So no point lies farther in front of any face than 1.2 % of half
/// the largest extent, unless that would take more than [`ConvexHull::MAX_VERTICES`] vertices: a
/// fine ball keeps within 4 %. Exact corners stay exact.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque, Clone, Debug, PartialEq)]
pub struct ConvexHull(Arc<Measured>);

#[derive(Debug, PartialEq)]
struct Measured {
    hull: Arc<Hull>,
    center: DVec3,
    axes: DQuat,
    measures: Measures,
}

impl ConvexHull {
    /// Most vertices that a hull has.
    pub const MAX_VERTICES: usize = quick_hull::MAX_VERTICES;

    /// The hull of points in any order, inner ones and repeated ones among them.
    ///
    /// # Errors
    /// The points are not finite, too large or too small, or have no volume.
    pub fn new(points: &[DVec3]) -> Result<Self, HullError> {
        let (middle, half_extent) = bounds(points)?;
        // A power of two: scaling by it rounds nothing.
        let unit = half_extent.log2().ceil().exp2();
        let scaled: Vec<Vector3<f64>> = points.iter().map(|&point| ((point - middle) / unit).into()).collect();
        let count = points.len();
        let triangulation = quick_hull::triangulate(&scaled).map_err(|degenerate| match degenerate {
            Degenerate::Line => HullError::Collinear { count },
            Degenerate::Plane => HullError::Flat { count },
        })?;
        let (vertices, loops) = compact(&scaled, merge_facets::merge(&scaled, &triangulation));
        Ok(Self(Arc::new(Measured::new(vertices, loops, middle, unit))))
    }

    /// Centre of mass in the frame of the points.
    pub fn center(&self) -> DVec3 {
        self.0.center
    }

    /// Turns principal axes into those of the points: a vertex v is their point
    /// `center() + axes() * v`. The identity where theirs are principal.
    pub fn axes(&self) -> DQuat {
        self.0.axes
    }

    /// From the centre of mass, in principal axes, m.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = DVec3> {
        self.0.hull.vertices.iter().map(|&vertex| vertex.into())
    }

    /// The faces, each as indices of its vertices, counter-clockwise seen from outside.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.0.hull.faces.iter().map(|face| face.vertices.as_slice())
    }

    /// m³.
    pub fn volume(&self) -> f64 {
        self.0.measures.volume
    }

    /// The least distance from a face's plane to the vertex farthest behind it, m.
    pub fn thickness(&self) -> f64 {
        let hull = &self.0.hull;
        let depth = |vertex: &Vector3<f64>, face: &Face| face.offset - face.normal.dot(vertex);
        let behind = |face| hull.vertices.iter().map(|vertex| depth(vertex, face)).fold(0.0, f64::max);
        hull.faces.iter().map(behind).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn measures(&self) -> Measures {
        self.0.measures
    }

    /// Radius of the smallest sphere about the centre of mass that holds it, m.
    pub fn bounding_radius(&self) -> f64 {
        self.0.measures.radius
    }

    pub(super) fn hull(&self) -> Arc<Hull> {
        self.0.hull.clone()
    }
}

impl Measured {
    /// From vertices in units of `unit` about `middle`.
    fn new(vertices: Vec<Vector3<f64>>, loops: Vec<Vec<u32>>, middle: DVec3, unit: f64) -> Self {
        let center = VolumeIntegrals::of(&vertices, &loops).center;
        let center = center.map(|component| if component.abs() < CENTER_ROUNDING { 0.0 } else { component });
        let about_center: Vec<Vector3<f64>> = vertices.iter().map(|vertex| vertex - center).collect();
        let integrals = VolumeIntegrals::of(&about_center, &loops);
        let (axes, moments) = principal_axes(&(integrals.inertia() / integrals.volume));
        let turn = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::from(axes));
        let vertices: Vec<Vector3<f64>> =
            about_center.iter().map(|vertex| turn.inverse_transform_vector(vertex) * unit).collect();
        let measures = Measures {
            volume: integrals.volume * unit.powi(3),
            moments: moments * unit * unit,
            radius: vertices.iter().map(Vector3::norm).fold(0.0, f64::max),
        };
        let center = middle + DVec3::from(center) * unit;
        Self { hull: Arc::new(Hull::new(vertices, loops)), center, axes, measures }
    }
}

/// The middle of the extents and half the largest.
fn bounds(points: &[DVec3]) -> Result<(DVec3, f64), HullError> {
    if let Some(index) = points.iter().position(|point| !point.is_finite()) {
        return Err(HullError::NotFinite { index });
    }
    let count = points.len();
    if count < 4 {
        return Err(HullError::TooFewPoints { count });
    }
    let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), &p| (low.min(p), high.max(p)));
    // Halved first: their sum and difference may leave the range.
    let half_extent = (high / 2.0 - low / 2.0).max_element();
    if low == high {
        Err(HullError::Coincident { count })
    } else if HALF_EXTENTS.contains(&half_extent) {
        Ok((high / 2.0 + low / 2.0, half_extent))
    } else {
        Err(HullError::Extent { extent: 2.0 * half_extent })
    }
}

/// The vertices that the loops use, in the order of the points, and the loops of their indices.
fn compact(points: &[Vector3<f64>], mut loops: Vec<Vec<u32>>) -> (Vec<Vector3<f64>>, Vec<Vec<u32>>) {
    let mut used: Vec<u32> = loops.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    for corner in loops.iter_mut().flatten() {
        *corner = used.partition_point(|index| index < corner) as u32;
    }
    (used.iter().map(|&index| points[index as usize]).collect(), loops)
}
