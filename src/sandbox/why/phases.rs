//! What the phases of the last steps took, as a plot.

use std::collections::VecDeque;

use bevy::prelude::*;
use bevy_egui::egui;
use egui_plot::{Bar, BarChart, Plot};

use crate::physics::{PhaseTimes, PhysicsSchedule, PhysicsSystems};
use crate::sandbox::axes::{color32, mark_text, round_marks, still};
use crate::sandbox::panel::{Quantity, palette};

/// Steps on view.
const STEPS: usize = 100;
/// Share of a step in the mean that is drawn: as many steps as its inverse are seen at once.
const SHARE: f64 = 0.1;

/// A color for each phase.
const COLORS: [[u8; 3]; PhaseTimes::COUNT] = [
    [150, 155, 165],
    palette::YELLOW,
    palette::ORANGE,
    palette::PURPLE,
    palette::SKY,
    palette::GREEN,
    palette::VERMILION,
];

/// Means of the last steps, s, the newest last.
#[derive(Resource, Default)]
pub struct PhaseHistory(VecDeque<[f64; PhaseTimes::COUNT]>);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<PhaseHistory>()
        .add_systems(PreUpdate, forget.run_if(not(resource_exists::<PhaseTimes>)))
        .add_systems(PhysicsSchedule, record.after(PhysicsSystems::Diagnose).run_if(resource_exists::<PhaseTimes>));
}

fn record(times: Res<PhaseTimes>, mut history: ResMut<PhaseHistory>) {
    history.push(times.seconds);
}

/// A plot with a gap in it would lie.
fn forget(mut history: ResMut<PhaseHistory>) {
    if !history.0.is_empty() {
        history.0.clear();
    }
}

impl PhaseHistory {
    fn push(&mut self, seconds: [f64; PhaseTimes::COUNT]) {
        let before = self.0.back().copied().unwrap_or(seconds);
        if self.0.len() == STEPS {
            self.0.pop_front();
        }
        self.0.push_back(std::array::from_fn(|phase| before[phase] + SHARE * (seconds[phase] - before[phase])));
    }
}

/// The plot, a caption with the sum, and what has which color with its newest mean.
pub(super) fn show(ui: &mut egui::Ui, history: &PhaseHistory) {
    let sum = |seconds: &[f64; PhaseTimes::COUNT]| seconds.iter().sum::<f64>();
    let newest = history.0.back();
    let largest = history.0.iter().map(sum).fold(0.0, f64::max);
    let scale = Quantity::suiting(largest, "s");
    ui.horizontal(|ui| {
        ui.label(format!("time by phase, {}", scale.unit)).on_hover_text(
            "wall-clock time of each phase of a step, mean of the last ten steps or so: one bar a step, the newest at the \
             right; what is measured for this panel is left out, as are commands at the end of the step",
        );
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let text = newest.map_or_else(|| "–".into(), |newest| scale.number(sum(newest)));
            ui.label(egui::RichText::new(format!("sum {text}")).small());
        });
    });
    draw(ui, history, scale.factor);
    egui::Grid::new("phases").num_columns(4).spacing([8.0, 2.0]).show(ui, |ui| {
        for (phase, name) in PhaseTimes::NAMES.into_iter().enumerate() {
            let name = egui::RichText::new(name).small().color(color32(COLORS[phase]));
            ui.label(name);
            let text = newest.map_or_else(|| "–".into(), |newest| scale.number(newest[phase]));
            ui.monospace(egui::RichText::new(format!("{text:>7}")).small());
            if phase % 2 == 1 {
                ui.end_row();
            }
        }
    });
}

/// Phase upon phase.
fn draw(ui: &mut egui::Ui, history: &PhaseHistory, factor: f64) {
    let first = STEPS - history.0.len();
    let chart = |phase: usize| {
        let color = color32(COLORS[phase]);
        let bars = history.0.iter().enumerate().map(|(step, seconds)| {
            let height = if seconds[phase].is_finite() { seconds[phase] * factor } else { 0.0 };
            Bar::new((first + step) as f64, height).width(1.0).stroke(egui::Stroke::NONE).fill(color)
        });
        BarChart::new(PhaseTimes::NAMES[phase], bars.collect()).color(color)
    };
    let plot = still(Plot::new("phases"))
        .height(76.0)
        .show_axes([false, true])
        .show_x(false)
        .show_y(false)
        .include_y(0.0)
        .include_y(if history.0.is_empty() { 1.0 } else { 0.0 })
        .set_margin_fraction(egui::vec2(0.0, 0.08))
        .y_axis_min_width(36.0)
        .y_grid_spacer(round_marks)
        .y_axis_formatter(|mark, _| mark_text(mark));
    ui.push_id("phases", |ui| {
        plot.show(ui, |plot| {
            let mut charts: Vec<BarChart> = Vec::new();
            for phase in 0..PhaseTimes::COUNT {
                let below: Vec<&BarChart> = charts.iter().collect();
                let stacked = chart(phase).stack_on(&below);
                charts.push(stacked);
            }
            charts.into_iter().for_each(|chart| plot.bar_chart(chart.allow_hover(false)));
            plot.set_plot_bounds_x(-0.5..=STEPS as f64 - 0.5);
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_over_about_ten_steps_in_bounded_memory() {
        let mut history = PhaseHistory::default();
        history.push([0.0; PhaseTimes::COUNT]);
        for _ in 0..10 {
            history.push([1.0; PhaseTimes::COUNT]);
        }
        let mean = history.0.back().unwrap()[0];
        assert!((mean - (1.0 - 0.9_f64.powi(10))).abs() < 1e-12, "{mean}");
        (0..500).for_each(|_| history.push([1.0; PhaseTimes::COUNT]));
        assert_eq!(history.0.len(), STEPS);
    }
}
