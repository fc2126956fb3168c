//! Dominoes fall one after the other, and all of them.

use std::f64::consts::FRAC_1_SQRT_2;

use bevy::math::DVec3;

use crate::scene::SceneSpec;

use super::super::run::Sample;
use super::{Truth, dynamic};

/// Sine of the tilt at which a domino counts as fallen: 45°, four times where it would balance on
/// its edge, and well before 66°, where it comes to rest on the next.
const FALLEN: f64 = FRAC_1_SQRT_2;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let dominoes = dynamic(scene);
    let first = &scene.bodies[*dominoes.first()?];
    let up = first.rotation * DVec3::Y;
    let onward = DVec3::new(up.x, 0.0, up.z).try_normalize()?;
    let mut fallen = vec![false; dominoes.len()];
    let mut out_of_turn = 0;
    let distance = move |sample: &Sample| {
        for (place, &body) in dominoes.iter().enumerate() {
            let falls = !fallen[place] && (sample.bodies[body].rotation * DVec3::Y).dot(onward) > FALLEN;
            fallen[place] |= falls;
            // Those before it have had their turn, this step's included.
            out_of_turn += u32::from(falls && !fallen[..place].iter().all(|&before| before));
        }
        let standing = fallen.iter().filter(|&&fallen| !fallen).count() as f64;
        Some(standing + f64::from(out_of_turn))
    };
    Some(Truth::last("dominoes that stand or fell out of turn", "dominoes", distance))
}
