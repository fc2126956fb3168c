//! The soft step: substeps with soft constraints (Catto 2024, *Solver2D*; Macklin et al. 2019 for
//! substeps instead of sweeps).
//!
//! Each substep: forces and last impulses → sweep with springs → positions → sweep without. The
//! springs mend position errors without stiffness a sweep cannot follow; the second sweep, *relax*,
//! takes their push out of the velocities again, so that it adds no energy. Bounces come last.

use super::impulse::{Color, GroupTerms, SoftTerms, Stage, UNLIMITED};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;

/// Natural frequency of contacts over substeps a second. What a sweep can follow is about a quarter (Catto 2024);
/// stiffer, large walls tremble, softer, columns buckle (30 Hz lets `stack 20` fall, at 45 Hz 30 cubes stand).
const CONTACT_FREQUENCY: f64 = 0.1875;
/// Damping ratio of contacts: they must not bounce. Less lets them ring, more lets columns creep.
const CONTACT_DAMPING: f64 = 5.0;
/// Natural frequency of joints over substeps a second.
const JOINT_FREQUENCY: f64 = 0.25;
/// Damping ratio of joints.
const JOINT_DAMPING: f64 = 2.0;

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings) -> GroupTerms<L> {
    let h = settings.step() / f64::from(settings.substeps);
    let push = settings.correction_speed.unwrap_or(UNLIMITED);
    let soft = |share: f64, damping, slop| SoftTerms::new(share / h, damping, push, slop, h);
    GroupTerms {
        h,
        substeps: settings.substeps,
        joint: soft(JOINT_FREQUENCY, JOINT_DAMPING, 0.0),
        contact: soft(CONTACT_FREQUENCY, CONTACT_DAMPING, settings.slop),
        restitution_speed: settings.restitution_speed.unwrap_or(UNLIMITED),
    }
}

/// What the stages of a group's step depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub substeps: u32,
    pub iterations: u32,
    /// Whether some contact may bounce, or forces are read.
    pub notes: bool,
    /// Whether bodies turn so far that rows must be made anew in each substep.
    pub turns_far: bool,
}

impl Plan {
    /// All stages of a step, for a group of these colours.
    pub fn stages(&self, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
        stages.clear();
        stages.extend([Stage::Fly, Stage::Swing]);
        if colors.clone().next().is_none() {
            return;
        }
        let (parts, substeps) = if self.turns_far { (self.substeps, 1) } else { (1, self.substeps) };
        for _ in 0..parts {
            self.part(substeps, colors.clone(), stages);
        }
    }

    /// Substeps with the rows of the first one's poses.
    fn part(&self, substeps: u32, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
        stages.push(Stage::Gather { substeps });
        stages.extend(colors.clone().map(Stage::Prepare));
        for substep in 0..substeps {
            let is_first = substep == 0;
            stages.push(Stage::Begin { is_first });
            if is_first {
                stages.extend(colors.clone().map(Stage::WarmStart));
            }
            let sweep = |soft| {
                let colors = colors.clone();
                (0..self.iterations).flat_map(move |_| colors.clone().map(move |color| Stage::Solve { color, soft }))
            };
            stages.extend(sweep(true));
            stages.push(Stage::Drift);
            stages.extend(sweep(false));
            if self.notes {
                stages.extend(colors.clone().map(Stage::Note));
            }
            stages.push(Stage::End);
        }
        if self.notes {
            stages.extend(colors.clone().map(Stage::Bounce));
        }
        stages.push(Stage::Scatter);
        stages.extend(colors.map(Stage::Store));
    }
}
