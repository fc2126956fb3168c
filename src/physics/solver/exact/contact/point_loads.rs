//! What contact points carry in a step, by pair and feature.
//!
//! Points come pair by pair, as in [`GapPoints`](super::gap_points::GapPoints): of each pair those that carried something are a
//! chain in the order in which they came, so that what is read one after the other lies side by side.

use nalgebra::Vector3;

use super::gap_points::GapPoint;
use crate::physics::collision::FeatureId;

/// What a contact point carries.
#[derive(Clone, Debug)]
pub(super) struct PointLoad {
    /// Over the step, N·s on B; then its mean, N.
    pub impulse: Vector3<f64>,
    /// Force of the last solve that had the point, N on B.
    pub last: Vector3<f64>,
    /// The force that the next step starts from, N on B: the last, but the mean of both halves of a smooth step at rest. What
    /// rests would never come to rest by the second half alone: that makes good what the first misses, v½, and as the first of
    /// the next step it would miss −v½.
    pub next: Vector3<f64>,
    /// The point in that solve.
    pub point: GapPoint,
    /// The next of the pair's.
    following: Option<u32>,
}

/// The points that carried something, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(super) struct PointLoads {
    pub list: Vec<PointLoad>,
    /// The first and the last of each pair.
    ends: Vec<Option<[u32; 2]>>,
}

impl PointLoads {
    /// Leaves none of so many pairs.
    pub fn clear(&mut self, pairs: usize) {
        self.list.clear();
        self.ends.clear();
        self.ends.resize(pairs, None);
    }

    /// What a point of a pair carried, if it did.
    pub fn get(&self, pair: u32, feature: FeatureId) -> Option<&PointLoad> {
        self.position(pair, feature).map(|index| &self.list[index])
    }

    fn position(&self, pair: u32, feature: FeatureId) -> Option<usize> {
        let mut at = self.ends[pair as usize].map(|[first, _]| first);
        while let Some(index) = at {
            let load = &self.list[index as usize];
            if load.point.feature == feature {
                return Some(index as usize);
            }
            at = load.following;
        }
        None
    }

    /// Adds an impulse on a point, N·s on B. Of a solve over a time `forces` are the last, and what the next step starts from, N.
    pub fn add(&mut self, point: &GapPoint, impulse: &Vector3<f64>, forces: Option<[Vector3<f64>; 2]>) {
        let index = self.position(point.pair, point.feature).unwrap_or_else(|| self.begin(point));
        let load = &mut self.list[index];
        load.impulse += impulse;
        load.point.clone_from(point);
        if let Some(forces) = forces {
            [load.last, load.next] = forces;
        }
    }

    /// A point that has carried nothing yet, as the last of its pair.
    fn begin(&mut self, point: &GapPoint) -> usize {
        let (index, zero) = (self.list.len() as u32, Vector3::zeros());
        self.list.push(PointLoad { impulse: zero, last: zero, next: zero, point: point.clone(), following: None });
        let ends = &mut self.ends[point.pair as usize];
        match ends {
            Some([_, last]) => {
                self.list[*last as usize].following = Some(index);
                *last = index;
            }
            None => *ends = Some([index; 2]),
        }
        index as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_of_a_pair_has_its_own_load() {
        let point = |pair: u32, feature: u64| GapPoint {
            pair,
            feature: FeatureId(feature),
            ends: [0, 1],
            point: Vector3::zeros(),
            arms: [Vector3::zeros(); 2],
            normal: Vector3::y(),
            gap: 0.0,
            friction: 0.5,
        };
        let mut loads = PointLoads::default();
        loads.clear(3);
        let keys = [(0, 7), (2, 7), (0, 8), (2, 9), (0, 9), (0, 7), (2, 9)];
        for (order, &(pair, feature)) in keys.iter().enumerate() {
            let force = Vector3::x() * order as f64;
            loads.add(&point(pair, feature), &Vector3::y(), Some([force; 2]));
        }
        let found = |pair: u32, feature: u64| {
            loads.get(pair, FeatureId(feature)).map(|load| (load.impulse.y, load.last.x, load.point.pair))
        };
        assert_eq!(
            [found(0, 7), found(0, 8), found(0, 9)],
            [Some((2.0, 5.0, 0)), Some((1.0, 2.0, 0)), Some((1.0, 4.0, 0))]
        );
        assert_eq!([found(2, 7), found(2, 9)], [Some((1.0, 1.0, 2)), Some((2.0, 6.0, 2))]);
        assert_eq!([found(1, 7), found(0, 3), found(2, 8)], [None; 3]);
        assert_eq!(loads.list.len(), 5);
        loads.clear(1);
        assert!(loads.get(0, FeatureId(7)).is_none() && loads.list.is_empty());
    }
}
