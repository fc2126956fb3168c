//! Choosing a setting, or a parameter of the scene, and its values: in the words of the command line, by its parser.

use bevy_egui::egui;

use super::entry::Entered;
use crate::lab::vary::{Assignment, Value, Variation};
use crate::physics::{SETTINGS, SolverSettings};
use crate::scene::SceneInfo;

/// What is on view, as far as it is typed.
#[derive(Clone, Default)]
pub struct Typed {
    name: String,
    values: String,
    entered: Entered,
    /// Why it cannot be had.
    pub problem: Option<String>,
}

impl Typed {
    /// What is chosen; empty where nothing is.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// `name=values`.
    pub fn text(&self) -> String {
        format!("{}={}", self.name, self.values)
    }
}

/// Settings that a step with `settings` reads, by name; of two with one name, one.
pub fn settings_names(settings: &SolverSettings) -> Vec<&'static str> {
    SETTINGS.iter().filter(|setting| setting.is_read(settings)).map(|setting| setting.name).collect()
}

/// What is chosen for, if that is to be said, a list of names, and a line for the values of the one chosen, which `suggest` fills first. Tells whether something else
/// is asked for now.
pub fn show(
    ui: &mut egui::Ui,
    id: &str,
    label: &str,
    names: &[&'static str],
    typed: &mut Typed,
    suggest: impl Fn(&str) -> String,
    about: &str,
) -> bool {
    let mut asked = false;
    ui.horizontal(|ui| {
        if !label.is_empty() {
            ui.label(label);
        }
        let shown = if typed.name.is_empty() { "…" } else { &typed.name };
        egui::ComboBox::from_id_salt(id).selected_text(shown).width(110.0).show_ui(ui, |ui| {
            for &name in names {
                if ui.selectable_label(typed.name == name, name).clicked() && typed.name != name {
                    *typed = Typed { name: name.to_owned(), values: suggest(name), ..Typed::default() };
                    asked = true;
                }
            }
        });
        if !typed.name.is_empty() {
            let line_id = egui::Id::new(id).with("values");
            if typed.problem.is_none() {
                typed.entered.accept(ui.ctx(), line_id);
            }
            let line = egui::TextEdit::singleline(&mut typed.values).desired_width(f32::INFINITY);
            let shown = ui.scope(|ui| typed.entered.show(ui, line_id, line).is_some());
            shown.response.on_hover_text(about);
            asked |= shown.inner;
        }
    });
    if let Some(problem) = &typed.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    asked
}

/// Values about the present one that are worth a look, in the words of the command line.
pub fn suggested_values(name: &str, scene: Option<&SceneInfo>, settings: &SolverSettings) -> String {
    let parameter = scene.and_then(|info| info.parameters.iter().find(|parameter| parameter.name == name));
    if let Some(parameter) = parameter {
        let size = if parameter.default == 0.0 { parameter.max } else { parameter.default };
        let ends = [size / 4.0, size * 4.0].map(|end| end.clamp(parameter.min, parameter.max));
        let [low, high] = if parameter.integer { ends.map(f64::round) } else { ends };
        return format!("{low}:{high}:lin:5");
    }
    let of_name = SETTINGS.iter().filter(|setting| setting.name == name);
    let Some(setting) = of_name.clone().find(|setting| setting.is_read(settings)).or(of_name.clone().next()) else {
        return String::new();
    };
    let choices: Vec<&str> = setting.choices.iter().map(|choice| choice.name).collect();
    match Assignment::of_settings(setting, settings).map(|present| present.value) {
        Some(Value::Number(value)) if value > 0.0 => {
            let whole = value.fract() == 0.0 && Assignment::new(name, "1.5", scene).is_err();
            let ends = |low: f64, high: f64| if whole { [low.round().max(1.0), high.round()] } else { [low, high] };
            let tried = [ends(value / 4.0, value * 4.0), ends(value / 4.0, value), [0.0, 1.0]];
            let texts = tried.map(|[low, high]| match low > 0.0 {
                true => format!("{low}:{high}:log:5"),
                false => format!("{low},{high}"),
            });
            let fits = |text: &&String| Variation::parse(&format!("{name}={text}"), scene).is_ok();
            texts.iter().find(fits).cloned().unwrap_or_else(|| value.to_string())
        }
        Some(Value::Number(_)) => {
            let texts = ["0:1:lin:5", "0:0.5:lin:5", "0,1"];
            let fits = |text: &&&str| Variation::parse(&format!("{name}={text}"), scene).is_ok();
            texts.iter().find(fits).copied().unwrap_or("0").to_owned()
        }
        Some(Value::None) => "0.1,1,None".to_owned(),
        Some(Value::Switch(_)) => "false,true".to_owned(),
        Some(Value::Choice(_)) | None => choices.join(","),
    }
}

/// A value other than the present one.
pub fn suggested_value(name: &str, settings: &SolverSettings) -> String {
    let text = format!("{name}={}", suggested_values(name, None, settings));
    let Ok(variation) = Variation::parse(&text, None) else { return String::new() };
    let differs = |value: &&Assignment| {
        let setting = value.setting();
        setting.is_none_or(|setting| Assignment::of_settings(setting, settings).as_ref() != Some(*value))
    };
    variation.values().iter().rev().find(differs).map_or_else(String::new, |value| value.value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn what_is_suggested_can_be_had_and_is_something_else() {
        for (preset, settings) in SolverSettings::PRESETS {
            let settings = settings();
            for name in settings_names(&settings) {
                let values = suggested_values(name, None, &settings);
                let variation = Variation::parse(&format!("{name}={values}"), None);
                assert!(
                    variation.as_ref().is_ok_and(|variation| variation.values().len() > 1),
                    "{preset}: {name}={values}"
                );
                let value = Assignment::new(name, &suggested_value(name, &settings), None).unwrap();
                let mut changed = settings;
                value.put_in(&mut changed);
                assert_ne!(changed, settings, "{preset}: {value}");
            }
        }
        for info in scene::catalog() {
            for parameter in info.parameters {
                let text = format!(
                    "{}={}",
                    parameter.name,
                    suggested_values(parameter.name, Some(info), &SolverSettings::game())
                );
                let variation =
                    Variation::parse(&text, Some(info)).unwrap_or_else(|error| panic!("{}: {error}", info.name));
                assert!(variation.values().len() > 1, "{}: {text}", info.name);
            }
        }
    }
}
