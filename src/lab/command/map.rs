//! `plumb map`.

use std::time::Duration;

use crate::lab::chart::{ChartError, POINTS};
use crate::lab::map::{ATLAS, MapInfo};
use crate::lab::sweep::{Budget, Point, Store, run};

use super::arguments::MapArguments;
use super::chart::{SweepBar, make_folder, tell_ignored};
use super::outcome::{CommandError, Outcome, print};

/// A point of a map that takes longer is drawn as not finished.
const BUDGET: Budget = Budget { most: Duration::from_secs(20), least: Duration::ZERO };

pub(super) fn map(arguments: &MapArguments) -> Result<Outcome, CommandError> {
    let maps = chosen(&arguments.scenes)?;
    make_folder(&arguments.sweep.out)?;
    let mut store = Store::open(&arguments.sweep.out.join(POINTS)).map_err(ChartError::from)?;
    tell_ignored(&store);
    let points: Vec<Point> = maps.iter().flat_map(|map| map.points()).collect();
    let bar = SweepBar::new();
    let records =
        run::<ChartError>(&points, arguments.sweep.shard, BUDGET, &mut store, |p, point| bar.show(&p, point))?;
    bar.finish();
    for map in maps {
        map.draw(&map.maps(&records), &arguments.sweep.out).map_err(ChartError::from)?;
        print(&format!("{}\n", arguments.sweep.out.join(format!("map-{}.svg", map.name)).display()))?;
    }
    Ok(Outcome::Done)
}

/// The maps of the scenes asked for, or all.
fn chosen(scenes: &[String]) -> Result<Vec<&'static MapInfo>, CommandError> {
    let is_of = |map: &&MapInfo, scene: &str| map.scene == scene || map.name == scene;
    if let Some(unknown) = scenes.iter().find(|scene| !ATLAS.iter().any(|map| is_of(&map, scene))) {
        let names: Vec<&str> = ATLAS.iter().map(|map| map.name).collect();
        return Err(CommandError::Usage(format!("no map of '{unknown}'; there are maps of {}", names.join(", "))));
    }
    Ok(ATLAS.iter().filter(|map| scenes.is_empty() || scenes.iter().any(|scene| is_of(map, scene))).collect())
}
