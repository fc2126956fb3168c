//! Narrow phase, first half: the separating axis test (Gottschalk 1996; Ericson 2005, 5.2.1)
//! over the reduced axis set of the 2009 engine.
//!
//! Two convex shapes are apart exactly if they are apart along one of the candidate axes: the
//! face normals of A, those of B, and the cross products of their edges. A ball has no faces; it
//! adds the axis to the nearest point of the other shape, which makes its test exact. A
//! half-space has one axis, its normal.
//!
//! Axes are made one at a time, go through the [`VectorSet`], and are tested only if they are
//! new to it; the first along which the shapes are apart ends the test. Leaving out axes never
//! loses a contact, but may report one where the axis left out would have separated, or a depth
//! that is not the least.
//!
//! For clipped manifolds two refinements can be asked for, see [`AxisSearch`].
//!
//! Depth here is how far B must move along the normal to be clear of A. Depth 0, touching, is a
//! contact, and so is a gap that rounding could have made of it.

use nalgebra::Vector3;

use super::CONTACT_TOLERANCE;
use super::placed::{EdgeArc, Placed};
use super::vector_set::VectorSet;
use crate::physics::collider::Geometry;

/// With [`AxisSearch::steady_faces`], an edge–edge axis (or a face of B) is taken only where its
/// depth is below this share of the depth along the best face (of A) …
const RIVAL_SHARE: f64 = 0.95;

/// … and below it by this share of the smaller bounding radius as well, for depths near zero.
const RIVAL_MARGIN: f64 = 1e-4;

/// Centre to nearest point closer than this share of the radius: the centre lies in the other
/// shape, and the direction would be noise.
const ON_SURFACE: f64 = 1e-12;

/// How axes are chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisSearch {
    /// L1 distance within which two axes count as one.
    pub epsilon: f64,
    /// Whether n and −n count as one.
    pub merge_opposites: bool,
    /// Prefers faces to edges and A's faces to B's where depths are nearly equal, so that
    /// clipped manifolds do not flicker. Not in the 2009 engine.
    pub steady_faces: bool,
    /// Of two hulls, takes only the edge pairs that can touch: the least depth is never along
    /// another, and there are tens of them instead of thousands. Not in the 2009 engine.
    pub touching_edges: bool,
    /// Gap over a plane up to which a body counts, m.
    pub plane_gap: f64,
}

/// How two shapes overlap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlap {
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// m; negative only within the gap over a plane that was asked for.
    pub depth: f64,
    pub source: AxisSource,
}

/// What an axis was made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AxisSource {
    /// A face of A (or A's plane, or a ball's nearest point).
    A,
    /// A face of B (or B's plane).
    B,
    /// An edge of each.
    Edges,
}

/// Buffers of the test, kept from pair to pair.
#[derive(Default)]
pub(super) struct AxisBuffers {
    set: VectorSet,
    a: Vec<Vector3<f64>>,
    b: Vec<Vector3<f64>>,
    arcs_a: Vec<EdgeArc>,
    arcs_b: Vec<EdgeArc>,
}

/// Tests two shapes; none if they are apart. Not for two half-spaces.
pub(super) fn overlap(a: &Placed, b: &Placed, search: &AxisSearch, buffers: &mut AxisBuffers) -> Option<Overlap> {
    match (a.geometry, b.geometry) {
        (Geometry::HalfSpace, _) => plane_overlap(a, b, search.plane_gap),
        (_, Geometry::HalfSpace) => plane_overlap(b, a, search.plane_gap).map(|overlap| Overlap {
            normal: -overlap.normal,
            source: AxisSource::B,
            ..overlap
        }),
        _ => convex_overlap(a, b, search, buffers),
    }
}

fn plane_overlap(plane: &Placed, body: &Placed, gap: f64) -> Option<Overlap> {
    let normal = plane.plane_normal();
    let depth = plane.center.dot(&normal) - body.project(&normal)[0];
    plane_depth(depth, gap, body.radius).map(|depth| Overlap { normal, depth, source: AxisSource::A })
}

/// The depth of a point or body below a plane, if it counts: what rounding could have made of zero
/// is zero, a true gap stays negative.
pub(super) fn plane_depth(depth: f64, gap: f64, radius: f64) -> Option<f64> {
    if depth >= -CONTACT_TOLERANCE * radius { Some(depth.max(0.0)) } else { (depth >= -gap).then_some(depth) }
}

fn convex_overlap(a: &Placed, b: &Placed, search: &AxisSearch, buffers: &mut AxisBuffers) -> Option<Overlap> {
    buffers.set.reset(search.epsilon, search.merge_opposites, 1.0);
    let mut test = AxisTest { a, b, tolerance: CONTACT_TOLERANCE * (a.radius + b.radius), least: [None; 3] };
    test.run(search, buffers)?;
    let margin = RIVAL_MARGIN * a.radius.min(b.radius);
    let [of_a, of_b, of_edges] = test.least;
    let choose = |best: Option<Overlap>, rival: Option<Overlap>| match (best, rival) {
        (Some(best), Some(rival)) => {
            let limit = if search.steady_faces { RIVAL_SHARE * best.depth - margin } else { best.depth };
            Some(if rival.depth < limit { rival } else { best })
        }
        (best, rival) => best.or(rival),
    };
    let least = choose(choose(of_a, of_b), of_edges);
    // Only two balls with one centre are left without an axis.
    Some(least.unwrap_or(Overlap { normal: Vector3::y(), depth: a.radius + b.radius, source: AxisSource::A }))
}

/// A test in progress: the least overlap so far along the axes of each source.
struct AxisTest<'t> {
    a: &'t Placed<'t>,
    b: &'t Placed<'t>,
    tolerance: f64,
    least: [Option<Overlap>; 3],
}

impl AxisTest<'_> {
    /// Goes through all candidate axes; none as soon as one separates.
    fn run(&mut self, search: &AxisSearch, buffers: &mut AxisBuffers) -> Option<()> {
        let AxisBuffers { set, a, b, arcs_a, arcs_b } = buffers;
        let (one, other) = (self.a, self.b);
        if matches!(other.geometry, Geometry::Sphere { .. }) {
            self.test_nearest(set, other, one)?;
        } else if matches!(one.geometry, Geometry::Sphere { .. }) {
            self.test_nearest(set, one, other)?;
        }
        self.test_faces(set, one, a, AxisSource::A)?;
        self.test_faces(set, other, b, AxisSource::B)?;
        if search.touching_edges && one.edge_arcs(false, arcs_a) && other.edge_arcs(true, arcs_b) {
            for arc_a in &*arcs_a {
                for arc_b in arcs_b.iter().filter(|arc_b| arc_a.crosses(arc_b)) {
                    self.test_edges(set, &arc_a.direction, &arc_b.direction)?;
                }
            }
        } else {
            one.edge_directions(a);
            other.edge_directions(b);
            for along_a in &*a {
                for along_b in &*b {
                    self.test_edges(set, along_a, along_b)?;
                }
            }
        }
        Some(())
    }

    #[inline]
    fn test_edges(&mut self, set: &mut VectorSet, along_a: &Vector3<f64>, along_b: &Vector3<f64>) -> Option<()> {
        match set.insert_direction(along_a.cross(along_b)) {
            Some(axis) => self.test(axis, AxisSource::Edges),
            None => Some(()),
        }
    }

    /// The axis from a ball to the nearest point of the other shape, unless its centre is inside.
    fn test_nearest(&mut self, set: &mut VectorSet, ball: &Placed, other: &Placed) -> Option<()> {
        // Of a ball, any point on the way to its centre shows the way; its centre always does.
        let nearest = match other.geometry {
            Geometry::Sphere { .. } => other.center,
            _ => other.nearest(&ball.center),
        };
        let away = ball.center - nearest;
        let distance = away.norm();
        if distance <= ON_SURFACE * ball.radius {
            return Some(());
        }
        let axis = away / distance;
        set.insert(axis);
        self.test(axis, AxisSource::A)
    }

    fn test_faces(
        &mut self,
        set: &mut VectorSet,
        shape: &Placed,
        normals: &mut Vec<Vector3<f64>>,
        source: AxisSource,
    ) -> Option<()> {
        shape.face_normals(normals);
        for &normal in &*normals {
            if set.insert(normal) {
                self.test(normal, source)?;
            }
            if shape.is_symmetric() {
                // The opposite face: an axis of its own for the set, but the same test.
                set.insert(-normal);
            }
        }
        Some(())
    }

    /// Measures the overlap along an axis both ways; none if it separates.
    #[inline]
    fn test(&mut self, axis: Vector3<f64>, source: AxisSource) -> Option<()> {
        let [low_a, high_a] = self.a.project(&axis);
        let [low_b, high_b] = self.b.project(&axis);
        let (forward, backward) = (high_a - low_b, high_b - low_a);
        let (depth, sign) = if forward <= backward { (forward, 1.0) } else { (backward, -1.0) };
        if depth < -self.tolerance {
            return None;
        }
        let least = &mut self.least[source as usize];
        if least.is_none_or(|least| depth.max(0.0) < least.depth) {
            *least = Some(Overlap { normal: axis * sign, depth: depth.max(0.0), source });
        }
        Some(())
    }
}
