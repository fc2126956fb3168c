//! How far joints go beyond their limits.

use crate::scene::{JointSpec, LimitSpec, SceneSpec};

use super::answer::Truth;
use crate::lab::angle::wrapped;
use crate::lab::joined::{Joined, joined};
use crate::lab::simulation::Sample;

/// A joint with limits of angles.
struct Limited {
    joined: Joined,
    limits: LimitSpec,
    /// The angle over all turns, rad.
    angle: f64,
}

impl Limited {
    /// How far it is beyond its limits, rad; negative within them.
    fn overshoot(&mut self, sample: &Sample) -> f64 {
        let relative = self.joined.relative(sample.bodies);
        self.angle += wrapped(relative.twist() - self.angle);
        self.limits.swing.map_or(f64::NEG_INFINITY, |most| relative.swing() - most).max(self.limits.beyond(self.angle))
    }
}

/// The largest angle by which a hinge or a ball joint is beyond its limits; none where no joint has any. Of any
/// scene, built in or not.
pub fn overshoot(scene: &SceneSpec) -> Option<Truth> {
    let limited = |(joint, bodies): (&JointSpec, [usize; 2])| {
        let limits = joint.limits?;
        Some(Limited { joined: Joined::of(joint, bodies, scene), limits, angle: joint.coordinate })
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
