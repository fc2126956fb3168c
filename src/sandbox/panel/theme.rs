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

/// What is not as the preset has it, or did not get where it was to.
pub(super) const CHANGED: egui::Color32 = egui::Color32::from_rgb(240, 176, 64);

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
        color(&mut style.visuals);
        for (of, size) in SIZES {
            if let Some(font) = style.text_styles.get_mut(&of) {
                font.size = size;
            }
        }
        style.spacing.slider_width = 96.0;
        style.interaction.tooltip_delay = 0.35;
    });
    *done = true;
    Ok(())
}

/// Heights of text, points.
const SIZES: [(egui::TextStyle, f32); 4] = [
    (egui::TextStyle::Small, SMALL),
    (egui::TextStyle::Body, 13.5),
    (egui::TextStyle::Button, 13.5),
    (egui::TextStyle::Monospace, 13.0),
];
/// Of the smallest text.
pub const SMALL: f32 = 12.0;
/// Of headers and of the names of pages.
pub const HEADER: f32 = 15.0;

/// Behind what is switched on. What is chosen of several has the color of a selection.
pub const ON: egui::Color32 = egui::Color32::from_rgb(14, 98, 72);

fn color(visuals: &mut egui::Visuals) {
    let gray = egui::Color32::from_gray;
    visuals.panel_fill = egui::Color32::from_rgb(27, 29, 33);
    visuals.window_fill = visuals.panel_fill;
    visuals.widgets.noninteractive.fg_stroke.color = gray(210);
    visuals.widgets.inactive.fg_stroke.color = gray(222);
    visuals.weak_text_color = Some(gray(165));
    visuals.error_fg_color = egui::Color32::from_rgb(255, 122, 102);
    visuals.slider_trailing_fill = true;
    visuals.selection.bg_fill = egui::Color32::from_rgb(0, 92, 140);
    visuals.selection.stroke.color = egui::Color32::from_rgb(214, 234, 255);
    visuals.collapsing_header_frame = true;
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

    /// Relative luminance by WCAG 2.2.
    fn luminance(color: egui::Color32) -> f64 {
        let linear = |part: u8| match f64::from(part) / 255.0 {
            part if part <= 0.04045 => part / 12.92,
            part => ((part + 0.055) / 1.055).powf(2.4),
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    #[test]
    fn text_can_be_read_on_what_it_is_written_on() {
        let mut visuals = egui::Visuals::dark();
        color(&mut visuals);
        let buttons = [&visuals.widgets.inactive, &visuals.widgets.hovered, &visuals.widgets.active];
        let mut pairs = vec![
            ("text", visuals.text_color(), visuals.panel_fill),
            ("weak text", visuals.weak_text_color(), visuals.panel_fill),
            ("strong text", visuals.strong_text_color(), visuals.panel_fill),
            ("an error", visuals.error_fg_color, visuals.panel_fill),
            ("a warning", visuals.warn_fg_color, visuals.panel_fill),
            ("what is typed", visuals.text_color(), visuals.extreme_bg_color),
            ("what is chosen", visuals.selection.stroke.color, visuals.selection.bg_fill),
            ("what is on", visuals.widgets.inactive.text_color(), ON),
        ];
        pairs.extend(buttons.map(|button| ("a button", button.text_color(), button.weak_bg_fill)));
        for (what, text, fill) in pairs {
            let (one, other) = (luminance(text) + 0.05, luminance(fill) + 0.05);
            let contrast = one.max(other) / one.min(other);
            assert!(contrast >= 4.5, "{what}: {contrast:.1}, WCAG 2.2 wants 4.5 (1.4.3)");
        }
        assert!(SIZES.iter().all(|(_, size)| *size >= SMALL));
    }

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
