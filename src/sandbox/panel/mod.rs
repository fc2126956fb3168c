//! The panel at the right: playback, scenes, building, files, gizmos, colors and what made the last step, the selected body,
//! plots, probes, ghosts beside the scene, charts, sweeps, solver, read-outs.
//!
//! Each section is a system that is handed egui's `Ui`, so that it names the resources it shows
//! and nothing else. What a section asks of the sandbox it writes as a
//! [`SandboxAction`](super::SandboxAction); physics resources it edits in place.

mod build;
mod buttons;
mod chart;
mod entry;
mod files;
mod joint;
mod measuring;
mod playback;
mod readouts;
mod scenes;
mod selection;
mod solver;
mod strip;
mod sweep;
mod theme;
mod toast;
pub(super) mod vary;
mod world;

pub use chart::measure_chart;
pub(super) use entry::Entered;
pub use measuring::ChartSource;
pub(super) use strip::HEIGHT as STRIP_HEIGHT;
pub(super) use theme::{Quantity, name_of, palette, without_negative_zero};

use bevy::prelude::*;
use bevy_egui::{EguiContext, EguiPrimaryContextPass, PrimaryEguiContext, egui};

use super::joint_readings::ReadJoints;
use super::state::Covered;
use super::{ghost, gizmos, plots, probe, why};
use crate::scene::Probes;

/// Whether the panel is open. Closed by dragging its edge to the side of the window.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelOpen(pub bool);

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(PanelOpen(true))
        .add_plugins((
            playback::plugin,
            scenes::plugin,
            files::plugin,
            measuring::plugin,
            chart::plugin,
            sweep::plugin,
            toast::plugin,
        ))
        .add_systems(EguiPrimaryContextPass, (theme::apply, show, strip::show).chain());
}

const DEFAULT_WIDTH: f32 = 334.0;
const WIDTHS: std::ops::RangeInclusive<f32> = 280.0..=560.0;
const SCROLL_BAR: f32 = 8.0;

/// Draws the panel. It lies in an `Area`, because egui counts a panel of the background layer as
/// part of the picture: the pointer over it would pick the bodies behind it.
fn show(world: &mut World) -> Result {
    let Ok(mut context) = world.query_filtered::<&mut EguiContext, With<PrimaryEguiContext>>().single_mut(world) else {
        return Ok(());
    };
    let context = context.get_mut().clone();
    let screen = context.content_rect();
    let id = egui::Id::new("panel");
    let last = egui::PanelState::load(&context, id).map_or(screen, |state| state.outer_rect);
    let mut open = world.resource::<PanelOpen>().0;
    let mut drawn = Ok(false);
    let mut covered = 0.0;
    egui::Area::new(id.with("area")).fixed_pos(last.min).movable(false).constrain(false).fade_in(false).show(
        &context,
        |ui| {
            let layer = egui::UiBuilder::new().layer_id(ui.layer_id()).max_rect(screen);
            let mut root = egui::Ui::new(context.clone(), id.with("root"), layer);
            let panel = egui::Panel::right(id).default_size(DEFAULT_WIDTH).size_range(WIDTHS);
            let shown = panel.show_collapsible(&mut root, &mut open, |ui| drawn = at_its_width(ui, world));
            if let Some(shown) = shown {
                covered = shown.response.rect.width() * context.zoom_factor();
                ui.expand_to_include_rect(shown.response.rect);
            }
        },
    );
    if !open {
        reopen_button(&context, &mut open);
    }
    world.resource_mut::<PanelOpen>().set_if_neq(PanelOpen(open));
    world.resource_mut::<Covered>().set_if_neq(Covered(covered));
    let watched = (drawn? && open) || probe::reads_diagnostics(world.resource::<Probes>());
    world.resource_mut::<plots::Watched>().set_if_neq(plots::Watched(watched));
    Ok(())
}

/// The sections, in a panel that stays as wide as it was made: what is too long for it is cut off at its edge.
fn at_its_width(ui: &mut egui::Ui, world: &mut World) -> Result<bool> {
    let room = ui.available_rect_before_wrap();
    let mut inside = ui.new_child(egui::UiBuilder::new().max_rect(room));
    inside.shrink_clip_rect(room);
    let drawn = sections(&mut inside, world);
    ui.advance_cursor_after_rect(room);
    drawn
}

/// The sections, top to bottom. Tells whether the plots are on view.
fn sections(ui: &mut egui::Ui, world: &mut World) -> Result<bool> {
    run(ui, world, playback::show)?;
    ui.separator();
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // The scroll bar floats over the contents.
            ui.set_max_width(ui.available_width() - SCROLL_BAR);
            section(ui, world, "Scene", true, scenes::show)?;
            section(ui, world, "Build", true, build::show)?;
            section(ui, world, "Files", true, files::show)?;
            section(ui, world, "Gizmos", true, gizmos::show)?;
            section(ui, world, "Why", false, why::show)?;
            // Beside the gizmos and the plots, which show what is chosen here.
            let list_open = section(ui, world, "Selected body", true, selection::show)?;
            if !list_open && !world.resource::<ReadJoints>().open.is_empty() {
                world.resource_mut::<ReadJoints>().open.clear();
            }
            let plots_open = section(ui, world, "Plots", true, plots::show)?;
            section(ui, world, "Probes", true, probe::show)?;
            section(ui, world, "Side by side", false, ghost::show)?;
            section(ui, world, "Chart", false, chart::show)?;
            section(ui, world, "Sweep", false, sweep::show)?;
            section(ui, world, "Solver", true, solver::show)?;
            section(ui, world, "Read-outs", true, readouts::show)?;
            section(ui, world, "World", false, world::show)?;
            Ok(plots_open)
        })
        .inner
}

/// A collapsible section. Tells whether it is open.
fn section<M, S>(ui: &mut egui::Ui, world: &mut World, title: &str, open: bool, contents: S) -> Result<bool>
where
    S: IntoSystem<InMut<'static, egui::Ui>, (), M> + 'static,
{
    let shown =
        egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(open).show_unindented(ui, |ui| {
            let result = run(ui, world, contents);
            ui.add_space(6.0);
            result
        });
    let is_open = shown.body_returned.is_some();
    shown.body_returned.transpose()?;
    Ok(is_open)
}

fn run<M, S>(ui: &mut egui::Ui, world: &mut World, contents: S) -> Result
where
    S: IntoSystem<InMut<'static, egui::Ui>, (), M> + 'static,
{
    Ok(world.run_system_cached_with(contents, ui)?)
}

/// A tab at the edge of the window, where the panel was.
fn reopen_button(context: &egui::Context, open: &mut bool) {
    egui::Area::new(egui::Id::new("panel tab")).anchor(egui::Align2::RIGHT_TOP, [-8.0, 8.0]).show(context, |ui| {
        if ui.button("☰").on_hover_text("show the panel").clicked() {
            *open = true;
        }
    });
}
