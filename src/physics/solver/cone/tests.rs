//! Against closed forms, enumerated modes of contact, and an independent residual.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::problem::{ConeEnd, ConeOutcome, Velocity};
use super::problems::*;
use super::{ConeBody, ConeContact, ConeJoint, ConeSolver, PerPoint};
use crate::physics::testing::Random;

type V = Vector3<f64>;

/// Solves from no guess and holds that what is reported is so.
fn solved(problem: &Problem) -> (Vec<Velocity>, PerPoint, ConeOutcome) {
    let mut impulses = problem.no_impulses();
    let (velocities, outcome) = problem.solve(&mut ConeSolver::default(), &mut impulses);
    let recomputed = residual(problem, &velocities, &impulses);
    let rounding = 1e-15 * largest(&impulses);
    assert!((recomputed - outcome.residual).abs() <= 1e-12 + rounding, "{recomputed:e}, not {:e}", outcome.residual);
    (velocities, impulses, outcome)
}

fn converged(problem: &Problem) -> (Vec<Velocity>, PerPoint) {
    let (velocities, impulses, outcome) = solved(problem);
    assert_eq!(outcome.end, ConeEnd::Converged, "{outcome:?}");
    (velocities, impulses)
}

fn largest(impulses: &PerPoint) -> f64 {
    impulses.contacts.iter().chain(&impulses.joints).map(V::norm).fold(0.0, f64::max)
}

/// v of impulses, body by body: v = v_free + M⁻¹Jᵀλ.
fn moved(problem: &Problem, impulses: &PerPoint) -> Vec<Velocity> {
    let mut velocities = problem.free.clone();
    let contacts = problem.contacts.iter().map(|contact| (contact.bodies, contact.arms)).zip(&impulses.contacts);
    let joints =
        problem.joints.iter().map(|joint| joint.bodies).zip(problem.joint_arms.iter().copied()).zip(&impulses.joints);
    for ((bodies, arms), impulse) in contacts.chain(joints) {
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let Some(body) = bodies[side] else { continue };
            let of = &problem.bodies[body as usize];
            velocities[body as usize][0] += sign * of.inverse_mass.component_mul(impulse);
            velocities[body as usize][1] += sign * (of.inverse_inertia * arms[side].cross(impulse));
        }
    }
    velocities
}

/// Velocity of B's point relative to A's.
fn between(velocities: &[Velocity], bodies: &[Option<u32>; 2], arms: &[V; 2]) -> V {
    let of = |side: usize| {
        bodies[side].map_or(V::zeros(), |body| {
            let [linear, angular] = velocities[body as usize];
            linear + angular.cross(&arms[side])
        })
    };
    of(1) - of(0)
}

/// The residual, with the impulses' own motion instead of the one returned, in the world's axes; that both are one is
/// checked.
fn residual(problem: &Problem, velocities: &[Velocity], impulses: &PerPoint) -> f64 {
    let own = moved(problem, impulses);
    for (own, [linear, angular]) in own.iter().zip(velocities) {
        let off = (own[0] - linear).norm() + (own[1] - angular).norm();
        assert!(off <= 1e-12 + 1e-15 * largest(impulses) * 100.0, "the motion is not that of the impulses: {off:e}");
    }
    let mut worst = 0.0_f64;
    for ((contact, impulse), bias) in problem.contacts.iter().zip(&impulses.contacts).zip(&problem.bias.contacts) {
        let u = between(&own, &contact.bodies, &contact.arms) + bias;
        let n = contact.normal;
        let inverse_mass: f64 = (0..2)
            .filter_map(|side| {
                let body = &problem.bodies[contact.bodies[side]? as usize];
                let turn = contact.arms[side].cross(&n);
                Some(n.dot(&body.inverse_mass.component_mul(&n)) + turn.dot(&(body.inverse_inertia * turn)))
            })
            .sum();
        if contact.friction == 0.0 {
            let scaled = n.dot(impulse) * inverse_mass;
            assert!((impulse - n * n.dot(impulse)).norm() < 1e-12 * impulse.norm() + 1e-300);
            worst = worst.max((scaled - (scaled - n.dot(&u)).max(0.0)).abs());
            continue;
        }
        let slip = u - n * n.dot(&u);
        let scaled = impulse * inverse_mass;
        let wanted = scaled - u - n * (contact.friction * slip.norm());
        worst = worst.max((scaled - on_cone(wanted, n, contact.friction)).norm());
    }
    for ((joint, arms), bias) in problem.joints.iter().zip(&problem.joint_arms).zip(&problem.bias.joints) {
        worst = worst.max((between(&own, &joint.bodies, arms) + bias).norm());
    }
    worst
}

fn on_cone(vector: V, n: V, friction: f64) -> V {
    let along = n.dot(&vector);
    let across = vector - along * n;
    let width = across.norm();
    if width <= friction * along {
        vector
    } else if friction * width <= -along {
        V::zeros()
    } else {
        (along + friction * width) / (1.0 + friction * friction) * (n + friction * across / width)
    }
}

/// Σ of the impulses' parts along an axis over contacts of this body B with this A.
fn carried(problem: &Problem, impulses: &PerPoint, a: Option<u32>, b: Option<u32>, axis: V) -> f64 {
    let of_pair = problem.contacts.iter().zip(&impulses.contacts).filter(|(contact, _)| contact.bodies == [a, b]);
    of_pair.map(|(_, impulse)| impulse.dot(&axis)).sum()
}

#[test]
fn in_a_column_each_face_carries_the_weight_above() {
    for (count, friction) in [(30, 0.6), (100, 0.6), (100, 0.0)] {
        let problem = column(count, friction);
        let (velocities, impulses) = converged(&problem);
        for level in 0..count {
            let below = level.checked_sub(1).map(|below| below as u32);
            let sum = carried(&problem, &impulses, below, Some(level as u32), V::y());
            let weight = (count - level) as f64 * 1000.0 * GRAVITY * STEP;
            assert!((sum - weight).abs() < 1e-6 * weight, "{count}, {level}: {sum}, not {weight}");
        }
        assert!(velocities.iter().all(|[linear, angular]| linear.norm() + angular.norm() < 1e-8));
    }
}

#[test]
fn a_million_to_one_is_carried() {
    let problem = sandwich(1e6);
    let (_, impulses) = converged(&problem);
    let half = (0.5e6 + 1.0) * GRAVITY * STEP;
    for cube in 0..2 {
        let sum = carried(&problem, &impulses, None, Some(cube), V::y());
        assert!((sum - half).abs() < 1e-6 * half, "{sum}, not {half}");
    }
}

#[test]
fn walls_and_arches_stand() {
    let still = [wall(10, false), wall(10, true), wall(20, true), arch(15, 0.6), arch(15, 1.0), chain(30)];
    for (index, problem) in still.iter().enumerate() {
        let (velocities, impulses) = converged(problem);
        let fastest = velocities.iter().map(|[linear, angular]| linear.norm() + angular.norm()).fold(0.0, f64::max);
        assert!(fastest < 1e-8, "{index}: {fastest:e}");
        let ground: f64 = problem.contacts.iter().zip(&impulses.contacts).fold(0.0, |sum, (contact, impulse)| {
            let sign =
                f64::from(u8::from(contact.bodies[0].is_none())) - f64::from(u8::from(contact.bodies[1].is_none()));
            sum + sign * impulse.y
        });
        let mass: f64 = problem.bodies.iter().map(|body| 1.0 / body.inverse_mass.y).sum();
        let off = (ground / mass - GRAVITY * STEP).abs();
        assert!(off < 10.0 * TOLERANCE, "{index}: {off:e} m/s");
    }
}

#[test]
fn a_slope_holds_to_the_tangent_and_no_further() {
    for change in [-1e-3, -1e-6, 1e-6, 1e-3] {
        let (tangent, friction) = (0.5, 0.5 * (1.0 + change));
        let ([linear, angular], _) = {
            let (velocities, impulses) = converged(&incline(tangent, friction));
            (velocities[0], impulses)
        };
        let angle = f64::atan(tangent);
        let expected = (GRAVITY * STEP * (angle.sin() - friction * angle.cos())).max(0.0);
        assert!((linear - V::x() * expected).norm() < 1e-9, "{change}: {linear:?}, not {expected:e}");
        assert!(angular.norm() < 1e-9, "{change}");
    }
}

#[test]
fn balls_roll_on_a_slab_that_is_pushed_away() {
    for heading in [0.0_f64, 60.0] {
        let problem = rolling(heading.to_radians());
        let (velocities, _) = converged(&problem);
        let slab = (150.0 - 0.4 * 35.0 * GRAVITY) / (10.0 + 25.0 * 2.0 / 7.0) * STEP;
        let along = V::new(heading.to_radians().cos(), 0.0, heading.to_radians().sin());
        assert!((velocities[0][0] - slab * along).norm() < 1e-9, "{heading}: {:?}", velocities[0]);
        for [ball, _] in &velocities[1..] {
            assert!((ball - slab * along * (2.0 / 7.0)).norm() < 1e-9, "{heading}: {ball:?}");
        }
    }
}

#[test]
fn sliding_columns_and_shaken_structures_converge_in_a_bounded_number_of_steps() {
    let mut sliding = column(30, 0.6);
    sliding.free.iter_mut().for_each(|[linear, _]| *linear += V::new(1.0, 0.0, 0.3));
    let moving = [
        sliding,
        column(30, 0.6).shaken(0.3, 1),
        column(100, 0.0).shaken(0.3, 3),
        wall(10, true).shaken(0.5, 10),
        arch(15, 0.1),
        arch(15, 0.6).shaken(1.0, 3),
        card_house(3, 0.6),
        card_house(3, 0.6).shaken(0.3, 3),
        chain(30).shaken(0.5, 3),
    ];
    for (index, problem) in moving.iter().enumerate() {
        let (_, _, outcome) = solved(problem);
        assert_eq!(outcome.end, ConeEnd::Converged, "{index}: {outcome:?}");
        assert!(outcome.steps < 300, "{index}: {outcome:?}");
    }
}

#[test]
fn piles_with_and_without_friction_and_of_unlike_masses_converge() {
    for seed in [0, 2, 3] {
        let mixed = |random: f64| if random < 0.3 { 0.0 } else { random };
        for problem in [pile(3, |_| 0.6, 1.0, seed), pile(3, mixed, 1.0, seed), pile(3, |_| 0.0, 10.0, seed)] {
            converged(&problem);
        }
    }
}

#[test]
fn a_solution_is_found_again_at_once_and_a_near_one_in_less_than_half() {
    let problem = column(30, 0.6).shaken(0.3, 1);
    let (mut solver, mut impulses) = (ConeSolver::default(), problem.no_impulses());
    let (_, cold) = problem.solve(&mut solver, &mut impulses);
    let (_, again) = problem.solve(&mut solver, &mut impulses);
    assert_eq!((again.end, again.steps), (ConeEnd::Converged, 0), "{again:?}");
    let near = column(30, 0.6).shaken(0.3001, 1);
    let (_, warm) = near.solve(&mut solver, &mut impulses);
    assert_eq!(warm.end, ConeEnd::Converged);
    assert!(2 * warm.steps <= cold.steps, "{warm:?}, cold {cold:?}");
}

#[test]
fn the_law_is_coulombs_and_not_the_associated_one() {
    // A ball without spin thrown flat: the quadratic program's would take off with μ|u_t|.
    let mut problem = Problem::default();
    let ball = problem.ball(V::new(0.0, 0.5, 0.0), 2.0, 0.5);
    problem.contact(None, Some(ball), V::zeros(), V::y(), 0.3);
    problem.free[0][0] += V::new(5.0, 0.0, 0.0);
    let (velocities, impulses) = converged(&problem);
    let gained = GRAVITY * STEP;
    assert!((impulses.contacts[0] - V::new(-0.3 * 2.0 * gained, 2.0 * gained, 0.0)).norm() < 1e-9);
    assert!((velocities[0][0] - V::new(5.0 - 0.3 * gained, 0.0, 0.0)).norm() < 1e-9);
}

#[test]
fn a_bias_is_reached_and_an_immovable_side_drags_along() {
    let mut problem = Problem::default();
    let ball = problem.ball(V::new(0.0, 0.5, 0.0), 2.0, 0.5);
    problem.contact(None, Some(ball), V::zeros(), V::y(), 10.0);
    // The ground runs at 3 m/s along x and rises at 1 m/s; the ball is to leave it at 2 m/s.
    problem.bias.contacts[0] = -V::new(3.0, 1.0, 0.0) - V::new(0.0, 2.0, 0.0);
    let (velocities, _) = converged(&problem);
    let [linear, angular] = velocities[0];
    assert!((linear.y - 3.0).abs() < 1e-9);
    let surface = linear + angular.cross(&V::new(0.0, -0.5, 0.0));
    assert!((surface.x - 3.0).abs() < 1e-9 && surface.z.abs() < 1e-9, "{surface:?}");
}

#[test]
fn locked_axes_do_not_move() {
    let mut problem = column(5, 0.6).shaken(0.3, 8);
    for (body, free) in problem.bodies.iter_mut().zip(&mut problem.free) {
        body.inverse_mass.z = 0.0;
        body.inverse_inertia = nalgebra::Matrix3::from_diagonal(&V::new(0.0, 0.0, body.inverse_inertia.m33));
        free[0].z = 0.0;
        free[1] = V::new(0.0, 0.0, free[1].z);
    }
    let (velocities, _) = converged(&problem);
    for [linear, angular] in velocities {
        assert!(linear.z == 0.0 && angular.x == 0.0 && angular.y == 0.0);
    }
}

/// Planar problems: bodies locked to the plane z = 0, so that a contact is open, sticks, or slips one way or the other.
#[test]
fn small_planar_problems_have_a_solution_that_enumeration_finds_too() {
    let mut random = Random::new(5);
    let mut compared = 0;
    for trial in 0..60 {
        let mut problem = Problem::default();
        let bodies = 1 + trial % 2;
        for body in 0..bodies {
            let place = V::new(f64::from(body), 0.5, 0.0);
            let one = problem.cuboid(place, 0.5 + random.unit(), V::repeat(1.0), nalgebra::UnitQuaternion::identity());
            let of = &mut problem.bodies[one as usize];
            of.inverse_mass.z = 0.0;
            of.inverse_inertia = nalgebra::Matrix3::from_diagonal(&V::new(0.0, 0.0, of.inverse_inertia.m33));
            let mut flat = random.vector();
            flat.z = 0.0;
            problem.free[one as usize] = [flat - V::y(), V::z() * random.unit()];
            let x = place.x - 0.5 + random.unit();
            problem.contact(None, Some(one), V::new(x, 0.0, 0.0), V::y(), 0.2 + random.unit());
        }
        if bodies == 2 {
            problem.contact(Some(0), Some(1), V::new(0.5, random.unit(), 0.0), V::x(), 0.2 + random.unit());
        } else {
            problem.contact(None, Some(0), V::new(-0.5, random.unit(), 0.0), V::x(), 0.2 + random.unit());
        }
        let (velocities, _) = converged(&problem);
        let all = enumerated(&problem);
        assert!(!all.is_empty(), "{trial}: no mode holds");
        let nearest = all.iter().map(|other| apart(other, &velocities)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-7, "{trial}: {nearest:e} from the nearest of {}", all.len());
        compared += 1;
    }
    assert_eq!(compared, 60);
}

fn apart(a: &[Velocity], b: &[Velocity]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).norm() + (a[1] - b[1]).norm()).sum()
}

/// The motions of all modes of a planar problem whose conditions hold.
fn enumerated(problem: &Problem) -> Vec<Vec<Velocity>> {
    let count = problem.contacts.len();
    let axes: Vec<[V; 2]> =
        problem.contacts.iter().map(|contact| [contact.normal, V::z().cross(&contact.normal)]).collect();
    let velocity = |motions: &[Velocity], index: usize, axis: usize| {
        let contact = &problem.contacts[index];
        (between(motions, &contact.bodies, &contact.arms) + problem.bias.contacts[index]).dot(&axes[index][axis])
    };
    let motion_of = |lambda: &DVector<f64>| {
        let mut impulses = problem.no_impulses();
        for index in 0..count {
            impulses.contacts[index] = axes[index][0] * lambda[2 * index] + axes[index][1] * lambda[2 * index + 1];
        }
        moved(problem, &impulses)
    };
    let at_rest = motion_of(&DVector::zeros(2 * count));
    let free = DVector::from_fn(2 * count, |row, _| velocity(&at_rest, row / 2, row % 2));
    let delassus = DMatrix::from_fn(2 * count, 2 * count, |row, column| {
        let mut unit = DVector::zeros(2 * count);
        unit[column] = 1.0;
        velocity(&motion_of(&unit), row / 2, row % 2) - free[row]
    });
    let mut found = Vec::new();
    for modes in 0..4_usize.pow(count as u32) {
        let mode = |index: usize| modes / 4_usize.pow(index as u32) % 4;
        let (mut matrix, mut right) = (DMatrix::zeros(2 * count, 2 * count), DVector::zeros(2 * count));
        for index in 0..count {
            let (n, t) = (2 * index, 2 * index + 1);
            let friction = problem.contacts[index].friction;
            for (row, is_velocity) in [(n, mode(index) > 0), (t, mode(index) == 1)] {
                if is_velocity {
                    matrix.set_row(row, &delassus.row(row));
                    right[row] = -free[row];
                } else {
                    matrix[(row, row)] = 1.0;
                }
            }
            match mode(index) {
                2 => matrix[(t, n)] = -friction,
                3 => matrix[(t, n)] = friction,
                _ => {}
            }
        }
        let Some(lambda) = matrix.lu().solve(&right) else { continue };
        let u = &delassus * &lambda + &free;
        let near = 1e-9;
        let holds = (0..count).all(|index| {
            let (n, t, friction) = (2 * index, 2 * index + 1, problem.contacts[index].friction);
            match mode(index) {
                0 => u[n] >= -near,
                1 => lambda[n] >= -near && lambda[t].abs() <= friction * lambda[n] + near,
                2 => lambda[n] >= -near && u[t] <= near,
                _ => lambda[n] >= -near && u[t] >= -near,
            }
        });
        if holds {
            found.push(motion_of(&lambda));
        }
    }
    found
}

#[test]
fn joints_alone_are_what_the_dense_system_gives() {
    let mut problem = chain(12).shaken(0.5, 2);
    problem.contacts.clear();
    problem.bias.contacts.clear();
    problem.joint(None, Some(0), V::new(0.0, 0.1, 0.0));
    // Redundant: the same point once more.
    problem.joint(None, Some(0), V::new(0.0, 0.1, 0.0));
    let (velocities, _) = converged(&problem);
    let rows = 3 * problem.joints.len();
    let velocity = |motions: &[Velocity], row: usize| {
        let joint = &problem.joints[row / 3];
        between(motions, &joint.bodies, &problem.joint_arms[row / 3])[row % 3]
    };
    let motion_of = |lambda: &DVector<f64>| {
        let mut impulses = problem.no_impulses();
        for row in 0..rows {
            impulses.joints[row / 3][row % 3] = lambda[row];
        }
        moved(&problem, &impulses)
    };
    let free = DVector::from_fn(rows, |row, _| velocity(&problem.free, row));
    let delassus = DMatrix::from_fn(rows, rows, |row, column| {
        let mut unit = DVector::zeros(rows);
        unit[column] = 1.0;
        velocity(&motion_of(&unit), row) - free[row]
    });
    let lambda = delassus.svd(true, true).solve(&-&free, 1e-10).expect("a least-squares solution");
    assert!(apart(&motion_of(&lambda), &velocities) < 1e-8);
}

/// A light body that turns easily, on a slider 30 m out from a heavy one that lands. The rotations that the slider holds keep the
/// light one from turning about the lever, which mobilities of points alone do not tell.
#[test]
fn a_slider_that_is_far_out_bears_an_impact() {
    let body = |mass: f64, inertia: f64| ConeBody {
        inverse_mass: V::repeat(1.0 / mass),
        inverse_inertia: Matrix3::from_diagonal_element(1.0 / inertia),
    };
    let bodies = [body(20.0, 0.2), body(2_000.0, 100.0)];
    let arms = [V::new(30.0, 0.0, 0.0), V::zeros()];
    let mut slider = ConeJoint::ball([Some(0), Some(1)], &arms);
    slider.jacobians.iter_mut().for_each(|jacobian| jacobian.row_mut(0).fill(0.0));
    let mut straight = ConeJoint::ball([Some(0), Some(1)], &[V::zeros(); 2]);
    for (jacobian, sign) in straight.jacobians.iter_mut().zip([-1.0, 1.0]) {
        jacobian.fill(0.0);
        jacobian.fixed_columns_mut::<3>(3).fill_diagonal(sign);
    }
    let foot = [V::zeros(), V::new(0.2, -0.5, 0.1)];
    let contact = ConeContact { bodies: [None, Some(1)], arms: foot, normal: V::y(), friction: 0.0 };
    let mut solver = ConeSolver::default();
    solver.set(&bodies, &[contact], &[slider, straight]);
    let mut velocities = vec![[V::new(0.0, -0.5, 0.0), V::zeros()]; 2];
    let bias = PerPoint { contacts: vec![V::zeros()], joints: vec![V::zeros(); 2] };
    let outcome = solver.solve(&mut velocities, &bias, &mut bias.clone(), 1e-10, 0.0);
    assert_eq!(outcome.end, ConeEnd::Converged, "{outcome:?}");
    assert!(outcome.steps <= 8, "{outcome:?}");
    let lands = between(&velocities, &contact.bodies, &foot).y;
    let parts = between(&velocities, &slider.bodies, &arms).yz().norm();
    let turns = (velocities[1][1] - velocities[0][1]).norm();
    assert!(lands.abs().max(parts).max(turns) < 1e-8, "{lands:e}, {parts:e}, {turns:e}");
}

#[test]
fn a_rod_that_digs_in_is_solved_and_stays_finite() {
    for friction in [0.5, 1.3, 1.4, 3.0, 10.0] {
        let problem = painleve(friction);
        let (velocities, _) = converged(&problem);
        let energy = |motion: &Velocity, free: &Velocity| {
            let inertia = problem.bodies[0].inverse_inertia.try_inverse().expect("a rod that turns");
            motion[0].norm_squared() - free[0].norm_squared() + motion[1].dot(&(inertia * motion[1]))
        };
        assert!(energy(&velocities[0], &problem.free[0]) <= 1e-9, "{friction}");
    }
}

#[test]
fn each_proximal_point_of_a_slipping_point_takes_one_iteration() {
    let (_, _, outcome) = solved(&painleve(0.5));
    assert!(outcome.end == ConeEnd::Converged && outcome.steps <= 4, "{outcome:?}");
    assert_eq!(outcome.steps, outcome.stages);
}

#[test]
fn what_has_no_solution_is_said_and_ends() {
    // A ball between two walls that close in on it.
    for friction in [0.0, 0.5] {
        let mut problem = Problem::default();
        let ball = problem.ball(V::zeros(), 1.0, 0.5);
        problem.contact(None, Some(ball), V::new(-0.5, 0.0, 0.0), V::x(), friction);
        problem.contact(None, Some(ball), V::new(0.5, 0.0, 0.0), -V::x(), friction);
        problem.bias.contacts = vec![V::new(-1.0, 0.0, 0.0), V::new(1.0, 0.0, 0.0)];
        let (velocities, impulses, outcome) = solved(&problem);
        assert_eq!(outcome.end, ConeEnd::NoRigidSolution, "{friction}: {outcome:?}");
        assert!(outcome.steps < 500 && outcome.residual >= 0.5);
        assert!(largest(&impulses).is_finite() && velocities[0][0].norm() < 10.0);
    }
    // Two joints at one point that want two velocities: the residual is what least squares leave.
    let mut problem = chain(3);
    problem.joint(None, Some(0), V::new(0.0, 0.1, 0.0));
    problem.joint(None, Some(0), V::new(0.0, 0.1, 0.0));
    *problem.bias.joints.last_mut().expect("a joint") = V::new(0.0, 0.0, 1e-3);
    let (_, impulses, outcome) = solved(&problem);
    assert!(outcome.end != ConeEnd::Converged && outcome.steps < 500, "{outcome:?}");
    assert!(outcome.residual < 1.1e-3 && largest(&impulses) < 1e6, "{outcome:?}");
}

#[test]
fn what_cannot_move_and_what_is_not_there_are_no_trouble() {
    let (_, _, outcome) = solved(&Problem::default());
    assert_eq!((outcome.end, outcome.steps), (ConeEnd::Converged, 0));
    let mut problem = column(2, 0.6);
    problem.bodies[0].inverse_mass = V::zeros();
    problem.bodies[0].inverse_inertia = nalgebra::Matrix3::zeros();
    problem.free[0] = [V::zeros(); 2];
    let (velocities, impulses) = converged(&problem);
    assert!(velocities[1][0].norm() < 1e-9);
    assert!(impulses.contacts[..4].iter().all(|impulse| *impulse == V::zeros()));
}

#[test]
fn the_same_problem_is_solved_to_the_same_bits() {
    let problem = wall(10, true).shaken(0.5, 4);
    let mut used = ConeSolver::default();
    column(3, 0.6).solve(&mut used, &mut column(3, 0.6).no_impulses());
    let (mut fresh, mut again) = (problem.no_impulses(), problem.no_impulses());
    let one = problem.solve(&mut ConeSolver::default(), &mut fresh);
    let other = problem.solve(&mut used, &mut again);
    assert!(one == other && fresh == again);
}
