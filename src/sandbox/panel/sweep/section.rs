//! The panel's section: what varies, what is measured of it, and the curve.

use bevy::prelude::*;
use bevy_egui::egui;

use super::plot::Shown;
use super::run::{Sweep, plan};
use crate::lab::chart::{Extent, Subject};
use crate::lab::vary::{Curves, MEASURES, Measure, Value};
use crate::physics::{SETTINGS, SolverSettings};
use crate::sandbox::panel::measuring::ChartSource;
use crate::sandbox::panel::vary;
use crate::sandbox::{CurrentScene, Notice, SandboxAction};
use crate::scene::find;

/// Time that can be simulated, s.
const SECONDS: std::ops::RangeInclusive<f64> = 0.02..=600.0;
/// Seconds that a scene from a file is run where none are asked for.
const USUAL_SECONDS: f64 = 2.0;

/// What the section keeps from frame to frame.
pub struct Form {
    typed: vary::Typed,
    /// Time to simulate, s; none: as quick charts have it.
    seconds: Option<f64>,
    measure: &'static Measure,
    /// Whether the quantity's axis is logarithmic, where somebody has said so.
    is_logarithmic: Option<bool>,
    /// The index of the value that the pointer is down on.
    pressed: Option<usize>,
}

impl Default for Form {
    fn default() -> Self {
        let typed = vary::Typed::default();
        Self { typed, seconds: None, measure: &MEASURES[0], is_logarithmic: None, pressed: None }
    }
}

/// The section.
pub fn show(
    InMut(ui): InMut<egui::Ui>,
    scene: Option<Res<CurrentScene>>,
    source: Res<ChartSource>,
    mut sweep: ResMut<Sweep>,
    mut settings: ResMut<SolverSettings>,
    mut notice: ResMut<Notice>,
    mut actions: MessageWriter<SandboxAction>,
    mut form: Local<Form>,
) {
    let Some(scene) = scene else { return };
    let form = &mut *form;
    choose_values(ui, &scene, &settings, &source, form);
    choose_measure(ui, &scene, form);
    ui.horizontal(|ui| run_or_stop(ui, &scene, &settings, &source, &mut sweep, form));
    let Some(curves) = &sweep.curves else {
        ui.weak("the scene as it is loaded, run alone with each of the values: what it measures over them");
        return;
    };
    if let Some(outdated) = sweep.outdated(&scene, &settings) {
        let shown = ui.colored_label(ui.visuals().warn_fg_color, format!("from before: {outdated}"));
        shown.on_hover_text("the curve is of what it was run of; Run makes it anew");
    }
    let shown = Shown::new(curves, &sweep.records, form.measure, form.is_logarithmic);
    if !shown.is_measured() && !shown.dots.is_empty() {
        ui.weak(format!("{}: not known of these runs", form.measure.about));
    }
    let present = sweep.present(&scene, &settings);
    let place = present.and_then(|value| curves.x.place_of(value));
    let now = present.zip(place).map(|(value, place)| (place, format!("now {value}")));
    let picked = shown.draw(ui, now, &mut form.pressed);
    let Curves { study, x } = curves;
    let subject = Subject { scene: study.scene.clone(), parameters: study.parameters.clone() };
    let seconds = Value::Number(study.seconds);
    ui.weak(format!(
        "{} as it is loaded, {seconds} s, over {}; × fails; click: take the value",
        subject.title(),
        x.name()
    ))
    .on_hover_text("each run alone, on one thread; what was built in the window is not in it");
    if let Some(index) = picked {
        take(curves, index, &mut settings, &mut notice, &mut actions);
    }
}

/// What varies, and its values.
fn choose_values(
    ui: &mut egui::Ui,
    scene: &CurrentScene,
    settings: &SolverSettings,
    source: &ChartSource,
    form: &mut Form,
) {
    let info = find(&scene.scene);
    let parameters = info.iter().flat_map(|info| info.parameters).map(|parameter| parameter.name);
    let is_there = |name: &str| SETTINGS.iter().any(|setting| setting.name == name);
    if !parameters.clone().any(|name| name == form.typed.name()) && !is_there(form.typed.name()) {
        // A parameter of another scene.
        form.typed = vary::Typed::default();
    }
    let names: Vec<&str> = parameters.chain(vary::settings_names(settings)).collect();
    let suggest = |name: &str| vary::suggested_values(name, info, settings);
    let about = "values: a,b,c or from:to:lin:count or from:to:log:count, as 'plumb chart --vary' has them";
    if vary::show(ui, "swept", "vary", &names, &mut form.typed, suggest, about) {
        let seconds = form.seconds.unwrap_or(usual_seconds(scene));
        form.typed.problem = plan(&form.typed.text(), seconds, scene, settings, source).err();
    }
}

/// What is measured, and for how long.
fn choose_measure(ui: &mut egui::Ui, scene: &CurrentScene, form: &mut Form) {
    ui.horizontal(|ui| {
        ui.label("measure");
        let list = egui::ComboBox::from_id_salt("measure").selected_text(form.measure.about);
        list.width(170.0).height(320.0).show_ui(ui, |ui| {
            for measure in &MEASURES {
                let is_chosen = form.measure == measure;
                if ui.selectable_label(is_chosen, measure.about).clicked() {
                    form.measure = measure;
                }
            }
        });
        let mut seconds = form.seconds.unwrap_or(usual_seconds(scene));
        let line = egui::DragValue::new(&mut seconds).range(SECONDS).speed(0.02).max_decimals(2).suffix(" s");
        if ui.add(line).on_hover_text("time to simulate").changed() {
            form.seconds = Some(seconds);
        }
    });
}

/// As long as quick charts have it.
fn usual_seconds(scene: &CurrentScene) -> f64 {
    find(&scene.scene).map_or(USUAL_SECONDS, |info| Extent::Quick.seconds(info.seconds))
}

fn run_or_stop(
    ui: &mut egui::Ui,
    scene: &CurrentScene,
    settings: &SolverSettings,
    source: &ChartSource,
    sweep: &mut Sweep,
    form: &mut Form,
) {
    if sweep.is_running() {
        if ui.button("Stop").clicked() {
            sweep.stop(source);
        }
        ui.spinner();
    } else {
        let about = "runs 'plumb chart --vary' on this scene in a process of its own";
        let button = ui.add_enabled(!form.typed.name().is_empty(), egui::Button::new("Run"));
        if button.on_hover_text(about).on_disabled_hover_text("choose first what is to vary").clicked() {
            let seconds = form.seconds.unwrap_or(usual_seconds(scene));
            let planned = plan(&form.typed.text(), seconds, scene, settings, source);
            form.typed.problem = planned.and_then(|curves| sweep.start(curves, source)).err();
        }
    }
    let Some(curves) = &sweep.curves else { return };
    let (done, all) = (sweep.records.len(), curves.x.values().len());
    if done < all {
        ui.label(format!("{done} of {all}"));
    }
    let shown = Shown::new(curves, &sweep.records, form.measure, form.is_logarithmic);
    let mut is_logarithmic = shown.is_logarithmic;
    let switch = ui.add_enabled(shown.can_be_logarithmic, egui::Checkbox::new(&mut is_logarithmic, "log"));
    if switch.on_hover_text("whether the quantity's axis is logarithmic").changed() {
        form.is_logarithmic = Some(is_logarithmic);
    }
}

/// Has the scene be as that point's was in what varies: a setting is set, a parameter loads the scene with it.
fn take(
    curves: &Curves,
    index: usize,
    settings: &mut ResMut<SolverSettings>,
    notice: &mut Notice,
    actions: &mut MessageWriter<SandboxAction>,
) {
    let Curves { study, x } = curves;
    let value = x.values()[index];
    if value.setting().is_some() {
        let mut changed = **settings;
        value.put_in(&mut changed);
        settings.set_if_neq(changed);
        *notice = Notice::Info(format!("took {value} from the sweep"));
        return;
    }
    let mut parameters = study.parameters.clone();
    let is_usual = find(&study.scene)
        .iter()
        .flat_map(|info| info.parameters)
        .any(|parameter| parameter.name == x.name() && value.value == Value::Number(parameter.default));
    if let (Some(number), false) = (value.value.number(), is_usual) {
        parameters.push((x.name().to_owned(), number));
    }
    actions.write(SandboxAction::LoadScene { scene: study.scene.clone(), parameters });
}
