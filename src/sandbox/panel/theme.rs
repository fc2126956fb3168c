//! How the panel looks, and how it writes numbers.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

/// Colors told apart by color-blind people too (Okabe and Ito 2008), shared by plots and gizmos.
pub mod palette {
    /// Orange.
    pub const ORANGE: [u8; 3] = [230, 159, 0];
    /// Sky blue.
    pub const SKY: [u8; 3] = [86, 180, 233];
    /// Bluish green.
    pub const GREEN: [u8; 3] = [0, 158, 115];
    /// Yellow.
    pub const YELLOW: [u8; 3] = [240, 228, 66];
    /// Vermilion.
    pub const VERMILION: [u8; 3] = [213, 94, 0];
    /// Reddish purple.
    pub const PURPLE: [u8; 3] = [204, 121, 167];
}

/// Sets egui's style, and what it takes for a click, once, at the first pass.
pub fn apply(mut contexts: EguiContexts, mut done: Local<bool>) -> Result {
    if *done {
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    context.set_theme(egui::Theme::Dark);
    // However long the button is held: a slow hand clicks too, and so does any hand where frames are slow.
    context.options_mut(|options| {
        options.input_options.max_click_duration = f64::INFINITY;
        // The sandbox has keys of its own for it.
        options.zoom_with_keyboard = false;
    });
    context.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = egui::Color32::from_rgb(27, 29, 33);
        visuals.window_fill = visuals.panel_fill;
        visuals.widgets.noninteractive.fg_stroke.color = egui::Color32::from_gray(205);
        visuals.widgets.inactive.fg_stroke.color = egui::Color32::from_gray(215);
        visuals.error_fg_color = egui::Color32::from_rgb(255, 110, 90);
        visuals.slider_trailing_fill = true;
        visuals.selection.bg_fill = egui::Color32::from_rgb(0, 92, 140);
        style.spacing.slider_width = 96.0;
        style.interaction.tooltip_delay = 0.35;
    });
    *done = true;
    Ok(())
}

/// A body as the panel calls it: each joint of the world has a body of its own to hold on to.
pub fn name_of(name: Option<&Name>, body: Entity) -> String {
    match name {
        Some(name) if name.starts_with("world:") => "the world".into(),
        Some(name) => name.to_string(),
        None => body.to_string(),
    }
}

/// The one unit that takes no prefix.
const DEGREE: &str = "°";

/// A unit with an SI prefix that keeps numbers between 1 and 1000.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// What a value in the plain unit is multiplied with.
    pub factor: f64,
    /// The unit with its prefix.
    pub unit: String,
}

impl Quantity {
    /// The prefix that suits `largest`, in `unit`.
    pub fn suiting(largest: f64, unit: &str) -> Self {
        const LEAST: (f64, &str) = (1e-9, "n");
        const PREFIXES: [(f64, &str); 6] = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")];
        let (size, prefix) = PREFIXES
            .into_iter()
            .find(|(size, _)| largest.abs() >= *size)
            .filter(|_| unit != DEGREE)
            .unwrap_or(if largest == 0.0 || unit == DEGREE { (1.0, "") } else { LEAST });
        Self { factor: 1.0 / size, unit: format!("{prefix}{unit}") }
    }

    /// A value with its suiting unit, three digits.
    pub fn text(value: f64, unit: &str) -> String {
        if !value.is_finite() {
            return format!("{value} {unit}");
        }
        let suiting = Self::suiting(value, unit);
        let space = if unit == DEGREE { "" } else { " " };
        format!("{}{space}{}", suiting.number(value), suiting.unit)
    }

    /// A value in this unit, without it: three digits, and no more than two decimals.
    pub fn number(&self, value: f64) -> String {
        let scaled = value * self.factor;
        let decimals = match scaled.abs() {
            size if size >= 99.95 || size == 0.0 => 0,
            size if size >= 9.995 => 1,
            _ => 2,
        };
        without_negative_zero(format!("{scaled:.decimals$}"))
    }
}

/// A number that was rounded to nothing has no sign: a space in its place keeps columns, but at the left end nothing.
pub fn without_negative_zero(text: String) -> String {
    match text.trim_start().strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => {
            if text.starts_with('-') {
                digits.to_owned()
            } else {
                text.replacen('-', " ", 1)
            }
        }
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_carry_three_digits_and_a_prefix() {
        assert_eq!(Quantity::text(0.0, "J"), "0 J");
        assert_eq!(Quantity::text(1234.0, "J"), "1.23 kJ");
        assert_eq!(Quantity::text(-0.0456, "m"), "-45.6 mm");
        assert_eq!(Quantity::text(5e-9, "m"), "5.00 nm");
        assert_eq!(Quantity::text(5e-11, "m"), "0.05 nm");
        assert_eq!(Quantity::text(1234.0, "°"), "1234°");
        assert_eq!(Quantity::text(-0.0456, "°"), "-0.05°");
        assert_eq!(Quantity::text(123.4, "kg"), "123 kg");
        assert_eq!(Quantity::text(f64::NAN, "J"), "NaN J");
        assert_eq!(Quantity::text(-0.0, "J"), "0 J");
        assert_eq!(Quantity::text(-1e-12, "m"), "0.00 nm");
        assert_eq!(Quantity::suiting(1.0, "J").number(-0.001), "0.00");
    }

    #[test]
    fn nothing_is_not_negative() {
        for (text, expected) in [("-0.00", "0.00"), ("  -0.000", "   0.000"), ("-0.01", "-0.01"), ("-10", "-10")] {
            assert_eq!(without_negative_zero(text.to_owned()), expected);
        }
    }
}
