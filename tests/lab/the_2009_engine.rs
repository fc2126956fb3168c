//! Claims of the document that `classic` is made after, where nothing else pins what `docs/the_2009_engine.md` says of
//! them. Numbers there are measured; the bounds here leave room for other compilers, and none where bits are equal.

use std::convert::Infallible;

use bevy::math::DVec3;
use plumb::lab::{BodyState, Metrics, Plan, Simulation, measure};
use plumb::physics::{ContactModel, FrictionModel, Integrator, Method, Precision, SolverSettings, StepStats};
use plumb::scene::load;

fn classic(change: impl FnOnce(&mut SolverSettings)) -> SolverSettings {
    let mut settings = SolverSettings::classic();
    change(&mut settings);
    settings
}

fn run(scene: &str, parameters: &[(&str, f64)], seconds: f64, change: impl FnOnce(&mut SolverSettings)) -> Metrics {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let plan = Plan::new(scene, &parameters, classic(change), Some(seconds)).unwrap();
    let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
    assert!(metrics.quarantined.is_empty(), "{scene}: {:?}", metrics.quarantined);
    metrics
}

/// The states of the last body of a scene after each step.
fn last_body(
    scene: &str,
    parameters: &[(&str, f64)],
    seconds: f64,
    change: impl FnOnce(&mut SolverSettings),
) -> Vec<BodyState> {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let settings = classic(change);
    let mut simulation = Simulation::new(load(scene, &parameters).unwrap(), settings);
    let steps = (seconds * settings.hz).round() as u32;
    let states = (0..steps).map(|_| {
        simulation.step();
        *simulation.sample().bodies.last().expect("a body")
    });
    states.collect()
}

/// The last state of the last body.
fn ends(scene: &str, seconds: f64, change: impl FnOnce(&mut SolverSettings)) -> BodyState {
    *last_body(scene, &[], seconds, change).last().expect("a step")
}

fn trembles(metrics: &Metrics) -> f64 {
    metrics.jitter_m_per_s.expect("a scene that should rest")
}

fn clip(settings: &mut SolverSettings) {
    settings.sweeps.contacts = ContactModel::Clipping;
}

// Friction and rest.

#[test]
fn a_cube_trembles_at_four_sweeps_and_is_quiet_at_six() {
    let cube = |iterations, friction| {
        run("stack", &[("n", 1.0)], 5.0, |settings| {
            settings.iterations = iterations;
            settings.friction = friction;
        })
    };
    let four = cube(4, FrictionModel::OneTangent);
    assert!(trembles(&four) > 0.1 && four.drift_max_m > 0.03, "{} m/s, {} m", trembles(&four), four.drift_max_m);
    let six = cube(6, FrictionModel::OneTangent);
    assert!(trembles(&six) < 1e-5 && six.drift_max_m < 1e-6, "{} m/s, {} m", trembles(&six), six.drift_max_m);
    // Without friction four sweeps do as well.
    let smooth = cube(4, FrictionModel::Off);
    assert!(trembles(&smooth) < 0.02 && smooth.drift_max_m == 0.0, "{} m/s", trembles(&smooth));
}

#[test]
fn a_flat_slab_creeps_on_level_ground() {
    let metrics = run("incline", &[("theta", 0.0), ("mu", 0.6)], 10.0, |_| ());
    assert!((0.005..0.1).contains(&metrics.drift_max_m), "{} m", metrics.drift_max_m);
}

#[test]
fn friction_keeps_limbs_from_sliding() {
    let slid = |friction| run("limbs", &[], 5.0, |settings| settings.friction = friction).drift_max_m;
    let (with, without) = (slid(FrictionModel::OneTangent), slid(FrictionModel::Off));
    assert!(with < 3.0 && without > 5.0, "{with} m with friction, {without} m without");
}

/// On a ball, a wedge, a box and a prism: s = ½ g (sin θ − n μ) t², where ten sweeps solve the rows. At four a prism on
/// three corners stands on fewer for a while, and slides farther.
#[test]
fn friction_is_of_the_weight_times_the_number_of_points() {
    for (theta, points, tolerance) in
        [(45.0, 1, 0.1), (45.0, 2, 0.1), (45.0, 3, 0.1), (45.0, 4, 0.1), (60.0, 4, 0.1), (60.0, 5, 0.1), (45.0, 6, 0.3)]
    {
        let parameters = [("theta", theta), ("mu", 0.1), ("points", f64::from(points))];
        let slid = run("incline", &parameters, 1.0, |settings| settings.iterations = 10).drift_max_m;
        let law = 0.5 * 9.81 * (f64::to_radians(theta).sin() - f64::from(points) * 0.1);
        assert!((slid / law - 1.0).abs() < tolerance, "{points} points at {theta} degrees: {slid} m of {law} m");
        let coulomb = run("incline", &parameters, 1.0, |settings| {
            settings.iterations = 10;
            settings.friction = FrictionModel::TwoTangents;
        });
        let theta = f64::to_radians(theta);
        let law = 0.5 * 9.81 * (theta.sin() - 0.1 * theta.cos());
        assert!((coulomb.drift_max_m / law - 1.0).abs() < 0.1, "{points} points: {} m of {law} m", coulomb.drift_max_m);
    }
}

// Contacts.

#[test]
fn a_single_point_trembles_however_good_the_solver() {
    let cube = |contacts, iterations| {
        run("stack", &[("n", 1.0)], 10.0, |settings| {
            settings.sweeps.contacts = contacts;
            settings.iterations = iterations;
        })
    };
    for iterations in [4, 100] {
        let metrics = cube(ContactModel::SinglePoint, iterations);
        let (speed, moved) = (trembles(&metrics), metrics.drift_max_m);
        assert_eq!(metrics.contacts.min(1), metrics.contacts, "one point");
        assert!(speed > 0.1 && moved > 0.1, "{iterations} sweeps: {speed} m/s, {moved} m");
    }
    for contacts in [ContactModel::ExtremeVertices, ContactModel::Clipping] {
        let metrics = cube(contacts, 100);
        assert!(trembles(&metrics) < 1e-6 && metrics.drift_max_m < 1e-6, "{contacts:?}: {} m/s", trembles(&metrics));
    }
}

#[test]
fn vertices_that_nothing_touches_hold_a_cube_in_the_air() {
    for iterations in [4, 100] {
        let cube = ends("assets/scenes/past_the_edge.ron", 3.0, |settings| settings.iterations = iterations);
        assert!((cube.position - DVec3::new(2.45, 0.99, 0.0)).length() < 2e-3, "{}", cube.position);
        assert!(cube.linear.length() < 1e-5, "{}", cube.linear);
    }
    let clipped = ends("assets/scenes/past_the_edge.ron", 3.0, clip);
    assert!(clipped.position.y < 0.6 && clipped.position.x > 2.9, "{}", clipped.position);
}

#[test]
fn far_corners_hold_a_cube_on_its_corner_and_stop_a_ball() {
    let height = |change: fn(&mut SolverSettings)| ends("assets/scenes/on_a_corner.ron", 3.0, change).position.y;
    let (extreme, clipped) = (height(|_| ()), height(clip));
    assert!(extreme > 0.6 && (clipped - 0.49).abs() < 5e-3, "centre at {extreme} m, clipped at {clipped} m");
    let rolled = |change: fn(&mut SolverSettings)| ends("assets/scenes/rolling_over_a_slab.ron", 3.0, change);
    let (extreme, clipped) = (rolled(|_| ()), rolled(clip));
    assert!(extreme.position.x < 8.0 && extreme.linear.length() < 0.5, "{} at {}", extreme.position, extreme.linear);
    // 5/7 of its speed, once it rolls.
    assert!((clipped.linear.x - 5.0 * 5.0 / 7.0).abs() < 0.05, "{}", clipped.linear);
}

#[test]
fn a_manifold_needs_about_half_the_points() {
    for scene in ["pyramid", "card_house"] {
        let [extreme, clipped] = [ContactModel::ExtremeVertices, ContactModel::Clipping]
            .map(|model| run(scene, &[], 0.1, |settings| settings.sweeps.contacts = model).contacts);
        assert!(10 * clipped < 6 * extreme && 10 * clipped > 4 * extreme, "{scene}: {clipped} of {extreme}");
    }
}

/// A rod that falls on its end: what pushes it out of the ground by its velocity throws it up, what moves it out does
/// not. What spins it about its long axis are few sweeps over points that are not clipped, with either.
#[test]
fn a_bias_throws_a_rod_up_and_projection_does_not() {
    let rod = |change: fn(&mut SolverSettings)| {
        let states = last_body("assets/scenes/tilted_rod.ron", &[], 2.0, change);
        let largest = |of: fn(&BodyState) -> f64| states.iter().map(of).fold(0.0, f64::max);
        (largest(|state| state.linear.y), largest(|state| state.angular.length()))
    };
    let (rises, turns) = rod(|_| ());
    assert!(rises > 0.5 && turns > 6.0, "{rises} m/s, {turns} rad/s");
    let (rises, turns) = rod(clip);
    assert!(rises > 0.5 && turns < 4.0, "clipped: {rises} m/s, {turns} rad/s");
    let (rises, turns) = rod(|settings| settings.sweeps.nonlinear_projection = true);
    assert!(rises < 0.3 && turns > 6.0, "projected: {rises} m/s, {turns} rad/s");
    let (rises, turns) = rod(|settings| {
        clip(settings);
        settings.sweeps.nonlinear_projection = true;
    });
    assert!(rises < 0.02 && turns < 4.0, "clipped and projected: {rises} m/s, {turns} rad/s");
}

// Columns.

#[test]
fn a_column_of_ten_stands_without_clipping_where_sweeps_converge() {
    let column = run("stack", &[("n", 10.0)], 3.0, |settings| settings.iterations = 1000);
    assert!(column.sink_max_m < 0.11 && column.drift_max_m < 0.02, "{} m, {} m", column.sink_max_m, column.drift_max_m);
    let column = run("stack", &[("n", 10.0)], 3.0, |_| ());
    assert!(column.sink_max_m > 3.0, "four sweeps: {} m", column.sink_max_m);
}

#[test]
fn caching_and_clipping_hold_ten_cubes_at_25_sweeps_and_neither_does_alone() {
    let sinks = |caching: bool, clipping: bool| {
        let column = run("stack", &[("n", 10.0)], 10.0, |settings| {
            settings.iterations = 25;
            settings.sweeps.warm_starting = caching;
            if clipping {
                clip(settings);
            }
        });
        column.sink_max_m
    };
    let both = sinks(true, true);
    assert!(both < 0.12, "{both} m");
    for (caching, clipping) in [(true, false), (false, true)] {
        let alone = sinks(caching, clipping);
        assert!(alone > 1.0, "caching {caching}, clipping {clipping}: {alone} m");
    }
}

/// A point is known again by its pair and its vertex.
#[test]
fn caching_works_on_extreme_vertices() {
    let cube = run("stack", &[("n", 1.0)], 5.0, |settings| settings.sweeps.warm_starting = true);
    assert!(trembles(&cube) < 0.05, "{} m/s; without: 0.34", trembles(&cube));
}

// The solver.

#[test]
fn priming_makes_a_cord_of_ten_take_15_passes_instead_of_100() {
    let cord = |method, iterations| {
        run("hanging", &[("n", 10.0)], 3.0, |settings| {
            settings.method = method;
            settings.iterations = iterations;
            settings.precision = Precision::F64;
        })
    };
    let error = |metrics: &Metrics| metrics.truth.as_ref().expect("statics").error;
    assert!(error(&cord(Method::PrimedGaussSeidel, 15)) < 1e-3);
    assert!(error(&cord(Method::ProjectedGaussSeidel, 15)) > 1e-2);
    assert!(error(&cord(Method::ProjectedGaussSeidel, 100)) < 1e-3);
    // It takes that many passes to begin.
    let [swept, primed] = [Method::ProjectedGaussSeidel, Method::PrimedGaussSeidel].map(|method| cord(method, 4));
    assert_eq!(swept.state_hash, primed.state_hash);
}

#[test]
fn at_four_sweeps_joints_part_the_less_the_larger_the_factor() {
    let gap = |factor, iterations| {
        run("rods", &[("n", 5.0)], 2.0, |settings| {
            settings.sweeps.baumgarte = factor;
            settings.iterations = iterations;
        })
        .joint_error_max_m
    };
    let gaps = [0.05, 0.2, 0.35, 0.8, 1.0].map(|factor| gap(factor, 4));
    assert!(gaps.is_sorted_by(|one, next| *one > 1.1 * next), "{gaps:?}");
    assert!(gap(0.35, 100) > 0.6 * gaps[2], "the bias does the sweeps' work, and little is left for more of them");
}

#[test]
fn verlet_updates_every_row_twice() {
    let updates = |integrator| {
        run("rods", &[("n", 5.0)], 0.5, |settings| settings.sweeps.integrator = integrator).counts.row_updates
    };
    let euler = updates(Integrator::Euler);
    assert_eq!((euler, updates(Integrator::VelocityVerlet)), (5 * 3 * 4, 2 * euler));
}

/// Cones that fell together, of 24 corners each: a thousand axes of a pair.
#[test]
fn reducing_the_axes_saves_tests() {
    let tested = |epsilon| {
        let mut simulation =
            Simulation::new(load("pile", &[]).unwrap(), classic(|settings| settings.sweeps.axis_epsilon = epsilon));
        let tested = (0..60).map(|_| {
            simulation.step();
            simulation.world().resource::<StepStats>().axes_tested
        });
        tested.sum::<u64>() as f64
    };
    let all = tested(0.0);
    let shares = [0.01, 0.1, 0.5].map(|epsilon| tested(epsilon) / all);
    assert!(shares[0] > 0.7 && shares[1] < 0.6 && shares[2] < 0.2, "{shares:?}");
}

// What moves freely, and what the loop does.

/// 5 m, in the steps that a clock would count.
#[test]
fn drag_makes_falling_slow() {
    let fall = |drag| {
        let states = last_body("bounce", &[("height", 6.0)], 8.0, |settings| settings.drag = drag);
        let landed = states.iter().position(|state| state.position.y < 1.0).expect("a landing");
        (landed + 1) as f64 / 60.0
    };
    let free = fall(0.0);
    for (drag, slower) in [(0.1, 1.02), (1.0, 1.2), (3.0, 1.85), (10.0, 5.2)] {
        assert!((fall(drag) / free / slower - 1.0).abs() < 0.03, "c = {drag}: {} of {free} s", fall(drag));
    }
}

/// Damping is no friction: on 10 degrees a box slides on however strongly it is damped, and with friction it stays.
#[test]
fn drag_holds_nothing_on_a_slope() {
    let slid = |friction, drag| {
        run("incline", &[("theta", 10.0)], 2.0, |settings| (settings.friction, settings.drag) = (friction, drag))
            .drift_max_m
    };
    let damped = slid(FrictionModel::Off, 3.0);
    assert!(damped > 0.5, "{damped} m");
    assert!(slid(FrictionModel::OneTangent, 0.0) < 0.05);
}

/// A ball that should stop rises by a quarter of its fall.
#[test]
fn contacts_one_step_late_throw_a_ball_up() {
    let ball = |contact_lag| {
        let states = last_body("bounce", &[("e", 0.0)], 3.0, |settings| settings.sweeps.contact_lag = contact_lag);
        let lowest = states.iter().position(|state| state.position.y < 0.1).expect("a landing");
        states[lowest..].iter().map(|state| state.position.y - 0.1).fold(f64::MIN, f64::max)
    };
    let (prompt, late) = (ball(0), ball(1));
    assert!(prompt < 0.3 && (0.8..2.0).contains(&late), "{prompt} m, with lag {late} m");
}
