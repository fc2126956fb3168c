//! Against dense solutions and rows written out one by one, on random graphs and patches.

use nalgebra::{Matrix3, SVector, UnitQuaternion, Vector3};

use super::contact::DirectContact;
use super::island::{energies, level};
use super::joint::{DirectJoint, SoftLaw};
use super::rows::{Correction, RowBlocks, Rows, Side, body_vector};
use crate::physics::collision::{ContactGeometry, ContactState};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::contact::tangents;
use crate::physics::lanes::Record;
use crate::physics::solver::linear::{BodyBlock as Block, BodyVector as Part};
use crate::physics::testing::Random;

/// A contact with points on A and B in their axes, and what is needed to look at it from outside.
struct Sample {
    rows: DirectContact,
    normal: Vector3<f64>,
    friction: [Vector3<f64>; 2],
    /// Points from A's centre and from B's.
    points: Vec<[Vector3<f64>; 2]>,
    middle: [Vector3<f64>; 2],
    radius: f64,
}

fn sample(random: &mut Random, impulses: [f32; 8]) -> Sample {
    sample_ahead(random, impulses, 0.0)
}

/// With a gap, m.
fn sample_ahead(random: &mut Random, impulses: [f32; 8], gap: f64) -> Sample {
    let turns: [UnitQuaternion<f64>; 2] = [random.rotation(), random.rotation()];
    let axes = turns.map(|turn| turn.to_rotation_matrix().into_inner());
    let apart = random.direction() * 1.5;
    let local_normal = random.direction();
    let local_tangent = tangents(&local_normal)[0];
    let on_a: Vec<Vector3<f64>> = (0..3).map(|_| random.vector()).collect();
    let points = on_a.iter().map(|&a| (a, axes[1].transpose() * (axes[0] * (a + local_normal * gap) - apart)));
    let geometry = ContactGeometry::new(&local_normal, &local_tangent, 0.7, 3, points);
    let state = ContactState { geometry, impulses: Record(impulses) };
    let mut rows = DirectContact::new(&state, &axes, &apart, [0.0, 1.0]);
    (rows.penalty, rows.per_step) = (1.0, 60.0);
    let normal = axes[0] * geometry.normal();
    let tangent = axes[0] * geometry.tangent();
    let points: Vec<[Vector3<f64>; 2]> = (0..3)
        .map(|index| {
            let (a, b) = geometry.point(index);
            let middle = (axes[0] * a + axes[1] * b + apart) * 0.5;
            [middle, middle - apart]
        })
        .collect();
    let middle = [0, 1].map(|side| points.iter().map(|point| point[side]).sum::<Vector3<f64>>() / 3.0);
    let radius = points.iter().map(|point| (point[0] - middle[0]).norm()).sum::<f64>() / 3.0;
    Sample { rows, normal, friction: [tangent, normal.cross(&tangent)], points, middle, radius }
}

/// The rows of a sample on (v_A, ω_A, v_B, ω_B), three points, two tangents and twist.
fn rows(sample: &Sample) -> Vec<SVector<f64, 12>> {
    let row = |direction: &Vector3<f64>, arms: &[Vector3<f64>; 2]| {
        let parts = [-direction, -arms[0].cross(direction), *direction, arms[1].cross(direction)];
        SVector::from_iterator(parts.iter().flat_map(|part| part.iter().copied()))
    };
    let points = sample.points.iter().map(|arms| row(&sample.normal, arms));
    let across = sample.friction.iter().map(|tangent| row(tangent, &sample.middle));
    let zero = Vector3::zeros();
    let spin = [zero, -sample.normal, zero, sample.normal];
    let twist = SVector::from_iterator(spin.iter().flat_map(|part| part.iter().copied())) * sample.radius;
    points.chain(across).chain([twist]).collect()
}

/// As bodies 0 and 1.
fn name(sides: &mut [Side; 2]) {
    for (side, body) in sides.iter_mut().zip(0..) {
        side.body = Some(body);
    }
}

fn blocks_of(rows: &impl Rows) -> RowBlocks {
    let mut blocks = RowBlocks::default();
    rows.blocks(&mut blocks);
    blocks
}

/// vᵀAv of what the rows between two bodies add to the matrix.
fn energy(blocks: &RowBlocks, v: &SVector<f64, 12>) -> f64 {
    let (of_a, of_b): (Part, Part) = (v.fixed_rows::<6>(0).into(), v.fixed_rows::<6>(6).into());
    let [own_a, own_b] = blocks.own;
    of_a.dot(&(own_a * of_a)) + of_b.dot(&(own_b * of_b)) + 2.0 * of_a.dot(&(blocks.across * of_b))
}

#[test]
fn the_stiffness_of_a_joint_is_that_of_its_rows() {
    let mut random = Random::new(8);
    for _ in 0..20 {
        let mut rows = DirectJoint { penalty: random.within(1.0, 5.0), ..DirectJoint::default() };
        name(&mut rows.sides);
        for side in &mut rows.sides {
            side.arm = random.vector();
        }
        let v = SVector::<f64, 12>::from_fn(|_, _| random.within(-1.0, 1.0));
        let of = |side: usize| rows.sides[side].motion(&v.fixed_rows::<6>(6 * side).into()).linear;
        let slip = of(1) - of(0);
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        close(energy(&blocks_of(&rows), &v), rows.penalty * slip.norm_squared());
        let stiffness = Matrix3::from_diagonal(&Vector3::new(2.0, 3.0, 4.0));
        rows.softness = Some(SoftLaw::new(stiffness, Vector3::zeros(), f64::INFINITY));
        close(energy(&blocks_of(&rows), &v), slip.dot(&(stiffness * slip)));
    }
}

#[test]
fn blocks_of_a_joint_are_made_anew_when_its_arms_move() {
    let mut rows = DirectJoint { penalty: 2.0, ..DirectJoint::default() };
    name(&mut rows.sides);
    let mut kept = RowBlocks::default();
    let mut made = 0;
    for arm in [0.5, 0.5, 0.6] {
        rows.sides[0].arm.x = arm;
        kept.update(&rows.key(), |blocks| {
            made += 1;
            rows.blocks(blocks);
        });
        assert_eq!(kept.own[0][(5, 1)], 2.0 * arm);
    }
    assert_eq!(made, 2, "not where they stayed");
}

#[test]
fn the_stiffness_of_a_contact_is_that_of_its_rows() {
    let mut random = Random::new(3);
    for _ in 0..20 {
        let mut sample = sample(&mut random, [1.0, 2.0, 0.5, 0.1, 0.0, 0.0, 0.0, 0.0]);
        let penalty = random.within(1.0, 5.0);
        sample.rows.penalty = penalty;
        name(&mut sample.rows.sides);
        let v = SVector::<f64, 12>::from_fn(|_, _| random.within(-1.0, 1.0));
        let energy = energy(&blocks_of(&sample.rows), &v);
        let expected: f64 = rows(&sample).iter().map(|row| penalty * row.dot(&v).powi(2)).sum();
        assert!((energy - expected).abs() < 1e-6 * expected, "{energy} instead of {expected}");
    }
}

#[test]
fn a_contact_that_bears_nothing_holds_nothing_back() {
    let mut random = Random::new(11);
    for _ in 0..20 {
        let mut sample = sample_ahead(&mut random, [0.0; 8], 0.2);
        name(&mut sample.rows.sides);
        for motion in [Twist::zero(), Twist { linear: random.vector(), angular: random.vector() }] {
            let v = SVector::<f64, 12>::from_fn(|_, _| random.within(-1.0, 1.0));
            assert_eq!(energy(&blocks_of(&sample.rows), &v), 0.0);
            assert_eq!(sample.rows.impulse_at_rest(), Wrench::zero());
            assert!(sample.rows.take(&motion, 1e-9), "nothing changes for what it bears");
        }
    }
}

#[test]
fn wrenches_and_motions_are_dual() {
    // The power of an impulse at the point is that of its wrench on the bodies.
    let mut random = Random::new(4);
    for _ in 0..20 {
        let side = Side { body: None, arm: random.vector() };
        let impulse = Wrench { linear: random.vector(), angular: random.vector() };
        let part = Part::from_fn(|_, _| random.within(-1.0, 1.0));
        let there = side.motion(&part);
        let error = (there.dot(&impulse) - part.dot(&side.wrench(&impulse))).abs();
        assert!(error < 1e-12, "{error}");
    }
}

#[test]
fn impulses_of_a_contact_are_bounded_by_the_cone() {
    let mut random = Random::new(5);
    for _ in 0..50 {
        let mut sample = sample(&mut random, [1.0, 2.0, 0.5, 0.3, -0.2, 0.1, 0.0, 0.0]);
        let moving = Twist { linear: random.vector() * 3.0, angular: random.vector() * 3.0 };
        sample.rows.take(&moving, 0.0);
        let Record([p, q, r, s, x, y, torsion, _]) = sample.rows.impulses(1.0);
        let load = p + q + r + s;
        assert!(p >= 0.0 && q >= 0.0 && r >= 0.0 && s == 0.0);
        assert!(x.hypot(y) <= 0.7 * load * 1.000_01, "slips with {} under {load}", x.hypot(y));
        assert!(torsion.abs() <= 0.7 * sample.radius as f32 * load * 1.000_01);
    }
}

#[test]
fn impulses_of_rows_fall_as_they_move() {
    // The gradient of a convex function: monotone. And where no row changes sides, it is what the stiffness says.
    let mut random = Random::new(6);
    let penalty = 3.0;
    for _ in 0..200 {
        let mut sample = sample(&mut random, [1.0, 2.0, 0.5, 0.3, -0.2, 0.1, 0.0, 0.0]);
        let mut moving = || Twist { linear: random.vector() * 0.5, angular: random.vector() * 0.5 };
        let (one, line) = (moving(), moving());
        sample.rows.penalty = penalty;
        sample.rows.take(&one, 0.0);
        let there = |share: f64| sample.rows.impulse_at(&one.plus(&line, share));
        assert!(line.dot(&there(1.0)) <= line.dot(&there(0.0)) + 1e-12);
        let (start, change) = (there(0.0), 1e-7);
        let stiffness = sample.rows.stiffness();
        let expected = stiffness.uu * line.linear + stiffness.uw * line.angular;
        let found = (start.linear - there(change).linear) / change;
        assert!((found - expected).norm() < 1e-4 * penalty, "{found} instead of {expected}");
        let expected = stiffness.uw.tr_mul(&line.linear) + stiffness.ww * line.angular;
        let found = (start.angular - there(change).angular) / change;
        assert!((found - expected).norm() < 1e-4 * penalty, "{found} instead of {expected}");
    }
}

#[test]
fn a_line_is_followed_to_where_it_is_level() {
    let bent = |share: f64| if share < 0.013 { share - 0.014 } else { 400.0 * (share - 0.013) - 0.001 };
    for (slope, expected) in [
        (&(|share: f64| share - 0.3) as &dyn Fn(f64) -> f64, 0.3),
        (&|share: f64| share.powi(5) - 0.1, 0.1_f64.powf(0.2)),
        (&bent, 0.013),
    ] {
        let found = level(8, slope);
        assert!((found - expected).abs() < 0.1, "{found} instead of {expected}");
        assert!(slope(found) < 0.1 * slope(1.0));
    }
    assert_eq!(level(8, |share| share - 2.0), 1.0, "all the way down");
}

#[test]
fn what_rows_do_not_take_is_gained() {
    // Two bodies that meet, one with spin: they may share their momentum, stop or turn on, not part faster.
    let bodies = [(2.0, Matrix3::from_diagonal(&Vector3::new(0.5, 1.0, 2.0))), (1.0, Matrix3::identity())];
    let at = |speeds: [f64; 2], spin: f64| {
        let spin = [Vector3::z() * spin, Vector3::zeros()];
        [0, 1].map(|body: usize| body_vector(&(Vector3::x() * speeds[body]), &spin[body]))
    };
    let free = at([1.0, -2.0], 3.0);
    let momenta = [0, 1].map(|body: usize| {
        let (mass, inertia) = bodies[body];
        let (linear, angular) = (free[body].fixed_rows::<3>(0) * mass, inertia * free[body].fixed_rows::<3>(3));
        body_vector(&linear, &angular)
    });
    for (after, expected) in [
        (free, false),
        (at([0.0, 0.0], 3.0), false),
        (at([-1.0, 2.0], 3.0), false),
        (at([-1.1, 2.2], 3.0), true),
        (at([0.0, 0.0], 3.5), true),
    ] {
        let placed = (0..2).map(|body| (&bodies[body], &after[body], &momenta[body]));
        let [kinetic, alone] = energies(placed);
        assert_eq!(kinetic > 1.001 * alone, expected, "{after:?}");
    }
}

#[test]
fn a_soft_joint_pulls_along_its_error_within_its_limit() {
    let stiffness = Matrix3::from_diagonal(&Vector3::new(2.0, 3.0, 4.0));
    let soft = SoftLaw::new(stiffness, Vector3::new(0.1, -0.2, 0.3), 1.0);
    let mut rows = DirectJoint { softness: Some(soft), ..DirectJoint::default() };
    let still = Twist::zero();
    assert!(rows.take(&still, 0.0) || rows.take(&still, 0.0), "it finds out whether it is at its limit");
    // −W b = (−0.2, 0.6, −1.2), whose norm is over the limit.
    let expected = Vector3::new(-0.2, 0.6, -1.2).normalize();
    assert!((rows.impulse - expected).norm() < 1e-12, "{}", rows.impulse);
    name(&mut rows.sides);
    assert_eq!(blocks_of(&rows).own[0], Block::zeros(), "it gives");
    let away = Twist { linear: Vector3::new(0.0, 0.0, -0.2), ..Twist::default() };
    rows.take(&away, 0.0);
    assert!(rows.take(&away, 0.0));
    assert!((rows.impulse - Vector3::new(-0.2, 0.6, -0.4)).norm() < 1e-12, "{}", rows.impulse);
    assert_eq!(blocks_of(&rows).own[0].fixed_view::<3, 3>(0, 0), stiffness);
}

#[test]
fn a_correction_takes_a_share_of_the_depth() {
    // Two cubes, the upper one 1 cm deep: all four corners ask for a tenth of it in a step.
    let corners = [(0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)];
    let points = corners.map(|(x, z)| (Vector3::new(x, 0.5, z), Vector3::new(x, -0.5, z)));
    let geometry = ContactGeometry::new(&Vector3::y(), &Vector3::x(), 0.5, 4, points.into_iter());
    let state = ContactState { geometry, impulses: Record([1.0; 8]) };
    let axes = [Matrix3::identity(); 2];
    let mut rows = DirectContact::new(&state, &axes, &Vector3::new(0.0, 0.99, 0.0), [0.0, 1.0]);
    rows.penalty = 1.0;
    let of = |speed: f64| rows.correction(&rows.key(), &Correction { rates: [0.1 * 60.0; 2], speeds: [speed; 2] });
    let impulse = of(1.0);
    assert!((impulse.linear - Vector3::y() * 4.0 * 0.01 * 0.1 * 60.0).norm() < 1e-3, "{:?}", impulse.linear);
    assert!(impulse.angular.norm() < 1e-6);
    assert!((of(0.01).linear.y - 0.04).abs() < 1e-6, "{}", of(0.01).linear.y);
}
