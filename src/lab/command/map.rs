//! `plumb map`.

use std::time::Duration;

use crate::lab::chart::{ChartError, POINTS};
use crate::lab::map::{ATLAS, MapInfo, MapPlan};
use crate::lab::sweep::{Budget, Point, Store, run};

use super::arguments::MapArguments;
use super::chart::{SweepBar, make_folder, tell_ignored};
use super::outcome::{CommandError, Outcome, print};

/// A point of a map that takes longer is drawn as not finished.
const BUDGET: Budget = Budget { most: Duration::from_secs(20), least: Duration::ZERO };

pub(super) fn map(arguments: &MapArguments) -> Result<Outcome, CommandError> {
    if arguments.vary.measure.len() > 1 {
        return Err(CommandError::Usage("a map has room for one --measure".into()));
    }
    let plans = if arguments.vary.is_given()? { vec![varied(arguments)?] } else { chosen(arguments)? };
    make_folder(&arguments.sweep.out)?;
    let mut store = Store::open(&arguments.sweep.out.join(POINTS)).map_err(ChartError::from)?;
    tell_ignored(&store);
    let points: Vec<Point> = plans.iter().flat_map(MapPlan::points).collect();
    let bar = SweepBar::new();
    let records =
        run::<ChartError>(&points, arguments.sweep.shard, BUDGET, &mut store, |p, point| bar.show(&p, point))?;
    bar.finish();
    for mut plan in plans {
        plan.measure = arguments.vary.measure.first().copied().or(plan.measure);
        let path = plan.draw(&plan.maps(&records), &arguments.sweep.out).map_err(ChartError::from)?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(Outcome::Done)
}

/// The map of what is varied.
fn varied(arguments: &MapArguments) -> Result<MapPlan, CommandError> {
    let (study, [x, y]) = arguments.vary.study(&arguments.scenes, &arguments.parameters.list)?;
    Ok(MapPlan::new(study, x, y))
}

/// The maps of the scenes asked for, or all.
fn chosen(arguments: &MapArguments) -> Result<Vec<MapPlan>, CommandError> {
    let scenes = &arguments.scenes;
    if !arguments.parameters.list.is_empty() {
        return Err(CommandError::Usage("-p goes with --vary here: the maps by name have their own parameters".into()));
    }
    let is_of = |map: &MapInfo, scene: &str| map.scene == scene || map.name == scene;
    if let Some(unknown) = scenes.iter().find(|scene| !ATLAS.iter().any(|map| is_of(map, scene))) {
        let names: Vec<&str> = ATLAS.iter().map(|map| map.name).collect();
        let names = names.join(", ");
        return Err(CommandError::Usage(format!(
            "no map of '{unknown}'; there are maps of {names}; --vary makes one of any scene"
        )));
    }
    let asked = ATLAS.iter().filter(|map| scenes.is_empty() || scenes.iter().any(|scene| is_of(map, scene)));
    Ok(asked.map(MapInfo::plan).collect())
}
