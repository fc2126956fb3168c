//! Extended position-based dynamics with small steps (Müller, Macklin, Chentanez, Jeschke and Kim 2020, *Detailed
//! Rigid Body Simulation with Extended Position Based Dynamics*).
//!
//! Each substep: forces → positions solved → velocities from how far bodies moved → contacts settle. Nothing is
//! remembered of the substep before; substeps take the place of sweeps (Macklin et al. 2019).
//!
//! **Positions as velocities.** Their method predicts x* = x + h v, then moves each pair by M⁻¹Jᵀ Δλ,
//! Δλ = −(C(x) + α̃ λ)/(w + α̃), w = J M⁻¹Jᵀ, α̃ = α/h², and ends with v = (x − x_before)/h. Seen from the pose before,
//! with rows of the start of the substep, C(x) = C(x_before) + h J v: to move by Δx is to change v by Δx/h, and with
//! the impulse Λ = λ/h the update reads, for α = 0, Λ ← max(0, Λ − m (J v + C(x_before)/h)). That is the row of
//! [`super::impulse`] with the bias C/h and Λ from zero, and the drift after it is the prediction and all moves at
//! once. What is deep already is pushed out no faster than the settings' `correction_speed`.
//!
//! **Compliance.** A soft joint of frequency f and damping ratio ζ has α = 1/(m ω²) and dissipates at 2ζ/ω, taken
//! implicitly (Macklin et al. 2016, eq. 26): from Λ = 0 that is the impulse of the implicit spring
//! ([`SoftTerms`]).
//!
//! **Contacts settle** (their velocity solve): points that pushed neither part nor approach, friction up to its
//! bound. That takes out what the way out of an overlap left in the velocities. Bounces follow once a step, as of all
//! methods here. Static friction is in the position solve: no bias, no slip since the start of the substep.

use super::impulse::{Color, GroupTerms, Plan, SoftTerms, Stage, UNLIMITED};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;

/// Turn in a step beyond which rows of joints turn along, rad: what a turn θ of an arm r misses, ½ r θ², comes back as
/// a speed.
const FAR: f64 = 0.01;

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings) -> GroupTerms<L> {
    let h = settings.step() / f64::from(settings.substeps);
    let push = settings.correction_speed.unwrap_or(UNLIMITED);
    GroupTerms {
        h,
        substeps: settings.substeps,
        joint: SoftTerms::rigid(1.0 / h, UNLIMITED, 0.0, h),
        contact: SoftTerms::rigid(1.0 / h, push, settings.slop, h),
        projection: None,
        restitution_speed: settings.restitution_speed.unwrap_or(UNLIMITED),
    }
}

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    let contacts = colors.clone().filter(|color| matches!(color, Color::Contacts(_)));
    for part in plan.parts(plan.turns_over(FAR)) {
        plan.part(part, colors.clone(), stages, |_, stages| {
            stages.push(Stage::Begin { is_first: true });
            stages.extend(contacts.clone().map(Stage::Rub));
            for iteration in 0..plan.iterations {
                stages.extend(colors.clone().map(|color| Stage::Press { color, is_first: iteration == 0 }));
            }
            stages.push(Stage::Drift);
            stages.extend(contacts.clone().map(Stage::Settle));
        });
    }
}
