//! Convex polyhedra: vertices, faces, edges, and what the separating axis test needs of them,
//! computed once.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::super::collision::vector_set::VectorSet;

/// Vertices within this share of the bounding radius (L1 distance) of a kept one are dropped
/// where a hull is built from points (the 2009 engine's reduction at load).
pub(super) const VERTEX_EPSILON: f64 = 1e-2;

/// Edges count as parallel within this L1 distance of their unit directions. Far below the
/// angle at which two edges give different axes, far above rounding.
const PARALLEL_EPSILON: f64 = 1e-9;

/// A convex polyhedron in body axes, about the centre of mass.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub vertices: Vec<Vector3<f64>>,
    pub faces: Vec<Face>,
    pub edges: Vec<Edge>,
    /// Unit directions of the edges, each once up to sign.
    pub edge_directions: Vec<Vector3<f64>>,
}

/// Where two faces meet.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    /// Its vertices.
    pub ends: [u32; 2],
    /// The faces on either side.
    pub faces: [u32; 2],
}

/// A plane polygon.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// Unit, outward.
    pub normal: Vector3<f64>,
    /// Distance of its plane from the centre of mass along the normal.
    pub offset: f64,
    /// Counter-clockwise seen from outside.
    pub vertices: Vec<u32>,
}

impl Hull {
    /// From vertices and the loops of the faces of a closed surface, counter-clockwise seen from
    /// outside.
    pub fn new(vertices: Vec<Vector3<f64>>, loops: Vec<Vec<u32>>) -> Self {
        // Each edge is in the loops of two faces, once in each direction.
        let mut sides = BTreeMap::new();
        for (face, corners) in loops.iter().enumerate() {
            for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                sides.insert((from, to), face as u32);
            }
        }
        let mut edges = Vec::new();
        let mut directions = VectorSet::default();
        directions.reset(PARALLEL_EPSILON, true, 1.0);
        for (&(from, to), &face) in sides.iter().filter(|((from, to), _)| from < to) {
            edges.push(Edge { ends: [from, to], faces: [face, sides[&(to, from)]] });
            directions.insert((vertices[to as usize] - vertices[from as usize]).normalize());
        }
        let faces = loops.into_iter().map(|corners| Face::new(&vertices, corners)).collect();
        Self { vertices, faces, edges, edge_directions: directions.vectors().to_vec() }
    }
}

impl Face {
    /// The normal is Newell's: exact for triangles, and the best fit of a polygon that rounding
    /// has bent.
    fn new(vertices: &[Vector3<f64>], corners: Vec<u32>) -> Self {
        let at = |corner: u32| vertices[corner as usize];
        let origin = at(corners[0]);
        let normal = corners[1..]
            .windows(2)
            .map(|side| (at(side[0]) - origin).cross(&(at(side[1]) - origin)))
            .sum::<Vector3<f64>>()
            .normalize();
        let offset = corners.iter().map(|&corner| at(corner).dot(&normal)).sum::<f64>() / corners.len() as f64;
        Self { normal, offset, vertices: corners }
    }
}
