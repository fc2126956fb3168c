//! What the last step did, and which bodies it had to freeze.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::held::Drag;
use super::super::probe::offer;
use super::theme::{CHANGED, Quantity};
use crate::physics::{Method, Quarantined, SolverSettings, StepStats};
use crate::scene::{Probe, ProbePlot, ProbeSubject, Probes};

/// How many quarantined bodies are named.
const NAMED: usize = 8;

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    drag: Res<Drag>,
    quarantined: Query<(Entity, Option<&Name>, &Quarantined)>,
    mut probes: ResMut<Probes>,
) {
    // The hand, and the joint that it drags with, are none of the scene.
    let of_hand = u32::from(drag.is_active());
    let counts: [(&str, u64, &str, Option<ProbePlot>); 10] = [
        ("bodies", stats.bodies.saturating_sub(of_hand).into(), "bodies of all kinds", None),
        ("joints", stats.joints.saturating_sub(of_hand).into(), "joints", None),
        ("pairs", stats.pairs.into(), "pairs that the broad phase handed on", Some(ProbePlot::Pairs)),
        ("touching", stats.manifolds.into(), "pairs that touch", Some(ProbePlot::Touching)),
        ("contacts", stats.contact_points.into(), "contact points", Some(ProbePlot::Contacts)),
        ("rows", stats.rows.into(), "scalar constraints solved in one substep", Some(ProbePlot::Rows)),
        (
            "row updates",
            stats.row_updates,
            "rows × iterations × solves, over all substeps: a cost without a clock",
            Some(ProbePlot::RowUpdates),
        ),
        ("islands", stats.islands.into(), "groups of awake bodies that touch or are joined", Some(ProbePlot::Islands)),
        (
            "at rest",
            stats.resting.into(),
            "awake bodies of islands at rest: solved directly, or nothing to solve",
            Some(ProbePlot::AtRest),
        ),
        ("asleep", stats.sleeping.into(), "bodies that sleep", Some(ProbePlot::Asleep)),
    ];
    egui::Grid::new("read-outs").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
        for pair in counts.chunks(2) {
            for (label, count, about, plot) in pair {
                name(ui, &mut probes, label, about, *plot);
                ui.monospace(format!("{:>9}", grouped(*count))).on_hover_text(*about);
            }
            // An odd last row has room for the time.
            if pair.len() == 2 {
                ui.end_row();
            }
        }
        name(ui, &mut probes, "step time", "wall-clock time of the last step", Some(ProbePlot::StepTime));
        ui.monospace(format!("{:>9}", Quantity::text(stats.step_seconds, "s")));
        ui.end_row();
    });
    if settings.method == Method::Exact {
        let text = format!("cut into {} parts, {} not settled", stats.cuts + settings.substeps, stats.unsettled);
        let text = egui::RichText::new(text);
        let text = if stats.unsettled > 0 { text.color(CHANGED) } else { text };
        ui.label(text).on_hover_text("the last step: what is not settled does not obey the laws to 1e-8 m/s");
    }
    let frozen = quarantined.iter().count();
    if frozen == 0 {
        return;
    }
    let red = ui.visuals().error_fg_color;
    ui.colored_label(red, format!("{frozen} quarantined:"))
        .on_hover_text("frozen at the last state that made sense; reset the scene to start over");
    for (entity, name, quarantine) in quarantined.iter().take(NAMED) {
        let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
        ui.colored_label(red, format!("{name}: {}", quarantine.reason));
    }
    if frozen > NAMED {
        ui.colored_label(red, format!("and {} more", frozen - NAMED));
    }
}

/// What a line is called; a right click plots it.
fn name(ui: &mut egui::Ui, probes: &mut ResMut<Probes>, label: &str, about: &str, plot: Option<ProbePlot>) {
    let shown = ui.add(egui::Label::new(label).selectable(false).sense(egui::Sense::click())).on_hover_text(about);
    let offered = plot.map(|plot| Probe::Plot(ProbeSubject::Scene, plot));
    offer(&shown, probes, offered.as_slice());
}

/// A number with thin gaps between thousands.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_grouped() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1 000");
        assert_eq!(grouped(12_345_678), "12 345 678");
    }
}
