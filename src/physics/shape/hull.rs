//! Convex polyhedra: vertices, faces, edges, and what the separating axis test needs of them,
//! computed once.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use wide::f64x4;

use super::edge_lanes::EdgeLanes;
use crate::physics::VectorSet;

/// Vertices within this share of the bounding radius (L1 distance) of a kept one are dropped
/// where a hull is built from points (the 2009 engine's reduction at load).
pub(super) const VERTEX_EPSILON: f64 = 1e-2;

/// Edges count as parallel within this L1 distance of their unit directions. Far below the
/// angle at which two edges give different axes, far above rounding.
const PARALLEL_EPSILON: f64 = 1e-9;

/// Vertices that [`Hull::reach`] and [`Hull::farthest`] look at together.
const LANES: usize = 4;

/// A convex polyhedron in body axes, about the centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hull {
    pub vertices: Vec<Vector3<f64>>,
    pub faces: Vec<Face>,
    pub edges: Vec<Edge>,
    /// Unit directions of the edges, each once up to sign.
    pub edge_directions: Vec<Vector3<f64>>,
    /// Radius of the largest ball about the centre of mass that the hull holds, m.
    pub inner_radius: f64,
    /// The edges, eight at a time.
    pub edge_lanes: Vec<EdgeLanes>,
    /// The vertices by components, some at a time; the last ones fill up with the first.
    lanes: Vec<[[f64; LANES]; 3]>,
}

/// Where two faces meet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Its vertices.
    pub ends: [u32; 2],
    /// The faces on either side.
    pub faces: [u32; 2],
    /// Unit, from the first vertex to the second.
    pub direction: Vector3<f64>,
}

/// A plane polygon.
#[derive(Clone, Debug, PartialEq)]
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
            let direction = (vertices[to as usize] - vertices[from as usize]).normalize();
            edges.push(Edge { ends: [from, to], faces: [face, sides[&(to, from)]], direction });
            directions.insert(direction);
        }
        let faces: Vec<_> = loops.into_iter().map(|corners| Face::new(&vertices, corners)).collect();
        let inner_radius = faces.iter().map(|face| face.offset).fold(f64::INFINITY, f64::min);
        let edge_lanes = EdgeLanes::of(edges.len(), |index| {
            let Edge { ends, faces: beside, direction } = &edges[index];
            (vertices[ends[0] as usize], *direction, beside.map(|face| faces[face as usize].normal))
        });
        let edge_lanes = edge_lanes.collect();
        let lanes = vertices.chunks(LANES).map(|some| {
            std::array::from_fn(|axis| std::array::from_fn(|lane| some.get(lane).unwrap_or(&vertices[0])[axis]))
        });
        let lanes = lanes.collect();
        let edge_directions = directions.vectors().to_vec();
        Self { vertices, faces, edges, edge_directions, inner_radius, edge_lanes, lanes }
    }

    /// How far it reaches along a direction from the centre of mass (times the direction's
    /// length): the support function. All vertices are looked at, a few at a time, which measured
    /// took a fifth (8 vertices) to two fifths (128) as long as climbing from neighbor to neighbor.
    pub fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let mut farthest = [f64::NEG_INFINITY; LANES];
        for [x, y, z] in &self.lanes {
            for lane in 0..LANES {
                let along = x[lane] * direction.x + y[lane] * direction.y + z[lane] * direction.z;
                farthest[lane] = if along > farthest[lane] { along } else { farthest[lane] };
            }
        }
        farthest.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The vertex that is farthest along a direction.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let direction: [f64x4; 3] = direction.data.0[0].map(f64x4::splat);
        let (mut farthest, mut which) = (f64x4::splat(f64::NEG_INFINITY), f64x4::ZERO);
        for (index, lanes) in self.lanes.iter().enumerate() {
            let [x, y, z] = lanes.map(f64x4::from);
            let along = x * direction[0] + y * direction[1] + z * direction[2];
            let is_farther = along.simd_gt(farthest);
            farthest = is_farther.select(along, farthest);
            which = is_farther.select(f64x4::splat(index as f64), which);
        }
        let (farthest, which) = (farthest.to_array(), which.to_array());
        let lane = (1..LANES).fold(0, |first, lane| if farthest[lane] > farthest[first] { lane } else { first });
        self.lanes[which[lane] as usize].map(|axis| axis[lane]).into()
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

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;

    use crate::physics::testing::Random;
    use crate::physics::{Collider, Geometry};

    #[test]
    fn the_farthest_vertex_is_as_far_as_the_hull_reaches() {
        let mut random = Random::new(31);
        for count in 4..30 {
            let points: Vec<DVec3> = (0..count).map(|_| random.direction().into()).collect();
            let collider = Collider::convex_hull(&points).unwrap();
            let Geometry::Hull(hull) = collider.geometry() else { panic!("a hull") };
            for _ in 0..20 {
                let direction = random.direction();
                let farthest = hull.farthest(&direction);
                assert!(hull.vertices.contains(&farthest), "{count} points");
                assert!((farthest.dot(&direction) - hull.reach(&direction)).abs() < 1e-15, "{count} points");
            }
        }
    }
}
