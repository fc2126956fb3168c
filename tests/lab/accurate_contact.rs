//! The preset `accurate` where things touch: closed forms of sliding, rolling and bouncing, and what should stand.

use std::collections::BTreeMap;
use std::convert::Infallible;

use plumb::lab::{Plan, Simulation, measure};
use plumb::physics::{ContactForces, Diagnostics, ExactSettings, Mass, SolverSettings, StepStats};

use crate::accurate::{run, scene, simulation};

#[test]
fn balls_roll_on_a_slab_as_their_closed_form_says() {
    for angle in [0.0, 60.0] {
        let outcome = run(scene("rolling", &[("angle", angle)]), 1000.0, 1.0);
        assert!(outcome.error < 1e-20, "{angle}: {:e} m2/s2", outcome.error);
        assert_eq!(outcome.unsettled, 0);
    }
}

/// A slope of 30 degrees: it holds from mu = tan 30 degrees on, and is slid down as the closed form says below.
#[test]
fn a_box_sticks_or_slides_as_friction_crosses_the_slope() {
    let edge = 30.0_f64.to_radians().tan();
    for (mu, slides) in [(edge - 1e-6, true), (edge + 1e-6, false), (0.4, true), (0.0, true)] {
        let incline = scene("incline", &[("theta", 30.0), ("mu", mu)]);
        let mut simulation = simulation(incline.clone(), 60.0);
        let start = simulation.sample().bodies[1].position;
        let outcome = run(incline, 60.0, 2.0);
        (0..120).for_each(|_| simulation.step());
        let way = simulation.sample().bodies[1].position.distance(start);
        // The least slope's excess makes half of g times 1e-6 cos 30 degrees times t squared.
        assert_eq!(way > 1e-6, slides, "mu {mu}: {way:e} m");
        assert!(outcome.error < 1e-9, "mu {mu}: {:e} m", outcome.error);
    }
}

/// Neither what a first forecast leaves nor the fastest speed is the measure of what few points may be off: a ball of 7 m/s
/// that slides until it rolls, and one of 10 m/s that a wall stops, which no weight holds there.
#[test]
fn few_points_end_as_near_to_their_laws_however_fast_they_came() {
    for (name, seconds, most) in [("slide_roll", 2.0, 2e-11), ("wall", 1.0, 6e-10)] {
        let outcome = run(scene(name, &[]), 60.0, seconds);
        assert!(outcome.error < most, "{name}: {:e}", outcome.error);
        assert_eq!(outcome.unsettled, 0, "{name}");
    }
}

/// 49 balls, whose landings are found to a fraction of an atom.
#[test]
fn balls_bounce_as_high_as_they_fell() {
    for hz in [1000.0, 100.0] {
        let outcome = run(scene("bounce", &[("e", 1.0)]), hz, 20.0);
        let first = outcome.energies[0];
        let squares = outcome.energies.iter().map(|energy| (energy - first).powi(2)).sum::<f64>();
        assert!(squares / outcome.energies.len() as f64 <= 1e-8, "{hz}: {squares:e}");
        assert!(outcome.error <= 1e-6, "{hz}: {:e} m", outcome.error);
        // Each lands once in 2 t0, first after t0 = 0.9995 s.
        assert_eq!(outcome.cuts, 49 * 10, "{hz}: landings");
    }
}

/// Bounces add up: the k-th, from 0, has an approach of 9.9 / 2^k m/s, and one below 1e-4 m/s is none.
#[test]
fn bounces_that_add_up_come_to_an_end() {
    let outcome = run(scene("bounce", &[("e", 0.5)]), 100.0, 5.0);
    assert!(outcome.error <= 1e-6, "{:e} m", outcome.error);
    assert_eq!(outcome.cuts, 49 * 17, "landings");
    assert_eq!(outcome.unsettled, 0);
}

#[test]
fn a_heap_of_balls_neither_overlaps_nor_loses_energy() {
    let still = run(scene("spheres", &[("e", 0.0)]), 1000.0, 2.0);
    assert!(still.error <= 1e-10, "{:e} m2", still.error);
    let bouncing = run(scene("spheres", &[("e", 1.0)]), 1000.0, 10.0);
    assert!(bouncing.cuts > 100, "{} landings", bouncing.cuts);
    assert!(bouncing.error <= 1e-6, "{:e} J2", bouncing.error);
}

/// Each half of a step starts from forces that leave nothing over, so that a step at rest takes no factorisation: mostly, as
/// rounding adds up.
#[test]
fn what_rests_is_seldom_solved_anew() {
    for (name, parameters) in [("pyramid", &[("n", 8.0)][..]), ("arch", &[]), ("card_house", &[])] {
        let mut simulation = simulation(scene(name, parameters), 60.0);
        let mut solves = Vec::new();
        for _ in 0..120 {
            simulation.step();
            let stats = simulation.world().resource::<StepStats>();
            solves.push(stats.row_updates / u64::from(stats.rows.max(1)));
        }
        let late: u64 = solves[60..].iter().sum();
        assert!(late <= 40, "{name}: {late} factorisations in 60 steps: {solves:?}");
    }
}

/// Between edges of hulls some solves do not come to their end, and what they leave is not to fling bodies.
#[test]
fn what_is_not_settled_flings_nothing() {
    let mut simulation = Simulation::new(scene("heap", &[("n", 70.0), ("kind", 2.0)]), SolverSettings::accurate());
    simulation.world_mut().init_resource::<Diagnostics>();
    let (mut before, mut rise, mut unsettled) = (f64::INFINITY, 0.0_f64, 0);
    for _ in 0..240 {
        simulation.step();
        let energy = simulation.world().resource::<Diagnostics>().energy();
        rise = rise.max(energy - before);
        before = energy;
        unsettled += simulation.world().resource::<StepStats>().unsettled;
    }
    assert!(unsettled > 0, "all are settled: this heap tells nothing any more");
    assert!(rise < 1.0, "{rise} J in a step");
}

/// Cones touch along lines whose ends change their names on the way, and edges of boxes come to lie on others: each contact
/// is followed by its place.
#[test]
fn heaps_that_fall_and_hit_are_settled() {
    for (kind, most) in [(0.0, 2), (3.0, 0)] {
        let mut simulation =
            Simulation::new(scene("heap", &[("n", 100.0), ("kind", kind)]), SolverSettings::accurate());
        simulation.world_mut().init_resource::<Diagnostics>();
        let (mut unsettled, mut overlap) = (0, 0.0_f64);
        for _ in 0..75 {
            simulation.step();
            unsettled += simulation.world().resource::<StepStats>().unsettled;
            overlap = overlap.max(simulation.world().resource::<Diagnostics>().penetration);
        }
        assert!(unsettled <= most, "kind {kind}: {unsettled} parts");
        assert!(overlap < 1e-6, "kind {kind}: {overlap:e} m");
    }
}

/// A step without time goes on with what a few iterations bring, and says so; what needs no more has it.
#[test]
fn a_step_whose_time_is_over_goes_on_with_what_it_has() {
    let budgets = [None, Some(1e9), Some(0.0)];
    let [free, ample, none] = budgets.map(|time_budget| {
        let accurate = SolverSettings::accurate();
        let settings = SolverSettings { exact: ExactSettings { time_budget, ..accurate.exact }, ..accurate };
        let mut simulation = Simulation::new(scene("heap", &[("n", 100.0)]), settings);
        simulation.world_mut().init_resource::<Diagnostics>();
        let (mut unsettled, mut most, mut overlap) = (0, 0, 0.0_f64);
        for _ in 0..120 {
            simulation.step();
            let stats = simulation.world().resource::<StepStats>();
            unsettled += stats.unsettled;
            most = most.max(stats.row_updates / u64::from(stats.rows.max(1)));
            overlap = overlap.max(simulation.world().resource::<Diagnostics>().penetration);
        }
        (unsettled, most, overlap, simulation.state_hash())
    });
    assert_eq!(ample, free);
    assert!(none.0 > 0, "{none:?}");
    assert!(none.1 < 64 && free.1 > 2 * none.1, "{none:?} for {free:?}");
    assert!(none.2 < 0.03, "{none:?}");
    let accurate = SolverSettings::accurate();
    let hurried = SolverSettings { exact: ExactSettings { time_budget: Some(0.0), ..accurate.exact }, ..accurate };
    let [slow, fast] = [accurate, hurried].map(|settings| {
        let mut simulation = Simulation::new(scene("rolling", &[]), settings);
        (0..120).for_each(|_| simulation.step());
        (simulation.state_hash(), simulation.world().resource::<StepStats>().unsettled)
    });
    assert_eq!(fast, slow);
}

#[test]
fn the_last_ball_of_a_cradle_takes_it_all() {
    let outcome = run(scene("cradle", &[]), 240.0, 3.0);
    assert!(outcome.error <= 1e-5, "{:e} rad", outcome.error);
    assert!(outcome.separation <= 1e-9, "{:e} m", outcome.separation);
}

/// Largest move.
#[test]
fn what_stands_stands_still() {
    let columns = [10.0, 30.0, 100.0].iter().flat_map(|&n| [(n, 0.0), (n, 0.001)]);
    let columns = columns.map(|(n, jitter)| ("stack", vec![("n", n), ("jitter", jitter)]));
    let others = [("sandwich", vec![("r", 1e6)]), ("pyramid", vec![("n", 6.0)])];
    for (name, parameters) in columns.chain(others) {
        let outcome = run(scene(name, &parameters), 60.0, 10.0);
        assert!(outcome.error <= 1e-5, "{name} {parameters:?}: moved {:e} m", outcome.error);
        assert!(outcome.penetration <= 1e-9, "{name} {parameters:?}: {:e} m deep", outcome.penetration);
    }
}

/// Forces across each interface of a column add up to the weight above it.
#[test]
fn a_column_carries_its_weight() {
    for (n, jitter) in [(30, 0.0), (30, 0.001), (100, 0.0)] {
        let mut simulation = simulation(scene("stack", &[("n", f64::from(n)), ("jitter", jitter)]), 60.0);
        let world = simulation.world_mut();
        world.init_resource::<ContactForces>();
        (0..60).for_each(|_| simulation.step());
        let world = simulation.world_mut();
        let heaviest = world.query::<&Mass>().iter(world).map(|mass| mass.0).fold(0.0, f64::max);
        let mut carried = BTreeMap::<_, f64>::new();
        for contact in &world.resource::<ContactForces>().0 {
            *carried.entry((contact.a, contact.b)).or_default() += contact.force.y.abs();
        }
        let mut carried: Vec<f64> = carried.into_values().collect();
        carried.sort_by(f64::total_cmp);
        assert_eq!(carried.len(), n as usize);
        for (above, force) in (1..).zip(carried) {
            let weight = f64::from(above) * heaviest * 10.0;
            assert!((force / weight - 1.0).abs() <= 1e-6, "stack {n} {jitter}: {force} N under {above}, not {weight}");
        }
    }
}

#[test]
fn arch_and_house_of_cards_do_not_creep() {
    for name in ["arch", "card_house"] {
        let outcome = run(scene(name, &[]), 60.0, 60.0);
        assert!(outcome.error <= 1e-5, "{name}: {:e} m", outcome.error);
    }
}

/// No more energy than at the start, whatever the friction; where motion is rigid, the way that it takes.
#[test]
fn a_sliding_rod_makes_no_energy() {
    for mu in [0.0, 0.5, 1.0, 1.3, 1.5, 3.0, 10.0] {
        let rod = scene("painleve", &[("mu", mu)]);
        let mut simulation = simulation(rod.clone(), 20_000.0);
        simulation.step();
        let first = simulation.world().resource::<Diagnostics>().energy();
        let mut highest = first;
        for _ in 0..10_000 {
            simulation.step();
            highest = highest.max(simulation.world().resource::<Diagnostics>().energy());
        }
        assert!(highest - first <= 1e-9 * first.abs().max(5.0), "mu {mu}: {:e} J gained", highest - first);
        assert!(simulation.quarantined().is_empty());
        if mu < 1.35 {
            let outcome = run(rod, 4000.0, 0.5);
            assert!(outcome.error <= 1e-6, "mu {mu}: {:e} m", outcome.error);
        }
    }
}

/// Figures that fall, land on each other and slide.
#[test]
fn limbs_in_a_heap_keep_their_joints_and_make_no_energy() {
    let mut simulation: Simulation = simulation(scene("limbs", &[]), 60.0);
    simulation.step();
    let first = simulation.world().resource::<Diagnostics>().energy();
    let (mut highest, mut separation, mut penetration) = (first, 0.0_f64, 0.0_f64);
    for _ in 0..45 {
        simulation.step();
        let seen = simulation.world().resource::<Diagnostics>();
        highest = highest.max(seen.energy());
        separation = separation.max(seen.joint_error);
        penetration = penetration.max(seen.penetration);
    }
    assert!(highest <= first + 1e-3, "energy rises from {first} to {highest} J");
    assert!(separation < 1e-5, "joints part by {separation} m");
    assert!(penetration < 1e-3, "{penetration} m deep");
    assert!(simulation.quarantined().is_empty());
}

/// By the residual of the natural map, over the larger of g h and the fastest contact of a step.
#[test]
fn contacts_obey_their_laws() {
    for (name, hz, seconds) in [
        ("slide_roll", 60.0, 2.0),
        ("rolling", 1000.0, 0.2),
        ("pyramid", 60.0, 1.0),
        ("arch", 60.0, 1.0),
        ("limbs", 60.0, 0.5),
    ] {
        let settings = SolverSettings { hz, ..SolverSettings::accurate() };
        let plan = Plan::new(name, &[], settings, Some(seconds)).unwrap();
        let residual = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap().contact_residual.expect("contacts");
        assert!(residual.worst < 2e-8, "{name}: {:e}", residual.worst);
    }
}

/// Above mu = 1.34 at 60 degrees; no other rod is.
#[test]
fn where_no_rigid_motion_exists_is_told() {
    for (mu, jams) in [(1.0, false), (1.3, false), (1.4, true), (10.0, true)] {
        let mut simulation = simulation(scene("painleve", &[("mu", mu)]), 1000.0);
        simulation.step();
        let told = simulation.world().resource::<StepStats>().jammed;
        assert_eq!(told > 0, jams, "mu {mu}: {told}");
    }
}
