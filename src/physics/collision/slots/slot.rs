//! One pair: which features touch, and when they are looked for again.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::record::{ContactGeometry, ContactState, POINTS};
use super::watch::Known;
use crate::physics::bit_set::BitSet;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::constants::{FLAT_RECYCLING, ROUND_RECYCLING, SUCCESSION_REACH};
use crate::physics::collision::continuous::fast_pair::FastPair;
use crate::physics::collision::continuous::time_of_impact::{self, Course, Impact};
use crate::physics::collision::gap::{Near, lasting_gap, way_ahead};
use crate::physics::collision::manifold::{ContactPoint, FeatureId, Overlap, Pair, PartPair};
use crate::physics::collision::narrow::contact_pair::{self, PairSearch};
use crate::physics::collision::narrow::feature_sat::Feature;
use crate::physics::collision::parts::{Placed, has_parts};
use crate::physics::collision::pose::Pose;
use crate::physics::contact::{predecessors, surface, tangents};
use crate::physics::settings::SolverSettings;
use crate::physics::shape::Geometry;

/// One pair.
///
/// In the order in which a step needs it: its head is what tells whether the manifold is still good and what the solver
/// reads, the next cache line what of that is seldom needed, the others are looked at when a manifold is found.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Slot {
    pub pair: Pair,
    /// Whether there are contact points.
    pub touching: bool,
    /// Whether one of the shapes is curved, and whether both are balls.
    is_curved: bool,
    pub(super) is_of_balls: bool,
    pub restitution: f32,
    /// Smaller bounding radius.
    size: f64,
    /// By how much the bodies may move against each other until the manifold is found anew, m.
    recycling: f64,
    /// Bounding radius of B, or of its part.
    reach: f64,
    /// The gap up to which the manifold was looked for, m.
    found_within: f64,
    /// How far apart the bodies were then at least if they do not touch, m.
    apart: f64,
    /// In which of the graph's updates the manifold was found.
    pub found_in: u64,
    /// Displacement of B against A until they meet, world axes, m, where the contact was found ahead: its points are
    /// those of the poses at which they meet.
    pub ahead: Vector3<f64>,
    /// Origin of A's axes for this contact, from its centre of mass: none, or near B where A is static, since it may be
    /// a ground that reaches far.
    pub(super) origin: Vector3<f64>,
    /// The axis that the test ended with: the next one begins there. Manifolds do not depend on it.
    axis: Option<Feature>,
    /// The pose at which the manifold was found; none: it is to be found.
    found_at: Option<Pose>,
    /// None: there is no pair.
    pub entities: Option<(Entity, Entity)>,
    pub(super) features: [FeatureId; POINTS],
    /// Which parts of the two shapes it is of.
    pub parts: PartPair,
    /// The middle of B's part in B's axes.
    part_of_b: Vector3<f64>,
    /// Whether one of them has parts, so that the bodies may have several slots.
    pub is_of_parts: bool,
}

impl Slot {
    /// Of a new pair, whose manifold is not known.
    pub(super) fn new(pair: Pair, parts: PartPair, a: &Body, b: &Body) -> Self {
        let is_round = |body: &Body| body.geometry.as_ref().is_some_and(Geometry::is_round);
        let is_ball = |body: &Body| matches!(body.geometry, Some(Geometry::Sphere { .. }));
        let of_b = Placed::of(b, parts.b).map_or((b.radius, b.position), |placed| (placed.radius, placed.position));
        Self {
            pair,
            parts,
            is_of_parts: has_parts(a) || has_parts(b),
            is_curved: is_round(a) || is_round(b),
            is_of_balls: is_ball(a) && is_ball(b),
            size: Near::of([a, b], parts).size,
            reach: of_b.0,
            part_of_b: b.rotation.inverse_transform_vector(&(of_b.1 - b.position)),
            entities: Some((a.entity, b.entity)),
            ..Self::default()
        }
    }

    /// How B, or its part, lies to A.
    #[inline]
    pub(super) fn pose(&self, a: &Body, b: &Body) -> Pose {
        if self.is_of_parts { Pose::relative_at(a, b, &self.part_of_b) } else { Pose::relative(a, b) }
    }

    /// Where the two may meet.
    #[inline]
    pub(super) fn near(&self, b: &Body) -> Near {
        let part = || (b.position + b.rotation * self.part_of_b, self.reach);
        Near { size: self.size, part: self.is_of_parts.then(part) }
    }

    /// Has the manifold found anew.
    pub(super) fn forget(&mut self) {
        self.found_at = None;
    }

    /// How far the bodies have moved against each other since the manifold was found, at most; none: it is to be found.
    #[inline]
    pub(super) fn moved(&self, pose: &Pose) -> Option<f64> {
        self.found_at.as_ref().map(|found| found.moved(pose, self.reach))
    }

    /// Whether the manifold is good where the bodies have moved so far. That of bodies that touch is while they have
    /// hardly moved against each other. Bodies that are apart have none while they cannot have come as near as one is
    /// looked for, nor where they have hardly moved and do not come from beyond where it was looked for.
    #[inline]
    pub(super) fn holds_after(&self, moved: f64, a: &Body, b: &Body, near: &Near, h: f64) -> bool {
        if self.touching {
            return moved <= self.recycling;
        }
        let limit = ROUND_RECYCLING * self.size;
        moved + lasting_gap(a, b, near, h) <= self.apart
            || (moved <= limit && way_ahead(a, b, near, h) <= self.found_within - limit)
    }

    /// What is known of the pair where the bodies have moved so far since the manifold was looked for.
    pub(super) fn known_after(&self, moved: f64) -> Known {
        match (self.touching, &self.found_at) {
            (false, _) => Known::Apart(self.apart - moved),
            (true, Some(_)) => Known::Manifold(self.recycling - moved),
            (true, None) => Known::Nothing,
        }
    }

    /// Smaller bounding radius.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// By how much the bodies may move against each other until a manifold of so many points is found anew, m. Three
    /// points and more are a patch, on which nothing rolls.
    pub(super) fn recycling_of(&self, points: usize) -> f64 {
        let share = if self.is_curved && points < 3 { ROUND_RECYCLING } else { FLAT_RECYCLING };
        share * self.size
    }

    /// From the centre of mass of A, world axes.
    pub fn origin_in_world(&self, a: &Body) -> Vector3<f64> {
        a.rotation * self.origin
    }

    /// Finds the manifold for the present poses within a gap, m, or, if the pair is fast, that at its impact. Returns it
    /// if it is.
    pub(super) fn find(
        &mut self,
        (pose, gap): (Pose, f64),
        state: &mut ContactState,
        a: &Body,
        b: &Body,
        joined: &BitSet,
        settings: &SolverSettings,
        search: &mut PairSearch,
        points: &mut Vec<ContactPoint>,
    ) -> Option<FastPair> {
        let h = settings.step();
        self.found_at = Some(pose);
        self.found_within = gap;
        self.apart = 0.0;
        search.last = self.axis;
        // One on a joint will not go on as it moves now.
        let is_free = !joined.contains(self.pair.a) && !joined.contains(self.pair.b);
        let parts = self.parts;
        let fast = if is_free { time_of_impact::move_far([a, b], parts, h) } else { [false; 2] };
        let is_fast = fast.contains(&true);
        let course = if is_fast { time_of_impact::course([a, b], parts, h, search, points) } else { Course::Touching };
        let meeting = match course {
            Course::Touching => {
                let overlap = contact_pair::touch([a, b], parts, self.found_within, search, points);
                self.apart = search.apart;
                overlap.map(|overlap| Impact { time: 0.0, at: [a.position, b.position], overlap })
            }
            Course::Impact(impact) => {
                // To be found again in the next step, however little is left of the approach.
                self.found_at = None;
                Some(impact)
            }
            Course::Apart => None,
        };
        self.axis = search.last;
        if let Some(meeting) = &meeting {
            points.truncate(POINTS);
            self.take_in(state, a, b, meeting, settings, points);
        } else {
            *state = ContactState::default();
        }
        self.touching = meeting.is_some();
        is_fast.then(|| FastPair::new(self.pair, parts, [a, b], fast, meeting.map(|meeting| meeting.time)))
    }

    /// Takes in the points found where the bodies meet.
    fn take_in(
        &mut self,
        state: &mut ContactState,
        a: &Body,
        b: &Body,
        &Impact { time, at, overlap: Overlap { normal, .. } }: &Impact,
        settings: &SolverSettings,
        points: &[ContactPoint],
    ) {
        let surface = surface(a, b, settings.friction);
        let old = std::mem::take(state);
        let normal_in_a = a.rotation.inverse_transform_vector(&normal);
        let [tangent, _] = tangents(&normal_in_a);
        let apart = at[1] - at[0];
        self.ahead = apart - (b.position - a.position);
        self.origin = match a.kind {
            RigidBody::Static => a.rotation.inverse_transform_vector(&apart),
            RigidBody::Dynamic | RigidBody::Kinematic => Vector3::zeros(),
        };
        let origin = self.origin;
        let places = points.iter().map(|point| {
            let [arm_a, arm_b] = at.map(|center| point.point - center);
            // Rows are straight: points that meet later are as far apart now as their speed then will close.
            let approach = (a.point_velocity(&arm_a) - b.point_velocity(&arm_b)).dot(&normal);
            let half = normal * (0.5 * (point.depth - approach.max(0.0) * time));
            let on_a = a.rotation.inverse_transform_vector(&(arm_a + half)) - origin;
            let on_b = b.rotation.inverse_transform_vector(&(arm_b - half));
            (on_a, on_b)
        });
        state.geometry = ContactGeometry::new(&normal_in_a, &tangent, surface.friction, points.len(), places);
        self.restitution = surface.restitution as f32;
        self.recycling = self.recycling_of(points.len());
        if self.touching {
            self.carry_pushes(&old, state, points);
            self.carry_friction(&old, state);
        }
        for (kept, point) in self.features.iter_mut().zip(points) {
            *kept = point.feature;
        }
    }

    /// Each point takes over what its predecessor pushed.
    fn carry_pushes(&self, old: &ContactState, state: &mut ContactState, points: &[ContactPoint]) {
        let known = &self.features[..old.geometry.point_count()];
        let place = |geometry: &ContactGeometry, index: usize| geometry.point(index).0;
        let apart = |new, known| (place(&old.geometry, known) - place(&state.geometry, new)).norm_squared();
        let new = points.iter().map(|point| point.feature);
        let from: [_; POINTS] = predecessors(known, new, apart, SUCCESSION_REACH * self.size);
        for (impulse, from) in state.impulses.0.iter_mut().zip(from) {
            *impulse = from.map_or(0.0, |known| old.impulses.0[known]);
        }
    }

    /// Friction turns along with the tangents.
    fn carry_friction(&self, old: &ContactState, state: &mut ContactState) {
        let frame = |geometry: &ContactGeometry| {
            let (normal, tangent) = (geometry.normal(), geometry.tangent());
            [tangent, normal.cross(&tangent)]
        };
        let [x, y] = frame(&old.geometry);
        let force = x * f64::from(old.impulses.0[POINTS]) + y * f64::from(old.impulses.0[POINTS + 1]);
        for (impulse, tangent) in state.impulses.0[POINTS..].iter_mut().zip(frame(&state.geometry)) {
            *impulse = force.dot(&tangent) as f32;
        }
        state.impulses.0[POINTS + 2] = old.impulses.0[POINTS + 2];
    }
}
