//! The plots, over the width of the picture above the strip of time: a button there and a key show and hide them, their upper
//! edge makes them higher.

use bevy::prelude::*;
use bevy_egui::egui;

use super::pane::{self, Edge};
use super::run::run;
use super::strip::STRIP_HEIGHT;
use crate::sandbox::plots;
use crate::sandbox::state::{Covered, ShowsPlots};

const HEIGHTS: std::ops::RangeInclusive<f32> = 100.0..=420.0;
/// Between them and what is at their sides, and within.
const MARGIN: f32 = 8.0;
const INNER: f32 = 6.0;

/// How high the plots are, points.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct PlotsHeight(pub f32);

impl Default for PlotsHeight {
    fn default() -> Self {
        Self(150.0)
    }
}

/// Draws them beside the panel, which is drawn before. How high they are, logical pixels.
pub(super) fn show(context: &egui::Context, world: &mut World) -> Result<f32> {
    if !world.resource::<ShowsPlots>().0 {
        return Ok(0.0);
    }
    let screen = context.content_rect();
    let [panel, _] = world.resource::<Covered>().in_points(context);
    let right = screen.right() - panel - MARGIN;
    let bottom = screen.bottom() - STRIP_HEIGHT;
    let PlotsHeight(height) = *world.resource::<PlotsHeight>();
    let height = height.clamp(*HEIGHTS.start(), *HEIGHTS.end());
    let place =
        egui::Rect::from_min_max(egui::pos2(screen.left() + MARGIN, bottom - height), egui::pos2(right, bottom));
    let mut drawn = Ok(());
    let frame = egui::Frame::popup(&context.global_style()).inner_margin(INNER);
    let (by, _) = pane::show(context, (egui::Id::new("plots"), Edge::Top), place, frame, |ui| {
        drawn = run(ui, world, plots::show)
    });
    let height = PlotsHeight((height + by).clamp(*HEIGHTS.start(), *HEIGHTS.end()));
    world.resource_mut::<PlotsHeight>().set_if_neq(height);
    drawn?;
    Ok(place.height() * context.zoom_factor())
}
