//! Two balls: their contact in closed form, without the way that other shapes take.
//!
//! The one point of two balls lies on the line of their centres, on each ball at its radius along the normal n: no axes
//! need be turned to find it. So it is found anew wherever the pair is looked at, which costs less than to ask whether
//! the last one is still good.

use nalgebra::Vector3;

use super::record::{ContactGeometry, ContactState, IMPACT, POINTS};
use super::slot::Slot;
use super::watch::Known;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::constants::ON_SURFACE;
use crate::physics::collision::continuous::time_of_impact::move_far;
use crate::physics::collision::gap::contact_gap;
use crate::physics::collision::manifold::PartPair;
use crate::physics::collision::narrow::Scale;
use crate::physics::contact::{surface, tangents};
use crate::physics::settings::SolverSettings;

impl Slot {
    /// Finds the contact of two balls at their present places, and what is then known of them. None where that is for the
    /// way of all shapes: where they are not balls, one may move far in the step, or A is static.
    pub(super) fn find_balls(
        &mut self,
        state: &mut ContactState,
        a: &Body,
        b: &Body,
        settings: &SolverSettings,
    ) -> Option<Known> {
        let h = settings.step();
        if !self.is_of_balls || a.kind == RigidBody::Static || move_far([a, b], PartPair::default(), h).contains(&true)
        {
            return None;
        }
        let between = b.position - a.position;
        let distance = between.norm();
        let scale = Scale::new(a.radius, b.radius, contact_gap(a, b, settings));
        let depth = a.radius + b.radius - distance;
        if scale.separates(depth) {
            if self.touching {
                *state = ContactState::default();
                self.touching = false;
            }
            return Some(Known::Apart(-depth));
        }
        let normal = if distance > ON_SURFACE * a.radius { between / distance } else { Vector3::y() };
        let [normal_in_a, normal_in_b] = [a, b].map(|body| body.rotation.inverse_transform_vector(&normal));
        let [tangent, other] = tangents(&normal_in_a);
        let surface = surface(a, b, settings.friction);
        let force = self.touching.then(|| {
            let (normal, tangent) = (state.geometry.normal(), state.geometry.tangent());
            let [x, y] = [POINTS, POINTS + 1].map(|row| f64::from(state.impulses.0[row]));
            tangent * x + normal.cross(&tangent) * y
        });
        let points = (normal_in_a * a.radius, normal_in_b * -b.radius);
        state.geometry = ContactGeometry::new(&normal_in_a, &tangent, surface.friction, 1, std::iter::once(points));
        match force {
            Some(force) => {
                state.impulses.0[POINTS] = force.dot(&tangent) as f32;
                state.impulses.0[POINTS + 1] = force.dot(&other) as f32;
                state.impulses.0[IMPACT] = 0.0;
            }
            None => state.impulses.0 = Default::default(),
        }
        self.restitution = surface.restitution as f32;
        self.ahead = Vector3::zeros();
        self.touching = true;
        Some(Known::Manifold(self.recycling_of(1)))
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::Entity;

    use super::*;
    use crate::physics::bit_set::BitSet;
    use crate::physics::collision::manifold::Pair;
    use crate::physics::collision::narrow::contact_pair::PairSearch;
    use crate::physics::collision::pose::Pose;
    use crate::physics::shape::Geometry;
    use crate::physics::testing::Random;

    fn ball(random: &mut Random, radius: f64, at: Vector3<f64>) -> Body {
        Body {
            kind: RigidBody::Dynamic,
            position: at,
            rotation: random.rotation(),
            linear: random.vector(),
            angular: random.vector(),
            radius,
            geometry: Some(Geometry::Sphere { radius }),
            ..Body::new(Entity::PLACEHOLDER)
        }
    }

    /// How far two records are apart.
    fn difference(one: &ContactState, other: &ContactState) -> f32 {
        let of = |state: &ContactState| {
            let geometry = state.geometry.records.iter().flat_map(|record| record.0);
            geometry.chain(state.impulses.0).collect::<Vec<_>>()
        };
        of(one).into_iter().zip(of(other)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn two_balls_have_the_contact_that_the_way_of_all_shapes_finds_and_keep_its_impulses() {
        let (mut random, settings) = (Random::new(38), SolverSettings::game());
        let (mut touched, mut apart) = (0, 0);
        for _ in 0..500 {
            let radii = [random.within(0.1, 1.0), random.within(0.1, 1.0)];
            let at = random.vector() * 3.0;
            let a = ball(&mut random, radii[0], at);
            let between = random.direction() * (radii[0] + radii[1]) * random.within(0.9, 1.3);
            let b = ball(&mut random, radii[1], a.position + between);
            let mut slots = [(); 2]
                .map(|()| (Slot::new(Pair { a: 0, b: 1 }, PartPair::default(), &a, &b), ContactState::default()));
            let mut points = Vec::new();
            // The second time they have turned, and pushed before.
            let mut bodies = [a, b];
            for time in 0..2 {
                let [a, b] = &bodies;
                let [(short, of_short), (long, of_long)] = &mut slots;
                let Some(known) = short.find_balls(of_short, a, b, &settings) else { break };
                points.clear();
                let (search, joined) = (&mut PairSearch::default(), &BitSet::default());
                let place = (Pose::relative(a, b), contact_gap(a, b, &settings));
                long.find(place, of_long, a, b, joined, &settings, search, &mut points);
                assert_eq!((short.touching, short.features), (long.touching, long.features));
                let off = difference(of_short, of_long);
                assert!(off < 2e-6, "off by {off} the {time}. time: {of_short:?} and {of_long:?}");
                match (known, long.known_after(0.0)) {
                    (Known::Apart(one), Known::Apart(other)) => assert!((one - other).abs() < 1e-12),
                    (Known::Manifold(one), Known::Manifold(other)) => assert_eq!(one, other),
                    (one, other) => panic!("{one:?} is not {other:?}"),
                }
                touched += u32::from(short.touching && time == 1);
                apart += u32::from(!short.touching);
                if short.touching {
                    for state in [of_short, of_long] {
                        state.impulses.0[0] = 2.0;
                        state.impulses.0[POINTS] = 0.5;
                        state.impulses.0[POINTS + 1] = -0.3;
                        state.impulses.0[IMPACT] = 1.0;
                    }
                }
                bodies.iter_mut().for_each(|body| body.advance(&(random.vector() * 1e-3), &(random.vector() * 0.1)));
            }
        }
        assert!(touched > 100 && apart > 100, "{touched} and {apart}");
    }

    #[test]
    fn what_stands_still_and_what_moves_far_goes_the_way_of_all_shapes() {
        let mut random = Random::new(39);
        let a = ball(&mut random, 0.5, Vector3::zeros());
        let b = ball(&mut random, 0.5, Vector3::x());
        let find = |a: &Body, b: &Body| {
            let mut slot = Slot::new(Pair { a: 0, b: 1 }, PartPair::default(), a, b);
            slot.find_balls(&mut ContactState::default(), a, b, &SolverSettings::game()).is_some()
        };
        assert!(find(&a, &b));
        assert!(!find(&Body { kind: RigidBody::Static, ..a.clone() }, &b));
        assert!(!find(&a, &Body { linear: Vector3::x() * 100.0, ..b.clone() }));
        assert!(!find(&a, &Body { geometry: Some(Geometry::Cuboid { half: Vector3::repeat(0.3) }), ..b }));
    }
}
