//! How the frames of a joint lie in its bodies.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::UnitQuaternion;

/// The frames of a joint, whose x is its axis. What is given as axes becomes frames when the joint is first seen, from
/// the poses that its bodies then have: there its coordinates are zero.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum JointAxes {
    /// An axis of the world, of any length but 0.
    World(DVec3),
    /// An axis of A and one of B, in their bodies' axes.
    Bodies(DVec3, DVec3),
    /// Rotations from the axes of the frames to the axes of A and of B.
    Frames(DQuat, DQuat),
}

impl JointAxes {
    /// Whether its axes have a direction.
    pub(crate) fn is_valid(&self) -> bool {
        let is_axis = |axis: &DVec3| axis.is_finite() && *axis != DVec3::ZERO;
        match self {
            Self::World(axis) => is_axis(axis),
            Self::Bodies(a, b) => is_axis(a) && is_axis(b),
            Self::Frames(a, b) => [a, b].iter().all(|frame| (frame.length() - 1.0).abs() < 1e-6),
        }
    }

    /// As frames, for bodies in those rotations.
    pub fn frames(&self, rotations: [DQuat; 2]) -> [DQuat; 2] {
        let [a, b] = rotations;
        match *self {
            Self::Frames(a, b) => [a, b],
            Self::World(axis) => {
                let frame = frame_along(axis);
                [a.inverse() * frame, b.inverse() * frame]
            }
            Self::Bodies(of_a, of_b) => {
                let frame = a * frame_along(of_a);
                let swing = DQuat::from_rotation_arc((frame * DVec3::X).normalize(), (b * of_b).normalize());
                [frame_along(of_a), (b.inverse() * swing * frame).normalize()]
            }
        }
    }

    /// [`Self::frames`] as a solver has them.
    pub(crate) fn rotations(&self, rotations: [DQuat; 2]) -> [UnitQuaternion<f64>; 2] {
        self.frames(rotations).map(|frame| UnitQuaternion::new_normalize(frame.into()))
    }
}

/// A rotation that takes x to an axis.
fn frame_along(axis: DVec3) -> DQuat {
    // As multiples of the largest component: squares of very large or small ones leave f64's range.
    DQuat::from_rotation_arc(DVec3::X, (axis / axis.abs().max_element()).normalize())
}
