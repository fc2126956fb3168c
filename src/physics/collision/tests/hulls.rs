//! Hulls for the tests, built by trying every plane, and what a pair of them does by trying every
//! axis.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::{body, random_size};
use crate::physics::body::Body;
use crate::physics::shape::{Collider, Geometry, Hull};
use crate::physics::testing::Random;

/// Points nearer to a plane than this lie on it.
const FLAT: f64 = 1e-9;

/// The convex hull of points about their mean: a face for every plane through three of them that
/// has the others on one side.
pub fn hull_of(points: &[Vector3<f64>]) -> Hull {
    let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let points: Vec<_> = points.iter().map(|point| point - center).collect();
    let mut faces: BTreeMap<Vec<u32>, Vec<u32>> = BTreeMap::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let normal = (points[j] - points[i]).cross(&(points[k] - points[i])).normalize();
                let height = |point: &Vector3<f64>| normal.dot(&(point - points[i]));
                let (low, high) = points
                    .iter()
                    .map(height)
                    .fold((0.0, 0.0), |(low, high): (f64, f64), height| (low.min(height), high.max(height)));
                let outward = if high < FLAT { normal } else { -normal };
                if low < -FLAT && high > FLAT {
                    continue;
                }
                let on_face: Vec<_> =
                    (0..points.len() as u32).filter(|&index| height(&points[index as usize]).abs() < FLAT).collect();
                faces.entry(on_face.clone()).or_insert_with(|| turned_about(&points, on_face, &outward));
            }
        }
    }
    Hull::new(points, faces.into_values().collect())
}

/// The corners of a face, counter-clockwise about its normal.
fn turned_about(points: &[Vector3<f64>], mut corners: Vec<u32>, normal: &Vector3<f64>) -> Vec<u32> {
    let at = |corner: u32| points[corner as usize];
    let middle = corners.iter().map(|&corner| at(corner)).sum::<Vector3<f64>>() / corners.len() as f64;
    let u = (at(corners[0]) - middle).normalize();
    let v = normal.cross(&u);
    let angle = |corner: u32| f64::atan2((at(corner) - middle).dot(&v), (at(corner) - middle).dot(&u));
    corners.sort_by(|&one, &other| angle(one).total_cmp(&angle(other)));
    corners
}

/// A random hull: points on an ellipsoid, a prism, a box, a tetrahedron.
pub fn random_hull(random: &mut Random) -> Hull {
    let size = Vector3::from_fn(|_, _| random_size(random));
    let points: Vec<_> = match random.random_range(0..4) {
        0 => (0..random.random_range(5..16)).map(|_| random.direction().component_mul(&size)).collect(),
        1 => {
            let sides = random.random_range(3..9);
            let corner = |side: u32| (std::f64::consts::TAU * f64::from(side) / f64::from(sides)).sin_cos();
            let level = |side: u32, level: f64| Vector3::new(corner(side).0, level, corner(side).1);
            (0..sides).flat_map(|side| [-1.0, 1.0].map(|y| level(side, y).component_mul(&size))).collect()
        }
        2 => (0..8)
            .map(|bits| size.map_with_location(|row, _, half| if bits >> row & 1 == 0 { half } else { -half }))
            .collect(),
        _ => (0..4).map(|_| random.direction().component_mul(&size)).collect(),
    };
    hull_of(&points)
}

/// A body of that hull.
pub fn hull_body(hull: Hull, position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Body {
    let radius = hull.vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max);
    let geometry = Some(Geometry::Hull(Arc::new(hull)));
    Body { geometry, radius, ..body(&Collider::sphere(1.0), position, rotation) }
}

/// Vertices, face normals and edges of a box or hull, in world axes about its centre.
pub struct Features {
    pub vertices: Vec<Vector3<f64>>,
    pub normals: Vec<Vector3<f64>>,
    pub edges: Vec<Vector3<f64>>,
}

impl Features {
    pub fn of(body: &Body) -> Self {
        let turned = |local: Vec<Vector3<f64>>| local.iter().map(|vector| body.rotation * vector).collect::<Vec<_>>();
        match body.geometry.as_ref().unwrap() {
            Geometry::Cuboid { half } => {
                let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
                let vertex =
                    |bits: u32| half.map_with_location(|row, _, half| if bits >> row & 1 == 0 { half } else { -half });
                Self {
                    vertices: turned((0..8).map(vertex).collect()),
                    normals: turned(axes.iter().flat_map(|axis| [*axis, -axis]).collect()),
                    edges: turned(axes),
                }
            }
            Geometry::Hull(hull) => Self {
                vertices: turned(hull.vertices.clone()),
                normals: turned(hull.faces.iter().map(|face| face.normal).collect()),
                edges: turned(
                    hull.edges
                        .iter()
                        .map(|edge| hull.vertices[edge.ends[1] as usize] - hull.vertices[edge.ends[0] as usize])
                        .collect(),
                ),
            },
            _ => unreachable!("has no flat faces"),
        }
    }

    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.vertices.iter().map(|vertex| vertex.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// How far B must move along a direction to be clear of A.
pub fn depth_along(a: &Features, b: &Features, apart: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
    a.reach(direction) + b.reach(&-direction) - apart.dot(direction)
}

/// The least depth along the faces of A, the faces of B, and across all pairs of edges.
pub fn least_depths(a: &Body, b: &Body) -> [f64; 3] {
    let (one, other) = (Features::of(a), Features::of(b));
    let apart = b.position - a.position;
    let least = |axes: &mut dyn Iterator<Item = Vector3<f64>>| {
        axes.map(|axis| depth_along(&one, &other, &apart, &axis)).fold(f64::INFINITY, f64::min)
    };
    let crosses = one.edges.iter().flat_map(|edge| other.edges.iter().map(move |across| edge.cross(across)));
    let across = crosses.filter(|cross| cross.norm() > 1e-9).map(|cross| cross.normalize());
    [
        least(&mut one.normals.iter().copied()),
        least(&mut other.normals.iter().map(|normal| -normal)),
        least(&mut across.flat_map(|axis| [axis, -axis])),
    ]
}
