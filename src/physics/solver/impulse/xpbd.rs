//! Extended position-based dynamics with small steps (Müller, Macklin, Chentanez, Jeschke and Kim 2020, *Detailed
//! Rigid Body Simulation with Extended Position Based Dynamics*).
//!
//! Each substep: forces → positions solved → velocities from how far bodies moved → velocities of contacts solved.
//! Nothing is remembered of the substep before; substeps take the place of sweeps (Macklin et al. 2019).
//!
//! **Positions as velocities.** Their method predicts x* = x + h v, then moves each pair by M⁻¹Jᵀ Δλ,
//! Δλ = −(C(x) + α̃ λ)/(w + α̃), w = J M⁻¹Jᵀ, α̃ = α/h², and ends with v = (x − x_before)/h. Seen from the pose before,
//! with rows of the start of the substep, C(x) = C(x_before) + h J v: to move by Δx is to change v by Δx/h, and with
//! the impulse Λ = λ/h the update reads, for α = 0, Λ ← max(0, Λ − m (J v + C(x_before)/h)). That is the row of
//! [`crate::physics::solver::impulse`] with the bias C/h and Λ from zero, and the drift after it is the prediction and all moves at
//! once. What is deep already is pushed out no faster than the settings' `correction_speed`. Gradients are those of
//! the start of the substep, not of the prediction, as in SHAKE.
//!
//! **Compliance.** A soft joint of frequency f and damping ratio ζ has α = 1/(m ω²) and dissipates at 2ζ/ω, taken
//! implicitly (Macklin et al. 2016, eq. 26): from Λ = 0 that is the impulse of the implicit spring
//! ([`SoftTerms`]).
//!
//! **Friction.** Static friction is positional: no slip since the start of the substep. It is solved before the
//! normals, bounded by their impulses of the substep before. After or among normals that start from zero, it would
//! hold against tilts that the next normal takes back, and boxes walk apart (`pyramid 20` by 2 m in 10 s with 16
//! substeps, which so drifts by 1 mm in 5 s).
//!
//! **Velocities of contacts**: points with a normal impulse neither part nor approach, friction up to its bound. That
//! takes out what the correction of an overlap left in the velocities. Impacts come before each substep, as in all
//! methods here.
//!
//! **Good at** walls and loads for its cost: with 8 substeps `pyramid 40` sinks by 20 mm and drifts by 80 mm in 10 s,
//! `limbs` part by 7 mm, `sandwich 100` sinks by 1 mm; 4, 8 and 16 substeps part `chain 100` by 117, 38 and 12 mm in
//! 5 s. **Bad at** few substeps: with 4, `stack 30` falls. Nothing is carried over, so that slopes creep, by 1.5 mm/s
//! at 30°, and `card_house` falls.

use super::coloring::Color;
use super::constants::XPBD_TURN;
use super::stage::{GroupTerms, Plan, Stage};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{SoftTerms, UNLIMITED};

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings, time: f64) -> GroupTerms<L> {
    let rigid = GroupTerms::new(settings, time);
    let h = rigid.h;
    let max_speed = settings.correction_speed.unwrap_or(UNLIMITED);
    GroupTerms {
        joint: SoftTerms::rigid(1.0 / h, UNLIMITED, 0.0, h),
        contact: SoftTerms::rigid(1.0 / h, max_speed, settings.slop, h),
        ..rigid
    }
}

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    let contacts = colors.clone().filter(|color| matches!(color, Color::Contacts(_)));
    for interval in plan.intervals(plan.turns_over(XPBD_TURN)) {
        plan.interval(interval, colors.clone(), stages, |_, stages| {
            stages.push(Stage::BeginSubstep { is_first: true });
            stages.extend(contacts.clone().map(Stage::SolveFriction));
            plan.trace(true, stages);
            for iteration in 0..plan.iterations {
                stages.extend(colors.clone().map(|color| Stage::SolvePositions { color, is_first: iteration == 0 }));
                plan.trace(false, stages);
            }
            plan.drift(stages);
            stages.extend(contacts.clone().map(Stage::SolveVelocities));
        });
    }
}
