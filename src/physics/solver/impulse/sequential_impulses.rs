//! Sequential impulses (Catto 2006, *Fast and Simple Physics using Sequential Impulses*): velocities solved with
//! the impulses of the step before as a start, positions mended on their own.
//!
//! Each substep: forces → last impulses → sweeps over velocities, without any bias but that of gaps → positions →
//! sweeps over positions.
//!
//! **Velocities.** Each update makes one row's velocity zero, accumulated impulses clamped: λ ← max(0, λ − m v_n),
//! friction within its disc. A point across a gap s may close it, v_n ≥ −s/h. No error of a position is in it, so
//! that none becomes energy.
//!
//! **Positions**, by nonlinear Gauss–Seidel (the 2009 engine's *nonlinear projection*): with the same rows, and C the
//! error of the poses as they are by now, an update moves the bodies by M⁻¹Jᵀ(−m β C), C = min(0, s + slop) of a
//! contact's point and the whole of a joint's separation. Nothing is accumulated and no velocity learns of it.
//! Where bodies on joints turn, rows are made anew for the poses after the drift, so that what a turn θ of an arm r
//! parts to second order, ½ r θ², is seen.
//!
//! **Good at** loops and grids of joints at rest (`joint_grid 30` ends closed), little sinking for many sweeps (30
//! sweeps: `stack 10` 1.6 mm, `sandwich 100` 2 mm, of which the slop is most), houses of cards, and momentum: with one
//! substep a collision without bounce keeps it to rounding. **Bad at** whatever a sweep must carry far: with 10 sweeps
//! `stack 30` falls and `pyramid 40` spreads by metres, with 30 by 0.7 m; a chain under 100 times its links' weight
//! parts by 0.2 m; what swings loses energy, `chain 100` a sixth in 4 s.

use super::{Color, GroupTerms, Plan, Stage, Sweep};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};
use crate::physics::solver::substeps::Substeps;

/// Sweeps over positions in a substep.
pub(crate) const POSITION_SWEEPS: u32 = 3;

/// Share of a contact's error that an update mends. Neighbours mend it too: all of it would be too much.
const CONTACT_SHARE: f64 = 0.1;

/// Share of a joint's error that an update mends.
const JOINT_SHARE: f64 = 1.0;

/// Turn in a step beyond which rows of joints turn along, rad: by then they miss 5e-5 of a limb.
const FAR: f64 = 0.01;

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings) -> GroupTerms<L> {
    let h = settings.step() / f64::from(settings.substeps);
    let without_bias = SoftTerms::rigid(0.0, UNLIMITED, 0.0, h);
    GroupTerms {
        h,
        substeps: Substeps::of(settings),
        joint: without_bias,
        contact: without_bias,
        projection: Some(Projection {
            contact: L::of(CONTACT_SHARE),
            joint: L::of(JOINT_SHARE),
            most: L::of(settings.correction_speed.map_or(UNLIMITED, |speed| speed * h)),
            slop: L::of(settings.slop),
        }),
        restitution_speed: settings.restitution_speed.unwrap_or(UNLIMITED),
    }
}

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    let project = |stages: &mut Vec<Stage>| {
        for _ in 0..POSITION_SWEEPS {
            stages.extend(colors.clone().map(Stage::Project));
        }
    };
    let turns = plan.turns_over(FAR);
    for part in plan.parts(turns) {
        plan.part(part, colors.clone(), stages, |is_first, stages| {
            stages.push(Stage::Begin { is_first });
            if is_first {
                stages.extend(colors.clone().map(Stage::WarmStart));
            }
            plan.sweeps(Sweep::Whole, colors.clone(), stages);
            stages.push(Stage::Drift);
            if !turns {
                project(stages);
            }
        });
        if turns {
            stages.push(Stage::Gather { substeps: 0, done: part.0 + 1 });
            stages.extend(colors.clone().map(Stage::Prepare));
            project(stages);
            stages.push(Stage::Scatter);
        }
    }
}
