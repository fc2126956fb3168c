//! Joined bodies as their joint sees them: where B's frame is, seen from A's.

use std::collections::HashMap;

use bevy::math::{DQuat, DVec3};

use super::angle::twist;
use crate::physics::{BodyState, JointAxis};
use crate::scene::{JointSpec, SceneSpec};

/// The bodies and frames of a joint, in the axes that the bodies are simulated in.
pub(super) struct Joined {
    /// A and B, by their places in the scene.
    pub bodies: [usize; 2],
    anchors: [DVec3; 2],
    frames: [DQuat; 2],
}

/// Where B's frame is, seen from A's.
pub(super) struct Relative {
    /// From A's anchor to B's, in the axes of A's frame, m.
    pub apart: DVec3,
    /// From the axes of B's frame to those of A's.
    pub turn: DQuat,
}

impl Joined {
    /// Of a joint between bodies in those places of a scene.
    pub fn of(joint: &JointSpec, bodies: [usize; 2], scene: &SceneSpec) -> Self {
        let ends = bodies.map(|body| &scene.bodies[body]);
        // A hull is given in axes of its own, and simulated in its principal ones.
        let into = ends.map(|end| end.shape.as_ref().map_or(DQuat::IDENTITY, |shape| shape.axes().inverse()));
        let frames = joint.axes.frames(ends.map(|end| end.rotation));
        Self {
            bodies,
            anchors: [into[0] * joint.anchor_a, into[1] * joint.anchor_b],
            frames: [into[0] * frames[0], into[1] * frames[1]],
        }
    }

    /// In a state of the scene's bodies.
    pub fn relative(&self, states: &[BodyState]) -> Relative {
        let [a, b] = self.bodies.map(|body| &states[body]);
        let [frame_a, frame_b] = [a.rotation * self.frames[0], b.rotation * self.frames[1]];
        // The difference of the centres first: far from the origin it is exact, where the anchors' is not.
        let apart = b.position - a.position + b.rotation * self.anchors[1] - a.rotation * self.anchors[0];
        Relative { apart: frame_a.inverse() * apart, turn: frame_a.inverse() * frame_b }
    }
}

impl Relative {
    /// The twist about x, rad, −π to π.
    pub fn twist(&self) -> f64 {
        twist(self.turn, DVec3::X)
    }

    /// The angle between A's x and B's x, rad, 0 to π.
    pub fn swing(&self) -> f64 {
        let DQuat { x, y, z, w } = self.turn;
        2.0 * y.hypot(z).atan2(w.hypot(x))
    }

    /// The angle of the whole turn, rad, 0 to π.
    pub fn angle(&self) -> f64 {
        2.0 * self.turn.xyz().length().atan2(self.turn.w.abs())
    }

    /// One of the coordinates that limits may be of, rad or m.
    pub fn coordinate(&self, axis: JointAxis) -> f64 {
        match axis {
            JointAxis::X => self.apart.x,
            JointAxis::Y => self.apart.y,
            JointAxis::Z => self.apart.z,
            JointAxis::Twist => self.twist(),
            JointAxis::Swing => self.swing(),
            JointAxis::Distance => self.apart.length(),
        }
    }
}

/// Each joint of a scene with the places of its bodies A and B.
pub(super) fn joined(scene: &SceneSpec) -> impl Iterator<Item = (&JointSpec, [usize; 2])> {
    let places: HashMap<&str, usize> = scene.bodies.iter().map(|body| body.name.as_str()).zip(0..).collect();
    let bodies = move |joint: &JointSpec| {
        let place = |name: &str| places.get(name).copied();
        Some([place(&joint.body_a)?, place(&joint.body_b)?])
    };
    scene.joints.iter().filter_map(move |joint| Some((joint, bodies(joint)?)))
}
