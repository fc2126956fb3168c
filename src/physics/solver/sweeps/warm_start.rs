//! Contact caching: what each contact point carried in the last step, found again by feature id.
//!
//! Forces, not multipliers, are kept, in world axes: they are projected on whatever rows the point
//! has next, so that friction directions may turn. Within a step, points carry their forces from
//! substep to substep.
//!
//! Joints start from zero. Their Baumgarte bias is part of the multiplier, and a bias carried over
//! before the sweeps have converged winds up: warm started, `joint_grid` gained 80 times its
//! energy in two seconds and `chain 100` a third, where from zero both lose a little. Contacts
//! cannot pull, which bounds it.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use nalgebra::Vector3;

use crate::physics::collision::{FeatureId, Pair};

/// Share of a kept force that a row starts from. All of it makes columns tremble (`stack 10` at
/// 0.5 m/s, at 0.002 with this share), none of it makes them creep: what few sweeps put wrong,
/// friction above all, must die away.
pub(crate) const KEPT_SHARE: f64 = 0.8;

/// Forces on B at the contact points of the last step, by pair and feature.
#[derive(Resource, Default)]
pub(crate) struct ContactCache {
    ranges: HashMap<(u32, u32), (usize, usize)>,
    points: Vec<(FeatureId, Vector3<f64>)>,
}

impl ContactCache {
    /// The force that a point carried, zero where it is new.
    pub fn force(&self, pair: Pair, feature: FeatureId) -> Vector3<f64> {
        let Some(&(start, end)) = self.ranges.get(&(pair.a, pair.b)) else { return Vector3::zeros() };
        let known = self.points[start..end].iter().find(|(known, _)| *known == feature);
        known.map_or_else(Vector3::zeros, |&(_, force)| force)
    }

    /// Replaces everything: one run of points a pair.
    pub fn clear(&mut self) {
        self.ranges.clear();
        self.points.clear();
    }

    /// Adds the points of one pair.
    pub fn insert(&mut self, pair: Pair, points: impl Iterator<Item = (FeatureId, Vector3<f64>)>) {
        let start = self.points.len();
        self.points.extend(points);
        self.ranges.insert((pair.a, pair.b), (start, self.points.len()));
    }

    /// Forgets the contacts of a body whose pose jumped.
    pub fn drop_body(&mut self, body: u32) {
        self.ranges.retain(|&(a, b), _| a != body && b != body);
    }

    /// All points, in the order in which they were inserted.
    pub fn points(&self) -> &[(FeatureId, Vector3<f64>)] {
        &self.points
    }
}
