//! What the last step did, and which bodies it had to freeze.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::held::Drag;
use super::theme::Quantity;
use crate::physics::{Quarantined, StepStats};

/// How many quarantined bodies are named.
const NAMED: usize = 8;

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    stats: Res<StepStats>,
    drag: Res<Drag>,
    quarantined: Query<(Entity, Option<&Name>, &Quarantined)>,
) {
    // The hand, and the joint that it drags with, are none of the scene.
    let of_hand = u32::from(drag.is_active());
    let counts: [(&str, u64, &str); 10] = [
        ("bodies", stats.bodies.saturating_sub(of_hand).into(), "bodies of all kinds"),
        ("joints", stats.joints.saturating_sub(of_hand).into(), "joints"),
        ("pairs", stats.pairs.into(), "pairs that the broad phase handed on"),
        ("touching", stats.manifolds.into(), "pairs that touch"),
        ("contacts", stats.contact_points.into(), "contact points"),
        ("rows", stats.rows.into(), "scalar constraints solved in one substep"),
        ("row updates", stats.row_updates, "rows × iterations × solves, over all substeps: a cost without a clock"),
        ("islands", stats.islands.into(), "groups of awake bodies that touch or are joined"),
        ("at rest", stats.resting.into(), "awake bodies of islands at rest: solved directly, or nothing to solve"),
        ("asleep", stats.sleeping.into(), "bodies that sleep"),
    ];
    egui::Grid::new("read-outs").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
        for pair in counts.chunks(2) {
            for (label, count, about) in pair {
                ui.label(*label).on_hover_text(*about);
                ui.monospace(format!("{:>9}", grouped(*count))).on_hover_text(*about);
            }
            // An odd last row has room for the time.
            if pair.len() == 2 {
                ui.end_row();
            }
        }
        ui.label("step time").on_hover_text("wall-clock time of the last step");
        ui.monospace(format!("{:>9}", Quantity::text(stats.step_seconds, "s")));
        ui.end_row();
    });
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
