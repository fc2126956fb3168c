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

use super::feature_sat::Best;
use super::{
    ClipBuffers, Cone, ContactPoint, Convex, Edge, Feature, FeatureId, Found, Least, Overlap, PairSearch, Polyhedron,
    Segment, ShapePair, edge_contact, ellipse, unit_across,
};
use crate::physics::collision::constants::{ARC_ROUNDING, FLAT_ELLIPSE};

/// Normals that each edge may have: two across the flank, two across the rim.
const PER_EDGE: u32 = 4;

/// Tests a cone and a polyhedron given in its axes; what was the last step's axis is tried first
/// and replaced. Contact points are left in the clip buffers, in the cone's axes.
pub(crate) fn touch(pair: &ShapePair<Cone, impl Polyhedron>, search: &mut PairSearch) -> Option<Overlap> {
    let cone_in_other = pair.b_in_a.inverse();
    let mut test = Test { pair, swapped: pair.swapped(&cone_in_other), axes: &mut search.axes };
    let found = test.run(search.last, &mut search.edges[0]);
    search.near(found)?.take(pair, search, |least, clip| pair.smooth_point(least, clip))
}

struct Test<'t, P> {
    pair: &'t ShapePair<'t, Cone, P>,
    swapped: ShapePair<'t, P, Cone>,
    axes: &'t mut u32,
}

impl<P: Polyhedron> Test<'_, P> {
    /// The overlap or separation, or the feature along which that is beyond the gap.
    fn run(&mut self, last: Option<Feature>, edges: &mut Vec<Edge>) -> Result<Found, Feature> {
        let &ShapePair { b: other, scale, .. } = self.pair;
        self.try_last(last)?;
        let of_face = self.swapped.least_face(f64::INFINITY, None, self.axes);
        let Best { depth, index } = of_face.map_err(Feature::FaceOfB)?.expect("some face is the best");
        let normal = self.pair.out_of_a(other.face(index as usize).normal);
        let of_face = Least { normal, depth, feature: Feature::FaceOfB(index) }.rounded(scale);
        let (normal, feature) = (Cone::base_normal(), Feature::FaceOfA(0));
        let depth = self.pair.depth_along(&normal);
        *self.axes += 1;
        if scale.separates(depth) {
            return Err(feature);
        }
        let of_base = Least { normal, depth, feature }.rounded(scale);
        let mut preferred = if of_base.depth < scale.limit(of_face.depth) { of_base } else { of_face };
        let mut least = if of_base.depth < of_face.depth { of_base } else { of_face };
        if let Some(smooth) = self.least_smooth(least.depth, edges)? {
            least = smooth.rounded(scale);
            if least.depth < scale.limit(preferred.depth) {
                preferred = least;
            }
        }
        Ok(Found { least, preferred })
    }

    /// An error if the axis of the last step separates now.
    fn try_last(&mut self, last: Option<Feature>) -> Result<(), Feature> {
        let depth = match last {
            Some(Feature::FaceOfA(0)) => Some(self.pair.depth_along(&Cone::base_normal())),
            Some(Feature::FaceOfB(face)) if (face as usize) < self.pair.b.face_count() => {
                Some(self.swapped.face_depth(face as usize))
            }
            Some(Feature::Smooth(number)) => self.pair.smooth(number).map(|(depth, _)| depth),
            _ => None,
        };
        *self.axes += u32::from(depth.is_some());
        last.filter(|_| depth.is_some_and(|depth| self.pair.scale.separates(depth))).map_or(Ok(()), Err)
    }

    /// The least depth along the smooth cone's own normals, if it is below `limit`; an error if
    /// one separates.
    fn least_smooth(&mut self, limit: f64, edges: &mut Vec<Edge>) -> Result<Option<Least>, Feature> {
        let &ShapePair { a: cone, b: other, b_in_a, scale } = self.pair;
        let bound = scale.bound(limit);
        let mut best = Best::under(limit);
        let mut normal = Vector3::zeros();
        let mut take = |number: u32, (depth, along): (f64, Vector3<f64>)| {
            *self.axes += 1;
            if scale.separates(depth) {
                return Err(Feature::Smooth(number));
            }
            if depth < limit && best.take(depth, number) {
                normal = along;
            }
            Ok(())
        };
        self.swapped.facing_edges(bound, edges);
        for edge in &*edges {
            let placed = edge.placed(b_in_a, true);
            for way in 0..PER_EDGE {
                if let Some(found) = across_edge(cone, &placed, way) {
                    take(edge.index * PER_EDGE + way, found)?;
                }
            }
        }
        let first = other.edge_count() as u32 * PER_EDGE;
        for vertex in 0..other.vertex_count() {
            if let Some(found) = self.pair.flank_at_vertex(vertex, bound) {
                take(first + vertex as u32, found)?;
            }
        }
        let index = best.index;
        Ok((index != u32::MAX).then_some(Least { normal, depth: best.depth, feature: Feature::Smooth(index) }))
    }
}

impl<P: Polyhedron> ShapePair<'_, Cone, P> {
    /// The depth and normal of that number, as [`Test::least_smooth`] counts them, if they count.
    fn smooth(&self, number: u32) -> Option<(f64, Vector3<f64>)> {
        let edges = self.b.edge_count() as u32;
        if number < edges * PER_EDGE {
            let edge = self.b.edge((number / PER_EDGE) as usize).placed(self.b_in_a, true);
            return across_edge(self.a, &edge, number % PER_EDGE);
        }
        let vertex = (number - edges * PER_EDGE) as usize;
        (vertex < self.b.vertex_count()).then(|| self.flank_at_vertex(vertex, f64::INFINITY)).flatten()
    }

    /// The depth along the flank's normal that a vertex lies deepest behind, and that normal. None
    /// where the vertex is not the foremost of its polyhedron there, or the depth is certain to be
    /// above `bound`.
    fn flank_at_vertex(&self, vertex: usize, bound: f64) -> Option<(f64, Vector3<f64>)> {
        let &Self { a: cone, b: other, b_in_a, .. } = self;
        let local = other.vertex(vertex);
        let place = b_in_a.place(&local);
        let normal = cone.flank_normal(unit_across(&place));
        if cone.flank_offset() + other.inner_radius() - normal.dot(&b_in_a.center) > bound {
            return None;
        }
        let toward = -b_in_a.enter(&normal);
        let height = local.dot(&toward) + ARC_ROUNDING * cone.radius;
        let is_foremost = (0..other.vertex_count()).all(|rival| other.vertex(rival).dot(&toward) <= height);
        is_foremost.then(|| (cone.flank_offset() - normal.dot(&place), normal))
    }

    /// Leaves the point where the cone's surface touches an edge or vertex in the buffers.
    fn smooth_point(&self, least: &Least, buffers: &mut ClipBuffers) {
        let Least { normal, depth, feature: Feature::Smooth(number) } = *least else { return };
        let &Self { a: cone, b: other, b_in_a, scale } = self;
        let feature = FeatureId::of_vertex(false, number);
        let on_rim = || cone.rim_point(unit_across(&normal));
        let edges = other.edge_count() as u32;
        buffers.found.clear();
        let point = if number >= edges * PER_EDGE {
            b_in_a.place(&other.vertex((number - edges * PER_EDGE) as usize)) + normal * (depth / 2.0)
        } else if number % PER_EDGE < 2 {
            let line = Segment([cone.apex_point(), on_rim()]);
            let edge = other.edge((number / PER_EDGE) as usize).placed(b_in_a, false).segment();
            return edge_contact::touch(&line, &edge, &Overlap { normal, depth }, feature, scale, &mut buffers.found);
        } else {
            on_rim() - normal * (depth / 2.0)
        };
        buffers.found.push(ContactPoint { point, depth, feature });
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
