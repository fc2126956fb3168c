//! The plots, over the width of the picture above the strip of time: a button there and a key show and hide them, their upper
//! edge makes them higher.

use bevy::prelude::*;
use bevy_egui::egui;

use super::run;
use super::strip::STRIP_HEIGHT;
use crate::sandbox::plots;
use crate::sandbox::state::{Covered, ShowsPlots};

const DEFAULT_HEIGHT: f32 = 128.0;
const HEIGHTS: std::ops::RangeInclusive<f32> = 90.0..=420.0;
/// Between them and what is at their sides.
const MARGIN: f32 = 8.0;

/// Draws them beside the panel, which is drawn before. How high they are, logical pixels.
pub(super) fn show(context: &egui::Context, world: &mut World) -> Result<f32> {
    if !world.resource::<ShowsPlots>().0 {
        return Ok(0.0);
    }
    let screen = context.content_rect();
    let covered = world.resource::<Covered>().right / context.zoom_factor();
    let room = egui::Rect::from_min_max(
        screen.min + egui::vec2(MARGIN, 0.0),
        egui::pos2(screen.right() - covered - MARGIN, screen.bottom() - STRIP_HEIGHT),
    );
    let id = egui::Id::new("plots");
    let last = egui::PanelState::load(context, id).map_or(room, |state| state.outer_rect);
    let mut drawn = Ok(());
    let mut height = 0.0;
    egui::Area::new(id.with("area")).fixed_pos(last.min).movable(false).constrain(false).fade_in(false).show(
        context,
        |ui| {
            let layer = egui::UiBuilder::new().layer_id(ui.layer_id()).max_rect(room);
            let mut root = egui::Ui::new(context.clone(), id.with("root"), layer);
            let panel = egui::Panel::bottom(id).default_size(DEFAULT_HEIGHT).size_range(HEIGHTS).resizable(true);
            let frame = egui::Frame::popup(ui.style()).inner_margin(6.0);
            let shown = panel.frame(frame).show(&mut root, |ui| {
                let inside = ui.available_rect_before_wrap();
                let mut ui_inside = ui.new_child(egui::UiBuilder::new().max_rect(inside));
                ui_inside.shrink_clip_rect(inside);
                drawn = run(&mut ui_inside, world, plots::show);
                ui.advance_cursor_after_rect(inside);
            });
            height = shown.response.rect.height() * context.zoom_factor();
            ui.expand_to_include_rect(shown.response.rect);
        },
    );
    drawn?;
    Ok(height)
}
