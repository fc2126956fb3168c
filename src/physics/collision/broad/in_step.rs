//! The bodies of a step as the broad phase asks for them. Bounds each shape: for impulse methods by its own box, for others,
//! whose gap is told for each body, by its sphere and that gap.

use nalgebra::Vector3;

use super::bounding_tree::BoundingBox;
use super::fat_box::{Extent, Placement};
use super::persistent_pairs::{BoundedBodies, Bounds};
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::constants::CONTACT_TOLERANCE;
use crate::physics::collision::gap::own_reach;
use crate::physics::joint::JoinedPairs;
use crate::physics::settings::SolverSettings;

/// The bodies as the broad phase asks for them.
pub(crate) struct InStep<'a> {
    pub bodies: &'a [Body],
    pub joined: &'a JoinedPairs,
    /// s.
    pub h: f64,
    /// Of methods that look for contacts up to a gap told for each body.
    pub reach: Option<&'a SolverSettings>,
}

impl BoundedBodies for InStep<'_> {
    fn placement(&self, body: u32) -> Placement {
        let Body { position, rotation, linear, angular, pulled, .. } = self.bodies[body as usize];
        if self.reach.is_some() {
            return Placement { position, rotation, travel: Vector3::zeros(), turn: f64::INFINITY };
        }
        let turn = if pulled > 0.0 { f64::INFINITY } else { angular.norm() * self.h };
        Placement { position, rotation, travel: linear * self.h, turn }
    }

    fn bounds(&self, body: u32) -> Bounds {
        let body = &self.bodies[body as usize];
        if body.touches_nothing() {
            return Bounds::None;
        }
        let axes = body.rotation.to_rotation_matrix().into_inner();
        let gap = self.reach.map_or(body.pulled * self.h * self.h, |settings| own_reach(body, settings));
        let Some(geometry) = &body.geometry else { return Bounds::None };
        let Some(reach) = geometry.reach(&axes) else {
            let normal = axes.column(1).into_owned();
            return Bounds::HalfSpace { normal, point: body.position + normal * gap };
        };
        let slack = Vector3::repeat(CONTACT_TOLERANCE * body.radius);
        let [low, high] = [body.position + reach[0] - slack, body.position + reach[1] + slack];
        let moves = body.kind != RigidBody::Static;
        Bounds::Within(Extent { bounds: BoundingBox { low, high }, radius: body.radius + gap, moves })
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        may_collide([a, b].map(|body| &self.bodies[body as usize]), self.joined, [a, b])
    }
}

/// Whether two bodies of those indices that touch anything are to collide where they meet.
pub(crate) fn may_collide([one, other]: [&Body; 2], joined: &JoinedPairs, [a, b]: [u32; 2]) -> bool {
    (one.is_dynamic() || other.is_dynamic()) && one.layers.interact(other.layers) && !joined.contains(a, b)
}
