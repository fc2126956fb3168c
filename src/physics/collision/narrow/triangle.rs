//! A triangle of a mesh against a convex shape.
//!
//! For what is tested the triangle is the front of a low pyramid behind it. Along the normal that the test finds, the mesh
//! itself need not be foremost: beside a triangle that has a neighbor in the same plane, nothing is. Of such a normal the
//! triangle's own is taken instead, and contact points are those over the triangle: where there are none, its neighbors
//! have them. So no inner edge is ever felt (which normals there are: [`Triangle::admits`]).
//!
//! While a fast body is on its way to a mesh, normals of the pyramid tell how far it can go ([`PairSearch::any_normal`]);
//! where it arrives it is looked at again.

use nalgebra::Vector3;

use super::clipping::keep_touching_spread;
use super::place::Place;
use super::{
    Cone, Convex, Cuboid, Cylinder, Edge, Frame, Overlap, PairSearch, Plane, Polyhedron, Scale, ShapePair, capsule,
    feature_sat, revolved_polyhedron,
};
use crate::physics::shape::Triangle;
use crate::physics::{ContactPoint, FeatureId, Geometry};

/// How far behind the triangle the pyramid reaches, as a share of its radius.
const PYRAMID: f64 = 1.0;

/// Likewise of one that is next to flat. Axes across its edges are told apart in `f32`.
const SHEET: f64 = 1e-4;

/// Distance from a side or a corner up to which a point is on it, as a share of the radius.
const SHARED: f64 = 1e-9;

/// A triangle as the front of a pyramid, about the middle of the triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pyramid<'t> {
    pub triangle: Triangle<'t>,
    /// The triangle, then the sides, by the corner where each begins.
    faces: [Plane; 4],
    apex: Vector3<f64>,
    /// Whether normals that the mesh does not have are given up for that of the triangle.
    is_strict: bool,
}

impl<'t> Pyramid<'t> {
    pub fn new(triangle: Triangle<'t>, search: &PairSearch) -> Self {
        let depth = if search.is_sheet { SHEET } else { PYRAMID };
        let apex = -triangle.normal * (depth * triangle.radius);
        let front = Plane { normal: triangle.normal, offset: 0.0 };
        let side = |from: usize| {
            let [from, to] = [from, (from + 1) % 3].map(|corner| triangle.corners[corner]);
            let normal = (apex - from).cross(&(to - from)).normalize();
            Plane { normal, offset: normal.dot(&from) }
        };
        Self { triangle, faces: [front, side(0), side(1), side(2)], apex, is_strict: !search.any_normal }
    }

    /// The unit normal out of it along the shortest way between its surface and a point, and how far the point is out, m.
    fn place(&self, point: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let heights = self.faces.map(|face| face.normal.dot(point) - face.offset);
        let mut nearest: Option<(Vector3<f64>, f64)> = None;
        for (face, &height) in heights.iter().enumerate().filter(|(_, height)| **height > 0.0) {
            let on_face = nearest_on_triangle(&self.face_corners(face), point);
            let away = point - on_face;
            let distance = away.norm();
            // Above a face, rounding of a short way would bend its normal.
            let is_over = distance <= height * (1.0 + 1e-12);
            let normal = if is_over || distance == 0.0 { self.faces[face].normal } else { away / distance };
            if nearest.is_none_or(|(_, known)| distance < known) {
                nearest = Some((normal, distance));
            }
        }
        nearest.unwrap_or_else(|| {
            let highest = super::first_max(heights.into_iter());
            (self.faces[highest].normal, heights[highest])
        })
    }

    fn face_corners(&self, face: usize) -> [Vector3<f64>; 3] {
        let corners = &self.triangle.corners;
        match face.checked_sub(1) {
            None => *corners,
            Some(from) => [corners[(from + 1) % 3], corners[from], self.apex],
        }
    }
}

/// The point of a triangle nearest to a point (Ericson 2005, 5.1.5).
pub(crate) fn nearest_on_triangle(&[a, b, c]: &[Vector3<f64>; 3], point: &Vector3<f64>) -> Vector3<f64> {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|side| side.dot(&(point - a)));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let [d3, d4] = [ab, ac].map(|side| side.dot(&(point - b)));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let [d5, d6] = [ab, ac].map(|side| side.dot(&(point - c)));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

/// Tests a triangle and a shape of that bounding radius, placed in the triangle's axes about its middle, and adds the points
/// where they touch in these axes. The normal points out of the triangle.
pub(crate) fn touch(
    triangle: Triangle,
    shape: &Geometry,
    radius: f64,
    shape_in_triangle: &Frame,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let height = triangle.normal.dot(&shape_in_triangle.center);
    if height <= 0.0 {
        // From behind. Not before its middle has come to the front.
        search.apart = -height;
        return None;
    }
    search.apart = 0.0;
    let scale = &Scale::new(triangle.radius, radius, gap).exact(search.is_exact).keeping_faces(search.keeps_faces);
    let below = -shape_in_triangle.rotation.tr_mul(&triangle.normal);
    let reach = match shape {
        Geometry::Cuboid { half } => below.abs().dot(half),
        Geometry::Hull(hull) => hull.reach(&below),
        _ => height,
    };
    if scale.separates(reach - height) {
        // Most of a mesh that is near something is.
        search.apart = height - reach;
        return None;
    }
    let pyramid = &Pyramid::new(triangle, search);
    macro_rules! tested {
        ($touch:path, $a:expr, $b:expr, $b_in_a:expr) => {
            $touch(&ShapePair { a: $a, b: $b, b_in_a: $b_in_a, scale }, search)?
        };
    }
    let overlap = match shape {
        Geometry::Sphere { radius } => return touch_ball(pyramid, *radius, shape_in_triangle, scale, search, points),
        Geometry::Capsule { radius, half, .. } => {
            return touch_capsule(pyramid, [*radius, *half], shape_in_triangle, scale, search, points);
        }
        Geometry::Cuboid { half } => {
            tested!(feature_sat::touch, pyramid, &Cuboid { half: *half }, shape_in_triangle)
        }
        Geometry::Hull(hull) => tested!(feature_sat::touch, pyramid, &**hull, shape_in_triangle),
        Geometry::Cone { .. } | Geometry::Cylinder { .. } => {
            let triangle_in_shape = &shape_in_triangle.inverse();
            let Overlap { normal, depth } = match shape {
                Geometry::Cone { radius, height, .. } => {
                    let cone = &Cone::new(*radius, *height);
                    tested!(revolved_polyhedron::touch, cone, pyramid, triangle_in_shape)
                }
                Geometry::Cylinder { radius, half, .. } => {
                    let cylinder = &Cylinder { radius: *radius, half: *half };
                    tested!(revolved_polyhedron::touch, cylinder, pyramid, triangle_in_shape)
                }
                _ => unreachable!("matched"),
            };
            search.clip.place(shape_in_triangle);
            Overlap { normal: -(shape_in_triangle.rotation * normal), depth }
        }
        Geometry::HalfSpace | Geometry::Parts(_) => return None,
    };
    keep_touching_spread(&mut search.clip.found, &overlap.normal, scale.size, points);
    Some(overlap)
}

fn touch_ball(
    pyramid: &Pyramid,
    radius: f64,
    ball: &Frame,
    scale: &Scale,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let (normal, distance) = pyramid.place(&ball.center);
    let depth = radius - distance;
    if scale.separates(depth) {
        search.apart = -depth;
        return None;
    }
    let touched = ball.center - normal * distance;
    let is_its_own = || pyramid.triangle.admits(&normal) && has_it(&pyramid.triangle, &touched, &normal);
    if pyramid.is_strict && !is_its_own() {
        return None;
    }
    let depth = scale.rounded(depth);
    let point = ball.center - normal * (radius - depth / 2.0);
    points.push(ContactPoint { point, depth, feature: FeatureId::default() });
    Some(Overlap { normal, depth })
}

/// Whether a point of the triangle is its own, and not a neighbor's which shares it.
fn has_it(triangle: &Triangle, point: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    let near = SHARED * triangle.radius;
    let corners = &triangle.corners;
    if let Some(corner) = (0..3).find(|&corner| (corners[corner] - point).norm() <= near) {
        return triangle.owns(corner, false, normal);
    }
    let is_on = |from: usize| {
        let side = corners[(from + 1) % 3] - corners[from];
        side.cross(&(point - corners[from])).norm() <= near * side.norm()
    };
    (0..3).find(|&from| is_on(from)).is_none_or(|from| triangle.owns(from, true, normal))
}

fn touch_capsule(
    pyramid: &Pyramid,
    [radius, half]: [f64; 2],
    capsule: &Frame,
    scale: &Scale,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let first = points.len();
    let place = |point: &Vector3<f64>| pyramid.place(point);
    let size = pyramid.triangle.radius;
    let found = capsule::touch_placed(place, size, [radius, half], capsule, scale, &mut search.apart, points)?;
    if !pyramid.is_strict || pyramid.triangle.admits(&found.normal) {
        return Some(found);
    }
    // What of its segment is over the triangle.
    points.truncate(first);
    search.apart = 0.0;
    let (normal, along) = (pyramid.triangle.normal, capsule.rotation.column(1).into_owned());
    let (mut low, mut high) = (-half, half);
    let corners = &pyramid.triangle.corners;
    for from in 0..3 {
        let outward = (corners[(from + 1) % 3] - corners[from]).cross(&normal).normalize();
        let (height, rise) = (outward.dot(&(capsule.center - corners[from])), outward.dot(&along));
        if rise.abs() <= f64::EPSILON {
            if height > 0.0 {
                return None;
            }
        } else if rise > 0.0 {
            high = high.min(-height / rise);
        } else {
            low = low.max(-height / rise);
        }
    }
    if low > high {
        return None;
    }
    let mut deepest = f64::NEG_INFINITY;
    for (end, place) in [low, high].into_iter().enumerate() {
        let at = capsule.center + along * place;
        let depth = scale.rounded(radius - normal.dot(&at));
        if !scale.separates(depth) && (end == 0 || high > low) {
            let feature = FeatureId::of_vertex(true, end as u32);
            points.push(ContactPoint { point: at - normal * (radius - depth / 2.0), depth, feature });
            deepest = deepest.max(depth);
        }
    }
    (points.len() > first).then_some(Overlap { normal, depth: deepest })
}

impl Polyhedron for Pyramid<'_> {
    fn face_count(&self) -> usize {
        4
    }

    fn face(&self, index: usize) -> Plane {
        self.faces[index]
    }

    fn face_toward(&self, direction: &Vector3<f64>) -> usize {
        super::first_max(self.faces.iter().map(|face| face.normal.dot(direction)))
    }

    fn corners(&self, face: usize, corners: &mut Vec<Vector3<f64>>) {
        corners.clear();
        corners.extend(self.face_corners(face));
    }

    fn edge_count(&self) -> usize {
        6
    }

    fn edge(&self, index: usize) -> Edge {
        let corner = |at: usize| self.triangle.corners[at % 3];
        let (start, end, faces) = if index < 3 {
            (corner(index), corner(index + 1), [0, index + 1])
        } else {
            let at = index - 3;
            (corner(at), self.apex, [at + 1, (at + 2) % 3 + 1])
        };
        let along = end - start;
        let length = along.norm();
        let normals = faces.map(|face| self.faces[face].normal);
        Edge { index: index as u32, start, direction: along / length, length, normals }
    }

    fn vertex_count(&self) -> usize {
        4
    }

    fn vertex(&self, index: usize) -> Vector3<f64> {
        if index < 3 { self.triangle.corners[index] } else { self.apex }
    }

    fn face_instead(&self, normal: &Vector3<f64>) -> Option<usize> {
        (self.is_strict && !self.triangle.admits(normal)).then_some(0)
    }

    fn is_of_mesh(&self) -> bool {
        self.is_strict
    }
}

impl Convex for Pyramid<'_> {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let corners = self.triangle.corners.iter().map(|corner| corner.dot(direction));
        corners.fold(self.apex.dot(direction), f64::max)
    }

    /// Its origin is on its front.
    fn inner_radius(&self) -> f64 {
        0.0
    }
}

/// The unit normal out of a mesh's triangle toward a point in the mesh's axes, and how far it is away, m.
pub(crate) fn place(triangle: &Triangle, point: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let from_middle = point - triangle.middle;
    let nearest = nearest_on_triangle(&triangle.corners, &from_middle);
    let away = Place::outside(&from_middle, &nearest, triangle.radius);
    away.map_or((triangle.normal, 0.0), |place| (place.normal, place.height))
}
