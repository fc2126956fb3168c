//! The panel's section: who the ghosts are, and a table of how they do beside the scene.

use std::path::Path;

use bevy::prelude::*;
use bevy_egui::egui;

use super::choice::{CHANGED, GhostChoice, Ghosts, MOST_GHOSTS};
use super::ghosts::{GhostReading, GhostReadings};
use super::lane::Reading;
use crate::lab::chart::{SERIES, Series};
use crate::lab::vary::Assignment;
use crate::lab::{read_settings, truth};
use crate::physics::{SolverSettings, StepStats};
use crate::sandbox::panel::{Entered, Quantity, vary};
use crate::sandbox::{CurrentScene, SandboxAction};

/// What the list calls settings that were saved.
const SAVED: &str = "settings of a file";
/// What most people compare, at the head of the list.
const FIRST: [&str; 3] = ["game f32", "classic f32", "accurate f64"];
/// What it calls no ghost.
const NONE: &str = "none";

/// What is being typed for the ghost in that place.
#[derive(Default)]
pub enum Typing {
    #[default]
    Nothing,
    Changed(usize, vary::Typed),
    Saved(usize, String, Entered, Option<String>),
}

/// The section.
pub fn show(
    InMut(ui): InMut<egui::Ui>,
    scene: Option<Res<CurrentScene>>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
    mut ghosts: ResMut<Ghosts>,
    mut readings: ResMut<GhostReadings>,
    mut typing: Local<Typing>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let has_answer = scene.is_some_and(|scene| truth::poses(&scene.spec).is_some());
    let mut chosen = ghosts.0.clone();
    for place in 0..(chosen.len() + 1).min(MOST_GHOSTS) {
        choose(ui, place, has_answer, &mut chosen, &mut typing);
        type_for(ui, place, &settings, &mut chosen, &mut typing);
    }
    ghosts.set_if_neq(Ghosts(chosen));
    if readings.ghosts.is_empty() {
        return;
    }
    ui.horizontal(|ui| {
        let again = ui.button("from the start").on_hover_text("the scene and its ghosts once more from its start");
        if again.clicked() {
            actions.write(SandboxAction::Reset);
        }
        ui.label("apart from");
        let mut limit = 1e3 * readings.limit;
        let line = egui::DragValue::new(&mut limit).range(0.001..=1e4).suffix(" mm").speed(0.1);
        if ui
            .add(line)
            .on_hover_text("the distance from which on a ghost counts as parted: marked on the strip")
            .changed()
        {
            readings.limit = 1e-3 * limit;
            readings.ghosts.iter_mut().for_each(|ghost| ghost.parted = None);
        }
    });
    table(ui, &readings, &settings, &stats);
}

/// The list of one ghost.
fn choose(ui: &mut egui::Ui, place: usize, has_answer: bool, chosen: &mut Vec<GhostChoice>, typing: &mut Typing) {
    let is_typed = match typing {
        Typing::Changed(at, _) | Typing::Saved(at, ..) => *at == place,
        Typing::Nothing => false,
    };
    let shown = match (&*typing, chosen.get(place)) {
        (Typing::Changed(..), _) if is_typed => CHANGED.to_owned(),
        (Typing::Saved(..), _) if is_typed => SAVED.to_owned(),
        (_, Some(choice)) => choice.name(),
        (_, None) => NONE.to_owned(),
    };
    ui.horizontal(|ui| {
        let about = "the scene run on from here by another method, translucent; your hand does not reach it";
        ui.label(if place == 0 { "run on by" } else { "and by" }).on_hover_text(about);
        egui::ComboBox::from_id_salt(("ghost", place)).selected_text(shown).width(190.0).show_ui(ui, |ui| {
            let mut picked = None;
            let present = chosen.get(place);
            let mut pick = |ui: &mut egui::Ui, name: &str, choice: Option<GhostChoice>| {
                let response = ui.selectable_label(!is_typed && present == choice.as_ref(), name);
                if response.clicked() {
                    picked = Some(choice);
                }
                response
            };
            pick(ui, NONE, None);
            let is_first = |(_, series): &(usize, &Series)| FIRST.contains(&series.name);
            let (first, others): (Vec<_>, Vec<_>) = SERIES.iter().enumerate().partition(is_first);
            for (index, series) in first.into_iter().chain(others) {
                pick(ui, series.name, Some(GhostChoice::Method(index)));
            }
            ui.add_enabled_ui(has_answer, |ui| {
                pick(ui, "reference answer", Some(GhostChoice::Reference))
                    .on_disabled_hover_text("the answer of this scene does not give the whole motion");
            });
            let about = "the settings on view with one thing changed";
            if ui.selectable_label(false, CHANGED).on_hover_text(about).clicked() {
                *typing = Typing::Changed(place, vary::Typed::default());
            }
            if ui.selectable_label(false, SAVED).on_hover_text("as 'save settings' writes them").clicked() {
                *typing = Typing::Saved(place, String::new(), Entered::default(), None);
            }
            if let Some(choice) = picked {
                *typing = Typing::Nothing;
                put(chosen, place, choice);
            }
        });
    });
}

/// Has that ghost be another, or none.
fn put(chosen: &mut Vec<GhostChoice>, place: usize, choice: Option<GhostChoice>) {
    match choice {
        Some(choice) if place < chosen.len() => chosen[place] = choice,
        Some(choice) => chosen.push(choice),
        None if place < chosen.len() => _ = chosen.remove(place),
        None => {}
    }
}

/// The line in which what that ghost is to be is typed, if it is.
fn type_for(
    ui: &mut egui::Ui,
    place: usize,
    settings: &SolverSettings,
    chosen: &mut Vec<GhostChoice>,
    typing: &mut Typing,
) {
    match typing {
        Typing::Changed(at, typed) if *at == place => {
            let names = vary::settings_names(settings);
            let suggest = |name: &str| vary::suggested_value(name, settings);
            let about = "the ghost's value; Enter lets it run on from here";
            if vary::show(ui, "changed setting", "", &names, typed, suggest, about) {
                let changed = Assignment::parse(&typed.text(), None);
                typed.problem = changed.as_ref().err().map(ToString::to_string);
                if let Ok(changed) = changed {
                    put(chosen, place, Some(GhostChoice::Changed(changed)));
                }
            }
        }
        Typing::Saved(at, file, entered, problem) if *at == place => {
            let id = egui::Id::new(("ghost's settings", place));
            let line = egui::TextEdit::singleline(file).hint_text("settings.ron").desired_width(f32::INFINITY);
            if entered.show(ui, id, line).is_some() && !file.trim().is_empty() {
                match read_settings(Path::new(file.trim())) {
                    Ok(settings) => {
                        entered.accept(ui.ctx(), id);
                        *problem = None;
                        let name =
                            Path::new(file.trim()).file_stem().unwrap_or_default().to_string_lossy().into_owned();
                        put(chosen, place, Some(GhostChoice::Saved(name, Box::new(settings))));
                    }
                    Err(error) => *problem = Some(error.to_string()),
                }
            }
            if let Some(problem) = problem {
                ui.colored_label(ui.visuals().error_fg_color, problem.as_str());
            }
        }
        _ => {}
    }
}

/// A column for the scene and one for each ghost.
fn table(ui: &mut egui::Ui, readings: &GhostReadings, settings: &SolverSettings, stats: &StepStats) {
    let color = |[r, g, b]: [u8; 3]| egui::Color32::from_rgb(r, g, b);
    let text = |ui: &mut egui::Ui, text: String| ui.label(egui::RichText::new(text).small());
    let readings_of =
        || std::iter::once(Some(&readings.scene)).chain(readings.ghosts.iter().map(|ghost| ghost.reading.as_ref()));
    egui::Grid::new("ghosts").striped(true).spacing([6.0, 2.0]).min_col_width(58.0).show(ui, |ui| {
        text(ui, String::new());
        text(ui, "the scene".into());
        for ghost in &readings.ghosts {
            let head = egui::RichText::new(format!("■ {}", ghost.short_name())).small();
            ui.label(head.color(color(ghost.color))).on_hover_text(&ghost.name);
        }
        ui.end_row();
        for (what, value) in [
            ("apart", (|ghost| Quantity::text(ghost.apart.distance, "m")) as fn(&GhostReading) -> String),
            ("turned", |ghost| Quantity::text(ghost.apart.angle.to_degrees(), "°")),
        ] {
            text(ui, what.into());
            text(ui, String::new());
            for ghost in &readings.ghosts {
                text(ui, value(ghost));
            }
            ui.end_row();
        }
        text(ui, "apart at".into());
        text(ui, String::new());
        for ghost in &readings.ghosts {
            // Steps back from now, of the length that they have now.
            let time =
                ghost.parted.map(|step| stats.time - (stats.steps - step.min(stats.steps)) as f64 * settings.step());
            text(ui, time.map_or_else(|| "not yet".into(), |time| format!("{time:.2} s")));
        }
        ui.end_row();
        for (what, value) in [
            ("energy", (|reading| Quantity::text(reading.energy, "J")) as fn(&Reading) -> String),
            ("joint gap", |reading| Quantity::text(reading.joint_gap, "m")),
            ("overlap", |reading| Quantity::text(reading.overlap, "m")),
            ("a step", |reading| Quantity::text(reading.step_seconds, "s")),
        ] {
            text(ui, what.into());
            for reading in readings_of() {
                text(ui, reading.map_or_else(|| "–".into(), value));
            }
            ui.end_row();
        }
        text(ui, "fails".into());
        for reading in readings_of() {
            match reading.and_then(|reading| reading.failed.as_ref()) {
                Some((time, why)) => {
                    let said = egui::RichText::new(format!("at {time:.2} s")).small();
                    ui.colored_label(ui.visuals().error_fg_color, said).on_hover_text(why)
                }
                None => text(ui, "no".into()),
            };
        }
        ui.end_row();
    });
}
