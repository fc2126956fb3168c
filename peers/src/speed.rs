//! What a step costs: all engines step the same scene in alternation, in blocks of steps, so that a
//! machine that gets slower or faster meanwhile does so for all.

use std::time::{Duration, Instant};

use crate::engine::{EngineKind, Run, Settings, Unable};
use crate::overlap;
use crate::plan::{Plan, Report};
use crate::record::Row;
use crate::scene::Scene;
use crate::statistics::{median, range};
use crate::table::{short, table};

/// Measured where none are asked for.
pub const SCENES: &str = "pyramid 40, pyramids 8, joint_grid 100, chain 1, chain 100, chain 1000, stack 10, stack 30, \
                          sandwich 1000, top, rods 5, bridge 30, bridge 100, ragdolls 1, ragdolls 10, \
                          hinge_chain 100 1, hinge_chain 100 1000, hinge_chain 100 1 45, arm, car 0 100 10, \
                          four_bar 1, four_bar 40, limbs, ragdolls 100, pile 200, pile 1000, heap 0 200, heap 0 1000, \
                          heap 0 4000, heap 0 10000, heap 1 1000, heap 1 4000, heap 2 1000, heap 2 4000, heap 3 200, \
                          heap 4 1000, heap 4 4000";

/// How long a moving scene runs, s: it is measured from its start, and with how deep the bodies overlap.
const MOVING_SECONDS: f64 = 5.0;

/// Steps of other scenes before anything is timed: contacts are found, buffers have grown.
const WARM_UP_STEPS: u32 = 60;

/// Steps that an engine takes before it is the next one's turn.
const BLOCK_STEPS: u32 = 20;

/// Rounds of Box3D's benchmark between looks: its scenes are large, and a look costs as much as many steps.
const SUITE_LOOKS: u32 = 5;

/// A block, or the warm-up, ends early after this.
const LONGEST_BLOCK: Duration = Duration::from_secs(2);

/// Measures every scene of a plan.
pub fn measure(plan: &Plan) -> Report {
    let mut report = Report::default();
    let heading = |what: &str| {
        let engines = plan.engines.iter().map(EngineKind::to_string);
        vec![[what.to_owned()].into_iter().chain(engines).collect::<Vec<_>>()]
    };
    let mut cost = heading("ms a step");
    let mut times_plumb = heading("times plumb's");
    let mut times_fastest = heading("times the fastest peer's");
    let mut overlaps = heading("deepest overlap, m: ever, at the end");
    let mut separations = heading("joints apart, m: ever, at the end");
    for scene in &plan.scenes {
        plan.progress(scene);
        let rows = measure_scene(scene, &plan.engines, &plan.settings, &Course::of(scene, plan));
        let line = |show: fn(&Row) -> Option<f64>| {
            let cell = |row: &Row| show(row).map_or_else(|| "-".to_owned(), short);
            [scene.to_string()].into_iter().chain(rows.iter().map(cell)).collect()
        };
        cost.push(line(|row| row.ms_per_step));
        times_plumb.push(line(|row| row.times_plumb));
        times_fastest.push(line(|row| row.times_fastest_peer));
        let both = |of: fn(&Row) -> (Option<f64>, Option<f64>)| {
            let cell = |row: &Row| match of(row) {
                (Some(ever), Some(end)) => format!("{}, {}", short(ever), short(end)),
                _ => "-".to_owned(),
            };
            [scene.to_string()].into_iter().chain(rows.iter().map(cell)).collect()
        };
        if rows.iter().any(|row| row.overlap.is_some()) {
            overlaps.push(both(|row| (row.overlap, row.overlap_end)));
        }
        if rows.iter().any(|row| row.joint_separation.is_some()) {
            separations.push(both(|row| (row.joint_separation, row.joint_separation_end)));
        }
        report.note_refusals(scene, &rows);
        report.rows.extend(rows);
    }
    let tables = [cost, times_plumb, times_fastest, overlaps, separations];
    let tables: Vec<String> = tables.iter().filter(|cells| cells.len() > 1).map(|cells| table(cells)).collect();
    report.text = tables.join("\n") + &report.text;
    report
}

/// How a scene is run.
struct Course {
    /// Steps before anything is timed.
    warm_up: u32,
    rounds: u32,
    /// Rounds from one look at how deep bodies overlap, and joints come apart, to the next; none: there is none.
    look_every: Option<u32>,
    /// Whether what is at rest may sleep.
    sleep: bool,
}

impl Course {
    fn of(scene: &Scene, plan: &Plan) -> Self {
        let sleep = plan.settings.sleep;
        let rounds = |steps: f64| (steps / f64::from(BLOCK_STEPS)).ceil() as u32;
        let steps_of = |seconds: f64| seconds * plan.settings.hz;
        if let Some(entry) = crate::suite::entry(scene).filter(|_| plan.suite) {
            let steps = plan.seconds.map_or(f64::INFINITY, steps_of).min(entry.steps.into());
            // The first step of a world is not in the benchmark's numbers.
            let sleep = sleep && entry.sleeps;
            Self { warm_up: 1, rounds: rounds(steps), look_every: Some(SUITE_LOOKS), sleep }
        } else if scene.is_moving {
            Self {
                warm_up: 0,
                rounds: rounds(steps_of(plan.seconds.unwrap_or(MOVING_SECONDS))),
                look_every: Some(1),
                sleep,
            }
        } else {
            Self { warm_up: WARM_UP_STEPS, rounds: plan.rounds, look_every: None, sleep }
        }
    }
}

/// One engine in one scene: the step times, ms, of each block.
struct Lane {
    run: Result<Run, Unable>,
    blocks: Vec<Vec<f64>>,
    /// How deep bodies overlapped at each look, m.
    overlaps: Vec<f64>,
    /// How far joints had come apart, m.
    separations: Vec<f64>,
}

fn measure_scene(scene: &Scene, engines: &[EngineKind], settings: &Settings, course: &Course) -> Vec<Row> {
    let settings = &Settings { sleep: course.sleep, ..*settings };
    let start = |kind: &EngineKind| Lane {
        run: kind.start(scene, settings),
        blocks: Vec::new(),
        overlaps: Vec::new(),
        separations: Vec::new(),
    };
    let mut lanes: Vec<Lane> = engines.iter().map(start).collect();
    if course.warm_up > 0 {
        for lane in &mut lanes {
            lane.block(course.warm_up);
            lane.blocks.clear();
        }
    }
    for round in 0..course.rounds {
        // Not always the same after the same.
        for turn in 0..lanes.len() {
            let lane = (round as usize + turn) % lanes.len();
            lanes[lane].block(BLOCK_STEPS);
            if course.look_every.is_some_and(|every| (round + 1) % every == 0 || round + 1 == course.rounds) {
                lanes[lane].look(scene);
            }
        }
    }
    let medians: Vec<Vec<f64>> = lanes.iter().map(Lane::block_medians).collect();
    let plumb = engines.iter().position(|kind| kind.is_plumb());
    let fastest_peer = (0..engines.len())
        .filter(|&lane| !engines[lane].is_plumb())
        .filter_map(|lane| Some((lane, median(&medians[lane])?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(lane, _)| lane);
    let rows = engines.iter().zip(&lanes).zip(&medians).map(|((kind, lane), own)| {
        let row = Row::new("speed", scene, *kind, settings);
        match &lane.run {
            Err(unable) => row.with_note(unable),
            Ok(run) => Row {
                seconds: run.time(),
                ms_per_step: median(&lane.blocks.concat()),
                ms_low: range(own).map(|(low, _)| low),
                ms_high: range(own).map(|(_, high)| high),
                times_plumb: plumb.and_then(|plumb| ratio(own, &medians[plumb])),
                times_fastest_peer: fastest_peer.and_then(|peer| ratio(own, &medians[peer])),
                overlap: lane.overlaps.iter().copied().reduce(f64::max),
                overlap_end: lane.overlaps.last().copied(),
                joint_separation: lane.separations.iter().copied().reduce(f64::max),
                joint_separation_end: lane.separations.last().copied(),
                ..row
            },
        }
    });
    rows.collect()
}

impl Lane {
    /// Takes steps until their number or the time is up; after a panic none.
    fn block(&mut self, steps: u32) {
        let Ok(run) = &mut self.run else { return };
        let start = Instant::now();
        let mut block = Vec::new();
        while block.is_empty() || (block.len() < steps as usize && start.elapsed() < LONGEST_BLOCK) {
            match run.step() {
                Ok(took) => block.push(1e3 * took.as_secs_f64()),
                Err(unable) => {
                    self.run = Err(unable);
                    return;
                }
            }
        }
        self.blocks.push(block);
    }

    fn look(&mut self, scene: &Scene) {
        let Ok(run) = &mut self.run else { return };
        match run.read() {
            Ok(states) => {
                self.overlaps.push(overlap::deepest(scene, states));
                self.separations.extend(scene.joints.iter().map(|joint| joint.separation(states)).reduce(f64::max));
            }
            Err(unable) => self.run = Err(unable),
        }
    }

    fn block_medians(&self) -> Vec<f64> {
        self.blocks.iter().filter_map(|block| median(block)).collect()
    }
}

/// Median of the ratios within each round: what slows both down cancels.
fn ratio(own: &[f64], other: &[f64]) -> Option<f64> {
    let ratios: Vec<f64> = own.iter().zip(other).map(|(own, other)| own / other).collect();
    median(&ratios)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_taken_round_by_round() {
        // Both twice as slow from the third round on.
        assert_eq!(ratio(&[1.0, 1.0, 2.0, 2.0, 2.0], &[4.0, 4.0, 8.0, 8.0, 8.0]), Some(0.25));
        assert_eq!(ratio(&[], &[1.0]), None);
    }

    #[test]
    fn a_heap_is_measured_as_it_falls_with_how_deep_it_overlaps() {
        let scene = Scene::parse("heap 0 20").unwrap();
        let settings = Settings { hz: 60.0, substeps: None, threads: 1, sleep: false };
        let course = Course { warm_up: 0, rounds: 15, look_every: Some(1), sleep: false };
        let rows = measure_scene(&scene, &EngineKind::standard(), &settings, &course);
        for row in &rows {
            assert!((row.seconds - MOVING_SECONDS).abs() < 1e-12, "{}", row.engine);
            let (ever, end) = (row.overlap.unwrap(), row.overlap_end.unwrap());
            assert!(0.0 < ever && end <= ever && ever < 0.5, "{}: {ever}, {end}", row.engine);
        }
    }

    #[test]
    fn every_engine_has_a_row_and_plumb_is_one_times_plumb() {
        let scene = Scene::parse("rods 2").unwrap();
        let settings = Settings { hz: 60.0, substeps: None, threads: 1, sleep: false };
        let course = Course { warm_up: WARM_UP_STEPS, rounds: 3, look_every: None, sleep: false };
        let rows = measure_scene(&scene, &EngineKind::standard(), &settings, &course);
        assert_eq!(rows.len(), EngineKind::standard().len());
        assert_eq!(rows[0].times_plumb, Some(1.0));
        for row in &rows {
            // A warm-up and three blocks of 20 steps.
            assert!((row.seconds - 2.0).abs() < 1e-12, "{}", row.engine);
            assert!(row.ms_low <= row.ms_per_step && row.ms_per_step <= row.ms_high, "{}", row.engine);
        }
        assert!(rows.iter().all(|row| row.overlap.is_none()));
        let fastest = rows[1..].iter().filter_map(|row| row.times_fastest_peer).fold(f64::INFINITY, f64::min);
        assert!((0.5..=1.0).contains(&fastest));
    }
}
