//! The points where bodies touch, or may touch within a step, at the poses that they have.

use nalgebra::Vector3;

use super::super::constants::{NEARLY_THE_SAME, ROUNDED_DEPTH, SAME_DEPTH};
use super::super::mechanism::MemberState;
use crate::physics::Geometry;
use crate::physics::body::{Body, SurfaceMaterial};
use crate::physics::collision::{ContactPoint, FeatureId, Overlap, PairKey, PairSearch, PartPair, touch};
use crate::physics::contact::namesake;

/// Two bodies in reach of each other.
#[derive(Clone, Debug)]
pub(super) struct ReachablePair {
    /// By their indices in the world.
    pub key: PairKey,
    /// By their places here.
    pub ends: [u32; 2],
    pub surface: SurfaceMaterial,
}

/// A contact point with its gap, at the poses it was found at.
#[derive(Clone, Debug)]
pub(super) struct GapPoint {
    /// Index of its pair.
    pub pair: u32,
    pub feature: FeatureId,
    pub ends: [u32; 2],
    /// In the world, m.
    pub point: Vector3<f64>,
    /// From the centres of mass, world axes, to where it rubs: the points of a pair all on the plane of the deepest of them.
    /// Of points at unlike heights no two could stick while a gap between them closes: as one body tilts over the other,
    /// what is higher goes along with it. Along the normal an arm is worth nothing else.
    pub arms: [Vector3<f64>; 2],
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// m; negative: they overlap.
    pub gap: f64,
    pub friction: f64,
}

impl GapPoint {
    /// Velocity of B's point relative to A's, m/s.
    pub fn velocity(&self, states: &[MemberState]) -> Vector3<f64> {
        let [a, b] = [0, 1].map(|end| point_velocity(&states[self.ends[end] as usize], &self.arms[end]));
        b - a
    }

    /// How fast its gap opens, m/s.
    pub fn opening(&self, states: &[MemberState]) -> f64 {
        self.normal.dot(&self.velocity(states))
    }
}

pub(super) fn point_velocity(state: &MemberState, arm: &Vector3<f64>) -> Vector3<f64> {
    state.linear + state.angular.cross(arm)
}

/// The contact points of all pairs, in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct GapPoints {
    pub list: Vec<GapPoint>,
    /// Where the points of each pair begin; then the number of all.
    starts: Vec<u32>,
}

impl GapPoints {
    #[cfg(test)]
    pub fn of_one_pair(list: Vec<GapPoint>) -> Self {
        Self { starts: vec![0, list.len() as u32], list }
    }

    /// Leaves none of so many pairs.
    pub fn clear(&mut self, pairs: usize) {
        self.list.clear();
        self.starts.clear();
        self.starts.resize(pairs + 1, 0);
    }

    pub fn of(&self, pair: usize) -> &[GapPoint] {
        &self.list[self.starts[pair] as usize..self.starts[pair + 1] as usize]
    }

    /// The index of the point of the same features.
    pub fn position(&self, pair: u32, feature: FeatureId) -> Option<usize> {
        let pair = pair as usize;
        let at = namesake(self.of(pair).iter().map(|point| point.feature), feature)?;
        Some(self.starts[pair] as usize + at)
    }

    /// The indices of all points of the same features: facets of a mesh number theirs each for itself.
    pub fn namesakes(&self, pair: u32, feature: FeatureId) -> impl Iterator<Item = usize> {
        let first = self.starts[pair as usize] as usize;
        let own = self.of(pair as usize).iter().zip(first..);
        own.filter(move |(point, _)| point.feature == feature).map(|(_, index)| index)
    }

    /// Finds them at the bodies' poses, up to a gap for each pair, m. Where a pair has fewer than `wanted`, as a cone that has
    /// lain on a box and is tilted about its edge by a forecast, those of the face that it lay on are as true, if they are as
    /// deep.
    pub fn find(
        &mut self,
        pairs: &[ReachablePair],
        bodies: &[Body],
        gap: impl Fn(&ReachablePair) -> f64,
        wanted: impl Fn(u32) -> usize,
        search: &mut PointSearch,
    ) {
        self.list.clear();
        self.starts.clear();
        for (index, pair) in (0..).zip(pairs) {
            self.starts.push(self.list.len() as u32);
            let [a, b] = pair.ends.map(|end| &bodies[end as usize]);
            let Some(mut overlap) = search.find([a, b], pair.key.parts, gap(pair), false) else { continue };
            if touch_along_a_line([a, b]) && search.points.len() < wanted(index) {
                std::mem::swap(&mut search.points, &mut search.least);
                match search.find([a, b], pair.key.parts, gap(pair), true) {
                    Some(over_face) if search.is_as_true([&overlap, &over_face], a.radius.min(b.radius)) => {
                        overlap = over_face
                    }
                    _ => std::mem::swap(&mut search.points, &mut search.least),
                }
            }
            let normal = overlap.normal;
            let deepest = search.points.iter().max_by(|one, other| one.depth.total_cmp(&other.depth));
            let height = deepest.map_or(0.0, |deepest| normal.dot(&deepest.point));
            self.list.extend(search.points.iter().map(|point| {
                let rubbed = point.point + normal * (height - normal.dot(&point.point));
                GapPoint {
                    pair: index,
                    feature: point.feature,
                    ends: pair.ends,
                    point: point.point,
                    arms: [rubbed - a.position, rubbed - b.position],
                    normal,
                    gap: -point.depth,
                    friction: pair.surface.friction,
                }
            }));
        }
        self.starts.push(self.list.len() as u32);
    }
}

/// Whether one is a cone or a cylinder and the other has faces: tilted about the edge of a face that it lies on, such a flank
/// touches at one point by the least overlap. Of two polyhedra that tells the points of one face or the other.
fn touch_along_a_line(bodies: [&Body; 2]) -> bool {
    let is_round = |body: &Body| matches!(body.geometry, Some(Geometry::Cone { .. } | Geometry::Cylinder { .. }));
    let has_faces = |body: &Body| matches!(body.geometry, Some(Geometry::Cuboid { .. } | Geometry::Hull(_)));
    bodies.iter().any(|body| is_round(body)) && bodies.iter().any(|body| has_faces(body))
}

/// Buffers of the search.
#[derive(Clone, Default)]
pub(super) struct PointSearch {
    search: PairSearch,
    points: Vec<ContactPoint>,
    /// Those of the least overlap, where others were looked for.
    least: Vec<ContactPoint>,
}

impl PointSearch {
    fn find(&mut self, pair: [&Body; 2], parts: PartPair, gap: f64, keeps_faces: bool) -> Option<Overlap> {
        (self.search.last, self.search.is_exact, self.search.keeps_faces) = (None, true, keeps_faces);
        self.points.clear();
        touch(pair, parts, gap, &mut self.search, &mut self.points)
    }

    /// Whether the points are more than those of the least overlap, and as deep, along nearly the same normal.
    fn is_as_true(&self, [least, found]: [&Overlap; 2], size: f64) -> bool {
        let [deepest, found_deepest] = [&self.least, &self.points]
            .map(|points| points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max));
        self.points.len() > self.least.len()
            && least.normal.dot(&found.normal) > NEARLY_THE_SAME
            && (found_deepest - deepest).abs() <= SAME_DEPTH * deepest.abs() + ROUNDED_DEPTH * size
    }
}
