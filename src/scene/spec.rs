//! The data of a scene. Plain numbers in SI; [`SceneSpec::validate`] says what they may be.

use std::f64::consts::PI;

use bevy::math::DVec3;

use super::{BodySpec, JointSpec, ProbeSpec};

/// Most bodies that a scene may have.
pub const MAX_BODIES: usize = 100_000;

/// A whole scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// What it is called: the built-in name, or the file's stem.
    pub name: String,
    /// m/s².
    pub gravity: DVec3,
    /// Bodies, in the order in which they are spawned.
    pub bodies: Vec<BodySpec>,
    /// Joints between them.
    pub joints: Vec<JointSpec>,
    /// Where a camera best looks from.
    pub view: Option<ViewSpec>,
    /// What is plotted, trailed or measured in a window.
    pub probes: Vec<ProbeSpec>,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSpec {
    /// Where it is, m.
    pub eye: DVec3,
    /// What it looks at, m.
    pub target: DVec3,
}

impl SceneSpec {
    /// An empty scene.
    pub fn new(name: impl Into<String>, gravity: DVec3) -> Self {
        Self { name: name.into(), gravity, bodies: Vec::new(), joints: Vec::new(), view: None, probes: Vec::new() }
    }
}

impl ViewSpec {
    /// Looks at `target` from the side that `direction` points to, from as far as it takes to see
    /// a ball of that radius whole through a lens of 45°.
    pub fn framing(target: DVec3, radius: f64, direction: DVec3) -> Self {
        let distance = radius / (PI / 8.0).sin();
        Self { eye: target + distance * direction.normalize(), target }
    }
}
