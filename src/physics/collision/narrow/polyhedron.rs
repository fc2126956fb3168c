//! What the narrow phase asks of a convex polyhedron, in its own body axes: planes of faces, edges
//! with the faces beside them, corners, reach. Boxes answer in closed form.

use nalgebra::{Matrix3, Vector3};

use crate::physics::shape::Face;
use crate::physics::{EdgeLanes, EdgeParts, Hull, Refill};

/// A body's axes and centre in those of another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Columns are the axes.
    pub rotation: Matrix3<f64>,
    pub center: Vector3<f64>,
}

impl Frame {
    /// The other's axes and centre in those of this one.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, center: -(rotation * self.center) }
    }

    /// A point of the framed body, in the axes of the other.
    pub fn place(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.center
    }

    /// A direction of the other's axes, in those of the framed body.
    pub fn enter(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(direction)
    }
}

/// The plane of a face.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    /// Unit, outward.
    pub normal: Vector3<f64>,
    /// Distance from the centre along the normal.
    pub offset: f64,
}

/// An edge, and the normals of the faces beside it. On the unit sphere (the Gauss map) the arc
/// between these are the directions in which the edge is foremost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub index: u32,
    pub start: Vector3<f64>,
    /// Unit, along the edge.
    pub direction: Vector3<f64>,
    pub length: f64,
    pub normals: [Vector3<f64>; 2],
}

impl Edge {
    /// In the axes of another body, the shape mirrored in the origin or not: the normals turn, the
    /// place does not.
    pub fn placed(&self, frame: &Frame, mirrored: bool) -> Self {
        let sign = if mirrored { -1.0 } else { 1.0 };
        Self {
            start: frame.place(&self.start),
            direction: frame.rotation * self.direction,
            normals: self.normals.map(|normal| frame.rotation * normal * sign),
            ..*self
        }
    }

    pub fn parts(&self) -> EdgeParts {
        (self.start, self.direction, self.normals)
    }

    pub fn segment(&self) -> Segment {
        Segment([self.start, self.start + self.direction * self.length])
    }

    /// Whether the arcs of an edge and of a mirrored one cross: then both edges are foremost in
    /// one direction, and bound the Minkowski difference together (Gregorius, GDC 2013).
    #[inline]
    pub fn crosses(&self, other: &Self) -> bool {
        let [a, b] = self.normals.map(|normal| normal.dot(&other.direction));
        if a * b >= 0.0 {
            return false;
        }
        let [c, d] = other.normals.map(|normal| normal.dot(&self.direction));
        if c * d >= 0.0 {
            return false;
        }
        // Where each arc meets the plane of the other: the same point, or opposite ones.
        let point = self.normals[0] * b.abs() + self.normals[1] * a.abs();
        let other_point = other.normals[0] * d.abs() + other.normals[1] * c.abs();
        point.dot(&other_point) > 0.0
    }

    /// Whether a unit direction across the edge lies in its arc, up to that much rounding.
    #[inline]
    pub fn arc_holds(&self, direction: &Vector3<f64>, rounding: f64) -> bool {
        let [one, other] = self.normals.map(|normal| normal.dot(direction));
        let cosine = self.normals[0].dot(&self.normals[1]);
        one - cosine * other >= -rounding && other - cosine * one >= -rounding
    }

    /// How far a point lies beyond the edge at most, along any direction of its arc.
    #[inline]
    pub fn height_of(&self, point: &Vector3<f64>) -> f64 {
        let arm = point - self.start;
        let [one, other] = self.normals.map(|normal| normal.dot(&arm));
        let cosine = self.normals[0].dot(&self.normals[1]);
        if one > cosine * other && other > cosine * one {
            // What of the arm lies across the edge points between the normals.
            let along = arm.dot(&self.direction);
            (arm.norm_squared() - along * along).max(0.0).sqrt()
        } else {
            one.max(other)
        }
    }
}

/// The ends of an edge.
#[derive(Clone, Copy)]
pub(crate) struct Segment(pub [Vector3<f64>; 2]);

impl Segment {
    pub fn along(&self) -> Vector3<f64> {
        self.0[1] - self.0[0]
    }

    pub fn at(&self, share: f64) -> Vector3<f64> {
        self.0[0] + self.along() * share
    }

    /// Of the angle between two.
    pub fn squared_sine(&self, other: &Self) -> f64 {
        let (u, v) = (self.along(), other.along());
        u.cross(&v).norm_squared() / (u.norm_squared() * v.norm_squared())
    }

    /// Share of the way at which a point is nearest, beyond the ends too.
    pub fn share_of(&self, point: &Vector3<f64>) -> f64 {
        let along = self.along();
        (point - self.0[0]).dot(&along) / along.norm_squared()
    }
}

/// A convex shape about the origin of its axes.
pub(crate) trait Convex {
    /// The support function: how far it reaches along a direction from the origin.
    fn reach(&self, direction: &Vector3<f64>) -> f64;
    /// Radius of the largest ball about the origin that it holds.
    fn inner_radius(&self) -> f64;
}

/// A convex polyhedron.
pub(crate) trait Polyhedron: Convex {
    fn face_count(&self) -> usize;
    fn face(&self, index: usize) -> Plane;
    /// The face whose normal is nearest to a direction, of those that hold a foremost vertex.
    fn face_toward(&self, direction: &Vector3<f64>) -> usize;
    /// Replaces what is in `corners` by those of a face, counter-clockwise seen from outside.
    fn corners(&self, face: usize, corners: &mut Vec<Vector3<f64>>);
    fn edge_count(&self) -> usize;
    fn edge(&self, index: usize) -> Edge;
    /// The edges, eight at a time, where there are many.
    fn edge_lanes(&self) -> &[EdgeLanes] {
        &[]
    }
    fn vertex_count(&self) -> usize;
    fn vertex(&self, index: usize) -> Vector3<f64>;
    /// The face that stands for a normal which the surface that this is a part of does not have here.
    fn face_instead(&self, _normal: &Vector3<f64>) -> Option<usize> {
        None
    }
    /// Whether it is part of a surface, which has contact points over its faces alone.
    fn is_of_mesh(&self) -> bool {
        false
    }
    /// The farthest vertex along a direction.
    fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.vertex(first_max((0..self.vertex_count()).map(|index| self.vertex(index).dot(direction))))
    }
}

/// A box by its half extents. Faces are numbered +x, −x, +y, …; an edge by its axis and the signs
/// of its place along the next two; a vertex by its signs along x, y, z. A set bit is a minus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuboid {
    pub half: Vector3<f64>,
}

fn sign_of_bit(bits: usize, bit: usize) -> f64 {
    if bits >> bit & 1 == 0 { 1.0 } else { -1.0 }
}

impl Polyhedron for Cuboid {
    fn face_count(&self) -> usize {
        6
    }

    fn face(&self, index: usize) -> Plane {
        let mut normal = Vector3::zeros();
        normal[index / 2] = sign_of_bit(index, 0);
        Plane { normal, offset: self.half[index / 2] }
    }

    fn face_toward(&self, direction: &Vector3<f64>) -> usize {
        let axis = direction.iamax();
        2 * axis + usize::from(direction[axis] < 0.0)
    }

    fn corners(&self, face: usize, corners: &mut Vec<Vector3<f64>>) {
        let (axis, sign) = (face / 2, sign_of_bit(face, 0));
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        corners.clear();
        // Turns about +axis; on the opposite face `sign` mirrors v, and so the turn.
        corners.extend([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[along_u, along_v]| {
            let mut corner = Vector3::zeros();
            corner[axis] = sign * self.half[axis];
            corner[u] = along_u * self.half[u];
            corner[v] = along_v * sign * self.half[v];
            corner
        }));
    }

    fn edge_count(&self) -> usize {
        12
    }

    fn edge(&self, index: usize) -> Edge {
        let axis = index / 4;
        let sides = [((axis + 1) % 3, sign_of_bit(index, 1)), ((axis + 2) % 3, sign_of_bit(index, 0))];
        let mut start = Vector3::zeros();
        start[axis] = -self.half[axis];
        let mut direction = Vector3::zeros();
        direction[axis] = 1.0;
        let normals = sides.map(|(side, sign)| {
            start[side] = sign * self.half[side];
            let mut normal = Vector3::zeros();
            normal[side] = sign;
            normal
        });
        Edge { index: index as u32, start, direction, length: 2.0 * self.half[axis], normals }
    }

    fn vertex_count(&self) -> usize {
        8
    }

    fn vertex(&self, index: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| sign_of_bit(index, axis) * self.half[axis])
    }

    fn foremost(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.half.zip_map(direction, f64::copysign)
    }
}

impl Convex for Cuboid {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        direction.abs().dot(&self.half)
    }

    fn inner_radius(&self) -> f64 {
        self.half.min()
    }
}

impl Polyhedron for Hull {
    fn face_count(&self) -> usize {
        self.faces.len()
    }

    fn face(&self, index: usize) -> Plane {
        let face = &self.faces[index];
        Plane { normal: face.normal, offset: face.offset }
    }

    fn face_toward(&self, direction: &Vector3<f64>) -> usize {
        let looks = |face: &Face| face.normal.dot(direction);
        let level = self.reach(direction) * (1.0 - NEAREST);
        let is_foremost =
            |face: &Face| face.vertices.iter().any(|&at| self.vertices[at as usize].dot(direction) >= level);
        let nearest = first_max(self.faces.iter().map(looks));
        if is_foremost(&self.faces[nearest]) {
            return nearest;
        }
        // Beside a flat face a corner may stand out.
        first_max(self.faces.iter().map(|face| if is_foremost(face) { looks(face) } else { f64::NEG_INFINITY }))
    }

    fn corners(&self, face: usize, corners: &mut Vec<Vector3<f64>>) {
        corners.refill(self.faces[face].vertices.iter().map(|&vertex| self.vertices[vertex as usize]));
    }

    fn edge_count(&self) -> usize {
        self.edges.len()
    }

    fn edge(&self, index: usize) -> Edge {
        let edge = &self.edges[index];
        let [start, end] = edge.ends.map(|vertex| self.vertices[vertex as usize]);
        Edge {
            index: index as u32,
            start,
            direction: edge.direction,
            length: edge.direction.dot(&(end - start)),
            normals: edge.faces.map(|face| self.faces[face as usize].normal),
        }
    }

    fn edge_lanes(&self) -> &[EdgeLanes] {
        &self.edge_lanes
    }

    fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    fn vertex(&self, index: usize) -> Vector3<f64> {
        self.vertices[index]
    }
}

impl Convex for Hull {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.reach(direction)
    }

    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }
}

/// Index of the greatest value, the first of equals; 0 for none.
pub(crate) fn first_max(values: impl Iterator<Item = f64>) -> usize {
    let start = (0, f64::NEG_INFINITY);
    values.enumerate().fold(start, |best, (index, value)| if value > best.1 { (index, value) } else { best }).0
}

/// A share of a distance that is rounding.
const NEAREST: f64 = 4.0 * f64::EPSILON;

/// The point of a hull nearest to a point in body axes (Ericson 2005, 5.1): it lies on one of the
/// faces that the point is in front of, and on none that is farther below it than a point found.
pub(crate) fn nearest_on_hull(hull: &Hull, point: &Vector3<f64>) -> Vector3<f64> {
    let mut nearest = (f64::INFINITY, *point);
    let face_along = |way: &Vector3<f64>| first_max(hull.faces.iter().map(|face| face.normal.dot(way)));
    let mut face = first_max(hull.faces.iter().map(|face| face.normal.dot(point) - face.offset));
    // The face that looks along the way found so far is mostly one that has the nearest point.
    for _ in 0..hull.faces.len() {
        let before = nearest.0;
        if look_at_face(hull, &hull.faces[face], point, &mut nearest) || has_all_behind(hull, point, &nearest.1) {
            return nearest.1;
        }
        if nearest.0 >= before {
            break;
        }
        face = face_along(&(point - nearest.1));
    }
    for face in &hull.faces {
        if look_at_face(hull, face, point, &mut nearest) {
            break;
        }
    }
    nearest.1
}

/// Takes in the nearest point of a face, with its squared distance, if it may be nearer. Whether no other can be.
fn look_at_face(hull: &Hull, face: &Face, point: &Vector3<f64>, nearest: &mut (f64, Vector3<f64>)) -> bool {
    let height = face.normal.dot(point) - face.offset;
    if height <= 0.0 || height * height >= nearest.0 {
        return false;
    }
    let foot = point - face.normal * height;
    let corner = |index: usize| hull.vertices[face.vertices[index % face.vertices.len()] as usize];
    let sides = || (0..face.vertices.len()).map(|index| (corner(index), corner(index + 1)));
    let beyond = |from: &Vector3<f64>, to: &Vector3<f64>| face.normal.cross(&(to - from)).dot(&(foot - from)) < 0.0;
    if sides().all(|(from, to)| !beyond(&from, &to)) {
        // Above a face itself.
        *nearest = (height * height, foot);
        return true;
    }
    for (from, to) in sides().filter(|(from, to)| beyond(from, to)) {
        let side = to - from;
        let share = ((point - from).dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
        let candidate = from + side * share;
        let distance = (point - candidate).norm_squared();
        if distance < nearest.0 {
            *nearest = (distance, candidate);
        }
    }
    false
}

/// Whether a plane through a point of the hull, across the way from there to a point, has the whole hull behind it: no other is
/// nearer.
fn has_all_behind(hull: &Hull, point: &Vector3<f64>, nearest: &Vector3<f64>) -> bool {
    let way = point - nearest;
    let most = way.dot(nearest) + NEAREST * way.norm() * point.norm();
    hull.vertices.iter().all(|vertex| way.dot(vertex) <= most)
}
