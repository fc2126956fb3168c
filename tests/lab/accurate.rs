//! The preset `accurate` where nothing touches: errors against references and closed forms, order, what is conserved.

use bevy::math::DVec3;
use plumb::lab::truth;
use plumb::lab::{BodyState, Simulation};
use plumb::physics::{Diagnostics, SolverSettings, StepStats};
use plumb::scene::{SceneSpec, load};

pub(crate) fn scene(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(name, &parameters).unwrap()
}

pub(crate) fn simulation(scene: SceneSpec, hz: f64) -> Simulation {
    let mut simulation = Simulation::new(scene, SolverSettings { hz, ..SolverSettings::accurate() });
    simulation.world_mut().init_resource::<Diagnostics>();
    simulation
}

/// What a run came to.
#[derive(Default)]
pub(crate) struct Outcome {
    /// Of the scene's truth, and of its further ones.
    pub error: f64,
    pub further: Vec<f64>,
    /// Largest separation of a joint, m.
    pub separation: f64,
    /// Energies after each step, J.
    pub energies: Vec<f64>,
    pub unsettled: u32,
    /// Parts beyond the steps.
    pub cuts: u32,
    /// Deepest overlap, m.
    pub penetration: f64,
}

pub(crate) fn run(scene: SceneSpec, hz: f64, seconds: f64) -> Outcome {
    let mut truth = truth::of(&scene, &SolverSettings::accurate()).expect("an answer");
    let mut simulation = simulation(scene, hz);
    truth.observe(&simulation.sample());
    let mut outcome = Outcome::default();
    for _ in 0..(hz * seconds).round() as u64 {
        simulation.step();
        truth.observe(&simulation.sample());
        let seen = simulation.world().resource::<Diagnostics>();
        outcome.separation = outcome.separation.max(seen.joint_error);
        outcome.energies.push(seen.energy());
        outcome.penetration = outcome.penetration.max(seen.penetration);
        let stats = simulation.world().resource::<StepStats>();
        outcome.unsettled += stats.unsettled;
        outcome.cuts += stats.cuts;
    }
    outcome.error = truth.error().expect("something to compare");
    outcome.further = truth.further.iter().filter_map(|truth| truth.error()).collect();
    outcome
}

/// Least-squares slope of log(error) on log h.
fn order(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(hz, error)| (-hz.ln(), error.ln())).collect();
    let count = logs.len() as f64;
    let (x, y) = logs.iter().fold((0.0, 0.0), |sum, log| (sum.0 + log.0 / count, sum.1 + log.1 / count));
    let (over, under) =
        logs.iter().fold((0.0, 0.0), |sum, log| (sum.0 + (log.0 - x) * (log.1 - y), sum.1 + (log.0 - x) * (log.0 - x)));
    over / under
}

/// Down to 1e-10 m, which is reached before 1/120 s: the order shows at longer steps.
#[test]
fn rods_converge_with_at_least_the_fourth_power_of_the_step() {
    for (n, rates) in [(1.0, [10.0, 20.0]), (2.0, [30.0, 60.0]), (5.0, [30.0, 60.0])] {
        let errors = rates.map(|hz| (hz, run(scene("rods", &[("n", n)]), hz, 2.0).error));
        assert!(order(&errors) >= 3.8, "rods {n}: order {}, {errors:?}", order(&errors));
        let fine = run(scene("rods", &[("n", n)]), 120.0, 2.0).error;
        assert!(fine < 1e-10, "rods {n}: {fine:e} m at 1/120 s");
    }
}

#[test]
fn a_heavy_ball_on_light_rods_follows_its_reference() {
    for (mass, hz, tolerance) in [(1e3, 240.0, 1e-4), (1e3, 60.0, 1e-4), (1e6, 240.0, 1e-4), (1e6, 60.0, 1e-4)] {
        let outcome = run(scene("chain", &[("r", mass)]), hz, 2.0);
        assert!(outcome.error < tolerance, "{mass} kg at {hz} Hz: {:e} m", outcome.error);
        assert!(outcome.separation < 1e-9, "{mass} kg at {hz} Hz: {:e} m apart", outcome.separation);
        assert_eq!(outcome.unsettled, 0, "{mass} kg at {hz} Hz");
    }
}

/// E − E₀ relative to S = m g L/2, over a thousand swings to and fro of 1.9 s.
#[test]
fn a_pendulum_keeps_its_energy_over_a_thousand_swings() {
    let outcome = run(scene("pendulum", &[]), 240.0, 1930.0);
    let scale = 9.81 * 0.5;
    let worst = outcome.energies.iter().map(|energy| energy.abs()).fold(0.0, f64::max);
    assert!(worst / scale < 1e-9, "{:e}", worst / scale);
    let ten = 10 * 463;
    let mean = |energies: &[f64]| energies.iter().sum::<f64>() / energies.len() as f64 / scale;
    let (first, last) = (mean(&outcome.energies[..ten]), mean(&outcome.energies[outcome.energies.len() - ten..]));
    assert!((first - last).abs() < 1e-12, "from {first:e} to {last:e}");
}

fn spread(energies: &[f64]) -> f64 {
    let (least, most) = energies.iter().fold((f64::MAX, f64::MIN), |range, &e| (range.0.min(e), range.1.max(e)));
    (most - least) / most.abs().max(least.abs())
}

#[test]
fn tops_turn_as_their_closed_forms_say() {
    let top = run(scene("top", &[]), 240.0, 10.0);
    assert!(top.error < 1e-5, "{:e} rad/s", top.error);
    assert!(spread(&top.energies) < 1e-8, "{:e}", spread(&top.energies));
    // Axis, azimuth, both angular momenta.
    let heavy = run(scene("heavy_top", &[]), 240.0, 10.0);
    assert!(heavy.error < 1e-6 && heavy.further[0] < 1e-6, "{:e} {:?}", heavy.error, heavy.further);
    assert!(heavy.further[1..].iter().all(|&momentum| momentum < 1e-8), "{:?}", heavy.further);
    assert!(spread(&heavy.energies) < 1e-8, "{:e}", spread(&heavy.energies));
}

/// While the sheet is plane, (n − 1)(n − 2) rows follow from the others, and again whenever it passes through a plane.
#[test]
fn a_sheet_of_redundant_joints_swings_as_one_of_its_columns() {
    for n in [8, 30] {
        swings_as_one_of_its_columns(n);
    }
}

fn swings_as_one_of_its_columns(n: usize) {
    let sheet = |tilt| scene("joint_grid", &[("n", n as f64), ("tilt", tilt)]);
    let mut column = sheet(30.0);
    let first = |name: &str| name.ends_with(" 0");
    column.bodies.retain(|body| first(&body.name));
    column.joints.retain(|joint| first(&joint.body_a) && first(&joint.body_b));
    let (mut column, mut sheet) = (simulation(column, 960.0), simulation(sheet(30.0), 240.0));
    let (mut error, mut separation): (f64, f64) = (0.0, 0.0);
    for _ in 0..480 {
        sheet.step();
        (0..4).for_each(|_| column.step());
        separation = separation.max(sheet.world().resource::<Diagnostics>().joint_error);
        let one: Vec<BodyState> = column.sample().bodies.to_vec();
        for (index, body) in sheet.sample().bodies.iter().enumerate() {
            let expected = one[index / n].position + (index % n) as f64 * DVec3::X;
            error = error.max(body.position.distance(expected));
        }
    }
    assert!(separation < 1e-9, "{n}: {separation:e} m apart");
    assert!(error < 1e-4, "{n}: {error:e} m");
}

/// A tenth of a second, in which rods swing through half a turn.
#[test]
fn a_step_too_long_is_cut_and_says_so() {
    let mut simulation = simulation(scene("chain", &[("r", 1e4)]), 10.0);
    let mut cuts = 0;
    for _ in 0..20 {
        simulation.step();
        cuts += simulation.world().resource::<StepStats>().cuts;
    }
    assert!(cuts > 0);
    assert!(simulation.sample().bodies.iter().all(|body| body.position.is_finite()));
}

/// It hangs on strings that are almost straight, so that rows are nearly redundant.
#[test]
fn a_figure_on_strings_begins_without_many_cuts() {
    let spec = scene("limbs", &[]);
    let figure: Vec<usize> = (0..spec.bodies.len()).filter(|&body| spec.bodies[body].name.starts_with("ann")).collect();
    assert!(figure.len() > 10);
    let places_at = |hz: f64| {
        let mut simulation = simulation(spec.clone(), hz);
        let mut cuts = 0;
        for _ in 0..(hz * 0.1).round() as u32 {
            simulation.step();
            cuts += simulation.world().resource::<StepStats>().cuts;
        }
        let bodies = simulation.sample().bodies;
        (figure.iter().map(|&body| bodies[body].position).collect::<Vec<_>>(), cuts)
    };
    let ((places, cuts), (fine, _)) = (places_at(60.0), places_at(480.0));
    assert!(cuts < 20, "{cuts} cuts");
    let apart = places.iter().zip(&fine).map(|(one, other)| one.distance(*other)).fold(0.0, f64::max);
    assert!(apart < 5e-4, "{apart} m from steps of an eighth");
}
