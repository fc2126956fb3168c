//! How far a runner may be off until it fails, as maps have it.

use crate::physics::{Diagnostics, RigidBody};
use crate::scene::SceneSpec;

/// Share of a body's smallest extent, or of a limb, by which a runner may be off at most.
const FAILS_FROM: f64 = 0.1;

/// What fails a runner, m.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    overlap: f64,
    joint_gap: f64,
}

impl Limits {
    /// For a scene.
    pub fn of(scene: &SceneSpec) -> Self {
        let least = |sizes: &mut dyn Iterator<Item = f64>| sizes.fold(f64::INFINITY, f64::min);
        let moving = scene.bodies.iter().filter(|body| body.kind == RigidBody::Dynamic);
        let overlap = least(&mut moving.filter_map(|body| Some(body.shape.as_ref()?.smallest_extent())));
        let ends = scene.joints.iter().flat_map(|joint| [&joint.body_a, &joint.body_b]);
        let diameter = |name: &String| {
            let body = scene.bodies.iter().find(|body| body.name == *name)?;
            Some(2.0 * body.shape.as_ref()?.bounding_radius()).filter(|diameter| diameter.is_finite())
        };
        let joint_gap = least(&mut ends.filter_map(diameter));
        Self { overlap: FAILS_FROM * overlap, joint_gap: FAILS_FROM * joint_gap }
    }

    /// Why that fails, if it does.
    pub fn failure(&self, measured: &Diagnostics) -> Option<String> {
        if measured.penetration > self.overlap {
            Some(format!("bodies overlap by {:.2} m", measured.penetration))
        } else if measured.joint_error > self.joint_gap {
            Some(format!("a joint parts by {:.2} m", measured.joint_error))
        } else {
            None
        }
    }

    /// Why a body so far from where the answer has it, m, fails, if it does.
    pub(super) fn far_from_answer(&self, distance: f64) -> Option<String> {
        (distance > self.overlap).then(|| format!("{distance:.2} m from the answer"))
    }
}
