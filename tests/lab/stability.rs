//! Stability fails where it is charted to fail and holds where it is charted to hold: the borders
//! of `plumb map`, on both sides with a margin.
//!
//! A method that gets better makes its test fail, so that the border is moved on purpose, and the
//! maps in `docs/accuracy.md` with it.

use std::convert::Infallible;

use plumb::lab::map::{ATLAS, MapPlan};
use plumb::lab::vary::{Assignment, Candidate};
use plumb::lab::verdict::{Judgement, Verdict, judge};
use plumb::lab::{Plan, measure};
use plumb::physics::SolverSettings;

/// A border along one parameter of a scene, the rest at its default.
struct Border {
    settings: SolverSettings,
    scene: &'static str,
    parameter: &'static str,
    seconds: f64,
    /// Does not fail here …
    holds: f64,
    /// … and fails here.
    fails: f64,
}

fn border(
    settings: SolverSettings,
    scene: &'static str,
    parameter: &'static str,
    seconds: f64,
    [holds, fails]: [f64; 2],
) -> Border {
    Border { settings, scene, parameter, seconds, holds, fails }
}

impl Border {
    fn verdict(&self, value: f64) -> (Verdict, String) {
        let parameters = [(self.parameter.to_owned(), value)];
        let plan = Plan::new(self.scene, &parameters, self.settings, Some(self.seconds)).unwrap();
        let Judgement { verdict, reason } = judged(&plan);
        (verdict, reason)
    }

    fn check(&self) {
        let Self { scene, parameter, holds, fails, .. } = self;
        let (verdict, reason) = self.verdict(*holds);
        assert!(matches!(verdict, Verdict::Holds | Verdict::Degrades), "{scene} {parameter}={holds}: {reason}");
        let (verdict, reason) = self.verdict(*fails);
        assert_eq!(verdict, Verdict::Fails, "{scene} {parameter}={fails}: {reason}");
    }
}

fn judged(plan: &Plan) -> Judgement {
    judge(&measure(plan, |_| Ok::<(), Infallible>(())).unwrap())
}

/// On the corners, edges and middles of the maps. Not of servos: a joint tree gets half its substeps where nothing turns
/// far, and a servo that is faster than them is nearer to its answer with all.
#[test]
fn fitted_effort_does_no_worse_than_full_effort() {
    let mut better = 0;
    for map in ATLAS.iter().filter(|map| map.name != "servo") {
        let map = map.plan();
        for (x, y) in places(&map) {
            let [fitted, full] = [true, false].map(|fitted_effort| {
                let mut base = SolverSettings::game();
                base.impulse.fitted_effort = fitted_effort;
                judged(&map.point(&Candidate::new("game", base), x, y).plan().unwrap())
            });
            let cell = format!("{} at {x}, {y}", map.name);
            assert!(fitted.verdict <= full.verdict, "{cell}: {}; at full effort: {}", fitted.reason, full.reason);
            better += u32::from(fitted.verdict < full.verdict);
        }
    }
    assert!(better > 5, "nothing is gained by solving what rests directly");
}

/// At the longest steps of all maps, where they are hardest; the largest wall takes minutes here, as do limits that stop
/// ten tonnes on two links, where the axes tilt.
#[test]
fn accurate_has_no_border() {
    let most = |map: &str| match map {
        "pyramid" => 10.0,
        "hinge_chain" => 1000.0,
        _ => f64::INFINITY,
    };
    let mut cells = 0;
    let accurate = Candidate::new("accurate", SolverSettings::accurate());
    for map in &ATLAS {
        let map = map.plan();
        let x = map.x.values()[0];
        for &y in map.y.values().iter().filter(|y| y.value.number().is_none_or(|y| y <= most(&map.name))) {
            let Judgement { verdict, reason } = judged(&map.point(&accurate, x, y).plan().unwrap());
            assert_eq!(verdict, Verdict::Holds, "{} at {x}, {y}: {reason}", map.name);
            cells += 1;
        }
    }
    assert!(cells > 50, "{cells}");
}

/// First, middle and last values of either side.
fn places(map: &MapPlan) -> impl Iterator<Item = (Assignment, Assignment)> {
    let of = |values: &[Assignment]| [values[0], values[values.len() / 2], values[values.len() - 1]];
    let (across, upwards) = (of(map.x.values()), of(map.y.values()));
    upwards.into_iter().flat_map(move |y| across.into_iter().map(move |x| (x, y)))
}

#[test]
fn classic_holds_light_loads_only() {
    let classic = SolverSettings::classic();
    border(classic, "chain", "r", 4.0, [1.0, 10.0]).check();
    border(classic, "chain", "r", 4.0, [1.0, 1000.0]).check();
    border(classic, "sandwich", "r", 4.0, [1.0, 10.0]).check();
}

#[test]
fn classic_holds_low_walls_and_no_columns() {
    let classic = SolverSettings::classic();
    border(classic, "pyramid", "n", 5.0, [2.0, 6.0]).check();
    // With four substeps two cubes stand, …
    let patient = SolverSettings { substeps: 4, ..classic };
    border(patient, "stack", "n", 5.0, [2.0, 10.0]).check();
    // … with its own one not even those.
    let (verdict, _) = border(classic, "stack", "n", 5.0, [2.0; 2]).verdict(2.0);
    assert_eq!(verdict, Verdict::Fails);
    let (verdict, _) = border(classic, "stack", "n", 5.0, [10.0; 2]).verdict(10.0);
    assert_eq!(verdict, Verdict::Fails);
}

#[test]
fn steady_holds_what_its_maps_claim() {
    let steady = SolverSettings::steady();
    border(steady, "chain", "r", 4.0, [30.0, 1000.0]).check();
    border(steady, "sandwich", "r", 4.0, [30.0, 1000.0]).check();
    border(steady, "stack", "n", 5.0, [10.0, 30.0]).check();
    border(steady, "pyramid", "n", 5.0, [10.0, 20.0]).check();
}

#[test]
fn force_level_sweeps_turn_no_top_and_stop_no_fast_ball() {
    for settings in [SolverSettings::classic(), SolverSettings::steady()] {
        border(settings, "top", "spin", 3.0, [1.0, 10.0]).check();
        border(settings, "wall", "v", 1.0, [1.0, 10.0]).check();
    }
}

/// Joints that form a tree are solved exactly: there is no border.
#[test]
fn the_default_holds_any_load_on_a_chain() {
    for r in [1.0, 1000.0, 1e6] {
        let (verdict, reason) = border(SolverSettings::default(), "chain", "r", 4.0, [r; 2]).verdict(r);
        assert_ne!(verdict, Verdict::Fails, "{r}: {reason}");
    }
}

/// Islands at rest are solved directly: there is no border.
#[test]
fn the_default_holds_any_load_at_rest() {
    let mut default = SolverSettings::default();
    default.impulse.sleep_speed = None;
    for (scene, parameter, value) in [("sandwich", "r", 1e4), ("sandwich", "r", 1e6), ("stack", "n", 60.0)] {
        let (verdict, reason) = border(default, scene, parameter, 4.0, [value; 2]).verdict(value);
        assert_eq!(verdict, Verdict::Holds, "{scene} {parameter}={value}: {reason}");
    }
}

#[test]
fn the_soft_step_at_full_effort_holds_what_its_maps_claim() {
    let mut full = SolverSettings::default();
    full.impulse.fitted_effort = false;
    border(full, "sandwich", "r", 4.0, [300.0, 1e4]).check();
    border(full, "stack", "n", 5.0, [20.0, 60.0]).check();
    border(full, "top", "spin", 3.0, [10.0, 1000.0]).check();
}

/// Their sweeps carry joints and contacts, as far as sweeps go.
#[test]
fn sequential_impulses_and_xpbd_hold_what_their_maps_claim() {
    let sequential = SolverSettings::sequential_impulses();
    border(sequential, "chain", "r", 4.0, [10.0, 1000.0]).check();
    border(sequential, "sandwich", "r", 4.0, [100.0, 1e5]).check();
    border(sequential, "stack", "n", 5.0, [10.0, 40.0]).check();
    let xpbd = SolverSettings::xpbd();
    border(xpbd, "chain", "r", 4.0, [10.0, 1e4]).check();
    border(xpbd, "sandwich", "r", 4.0, [100.0, 1e5]).check();
    border(xpbd, "stack", "n", 5.0, [10.0, 60.0]).check();
}

/// Contacts are found as far ahead as a body comes in the step.
#[test]
fn the_default_stops_balls_of_any_speed() {
    for v in [10.0, 1e3, 1e4] {
        let (verdict, reason) = border(SolverSettings::default(), "wall", "v", 1.0, [v; 2]).verdict(v);
        assert_ne!(verdict, Verdict::Fails, "{v}: {reason}");
    }
}

/// Where friction jams the rod no rigid motion exists; whatever happens, it neither gains energy nor digs itself in,
/// but where it is thrown up at 70 degrees and comes down on its tip: there by up to a sixth of its 20 mm.
#[test]
fn the_default_holds_the_sliding_rod() {
    let atlas = ATLAS.iter().find(|map| map.name == "painleve").unwrap().plan();
    let game = Candidate::new("game", SolverSettings::default());
    for &tilt in atlas.y.values() {
        let is_thrown_up = tilt.value.number() == Some(70.0);
        for &mu in atlas.x.values().iter().filter(|mu| !is_thrown_up || mu.value.number() < Some(1.5)) {
            let Judgement { verdict, reason } = judged(&atlas.point(&game, mu, tilt).plan().unwrap());
            assert_ne!(verdict, Verdict::Fails, "{mu}, {tilt}: {reason}");
        }
    }
}
