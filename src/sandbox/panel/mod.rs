//! The panel at the right, in pages: scenes and files, building and the selected body, what is shown and plotted, the solver with
//! its charts and sweeps. Beside the picture the tools, under it the strip of time.
//!
//! Each section is a system that is handed egui's `Ui`, so that it names the resources it shows
//! and nothing else. What a section asks of the sandbox it writes as a
//! [`SandboxAction`](super::SandboxAction); physics resources it edits in place.

mod body;
mod build;
mod buttons;
mod chart;
mod entry;
mod files;
mod gallery;
mod graphs;
mod hills;
mod icons;
mod inspector;
mod joint;
mod let_go;
mod many;
mod measuring;
mod mesh;
mod pane;
mod pictures;
mod playback;
mod readouts;
mod run;
mod scenes;
mod selection;
mod size;
mod solver;
mod strip;
mod sweep;
mod theme;
mod toast;
mod toolbar;
pub(super) mod vary;
mod vector;
mod world;

pub(super) use buttons::toggle;
pub use chart::measure_chart;
pub(super) use entry::Entered;
pub use graphs::PlotsHeight;
pub use measuring::ChartSource;
pub(super) use strip::STRIP_HEIGHT;
pub(super) use theme::{Quantity, name_of, palette, without_negative_zero};
pub(super) use toolbar::BESIDE_TOOLS;

use bevy::prelude::*;
use bevy_egui::{EguiContext, EguiPrimaryContextPass, PrimaryEguiContext, egui};
use serde::{Deserialize, Serialize};

use self::pane::Edge;
use self::run::run;
use super::action::CarryOut;
use super::state::{Covered, ShowsPlots};
use super::{Ghosts, Tool, ghost, gizmos, plots, probe, why};
use crate::scene::Probes;

/// Whether the panel is open. Closed by dragging its edge to the side of the window.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelOpen(pub bool);

/// How wide the panel is, points.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct PanelWidth(pub f32);

impl Default for PanelWidth {
    fn default() -> Self {
        Self(334.0)
    }
}

/// What the panel shows.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Page {
    /// Scenes.
    #[default]
    Play,
    /// New bodies and joints, and the picked ones.
    Build,
    /// What is shown, plotted and told.
    Analyse,
    /// How it is solved, and how well.
    Solver,
}

impl Page {
    /// All of them, with what each is called and has.
    const ALL: [(Self, &str, &str); 4] = [
        (Self::Play, "Play", "scenes and files"),
        (Self::Build, "Build", "what the next body is, and the selected one with its joints"),
        (Self::Analyse, "Analyse", "what is drawn over the picture, plots, probes, ghosts, read-outs"),
        (Self::Solver, "Solver", "the solver's settings, charts and sweeps"),
    ];
}

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(PanelOpen(true))
        .init_resource::<Page>()
        .init_resource::<PanelWidth>()
        .init_resource::<PlotsHeight>()
        .init_resource::<inspector::Inspector>()
        .add_systems(PreUpdate, turn_with_tool)
        .add_systems(Update, inspector::follow.after(CarryOut))
        .add_plugins((
            playback::plugin,
            scenes::plugin,
            gallery::plugin,
            files::plugin,
            measuring::plugin,
            chart::plugin,
            sweep::plugin,
            toast::plugin,
        ))
        .add_systems(EguiPrimaryContextPass, (theme::apply, show, strip::show, toolbar::show).chain());
}

const WIDTHS: std::ops::RangeInclusive<f32> = 280.0..=560.0;
/// Share of the least width at which it closes.
const CLOSES: f32 = 0.6;
const SCROLL_BAR: f32 = 8.0;

/// Draws the panel, and what lies over the picture beside it.
fn show(world: &mut World) -> Result {
    let Ok(mut context) = world.query_filtered::<&mut EguiContext, With<PrimaryEguiContext>>().single_mut(world) else {
        return Ok(());
    };
    let context = context.get_mut().clone();
    let mut open = world.resource::<PanelOpen>().0;
    let mut drawn = Ok(());
    let mut covered = 0.0;
    if open {
        let id = egui::Id::new("panel");
        let screen = context.content_rect();
        let PanelWidth(asked) = *world.resource::<PanelWidth>();
        let width = asked.clamp(*WIDTHS.start(), *WIDTHS.end());
        let place = egui::Rect::from_min_max(egui::pos2(screen.right() - width, screen.top()), screen.max);
        let frame = egui::Frame::side_top_panel(&context.global_style());
        let (by, let_go) = pane::show(&context, (id, Edge::Left), place, frame, |ui| drawn = sections(ui, world));
        // Dragged far beyond its least width, it goes.
        open = asked + by > CLOSES * WIDTHS.start();
        let kept = if let_go || !open { width } else { asked + by };
        world.resource_mut::<PanelWidth>().set_if_neq(PanelWidth(kept));
        covered = if open { width * context.zoom_factor() } else { 0.0 };
    }
    if !open {
        reopen_button(&context, &mut open);
    }
    world.resource_mut::<PanelOpen>().set_if_neq(PanelOpen(open));
    drawn?;
    let bottom = world.resource::<Covered>().bottom;
    world.resource_mut::<Covered>().set_if_neq(Covered { right: covered, bottom });
    inspector::show(&context, world)?;
    let bottom = graphs::show(&context, world)?;
    world.resource_mut::<Covered>().set_if_neq(Covered { right: covered, bottom });
    let watched = world.resource::<ShowsPlots>().0
        || probe::reads_diagnostics(world.resource::<Probes>())
        || !world.resource::<Ghosts>().0.is_empty();
    world.resource_mut::<plots::Watched>().set_if_neq(plots::Watched(watched));
    Ok(())
}

/// The pages, and the sections of the one on view, top to bottom.
fn sections(ui: &mut egui::Ui, world: &mut World) -> Result {
    run(ui, world, pages)?;
    ui.separator();
    let page = *world.resource::<Page>();
    egui::ScrollArea::vertical()
        .id_salt(page)
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // The scroll bar floats over the contents.
            ui.set_max_width(ui.available_width() - SCROLL_BAR);
            // What lies where another page's section lay is another one.
            ui.push_id(page, |ui| show_page(ui, world, page)).inner
        })
        .inner
}

fn show_page(ui: &mut egui::Ui, world: &mut World, page: Page) -> Result {
    match page {
        Page::Play => {
            section(ui, world, "Scene", true, scenes::show)?;
            section(ui, world, "Gallery", true, gallery::show)?;
            section(ui, world, "Files", true, files::show)?;
            section(ui, world, "World", true, world::show)?;
            section(ui, world, "Interface", true, size::show)?;
        }
        Page::Build => {
            section(ui, world, "Build", true, build::show)?;
        }
        Page::Analyse => {
            section(ui, world, "Gizmos", true, gizmos::show)?;
            section(ui, world, "Probes", true, probe::show)?;
            section(ui, world, "Why", false, why::show)?;
            section(ui, world, "Side by side", false, ghost::show)?;
            section(ui, world, "Read-outs", true, readouts::show)?;
        }
        Page::Solver => {
            section(ui, world, "Solver", true, solver::show)?;
            section(ui, world, "Chart", false, chart::show)?;
            section(ui, world, "Sweep", false, sweep::show)?;
        }
    }
    Ok(())
}

/// What is built with is on view once a tool that builds is in hand.
fn turn_with_tool(tool: Res<Tool>, mut page: ResMut<Page>) {
    if tool.is_changed() && matches!(*tool, Tool::Add | Tool::Bar | Tool::Join) {
        page.set_if_neq(Page::Build);
    }
}

/// The pages' names; a click turns to one.
fn pages(InMut(ui): InMut<egui::Ui>, mut page: ResMut<Page>) {
    ui.add_space(4.0);
    ui.columns(Page::ALL.len(), |columns| {
        for (column, (own, name, about)) in columns.iter_mut().zip(Page::ALL) {
            let text = egui::RichText::new(name).size(theme::HEADER);
            let shown = buttons::wide_button(column, 28.0, true, egui::Button::selectable(*page == own, text));
            if shown.on_hover_text(about).clicked() {
                page.set_if_neq(own);
            }
        }
    });
}

/// A collapsible section. Tells whether it is open.
fn section<M, S>(ui: &mut egui::Ui, world: &mut World, title: &str, open: bool, contents: S) -> Result<bool>
where
    S: IntoSystem<InMut<'static, egui::Ui>, (), M> + 'static,
{
    let title = egui::RichText::new(title).size(theme::HEADER).strong();
    let shown = egui::CollapsingHeader::new(title).default_open(open).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        let result = run(ui, world, contents);
        ui.add_space(8.0);
        result
    });
    let is_open = shown.body_returned.is_some();
    shown.body_returned.transpose()?;
    Ok(is_open)
}

/// A tab at the edge of the window, where the panel was.
fn reopen_button(context: &egui::Context, open: &mut bool) {
    egui::Area::new(egui::Id::new("panel tab")).anchor(egui::Align2::RIGHT_TOP, [-8.0, 8.0]).show(context, |ui| {
        if ui.button("☰").on_hover_text("show the panel").clicked() {
            *open = true;
        }
    });
}
