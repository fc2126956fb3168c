//! How far joints go beyond their limits.

use bevy::math::{DQuat, DVec3};

use crate::scene::{JointSpec, LimitSpec, SceneSpec};

use super::answer::Truth;
use super::bodies::{joined, twist, wrapped};
use crate::lab::simulation::Sample;

/// A joint with limits of angles.
struct Limited {
    bodies: [usize; 2],
    frames: [DQuat; 2],
    limits: LimitSpec,
    /// The angle over all turns, rad.
    angle: f64,
}

impl Limited {
    /// How far it is beyond its limits, rad; negative within them.
    fn overshoot(&mut self, sample: &Sample) -> f64 {
        let [a, b] = [0, 1].map(|end| sample.bodies[self.bodies[end]].rotation * self.frames[end]);
        let turn = a.inverse() * b;
        self.angle += wrapped(twist(turn, DVec3::X) - self.angle);
        let LimitSpec { swing, min, max, .. } = self.limits;
        let of_swing =
            swing.map_or(f64::NEG_INFINITY, |most| 2.0 * turn.y.hypot(turn.z).atan2(turn.w.hypot(turn.x)) - most);
        of_swing.max(min - self.angle).max(self.angle - max)
    }
}

/// The largest angle by which a hinge or a ball joint is beyond its limits; none where no joint has any. Of any
/// scene, built in or not.
pub fn overshoot(scene: &SceneSpec) -> Option<Truth> {
    let limited = |(joint, bodies): (&JointSpec, [usize; 2])| {
        let frames = joint.axes.frames(bodies.map(|body| scene.bodies[body].rotation));
        Some(Limited { bodies, frames, limits: joint.limits?, angle: joint.coordinate })
    };
    let mut joints: Vec<Limited> = joined(scene).filter_map(limited).collect();
    if joints.is_empty() {
        return None;
    }
    let distance =
        move |sample: &Sample| Some(joints.iter_mut().map(|joint| joint.overshoot(sample)).fold(0.0, f64::max));
    Some(Truth::largest("overshoot of limits", "rad", distance).failing_above(FAILS_ABOVE))
}

/// What looks broken, rad.
const FAILS_ABOVE: f64 = 0.2;
