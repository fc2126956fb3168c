//! Figures that fall: whatever else they do, limits and hinges hold.

use crate::scene::SceneSpec;

use super::answer::Truth;
use super::{hinges, limits};

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    Some(limits::overshoot(scene)?.and(hinges::tilt(scene)))
}
