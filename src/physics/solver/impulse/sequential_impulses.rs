//! Sequential impulses (Catto 2006, *Fast and Simple Physics using Sequential Impulses*): velocities solved with
//! the impulses of the step before as a start, positions corrected on their own.
//!
//! Each substep: forces → last impulses → sweeps over velocities, without any bias but that of gaps → positions →
//! sweeps over positions.
//!
//! **Velocities.** Each update makes one row's velocity zero, accumulated impulses clamped: λ ← max(0, λ − m v_n),
//! friction within its disc. A point across a gap s may close it, v_n ≥ −s/h. No position error enters the velocities,
//! so that none becomes energy.
//!
//! **Positions**, by nonlinear Gauss–Seidel (the 2009 engine's *nonlinear projection*): with the same rows, and C the
//! error of the poses as they are by now, an update moves the bodies by M⁻¹Jᵀ(−m β C), C = min(0, s + slop) of a
//! contact point and the whole of a joint's separation. Nothing is accumulated and no velocity changes.
//! Where bodies on joints turn, rows are made anew for the poses after the drift, so that what a turn θ of an arm r
//! parts to second order, ½ r θ², is seen.
//!
//! **Good at** loops and grids of joints at rest (`joint_grid 30` ends closed), little sinking for many sweeps (30
//! sweeps: `stack 10` 1.6 mm, `sandwich 100` 2 mm, of which the slop is most), houses of cards, and momentum: with one
//! substep a collision without bounce keeps it to rounding. **Bad at** whatever a sweep must carry far: with 10 sweeps
//! `stack 30` falls and `pyramid 40` spreads by metres, with 30 by 0.7 m; a chain under 100 times its links' weight
//! parts by 0.2 m; what swings loses energy, `chain 100` a sixth in 4 s.

use super::coloring::Color;
use super::constants::{CONTACT_SHARE, JOINT_SHARE, POSITION_SWEEPS, SEQUENTIAL_IMPULSES_TURN};
use super::stage::{GroupTerms, Plan, Stage, Sweep};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{Projection, UNLIMITED};

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings, time: f64) -> GroupTerms<L> {
    let rigid = GroupTerms::new(settings, time);
    GroupTerms {
        projection: Some(Projection {
            contact_share: L::of(CONTACT_SHARE),
            joint_share: L::of(JOINT_SHARE),
            max_correction: L::of(settings.correction_speed.map_or(UNLIMITED, |speed| speed * rigid.h)),
            slop: L::of(settings.slop),
        }),
        ..rigid
    }
}

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    let project = |stages: &mut Vec<Stage>| {
        for _ in 0..POSITION_SWEEPS {
            stages.extend(colors.clone().map(Stage::Project));
        }
    };
    let turns = plan.turns_over(SEQUENTIAL_IMPULSES_TURN);
    for interval in plan.intervals(turns) {
        plan.interval(interval, colors.clone(), stages, |is_first, stages| {
            plan.begin(is_first, colors.clone(), stages);
            plan.sweeps(Sweep::SoftWithFriction, colors.clone(), stages);
            plan.drift(stages);
            if !turns {
                project(stages);
            }
        });
        if turns {
            let done = interval.0 + 1;
            stages.push(Stage::Gather { substeps: 0, done });
            stages.extend(colors.clone().map(|color| Stage::Prepare { color, done }));
            project(stages);
            stages.push(Stage::Scatter);
        }
    }
}
