//! Saved contact problems: their format, how they are written, and the measure that the benchmark `contacts` takes.

#[path = "../../benches/contacts/natural_map.rs"]
mod natural_map;

use std::fs;
use std::path::Path;

use bevy::math::{DMat3, DVec3};
use plumb::lab::{
    ContactProblemError, Plan, Simulation, contact_problem_files, read_contact_problem, write_contact_problem,
};
use plumb::physics::{
    ContactProblem, HardProblem, HardProblems, ProblemBody, ProblemContact, ProblemJoint, SolverSettings,
};

use crate::command_line::refuses;
use natural_map::{Impulses, residual};

const STEP: f64 = 1.0 / 60.0;
const FRICTION: f64 = 0.5;

/// A ball of 2 kg, r 0.5 m, on the ground, under its weight for a step and with a velocity along x.
fn ball(speed: f64) -> ContactProblem {
    ContactProblem {
        bodies: vec![ProblemBody {
            inverse_mass: DVec3::splat(0.5),
            inverse_inertia: DMat3::from_diagonal(DVec3::splat(5.0)),
            velocity: DVec3::new(speed, -9.81 * STEP, 0.0),
            angular_velocity: DVec3::ZERO,
        }],
        contacts: vec![ProblemContact {
            bodies: [None, Some(0)],
            arms: [DVec3::ZERO, DVec3::new(0.0, -0.5, 0.0)],
            normal: DVec3::Y,
            friction: FRICTION,
            bias: DVec3::ZERO,
            guess: DVec3::ZERO,
        }],
        joints: Vec::new(),
    }
}

/// Numbers of all kinds: a third of anything, what has no short decimal, the least and the largest.
fn numbers() -> ContactProblem {
    let mut problem = ball(1.0 / 3.0);
    problem.bodies.push(ProblemBody { inverse_mass: DVec3::new(0.0, 5e-324, 1e300), ..problem.bodies[0] });
    problem.contacts[0].guess = DVec3::new(-0.0, f64::MIN_POSITIVE, -1.0 / 7e-12);
    problem.contacts[0].bodies = [Some(1), None];
    let matrix = DMat3::from_cols_array(&[0.1, 0.2, 0.3, 1e-17, -2e22, 3.0, 4.0, 5.5, -6e5]);
    problem.joints.push(ProblemJoint {
        bodies: [Some(1), Some(0)],
        jacobians: [[matrix, -matrix], [matrix.transpose(), DMat3::ZERO]],
        bounds: (f64::NEG_INFINITY, 0.1 + 0.2),
        bias: DVec3::new(1e5, 123_456.789, 1e21),
        guess: DVec3::ONE,
    });
    problem
}

#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_contact_problem(&path, &numbers(), "of all kinds").unwrap();
    let read = read_contact_problem(&path).unwrap();
    assert_eq!(read, numbers());
    assert!(read.contacts[0].guess.x.is_sign_negative(), "-0 is not 0");
    assert_eq!(contact_problem_files(folder.path()).unwrap(), [path]);
}

#[test]
fn what_is_malformed_is_refused_at_its_line_with_the_cure() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_contact_problem(&path, &numbers(), "of all kinds").unwrap();
    let good = fs::read_to_string(&path).unwrap();
    // Lines: header, comment, bodies, two of them, contacts, one, joints, one.
    let with = |line: usize, change: &dyn Fn(&str) -> String| {
        let lines =
            good.lines().enumerate().map(|(index, text)| if index + 1 == line { change(text) } else { text.into() });
        lines.collect::<Vec<_>>().join("\n")
    };
    let word = |index: usize, new: &'static str| {
        move |line: &str| {
            let mut words: Vec<_> = line.split(' ').collect();
            words[index] = new;
            words.join(" ")
        }
    };
    let cases: [(String, usize, &str); 18] = [
        (String::new(), 1, "the first line is to be 'plumb contact problem 1'"),
        (with(1, &|_| "plumb contact problem 2".into()), 1, "the first line is to be"),
        (with(3, &|_| "bodies many".into()), 3, "'bodies many' is to be 'bodies N'"),
        (with(3, &|_| "bodies 1".into()), 5, "is to be 'contacts N'"),
        (with(4, &word(0, "x")), 4, "'x' is to be a number"),
        (with(4, &word(0, "NaN")), 4, "'NaN' is to be a number"),
        (with(4, &word(0, "inf")), 4, "only bounds may be"),
        (with(4, &word(1, "-1")), 4, "none may be less than 0"),
        (with(4, &word(4, "9")), 4, "is to be symmetric"),
        (with(5, &|line| line[..line.len() - 2].into()), 5, "numbers are missing at the end"),
        (with(5, &|line| format!("{line} 7")), 5, "'7' is one number too many"),
        (with(7, &word(0, "2")), 7, "'2' is to be a body from 0 to 1, or '-'"),
        (with(7, &word(0, "-")), 7, "A and B are to be two bodies"),
        (with(7, &word(9, "2")), 7, "it is to have length 1"),
        (with(7, &word(11, "-0.5")), 7, "is to be 0 or more"),
        (with(9, &word(38, "1")), 9, "is to be no more than the most"),
        (good.lines().take(8).collect::<Vec<_>>().join("\n"), 9, "line 1 of 1 joints is to follow"),
        (format!("{good}joints 0\n"), 10, "after the last joint is to go"),
    ];
    for (text, line, says) in cases {
        fs::write(&path, &text).unwrap();
        let error = read_contact_problem(&path).expect_err(says).to_string();
        let place = format!("{}:{line}: ", path.display());
        assert!(error.starts_with(&place) && error.contains(says), "'{says}' at {line}, not: {error}");
        assert_eq!(error.lines().count(), 1);
    }
    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(contact_problem_files(empty.path()), Err(ContactProblemError::NoneHere { .. })));
    let missing = contact_problem_files(&empty.path().join("no")).unwrap_err().to_string();
    assert!(missing.contains("cannot be read"), "{missing}");
}

/// λ of the ball: it lands, and where it slides the ground rubs with μ times that. Sticking it would roll at 5/7 of its speed.
fn solution(speed: f64) -> DVec3 {
    let weight = 2.0 * 9.81 * STEP;
    let rolling = 2.0 / 7.0 * 2.0 * speed;
    DVec3::new(-rolling.min(FRICTION * weight), weight, 0.0)
}

#[test]
fn the_measure_is_zero_for_what_obeys_the_laws_and_catches_what_does_not() {
    let of = |speed: f64, impulse: DVec3| residual(&ball(speed), &Impulses { contacts: vec![impulse], joints: vec![] });
    for speed in [0.0, 0.1, 0.9] {
        let right = solution(speed);
        assert!(of(speed, right) < 1e-15, "{speed}: {:e} m/s", of(speed, right));
        // None; too little and too much; pulling; from the side; the other way; more than the cone allows.
        let wrong = [
            DVec3::ZERO,
            right * 0.99,
            right * 1.01,
            -right,
            right + 0.01 * DVec3::Z,
            right * DVec3::new(-1.0, 1.0, 1.0) + 0.01 * DVec3::X,
            right - 0.01 * DVec3::X,
        ];
        for (case, impulse) in wrong.into_iter().enumerate() {
            assert!(of(speed, impulse) > 1e-3, "{speed}, {case}: {:e} m/s", of(speed, impulse));
        }
    }
    assert!(of(0.0, DVec3::NAN).is_nan());
    // The associated law's answer to sliding takes off: u + μ|u_t| n is not along the ground.
    let mut lifted = solution(0.9);
    lifted.y += 0.5 * FRICTION * 0.5;
    assert!(of(0.9, lifted) > 1e-2);
    // Relative to what is fast.
    let fast = of(100.0, solution(100.0) * 1.01) / of(1.0, solution(1.0) * 1.01);
    assert!((0.009..0.011).contains(&fast), "{fast}");
}

#[test]
fn the_measure_knows_joints_and_bounds() {
    let mut problem = ball(0.4);
    problem.contacts.clear();
    let hold = |bounds| ProblemJoint {
        bodies: [None, Some(0)],
        jacobians: [[DMat3::ZERO; 2], [DMat3::from_cols(DVec3::X, DVec3::ZERO, DVec3::ZERO), DMat3::ZERO]],
        bounds,
        bias: DVec3::ZERO,
        guess: DVec3::ZERO,
    };
    let (all, some, least) = ((f64::NEG_INFINITY, f64::INFINITY), (-0.3, 0.3), (-2.0, -0.9));
    // 0.8 N s stop it; with at most 0.3 it goes on at 0.25 m/s; with at least 0.9 it turns back.
    for (bounds, impulse, off) in [
        (all, -0.8, 0.0),
        (all, -0.3, 0.25),
        (some, -0.3, 0.0),
        (some, -0.2, 0.05),
        (some, 0.3, 0.3),
        (some, -0.8, 0.25),
        (least, -0.9, 0.0),
    ] {
        problem.joints = vec![hold(bounds)];
        let impulses = Impulses { contacts: vec![], joints: vec![DVec3::X * impulse] };
        let found = residual(&problem, &impulses);
        assert!((found - off).abs() < 1e-15, "{bounds:?}, {impulse}: {found}, not {off}");
    }
}

#[test]
fn a_run_writes_its_hardest_problems_and_is_the_same_without() {
    let plan = Plan::new("car", &[], SolverSettings::accurate(), Some(0.1)).unwrap();
    let mut simulations = [true, false].map(|keeps| {
        let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
        if keeps {
            simulation.world_mut().insert_resource(HardProblems::new(3));
        }
        (0..plan.steps).for_each(|_| simulation.step());
        simulation
    });
    assert_eq!(simulations[0].state_hash(), simulations[1].state_hash());
    let kept = simulations[0].world_mut().remove_resource::<HardProblems>().unwrap();
    assert_eq!(kept.list().len(), 3);
    assert!(kept.list().is_sorted_by(|a, b| a.iterations >= b.iterations && a.step != b.step));

    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("new").display().to_string();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_plumb"))
        .args(["run", "car", "--preset", "accurate", "--seconds", "0.1", "--problems", &at])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = contact_problem_files(Path::new(&at)).unwrap();
    assert!((3..=10).contains(&files.len()), "{files:?}");
    for HardProblem { step, iterations, problem, .. } in kept.list() {
        let path = Path::new(&at).join(format!("car-{step:05}-{iterations}.txt"));
        assert_eq!(&read_contact_problem(&path).unwrap(), problem, "{}", path.display());
    }
}

#[test]
fn problems_are_refused_where_none_are_solved_and_where_they_cannot_be_written() {
    refuses(&["run", "stack", "--problems", "here"], &["--problems", "--preset accurate"]);
    let (_folder, file) = crate::command_line::file("taken", "");
    refuses(&["run", "stack", "--preset", "accurate", "--problems", &file], &["taken", "cannot be written"]);
}

#[test]
fn the_problems_of_the_benchmark_are_some() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/contacts/problems"));
    for file in contact_problem_files(folder).unwrap() {
        let problem = read_contact_problem(&file).unwrap();
        let [guess, zero] =
            [Impulses::guess(&problem), Impulses::zero(&problem)].map(|start| residual(&problem, &start));
        assert!(guess > 1e-8 && zero > 1e-8, "{}: nothing to solve", file.display());
    }
}
