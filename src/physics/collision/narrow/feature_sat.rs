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

use super::cluster::ClusterBuffers;
use super::{ClipBuffers, Convex, Edge, Faced, Overlap, Polyhedron, Scale, ShapePair, first_max};
use crate::physics::collision::constants::PARALLEL_SINE;
use crate::physics::lanes::WIDTH;
use crate::physics::{ContactPoint, EdgeLanes, Refill};

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
        pair: &ShapePair<impl Faced, impl Faced>,
        PairSearch { clip, last, .. }: &mut PairSearch,
        smooth_points: impl Fn(&Least, &mut ClipBuffers),
    ) -> Option<Overlap> {
        let Self { least, preferred } = self;
        let find_points = |least: &Least, clip: &mut ClipBuffers| match least.feature.face() {
            Some((of_b, face)) => pair.clip_to_face(of_b, face, least.depth, clip),
            None => {
                smooth_points(least, clip);
                true
            }
        };
        let mut is_any = find_points(&preferred, clip);
        let stands = pair.scale.keeps_faces || clip.stand_for(preferred.depth, pair.scale.size);
        let taken = if is_any && stands { preferred } else { least };
        if taken.feature != preferred.feature {
            is_any = find_points(&taken, clip);
        }
        *last = Some(taken.feature);
        let overlap = Overlap { normal: taken.normal, depth: taken.depth };
        if !is_any && overlap.depth < 0.0 {
            let reference_is_b = matches!(taken.feature, Feature::FaceOfB(_));
            return pair.beside(reference_is_b, &overlap, clip);
        }
        Some(overlap)
    }
}

/// The edges of two polyhedra that may count.
#[derive(Clone, Default)]
pub(crate) struct EdgeBuffers {
    /// In A's axes.
    pub of_a: Vec<Edge>,
    /// Mirrored.
    of_b: Vec<Edge>,
    /// B's, eight at a time.
    lanes_of_b: Vec<EdgeLanes>,
}

/// What one pair's test needs and leaves: buffers, and the axis that next step's test begins with.
#[derive(Clone, Default)]
pub(crate) struct PairSearch {
    pub edges: EdgeBuffers,
    pub clip: ClipBuffers,
    /// The axis of the last step, then that of this one.
    pub last: Option<Feature>,
    /// Axes measured so far.
    pub axes: u32,
    /// Of shapes found to be apart by more than the gap: how far they are at least, m.
    pub apart: f64,
    /// Of triangles, any normal will do that tells how far away a shape is, whether or not the mesh has it.
    pub any_normal: bool,
    /// Whether the least overlap is asked for, and not one of the faces that are nearly as good.
    pub is_exact: bool,
    /// Whether faces are to be kept where what is over them is somewhat deeper than the least overlap.
    pub keeps_faces: bool,
    /// Of triangles, what is behind them does not count: the pyramid there is next to flat.
    pub is_sheet: bool,
    /// Points of a facet's triangles, along its own normal and along another, and a buffer.
    pub of_facet: [Vec<ContactPoint>; 3],
    pub of_cluster: ClusterBuffers,
}

impl PairSearch {
    /// What a test has found; of shapes that are apart, keeps the feature along whose axis they are.
    pub fn near<T>(&mut self, found: Result<T, Feature>) -> Option<T> {
        found.map_err(|feature| self.last = Some(feature)).ok()
    }
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

/// Tests two polyhedra; what was the last step's axis is tried first and replaced. Contact points
/// are left in the clip buffers, in A's axes.
pub(crate) fn touch<A: Polyhedron, B: Polyhedron>(pair: &ShapePair<A, B>, search: &mut PairSearch) -> Option<Overlap> {
    let a_in_b = pair.b_in_a.inverse();
    let mut test = Test { pair, swapped: pair.swapped(&a_in_b), axes: &mut search.axes };
    let found = test.run(search.last, &mut search.edges);
    if let Err(feature) = found {
        search.apart = test.depth(feature).map_or(search.apart, |depth| -depth);
    }
    let found = pair.of_surface(search.near(found)?.rounded(pair.scale));
    let Least { normal, depth, feature } = found.ok_or_else(|| search.last = None).ok()?;
    search.last = Some(feature);
    let overlap = Overlap { normal, depth };
    if let Feature::Edges(edge_a, edge_b) = feature {
        return pair.crossing([edge_a, edge_b].map(|edge| edge as usize), &overlap, &mut search.clip);
    }
    let (reference_is_b, face) = feature.face().expect("a polyhedron has faces and edges alone");
    let is_any = pair.clip_to_face(reference_is_b, face, depth, &mut search.clip);
    if !is_any && (pair.a.is_of_mesh() || pair.b.is_of_mesh()) {
        return None;
    }
    if !is_any && depth < 0.0 {
        return pair.beside(reference_is_b, &overlap, &mut search.clip);
    }
    Some(overlap)
}

impl<A: Polyhedron, B: Polyhedron> ShapePair<'_, A, B> {
    /// What was found, or where it has a normal that the surface which A is part of does not have, what there is along that
    /// of its face; none if they are apart along it by more than the gap.
    fn of_surface(&self, found: Least) -> Option<Least> {
        let Some(face) = self.a.face_instead(&found.normal) else { return Some(found) };
        let depth = self.face_depth(face);
        let of_face = Least { normal: self.a.face(face).normal, depth, feature: Feature::FaceOfA(face as u32) };
        (!self.scale.separates(depth)).then(|| of_face.rounded(self.scale))
    }
}

struct Test<'t, A, B> {
    pair: &'t ShapePair<'t, A, B>,
    swapped: ShapePair<'t, B, A>,
    axes: &'t mut u32,
}

impl<A: Polyhedron, B: Polyhedron> Test<'_, A, B> {
    /// The least overlap or greatest separation, or the feature along which that is beyond the gap.
    fn run(&mut self, last: Option<Feature>, edges: &mut EdgeBuffers) -> Result<Least, Feature> {
        let &ShapePair { a, b, scale, .. } = self.pair;
        let last = last.filter(|last| self.exists(*last));
        self.try_last(last)?;
        let last_face = |of_b: bool| last.and_then(Feature::face).filter(|face| face.0 == of_b).map(|(_, face)| face);
        let of_a = self.pair.least_face(f64::INFINITY, last_face(false), self.axes);
        // None is the best of what is nowhere: a solve that came to nothing may leave a place that is not a number.
        let of_a = of_a.map_err(Feature::FaceOfA)?.ok_or(Feature::FaceOfA(0))?;
        let of_b = self.swapped.least_face(scale.limit(of_a.depth), last_face(true), self.axes);
        let least = match of_b.map_err(Feature::FaceOfB)? {
            None => {
                let normal = a.face(of_a.index as usize).normal;
                Least { normal, depth: of_a.depth, feature: Feature::FaceOfA(of_a.index) }
            }
            Some(best) => {
                let normal = self.pair.out_of_a(b.face(best.index as usize).normal);
                Least { normal, depth: best.depth, feature: Feature::FaceOfB(best.index) }
            }
        };
        let of_edges = self.least_edges(scale.limit(least.depth), last, edges)?;
        Ok(of_edges.unwrap_or(least))
    }

    fn exists(&self, feature: Feature) -> bool {
        let &ShapePair { a, b, .. } = self.pair;
        let within = |index: u32, count: usize| (index as usize) < count;
        match feature {
            Feature::FaceOfA(face) => within(face, a.face_count()),
            Feature::FaceOfB(face) => within(face, b.face_count()),
            Feature::Edges(on_a, on_b) => within(on_a, a.edge_count()) && within(on_b, b.edge_count()),
            Feature::Smooth(_) => false,
        }
    }

    /// An error if the axis of the last step separates now. A face of A comes first anyway.
    fn try_last(&mut self, last: Option<Feature>) -> Result<(), Feature> {
        let Some(last) = last.filter(|last| !matches!(last, Feature::FaceOfA(_))) else { return Ok(()) };
        *self.axes += 1;
        match self.depth(last) {
            Some(depth) if self.pair.scale.separates(depth) => Err(last),
            _ => Ok(()),
        }
    }

    /// Along the axis of a feature, if there is one.
    fn depth(&self, feature: Feature) -> Option<f64> {
        match feature {
            Feature::FaceOfA(face) => Some(self.pair.face_depth(face as usize)),
            Feature::FaceOfB(face) => Some(self.swapped.face_depth(face as usize)),
            Feature::Edges(a, b) => self.edge_depth(a, b).map(|(depth, _)| depth),
            Feature::Smooth(_) => None,
        }
    }

    fn edge_depth(&self, a: u32, b: u32) -> Option<(f64, Vector3<f64>)> {
        edge_depth(&self.pair.a.edge(a as usize), &self.pair.b.edge(b as usize).placed(self.pair.b_in_a, true))
    }

    /// The pair of edges of least depth, if it is below `limit`; an error if one separates.
    fn least_edges(
        &mut self,
        limit: f64,
        last: Option<Feature>,
        EdgeBuffers { of_a, of_b, lanes_of_b }: &mut EdgeBuffers,
    ) -> Result<Option<Least>, Feature> {
        let &ShapePair { b_in_a, scale, .. } = self.pair;
        let mut best = Best { depth: limit, index: (u32::MAX, u32::MAX) };
        if let Some(Feature::Edges(a, b)) = last
            && let Some((depth, _)) = self.edge_depth(a, b)
            && depth < limit
        {
            best.take(depth, (a, b));
        }
        let bound = scale.bound(best.depth);
        self.pair.facing_edges(bound, of_a);
        of_b.clear();
        if !of_a.is_empty() {
            self.swapped.facing_edges(bound, of_b);
        }
        for edge in &mut *of_b {
            *edge = edge.placed(b_in_a, true);
        }
        lanes_of_b.refill(EdgeLanes::of(of_b.len(), |index| of_b[index].parts()));
        for a in &*of_a {
            let parts = a.parts();
            for (eight, lanes) in lanes_of_b.iter().enumerate() {
                let lanes = lanes.crossing(&parts, scale.bound(best.depth), scale.reach);
                for b in lanes_of(lanes, eight, of_b.len()).map(|index| &of_b[index]) {
                    let Some((depth, _)) = edge_depth(a, b) else { continue };
                    *self.axes += 1;
                    if scale.separates(depth) {
                        return Err(Feature::Edges(a.index, b.index));
                    }
                    if depth < limit {
                        best.take(depth, (a.index, b.index));
                    }
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

impl<A: Polyhedron, B: Convex> ShapePair<'_, A, B> {
    /// The overlap along the normal of a face of A.
    pub fn face_depth(&self, face: usize) -> f64 {
        let plane = self.a.face(face);
        plane.offset - plane.normal.dot(&self.b_in_a.center) + self.b.reach(&-self.b_in_a.enter(&plane.normal))
    }

    /// The face of A with the least depth, if it is below `limit`; the error is one that separates.
    /// Begins with the face given, or else the one that B's centre is highest above.
    pub fn least_face(&self, limit: f64, last: Option<u32>, axes: &mut u32) -> Result<Option<Best<u32>>, u32> {
        let scale = self.scale;
        let height = |face: usize| {
            let plane = self.a.face(face);
            plane.normal.dot(&self.b_in_a.center) - plane.offset
        };
        let inner = self.b.inner_radius();
        let count = self.a.face_count();
        let mut best = Best::under(limit);
        let mut measure = |face: usize, best: &mut Best<u32>| {
            *axes += 1;
            let depth = self.face_depth(face);
            if scale.separates(depth) {
                return Err(face as u32);
            }
            if depth < limit {
                best.take(depth, face as u32);
            }
            Ok(())
        };
        let first = last.map_or_else(|| first_max((0..count).map(height)), |last| last as usize);
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

    /// The edges of A whose arcs hold a direction along which the depth may be within `bound`.
    pub fn facing_edges(&self, bound: f64, edges: &mut Vec<Edge>) {
        let (inner, center) = (self.b.inner_radius(), &self.b_in_a.center);
        if self.a.edge_lanes().is_empty() {
            let faces = |edge: &Edge| inner - edge.height_of(center) <= bound;
            edges.refill((0..self.a.edge_count()).map(|index| self.a.edge(index)).filter(faces));
            return;
        }
        edges.clear();
        for (eight, lanes) in self.a.edge_lanes().iter().enumerate() {
            let lanes = lanes.below(center, inner - bound, self.scale.reach);
            edges.extend(lanes_of(lanes, eight, self.a.edge_count()).map(|index| self.a.edge(index)));
        }
    }
}

/// The numbers, below `count`, that the bits of one of several eights stand for.
fn lanes_of(mut bits: u32, eight: usize, count: usize) -> impl Iterator<Item = usize> {
    let next = move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < WIDTH).then_some(WIDTH * eight + lane)
    };
    std::iter::from_fn(next).take_while(move |&index| index < count)
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
