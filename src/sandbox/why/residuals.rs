//! How the solves of the last step came to their ends, as a plot.

use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, HoverPosition, Line, Plot, PlotPoints, Points};

use crate::lab::round_step;
use crate::physics::{SolveTrace, SolverSettings, StepStats};
use crate::sandbox::axes::{color32, every, power, powers, still};
use crate::sandbox::panel::{Quantity, palette};

/// Under it, m/s, all is rounding: what is less, or zero, is drawn there.
const FLOOR: f64 = 1e-16;
/// Up to so many numbers each has a dot.
const DOTS: usize = 80;

/// The plot, with a caption.
pub(super) fn show(ui: &mut egui::Ui, settings: &SolverSettings, stats: &StepStats, trace: Option<&SolveTrace>) {
    let solves = trace.filter(|trace| trace.step == stats.steps && trace.step > 0);
    let solves = solves.map(|trace| &trace.residuals.solves[..]);
    let lines = lines(solves.unwrap_or_default());
    let last = lines.last().and_then(|line| line.last()).map(|[_, exponent]| 10_f64.powf(*exponent));
    ui.horizontal(|ui| {
        ui.label("residual, m/s").on_hover_text(about(settings));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(last) = last {
                let text = format!("at the end {}", Quantity::text(last, "m/s"));
                ui.label(egui::RichText::new(text).small());
            }
        });
    });
    if lines.is_empty() {
        let why = match solves {
            None => "not measured in this step",
            Some(_) => "nothing was swept in this step: solved directly, or nothing to solve",
        };
        ui.weak(why);
        return;
    }
    draw(ui, &lines);
}

/// What is measured.
fn about(settings: &SolverSettings) -> &'static str {
    match (settings.method.keeps_contacts(), settings.method.is_force_level()) {
        (true, _) => {
            "of each sweep of the last step, over all substeps: the largest change that it made to the velocity of a point \
             of a body, |Δv| + R |Δω|; a line is the sweeps of one solve (of a soft step's substep two: with springs, then \
             without). Islands that are solved directly have none"
        }
        (_, true) => {
            "of each sweep of the last step, over all substeps: the largest change that it made to the velocity of a point \
             of a body, |Δv| + R |Δω|; a line is the sweeps of one solve. Where they fall slowly, more sweeps would help \
             little"
        }
        _ => {
            "of each iteration of the last step: how far contacts, and joints beside them, are from their laws (the natural \
             map); a line is one solve: for positions, then for velocities, then for impacts. Joints without contacts are \
             not in it"
        }
    }
}

/// Sweeps that are counted on from solve to solve, and the logarithm of their residual; of each solve a line.
fn lines(solves: &[Vec<f64>]) -> Vec<Vec<[f64; 2]>> {
    let mut sweep = 0.0;
    let mut next = |residual: &f64| {
        sweep += 1.0;
        let sized = if residual.is_finite() { residual.max(FLOOR) } else { f64::NAN };
        [sweep, sized.log10()]
    };
    let lines = solves.iter().filter(|solve| !solve.is_empty());
    let lines: Vec<Vec<_>> = lines.map(|solve| solve.iter().map(&mut next).collect()).collect();
    let drawn = |line: Vec<[f64; 2]>| line.into_iter().filter(|[_, size]| size.is_finite()).collect::<Vec<_>>();
    lines.into_iter().map(drawn).filter(|line| !line.is_empty()).collect()
}

fn draw(ui: &mut egui::Ui, lines: &[Vec<[f64; 2]>]) {
    let count: usize = lines.iter().map(Vec::len).sum();
    let last = lines.last().and_then(|line| line.last()).map_or(1.0, |[sweep, _]| *sweep);
    let sizes = lines.iter().flatten().map(|[_, size]| *size);
    let (low, high) =
        sizes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), size| (low.min(size), high.max(size)));
    let plot = still(Plot::new("residual"))
        .height(84.0)
        .y_axis_min_width(36.0)
        .y_grid_spacer(powers)
        .x_grid_spacer(whole_marks)
        .y_axis_formatter(|mark, _| power(mark.value))
        .x_axis_formatter(|mark, _| format!("{:.0}", mark.value))
        .label_formatter(|position| match position {
            HoverPosition::NearDataPoint { position, .. } => {
                Some(format!("{}\nsweep {:.0}", Quantity::text(10_f64.powf(position.y), "m/s"), position.x))
            }
            HoverPosition::Elsewhere { .. } => None,
        });
    let color = color32(palette::SKY);
    // egui counts the widgets inside a plot anew at each pass; its id keeps the next ones' stable.
    ui.push_id("residual", |ui| {
        plot.show(ui, |plot| {
            for line in lines {
                plot.line(Line::new("residual", PlotPoints::from(line.clone())).color(color).width(1.5));
                if count <= DOTS {
                    plot.points(Points::new("residual", PlotPoints::from(line.clone())).color(color).radius(2.2));
                }
            }
            plot.set_plot_bounds_x(0.5..=last + 0.5);
            // Whole powers of ten, one at least above the other.
            let low = (low - 0.1).floor();
            plot.set_plot_bounds_y(low..=(high + 0.1).ceil().max(low + 1.0));
        });
    });
}

/// At most ten lines at whole numbers.
fn whole_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(high - low).is_finite() {
        return Vec::new();
    }
    every(round_step((high - low) / 8.0).max(1.0), input.bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_counted_on_and_what_is_no_number_is_left_out() {
        let drawn = lines(&[vec![1.0, 0.1], vec![], vec![0.0, f64::NAN, 10.0]]);
        assert_eq!(drawn, [vec![[1.0, 0.0], [2.0, -1.0]], vec![[3.0, -16.0], [5.0, 1.0]]]);
        assert!(lines(&[vec![f64::INFINITY]]).is_empty());
    }

    #[test]
    fn marks_are_whole_numbers_and_few() {
        for high in [1.5, 8.5, 40.5, 3000.5] {
            let marks = whole_marks(GridInput { bounds: (0.5, high), base_step_size: 0.0 });
            assert!((1..=10).contains(&marks.len()), "{high}: {marks:?}");
            assert!(marks.iter().all(|mark| mark.value.fract() == 0.0));
        }
    }
}
