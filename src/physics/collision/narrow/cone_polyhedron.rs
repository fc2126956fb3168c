//! A cone and a polyhedron: the separating axis test over all axes that a smooth cone has.
//!
//! In the cone's axes, with d the other's centre and h the support functions, the overlap along a
//! unit direction n out of the cone is depth(n) = h_cone(n) + h_other(−n) − n·d. It is least, and
//! if it is ever negative it is negative, along one of these:
//!
//! - a face's normal of the polyhedron, or the base's: the depth comes from the support functions;
//! - **flank across edge**: flank normals (cos γ ρ, sin γ) across an edge e, ρ·e_h = −tan γ e_y,
//!   e_h what of e lies across the axis: two of them;
//! - **flank at vertex** v: the flank normal whose plane v lies deepest behind, ρ along v_h;
//! - **rim across edge**: seen along the edge, the base is an ellipse of half axes r and r |e_y|,
//!   and the edge is a point; the normals at its [`feet`](super::ellipse::feet).
//!
//! At other normals the rim, the apex or a vertex alone would touch, which bound the overlap only
//! together with their neighbours. So the depth is the true cone's, to rounding (the feet are
//! found to 1e-15 rad, and depths are flat there).
//!
//! An edge's or vertex's normal counts only where that edge or vertex is the foremost of the
//! polyhedron; then the depth is that from the cone to it, without a look at other vertices. Edges
//! are culled beforehand as in [`feature_sat`](super::feature_sat), and the last step's axis comes
//! first here too. Faces are preferred alike, but only where the point that lies deepest behind one
//! is over it: a cone has one where a polygon's flank would have a patch.

use nalgebra::Vector3;

use super::clipping::ClipBuffers;
use super::cone::{Cone, unit_across};
use super::edge_contact::{self, Segment};
use super::ellipse;
use super::feature_sat::{Best, Feature, Found, Least, face_depth, facing_edges, least_face};
use super::polyhedron::{Convex, Edge, Frame, Polyhedron};
use super::scale::Scale;
use crate::physics::collision::constants::{ARC_ROUNDING, FLAT_ELLIPSE};
use crate::physics::collision::manifold::{ContactPoint, FeatureId, Overlap};

/// Normals that each edge may have: two across the flank, two across the rim.
const PER_EDGE: u32 = 4;

/// Tests a cone and a polyhedron given in its axes; what was the last step's axis is tried first
/// and replaced. Contact points are left in the clip buffers, in the cone's axes.
pub(crate) fn touch(
    cone: &Cone,
    other: &impl Polyhedron,
    other_in_cone: &Frame,
    scale: &Scale,
    last: &mut Option<Feature>,
    edges: &mut Vec<Edge>,
    clip: &mut ClipBuffers,
    axes: &mut u32,
) -> Option<Overlap> {
    let mut test = Test { cone, other, other_in_cone, cone_in_other: &other_in_cone.inverse(), scale, axes };
    match test.run(*last, edges) {
        Err(feature) => {
            *last = Some(feature);
            None
        }
        Ok(found) => {
            found.take(cone, other, other_in_cone, scale, last, clip, |least, clip| test.smooth_point(least, clip))
        }
    }
}

struct Test<'t, P> {
    cone: &'t Cone,
    other: &'t P,
    other_in_cone: &'t Frame,
    cone_in_other: &'t Frame,
    scale: &'t Scale,
    axes: &'t mut u32,
}

impl<P: Polyhedron> Test<'_, P> {
    /// The overlap or separation, or the feature along which that is beyond the gap.
    fn run(&mut self, last: Option<Feature>, edges: &mut Vec<Edge>) -> Result<Found, Feature> {
        self.try_last(last)?;
        let of_face = least_face(self.other, self.cone, self.cone_in_other, self.scale, f64::INFINITY, None, self.axes);
        let of_face = of_face.map_err(Feature::FaceOfB)?.expect("some face is the best");
        let normal = -(self.other_in_cone.rotation * self.other.face(of_face.index as usize).normal);
        let of_face =
            Least { normal, depth: of_face.depth, feature: Feature::FaceOfB(of_face.index) }.rounded(self.scale);
        let of_base = self.base_depth();
        *self.axes += 1;
        if self.scale.separates(of_base) {
            return Err(Feature::FaceOfA(0));
        }
        let of_base =
            Least { normal: Cone::base_normal(), depth: of_base, feature: Feature::FaceOfA(0) }.rounded(self.scale);
        let mut preferred = if of_base.depth < self.scale.limit(of_face.depth) { of_base } else { of_face };
        let mut least = if of_base.depth < of_face.depth { of_base } else { of_face };
        if let Some(smooth) = self.least_smooth(least.depth, edges)? {
            least = smooth.rounded(self.scale);
            if least.depth < self.scale.limit(preferred.depth) {
                preferred = least;
            }
        }
        Ok(Found { least, preferred })
    }

    fn base_depth(&self) -> f64 {
        let normal = Cone::base_normal();
        -self.cone.base + self.other.reach(&-self.other_in_cone.enter(&normal)) - normal.dot(&self.other_in_cone.center)
    }

    /// An error if the axis of the last step separates now.
    fn try_last(&mut self, last: Option<Feature>) -> Result<(), Feature> {
        let depth = match last {
            Some(Feature::FaceOfA(0)) => Some(self.base_depth()),
            Some(Feature::FaceOfB(face)) if (face as usize) < self.other.face_count() => {
                Some(face_depth(self.other, self.cone, self.cone_in_other, face as usize))
            }
            Some(Feature::Smooth(number)) => self.smooth(number).map(|(depth, _)| depth),
            _ => None,
        };
        *self.axes += u32::from(depth.is_some());
        match last.zip(depth) {
            Some((last, depth)) if self.scale.separates(depth) => Err(last),
            _ => Ok(()),
        }
    }

    /// The least depth along the smooth cone's own normals, if it is below `limit`; an error if
    /// one separates.
    fn least_smooth(&mut self, limit: f64, edges: &mut Vec<Edge>) -> Result<Option<Least>, Feature> {
        let bound = self.scale.bound(limit);
        let mut best = Best::under(limit);
        let mut normal = Vector3::zeros();
        let (axes, scale) = (&mut *self.axes, self.scale);
        let mut take = |number: u32, (depth, along): (f64, Vector3<f64>)| {
            *axes += 1;
            if scale.separates(depth) {
                return Err(Feature::Smooth(number));
            }
            if depth < limit && best.take(depth, number) {
                normal = along;
            }
            Ok(())
        };
        facing_edges(self.other, self.cone.inner_radius(), &self.cone_in_other.center, bound, edges);
        for edge in &*edges {
            let placed = edge.placed(self.other_in_cone, true);
            for way in 0..PER_EDGE {
                if let Some(found) = across_edge(self.cone, &placed, way) {
                    take(edge.index * PER_EDGE + way, found)?;
                }
            }
        }
        let first = self.other.edge_count() as u32 * PER_EDGE;
        for vertex in 0..self.other.vertex_count() {
            if let Some(found) = flank_at_vertex(self.cone, self.other, self.other_in_cone, vertex, bound) {
                take(first + vertex as u32, found)?;
            }
        }
        let index = best.index;
        Ok((index != u32::MAX).then_some(Least { normal, depth: best.depth, feature: Feature::Smooth(index) }))
    }

    /// The depth and normal of that number, as [`Self::least_smooth`] counts them, if they count.
    fn smooth(&self, number: u32) -> Option<(f64, Vector3<f64>)> {
        let edges = self.other.edge_count() as u32;
        if number < edges * PER_EDGE {
            let edge = self.other.edge((number / PER_EDGE) as usize).placed(self.other_in_cone, true);
            return across_edge(self.cone, &edge, number % PER_EDGE);
        }
        let vertex = (number - edges * PER_EDGE) as usize;
        let exists = vertex < self.other.vertex_count();
        exists.then(|| flank_at_vertex(self.cone, self.other, self.other_in_cone, vertex, f64::INFINITY)).flatten()
    }

    /// Leaves the point where the cone's surface touches an edge or vertex in the buffers.
    fn smooth_point(&self, least: &Least, buffers: &mut ClipBuffers) {
        let Least { normal, depth, feature: Feature::Smooth(number) } = *least else { return };
        let feature = FeatureId::of_vertex(false, number);
        let edges = self.other.edge_count() as u32;
        buffers.found.clear();
        if number >= edges * PER_EDGE {
            let vertex = self.other.vertex((number - edges * PER_EDGE) as usize);
            let point = self.other_in_cone.place(&vertex) + normal * (depth / 2.0);
            buffers.found.push(ContactPoint { point, depth, feature });
            return;
        }
        let edge = self.other.edge((number / PER_EDGE) as usize).placed(self.other_in_cone, false);
        if number % PER_EDGE < 2 {
            let line = Segment([self.cone.apex_point(), self.cone.rim_point(unit_across(&normal))]);
            let edge = Segment([edge.start, edge.end()]);
            edge_contact::touch(&line, &edge, &normal, depth, feature, self.scale, &mut buffers.found);
        } else {
            let point = self.cone.rim_point(unit_across(&normal)) - normal * (depth / 2.0);
            buffers.found.push(ContactPoint { point, depth, feature });
        }
    }
}

/// The depth along a normal of the cone across an edge given in its axes, mirrored, and the
/// normal: of the flank, or of the rim. None where there is no such normal, or the edge is not the
/// foremost of its polyhedron there.
fn across_edge(cone: &Cone, edge: &Edge, way: u32) -> Option<(f64, Vector3<f64>)> {
    let normal = if way < 2 { flank_across(cone, edge, way == 1)? } else { rim_across(cone, edge, way == 3)? };
    edge.arc_holds(&normal, ARC_ROUNDING).then(|| (cone.reach(&normal) - normal.dot(&edge.start), normal))
}

fn flank_across(cone: &Cone, edge: &Edge, other_way: bool) -> Option<Vector3<f64>> {
    let e = edge.direction;
    let across = e.x.hypot(e.z);
    if across < FLAT_ELLIPSE {
        return None;
    }
    let along = -cone.sine * e.y / (cone.cosine * across);
    let beside = 1.0 - along * along;
    if beside < 0.0 {
        return None;
    }
    let beside = if other_way { -beside.sqrt() } else { beside.sqrt() };
    let [x, z] = [e.x / across, e.z / across];
    Some(cone.flank_normal([along * x - beside * z, along * z + beside * x]))
}

fn rim_across(cone: &Cone, edge: &Edge, far: bool) -> Option<Vector3<f64>> {
    let e = edge.direction;
    // The long axis of the ellipse, level, and the short one, both across the edge.
    let [x, z] = unit_across(&Vector3::new(e.z, 0.0, -e.x));
    let long = Vector3::new(x, 0.0, z);
    let short = e.cross(&long);
    let arm = edge.start - Vector3::new(0.0, cone.base, 0.0);
    let half = [cone.radius, cone.radius * e.y.abs()];
    let [near, beyond] = ellipse::feet(half, [arm.dot(&long), arm.dot(&short)]);
    let [sin, cos] = if far { beyond } else { near }?;
    let normal = long * (half[1] * cos) + short * (half[0] * sin);
    let length = normal.norm();
    (length > FLAT_ELLIPSE * cone.radius).then(|| normal / length)
}

/// The depth along the flank's normal that a vertex lies deepest behind, and that normal. None
/// where the vertex is not the foremost of its polyhedron there, or the depth is certain to be
/// above `bound`.
fn flank_at_vertex(
    cone: &Cone,
    other: &impl Polyhedron,
    other_in_cone: &Frame,
    vertex: usize,
    bound: f64,
) -> Option<(f64, Vector3<f64>)> {
    let local = other.vertex(vertex);
    let place = other_in_cone.place(&local);
    let normal = cone.flank_normal(unit_across(&place));
    if cone.flank_offset() + other.inner_radius() - normal.dot(&other_in_cone.center) > bound {
        return None;
    }
    let toward = -other_in_cone.enter(&normal);
    let height = local.dot(&toward) + ARC_ROUNDING * cone.radius;
    let is_foremost = (0..other.vertex_count()).all(|rival| other.vertex(rival).dot(&toward) <= height);
    is_foremost.then(|| (cone.flank_offset() - normal.dot(&place), normal))
}
