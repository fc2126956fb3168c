//! Dominoes fall one after the other, and all of them.

use std::f64::consts::FRAC_1_SQRT_2;

use bevy::math::DVec3;

use crate::scene::SceneSpec;

use super::answer::Truth;
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

/// Sine of the tilt at which a domino counts as fallen: 45°, four times where it would balance on
/// its edge, and well before 66°, where it comes to rest on the next.
const FALLEN: f64 = FRAC_1_SQRT_2;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let dominoes = dynamic(scene);
    let first = &scene.bodies[*dominoes.first()?];
    let up = first.rotation * DVec3::Y;
    let onward = DVec3::new(up.x, 0.0, up.z).try_normalize()?;
    let row = Row { fallen: vec![false; dominoes.len()], out_of_turn: 0, dominoes, onward };
    let mut order = row.clone();
    let mut row = row;
    let distance = move |sample: &Sample| {
        row.observe(sample);
        let standing = row.fallen.iter().filter(|&&fallen| !fallen).count() as f64;
        Some(standing + f64::from(row.out_of_turn))
    };
    let out_of_turn = Truth::largest("dominoes that fell out of turn", "dominoes", move |sample| {
        order.observe(sample);
        Some(f64::from(order.out_of_turn))
    });
    let truth = Truth::last("dominoes that stand or fell out of turn", "dominoes", distance);
    Some(truth.with_uncertainty(0.0).and(out_of_turn.with_uncertainty(0.0).failing_above(0.5)))
}

/// Which have fallen so far.
#[derive(Clone)]
struct Row {
    dominoes: Vec<usize>,
    onward: DVec3,
    fallen: Vec<bool>,
    out_of_turn: u32,
}

impl Row {
    fn observe(&mut self, sample: &Sample) {
        for (place, &body) in self.dominoes.iter().enumerate() {
            let up = sample.bodies[body].rotation * DVec3::Y;
            let falls = !self.fallen[place] && up.dot(self.onward) > FALLEN;
            self.fallen[place] |= falls;
            // Those before it have had their turn, this step's included.
            self.out_of_turn += u32::from(falls && !self.fallen[..place].iter().all(|&before| before));
        }
    }
}
