//! `plumb chart`.

use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::lab::chart::{ChartError, Extent, POINTS, Subject, draw_all, read_peers};
use crate::lab::sweep::{Budget, Point, Progress, Record, Store, run};
use crate::lab::vary::Curves;
use crate::scene;

use super::arguments::ChartArguments;
use super::outcome::{CommandError, Outcome, print};
use super::vary::usual_measures;

pub(super) fn chart(arguments: &ChartArguments) -> Result<Outcome, CommandError> {
    let extent = if arguments.quick { Extent::Quick } else { Extent::Full };
    if arguments.vary.is_given()? {
        return curves(arguments, extent);
    }
    if !arguments.vary.measure.is_empty() {
        return Err(CommandError::Usage("--measure goes with --vary here: other charts are of error and cost".into()));
    }
    let subjects = subjects(arguments)?;
    let peers = arguments.peers.as_deref().map(read_peers).transpose()?.unwrap_or_default();
    let plans: Vec<(Subject, Vec<Point>)> = subjects
        .into_iter()
        .map(|subject| subject.points(extent).map(|points| (subject, points)))
        .collect::<Result<_, _>>()?;
    let points: Vec<Point> = plans.iter().flat_map(|(_, points)| points).cloned().collect();
    let records = measure(arguments, &points, extent)?;
    let charts: Vec<_> = plans
        .into_iter()
        .map(|(subject, points)| {
            let keys: std::collections::HashSet<String> = points.iter().map(Point::key).collect();
            let records = records.iter().filter(|record| keys.contains(&record.key)).cloned().collect();
            (subject, records)
        })
        .collect();
    draw_all(&arguments.sweep.out, &charts, &peers)?;
    print(&format!("{}\n", arguments.sweep.out.join("index.html").display()))?;
    Ok(Outcome::Done)
}

/// The picture of what is varied.
fn curves(arguments: &ChartArguments, extent: Extent) -> Result<Outcome, CommandError> {
    let (mut study, [x]) = arguments.vary.study(&arguments.scenes, &arguments.parameters.list)?;
    study.seconds = extent.seconds(study.seconds);
    let curves = Curves { study, x };
    let records = measure(arguments, &curves.points(), extent)?;
    let measures = match arguments.vary.measure.as_slice() {
        [] => usual_measures(),
        measures => measures.to_vec(),
    };
    let path = curves.draw(&records, &measures, &arguments.sweep.out).map_err(ChartError::from)?;
    print(&format!("{}\n", path.display()))?;
    Ok(Outcome::Done)
}

/// Measures the points that the folder does not have, or all that are to be measured again.
fn measure(arguments: &ChartArguments, points: &[Point], extent: Extent) -> Result<Vec<Record>, CommandError> {
    make_folder(&arguments.sweep.out)?;
    let mut store = Store::open(&arguments.sweep.out.join(POINTS)).map_err(ChartError::from)?;
    tell_ignored(&store);
    if arguments.again {
        let is_mine = |key: &String| arguments.sweep.shard.has(key);
        let keys: Vec<String> = points.iter().map(Point::key).filter(is_mine).collect();
        store.set_aside(&keys);
    }
    let bar = SweepBar::new();
    let records =
        run::<ChartError>(points, arguments.sweep.shard, budget(extent), &mut store, |p, point| bar.show(&p, point))?;
    bar.finish();
    Ok(records)
}

/// The scenes asked for, or all.
fn subjects(arguments: &ChartArguments) -> Result<Vec<Subject>, CommandError> {
    let parameters = &arguments.parameters.list;
    match arguments.scenes.as_slice() {
        [scene] => Ok(vec![Subject { scene: scene.clone(), parameters: parameters.clone() }]),
        _ if !parameters.is_empty() => {
            Err(CommandError::Usage("-p sets a parameter of one scene: name exactly one scene with it".into()))
        }
        [] => Ok(scene::catalog()
            .iter()
            .map(|info| Subject { scene: info.name.into(), parameters: Vec::new() })
            .collect()),
        scenes => Ok(scenes.iter().map(|scene| Subject { scene: scene.clone(), parameters: Vec::new() }).collect()),
    }
}

/// A quick chart of a scene is drawn in seconds, a full one in minutes.
fn budget(extent: Extent) -> Budget {
    match extent {
        Extent::Quick => Budget { most: Duration::from_secs(4), least: Duration::from_millis(30) },
        Extent::Full => Budget { most: Duration::from_secs(30), least: Duration::from_millis(300) },
    }
}

pub(super) fn make_folder(folder: &Path) -> Result<(), CommandError> {
    std::fs::create_dir_all(folder).map_err(CommandError::unwritable(folder))
}

/// Rows that are passed over are not passed over in silence.
pub(super) fn tell_ignored(store: &Store) {
    if store.ignored() > 0 {
        eprintln!("plumb: {} rows by another build of plumb, or cut short, are left aside", store.ignored());
    }
}

/// Points done, the one at work, time left; on standard error.
pub(super) struct SweepBar(ProgressBar);

impl SweepBar {
    pub fn new() -> Self {
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len}, {eta} left  {msg:30}");
        Self(ProgressBar::new(0).with_style(style.expect("a template of this file")))
    }

    pub fn show(&self, progress: &Progress, point: &Point) {
        self.0.set_length(progress.all as u64);
        if self.0.position() == 0 {
            // What an earlier run left counts as done, and not in the time that a point takes.
            self.0.reset_eta();
        }
        self.0.set_position(progress.done as u64);
        self.0.set_message(format!("{} {}", point.scene, point.parameters_text()));
    }

    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
