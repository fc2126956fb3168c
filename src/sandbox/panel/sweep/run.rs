//! A sweep at work, and what came of it.

use bevy::prelude::*;

use crate::lab::sweep::{Point, Record};
use crate::lab::vary::{Assignment, Candidate, Curves, Study, Value, Variation};
use crate::lab::{read_settings, write_settings};
use crate::physics::{Setting, SolverSettings};
use crate::sandbox::panel::measuring::{ChartSource, Measuring, Progress};
use crate::sandbox::{CurrentScene, Notice};
use crate::scene::find;

/// The file with the settings that a sweep has but for what varies, in the folder of the charts.
const SETTINGS_FILE: &str = "sweep.ron";
/// Settings that are named of those that are others now.
const MOST_NAMES: usize = 3;

/// What was swept last.
#[derive(Resource, Default)]
pub struct Sweep {
    /// What is run; none before the first.
    pub curves: Option<Curves>,
    /// Those that are there, each with the index of its value, in order.
    pub records: Vec<(usize, Record)>,
    measuring: Option<Measuring>,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Sweep>().add_systems(PreUpdate, follow);
}

/// What `plumb chart --vary TEXT` runs of the scene as it is loaded, for so long, s, by those settings, which it reads from a
/// file.
///
/// # Errors
/// Values that cannot be had, or a file that cannot be written.
pub fn plan(
    text: &str,
    seconds: f64,
    scene: &CurrentScene,
    settings: &SolverSettings,
    source: &ChartSource,
) -> Result<Curves, String> {
    let x = Variation::parse(text, find(&scene.scene)).map_err(|error| error.to_string())?;
    let path = source.folder.join(SETTINGS_FILE);
    // Points are measured on one thread.
    let settings = SolverSettings { threads: 1, ..*settings };
    let written = std::fs::create_dir_all(&source.folder).and_then(|()| write_settings(&path, &settings));
    written.map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
    let settings = read_settings(&path).map_err(|error| error.to_string())?;
    let parameters: Vec<_> = scene.parameters.iter().filter(|(name, _)| name != x.name()).cloned().collect();
    let candidates = vec![Candidate::new("sweep", settings)];
    let study = Study::new(&scene.scene, &parameters, candidates, Some(seconds)).map_err(|error| error.to_string())?;
    study.check(&[&x]).map_err(|error| error.to_string())?;
    Ok(Curves { study, x })
}

impl Sweep {
    /// Runs that, in the place of what was swept before.
    ///
    /// # Errors
    /// The program cannot be run.
    pub fn start(&mut self, curves: Curves, source: &ChartSource) -> Result<(), String> {
        let Study { scene, parameters, seconds, .. } = &curves.study;
        let mut arguments = vec![scene.clone()];
        arguments.extend(parameters.iter().flat_map(|(name, value)| ["-p".to_owned(), format!("{name}={value}")]));
        let settings = source.folder.join(SETTINGS_FILE).display().to_string();
        let (varied, seconds) = (curves.x.to_string(), seconds.to_string());
        // Whatever was measured before, so that what is told is of now.
        let options = ["--vary", &varied, "--settings", &settings, "--seconds", &seconds, "--again"];
        arguments.extend(options.map(str::to_owned));
        let since = source.records().len();
        let measuring = Measuring::start(source, since, &arguments).map_err(|error| error.to_string())?;
        *self = Self { curves: Some(curves), records: Vec::new(), measuring: Some(measuring) };
        Ok(())
    }

    /// Whether it is at work.
    pub fn is_running(&self) -> bool {
        self.measuring.is_some()
    }

    /// Ends it; what is measured stays.
    pub fn stop(&mut self, source: &ChartSource) {
        self.read(source);
        self.measuring = None;
    }

    /// Takes in what the measurement at work has written.
    fn read(&mut self, source: &ChartSource) {
        let (Some(curves), Some(measuring)) = (&self.curves, &self.measuring) else { return };
        let rows = source.records();
        let own = rows.get(measuring.since..).unwrap_or_default();
        let of_point = |(index, point): (usize, Point)| {
            let key = point.key();
            own.iter().rev().find(|row| row.key == key).map(|row| (index, row.clone()))
        };
        self.records = curves.points().into_iter().enumerate().filter_map(of_point).collect();
    }

    /// What it was run of that is otherwise now, in one line.
    pub fn outdated(&self, scene: &CurrentScene, settings: &SolverSettings) -> Option<String> {
        let Curves { study, x } = self.curves.as_ref()?;
        if study.scene != scene.scene {
            return Some("another scene is on view now".into());
        }
        let others = scene.parameters.iter().filter(|(name, _)| name != x.name());
        if !study.parameters.iter().eq(others) {
            return Some("the scene has other parameters now".into());
        }
        let was = study.candidates.first()?.settings;
        let differing = was.differences(settings).map(|setting| setting.name);
        let mut names: Vec<&str> = differing.filter(|name| *name != x.name() && *name != "threads").collect();
        let more = if names.len() > MOST_NAMES { ", …" } else { "" };
        names.truncate(MOST_NAMES);
        (!names.is_empty()).then(|| format!("settings are others now: {}{more}", names.join(", ")))
    }

    /// The value that what varies has now, if the scene on view has it.
    pub fn present(&self, scene: &CurrentScene, settings: &SolverSettings) -> Option<Value> {
        let Curves { study, x } = self.curves.as_ref()?;
        // Integrators of two engines share a name.
        let varied: Vec<&'static Setting> = x.values().iter().filter_map(Assignment::setting).collect();
        let read = varied.iter().find(|setting| setting.is_read(settings)).or(varied.first());
        if let Some(setting) = read {
            return Assignment::of_settings(setting, settings).map(|present| present.value);
        }
        if study.scene != scene.scene {
            return None;
        }
        let own = scene.parameters.iter().find(|(name, _)| name == x.name()).map(|(_, value)| *value);
        let usual = || find(&scene.scene)?.parameters.iter().find(|own| own.name == x.name()).map(|own| own.default);
        own.or_else(usual).map(Value::Number)
    }
}

fn follow(source: Res<ChartSource>, mut sweep: ResMut<Sweep>, mut notice: ResMut<Notice>) {
    let Some(measuring) = &mut sweep.bypass_change_detection().measuring else { return };
    match measuring.look(&source) {
        Progress::Nothing => {}
        Progress::More => sweep.read(&source),
        Progress::Ended(outcome) => {
            sweep.stop(&source);
            if let Err(reason) = outcome {
                *notice = Notice::Error(format!("the sweep ended too early: {reason}"));
            }
        }
    }
}
