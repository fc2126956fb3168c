//! A cluster of a mesh, of triangles that look nearly the same way where the surface is smooth, against a polyhedron.
//!
//! Whatever touches a triangle there is pushed nearly along its normal, and that is taken: how deep a polyhedron is, is how far it
//! reaches below the triangle's plane, and the contact points are what of the face that looks at the triangle is over it. Those of
//! all triangles of the cluster are put together to one manifold, each with its own depth. Its normal is the mean of theirs, of
//! what touches most.
//!
//! A triangle is apart from the polyhedron by no less than by the height of its lowest corner over the plane of a face, by that of
//! the polyhedron over the triangle's plane, or by the way that it is beyond one of the triangle's sides.

use nalgebra::Vector3;

use super::clipping::{Clip, ClipBuffers, keep_touching_spread};
use super::{Frame, Overlap, Plane, Polyhedron, Scale};
use crate::physics::collision::constants::{SIDE_MARGIN, SPECULATIVE_MARGIN};
use crate::physics::shape::Triangles;
use crate::physics::{BoundingBox, ContactPoint, FeatureId, Refill};

/// How much farther away than the gap, as a share of the radius, triangles are looked at, so that it is known for how long
/// the polyhedron touches none.
const LOOK_BEYOND: f64 = 0.1;

/// Cosine of the angle between the normal of a face and the way down to the cluster from which on its plane tells what is
/// apart, and how many planes are asked.
const LOOKS: f64 = 0.2;
const MOST_PLANES: usize = 8;

/// Buffers of a test.
#[derive(Clone, Default)]
pub(crate) struct ClusterBuffers {
    /// What was found over all triangles, and the normal of each one's triangle.
    found: Vec<ContactPoint>,
    normals: Vec<Vector3<f64>>,
    kept: Vec<ContactPoint>,
    /// Triangles that the planes below do not tell to be apart, and of which nothing was found.
    beside: Vec<u32>,
    /// Of faces that look at the cluster, in the mesh's axes.
    planes: Vec<Plane>,
    /// Those of the polyhedron that look at triangles of the cluster; the first so many.
    faces: Vec<Facing>,
    face_count: usize,
}

/// A face that looks at triangles, in the mesh's axes.
#[derive(Clone, Default)]
struct Facing {
    face: usize,
    plane: Plane,
    corners: Vec<Vector3<f64>>,
    /// Planes through its sides, across it.
    sides: Vec<Plane>,
}

/// A cluster, and a polyhedron placed in the mesh's axes.
#[derive(Clone, Copy)]
struct Both<'t, B> {
    mesh: &'t Triangles,
    cluster: u32,
    polyhedron: &'t B,
    placed: &'t Frame,
    scale: &'t Scale,
}

/// Tests a cluster and a polyhedron of that bounding radius, placed in the mesh's axes where `reach` bounds it, and adds the points
/// where they touch in these axes. The normal points out of the cluster.
///
/// # Errors
/// They are apart by more than the gap: by how much at least, m.
pub(super) fn touch<B: Polyhedron>(
    (mesh, cluster): (&Triangles, u32),
    (polyhedron, radius): (&B, f64),
    (placed, bounds): (&Frame, BoundingBox),
    gap: f64,
    (buffers, clip): (&mut ClusterBuffers, &mut ClipBuffers),
    points: &mut Vec<ContactPoint>,
) -> Result<Overlap, f64> {
    let scale = &Scale::new(radius, radius, gap);
    let both = Both { mesh, cluster, polyhedron, placed, scale };
    let beyond = scale.gap + LOOK_BEYOND * radius;
    let bounds = bounds.grown(beyond);
    buffers.clear();
    // Nothing of the cluster is nearer, unless found to be.
    let apart = both.find_points(&bounds, beyond, buffers, clip);
    buffers.keep(scale, points).ok_or_else(|| both.least_distance(&buffers.beside, apart))
}

impl<B: Polyhedron> Both<'_, B> {
    /// Finds the points over all triangles that may be within the gap. How far others are at least, if that is less than the most
    /// there may be, m.
    fn find_points(
        &self,
        bounds: &BoundingBox,
        most: f64,
        buffers: &mut ClusterBuffers,
        clip: &mut ClipBuffers,
    ) -> f64 {
        let mut apart = most;
        let mut planes = std::mem::take(&mut buffers.planes);
        self.find_planes(&mut planes);
        let is_within = |other: &BoundingBox| {
            let (middle, half) = ((other.low + other.high) / 2.0, (other.high - other.low) / 2.0);
            let mut over =
                planes.iter().map(|Plane { normal, offset }| normal.dot(&middle) - normal.abs().dot(&half) - offset);
            match over.find(|over| *over > self.scale.gap) {
                Some(over) => {
                    apart = apart.min(over);
                    false
                }
                None => true,
            }
        };
        self.mesh.in_facet_where(self.cluster, bounds, is_within, |triangle| buffers.find_points(self, triangle, clip));
        buffers.planes = planes;
        apart
    }

    /// Planes of faces that look at the cluster, in the mesh's axes: most of it is above one of them.
    fn find_planes(&self, planes: &mut Vec<Plane>) {
        let below = -self.placed.enter(&self.mesh.normal(self.mesh.triangles_of(self.cluster)[0]));
        let faces = (0..self.polyhedron.face_count()).map(|face| self.polyhedron.face(face));
        let looking = faces.filter(|face| face.normal.dot(&below) > LOOKS).map(|face| self.place(face));
        planes.refill(looking.take(MOST_PLANES));
    }

    /// A plane of the polyhedron in the mesh's axes.
    fn place(&self, Plane { normal, offset }: Plane) -> Plane {
        let normal = self.placed.rotation * normal;
        Plane { normal, offset: offset + normal.dot(&self.placed.center) }
    }

    /// How far triangles are at least, m, if that is less than the most there may be. Within the gap no more need be known.
    fn least_distance(&self, triangles: &[u32], most: f64) -> f64 {
        let mut least = most;
        for &triangle in triangles {
            least = least.min(self.distance(triangle, least)).max(0.0);
            if !self.scale.separates(-least) {
                break;
            }
        }
        least
    }

    /// How high the middle of the polyhedron is over a triangle's plane, m. Seen from behind a triangle is not there, until the
    /// middle has come to the front.
    fn height(&self, index: u32) -> f64 {
        self.mesh.normal(index).dot(&(self.placed.center - self.mesh.corners_of(index)[0]))
    }

    /// How far a triangle is at least, m, or more than the most that matters.
    fn distance(&self, index: u32, most: f64) -> f64 {
        let (corners, normal) = (self.mesh.corners_of(index), self.mesh.normal(index));
        let along = |direction: Vector3<f64>, corner: &Vector3<f64>| {
            direction.dot(&(self.placed.center - corner)) - self.polyhedron.reach(&-self.placed.enter(&direction))
        };
        let height = self.height(index);
        let mut farthest = if height > 0.0 { along(normal, &corners[0]) } else { -height };
        for from in 0..3 {
            if farthest > most {
                break;
            }
            let outward = (corners[(from + 1) % 3] - corners[from]).cross(&normal).normalize();
            farthest = farthest.max(along(outward, &corners[from]));
        }
        farthest
    }
}

impl ClusterBuffers {
    fn clear(&mut self) {
        self.found.clear();
        self.normals.clear();
        self.beside.clear();
        self.face_count = 0;
    }

    /// The face that looks along a direction of the polyhedron's axes most, by its place in the list.
    fn facing<B: Polyhedron>(&mut self, both: &Both<B>, direction: &Vector3<f64>) -> usize {
        let face = both.polyhedron.face_toward(direction);
        if let Some(known) = self.faces[..self.face_count].iter().position(|known| known.face == face) {
            return known;
        }
        let next = self.face_count;
        self.face_count += 1;
        if self.faces.len() == next {
            self.faces.push(Facing::default());
        }
        let Facing { face: number, plane, corners, sides } = &mut self.faces[next];
        *number = face;
        both.polyhedron.corners(face, corners);
        corners.iter_mut().for_each(|corner| *corner = both.placed.place(corner));
        *plane = both.place(both.polyhedron.face(face));
        sides.refill((0..corners.len()).map(|from| {
            let to = corners[(from + 1) % corners.len()];
            let normal = (to - corners[from]).cross(&plane.normal).normalize();
            Plane { normal, offset: normal.dot(&corners[from]) }
        }));
        next
    }

    /// Adds the points of the polyhedron over a triangle.
    fn find_points<B: Polyhedron>(&mut self, both: &Both<B>, index: u32, clip: &mut ClipBuffers) {
        let Both { mesh, placed, scale, .. } = *both;
        let (corners, normal) = (mesh.corners_of(index), mesh.normal(index));
        if both.height(index) <= 0.0 {
            self.beside.push(index);
            return;
        }
        let facing = self.facing(both, &-placed.enter(&normal));
        let Facing { face, plane, corners: outline, sides } = &self.faces[facing];
        let heights = corners.map(|corner| plane.normal.dot(&corner) - plane.offset);
        if heights.iter().all(|&height| height > scale.gap) {
            self.beside.push(index);
            return;
        }
        // Seen along the normal instead of across the face, what is within the gap is elsewhere by less than that.
        let margin = scale.gap + SIDE_MARGIN * scale.size;
        let mut is_inside = true;
        for side in sides {
            let beyond = corners.map(|corner| side.normal.dot(&corner) - side.offset);
            if beyond.iter().all(|&beyond| beyond > margin) {
                self.beside.push(index);
                return;
            }
            is_inside &= beyond.iter().all(|&beyond| beyond <= 0.0);
        }
        if is_inside {
            // The deepest places are corners of the triangle. Of triangles that meet in a vertex, perhaps in another cluster, one
            // has it.
            let facing = -plane.normal.dot(&normal);
            for (corner, height) in (0..3).zip(heights).filter(|&(corner, _)| mesh.is_owner(index, corner)) {
                let depth = scale.rounded(-height / facing);
                if !scale.separates(depth) {
                    let feature = FeatureId::of_vertex(false, mesh.vertex_of(index, corner));
                    self.found.push(ContactPoint { point: corners[corner] - normal * (depth / 2.0), depth, feature });
                }
            }
        } else {
            clip.reference.clear();
            clip.reference.extend(corners);
            clip.incident.clone_from(outline);
            if Clip::to_triangle(index, *face as u32, &normal, normal.dot(&corners[0]), scale).clip(clip) {
                self.found.extend_from_slice(&clip.found);
            }
        }
        if self.found.len() == self.normals.len() {
            self.beside.push(index);
        }
        self.normals.resize(self.found.len(), normal);
    }

    /// Adds those of the points found that a manifold takes.
    fn keep(&mut self, scale: &Scale, points: &mut Vec<ContactPoint>) -> Option<Overlap> {
        let Self { found, normals, kept, .. } = self;
        let (mut deepest, mut along) = (f64::NEG_INFINITY, None);
        for (point, normal) in found.iter().zip(&*normals) {
            if point.depth > deepest {
                (deepest, along) = (point.depth, Some(*normal));
            }
        }
        let along = along?;
        let first = points.len();
        kept.clone_from(found);
        keep_touching_spread(kept, &along, scale.size, points);
        // What is higher by the margin of contacts ahead counts no more.
        let share = |depth: f64| (1.0 - (deepest - depth) / (SPECULATIVE_MARGIN * scale.size)).max(0.0);
        let sum = points[first..].iter().fold(along, |sum, point| {
            let of = found.iter().position(|found| found == point);
            of.map_or(sum, |of| sum + normals[of] * share(point.depth))
        });
        Some(Overlap { normal: sum.normalize(), depth: deepest })
    }
}
