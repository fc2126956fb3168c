//! QuickHull (Barber, Dobkin and Huhdanpaa 1996) with the 2009 engine's vertex reduction in it:
//! from points to the triangles of their convex hull.
//!
//! Each facet holds the points in front of it. The farthest of all is taken next, so that the
//! first vertices matter most; one that the vector set finds within ε of a vertex is dropped, and
//! there are never more than [`MAX_VERTICES`].
//!
//! A point is compared with a plane twice: in floating point, to find the farthest, and on a
//! lattice of 2⁻⁴⁰ of the extent in whole numbers, to decide which facets a new vertex sees. The
//! latter is exact, so that the hull of the lattice points is closed and convex whatever the
//! points: many on a plane, many on a line, many alike. Facets that rounding or noise bends are
//! merged afterwards, see [`crate::physics::shape::merge_facets`].

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::hull::VERTEX_EPSILON;
use crate::physics::VectorSet;

/// Most vertices of a hull: at most 252 faces.
pub(super) const MAX_VERTICES: usize = 128;

/// What is thinner than this share of half its largest extent is flat.
const THINNEST: f64 = 1e-6;

/// Most that the reduction may move a surface by, as a share of how thick the points lie.
const REDUCTION_OF_THICKNESS: f64 = 0.1;

/// Points this share of the reduction in front of a facet lie in it.
const FLATNESS_OF_REDUCTION: f64 = 0.1;

/// Heights count as equal within this share of the extent.
const ROUNDING: f64 = 1e-9;

/// Lattice points along the unit.
const LATTICE: f64 = (1_u64 << 40) as f64;

/// What points that have no volume lie on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Degenerate {
    Line,
    Plane,
}

/// A triangulated hull.
pub(super) struct Triangulation {
    /// Indices of points, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// What bends less is flat.
    pub flatness: f64,
}

/// The convex hull of points in the cube −1..1, which fill more than half of it along some axis.
pub(super) fn triangulate(points: &[Vector3<f64>]) -> Result<Triangulation, Degenerate> {
    let mut hull = expand(points, (0..points.len() as u32).collect())?;
    loop {
        // Noise may have made the start of a point within a face.
        let corners = hull.without_flat_vertices(points);
        match corners.map(|corners| expand(points, corners)) {
            Some(Ok(smaller)) => hull = smaller,
            None | Some(Err(_)) => return Ok(hull),
        }
    }
}

/// The hull of some of the points.
fn expand(points: &[Vector3<f64>], candidates: Vec<u32>) -> Result<Triangulation, Degenerate> {
    let simplex = Simplex::of(points, &candidates)?;
    let mut builder = Builder::new(points, candidates, &simplex);
    while builder.triangle_count / 2 + 2 < MAX_VERTICES {
        let Some(facet) = builder.farthest_facet() else { break };
        let point = builder.farthest_point(facet);
        if builder.vertices.insert(points[point as usize]) {
            builder.add_vertex(point);
        } else {
            builder.drop_near_vertices(facet);
        }
    }
    let triangles = builder.facets.iter().filter(|facet| facet.is_alive).map(|facet| facet.corners).collect();
    Ok(Triangulation { triangles, flatness: builder.flatness })
}

impl Triangulation {
    /// The vertices but for those in the midst of flat surroundings; of two neighbors only the first
    /// is left out. None if there are none to leave out.
    fn without_flat_vertices(&self, points: &[Vector3<f64>]) -> Option<Vec<u32>> {
        let mut stars: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for &triangle in &self.triangles {
            for corner in triangle {
                stars.entry(corner).or_default().push(triangle);
            }
        }
        let mut flat = BTreeSet::new();
        for (&vertex, star) in &stars {
            if spread(points, star) <= self.flatness && !star.iter().flatten().any(|corner| flat.contains(corner)) {
                flat.insert(vertex);
            }
        }
        let corners = stars.into_keys().filter(|vertex| !flat.contains(vertex));
        (!flat.is_empty()).then(|| corners.collect())
    }
}

/// How far the corners of triangles reach along the mean of their normals.
pub(super) fn spread(points: &[Vector3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        (b - a).cross(&(c - a))
    };
    let normal = triangles.iter().map(area).sum::<Vector3<f64>>().normalize();
    let heights = triangles.iter().flatten().map(|&corner| points[corner as usize].dot(&normal));
    let [low, high] =
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)]);
    high - low
}

/// Four points that span a volume.
struct Simplex {
    /// Counter-clockwise the first three seen from the far side of the fourth.
    corners: [u32; 4],
    /// Half the largest extent of the points.
    half_extent: f64,
    /// Height of the fourth above the plane of the others.
    thickness: f64,
}

impl Simplex {
    /// The ends of the largest extent, the farthest point from the line through them, and the
    /// farthest from the plane of these. Where several are as far, a vertex of the hull.
    fn of(points: &[Vector3<f64>], candidates: &[u32]) -> Result<Self, Degenerate> {
        let at = |index: u32| points[index as usize];
        let extents = [0, 1, 2].map(|axis| ends(points, candidates, axis));
        let (extent, [a, b]) = extents.into_iter().max_by(|p, q| p.0.total_cmp(&q.0)).unwrap_or_default();
        let half_extent = extent / 2.0;
        let along = (at(b) - at(a)).normalize();
        let farthest = |distance: &dyn Fn(&Vector3<f64>) -> f64, second: &dyn Fn(&Vector3<f64>) -> f64| {
            let greatest = candidates.iter().map(|&index| distance(&at(index))).fold(0.0, f64::max);
            let as_far = candidates.iter().filter(|&&index| distance(&at(index)) >= greatest - ROUNDING);
            (greatest, first_greatest(as_far.map(|&index| (index, second(&at(index))))))
        };
        let from_line = |point: &Vector3<f64>| (point - at(a)).cross(&along).norm();
        let (distance, c) = farthest(&from_line, &|point| (point - at(a)).norm_squared());
        if distance <= THINNEST * half_extent {
            return Err(Degenerate::Line);
        }
        let normal = (at(b) - at(a)).cross(&(at(c) - at(a))).normalize();
        let middle = (at(a) + at(b) + at(c)) / 3.0;
        let height = |point: &Vector3<f64>| (point - at(a)).dot(&normal);
        let (thickness, d) = farthest(&|point| height(point).abs(), &|point| (point - middle).norm_squared());
        if thickness <= THINNEST * half_extent {
            return Err(Degenerate::Plane);
        }
        let corners = if height(&at(d)) < 0.0 { [a, b, c, d] } else { [a, c, b, d] };
        Ok(Self { corners, half_extent, thickness })
    }
}

/// Extent along an axis and the points at its ends. Of those as far, the outermost on the next
/// axes: a vertex of the hull.
fn ends(points: &[Vector3<f64>], candidates: &[u32], axis: usize) -> (f64, [u32; 2]) {
    let turned = |index: u32| {
        let point = points[index as usize];
        [point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]]
    };
    let first = (candidates[0], candidates[0]);
    let (low, high) = candidates.iter().fold(first, |(low, high), &index| {
        (if turned(index) < turned(low) { index } else { low }, if turned(index) > turned(high) { index } else { high })
    });
    (points[high as usize][axis] - points[low as usize][axis], [low, high])
}

/// The index that has the greatest value, the first of equals.
fn first_greatest(values: impl Iterator<Item = (u32, f64)>) -> u32 {
    values.fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best }).0
}

/// A triangle of the hull so far.
struct Facet {
    corners: [u32; 3],
    /// Unit, outward.
    normal: Vector3<f64>,
    /// Of its plane along the normal.
    offset: f64,
    /// Points in front of it, each held by one facet only.
    outside: Vec<u32>,
    /// Height of the farthest of them.
    reach: f64,
    /// Not yet replaced.
    is_alive: bool,
}

impl Facet {
    fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }

    fn hold(&mut self, point: u32, height: f64) {
        self.outside.push(point);
        self.reach = self.reach.max(height);
    }
}

struct Builder<'a> {
    points: &'a [Vector3<f64>],
    facets: Vec<Facet>,
    /// The facet on the left of each directed edge.
    sides: BTreeMap<(u32, u32), usize>,
    triangle_count: usize,
    /// The 2009 reduction: no two vertices are near each other.
    vertices: VectorSet,
    flatness: f64,
}

impl<'a> Builder<'a> {
    fn new(points: &'a [Vector3<f64>], candidates: Vec<u32>, simplex: &Simplex) -> Self {
        let reduction = f64::min(VERTEX_EPSILON * simplex.half_extent, REDUCTION_OF_THICKNESS * simplex.thickness);
        let mut vertices = VectorSet::default();
        vertices.reset(reduction, false, 1.0);
        for corner in simplex.corners {
            vertices.insert(points[corner as usize]);
        }
        let mut builder = Self {
            points,
            facets: Vec::new(),
            sides: BTreeMap::new(),
            triangle_count: 0,
            vertices,
            flatness: FLATNESS_OF_REDUCTION * reduction,
        };
        let [a, b, c, d] = simplex.corners;
        builder.add_facets(&[[a, b, c], [a, d, b], [b, d, c], [c, d, a]], candidates);
        builder
    }

    /// The facet that a point lies farthest in front of.
    fn farthest_facet(&self) -> Option<usize> {
        let held = self.facets.iter().enumerate().filter(|(_, facet)| !facet.outside.is_empty());
        held.max_by(|(_, a), (_, b)| a.reach.total_cmp(&b.reach)).map(|(index, _)| index)
    }

    /// The farthest point in front of a facet. Of those as far, up to noise, the one farthest from
    /// its middle: a vertex of the hull, not a point within a face.
    fn farthest_point(&self, facet: usize) -> u32 {
        let facet = &self.facets[facet];
        let middle = facet.corners.map(|corner| self.points[corner as usize]).iter().sum::<Vector3<f64>>() / 3.0;
        let at = |index: u32| self.points[index as usize];
        let level = facet.reach - self.flatness / 2.0;
        let candidates = facet.outside.iter().copied().filter(|&index| facet.height(&at(index)) >= level);
        first_greatest(candidates.map(|index| (index, (at(index) - middle).norm_squared())))
    }

    /// Replaces the facets that a point sees by those from their horizon to the point.
    fn add_vertex(&mut self, point: u32) {
        let sees = |facet: &Facet| facet.is_alive && self.is_in_front(point, facet.corners);
        let visible: Vec<usize> = (0..self.facets.len()).filter(|&index| sees(&self.facets[index])).collect();
        let mut horizon = Vec::new();
        for &index in &visible {
            for [from, to] in edges(self.facets[index].corners) {
                if !visible.contains(&self.sides[&(to, from)]) {
                    horizon.push([from, to, point]);
                }
            }
        }
        let mut orphans = Vec::new();
        for &index in &visible {
            let facet = &mut self.facets[index];
            facet.is_alive = false;
            orphans.append(&mut facet.outside);
            for [from, to] in edges(facet.corners) {
                self.sides.remove(&(from, to));
            }
        }
        self.triangle_count -= visible.len();
        self.add_facets(&horizon, orphans);
    }

    /// Adds facets and gives each point to the one that it is farthest in front of, if any.
    fn add_facets(&mut self, triangles: &[[u32; 3]], points: Vec<u32>) {
        let first = self.facets.len();
        self.triangle_count += triangles.len();
        for &corners in triangles {
            for [from, to] in edges(corners) {
                self.sides.insert((from, to), self.facets.len());
            }
            let [a, b, c] = corners.map(|corner| self.lattice(corner));
            // In whole numbers: the normal of the narrowest triangle is as true as any.
            let normal = (b - a).cross(&(c - a)).map(|component| component as f64).normalize();
            let offset = normal.dot(&a.map(|component| component as f64 / LATTICE));
            self.facets.push(Facet { corners, normal, offset, outside: Vec::new(), reach: 0.0, is_alive: true });
        }
        let facets = &mut self.facets[first..];
        for index in points {
            let point = &self.points[index as usize];
            let heights = facets.iter().map(|facet| facet.height(point)).enumerate();
            let flat = (0, self.flatness);
            let (facet, height) = heights.fold(flat, |best, next| if next.1 > best.1 { next } else { best });
            if height > self.flatness {
                facets[facet].hold(index, height);
            }
        }
    }

    /// Drops the points in front of a facet that are near a vertex.
    fn drop_near_vertices(&mut self, facet: usize) {
        let facet = &mut self.facets[facet];
        facet.reach = 0.0;
        for point in std::mem::take(&mut facet.outside) {
            let place = &self.points[point as usize];
            if !self.vertices.has_near(place) {
                let height = facet.height(place);
                facet.hold(point, height);
            }
        }
    }

    fn is_in_front(&self, point: u32, [a, b, c]: [u32; 3]) -> bool {
        let origin = self.lattice(a);
        let [b, c, point] = [b, c, point].map(|index| self.lattice(index) - origin);
        // 41 bits each and three products: within the 127 there are.
        b.cross(&c).dot(&point) > 0
    }

    fn lattice(&self, point: u32) -> Vector3<i128> {
        self.points[point as usize].map(|component| (component * LATTICE).round() as i128)
    }
}

/// Directed, counter-clockwise.
pub(super) fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
