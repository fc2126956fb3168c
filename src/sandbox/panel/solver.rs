//! Every field of [`SolverSettings`], applied at once.
//!
//! [`FIELDS`] and [`RARE_FIELDS`] say how each is shown; the widget follows from its type, what it is and whether it is grey
//! from [`SETTINGS`]. A unit test holds the lists and the table equal.

use std::ops::RangeInclusive;

use bevy::prelude::*;
use bevy::reflect::enums::{DynamicEnum, Enum};
use bevy::reflect::{GetPath, PartialReflect, ReflectMut, ReflectRef};
use bevy_egui::egui;

use super::theme::CHANGED;
use crate::physics::{SETTINGS, Setting, SolverSettings};

/// How a setting is shown. What it is and who reads it, [`SETTINGS`] knows.
struct Field {
    /// [`Setting::path`].
    path: &'static str,
    /// What the panel calls it.
    label: &'static str,
    /// Unit, after the number.
    unit: &'static str,
    /// Range of the slider.
    slider: RangeInclusive<f64>,
    /// What may be typed; contains the slider's range.
    limits: RangeInclusive<f64>,
    /// Whether the slider is logarithmic.
    logarithmic: bool,
    /// Value that an optional number starts at when it is switched on.
    when_on: f64,
}

impl Field {
    /// A choice or a switch.
    const fn choice(path: &'static str, label: &'static str) -> Self {
        Self::number(path, label, "", 0.0..=1.0, 0.0..=1.0)
    }

    /// A number.
    const fn number(
        path: &'static str,
        label: &'static str,
        unit: &'static str,
        slider: RangeInclusive<f64>,
        limits: RangeInclusive<f64>,
    ) -> Self {
        Self { path, label, unit, slider, limits, logarithmic: false, when_on: 0.0 }
    }

    /// An optional number that starts at `value` when it is switched on.
    const fn or_none(mut self, value: f64) -> Self {
        self.when_on = value;
        self
    }

    /// Lets the slider span decades.
    const fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    fn setting(&self) -> &'static Setting {
        SETTINGS.iter().find(|setting| setting.path == self.path).expect("a test holds the fields to the table")
    }

    /// What it is, and what there is to choose from.
    fn help(&self) -> String {
        let setting = self.setting();
        let choices = setting.choices.iter().map(|choice| format!("\n\n{}: {}", spaced(choice.variant), choice.help()));
        setting.help() + &choices.collect::<String>()
    }

    /// Whether it is another value, of a setting that either's method reads.
    fn differs(&self, one: &SolverSettings, other: &SolverSettings) -> bool {
        one.differences(other).any(|setting| setting.path == self.path)
    }

    /// Whether it can be switched off.
    fn is_optional(&self, settings: &mut SolverSettings) -> bool {
        self.value(settings).try_downcast_ref::<Option<f64>>().is_some()
    }

    /// Its value in words.
    fn text(&self, settings: &mut SolverSettings) -> String {
        let number = |value: f64| format!("{value}{}", self.unit);
        let value = self.value(settings);
        if let Some(value) = value.try_downcast_ref::<f64>() {
            number(*value)
        } else if let Some(value) = value.try_downcast_ref::<u32>() {
            number(f64::from(*value))
        } else if let Some(value) = value.try_downcast_ref::<bool>() {
            if *value { "it on".into() } else { "it off".into() }
        } else if let Some(value) = value.try_downcast_ref::<Option<f64>>() {
            value.map_or_else(|| "it off".into(), number)
        } else if let ReflectRef::Enum(value) = value.reflect_ref() {
            spaced(value.variant_name())
        } else {
            String::new()
        }
    }

    fn value<'a>(&self, settings: &'a mut SolverSettings) -> &'a mut dyn PartialReflect {
        settings.reflect_path_mut(self.path).expect("a test holds the fields to the table")
    }
}

/// Fields under a headline.
type Group = (&'static str, &'static [Field]);

/// Groups of fields that are changed often, in the order of the panel.
const FIELDS: &[Group] = &[
    (
        "Step",
        &[
            Field::choice("method", "method"),
            Field::number("hz", "steps per second", " Hz", 10.0..=1000.0, 1.0..=1e9).logarithmic(),
            Field::number("substeps", "substeps", "", 1.0..=32.0, 1.0..=4096.0),
            Field::number("iterations", "iterations", "", 1.0..=100.0, 1.0..=100_000.0).logarithmic(),
            Field::number("threads", "threads", "", 1.0..=16.0, 1.0..=1024.0),
        ],
    ),
    (
        "Laws",
        &[
            Field::choice("friction", "friction"),
            Field::number("restitution_speed", "bounce above", " m/s", 0.0..=5.0, 0.0..=1e6).or_none(0.5),
            Field::number("drag", "drag", " 1/s", 0.0..=5.0, 0.0..=1e6),
            Field::number("impulse.sleep_speed", "sleep below", " m/s", 0.0..=0.5, 0.0..=1e6).or_none(0.02),
        ],
    ),
];

/// Groups of those that are changed rarely.
const RARE_FIELDS: &[Group] = &[
    (
        "All methods",
        &[
            Field::choice("precision", "precision"),
            Field::number("slop", "slop", " m", 0.0..=0.05, 0.0..=10.0),
            Field::number("correction_speed", "repair speed limit", " m/s", 0.0..=10.0, 0.0..=1e6).or_none(3.0),
        ],
    ),
    ("Contacts that last", &[Field::choice("impulse.fitted_effort", "fitted effort")]),
    (
        "Force-level sweeps",
        &[
            Field::choice("sweeps.integrator", "integrator"),
            Field::choice("sweeps.warm_starting", "warm starting"),
            Field::number("sweeps.baumgarte", "position repair", "", 0.0..=1.0, 0.0..=1.0),
            Field::choice("sweeps.nonlinear_projection", "repair of poses"),
            Field::choice("sweeps.contacts", "contacts"),
            Field::choice("sweeps.contacts_ahead", "contacts ahead"),
            Field::number("sweeps.axis_epsilon", "axis merging ε", "", 0.0..=0.5, 0.0..=0.5).logarithmic(),
            Field::choice("sweeps.merge_opposite_axes", "merge ±axes"),
            Field::choice("sweeps.prune_y", "prune on y"),
            Field::number("sweeps.contact_lag", "contact lag", " steps", 0.0..=1.0, 0.0..=1.0),
        ],
    ),
    (
        "Exact",
        &[
            Field::choice("exact.integrator", "integrator"),
            Field::number("exact.time_budget", "time budget", " ms", 0.0..=100.0, 0.0..=1e6).or_none(16.0),
        ],
    ),
];

/// The preset that settings are compared with.
#[derive(Default)]
pub(super) struct Base {
    /// By index; none before anything was compared.
    preset: Option<usize>,
    /// The settings that were looked at last.
    last: SolverSettings,
}

impl Base {
    /// The one that the settings are; else the one that they were changed from, a setting at a time; else the nearest.
    fn follow(&mut self, settings: &SolverSettings) -> Preset {
        let changed = self.last.differences(settings).count();
        self.last = *settings;
        let exactly = SolverSettings::PRESETS.iter().position(|(_, preset)| preset() == *settings);
        let kept = self.preset.filter(|_| changed <= 1);
        let index = exactly.or(kept).unwrap_or_else(|| nearest_preset(settings));
        self.preset = Some(index);
        SolverSettings::PRESETS[index]
    }
}

/// A preset: its name, and what makes its settings.
type Preset = (&'static str, fn() -> SolverSettings);

pub(super) fn show(InMut(ui): InMut<egui::Ui>, mut settings: ResMut<SolverSettings>, mut base: Local<Base>) {
    let mut edited = *settings;
    let preset = base.follow(&settings);
    presets(ui, preset, &mut edited);
    FIELDS.iter().for_each(|group| show_group(ui, group, preset, &mut edited));
    ui.add_space(6.0);
    let changed = fields(RARE_FIELDS).filter(|field| field.differs(&edited, &preset.1())).count();
    let title = match changed {
        0 => "Advanced".to_owned(),
        _ => format!("Advanced ({changed} changed)"),
    };
    egui::CollapsingHeader::new(title).id_salt("advanced").show_unindented(ui, |ui| {
        RARE_FIELDS.iter().for_each(|group| show_group(ui, group, preset, &mut edited));
    });
    settings.set_if_neq(edited);
}

fn fields(groups: &'static [Group]) -> impl Iterator<Item = &'static Field> {
    groups.iter().flat_map(|(_, fields)| fields.iter())
}

fn show_group(ui: &mut egui::Ui, (name, fields): &Group, preset: Preset, settings: &mut SolverSettings) {
    ui.add_space(4.0);
    ui.weak(*name);
    egui::Grid::new(name).num_columns(2).spacing([8.0, 4.0]).min_col_width(118.0).show(ui, |ui| {
        for field in *fields {
            row(ui, field, preset, settings);
            ui.end_row();
        }
    });
}

/// Label and widget, grey where the method does not read the setting, with a dot and a way back where it is not as the preset
/// has it.
fn row(ui: &mut egui::Ui, field: &Field, (name, preset): Preset, settings: &mut SolverSettings) {
    let setting = field.setting();
    let is_read = setting.is_read(settings);
    let why_not = if is_read { String::new() } else { setting.why_unread(settings) };
    let mut preset = preset();
    let differs = field.differs(settings, &preset);
    let usual = differs.then(|| format!("{name} has {}", field.text(&mut preset)));
    let explain = |ui: &mut egui::Ui| {
        usual.iter().for_each(|usual| _ = ui.colored_label(CHANGED, usual));
        ui.label(field.help());
    };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let (dot, _) = ui.allocate_exact_size(egui::vec2(DOT, DOT), egui::Sense::hover());
        if differs {
            ui.painter().circle_filled(dot.center(), 0.5 * DOT, CHANGED);
        }
        let label = ui.add_enabled(is_read, egui::Label::new(field.label));
        label.on_hover_ui(explain).on_disabled_hover_text(why_not.as_str());
    });
    ui.horizontal(|ui| {
        // With room for the way back.
        ui.spacing_mut().slider_width = if field.is_optional(&mut preset) { 54.0 } else { 84.0 };
        let shown = ui.add_enabled_ui(is_read, |ui| widget(ui, field, field.value(settings), &explain));
        shown.response.on_disabled_hover_text(why_not);
        if let Some(usual) = &usual
            && ui.add(egui::Button::new("⟲").small()).on_hover_text(format!("back: {usual}")).clicked()
        {
            field.value(settings).apply(field.value(&mut preset));
        }
    });
}

/// Diameter of the dot before it, points.
const DOT: f32 = 7.0;

/// The preset, by index, that the settings differ from in the fewest fields; of several the first.
fn nearest_preset(settings: &SolverSettings) -> usize {
    let from_preset = |&index: &usize| {
        let (_, preset) = SolverSettings::PRESETS[index];
        preset().differences(settings).count()
    };
    (0..SolverSettings::PRESETS.len()).min_by_key(from_preset).unwrap_or_default()
}

/// One button per preset, and how much the settings differ from the one that they were changed from.
fn presets(ui: &mut egui::Ui, (base, preset): Preset, settings: &mut SolverSettings) {
    let changed = preset().differences(settings).count();
    ui.horizontal_wrapped(|ui| {
        ui.label("preset");
        for (name, preset) in SolverSettings::PRESETS {
            if ui.selectable_label(name == base && changed == 0, name).clicked() {
                *settings = preset();
            }
        }
    });
    // There without a change, too, so that nothing below moves under the pointer with the first.
    ui.horizontal(|ui| {
        if changed == 0 {
            ui.weak(format!("all as {base} has them"));
        } else {
            ui.colored_label(CHANGED, format!("{base}, {changed} changed"));
        }
        let all = ui.add_visible(changed > 0, egui::Button::new("⟲ all").small());
        if all.on_hover_text(format!("all as {base} has them")).clicked() {
            *settings = preset();
        }
    });
}

/// The widget for a value of a type that settings are made of.
fn widget(ui: &mut egui::Ui, field: &Field, value: &mut dyn PartialReflect, explain: &impl Fn(&mut egui::Ui)) {
    if let Some(value) = value.try_downcast_mut::<f64>() {
        number(ui, field, value, explain);
    } else if let Some(value) = value.try_downcast_mut::<u32>() {
        whole_number(ui, field, value, explain);
    } else if let Some(value) = value.try_downcast_mut::<bool>() {
        ui.checkbox(value, "").on_hover_ui(explain);
    } else if let Some(value) = value.try_downcast_mut::<Option<f64>>() {
        ui.horizontal(|ui| {
            let mut on = value.is_some();
            ui.checkbox(&mut on, "").on_hover_ui(explain);
            *value = on.then(|| value.unwrap_or(field.when_on));
            match value {
                Some(value) => number(ui, field, value, explain),
                None => drop(ui.weak("off")),
            }
        });
    } else if let ReflectMut::Enum(value) = value.reflect_mut() {
        choice(ui, field, value, explain);
    }
}

fn number(ui: &mut egui::Ui, field: &Field, value: &mut f64, explain: &impl Fn(&mut egui::Ui)) {
    let slider = egui::Slider::new(value, field.slider.clone())
        .suffix(field.unit)
        .logarithmic(field.logarithmic)
        .smallest_positive(1e-4)
        .clamping(egui::SliderClamping::Never)
        .update_while_editing(false)
        .max_decimals(4);
    ui.add(slider).on_hover_ui(explain);
    if !value.is_finite() {
        *value = *field.slider.start();
    }
    *value = value.clamp(*field.limits.start(), *field.limits.end());
}

fn whole_number(ui: &mut egui::Ui, field: &Field, value: &mut u32, explain: &impl Fn(&mut egui::Ui)) {
    let mut real = f64::from(*value);
    let slider = egui::Slider::new(&mut real, field.slider.clone())
        .suffix(field.unit)
        .logarithmic(field.logarithmic)
        .clamping(egui::SliderClamping::Never)
        .update_while_editing(false)
        .integer();
    ui.add(slider).on_hover_ui(explain);
    *value = real.round().clamp(*field.limits.start(), *field.limits.end()) as u32;
}

/// Any enum of unit variants, so that a method added to the solver is in the panel too.
fn choice(ui: &mut egui::Ui, field: &Field, value: &mut dyn Enum, explain: &impl Fn(&mut egui::Ui)) {
    let names = value.get_represented_enum_info().map_or(&[][..], |info| info.variant_names());
    let mut chosen = value.variant_index();
    egui::ComboBox::from_id_salt(field.path)
        .selected_text(spaced(value.variant_name()))
        .width(150.0)
        .show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(&mut chosen, index, spaced(name));
            }
        })
        .response
        .on_hover_ui(explain);
    if chosen != value.variant_index() {
        value.apply(&DynamicEnum::new(names[chosen], ()));
    }
}

/// `VelocityVerlet` as `Velocity Verlet`.
fn spaced(variant: &str) -> String {
    let mut text = String::with_capacity(variant.len() + 4);
    for letter in variant.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push(' ');
        }
        text.push(letter);
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::physics::Integrator;

    fn all_fields() -> impl Iterator<Item = &'static Field> {
        fields(FIELDS).chain(fields(RARE_FIELDS))
    }

    #[test]
    fn every_setting_has_exactly_one_widget() {
        let all: BTreeSet<_> = SETTINGS.iter().map(|setting| setting.path).collect();
        let shown: BTreeSet<_> = all_fields().map(|field| field.path).collect();
        assert_eq!(shown, all);
        assert_eq!(all_fields().count(), all.len(), "a setting is shown twice");
    }

    /// The texts that the panel shows while the pointer rests on the middle of a setting's label.
    fn shown_over_the_label(field: &Field, mut settings: SolverSettings) -> String {
        let context = egui::Context::default();
        context.global_style_mut(|style| style.interaction.tooltip_delay = 0.0);
        let mut place = egui::Pos2::ZERO;
        let mut shown = String::new();
        for frame in 0..8 {
            let events = vec![egui::Event::PointerMoved(place)];
            let input = egui::RawInput { events, time: Some(f64::from(frame)), ..Default::default() };
            let output = context.run_ui(input, |ui| {
                // Behind the dot.
                place = ui.cursor().min + egui::vec2(24.0, 6.0);
                egui::Grid::new("one").show(ui, |ui| row(ui, field, SolverSettings::PRESETS[0], &mut settings));
            });
            let texts = output.shapes.iter().filter_map(|clipped| match &clipped.shape {
                egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
                _ => None,
            });
            shown = texts.collect::<Vec<_>>().join("\n");
        }
        shown
    }

    #[test]
    fn over_a_label_stands_the_doc_comment_or_why_it_is_grey() {
        let baumgarte = all_fields().find(|field| field.path == "sweeps.baumgarte").unwrap();
        let [steady, game] = [SolverSettings::steady(), SolverSettings::game()].map(|settings| {
            let shown = shown_over_the_label(baumgarte, settings);
            assert!(shown.contains("position repair"), "{shown}");
            shown
        });
        let help = "Share of a position error that one (sub)step aims to remove, 0 to 1";
        assert!(steady.contains(help) && !steady.contains("leave it out"), "{steady}");
        assert!(game.contains("soft_step does not read it, only pgs") && !game.contains(help), "{game}");
    }

    #[test]
    fn a_choice_is_told_with_all_its_values() {
        let method = all_fields().find(|field| field.path == "method").unwrap().help();
        assert!(
            method.starts_with("How contacts and joints are solved.\n\nProjected Gauss Seidel: Projected"),
            "{method}"
        );
        assert!(method.contains("\n\nExact: Joints by their exact forces, J M⁻¹ Jᵀ λ = b solved directly"), "{method}");
    }

    #[test]
    fn whatever_the_widgets_allow_is_valid() {
        for field in all_fields() {
            for bound in [field.limits.start(), field.limits.end(), field.slider.start(), field.slider.end()] {
                let mut settings = SolverSettings::default();
                let value = field.value(&mut settings);
                if let Some(value) = value.try_downcast_mut::<f64>() {
                    *value = *bound;
                } else if let Some(value) = value.try_downcast_mut::<u32>() {
                    *value = *bound as u32;
                } else if let Some(value) = value.try_downcast_mut::<Option<f64>>() {
                    *value = Some(*bound);
                }
                assert_eq!(settings.validate(), Ok(()), "{} at {bound}", field.path);
            }
        }
    }

    /// Draws every widget without a window, with the pointer nowhere: nothing may change, and no
    /// type of field may be without a widget.
    #[test]
    fn drawing_changes_nothing() {
        let context = egui::Context::default();
        for (_, preset) in SolverSettings::PRESETS {
            let mut settings = preset();
            let _ = context.run_ui(egui::RawInput::default(), |ui| {
                for field in all_fields() {
                    let before = ui.min_rect();
                    ui.push_id(field.path, |ui| row(ui, field, SolverSettings::PRESETS[0], &mut settings));
                    assert_ne!(ui.min_rect(), before, "{} has no widget for its type", field.path);
                }
            });
            assert_eq!(settings, preset());
        }
    }

    #[test]
    fn modified_settings_go_by_the_nearest_preset() {
        let name = |settings: SolverSettings| SolverSettings::PRESETS[nearest_preset(&settings)].0;
        let vary = |settings: SolverSettings| SolverSettings {
            hz: 240.0,
            substeps: 7,
            iterations: 20,
            threads: 3,
            drag: 0.5,
            ..settings
        };
        for (preset, settings) in SolverSettings::PRESETS {
            assert_eq!(settings().differences(&settings()).count(), 0);
            let own = if preset == "accurate" { 4 } else { 5 };
            assert_eq!(vary(settings()).differences(&settings()).count(), own, "{preset}");
            assert_eq!(name(settings()), preset);
            assert_eq!(name(vary(settings())), preset);
        }
    }

    #[test]
    fn settings_are_compared_with_the_preset_that_they_were_changed_from() {
        let mut base = Base::default();
        let start = SolverSettings::steady();
        assert_eq!(base.follow(&start).0, "steady");
        // One at a time, until another preset would be nearer.
        let goal = SolverSettings::classic();
        let mut settings = start;
        let paths: Vec<_> = goal.differences(&start).map(|setting| setting.path).collect();
        for path in &paths[..paths.len() - 1] {
            let mut goal = goal;
            let field = all_fields().find(|field| field.path == *path).expect("every setting has a field");
            field.value(&mut settings).apply(field.value(&mut goal));
            assert_eq!(base.follow(&settings).0, "steady", "{path}");
        }
        assert!(paths.len() > 2 && nearest_preset(&settings) != nearest_preset(&start));
        assert_eq!(base.follow(&goal).0, "classic", "what is a preset is that one");
        // From a file.
        let loaded = SolverSettings { hz: 100.0, iterations: 9, ..SolverSettings::game() };
        assert_eq!(base.follow(&loaded).0, "game");
    }

    #[test]
    fn a_changed_setting_says_what_the_preset_has() {
        let text = |path: &str, mut settings: SolverSettings| {
            all_fields().find(|field| field.path == path).unwrap().text(&mut settings)
        };
        let game = SolverSettings::game();
        assert_eq!(text("hz", SolverSettings { hz: 62.5, ..game }), "62.5 Hz");
        assert_eq!(text("threads", SolverSettings { threads: 3, ..game }), "3");
        assert_eq!(text("correction_speed", SolverSettings { correction_speed: None, ..game }), "it off");
        assert_eq!(text("method", SolverSettings { method: crate::physics::Method::SoftStep, ..game }), "Soft Step");
    }

    #[test]
    fn a_choice_is_applied_by_its_variant_name() {
        let mut integrator = Integrator::Euler;
        integrator.apply(&DynamicEnum::new("VelocityVerlet", ()));
        assert_eq!(integrator, Integrator::VelocityVerlet);
        assert_eq!(spaced("VelocityVerlet"), "Velocity Verlet");
        assert_eq!(spaced("F32"), "F32");
    }
}
