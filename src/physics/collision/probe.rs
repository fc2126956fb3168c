//! How deep two placed colliders overlap, outside a step.

use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::manifold::PartPair;
use super::narrow::contact_pair::{self, PairSearch};
use super::parts::{is_mesh, near_parts};
use crate::physics::body::Body;
use crate::physics::shape::{Collider, Geometry, Shape};
use crate::physics::{Position, Rotation};

/// A collider at a pose, to ask what it overlaps without a step.
#[derive(Clone, Copy, Debug)]
pub struct PlacedCollider<'a> {
    /// The shape.
    pub collider: &'a Collider,
    /// Its centre of mass, m.
    pub position: Position,
    /// Its orientation.
    pub rotation: Rotation,
}

impl PlacedCollider<'_> {
    /// How deep two overlap, m, along the direction in which that is least (over a half-space: its
    /// normal; over a mesh: along normals of its triangles, what is over them); 0 where they only
    /// touch. None: they are apart, or both are half-spaces, which no depth measures, or one has a
    /// size or a pose that makes no sense.
    pub fn overlap(&self, other: &Self) -> Option<f64> {
        if !self.collider.is_valid() || !other.collider.is_valid() {
            return None;
        }
        if [self, other].iter().all(|placed| matches!(placed.collider.shape(), Shape::HalfSpace)) {
            return None;
        }
        let reach = self.collider.bounding_radius() + other.collider.bounding_radius();
        let distance = self.position.distance(other.position.0);
        if !distance.is_finite() || distance > reach {
            return None; // before a hull is built for nothing
        }
        let (mut a, mut b) = (self.body()?, other.body()?);
        if matches!(b.geometry, Some(Geometry::HalfSpace)) {
            std::mem::swap(&mut a, &mut b); // as in every pair of the broad phase
        }
        let (mut search, mut points, mut parts) = (PairSearch::default(), Vec::new(), Vec::new());
        near_parts([&a, &b], Some(&|_, _, _| 0.0), |_, _, _| 0.0, &mut parts);
        let is_over_mesh = is_mesh(&a) || is_mesh(&b);
        let mut depth_of = |&parts: &PartPair| {
            points.clear();
            search.last = None;
            let overlap = contact_pair::touch([&a, &b], parts, 0.0, &mut search, &mut points)?;
            // How far something reaches below a triangle's plane is more than how deep it is, where that is beside the triangle.
            let deepest = points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
            let depth = if is_over_mesh { overlap.depth.min(deepest) } else { overlap.depth };
            (depth >= 0.0).then_some(depth)
        };
        parts.iter().filter_map(&mut depth_of).max_by(f64::total_cmp)
    }

    /// Where its body would be, and how it is turned. None: its rotation is none.
    pub(crate) fn pose(&self) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
        let length = self.rotation.0.length();
        let rotation = || UnitQuaternion::new_unchecked((self.rotation.0 / length).into());
        (length > 0.0 && length.is_finite()).then(|| (self.position.0.into(), rotation()))
    }

    fn body(&self) -> Option<Body> {
        let (position, rotation) = self.pose()?;
        let (geometry, radius) = (Some(self.collider.geometry()), self.collider.bounding_radius());
        Some(Body { position, rotation, geometry, radius, ..Body::new(Entity::PLACEHOLDER) })
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DQuat, DVec3};

    use super::PlacedCollider;
    use crate::physics::{Collider, Position, Rotation};

    fn placed(collider: &Collider, position: DVec3) -> PlacedCollider<'_> {
        PlacedCollider { collider, position: Position(position), rotation: Rotation(DQuat::IDENTITY) }
    }

    fn shapes() -> [Collider; 5] {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        [
            Collider::half_space(),
            Collider::sphere(0.5),
            Collider::cuboid(1.0, 2.0, 3.0),
            Collider::cone(0.5, 1.0),
            Collider::convex_hull(&corners).expect("four corners that span a volume"),
        ]
    }

    #[test]
    fn two_half_spaces_overlap_by_no_depth() {
        let plane = Collider::half_space();
        for height in [-1.0, 0.0, 1.0] {
            assert_eq!(placed(&plane, DVec3::ZERO).overlap(&placed(&plane, DVec3::Y * height)), None);
        }
    }

    #[test]
    fn what_is_nowhere_overlaps_nothing() {
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX];
        for (one, other) in shapes().iter().flat_map(|one| shapes().map(|other| (one.clone(), other))) {
            let here = placed(&other, DVec3::ZERO);
            for number in numbers {
                let nowhere = placed(&one, DVec3::new(0.0, number, 0.0));
                for found in [nowhere.overlap(&here), here.overlap(&nowhere)] {
                    assert_eq!(found, None, "{one:?}, {other:?} at {number}");
                }
                for rotation in [DQuat::from_xyzw(number, 0.0, 0.0, 1.0), DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)] {
                    let twisted = PlacedCollider { rotation: Rotation(rotation), ..placed(&one, DVec3::ZERO) };
                    assert_eq!(twisted.overlap(&here), None, "{one:?} {rotation} {other:?}");
                    assert_eq!(here.overlap(&twisted), None, "{one:?} {rotation} {other:?}");
                }
            }
        }
    }

    #[test]
    fn a_ball_in_the_ground_overlaps_by_its_depth() {
        let (plane, ball) = (Collider::half_space(), Collider::sphere(0.5));
        let (plane, ball) = (placed(&plane, DVec3::ZERO), placed(&ball, DVec3::Y * 0.3));
        for found in [plane.overlap(&ball), ball.overlap(&plane)] {
            assert!((found.expect("it is in it") - 0.2).abs() < 1e-15);
        }
    }
}
