//! A cone or a cylinder and a polyhedron: the separating axis test over all axes that a smooth solid of revolution has.
//!
//! In the axes of the round one, with d the other's centre and h the support functions, the overlap along a
//! unit direction n out of it is depth(n) = h_round(n) + h_other(−n) − n·d. It is least, and
//! if it is ever negative it is negative, along one of these:
//!
//! - a face's normal of the polyhedron, or an end's: the depth comes from the support functions;
//! - **flank across edge**: flank normals (cos γ ρ, sin γ) across an edge e, ρ·e_h = −tan γ e_y,
//!   e_h what of e lies across the axis: two of them;
//! - **flank at vertex** v: the flank normal whose plane v lies deepest behind, ρ along v_h;
//! - **rim across edge**: seen along the edge, an end is an ellipse of half axes r and r |e_y|,
//!   and the edge is a point; the normals at its [`feet`](super::ellipse::feet).
//!
//! At other normals the rim, the apex or a vertex alone would touch, which bound the overlap only
//! together with their neighbours. So the depth is that of the true shape, to rounding (the feet are
//! found to 1e-15 rad, and depths are flat there).
//!
//! An edge's or vertex's normal counts only where that edge or vertex is the foremost of the
//! polyhedron; then the depth is that from the round one to it, without a look at other vertices. Edges
//! are culled beforehand as in [`feature_sat`](super::feature_sat). Faces are preferred alike, but only where the point
//! that lies deepest behind one is over it: a round flank has one where a polygon's would have a patch.
//!
//! **Apart** by no more than the gap, they may be nearest where a **vertex**, or the **apex**, is: there −depth is the
//! distance, and nowhere greater. By more than the gap, it mostly takes a few steps to find ([`approach`](super::approach)).

use nalgebra::Vector3;

use super::approach::are_apart;
use super::axis_code::AxisCode;
use super::feature_sat::Best;
use super::revolved::{End, Revolved};
use super::{
    ClipBuffers, ContactPoint, Edge, Feature, FeatureId, Found, Least, Overlap, PairSearch, Polyhedron, ShapePair,
    edge_contact, ellipse, length_across, unit_across,
};
use crate::physics::collision::constants::{ARC_ROUNDING, FLAT_ELLIPSE};

/// Normals that each edge may have: two across the flank, two across each rim.
const PER_EDGE: u32 = 6;

/// Tests a solid of revolution and a polyhedron given in its axes; what was the last step's axis is tried first
/// and replaced. Contact points are left in the clip buffers, in the axes of the first.
pub(crate) fn touch(pair: &ShapePair<impl Revolved, impl Polyhedron>, search: &mut PairSearch) -> Option<Overlap> {
    let &ShapePair { a: round, b: other, b_in_a, scale } = pair;
    let foremost = |normal: &Vector3<f64>| b_in_a.place(&other.foremost(&b_in_a.enter(normal)));
    let between = |normal: &Vector3<f64>| foremost(&-normal) - round.foremost(normal);
    if are_apart(search, &b_in_a.center, scale.gap, between) {
        return None;
    }
    let round_in_other = b_in_a.inverse();
    let mut test = Test { pair, swapped: pair.swapped(&round_in_other), axes: &mut search.axes };
    let found = test.run(&mut search.edges.of_a);
    let overlap = match found {
        Ok(found) if other.is_of_mesh() => pair.touch_surface(&found, search),
        Ok(found) => found.take(pair, search, |least, clip| pair.smooth_point(least, clip)),
        Err(Separated) => None,
    };
    search.last = overlap.map(|overlap| Feature::Smooth(AxisCode::of(&overlap.normal).0));
    overlap
}

/// Apart by more than the gap.
struct Separated;

struct Test<'t, R, P> {
    pair: &'t ShapePair<'t, R, P>,
    swapped: ShapePair<'t, P, R>,
    axes: &'t mut u32,
}

impl<R: Revolved, P: Polyhedron> Test<'_, R, P> {
    /// The overlap or separation.
    fn run(&mut self, edges: &mut Vec<Edge>) -> Result<Found, Separated> {
        let &ShapePair { b: other, scale, .. } = self.pair;
        let of_face = self.swapped.least_face(f64::INFINITY, None, self.axes);
        let Best { depth, index } = of_face.map_err(|_| Separated)?.expect("some face is the best");
        let normal = self.pair.out_of_a(other.face(index as usize).normal);
        let of_face = Least { normal, depth, feature: Feature::FaceOfB(index) }.rounded(scale);
        let (mut preferred, mut least) = (of_face, of_face);
        for end in self.pair.a.ends().into_iter().flatten() {
            let (normal, feature) = (end.normal(), Feature::FaceOfA(end.face));
            let depth = self.pair.depth_along(&normal);
            *self.axes += 1;
            if scale.separates(depth) {
                return Err(Separated);
            }
            let of_end = Least { normal, depth, feature }.rounded(scale);
            if of_end.depth < scale.limit(preferred.depth) {
                preferred = of_end;
            }
            if of_end.depth < least.depth {
                least = of_end;
            }
        }
        let mut rivals = [self.least_smooth(least.depth, edges)?, None];
        let depth = rivals[0].map_or(least.depth, |smooth| smooth.depth);
        if depth < 0.0 {
            rivals[1] = self.at_corner(depth)?;
        }
        for rival in rivals.into_iter().flatten() {
            least = rival.rounded(scale);
            if least.depth < scale.limit(preferred.depth) {
                preferred = least;
            }
        }
        Ok(Found { least, preferred })
    }

    /// Of shapes apart, the normal between the nearest points if one of them is a vertex or the apex; none if their
    /// separation is not greater than that of a depth.
    fn at_corner(&mut self, depth: f64) -> Result<Option<Least>, Separated> {
        let &ShapePair { a: round, b: other, b_in_a, scale } = self.pair;
        let first = other.edge_count() as u32 * PER_EDGE;
        let mut nearest = (f64::INFINITY, Vector3::zeros(), 0);
        for vertex in 0..other.vertex_count() {
            let place = round.place(&b_in_a.place(&other.vertex(vertex)), scale.size);
            if place.height < nearest.0 {
                nearest = (place.height, place.normal, first + vertex as u32);
            }
        }
        let apex = round.tip().map(|tip| self.swapped.b_in_a.place(&tip));
        let first = first + other.vertex_count() as u32;
        for edge in (0..other.edge_count()).map(|edge| other.edge(edge)) {
            let Some(apex) = apex else { break };
            let along = (apex - edge.start).dot(&edge.direction).clamp(0.0, edge.length);
            let to_edge = edge.start + edge.direction * along - apex;
            let distance = to_edge.norm();
            if distance < nearest.0 && distance > 0.0 {
                nearest = (distance, b_in_a.rotation * to_edge / distance, first + edge.index);
            }
        }
        let (_, normal, number) = nearest;
        *self.axes += 1;
        let at_corner = Least { normal, depth: self.pair.depth_along(&normal), feature: Feature::Smooth(number) };
        if scale.separates(at_corner.depth) {
            return Err(Separated);
        }
        Ok((at_corner.depth < depth).then_some(at_corner))
    }

    /// The least depth along the round one's own normals, if it is below `limit`; an error if
    /// one separates.
    fn least_smooth(&mut self, limit: f64, edges: &mut Vec<Edge>) -> Result<Option<Least>, Separated> {
        let &ShapePair { a: round, b: other, b_in_a, scale } = self.pair;
        let bound = scale.bound(limit);
        let mut best = Best::under(limit);
        let mut normal = Vector3::zeros();
        let mut take = |number: u32, (depth, along): (f64, Vector3<f64>)| {
            *self.axes += 1;
            if scale.separates(depth) {
                return Err(Separated);
            }
            if depth < limit && best.take(depth, number) {
                normal = along;
            }
            Ok(())
        };
        self.swapped.facing_edges(bound, edges);
        for edge in &*edges {
            let placed = edge.placed(b_in_a, true);
            for (way, normal) in (0..).zip(normals_across(round, &placed, bound)) {
                if let Some(normal) = normal.filter(|normal| placed.arc_holds(normal, ARC_ROUNDING)) {
                    take(edge.index * PER_EDGE + way, (round.reach(&normal) - normal.dot(&placed.start), normal))?;
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

impl<R: Revolved, P: Polyhedron> ShapePair<'_, R, P> {
    /// Where the polyhedron is part of a surface: along a normal that the surface has, the preferred one if anything is
    /// between the faces there, or else the least, or else along that of its face, if anything is over that.
    fn touch_surface(&self, found: &Found, search: &mut PairSearch) -> Option<Overlap> {
        let Found { preferred, least } = found;
        let face_instead = |least: &Least| self.b.face_instead(&-self.b_in_a.enter(&least.normal));
        if face_instead(preferred).is_none() {
            if self.finds_points(preferred, &mut search.clip) {
                return Some(Overlap { normal: preferred.normal, depth: preferred.depth });
            }
            if least.feature == preferred.feature {
                return None;
            }
        }
        let least = match face_instead(least) {
            None => *least,
            Some(face) => self.along_face(face)?,
        };
        let is_any = self.finds_points(&least, &mut search.clip);
        is_any.then_some(Overlap { normal: least.normal, depth: least.depth })
    }

    /// Along the normal of a face of the surface; none if they are apart by more than the gap there.
    fn along_face(&self, face: usize) -> Option<Least> {
        let normal = self.out_of_a(self.b.face(face).normal);
        let depth = self.scale.rounded(self.depth_along(&normal));
        let along_face = Least { normal, depth, feature: Feature::FaceOfB(face as u32) };
        (!self.scale.separates(depth)).then_some(along_face)
    }

    /// Leaves the points that an axis has in the buffers, and tells whether there are any.
    fn finds_points(&self, least: &Least, clip: &mut ClipBuffers) -> bool {
        match least.feature.face() {
            Some((of_b, face)) => self.clip_to_face(of_b, face, least.depth, clip),
            None => {
                self.smooth_point(least, clip);
                true
            }
        }
    }

    /// The depth along the flank's normal that a vertex lies deepest behind, and that normal. None
    /// where the vertex is not the foremost of its polyhedron there, or the depth is certain to be
    /// above `bound`.
    fn flank_at_vertex(&self, vertex: usize, bound: f64) -> Option<(f64, Vector3<f64>)> {
        let &Self { a: round, b: other, b_in_a, .. } = self;
        let local = other.vertex(vertex);
        let place = b_in_a.place(&local);
        let normal = round.flank_normal(unit_across(&place));
        if round.flank_offset() + other.inner_radius() - normal.dot(&b_in_a.center) > bound {
            return None;
        }
        let toward = -b_in_a.enter(&normal);
        let height = local.dot(&toward) + ARC_ROUNDING * round.flank_offset();
        let is_foremost = (0..other.vertex_count()).all(|rival| other.vertex(rival).dot(&toward) <= height);
        is_foremost.then(|| (round.flank_offset() - normal.dot(&place), normal))
    }

    /// Leaves the point where the round surface touches an edge or vertex in the buffers.
    fn smooth_point(&self, least: &Least, buffers: &mut ClipBuffers) {
        let Least { normal, depth, feature: Feature::Smooth(number) } = *least else { return };
        let &Self { a: round, b: other, b_in_a, scale } = self;
        let feature = FeatureId::of_vertex(false, number);
        let first_vertex = other.edge_count() as u32 * PER_EDGE;
        buffers.found.clear();
        let point = if number >= first_vertex + other.vertex_count() as u32 {
            round.tip().expect("only a tip has that number") - normal * (depth / 2.0)
        } else if number >= first_vertex {
            b_in_a.place(&other.vertex((number - first_vertex) as usize)) + normal * (depth / 2.0)
        } else if number % PER_EDGE < 2 {
            let line = round.generator(unit_across(&normal));
            let edge = other.edge((number / PER_EDGE) as usize).placed(b_in_a, false).segment();
            return edge_contact::touch(&line, &edge, &Overlap { normal, depth }, feature, scale, &mut buffers.found);
        } else {
            let end = round.ends()[(number % PER_EDGE) as usize / 2 - 1].expect("it has the end");
            end.rim_point(unit_across(&normal)) - normal * (depth / 2.0)
        };
        buffers.found.push(ContactPoint { point, depth, feature });
    }
}

/// The normals of a solid of revolution across an edge given in its axes, mirrored: two of the flank, two of each rim. Those
/// of depths certain to be above `bound` may be left out.
fn normals_across(round: &impl Revolved, edge: &Edge, bound: f64) -> [Option<Vector3<f64>>; PER_EDGE as usize] {
    let [one, other] = flanks_across(round, &edge.direction, 0.0);
    let [sine, _] = round.slant();
    let [[a, b], [c, d]] = round.ends().map(|end| match end {
        // Where all of the arc is beyond the flank's circle, the rim is not foremost.
        Some(end) if edge.normals.iter().any(|normal| normal.y * end.outward >= sine * end.outward) => {
            rims_across(&end, &edge.start, &edge.direction, bound)
        }
        _ => [None; 2],
    });
    [one, other, a, b, c, d]
}

/// The normals n of the flank of which that much, n·e, lies along a unit direction e.
pub(super) fn flanks_across(round: &impl Revolved, e: &Vector3<f64>, share: f64) -> [Option<Vector3<f64>>; 2] {
    let [sine, cosine] = round.slant();
    let across = length_across(e);
    if across < FLAT_ELLIPSE {
        return [None; 2];
    }
    let along = (share - sine * e.y) / (cosine * across);
    let beside = 1.0 - along * along;
    if beside < 0.0 {
        return [None; 2];
    }
    let [x, z] = [e.x / across, e.z / across];
    [beside.sqrt(), -beside.sqrt()]
        .map(|beside| Some(round.flank_normal([along * x - beside * z, along * z + beside * x])))
}

/// The normals of an end's rim across a line through `start` along a unit direction e: where it is nearest to the line seen
/// along that, from either side.
pub(super) fn rims_across(end: &End, start: &Vector3<f64>, e: &Vector3<f64>, bound: f64) -> [Option<Vector3<f64>>; 2] {
    // The long axis of the ellipse, level, and the short one, both across the edge.
    let [x, z] = unit_across(&Vector3::new(e.z, 0.0, -e.x));
    let long = Vector3::new(x, 0.0, z);
    let short = e.cross(&long);
    let arm = start - end.center();
    let half = [end.radius, end.radius * e.y.abs()];
    let place = [arm.dot(&long), arm.dot(&short)];
    // From inside, the way out is no shorter than from the circle within the ellipse.
    if half[1] - (place[0] * place[0] + place[1] * place[1]).sqrt() > bound {
        return [None; 2];
    }
    ellipse::feet(half, place).map(|foot| {
        let [sin, cos] = foot?;
        let normal = long * (half[1] * cos) + short * (half[0] * sin);
        let length = normal.norm();
        if length > FLAT_ELLIPSE * end.radius {
            return Some(normal / length);
        }
        // At the end of an ellipse without width: toward the edge.
        let away = long * (place[0] - half[0] * cos) + short * (place[1] - half[1] * sin);
        away.try_normalize(FLAT_ELLIPSE * end.radius)
    })
}

#[cfg(test)]
impl<R: Revolved, P: Polyhedron> ShapePair<'_, R, P> {
    /// The least depth of all normals, and its normal.
    pub fn least(&self) -> (Vector3<f64>, f64) {
        let round_in_other = self.b_in_a.inverse();
        let mut test = Test { pair: self, swapped: self.swapped(&round_in_other), axes: &mut 0 };
        let found = test.run(&mut Vec::new()).ok().expect("the gap is wide");
        (found.least.normal, found.least.depth)
    }
}
