//! The plots, over the width of the picture above the strip of time: a button there and a key show and hide them, their upper
//! edge makes them higher.

use bevy::prelude::*;
use bevy_egui::egui;

use super::pane::{self, Edge};
use super::run::run;
use super::strip::STRIP_HEIGHT;
use crate::sandbox::plots;
use crate::sandbox::state::{Covered, ShowsPlots};

const DEFAULT_HEIGHT: f32 = 150.0;
const HEIGHTS: std::ops::RangeInclusive<f32> = 100.0..=420.0;
/// Between them and what is at their sides, and within.
const MARGIN: f32 = 8.0;
const INNER: f32 = 6.0;

/// Draws them beside the panel, which is drawn before. How high they are, logical pixels.
pub(super) fn show(context: &egui::Context, world: &mut World) -> Result<f32> {
    if !world.resource::<ShowsPlots>().0 {
        return Ok(0.0);
    }
    let id = egui::Id::new("plots");
    let screen = context.content_rect();
    let right = screen.right() - world.resource::<Covered>().right / context.zoom_factor() - MARGIN;
    let bottom = screen.bottom() - STRIP_HEIGHT;
    let mut height = context.data(|data| data.get_temp::<f32>(id)).unwrap_or(DEFAULT_HEIGHT);
    let place =
        egui::Rect::from_min_max(egui::pos2(screen.left() + MARGIN, bottom - height), egui::pos2(right, bottom));
    let mut drawn = Ok(());
    let frame = egui::Frame::popup(&context.global_style()).inner_margin(INNER);
    let (by, _) = pane::show(context, (id, Edge::Top), place, frame, |ui| drawn = run(ui, world, plots::show));
    height = (height + by).clamp(*HEIGHTS.start(), *HEIGHTS.end());
    context.data_mut(|data| data.insert_temp(id, height));
    drawn?;
    Ok(place.height() * context.zoom_factor())
}
