//! What statics says of the forces in a scene at rest: those that cross a level between two
//! heights of centres add up, vertically, to the weight of all that they carry.
//!
//! That holds whatever the forces in between, and where statics leaves them undetermined too.

use bevy::math::DVec3;

use crate::physics::RigidBody;
use crate::scene::{BodySpec, SceneSpec};

/// Weights by level.
#[derive(Clone, Debug, PartialEq)]
pub struct Statics {
    up: DVec3,
    /// Of each body, counted from the support; none: it does not move and is the support.
    levels: Vec<Option<usize>>,
    /// The weight that rests on, or hangs below, each cut: the first is the support's, N.
    carried: Vec<f64>,
}

/// Centres less than this apart in height, m, are at one level.
const SAME_LEVEL: f64 = 1e-6;

impl Statics {
    /// None where bodies are carried from above and from below, or something but gravity pulls.
    pub(super) fn of(scene: &SceneSpec) -> Option<Self> {
        let up = -scene.gravity.try_normalize()?;
        let height = |body: &BodySpec| body.position.dot(up);
        let is_dynamic = |body: &&BodySpec| body.kind == RigidBody::Dynamic;
        let (moving, fixed): (Vec<_>, Vec<_>) = scene.bodies.iter().partition(is_dynamic);
        let lowest = |bodies: &[&BodySpec]| bodies.iter().copied().map(height).fold(f64::INFINITY, f64::min);
        let highest = |bodies: &[&BodySpec]| bodies.iter().copied().map(height).fold(f64::NEG_INFINITY, f64::max);
        let stands = highest(&fixed) < lowest(&moving);
        let hangs = lowest(&fixed) > highest(&moving);
        if stands == hangs || scene.bodies.iter().any(|body| body.force != DVec3::ZERO || body.gravity_scale != 1.0) {
            return None;
        }
        let from_support = |body: &BodySpec| if stands { height(body) } else { -height(body) };
        let mut heights: Vec<f64> = moving.into_iter().map(from_support).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|next, kept| *next - *kept < SAME_LEVEL);
        let level = |body: &BodySpec| heights.partition_point(|&height| height < from_support(body) - SAME_LEVEL);
        let levels: Vec<Option<usize>> =
            scene.bodies.iter().map(|body| is_dynamic(&body).then(|| level(body))).collect();
        let mut carried = vec![0.0; heights.len()];
        for (body, level) in scene.bodies.iter().zip(&levels) {
            let Some(level) = *level else { continue };
            let weight = mass(body)? * scene.gravity.length();
            carried[..=level].iter_mut().for_each(|carried| *carried += weight);
        }
        Some(Self { up, levels, carried })
    }

    /// The largest share of the weight carried that the forces across a cut are off by. `forces`
    /// are those of contacts and joints: body A, body B by their places in the scene, and the
    /// force on B.
    pub fn error(&self, forces: impl IntoIterator<Item = (usize, usize, DVec3)>) -> f64 {
        // What each cut's forces are more than those of the cut before.
        let mut steps = vec![0.0; self.carried.len() + 1];
        for (a, b, force) in forces {
            let lift = force.dot(self.up);
            // Cuts 0 to the level lie between a body and the support.
            let [cuts_a, cuts_b] = [a, b].map(|body| self.levels[body].map_or(0, |level| level + 1));
            let (fewer, more, on_outer) =
                if cuts_a < cuts_b { (cuts_a, cuts_b, lift) } else { (cuts_b, cuts_a, -lift) };
            steps[fewer] += on_outer;
            steps[more] -= on_outer;
        }
        let mut across = 0.0;
        let errors = self.carried.iter().zip(&steps).map(|(carried, step)| {
            across += step;
            (across - carried).abs() / carried
        });
        errors.fold(0.0, f64::max)
    }
}

fn mass(body: &BodySpec) -> Option<f64> {
    body.mass.or_else(|| Some(body.density * body.shape.as_ref()?.volume()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    fn statics(scene: &str, parameters: &[(&str, f64)]) -> Statics {
        let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        Statics::of(&load(scene, &parameters).expect("a scene")).expect("a scene at rest")
    }

    #[test]
    fn cuts_carry_what_is_above_or_hangs_below() {
        let close = |statics: &Statics, expected: &[f64]| {
            assert_eq!(statics.carried.len(), expected.len());
            for (carried, expected) in statics.carried.iter().zip(expected) {
                assert!((carried / expected - 1.0).abs() < 1e-14, "{carried} N, not {expected} N");
            }
        };
        // Cubes of a tonne under g = 10: rows of 3, 2 and 1.
        close(&statics("pyramid", &[("n", 3.0)]), &[6e4, 3e4, 1e4]);
        close(&statics("sandwich", &[("r", 100.0)]), &[1020.0, 1000.0]);
        close(&statics("hanging", &[("n", 3.0)]), &[30.0, 20.0, 10.0]);
        // Two rows of 3 balls of radius 0.4 hang from one that does not move.
        let ball = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.4_f64.powi(3) * 10.0;
        close(&statics("joint_grid", &[("n", 3.0)]), &[6.0 * ball, 3.0 * ball]);
    }

    #[test]
    fn forces_that_balance_have_no_error_and_others_have_theirs() {
        let statics = statics("pyramid", &[("n", 2.0)]);
        // Bodies: ground, two cubes of the lower row, the upper one. Halves go either way; the
        // lower two push each other apart.
        let up = |newtons: f64| newtons * DVec3::Y;
        let balanced = [
            (0, 1, up(16e3)),
            (0, 2, up(14e3)),
            (1, 3, up(6e3)),
            (3, 2, up(-4e3) + 100.0 * DVec3::X),
            (1, 2, 500.0 * DVec3::X + up(70.0)),
        ];
        assert!(statics.error(balanced) < 1e-15);
        let mut unbalanced = balanced;
        unbalanced[2].2.y += 500.0;
        assert!((statics.error(unbalanced) - 0.05).abs() < 1e-15, "{}", statics.error(unbalanced));
        // The same from below: 300 N too little carry 30 kN.
        let mut sinking = balanced;
        sinking[1].2.y -= 300.0;
        assert!((statics.error(sinking) - 0.01).abs() < 1e-15);
        assert_eq!(statics.error([]), 1.0);
    }

    #[test]
    fn a_joint_carries_what_hangs_below_it() {
        let statics = statics("hanging", &[("n", 3.0)]);
        let hang = |off: f64| {
            let joint = |a, b, newtons: f64| (a, b, newtons * DVec3::Y);
            // The second given the other way round: the force on its upper body.
            statics.error([joint(0, 1, 30.0), joint(2, 1, -20.0 - off), joint(2, 3, 10.0)])
        };
        assert!(hang(0.0) < 1e-15);
        assert!((hang(1.0) - 0.05).abs() < 1e-15, "{}", hang(1.0));
    }

    #[test]
    fn what_is_held_from_both_sides_is_left_alone() {
        let mut scene = load("stack", &[("n".to_owned(), 2.0)]).expect("a scene");
        scene.bodies.push(BodySpec::pin("hook", DVec3::new(0.0, 9.0, 0.0)));
        assert_eq!(Statics::of(&scene), None);
        let top = load("top", &[]).expect("a scene");
        assert_eq!(Statics::of(&top), None, "no gravity");
    }
}
