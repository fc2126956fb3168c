//! Reference answers, fed with motions that are worked out here, and runs that come near them.

use std::convert::Infallible;

use bevy::math::{DQuat, DVec3};
use plumb::lab::truth::{self, Truth};
use plumb::lab::verdict::{Verdict, judge};
use plumb::lab::{BodyState, Plan, Sample, Simulation, measure};
use plumb::physics::{FrictionModel, Precision, SolverSettings};
use plumb::scene::{SceneSpec, load};

fn scene(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(name, &parameters).unwrap()
}

fn known(scene: &SceneSpec) -> Option<Truth> {
    truth::of(scene, &SolverSettings::default())
}

fn at_start(scene: &SceneSpec) -> Vec<BodyState> {
    let bodies = scene.bodies.iter().map(|body| BodyState {
        position: body.position,
        rotation: body.rotation,
        linear: body.linear_velocity,
        angular: body.angular_velocity,
    });
    bodies.collect()
}

/// The answer's error over a motion given by `change`, which edits the start state to that of
/// time t, sampled at 100 Hz for `seconds`.
fn error_of(scene: &SceneSpec, seconds: f64, mut change: impl FnMut(f64, &mut [BodyState])) -> f64 {
    let mut truth: Truth = known(scene).expect("an answer");
    for step in 0..=(100.0 * seconds).round() as u64 {
        let time = step as f64 / 100.0;
        let mut bodies = at_start(scene);
        change(time, &mut bodies);
        truth.observe(&Sample { step, time, bodies: &bodies, loads: &[] });
    }
    truth.error().expect("something to compare")
}

/// The error of a run with converged rows.
fn error_of_run(name: &str, parameters: &[(&str, f64)], hz: f64, seconds: f64) -> f64 {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let settings = SolverSettings {
        hz,
        substeps: 1,
        iterations: 60,
        precision: Precision::F64,
        slop: 0.0,
        restitution_speed: Some(0.0),
        ..SolverSettings::steady()
    };
    let plan = Plan::new(name, &parameters, settings, Some(seconds)).unwrap();
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap().truth.expect("an answer").error
}

#[test]
fn rods_and_chain_follow_the_reference_tables() {
    for (name, parameters, column) in [
        ("rods", [("n", 2.0)], include_str!("../../assets/reference/rods-2.csv")),
        ("chain", [("r", 1000.0)], include_str!("../../assets/reference/chain-1000.csv")),
    ] {
        let scene = scene(name, &parameters);
        let last = scene.bodies.len() - 1;
        let arm = if name == "rods" { DVec3::new(0.5, 0.0, 0.0) } else { DVec3::ZERO };
        let point = |time: f64| {
            let row = column.lines().nth(1 + (10.0 * time).round() as usize).unwrap();
            let numbers: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
            DVec3::new(numbers[1], numbers[2], numbers[3])
        };
        let follow = |off: DVec3| {
            error_of(&scene, 2.0, |time, bodies| {
                let turned = DQuat::from_rotation_z(3.0 * time);
                bodies[last] =
                    BodyState { position: point(time) - turned * arm + off, rotation: turned, ..bodies[last] };
            })
        };
        assert!(follow(DVec3::ZERO) < 1e-12, "{name}");
        assert!((follow(DVec3::new(0.0, 3e-3, 4e-3)) - 5e-3).abs() < 1e-12, "{name}");
    }
}

#[test]
fn the_heavy_top_precesses_at_the_rate_of_the_scene_table() {
    let scene = scene("heavy_top", &[]);
    let top = scene.bodies.iter().position(|body| body.name == "top").unwrap();
    let precess = |rate: f64| {
        error_of(&scene, 2.0, |time, bodies| {
            bodies[top].rotation = DQuat::from_rotation_y(rate * time) * bodies[top].rotation;
        })
    };
    // The table's rate has five digits; twice the rate is off by an angle seen from the axis.
    assert!(precess(1.7551) < 1e-4, "{}", precess(1.7551));
    let (tilt, turned) = (30_f64.to_radians(), 1.7551_f64);
    let at_one_second = 2.0 * (tilt.sin() * (0.5 * turned).sin()).asin();
    assert!(precess(2.0 * 1.7551) > at_one_second);
}

#[test]
fn a_box_on_a_slope_sticks_or_slides() {
    let slope = |theta: f64, mu: f64, acceleration: f64| {
        let scene = scene("incline", &[("theta", theta), ("mu", mu)]);
        error_of(&scene, 1.0, |time, bodies| {
            bodies.last_mut().unwrap().position += DVec3::new(0.5 * acceleration * time * time, -0.001, 0.0);
        })
    };
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let slides = 9.81 * (sin - 0.4 * cos);
    assert!(slope(30.0, 0.4, slides) < 1e-12);
    assert!((slope(30.0, 0.4, 0.0) - 0.5 * slides).abs() < 1e-12);
    assert!(slope(20.0, 0.4, 0.0) < 1e-12);
    assert!((slope(20.0, 0.4, 1.0) - 0.5).abs() < 1e-12);
}

#[test]
fn what_slides_on_any_number_of_points_follows_the_same_answer() {
    for points in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 64.0] {
        for (theta, slides) in [(30.0, true), (20.0, false)] {
            let parameters = [("theta".to_owned(), theta), ("points".to_owned(), points)];
            let plan = Plan::new("incline", &parameters, SolverSettings::accurate(), Some(1.0)).unwrap();
            let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
            let error = metrics.truth.unwrap().error;
            assert!(error < 1e-9, "{points} points, {theta} degrees: off by {error} m");
            assert_eq!(metrics.drift_max_m > 0.5, slides, "{points} points, {theta} degrees");
        }
    }
}

/// Another law of friction is told, the last step of 60 a second is not; rounding at rest is no gain of energy.
#[test]
fn a_slope_is_judged_by_whether_it_holds_and_by_how_far_things_slide() {
    let judged = |theta: f64, points: f64, preset: fn() -> SolverSettings| {
        let parameters = [("theta".to_owned(), theta), ("points".to_owned(), points), ("mu".to_owned(), 0.1)];
        let plan = Plan::new("incline", &parameters, SolverSettings { iterations: 20, ..preset() }, None).unwrap();
        let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
        let share = metrics.further_truths.first().map(|truth| truth.error);
        (judge(&metrics).verdict, judge(&metrics).reason, share)
    };
    let (verdict, reason, share) = judged(45.0, 6.0, SolverSettings::classic);
    assert!(verdict == Verdict::Fails && reason.contains("as a share"), "six times the friction: {reason}");
    assert!((0.4..1.0).contains(&share.unwrap()), "{share:?}");
    let two_tangents = || SolverSettings { friction: FrictionModel::TwoTangents, ..SolverSettings::classic() };
    let (_, reason, share) = judged(45.0, 6.0, two_tangents);
    assert!(share.unwrap() < 0.02, "off by {share:?}: {reason}");
    for points in [1.0, 2.0, 4.0, 12.0] {
        let (verdict, reason, share) = judged(5.0, points, SolverSettings::accurate);
        assert_eq!((verdict, share), (Verdict::Holds, None), "{points} points at rest: {reason}");
    }
    let (verdict, reason, _) =
        judged(5.0, 4.0, || SolverSettings { friction: FrictionModel::Off, ..SolverSettings::classic() });
    assert!(verdict == Verdict::Fails && reason.contains("a body that should stay moves"), "{reason}");
}

#[test]
fn a_thrown_ball_slides_then_rolls() {
    let scene = scene("slide_roll", &[]);
    let rolls_from = 2.0 * 5.0 / (7.0 * 0.3 * 9.81);
    let roll = |share: f64| {
        error_of(&scene, 2.0, |time, bodies| {
            let slid = time.min(rolls_from) / rolls_from;
            let ball = bodies.last_mut().unwrap();
            ball.linear = DVec3::X * 5.0 * (1.0 - slid * 2.0 / 7.0);
            ball.angular = -DVec3::Z * share * slid * (5.0 * 5.0 / 7.0) / 0.5;
        })
    };
    assert!(roll(1.0) < 1e-12);
    assert!((roll(0.9) - 0.1 * 25.0 / 7.0).abs() < 1e-12, "{}", roll(0.9));
}

#[test]
fn a_pushed_slab_carries_its_balls() {
    let slab_gain = (150.0 - 0.4 * 35.0 * 9.81) / (10.0 + 25.0 * 2.0 / 7.0);
    for angle in [0.0_f64, 60.0] {
        let scene = scene("rolling", &[("angle", angle)]);
        let slab = scene.bodies.iter().position(|body| body.name == "slab").unwrap();
        let along = DVec3::new(angle.to_radians().cos(), 0.0, angle.to_radians().sin());
        let error = |off: f64| {
            error_of(&scene, 4.0, |time, bodies| {
                bodies[slab].linear = (slab_gain * time + off) * along;
                bodies[slab + 1..].iter_mut().for_each(|ball| ball.linear = 2.0 / 7.0 * slab_gain * time * along);
            })
        };
        assert!(error(0.0) < 1e-20, "{angle}: {}", error(0.0));
        assert!((error(0.1) - 0.01).abs() < 1e-12, "a constant slip of 0.1 m/s is 0.01 m²/s² in the mean");
    }
}

#[test]
fn balls_without_restitution_must_not_overlap() {
    let scene = scene("spheres", &[("e", 0.0)]);
    let ball = scene.bodies.iter().position(|body| body.name == "ball 0").unwrap();
    let error = |depth: f64| {
        error_of(&scene, 0.1, |_, bodies| {
            bodies[ball].position.y = if depth > 0.0 { 0.1 - depth } else { bodies[ball].position.y };
        })
    };
    assert_eq!(error(0.0), 0.0);
    assert!((error(0.02) - 4e-4).abs() < 1e-12, "{}", error(0.02));
    // Two balls in the same place: (0.2 m)², and the other's neighbors untouched.
    let other = scene.bodies.len() - 1;
    let stacked = error_of(&scene, 0.1, |_, bodies| {
        bodies[ball].position = DVec3::new(0.0, 50.0, 0.0);
        bodies[other].position = DVec3::new(0.0, 50.0, 0.0);
    });
    assert!((stacked - 0.04).abs() < 1e-12, "{stacked}");
}

#[test]
fn balls_with_restitution_one_keep_their_energy() {
    let scene = scene("spheres", &[("e", 1.0)]);
    // 10 kg at 1 m/s gain 5 J; where the rim turns as fast, 2/5 of that more.
    let error = |spin: f64| {
        error_of(&scene, 0.1, |time, bodies| {
            let ball = bodies.last_mut().unwrap();
            ball.linear = DVec3::X * f64::from(time > 0.0);
            ball.angular = DVec3::Z * spin * f64::from(time > 0.0);
        })
    };
    assert!((error(0.0) - 25.0).abs() < 1e-9, "{}", error(0.0));
    assert!((error(10.0) - 49.0).abs() < 1e-9, "{}", error(10.0));
}

#[test]
fn the_cradle_swings_at_its_ends_by_turns() {
    let scene = scene("cradle", &[]);
    let bobs: Vec<usize> = (0..5).map(|i| 2 * i + 1).collect();
    let frequency = (9.81_f64 / (1.0 + 0.4 * 0.01)).sqrt();
    // θ″ = −ω₀² sin θ by many small symplectic steps, from 30° on the first ball's side.
    let swing = |ends: [usize; 2]| {
        let (mut angle, mut rate, mut now) = (30_f64.to_radians(), 0.0, 0.0);
        error_of(&scene, 4.0, |time, bodies| {
            let step = 1e-5;
            while now < time - 0.5 * step {
                rate -= 0.5 * step * frequency * frequency * angle.sin();
                angle += step * rate;
                rate -= 0.5 * step * frequency * frequency * angle.sin();
                now += step;
            }
            bodies[bobs[0]].rotation = DQuat::IDENTITY;
            let carrier = ends[usize::from(angle < 0.0)];
            bodies[bobs[carrier]].rotation = DQuat::from_rotation_z(-angle);
        })
    };
    // Leapfrog: (ω₀ h)² over 13 rad.
    assert!(swing([0, 4]) < 1e-7, "{}", swing([0, 4]));
    assert!((swing([0, 3]) - 30_f64.to_radians()).abs() < 1e-2, "{}", swing([0, 3]));
}

#[test]
fn scenes_at_rest_count_every_move() {
    for name in ["hanging", "stack", "pyramid", "pyramids", "sandwich", "joint_grid", "card_house", "arch"] {
        let scene = scene(name, &[]);
        let one_of_many = scene.bodies.len() - 2;
        let pushed = |by: DVec3| {
            error_of(&scene, 0.1, |time, bodies| {
                bodies[one_of_many].position += if time == 0.05 { by } else { DVec3::ZERO };
            })
        };
        assert_eq!(pushed(DVec3::ZERO), 0.0, "{name}");
        assert!((pushed(DVec3::new(0.0, -0.03, 0.04)) - 0.05).abs() < 1e-12, "{name}");
    }
}

#[test]
fn dominoes_must_all_fall_and_in_order() {
    let scene = scene("dominoes", &[]);
    // Domino i lies from its turn on: one every 0.1 s, but for what `falls` changes.
    let error = |seconds: f64, falls: fn(usize) -> f64| {
        error_of(&scene, seconds, |time, bodies| {
            for (place, domino) in bodies[1..].iter_mut().enumerate() {
                let tilt: f64 = if time > falls(place) { 66.0 } else { 5.0 };
                domino.rotation = DQuat::from_rotation_z(-tilt.to_radians());
            }
        })
    };
    let in_order = |place: usize| 0.1 * place as f64 + 0.05;
    assert_eq!(error(4.0, in_order), 0.0);
    assert_eq!(error(1.0, in_order), 10.0, "ten of twenty after half of the time");
    assert_eq!(error(4.0, |place| if place == 19 { 9.0 } else { 0.1 * place as f64 }), 1.0, "the last stands");
    assert_eq!(error(4.0, |place| 0.1 * if place == 7 { 9.2 } else { place as f64 } + 0.05), 2.0, "8 and 9 before 7");
    // Backwards is not fallen.
    let backwards = error_of(&scene, 1.0, |_, bodies| {
        bodies[1..].iter_mut().for_each(|domino| domino.rotation = DQuat::from_rotation_z(66_f64.to_radians()));
    });
    assert_eq!(backwards, 20.0);
    let limit = known(&scene).unwrap().further[0].fails_above.unwrap();
    assert!(limit > 0.0 && limit < 1.0, "one out of turn breaks the order");
}

#[test]
fn a_rod_that_slides_on_is_off_by_what_it_should_have_slowed_down() {
    // N/m = g/D on the edge, D = 1 + x (x − μ y)/k².
    let (beside, below) = (0.25 - 0.005 * 3_f64.sqrt(), 0.25 * 3_f64.sqrt() + 0.005);
    let square_radius = (1.0 + 0.02 * 0.02) / 12.0;
    let scene = scene("painleve", &[("mu", 0.5)]);
    let support = 9.81 / (1.0 + beside * (beside - 0.5 * below) / square_radius);
    let turning = support * (beside - 0.5 * below) / square_radius;
    let off = error_of(&scene, 0.01, |time, bodies| bodies[1].position.x += 5.0 * time);
    // At t = 10 ms the upper end, 2 · 0.433 m above the edge, is farthest off: ½ a t².
    let upper = DVec3::new(-0.5 - beside, 2.0 * below - 0.01, 0.0) - DVec3::new(-beside, below, 0.0);
    let slowing = DVec3::new(-0.5 * support, support - 9.81, 0.0) + turning * DVec3::Z.cross(upper);
    let expected = 0.5 * 1e-4 * slowing.length();
    assert!((off / expected - 1.0).abs() < 0.05, "{off} {expected}");
}

#[test]
fn a_rod_without_a_rigid_motion_must_not_gain_energy() {
    let scene = scene("painleve", &[("mu", 1.5)]);
    let error = |change: fn(&mut BodyState)| error_of(&scene, 0.1, |_, bodies| change(&mut bodies[1]));
    assert_eq!(error(|_| ()), 0.0);
    assert_eq!(error(|rod| rod.linear *= 0.5), 0.0, "losing some is fine");
    let mass = 1000.0 * 0.02 * 0.02;
    assert!((error(|rod| rod.position.y += 0.1) - mass * 9.81 * 0.1).abs() < 1e-12);
    let spin = error(|rod| rod.angular.z = 2.0);
    assert!((spin - 0.5 * mass * (1.0 + 0.02 * 0.02) / 12.0 * 4.0).abs() < 1e-12, "{spin}");
}

#[test]
fn a_ball_rests_on_the_wall_it_was_thrown_at() {
    let scene = scene("wall", &[("v", 10.0), ("t", 0.05)]);
    let start = scene.bodies[1].position.x;
    let fly = |stops_at: f64| {
        let mut truth = known(&scene).unwrap();
        for step in 0..=100 {
            let time = f64::from(step) / 100.0;
            let mut bodies = at_start(&scene);
            bodies[1].position.x = (start + 10.0 * time).min(stops_at);
            truth.observe(&Sample { step: step as u64, time, bodies: &bodies, loads: &[] });
        }
        (truth.error().unwrap(), truth.further[0].error().unwrap())
    };
    let beyond = known(&scene).unwrap().further[0].fails_above.unwrap();
    assert_eq!(fly(-0.1), (0.0, 0.0), "the ball's radius before the face");
    let stops_short = fly(-0.3);
    assert!((stops_short.0 - 0.2).abs() < 1e-12 && stops_short.1 == 0.0, "{stops_short:?}");
    let sinks = fly(-0.07);
    assert!((sinks.1 - 0.03).abs() < 1e-12 && sinks.1 > beyond, "{sinks:?}");
    assert!(fly(-0.09).1 < beyond);
}

#[test]
fn far_is_compared_with_its_twin_at_the_origin() {
    let mut settings = SolverSettings { iterations: 3, ..SolverSettings::default() };
    settings.impulse.fitted_effort = false;
    let error = |twin_settings: SolverSettings, off: DVec3| {
        let mut run = Simulation::new(scene("far", &[("d", 1024.0)]), settings);
        let mut truth = truth::of(run.scene(), &twin_settings).unwrap();
        truth.observe(&run.sample());
        for _ in 0..10 {
            run.step();
            let mut bodies = run.sample().bodies.to_vec();
            bodies[3].position += off;
            truth.observe(&Sample { bodies: &bodies, ..run.sample() });
        }
        assert_eq!(truth.fails_above, Some(1e-5));
        truth.error().unwrap()
    };
    let same = error(settings, DVec3::ZERO);
    assert!(same < 1e-9, "{same}");
    assert!((error(settings, DVec3::new(0.0, 3e-3, 4e-3)) - 5e-3).abs() < 1e-9);
    // A twin with other settings moves otherwise.
    assert!(error(SolverSettings { iterations: 4, ..settings }, DVec3::ZERO) > 1e-6);
    assert!(known(&scene("far", &[("d", 0.0)])).is_none(), "at the origin there is nothing to compare with");
}

#[test]
fn unknown_answers_are_none() {
    for (name, parameter) in
        [("rods", ("n", 3.0)), ("chain", ("r", 7.0)), ("joint_grid", ("tilt", 10.0)), ("spheres", ("e", 0.5))]
    {
        assert!(known(&scene(name, &[parameter])).is_none(), "{name}");
    }
    assert!(known(&scene("limbs", &[])).is_none());
}

#[test]
fn every_answer_belongs_to_a_scene() {
    for name in "pendulum rods chain joint_grid top heavy_top incline slide_roll rolling bounce spheres \
                 cradle wall hanging stack pyramid pyramids sandwich painleve dominoes arch card_house far four_bar \
                 bricard andrews arm servo stop hinge_chain bridge tower ragdolls"
        .split_whitespace()
    {
        let truth = known(&scene(name, &[("r", 1.0)].map(|p| p)[..usize::from(name == "chain")]));
        assert!(truth.is_some_and(|truth| !truth.name.is_empty() && truth.error().is_none()), "{name}");
    }
}

/// Symplectic Euler is of first order: a quarter of the step leaves about a quarter of the error.
#[test]
fn runs_close_in_on_the_pendulum_the_rods_and_the_sliding_rod() {
    for (name, parameters, fine_error) in
        [("pendulum", &[][..], 4e-3), ("rods", &[("n", 2.0)][..], 4e-3), ("painleve", &[("mu", 1.0)][..], 2e-3)]
    {
        let coarse = error_of_run(name, parameters, 480.0, 1.0);
        let fine = error_of_run(name, parameters, 1920.0, 1.0);
        let order = (coarse / fine).log(4.0);
        assert!((0.8..1.5).contains(&order), "{name}: {coarse} → {fine}, order {order}");
        assert!(fine < fine_error, "{name}: {fine}");
    }
}

#[test]
fn runs_close_in_on_friction_rolling_and_bouncing() {
    for (name, parameters, seconds, most) in [
        // ½ a t h of symplectic Euler: 1.6e-3.
        ("incline", &[("theta", 30.0), ("mu", 0.4)][..], 1.0, 2e-3),
        ("incline", &[("theta", 20.0), ("mu", 0.4)][..], 1.0, 1e-9),
        // Speeds change linearly: exact.
        ("slide_roll", &[][..], 2.0, 1e-9),
        ("painleve", &[("mu", 0.3)][..], 0.5, 6e-3),
        ("painleve", &[("mu", 1.0)][..], 0.5, 6e-3),
        ("painleve", &[("mu", 1.5)][..], 0.5, 1e-12),
        // Landings are up to a step late, at 9.8 m/s.
        ("bounce", &[("e", 0.5)][..], 4.0, 0.03),
    ] {
        let error = error_of_run(name, parameters, 480.0, seconds);
        assert!(error < most, "{name} {parameters:?}: {error}");
    }
}
