//! The section of the panel: what is colored by, and the plots of the last step.

use bevy::prelude::*;
use bevy_egui::egui;

use super::color_by::ColorBy;
use super::phases::{self, PhaseHistory};
use super::residuals;
use super::watched::Drawn;
use crate::physics::{SolveTrace, SolverSettings, StepStats};

/// The section.
pub fn show(
    InMut(ui): InMut<egui::Ui>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
    trace: Option<Res<SolveTrace>>,
    phases: Res<PhaseHistory>,
    mut by: ResMut<ColorBy>,
    mut drawn: ResMut<Drawn>,
) {
    drawn.0 = true;
    ui.horizontal_wrapped(|ui| {
        ui.label("color by")
            .on_hover_text("bodies, joints and contact points; the legend is in the picture, at the left");
        for choice in ColorBy::EVERY {
            let (name, about) = choice.label();
            let button = egui::Button::new(name).selected(*by == choice);
            if ui.add(button).on_hover_text(about).clicked() {
                by.set_if_neq(choice);
            }
        }
    });
    ui.add_space(4.0);
    residuals::show(ui, &settings, &stats, trace.as_deref());
    ui.add_space(4.0);
    phases::show(ui, &phases);
}
