//! The separating axis test of two polyhedra, feature by feature (Gregorius, GDC 2013).
//!
//! Two convex polyhedra are apart exactly if they are apart along the normal of a face of A, of
//! a face of B, or across an edge of each. How far they overlap along a direction n out of A is
//!
//!   depth(n) = h_A(n) + h_B(−n) − n·d,
//!
//! h the support functions, d from A's centre to B's; the least is the depth of the contact.
//!
//! - A face of A has h_A = its plane's offset; h_B ≥ r, the radius of the largest ball in B. So
//!   the depth is at least r less the height of B's centre over the plane: one product tells of
//!   most faces that they cannot be the best, and B's vertices are looked at for the others only.
//! - Two edges count only where their arcs on the Gauss map cross. Then both are foremost along
//!   n, their cross product, and the depth is that from one to the other: no vertices at all.
//!   Edges whose arc holds no direction that could beat the best so far, by the same bound, are
//!   left out before they are paired.
//!
//! **Last step's axis first.** [`Feature`] names what an axis was made of. That of the last step
//! is measured first, at the present pose: where it still separates, the test is over, and where
//! it does not, its depth is the bound to beat. It never changes the result: bounds leave out
//! only what is worse by more than rounding, and of equal depths the lowest number wins.
//!
//! **Apart.** Where the least depth is negative, down to the gap asked for, its axis is that of
//! greatest separation s = −depth, at most the distance of the shapes: equal to it where their
//! nearest features are a face and what is over it or two edges that cross, less where they are
//! a vertex or edge beside another (cubes corner to corner are √3 s apart). No test but that of
//! what separates changes for it: the bounds hold for negative depths too.
//!
//! Depths along faces of A, faces of B and edges are compared with a preference for the earlier
//! kind ([`Scale::limit`]), so that manifolds do not flicker between nearly equal axes.

use nalgebra::Vector3;

use super::apart;
use super::clipping::{ClipBuffers, Faced, clip_to_face};
use super::polyhedron::{Convex, Edge, Frame, Polyhedron, first_max};
use super::scale::Scale;
use crate::physics::collision::constants::PARALLEL_SINE;
use crate::physics::collision::manifold::Overlap;

/// What an axis was made of, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    FaceOfA(u32),
    FaceOfB(u32),
    /// An edge of A and one of B.
    Edges(u32, u32),
    /// What a cone numbers of its smooth surface.
    Smooth(u32),
}

impl Feature {
    /// Whether it is a face of B, and which, if it is one.
    pub fn face(self) -> Option<(bool, u32)> {
        match self {
            Self::FaceOfA(face) => Some((false, face)),
            Self::FaceOfB(face) => Some((true, face)),
            Self::Edges(..) | Self::Smooth(_) => None,
        }
    }
}

/// Along which axis two shapes overlap least.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Least {
    /// Unit, from A to B, in A's axes.
    pub normal: Vector3<f64>,
    /// m; negative where they are apart, by no more than the gap.
    pub depth: f64,
    pub feature: Feature,
}

impl Least {
    /// What rounding made of a depth of zero is zero.
    pub fn rounded(self, scale: &Scale) -> Self {
        Self { depth: scale.rounded(self.depth), ..self }
    }
}

/// Along which axes a cone overlaps another shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub least: Least,
    /// A face or base, or the least if that is less deep by enough.
    pub preferred: Least,
}

impl Found {
    /// Takes the preferred axis if its points can stand for it, else the least; leaves its points in the clip buffers,
    /// where it is no face's those that `smooth_points` does, and the axis in `last`.
    pub fn take(
        self,
        a: &(impl Convex + Faced),
        b: &(impl Convex + Faced),
        b_in_a: &Frame,
        scale: &Scale,
        last: &mut Option<Feature>,
        clip: &mut ClipBuffers,
        smooth_points: impl Fn(&Least, &mut ClipBuffers),
    ) -> Option<Overlap> {
        let Self { least, preferred } = self;
        let find_points = |least: &Least, clip: &mut ClipBuffers| match least.feature.face() {
            Some((of_b, face)) => clip_to_face(a, b, b_in_a, of_b, face, least.depth, scale, clip),
            None => {
                smooth_points(least, clip);
                true
            }
        };
        let mut is_any = find_points(&preferred, clip);
        let taken = if is_any && clip.stand_for(preferred.depth, scale.size) { preferred } else { least };
        if taken.feature != preferred.feature {
            is_any = find_points(&taken, clip);
        }
        *last = Some(taken.feature);
        let overlap = Overlap { normal: taken.normal, depth: taken.depth };
        if !is_any && overlap.depth < 0.0 {
            let reference_is_b = matches!(taken.feature, Feature::FaceOfB(_));
            return apart::beside(a, b, b_in_a, reference_is_b, &overlap, scale, clip);
        }
        Some(overlap)
    }
}

/// How a test went.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Verdict {
    /// Apart by more than the gap along that feature's axis.
    Apart(Feature),
    /// Overlapping, or within the gap.
    Near(Least),
}

/// Buffers of the edges that may count, kept from pair to pair.
#[derive(Default)]
pub(crate) struct EdgeBuffers {
    pub a: Vec<Edge>,
    b: Vec<Edge>,
}

/// The feature of least depth so far, by number.
#[derive(Clone, Copy)]
pub(crate) struct Best<I> {
    pub depth: f64,
    pub index: I,
}

impl Best<u32> {
    /// None yet; u32::MAX stands for it.
    pub fn under(limit: f64) -> Self {
        Self { depth: limit, index: u32::MAX }
    }
}

impl<I: PartialOrd + Copy> Best<I> {
    /// Takes what is less deep. Of equal depths the lowest number wins, whichever was measured
    /// first.
    pub fn take(&mut self, depth: f64, index: I) -> bool {
        let is_better = depth < self.depth || (depth == self.depth && index < self.index);
        if is_better {
            *self = Self { depth, index };
        }
        is_better
    }
}

/// Tests two polyhedra, B's frame in A's. Adds the number of axes measured to `axes`.
pub(crate) fn test(
    a: &impl Polyhedron,
    b: &impl Polyhedron,
    b_in_a: &Frame,
    scale: &Scale,
    last: Option<Feature>,
    buffers: &mut EdgeBuffers,
    axes: &mut u32,
) -> Verdict {
    let mut test = Test { a, b, b_in_a, a_in_b: &b_in_a.inverse(), scale, axes };
    match test.run(last, buffers) {
        Ok(least) => Verdict::Near(least.rounded(scale)),
        Err(feature) => Verdict::Apart(feature),
    }
}

struct Test<'t, A, B> {
    a: &'t A,
    b: &'t B,
    b_in_a: &'t Frame,
    a_in_b: &'t Frame,
    scale: &'t Scale,
    axes: &'t mut u32,
}

impl<A: Polyhedron, B: Polyhedron> Test<'_, A, B> {
    /// The least overlap or greatest separation, or the feature along which that is beyond the gap.
    fn run(&mut self, last: Option<Feature>, buffers: &mut EdgeBuffers) -> Result<Least, Feature> {
        let last = last.filter(|last| self.exists(*last));
        let (mut face_a, mut face_b, mut edges) = (None, None, None);
        match last {
            Some(Feature::FaceOfA(index)) => face_a = Some(index as usize),
            Some(Feature::FaceOfB(index)) => face_b = Some(index as usize),
            Some(Feature::Edges(a, b)) => edges = Some((a, b)),
            Some(Feature::Smooth(_)) | None => {}
        }
        self.try_last(face_b, edges)?;
        let (a_in_b, b_in_a) = (self.a_in_b, self.b_in_a);
        let of_a = least_face(self.a, self.b, b_in_a, self.scale, f64::INFINITY, face_a, self.axes);
        let of_a = of_a.map_err(Feature::FaceOfA)?.expect("some face is the best");
        let limit = self.scale.limit(of_a.depth);
        let of_b =
            least_face(self.b, self.a, a_in_b, self.scale, limit, face_b, self.axes).map_err(Feature::FaceOfB)?;
        let least = match of_b {
            None => {
                let normal = self.a.face(of_a.index as usize).normal;
                Least { normal, depth: of_a.depth, feature: Feature::FaceOfA(of_a.index) }
            }
            Some(best) => {
                let normal = -(b_in_a.rotation * self.b.face(best.index as usize).normal);
                Least { normal, depth: best.depth, feature: Feature::FaceOfB(best.index) }
            }
        };
        let of_edges = self.least_edges(self.scale.limit(least.depth), edges, buffers)?;
        Ok(of_edges.unwrap_or(least))
    }

    fn exists(&self, feature: Feature) -> bool {
        let within = |index: u32, count: usize| (index as usize) < count;
        match feature {
            Feature::FaceOfA(face) => within(face, self.a.face_count()),
            Feature::FaceOfB(face) => within(face, self.b.face_count()),
            Feature::Edges(a, b) => within(a, self.a.edge_count()) && within(b, self.b.edge_count()),
            Feature::Smooth(_) => false,
        }
    }

    /// An error if the axis of the last step separates now. A face of A comes first anyway.
    fn try_last(&mut self, face_b: Option<usize>, edges: Option<(u32, u32)>) -> Result<(), Feature> {
        let (last, depth) = if let Some(index) = face_b {
            (Feature::FaceOfB(index as u32), face_depth(self.b, self.a, self.a_in_b, index))
        } else if let Some((a, b)) = edges {
            (Feature::Edges(a, b), self.edge_depth(a, b).map_or(0.0, |(depth, _)| depth))
        } else {
            return Ok(());
        };
        *self.axes += 1;
        if self.scale.separates(depth) { Err(last) } else { Ok(()) }
    }

    fn edge_depth(&self, a: u32, b: u32) -> Option<(f64, Vector3<f64>)> {
        edge_depth(&self.a.edge(a as usize), &self.b.edge(b as usize).placed(self.b_in_a, true))
    }

    /// The pair of edges of least depth, if it is below `limit`; an error if one separates.
    fn least_edges(
        &mut self,
        limit: f64,
        last: Option<(u32, u32)>,
        buffers: &mut EdgeBuffers,
    ) -> Result<Option<Least>, Feature> {
        let mut best = Best { depth: limit, index: (u32::MAX, u32::MAX) };
        if let Some((a, b)) = last
            && let Some((depth, _)) = self.edge_depth(a, b)
            && depth < limit
        {
            best.take(depth, (a, b));
        }
        let bound = self.scale.bound(best.depth);
        facing_edges(self.a, self.b.inner_radius(), &self.b_in_a.center, bound, &mut buffers.a);
        buffers.b.clear();
        if !buffers.a.is_empty() {
            facing_edges(self.b, self.a.inner_radius(), &self.a_in_b.center, bound, &mut buffers.b);
        }
        for edge in &mut buffers.b {
            *edge = edge.placed(self.b_in_a, true);
        }
        for a in &buffers.a {
            for b in &buffers.b {
                let Some((depth, _)) = edge_depth(a, b) else { continue };
                *self.axes += 1;
                if self.scale.separates(depth) {
                    return Err(Feature::Edges(a.index, b.index));
                }
                if depth < limit {
                    best.take(depth, (a.index, b.index));
                }
            }
        }
        let (a, b) = best.index;
        if a == u32::MAX {
            return Ok(None);
        }
        let measured = self.edge_depth(a, b);
        Ok(measured.map(|(depth, normal)| Least { normal, depth, feature: Feature::Edges(a, b) }))
    }
}

/// The overlap along a face's normal.
pub(crate) fn face_depth(one: &impl Polyhedron, other: &impl Convex, other_in_one: &Frame, face: usize) -> f64 {
    let plane = one.face(face);
    plane.offset - plane.normal.dot(&other_in_one.center) + other.reach(&-other_in_one.enter(&plane.normal))
}

/// The face of `one` with the least depth, if it is below `limit`; the error is one that
/// separates. Begins with the face given, or else the one that the other's centre is highest
/// above.
pub(crate) fn least_face(
    one: &impl Polyhedron,
    other: &impl Convex,
    other_in_one: &Frame,
    scale: &Scale,
    limit: f64,
    last: Option<usize>,
    axes: &mut u32,
) -> Result<Option<Best<u32>>, u32> {
    let height = |face: usize| {
        let plane = one.face(face);
        plane.normal.dot(&other_in_one.center) - plane.offset
    };
    let inner = other.inner_radius();
    let count = one.face_count();
    let mut best = Best::under(limit);
    let mut measure = |face: usize, best: &mut Best<u32>| {
        *axes += 1;
        let depth = face_depth(one, other, other_in_one, face);
        if scale.separates(depth) {
            return Err(face as u32);
        }
        if depth < limit {
            best.take(depth, face as u32);
        }
        Ok(())
    };
    let first = last.unwrap_or_else(|| first_max((0..count).map(height)));
    if inner - height(first) <= scale.bound(limit) {
        measure(first, &mut best)?;
    }
    for face in (0..count).filter(|&face| face != first) {
        if inner - height(face) <= scale.bound(best.depth) {
            measure(face, &mut best)?;
        }
    }
    Ok((best.index != u32::MAX).then_some(best))
}

/// The depth across two edges and the unit normal, out of the first shape; none if they do not
/// bound the Minkowski difference together. The second comes mirrored.
fn edge_depth(a: &Edge, b: &Edge) -> Option<(f64, Vector3<f64>)> {
    if !a.crosses(b) {
        return None;
    }
    let across = a.direction.cross(&b.direction);
    let sine = across.norm();
    if sine < PARALLEL_SINE {
        return None;
    }
    let out = across.dot(&(a.normals[0] + a.normals[1]));
    let normal = across / sine.copysign(out);
    Some((normal.dot(&(a.start - b.start)), normal))
}

/// The edges of `one` whose arcs hold a direction along which the depth may be within `bound`,
/// given the centre and inner radius of the other.
pub(crate) fn facing_edges(
    one: &impl Polyhedron,
    other_inner: f64,
    other_center: &Vector3<f64>,
    bound: f64,
    edges: &mut Vec<Edge>,
) {
    edges.clear();
    edges.extend(
        (0..one.edge_count())
            .map(|index| one.edge(index))
            .filter(|edge| other_inner - edge.height_of(other_center) <= bound),
    );
}
