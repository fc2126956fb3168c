//! The legend in the picture, at the left above the strip.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::legend::{Chip, Key};
use super::paint::Painted;
use super::scale::{Scale, shade};
use crate::sandbox::axes::color32;
use crate::sandbox::panel::{BESIDE_TOOLS, STRIP_HEIGHT};
use crate::sandbox::state::Covered;

/// Size of a scale's bar, points.
const BAR: egui::Vec2 = egui::vec2(262.0, 12.0);
/// Of what stands under it.
const TEXT: f32 = 12.0;
/// Between two marks' texts.
const MARK_GAP: f32 = 4.0;
/// What a notice under the legend takes, points.
const NOTICE: f32 = 36.0;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(EguiPrimaryContextPass, show);
}

fn show(mut contexts: EguiContexts, painted: Res<Painted>, covered: Res<Covered>) -> Result {
    let Some(legend) = painted.legend() else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let [_, plots] = covered.in_points(context);
    let below = STRIP_HEIGHT + plots + NOTICE;
    egui::Area::new(egui::Id::new("legend"))
        .anchor(egui::Align2::LEFT_BOTTOM, [BESIDE_TOOLS, -12.0 - below])
        .interactable(false)
        .show(context, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.spacing_mut().item_spacing.y = 3.0;
                ui.set_max_width(BAR.x + 24.0);
                ui.strong(legend.title);
                match &legend.key {
                    Key::Scale(scale) => bar(ui, scale),
                    Key::Chips(chips) => chips.iter().for_each(|shown| chip(ui, shown)),
                }
                for note in &legend.notes {
                    ui.label(egui::RichText::new(note).size(TEXT).color(egui::Color32::from_gray(165)));
                }
            });
        });
    Ok(())
}

fn chip(ui: &mut egui::Ui, chip: &Chip) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(11.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 2.0, color32(chip.color));
        ui.label(&chip.text);
    });
}

/// The colors from left to right, with marks under them.
fn bar(ui: &mut egui::Ui, scale: &Scale) {
    const STRIPES: usize = 64;
    /// Room for what is written at the ends.
    const SIDE: f32 = 14.0;
    let size = egui::vec2(BAR.x + SIDE, BAR.y + TEXT + 9.0);
    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let bar = egui::Rect::from_min_size(rect.min + egui::vec2(SIDE / 2.0, 0.0), BAR - egui::vec2(SIDE, 0.0));
    let x = |share: f32| bar.left() + share * bar.width();
    for stripe in 0..STRIPES {
        let [from, to] = [stripe, stripe + 1].map(|edge| edge as f32 / STRIPES as f32);
        let part = egui::Rect::from_x_y_ranges(x(from)..=x(to), bar.y_range());
        ui.painter().rect_filled(part, 0.0, color32(shade((stripe as f32 + 0.5) / STRIPES as f32)));
    }
    let tint = ui.visuals().text_color();
    let mut free = rect.right();
    // From the right: what has no room beside its neighbour is left out.
    for (share, text) in scale.marks().into_iter().rev() {
        let length = if text.is_some() { 4.0 } else { 2.0 };
        ui.painter().vline(x(share), bar.bottom()..=bar.bottom() + length, egui::Stroke::new(1.0, tint));
        let Some(text) = text else { continue };
        let text = ui.painter().layout_no_wrap(text, egui::FontId::proportional(TEXT), tint);
        let width = text.size().x;
        // At the ends as far as the edge.
        let left = (x(share) - width / 2.0).clamp(rect.left(), rect.right() - width);
        if left + width <= free {
            ui.painter().galley(egui::pos2(left, bar.bottom() + 5.0), text, tint);
            free = left - MARK_GAP;
        }
    }
}
