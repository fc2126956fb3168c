//! The panel's section: a list of the probes with what they read, and a plot for each unit.

use bevy::prelude::*;
use bevy_egui::egui;
use egui_plot::{HoverPosition, Line, Plot, PlotPoints, VLine};

use super::reader::Reader;
use super::tracks::{Track, Tracks};
use crate::sandbox::SandboxAction;
use crate::sandbox::axes::{color32, decade_marks, decade_text, fifth_seconds, mark_text, round_marks};
use crate::sandbox::panel::Quantity;
use crate::scene::Probes;

/// Simulation time on view unless the user chooses another, s.
const WINDOW: f64 = 10.0;
/// Of the line at the pointer's time: no line of the grid is as bright.
const CURSOR: egui::Color32 = egui::Color32::from_gray(235);

/// What of the plots the user chose.
#[derive(Default)]
pub struct View {
    /// From when to when, s; none: the last [`WINDOW`].
    span: Option<[f64; 2]>,
    /// Whether values are drawn by their logarithms.
    logarithmic: bool,
    /// The time that the pointer is at on a plot, s.
    cursor: Option<f64>,
}

/// The section.
pub fn show(
    InMut(ui): InMut<egui::Ui>,
    tracks: Res<Tracks>,
    reader: Reader,
    mut probes: ResMut<Probes>,
    mut view: Local<View>,
    mut actions: MessageWriter<SandboxAction>,
) {
    if tracks.tracks.is_empty() {
        *view = View::default();
        ui.weak("none: right click on a body, a joint, the ground or the sky, or on a number here");
        return;
    }
    if let Some(gone) = list(ui, &tracks, &reader, view.cursor)
        && gone < probes.0.len()
    {
        probes.0.remove(gone);
    }
    let mut units: Vec<&str> = Vec::new();
    for track in tracks.tracks.iter().filter(|track| track.is_plotted()) {
        if !units.contains(&track.unit) {
            units.push(track.unit);
        }
    }
    ui.horizontal(|ui| {
        let about = "draw |values| on a logarithmic axis";
        ui.add_enabled(!units.is_empty(), egui::Checkbox::new(&mut view.logarithmic, "log axis")).on_hover_text(about);
        let about = "the last minute of all probes to plumb-N.csv";
        let save = ui.add_enabled(!units.is_empty(), egui::Button::new("Save CSV").small());
        if save.on_hover_text(about).clicked() {
            actions.write(SandboxAction::SaveProbes);
        }
        if ui.small_button("remove all").clicked() {
            probes.0.clear();
        }
        match (view.cursor, view.span) {
            (Some(time), _) => _ = ui.weak(format!("at {time:.2} s")),
            (None, Some(_)) => {
                if ui.small_button("follow").on_hover_text("the last ten seconds again").clicked() {
                    view.span = None;
                }
            }
            (None, None) => {}
        }
    });
    let mut cursor = None;
    for (place, unit) in units.iter().enumerate() {
        draw(ui, &tracks, unit, place + 1 == units.len(), &mut view, &mut cursor);
    }
    view.cursor = cursor;
}

/// A line a probe: which is to be taken away.
fn list(ui: &mut egui::Ui, tracks: &Tracks, reader: &Reader, cursor: Option<f64>) -> Option<usize> {
    let mut removed = None;
    let row = cursor.and_then(|time| tracks.nearest(time));
    for (at, track) in tracks.tracks.iter().enumerate() {
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("✖").on_hover_text("take this probe away").clicked() {
                removed = Some(at);
            }
            let value = match row {
                Some(row) => row.values.get(at).copied().unwrap_or(f64::NAN),
                None => reader.told(&track.probe, tracks.told_after(reader.now().0, at)),
            };
            ui.monospace(said(track, value));
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.colored_label(color32(track.color), "■");
                ui.add(egui::Label::new(&track.name).truncate());
            });
        });
    }
    removed
}

/// What the list says of a probe.
fn said(track: &Track, value: f64) -> String {
    match track {
        Track { is_gone: true, .. } => "gone".into(),
        track if !track.is_plotted() => String::new(),
        _ if value.is_nan() => "–".into(),
        track if track.unit.is_empty() => format!("{value}"),
        track => Quantity::text(value, track.unit),
    }
}

/// The plot of the probes with one unit.
fn draw(ui: &mut egui::Ui, tracks: &Tracks, unit: &str, labels_time: bool, view: &mut View, cursor: &mut Option<f64>) {
    let end = tracks.rows.back().map_or(WINDOW, |row| row.time.max(WINDOW));
    let span @ [from, to] = view.span.unwrap_or([end - WINDOW, end]);
    let curves: Vec<_> = (0..tracks.tracks.len())
        .filter(|at| tracks.tracks[*at].is_plotted() && tracks.tracks[*at].unit == unit)
        .map(|at| (&tracks.tracks[at], tracks.pieces(at, span)))
        .collect();
    let values = curves.iter().flat_map(|(_, pieces)| pieces.iter().flatten().map(|[_, value]| value.abs()));
    let scale = Quantity::suiting(values.fold(0.0, f64::max), unit);
    let logarithmic = view.logarithmic;
    let name = if scale.unit.is_empty() { "number" } else { &scale.unit };
    ui.label(if logarithmic { if unit.is_empty() { "number" } else { unit } } else { name }).on_hover_text(
        "drag to move, Ctrl and the wheel to zoom, drag with the right button to zoom to a box, double click to see all of it \
         that is now",
    );
    let mut plot = Plot::new(("probes", unit))
        .height(if labels_time { 116.0 } else { 100.0 })
        .show_axes([labels_time, true])
        .allow_zoom([true, false])
        .allow_drag([true, false])
        .allow_scroll(false)
        .allow_axis_zoom_drag(false)
        .link_cursor(egui::Id::new("probes"), [true, false])
        .set_margin_fraction(egui::vec2(0.0, 0.08))
        .y_axis_min_width(if logarithmic { 58.0 } else { 36.0 })
        .label_formatter(|position| match position {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                let value = if logarithmic { 10_f64.powf(position.y) } else { position.y / scale.factor };
                Some(format!("{plot_name}\n{}\nat {:.3} s", Quantity::text(value, unit), position.x))
            }
            HoverPosition::Elsewhere { .. } => None,
        });
    plot = match logarithmic {
        true => plot.y_grid_spacer(decade_marks).y_axis_formatter(|mark, _| decade_text(mark, unit)),
        false => plot.y_grid_spacer(round_marks).y_axis_formatter(|mark, _| mark_text(mark)),
    };
    if view.span.is_none() {
        // At the right end a number would be cut off.
        plot = plot.x_grid_spacer(move |_| fifth_seconds(from, to)).x_axis_formatter(move |mark, _| {
            if mark.value > to - 0.5 { String::new() } else { format!("{} s", mark.value) }
        });
    } else {
        plot = plot.x_grid_spacer(round_marks).x_axis_formatter(|mark, _| format!("{} s", mark_text(mark)));
    }
    // egui counts the widgets inside a plot anew at each pass; its id keeps the next ones' stable.
    let shown = ui.push_id(("probes of", unit), |ui| {
        plot.show(ui, |plot| {
            for (track, pieces) in &curves {
                for piece in pieces {
                    let point = |[time, value]: &[f64; 2]| match logarithmic {
                        true => [*time, value.abs().log10()],
                        false => [*time, value * scale.factor],
                    };
                    let points: PlotPoints = piece.iter().map(point).filter(|[_, value]| value.is_finite()).collect();
                    plot.line(Line::new(&track.name, points).color(color32(track.color)).width(1.5));
                }
            }
            if let Some(time) = view.cursor {
                let line = VLine::new("", time).color(CURSOR).width(1.5).allow_hover(false);
                plot.vline(line);
            }
            plot.set_plot_bounds_x(from..=to);
            plot.pointer_coordinate().filter(|_| plot.response().hovered()).map(|pointer| pointer.x)
        })
    });
    *cursor = cursor.or(shown.inner.inner);
    take_over(view, &shown.inner, [from, to]);
}

/// What the user did to a plot holds for all of them.
fn take_over(view: &mut View, shown: &egui_plot::PlotResponse<Option<f64>>, [from, to]: [f64; 2]) {
    let bounds = shown.transform.bounds();
    let now = [bounds.min()[0], bounds.max()[0]];
    let differs = (now[0] - from).abs().max((now[1] - to).abs()) > 1e-6 * (to - from);
    if shown.response.double_clicked() {
        view.span = None;
    } else if differs && now.iter().all(|time| time.is_finite()) && now[0] < now[1] {
        view.span = Some(now);
    }
}
