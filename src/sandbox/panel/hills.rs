//! What the next hilly ground is.

use bevy_egui::egui;
use bevy_egui::egui::emath::Numeric;

use crate::sandbox::{Hills, SandboxAction};

/// What the widgets hold while it is being changed: the surface is made anew once it is let go.
#[derive(Default)]
pub(super) struct HillRows(Option<Hills>);

impl HillRows {
    /// What is asked for.
    pub fn show(&mut self, ui: &mut egui::Ui, hills: Hills) -> Option<SandboxAction> {
        let mut edited = self.0.unwrap_or(hills);
        let Hills { size: [x, z], height, wavelength, squares } = &mut edited;
        let mut is_dragged = false;
        ui.horizontal(|ui| {
            is_dragged |= number(ui, x, ("x ", ""), Hills::SIZES);
            is_dragged |= number(ui, z, ("z ", " m"), Hills::SIZES);
            is_dragged |= number(ui, height, ("height ", " m"), Hills::HEIGHTS);
        });
        ui.horizontal(|ui| {
            is_dragged |= number(ui, wavelength, ("wavelength ", " m"), Hills::SIZES);
            is_dragged |= number(ui, squares, ("squares ", ""), Hills::SQUARES);
        });
        self.0 = is_dragged.then_some(edited);
        (!is_dragged && edited != hills).then_some(SandboxAction::ChooseHills(edited))
    }
}

/// Whether it is dragged.
fn number<N: Numeric>(
    ui: &mut egui::Ui,
    value: &mut N,
    (prefix, suffix): (&str, &str),
    range: std::ops::RangeInclusive<N>,
) -> bool {
    let (speed, decimals) = if N::INTEGRAL { (0.2, 0) } else { (0.01, 2) };
    let drag = egui::DragValue::new(value).prefix(prefix).suffix(suffix).range(range);
    let drag = drag.speed(speed).max_decimals(decimals);
    ui.add(drag.update_while_editing(false)).dragged()
}
