//! What axes of charts and sweeps have in common.

use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, PlotTransform};

/// Lines at whole powers of ten, four or five of them; in a short range at 2 and 5 times those too. Places are exponents.
pub fn powers(input: GridInput) -> Vec<GridMark> {
    /// Decades in which lines at 1, 2 and 5 are as many as fit.
    const SHORT: f64 = 2.5;
    let (low, high) = input.bounds;
    if !(high - low).is_finite() {
        return Vec::new();
    }
    if high - low < SHORT {
        let decades = low.floor() as i64..=high.floor() as i64;
        let marks = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit: f64| decade as f64 + digit.log10()));
        let within = marks.filter(|value| (low..=high).contains(value));
        return within.map(|value| GridMark { value, step_size: 2_f64.log10() }).collect();
    }
    let step_size = ((high - low) / 5.0).ceil().max(1.0);
    let (first, last) = ((low / step_size).ceil() as i64, (high / step_size).floor() as i64);
    (first..=last).map(|line| GridMark { value: line as f64 * step_size, step_size }).collect()
}

/// The number at a mark of [`powers`].
pub fn power(exponent: f64) -> String {
    // A mark is rounded: a hair below a whole power is that power.
    let decade = (exponent + 1e-9).floor();
    if (-2.0..=4.0).contains(&exponent) {
        let digits = (-decade).max(0.0) as usize;
        format!("{:.digits$}", 10_f64.powf(exponent))
    } else {
        format!("{:.0}e{decade}", 10_f64.powf(exponent - decade))
    }
}

/// A line at what is so now, with a text. Painted over the plot and no item of it: the axes follow the points, and do not
/// waver with the line. Beyond the axes, an arrow points to where it would be.
pub fn mark_now(ui: &egui::Ui, transform: &PlotTransform, place: f64, now: &str) {
    let frame = *transform.frame();
    let x = transform.position_from_point_x(place);
    let shade = egui::Color32::from_gray(215);
    let painter = ui.painter().with_clip_rect(frame.intersect(ui.clip_rect()));
    let (anchor, x, text) = if x < frame.left() {
        (egui::Align2::LEFT_TOP, frame.left(), format!("◀ {now}"))
    } else if x > frame.right() {
        (egui::Align2::RIGHT_TOP, frame.right(), format!("{now} ▶"))
    } else {
        painter.vline(x, frame.y_range(), egui::Stroke::new(1.0, shade.gamma_multiply(0.5)));
        let on_the_left = x < frame.center().x;
        (if on_the_left { egui::Align2::LEFT_TOP } else { egui::Align2::RIGHT_TOP }, x, now.to_owned())
    };
    let gap = if anchor == egui::Align2::LEFT_TOP { 4.0 } else { -4.0 };
    painter.text(egui::pos2(x + gap, frame.top() + 2.0), anchor, text, egui::FontId::proportional(11.0), shade);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_and_long_ranges_have_marks_that_say_what_they_are() {
        let texts = |low: f64, high: f64| -> Vec<String> {
            let marks = powers(GridInput { bounds: (low, high), base_step_size: 0.0 });
            marks.into_iter().map(|mark| power(mark.value)).collect()
        };
        assert_eq!(texts(-1.6, 0.4), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(texts(1.2, 1.8), ["20", "50"]);
        assert_eq!(texts(-9.4, -8.0), ["5e-10", "1e-9", "2e-9", "5e-9", "1e-8"]);
        assert_eq!(texts(-8.0, 1.0), ["1e-8", "1e-6", "1e-4", "0.01", "1"]);
    }
}
