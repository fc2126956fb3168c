//! Surfaces made of triangles: grounds that are not flat, walls, bowls.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::geometry::{PartList, Parts};
use super::triangles::Triangles;

/// Of the largest extent: a triangle lower than this over its longest side has no area.
const FLAT: f64 = 1e-9;

/// Coordinates that a vertex may have, m: areas are well within the range of `f64`.
const FARTHEST: f64 = 1e60;

/// Why some triangles make no mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No triangle is left.
    #[error("it has no triangle with an area; give at least one")]
    Empty,
    /// Too many.
    #[error("it has {count} triangles; give at most {}", TriangleMesh::MOST_TRIANGLES)]
    TooMany {
        /// How many.
        count: usize,
    },
    /// A coordinate is NaN, infinite, or beyond 1e60 m.
    #[error("vertex {index} (counted from 0) is not finite; give finite coordinates")]
    NotFinite {
        /// Of the first such vertex.
        index: usize,
    },
    /// A corner is no vertex.
    #[error("triangle {triangle} (counted from 0) names vertex {vertex}, but there are {count}")]
    NoVertex {
        /// Of the first such triangle.
        triangle: usize,
        /// Which it names.
        vertex: u32,
        /// How many there are.
        count: usize,
    },
}

/// A surface of triangles, for bodies that are static or kinematic. Cheap to clone.
///
/// The front of a triangle is where its corners go round counter-clockwise, and what touches it comes from there: the back
/// of a mesh lets everything through. Vertices in one place are one, and triangles without an area are left out. Whether
/// the surface is closed does not matter.
#[derive(Reflect, Clone, Debug)]
#[reflect(opaque, Clone, Debug, PartialEq)]
pub struct TriangleMesh(Arc<Parts>);

impl PartialEq for TriangleMesh {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.list() == other.list()
    }
}

impl TriangleMesh {
    /// Most triangles that a mesh has.
    pub const MOST_TRIANGLES: usize = 1 << 20;

    /// Of vertices in the body's axes, m, and triangles by the indices of their corners.
    ///
    /// # Errors
    /// A vertex is not finite, a corner is no vertex, there are too many triangles, or none has an area.
    pub fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        if triangles.len() > Self::MOST_TRIANGLES {
            return Err(MeshError::TooMany { count: triangles.len() });
        }
        let is_far = |vertex: &DVec3| !vertex.is_finite() || vertex.abs().max_element() > FARTHEST;
        if let Some(index) = vertices.iter().position(is_far) {
            return Err(MeshError::NotFinite { index });
        }
        let count = vertices.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
                return Err(MeshError::NoVertex { triangle, vertex, count });
            }
        }
        let (mut kept, mut places) = (Vec::new(), HashMap::new());
        let mut place = |vertex: u32| {
            let at = vertices[vertex as usize] + DVec3::ZERO; // −0 is 0
            *places.entry(at.to_array().map(f64::to_bits)).or_insert_with(|| {
                kept.push(Vector3::from(at));
                kept.len() as u32 - 1
            })
        };
        let has_area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| vertices[vertex as usize]);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() > FLAT * longest * longest
        };
        let corners: Vec<_> =
            triangles.iter().filter(|corners| has_area(corners)).map(|it| it.map(&mut place)).collect();
        if corners.is_empty() {
            return Err(MeshError::Empty);
        }
        Ok(Self(Arc::new(Parts::of_triangles(Triangles::new(kept, corners)))))
    }

    /// A ground of nx × nz squares, each of two triangles, over the rectangle of those sizes in m about the origin, whose
    /// height in m is a function of x and z; its front is up.
    ///
    /// # Errors
    /// A height or a size is not finite, there are too many triangles, or none has an area.
    pub fn height_field(
        size: [f64; 2],
        squares: [u32; 2],
        height: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, MeshError> {
        Self::grid(size, squares, |_, [x, z]| height(x, z))
    }

    /// Likewise, whose height is a function of which vertex it is along x and z, and of x and z.
    pub(crate) fn grid(
        [size_x, size_z]: [f64; 2],
        [nx, nz]: [u32; 2],
        height: impl Fn([u32; 2], [f64; 2]) -> f64,
    ) -> Result<Self, MeshError> {
        let count = 2 * nx as usize * nz as usize;
        if count > Self::MOST_TRIANGLES {
            return Err(MeshError::TooMany { count });
        }
        let along = |place: u32, count: u32, size: f64| (f64::from(place) / f64::from(count) - 0.5) * size;
        let mut vertices = Vec::with_capacity((nx as usize + 1) * (nz as usize + 1));
        for k in 0..=nz {
            for i in 0..=nx {
                let (x, z) = (along(i, nx, size_x), along(k, nz, size_z));
                vertices.push(DVec3::new(x, height([i, k], [x, z]), z));
            }
        }
        let at = |i: u32, k: u32| k * (nx + 1) + i;
        let mut triangles = Vec::with_capacity(count);
        for k in 0..nz {
            for i in 0..nx {
                triangles.push([at(i, k), at(i, k + 1), at(i + 1, k + 1)]);
                triangles.push([at(i, k), at(i + 1, k + 1), at(i + 1, k)]);
            }
        }
        Self::new(&vertices, &triangles)
    }

    /// The same seen from behind as well: each triangle once more, the other way round.
    ///
    /// # Errors
    /// That makes too many triangles.
    pub fn two_sided(&self) -> Result<Self, MeshError> {
        let list = self.list();
        let count = 2 * list.corners.len();
        if count > Self::MOST_TRIANGLES {
            return Err(MeshError::TooMany { count });
        }
        // Vertices of their own: front and back are two surfaces.
        let first = list.vertices.len() as u32;
        let back = list.corners.iter().map(|&[a, b, c]| [first + a, first + c, first + b]);
        let corners = list.corners.iter().copied().chain(back).collect();
        let vertices = list.vertices.iter().chain(&list.vertices).copied().collect();
        Ok(Self(Arc::new(Parts::of_triangles(Triangles::new(vertices, corners)))))
    }

    fn list(&self) -> &Triangles {
        match &self.0.list {
            PartList::Triangles(triangles) => triangles,
            PartList::Solids(_) => unreachable!("made of triangles"),
        }
    }

    /// In the body's axes, m.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = DVec3> {
        self.list().vertices.iter().map(|&vertex| vertex.into())
    }

    /// The corners of the triangles, as indices of vertices, counter-clockwise seen from the front.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.list().corners
    }

    /// The farthest vertex from the body's position, m.
    pub(super) fn radius(&self) -> f64 {
        self.list().radius
    }

    pub(super) fn parts(&self) -> Arc<Parts> {
        self.0.clone()
    }
}
