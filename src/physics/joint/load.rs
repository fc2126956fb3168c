//! What a joint carries.

use bevy::math::DVec3;
use bevy::prelude::*;

/// What a joint carried in the last step, measured from its multipliers λ: by `accurate`, joints without contacts, at the
/// step's end, unless a limit was hit in it; else its mean over the step. Add it to a joint entity to have it filled in.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct JointLoad {
    /// Force on body B at the joint, N, world axes.
    pub force: DVec3,
    /// Torque on body B about its anchor, N·m, world axes (zero for a ball joint).
    pub torque: DVec3,
    /// Euclidean norm |λ| of force and torque together: of a ball joint, of its force, N.
    pub lambda: f64,
}
