//! Scenes in equilibrium: any motion is error.

use crate::scene::SceneSpec;

use super::super::run::Sample;
use super::{Poses, Truth, dynamic};

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    // Gravity turned out of the plane of a joint grid makes it swing.
    if scene.gravity.x != 0.0 || scene.gravity.z != 0.0 {
        return None;
    }
    let starts: Vec<_> = dynamic(scene).into_iter().map(|index| (index, scene.bodies[index].position)).collect();
    let distance = move |sample: &Sample| {
        let moves = starts.iter().map(|(index, start)| sample.bodies[*index].position.distance(*start));
        Some(moves.fold(0.0, f64::max))
    };
    Some(Truth::largest("largest move of a body that should stay", "m", distance).that_stays())
}

/// Every body where it starts.
pub(super) fn poses(scene: &SceneSpec) -> Poses {
    let start = |index: usize| (index, scene.bodies[index].position, scene.bodies[index].rotation);
    let starts: Vec<_> = dynamic(scene).into_iter().map(start).collect();
    Box::new(move |_| starts.clone())
}
