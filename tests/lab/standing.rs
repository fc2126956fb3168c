//! What stands by friction stands, with as little of it as it takes, and what should fall falls.

use std::convert::Infallible;

use bevy::math::DVec3;
use plumb::lab::{Metrics, Plan, Simulation, measure};
use plumb::physics::{ContactForces, SolverSettings};
use plumb::scene::load;

/// What a scene of blocks on blocks takes to stand still: each more row between a force and the
/// ground takes more sweeps until it arrives.
fn patient() -> SolverSettings {
    SolverSettings { iterations: 100, ..SolverSettings::steady() }
}

fn run(scene: &str, settings: SolverSettings, seconds: f64) -> Metrics {
    let plan = Plan::new(scene, &[], settings, Some(seconds)).unwrap();
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap()
}

fn error(metrics: &Metrics) -> f64 {
    metrics.truth.as_ref().expect("an answer").error
}

/// Where the bodies have moved to, at most, after each second, with this friction everywhere.
fn moves(scene: &str, friction: f64, seconds: u32) -> Vec<f64> {
    let mut scene = load(scene, &[]).unwrap();
    scene.bodies.iter_mut().for_each(|body| body.material.friction = friction);
    let starts: Vec<DVec3> = scene.bodies.iter().map(|body| body.position).collect();
    let mut simulation = Simulation::new(scene, patient());
    (0..seconds)
        .map(|_| {
            (0..60).for_each(|_| simulation.step());
            let bodies = simulation.sample().bodies.iter().zip(&starts);
            bodies.map(|(body, start)| body.position.distance(*start)).fold(0.0, f64::max)
        })
        .collect()
}

#[test]
fn the_arch_stands() {
    let moves = moves("arch", 0.6, 10);
    // Each of 16 joints closes by the slop of 2 mm and more at the crown, once.
    assert!(moves[1] < 0.025, "it settles by {} m", moves[1]);
    assert!(moves[9] - moves[1] < 0.012, "it creeps from {} m to {} m", moves[1], moves[9]);
}

/// No line of thrust within the arch keeps to friction angles under atan 0.309 (see the scene).
#[test]
fn the_arch_takes_as_much_friction_as_its_line_of_thrust_says() {
    let held = *moves("arch", 0.34, 6).last().unwrap();
    assert!(held < 0.05, "with friction enough it moves by {held} m");
    let fallen = *moves("arch", 0.28, 6).last().unwrap();
    assert!(fallen > 1.0, "with too little it moves by {fallen} m only");
}

#[test]
fn the_house_of_cards_stands() {
    let metrics = run("card_house", SolverSettings::steady(), 10.0);
    assert!(error(&metrics) < 0.05, "default settings: {} m", error(&metrics));
    let metrics = run("card_house", patient(), 20.0);
    assert!(error(&metrics) < 0.02, "{} m", error(&metrics));
}

/// At the default settings nothing sleeps in the lab: what stands still is held by the solver.
#[test]
fn arch_and_house_of_cards_do_not_creep_in_a_minute() {
    for scene in ["arch", "card_house"] {
        let mut simulation = Simulation::new(load(scene, &[]).unwrap(), awake());
        let places = |simulation: &Simulation| -> Vec<DVec3> {
            simulation.sample().bodies.iter().map(|body| body.position).collect()
        };
        let touching = places(&simulation);
        (0..60).for_each(|_| simulation.step());
        let settled = places(&simulation);
        (60..3600).for_each(|_| simulation.step());
        let farthest = |from: &[DVec3]| {
            places(&simulation).iter().zip(from).map(|(now, then)| now.distance(*then)).fold(0.0, f64::max)
        };
        let (crept, moved) = (farthest(&settled), farthest(&touching));
        assert!(crept < 1e-4 && moved < 1e-3, "{scene} creeps by {crept} m and has moved by {moved} m");
    }
}

fn awake() -> SolverSettings {
    let mut game = SolverSettings::game();
    game.impulse.sleep_speed = None;
    game
}

/// The decks of the outer pairs hang on to 0.319 of their weight (see the scene).
#[test]
fn the_house_of_cards_falls_without_enough_friction() {
    let fallen = *moves("card_house", 0.28, 6).last().unwrap();
    assert!(fallen > 1.0, "it moves by {fallen} m only");
}

#[test]
fn cards_that_meet_edge_on_edge_push_along_a_direction_between_their_faces() {
    let mut simulation = Simulation::new(load("card_house", &[]).unwrap(), patient());
    simulation.world_mut().insert_resource(ContactForces::default());
    (0..30).for_each(|_| simulation.step());
    let place = |name: &str| simulation.scene().bodies.iter().position(|body| body.name == name).expect("a card");
    let [left, right] = ["left card 2.0", "right card 2.0"].map(|name| simulation.entities().bodies[place(name)]);
    let forces = &simulation.world().resource::<ContactForces>().0;
    let apex: Vec<_> = forces
        .iter()
        .filter(|contact| [contact.a, contact.b] == [left, right] || [contact.a, contact.b] == [right, left])
        .collect();
    assert_eq!(apex.len(), 2, "the ends of the edge");
    let mut push = 0.0;
    for contact in &apex {
        let toward_right = if contact.b == right { 1.0 } else { -1.0 };
        let normal = toward_right * contact.normal;
        // Rounding of single precision, and cards that lean a little more or less by now.
        let steepest = 20.5_f64.to_radians().sin();
        assert!(normal.x > 0.9 && normal.y.abs() < steepest && normal.z.abs() < 1e-2, "{normal}");
        push += toward_right * contact.force.x;
    }
    // ½ m g (tan α − t/L) on the top pair, which carries nothing.
    let weight = 1000.0 * 0.04 * 0.7 * 9.81;
    let expected = 0.5 * weight * (20_f64.to_radians().tan() - 0.04);
    assert!((push / expected - 1.0).abs() < 0.1, "{push} N for {expected} N");
}

#[test]
fn dominoes_fall_one_after_the_other() {
    let settings = SolverSettings::steady();
    for settings in [settings, SolverSettings { iterations: 40, ..settings }, SolverSettings { hz: 240.0, ..settings }]
    {
        let metrics = run("dominoes", settings, 8.0);
        assert_eq!(error(&metrics), 0.0, "{} sweeps at {} Hz", settings.iterations, settings.hz);
    }
}

#[test]
fn dominoes_do_not_fall_before_their_turn() {
    // Halfway down the row, the rest stand.
    let metrics = run("dominoes", SolverSettings::steady(), 3.0);
    assert!((3.0..17.0).contains(&error(&metrics)), "{} stand after 3 s", error(&metrics));
}

#[test]
fn the_rod_without_a_rigid_motion_stays_finite_and_gains_no_energy() {
    for friction in [1.4, 3.0, 10.0] {
        for settings in [SolverSettings::steady(), patient(), SolverSettings::classic()] {
            let plan = Plan::new("painleve", &[("mu".into(), friction)], settings, None).unwrap();
            let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
            assert!(metrics.quarantined.is_empty(), "{friction}");
            assert_eq!(metrics.truth.as_ref().expect("an answer").unit, "J");
            // Of 5 J.
            assert!(error(&metrics) < 1e-6, "{friction}: {} J gained", error(&metrics));
        }
    }
}

#[test]
fn a_pile_comes_to_rest_in_its_tray() {
    let mut simulation = Simulation::new(load("pile", &[]).unwrap(), SolverSettings::steady());
    (0..600).for_each(|_| simulation.step());
    assert!(simulation.quarantined().is_empty());
    let inside = simulation.scene().bodies[2].position.x; // the right wall
    for (body, spec) in simulation.sample().bodies.iter().zip(&simulation.scene().bodies).skip(5) {
        let place = body.position;
        assert!(place.x.abs() < inside && place.z.abs() < inside, "{} is at {place}", spec.name);
        assert!(place.y > 0.05 && body.linear.length() < 0.5, "{} at {place}, {} m/s", spec.name, body.linear.length());
    }
}

/// Softness lets none of them lean: a column of soft contacts buckles from 20 cubes on, one of rigid cubes does not.
#[test]
fn a_swept_column_of_forty_cubes_a_little_out_of_line_stands() {
    let mut settings = awake();
    settings.impulse.fitted_effort = false;
    let parameters = [("n", 40.0), ("jitter", 0.001)].map(|(name, value)| (name.to_owned(), value));
    let scene = load("stack", &parameters).unwrap();
    let starts: Vec<DVec3> = scene.bodies.iter().map(|body| body.position).collect();
    let mut simulation = Simulation::new(scene, settings);
    (0..1200).for_each(|_| simulation.step());
    let moves = simulation.sample().bodies.iter().zip(&starts).map(|(body, start)| body.position - *start);
    let aside = moves.map(|by| by.x.hypot(by.z)).fold(0.0, f64::max);
    assert!(aside < 0.02, "{aside} m");
}
