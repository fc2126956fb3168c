//! Where bodies touch, or may within a step, at the poses that they have.

use nalgebra::Vector3;

use super::super::mechanism::Motion;
use crate::physics::body::{Body, SurfaceMaterial};
use crate::physics::collision::{ContactPoint, FeatureId, Pair};
use crate::physics::collision::{PairSearch, touch};
use crate::physics::contact::namesake;

/// Two bodies in reach of each other.
#[derive(Clone, Debug)]
pub(super) struct Pairing {
    /// By their indices in the world.
    pub pair: Pair,
    /// By their places here.
    pub ends: [u32; 2],
    pub surface: SurfaceMaterial,
}

/// A point of a pair at the poses it was found at.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub pairing: u32,
    pub feature: FeatureId,
    pub ends: [u32; 2],
    /// In the world, m.
    pub point: Vector3<f64>,
    /// From the centres of mass, world axes.
    pub arms: [Vector3<f64>; 2],
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// m; negative: they overlap.
    pub gap: f64,
    pub friction: f64,
}

impl Site {
    /// How the point of B moves past that of A, m/s.
    pub fn velocity(&self, motion: &[Motion]) -> Vector3<f64> {
        let [a, b] = [0, 1].map(|end| point_velocity(&motion[self.ends[end] as usize], &self.arms[end]));
        b - a
    }

    /// How fast its gap opens, m/s.
    pub fn opening(&self, motion: &[Motion]) -> f64 {
        self.normal.dot(&self.velocity(motion))
    }
}

pub(super) fn point_velocity(motion: &Motion, arm: &Vector3<f64>) -> Vector3<f64> {
    motion.linear + motion.angular.cross(arm)
}

/// The sites of all pairings, in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct Sites {
    pub list: Vec<Site>,
    /// Of each pairing, where its sites begin; then their number.
    starts: Vec<u32>,
}

impl Sites {
    pub fn of(&self, pairing: usize) -> &[Site] {
        &self.list[self.starts[pairing] as usize..self.starts[pairing + 1] as usize]
    }

    /// The index of the same features' site.
    pub fn position(&self, pairing: u32, feature: FeatureId) -> Option<usize> {
        let pairing = pairing as usize;
        let at = namesake(self.of(pairing).iter().map(|site| site.feature), feature)?;
        Some(self.starts[pairing] as usize + at)
    }

    /// Finds them anew, up to the gap that each pairing is given.
    pub fn find(&mut self, pairings: &[Pairing], bodies: &[Body], gap: impl Fn(&Pairing) -> f64, finder: &mut Finder) {
        self.list.clear();
        self.starts.clear();
        for (index, pairing) in (0..).zip(pairings) {
            self.starts.push(self.list.len() as u32);
            let [a, b] = pairing.ends.map(|end| &bodies[end as usize]);
            finder.search.forget();
            finder.points.clear();
            let Some(overlap) = touch(a, b, gap(pairing), &mut finder.search, &mut finder.points) else { continue };
            self.list.extend(finder.points.iter().map(|point| Site {
                pairing: index,
                feature: point.feature,
                ends: pairing.ends,
                point: point.point,
                arms: [point.point - a.position, point.point - b.position],
                normal: overlap.normal,
                gap: -point.depth,
                friction: pairing.surface.friction,
            }));
        }
        self.starts.push(self.list.len() as u32);
    }
}

/// Buffers of the search.
#[derive(Default)]
pub(super) struct Finder {
    search: PairSearch,
    points: Vec<ContactPoint>,
}
