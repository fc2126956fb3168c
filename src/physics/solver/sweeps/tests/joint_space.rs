//! Contacts swept in joint space against dense solutions.

use nalgebra::{DMatrix, DVector};

use super::{Rows, assert_close, flat, solve_by_enumeration};
use crate::physics::constraint::row::{Bounds, Twist};
use crate::physics::solver::sweeps::joint_space;
use crate::physics::solver::sweeps::joint_space::JointSpace;
use crate::physics::testing::Random;

/// λ, M⁻¹Jᵀλ as the method kept it.
fn solved(system: &Rows, sweeps: u32, space: &mut JointSpace<f64>) -> (DVector<f64>, DVector<f64>) {
    let mut rows = system.rows.clone();
    let mut accelerations = vec![Twist::zero(); system.bodies.len()];
    joint_space::solve(&mut rows, &mut accelerations, sweeps, space, |_| ());
    let lambda = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.lambda));
    (lambda, flat(&accelerations))
}

fn rolled(back: u32) -> Bounds<f64> {
    Bounds::Friction { coefficient: 0.5, normal_rows_back: back }
}

/// Two mechanisms, one of them a ring held at a point, the other free, a body by itself, and contacts between them and
/// within them.
fn figures(random: &mut Random) -> Rows {
    let mut system = Rows::random(7, random);
    system.touch(1, 4, &[rolled, rolled], random);
    system.touch(2, 7, &[rolled], random);
    for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 1), (4, 5), (6, 5)] {
        system.join(a, b, random);
    }
    system.touch(4, 6, &[rolled], random);
    system.touch(0, 5, &[rolled], random);
    system.touch(3, 1, &[rolled], random);
    system
}

fn missing(system: &Rows, lambda: &DVector<f64>) -> DVector<f64> {
    system.targets() - system.matrix() * lambda
}

fn joint_rows(system: &Rows) -> Vec<usize> {
    let is_free = |index: &usize| matches!(system.rows[*index].bounds, Bounds::Fixed(lower, _) if lower < -1e300);
    (0..system.rows.len()).filter(is_free).collect()
}

#[test]
fn joints_hold_after_any_number_of_sweeps() {
    let random = &mut Random::new(31);
    for _ in 0..20 {
        let system = figures(random);
        let joints = joint_rows(&system);
        assert_eq!(joints.len(), 18);
        for sweeps in [0, 1, 3] {
            let (lambda, accelerations) = solved(&system, sweeps, &mut JointSpace::default());
            let missing = missing(&system, &lambda).select_rows(&joints).amax();
            assert!(missing < 1e-9 * lambda.amax(), "{missing} m/s² after {sweeps} sweeps");
            assert_close(&accelerations, &system.accelerations(&lambda), 1e-9);
        }
    }
}

/// One row with bounds ends where it must in one sweep, whatever hangs on its bodies: its response is that of the dense
/// K, J K Jᵀ λ = η − J M⁻¹J_EᵀA⁻¹η_E.
#[test]
fn one_contact_takes_one_sweep() {
    let random = &mut Random::new(32);
    let mut pushes = 0;
    for _ in 0..20 {
        let mut system = Rows::random(4, random);
        for body in 1..4 {
            system.join(body, body + 1, random);
        }
        system.touch(0, 2, &[], random);
        let bounds: Vec<(f64, f64)> = (0..10).map(|row| (if row < 9 { f64::MIN } else { 0.0 }, f64::MAX)).collect();
        let exact = solve_by_enumeration(&system.matrix(), &system.targets(), &bounds);
        let (lambda, _) = solved(&system, 1, &mut JointSpace::default());
        assert_close(&lambda, &exact, 1e-8);
        pushes += usize::from(lambda[lambda.len() - 1] > 0.0);
    }
    assert!((4..=16).contains(&pushes), "one-sided cases prove little: {pushes}");
}

#[test]
fn redundant_joints_share_their_load() {
    let random = &mut Random::new(33);
    let mut system = Rows::random(2, random);
    system.join(0, 1, random);
    system.join(1, 2, random);
    for index in 3..6 {
        system.rows.push(system.rows[index]);
    }
    system.touch(0, 2, &[rolled], random);
    let (lambda, _) = solved(&system, 100, &mut JointSpace::default());
    let joints = joint_rows(&system);
    let missing = missing(&system, &lambda).select_rows(&joints).amax();
    assert!(missing < 1e-8, "{missing} m/s²");
    for axis in 3..6 {
        assert!((lambda[axis] - lambda[axis + 3]).abs() < 1e-6 * lambda.amax(), "{lambda}");
    }
}

/// A contact that joints let nothing move is left alone, and does not throw what is joined.
#[test]
fn a_contact_that_joints_hold_stays_without_force() {
    let random = &mut Random::new(34);
    let mut system = Rows::random(1, random);
    for _ in 0..3 {
        system.join(0, 1, random);
    }
    system.rows.iter_mut().for_each(|row| row.target = 0.0);
    system.touch(0, 1, &[rolled], random);
    let (lambda, accelerations) = solved(&system, 10, &mut JointSpace::default());
    assert_eq!(lambda[9], 0.0);
    assert_eq!(accelerations.amax(), 0.0);
}

/// Mechanisms are kept while the same bodies are joined, though contacts come and go before their rows.
#[test]
fn what_is_kept_changes_nothing() {
    let random = &mut Random::new(35);
    let space = &mut JointSpace::default();
    let mut system = figures(random);
    for contacts in 0..4 {
        let fresh = solved(&system, 5, &mut JointSpace::default());
        assert_eq!(solved(&system, 5, space), fresh, "{contacts} more contacts");
        let mut more = Rows { bodies: system.bodies.clone(), rows: Vec::new() };
        more.touch(0, 1 + contacts, &[rolled], random);
        more.rows.append(&mut system.rows);
        system = more;
    }
    // Others are joined.
    let mut other = Rows { bodies: system.bodies.clone(), rows: Vec::new() };
    for (a, b) in [(7, 1), (2, 1), (5, 2), (3, 6), (6, 4), (0, 4)] {
        other.join(a, b, random);
    }
    other.touch(0, 3, &[rolled], random);
    assert_eq!(solved(&other, 5, space), solved(&other, 5, &mut JointSpace::default()));
}

/// What a unit force on one row does to all of them.
#[test]
fn responses_are_those_of_the_dense_matrix() {
    let random = &mut Random::new(36);
    let system = figures(random);
    let joints = joint_rows(&system);
    let matrix = system.matrix();
    let swept: Vec<usize> = (0..system.rows.len()).filter(|row| !joints.contains(row)).collect();
    // J_C K J_Cᵀ, dense.
    let among = |rows: &[usize], columns: &[usize]| matrix.select_rows(rows).select_columns(columns);
    let inverse = among(&joints, &joints).try_inverse().expect("rings are not redundant");
    let dense: DMatrix<f64> = among(&swept, &swept) - among(&swept, &joints) * inverse * among(&joints, &swept);
    for (column, &row) in swept.iter().enumerate() {
        let mut one = system.clone();
        for other in &mut one.rows {
            other.target = 0.0;
        }
        for &other in &swept {
            let force = f64::from(u8::from(other == row));
            one.rows[other].bounds = Bounds::Fixed(force, force);
        }
        let (lambda, _) = solved(&one, 1, &mut JointSpace::default());
        let motion = &matrix * lambda;
        assert_close(&motion.select_rows(&swept), &dense.column(column).into_owned(), 1e-7);
    }
}
