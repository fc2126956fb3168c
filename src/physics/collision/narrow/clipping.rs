//! Contact points by face clipping (Sutherland–Hodgman; Ericson 2005, 8.3; Catto, GDC 2007).
//!
//! The face that gave the normal is the *reference*; of the faces of the other shape that hold its foremost vertex, the one most
//! against it is the *incident* one. The incident face is cut by the sides of the reference face, and what is
//! left below the reference plane, or above it by no more than the gap asked for, are the contact
//! points, each with its own depth, negative above, half-way between the two surfaces. Of more than
//! [`MAX_POINTS`] the deepest and those that span the most area are kept ([`keep_spread`]), touching
//! ones before others ([`keep_touching_spread`]).

use nalgebra::Vector3;

use super::{Convex, Frame, Plane, Polyhedron, Rim, Scale, ShapePair, first_max};
use crate::physics::collision::constants::{NEARLY_DEEPEST, NEARLY_WIDEST, SIDE_MARGIN, SOUND_MARGIN, SOUND_SHARE};
use crate::physics::{ContactPoint, FeatureId, Refill};

/// Most points of a clipped manifold.
pub(crate) const MAX_POINTS: usize = 4;

/// Buffers of the clipping, kept from pair to pair.
#[derive(Clone, Default)]
pub(crate) struct ClipBuffers {
    /// Corners of the reference face, counter-clockwise seen from outside.
    pub reference: Vec<Vector3<f64>>,
    /// Corners of the incident face; two are a segment, one a point.
    pub incident: Vec<Vector3<f64>>,
    polygon: Vec<Corner>,
    clipped: Vec<Corner>,
    /// What was found, in the axes of the reference shape.
    pub found: Vec<ContactPoint>,
}

/// A corner of the polygon being clipped, named by the lines that meet in it: sides of the
/// incident face, or sides of the reference face.
#[derive(Clone, Copy)]
struct Corner {
    point: Vector3<f64>,
    before: u16,
    after: u16,
}

/// Names the side of a reference face; sides of the incident face have names below this.
pub(crate) const REFERENCE_SIDE: u16 = 0x8000;

/// Which faces are clipped, and how deep they overlap.
pub(crate) struct Clip<'t> {
    reference_is_b: bool,
    reference_face: u32,
    incident_face: u32,
    /// Unit, out of the reference face.
    normal: Vector3<f64>,
    /// Distance of the reference plane from the origin along the normal.
    level: f64,
    /// Of the overlap.
    depth: f64,
    /// Tells which corners above the reference plane count as on it, or are within the gap.
    scale: &'t Scale,
    /// The rim of the disc that the reference face stands for as a polygon, where gaps are told down to rounding.
    rim: Option<Rim>,
}

impl<'t> Clip<'t> {
    /// To a triangle of a mesh, for all that is within the gap.
    pub fn to_triangle(triangle: u32, face: u32, normal: &Vector3<f64>, level: f64, scale: &'t Scale) -> Self {
        let (reference_face, incident_face, normal, depth) = (triangle, face, *normal, -scale.gap);
        Self { reference_is_b: false, reference_face, incident_face, normal, level, depth, scale, rim: None }
    }

    /// Cuts the incident face by the sides of the reference face, all in the axes of the
    /// reference shape, and collects what is below the reference plane or within the gap above.
    /// Whether anything was that touches, or if the shapes are apart, anything at all.
    pub fn clip(&self, buffers: &mut ClipBuffers) -> bool {
        let ClipBuffers { reference, incident, polygon, .. } = buffers;
        fill(polygon, incident);
        let reference = std::mem::take(reference);
        for (side, from) in reference.iter().enumerate() {
            let to = &reference[if side + 1 < reference.len() { side + 1 } else { 0 }];
            // Not normalised: a side of no length cuts nothing.
            let outward = (to - from).cross(&self.normal);
            let limit = outward.dot(from) + SIDE_MARGIN * self.scale.size * outward.norm();
            buffers.cut(side, |point| outward.dot(point) - limit);
        }
        buffers.reference = reference;
        if let Some(rim) = &self.rim {
            buffers.widen(rim);
        }
        self.collect(buffers)
    }

    /// Likewise, where the reference face is a rectangle across `axis`, of those half extents.
    pub fn clip_to_rectangle(&self, axis: usize, half: &Vector3<f64>, buffers: &mut ClipBuffers) -> bool {
        let ClipBuffers { incident, polygon, .. } = buffers;
        fill(polygon, incident);
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let [far_u, far_v] = [u, v].map(|side| half[side] + SIDE_MARGIN * self.scale.size);
        buffers.cut(0, |point| point[v] - far_v);
        buffers.cut(1, |point| -point[u] - far_u);
        buffers.cut(2, |point| -point[v] - far_v);
        buffers.cut(3, |point| point[u] - far_u);
        self.collect(buffers)
    }

    fn collect(&self, buffers: &mut ClipBuffers) -> bool {
        let ClipBuffers { incident, polygon, found, .. } = buffers;
        found.clear();
        let name = |corner: &Corner| {
            let Self { reference_is_b, reference_face, incident_face, .. } = *self;
            FeatureId::of_clipping(reference_is_b, reference_face, incident_face, corner.before, corner.after)
        };
        for corner in &*polygon {
            let depth = self.level - corner.point.dot(&self.normal);
            if !self.scale.separates(depth) {
                let depth = self.scale.rounded(depth);
                let point = corner.point + self.normal * (depth / 2.0);
                found.push(ContactPoint { point, depth, feature: name(corner) });
            }
        }
        let is_any = if self.depth < 0.0 {
            !found.is_empty()
        } else {
            found.iter().any(|point| self.scale.touches(point.depth))
        };
        if !is_any {
            // The sides cut off all that is below the plane, as may be where the reference was
            // preferred to a rival of less depth: the deepest corner stands for the face.
            let deepest = first_max(incident.iter().map(|corner| -corner.dot(&self.normal)));
            let point = incident[deepest] + self.normal * (self.depth / 2.0);
            let feature = name(&incident_corner(point, deepest, incident.len()));
            found.retain(|found| found.feature != feature);
            found.push(ContactPoint { point, depth: self.depth, feature });
        }
        is_any
    }
}

/// A shape of which faces can be clipped.
pub(crate) trait Faced: Convex {
    /// The plane of a face, and its corners, counter-clockwise seen from outside.
    fn reference(&self, face: u32, corners: &mut Vec<Vector3<f64>>) -> Plane;
    /// What faces a direction most, by number, and its corners: a face, or the two ends of a line.
    fn incident(&self, direction: &Vector3<f64>, corners: &mut Vec<Vector3<f64>>) -> u32;
    /// The rim of a face whose corners are some of it.
    fn rim(&self, _face: u32) -> Option<Rim> {
        None
    }
}

impl<P: Polyhedron> Faced for P {
    fn reference(&self, face: u32, corners: &mut Vec<Vector3<f64>>) -> Plane {
        self.corners(face as usize, corners);
        self.face(face as usize)
    }

    fn incident(&self, direction: &Vector3<f64>, corners: &mut Vec<Vector3<f64>>) -> u32 {
        let face = self.face_toward(direction);
        self.corners(face, corners);
        face as u32
    }
}

impl<'t, A: Faced, B: Faced> ShapePair<'t, A, B> {
    /// Clips what of the other shape is most against a face of A, or of B, and leaves what touches in the buffers, in
    /// A's axes. False if nothing is over that face.
    pub fn clip_to_face(&self, of_b: bool, face: u32, depth: f64, buffers: &mut ClipBuffers) -> bool {
        if !of_b {
            let plane = self.a.reference(face, &mut buffers.reference);
            return self.clip_of(of_b, face, plane, depth, buffers).clip(buffers);
        }
        let plane = self.b.reference(face, &mut buffers.reference);
        let a_in_b = self.b_in_a.inverse();
        let is_any = self.swapped(&a_in_b).clip_of(of_b, face, plane, depth, buffers).clip(buffers);
        buffers.place(self.b_in_a);
        is_any
    }

    /// How to clip to a face of A, in a pair that may have been swapped, what of B is most against it, whose corners
    /// are left in the buffers.
    pub fn clip_of(&self, of_b: bool, face: u32, plane: Plane, depth: f64, buffers: &mut ClipBuffers) -> Clip<'t> {
        let Plane { normal, offset: level } = plane;
        let incident_face = self.b.incident(&-self.b_in_a.enter(&normal), &mut buffers.incident);
        for corner in &mut buffers.incident {
            *corner = self.b_in_a.place(corner);
        }
        let scale = self.scale;
        let rim = self.a.rim(face).filter(|_| scale.is_exact());
        Clip { reference_is_b: of_b, reference_face: face, incident_face, normal, level, depth, scale, rim }
    }
}

impl ClipBuffers {
    /// Takes what was found to the axes that a frame is given in.
    pub fn place(&mut self, frame: &Frame) {
        self.found.iter_mut().for_each(|found| found.point = frame.place(&found.point));
    }

    /// Whether the deepest of the points found is about as deep as the overlap. If not, or if the
    /// reference face was left with nothing, it was preferred to what truly touches.
    pub fn stand_for(&self, depth: f64, size: f64) -> bool {
        let deepest = self.found.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
        let share = if depth < 0.0 { depth / SOUND_SHARE } else { SOUND_SHARE * depth };
        deepest >= share - SOUND_MARGIN * size
    }

    /// Keeps what of the polygon lies at or below `height` zero. A segment is not closed.
    #[inline]
    fn cut(&mut self, side: usize, height: impl Fn(&Vector3<f64>) -> f64) {
        let Self { polygon, clipped, .. } = self;
        if polygon.iter().all(|corner| height(&corner.point) <= 0.0) {
            return;
        }
        let name = side as u16 | REFERENCE_SIDE;
        let closed = polygon.len() > 2;
        clipped.clear();
        for (index, corner) in polygon.iter().enumerate() {
            let above = height(&corner.point);
            if above <= 0.0 {
                clipped.push(*corner);
            }
            let Some(next) = polygon.get(index + 1).or(if closed { polygon.first() } else { None }) else { continue };
            let next_above = height(&next.point);
            if (above <= 0.0) != (next_above <= 0.0) {
                let share = above / (above - next_above);
                let point = corner.point + (next.point - corner.point) * share;
                let (before, after) = if above <= 0.0 { (corner.after, name) } else { (name, corner.after) };
                clipped.push(Corner { point, before, after });
            }
        }
        std::mem::swap(polygon, clipped);
    }

    /// Moves the corners where the sides of a polygon that stands for a disc cut sides of the incident face on, to the rim or the
    /// end of their side: what lies between would be left out, and be deepest where the disc is tilted.
    fn widen(&mut self, rim: &Rim) {
        let Self { incident, polygon, .. } = self;
        for corner in &mut *polygon {
            let of_incident = |side: u16| (side & REFERENCE_SIDE == 0).then_some(usize::from(side));
            let outer = match [corner.before, corner.after].map(of_incident) {
                [Some(side), None] => incident[(side + 1) % incident.len()],
                [None, Some(side)] => incident[side],
                _ => continue,
            };
            let share = rim.share_within(&corner.point, &outer);
            corner.point = if share < 1.0 { corner.point + (outer - corner.point) * share } else { outer };
        }
        // Both sides that meet in a corner may end there.
        polygon.dedup_by(|one, other| one.point == other.point);
    }
}

/// The incident face as the polygon to clip.
fn fill(polygon: &mut Vec<Corner>, incident: &[Vector3<f64>]) {
    polygon.refill(incident.iter().enumerate().map(|(index, &point)| incident_corner(point, index, incident.len())));
}

fn incident_corner(point: Vector3<f64>, index: usize, corners: usize) -> Corner {
    let before = if index == 0 { corners - 1 } else { index - 1 };
    let side = |side: usize| side as u16 & !REFERENCE_SIDE;
    Corner { point, before: side(before), after: side(index) }
}

/// Moves at most [`MAX_POINTS`] of the points found to `points`, in the order they were found.
pub(crate) fn keep_spread(found: &[ContactPoint], normal: &Vector3<f64>, size: f64, points: &mut Vec<ContactPoint>) {
    if found.len() > MAX_POINTS {
        let kept = spread(found, normal, size);
        points.extend(found.iter().enumerate().filter(|(index, _)| kept.contains(index)).map(|(_, point)| point));
    } else {
        points.extend_from_slice(found);
    }
}

/// Likewise, but of more than [`MAX_POINTS`] those that touch, or are lowest if none does, go before those within the gap:
/// where there are enough of them the others are left out, else these fill up. What hovers higher by less than
/// [`NEARLY_DEEPEST`] counts among them. Where no point is above the other's surface the points are those of
/// [`keep_spread`].
pub(crate) fn keep_touching_spread(
    found: &mut Vec<ContactPoint>,
    normal: &Vector3<f64>,
    size: f64,
    points: &mut Vec<ContactPoint>,
) {
    let deepest = found.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
    let touches = |point: &ContactPoint| point.depth >= deepest.min(0.0) - NEARLY_DEEPEST * size;
    let touching = found.iter().filter(|point| touches(point)).count();
    if found.len() > MAX_POINTS && (1..MAX_POINTS).contains(&touching) {
        let first = (0..found.len()).filter(|&index| touches(&found[index]));
        let (mut kept, mut count) = ([usize::MAX; MAX_POINTS], 0);
        for index in first.chain(spread(found, normal, size)) {
            if count < MAX_POINTS && !kept.contains(&index) {
                kept[count] = index;
                count += 1;
            }
        }
        points.extend(found.iter().enumerate().filter(|(index, _)| kept.contains(index)).map(|(_, point)| point));
        return;
    }
    if touching >= MAX_POINTS {
        found.retain(touches);
    }
    keep_spread(found, normal, size, points);
}

/// The deepest, the farthest from it, the farthest from the line of those two, and the one that
/// adds most area to the triangle of these. Some may be the same.
fn spread(found: &[ContactPoint], normal: &Vector3<f64>, size: f64) -> [usize; MAX_POINTS] {
    let point = |index: usize| found[index].point;
    // Of points over one another, as corners of a thin body are that comes fast, the deepest.
    let widest = |value: &dyn Fn(&Vector3<f64>) -> f64| {
        let greatest = found.iter().map(|found| value(&found.point)).fold(f64::NEG_INFINITY, f64::max);
        let is_wide = |found: &ContactPoint| value(&found.point) >= greatest * NEARLY_WIDEST;
        let depths = found.iter().map(|found| if is_wide(found) { found.depth } else { f64::NEG_INFINITY });
        first_from(depths, |deepest| deepest - NEARLY_DEEPEST * size)
    };
    let deepest = first_from(found.iter().map(|found| found.depth), |greatest| greatest - NEARLY_DEEPEST * size);
    let farthest = widest(&|at| (at - point(deepest)).norm_squared());
    let across = normal.cross(&(point(farthest) - point(deepest)));
    let beside = widest(&|at| across.dot(&(at - point(deepest))).abs());
    let mut triangle = [deepest, farthest, beside].map(point);
    if across.dot(&(triangle[2] - triangle[0])) < 0.0 {
        triangle.swap(1, 2);
    }
    let fourth = widest(&|at| {
        let beyond = |side: usize| {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            (to - from).cross(normal).dot(&(at - from))
        };
        beyond(0).max(beyond(1)).max(beyond(2))
    });
    [deepest, farthest, beside, fourth]
}

/// Index of the first value that is at least `limit` of the greatest.
fn first_from(values: impl Iterator<Item = f64> + Clone, limit: impl Fn(f64) -> f64) -> usize {
    let limit = limit(values.clone().fold(f64::NEG_INFINITY, f64::max));
    values.into_iter().position(|value| value >= limit).unwrap_or(0)
}
