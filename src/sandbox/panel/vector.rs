//! The three numbers of a vector, to be dragged or typed.

use std::ops::RangeInclusive;

use bevy::math::DVec3;
use bevy_egui::egui;

use super::theme::without_negative_zero;

/// How such numbers are shown and changed.
pub(super) struct VectorFields {
    /// What may be given. What is there already may be beyond it: to look at it must not change it.
    pub range: RangeInclusive<f64>,
    /// Change by a drag over a point.
    pub speed: f64,
    pub decimals: usize,
    /// Of each, points.
    pub width: f32,
}

impl VectorFields {
    /// Whether one of them was changed.
    pub fn show(&self, ui: &mut egui::Ui, vector: &mut DVec3) -> bool {
        let decimals = self.decimals;
        vector.as_mut().iter_mut().fold(false, |is_changed, part| {
            let drag = egui::DragValue::new(part).speed(self.speed).range(self.range.clone());
            let drag = drag.clamp_existing_to_range(false).update_while_editing(false);
            let drag = drag.custom_formatter(|value, _| without_negative_zero(format!("{value:.decimals$}")));
            is_changed | ui.add_sized([self.width, ui.spacing().interact_size.y], drag).changed()
        })
    }
}
