use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

use super::row::{BodyTerms, Bounds, RowPair, Twist};
use crate::physics::contact::{PointConstraint, penetration_bias, tangents};
use crate::physics::testing::Random;

/// A pose that a twist moves.
#[derive(Clone, Copy)]
struct Pose {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl Pose {
    fn random(random: &mut Random) -> Self {
        Self { position: random.vector() * 3.0, rotation: random.rotation() }
    }

    /// After moving with constant velocities for `time`.
    fn after(&self, twist: &Twist<f64>, time: f64) -> Self {
        Self {
            position: self.position + twist.linear * time,
            rotation: UnitQuaternion::from_scaled_axis(twist.angular * time) * self.rotation,
        }
    }

    fn point(&self, anchor: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * anchor
    }
}

fn random_twist(random: &mut Random) -> Twist<f64> {
    Twist { linear: random.vector() * 2.0, angular: random.vector() * 2.0 }
}

/// dC/dt by central differences along a motion of both bodies. The error is the third derivative
/// times the step squared: under 1e-9 here.
fn rate(constraint: impl Fn(&Pose, &Pose) -> f64, poses: &[Pose; 2], twists: &[Twist<f64>; 2]) -> f64 {
    const STEP: f64 = 1e-5;
    let at = |time| constraint(&poses[0].after(&twists[0], time), &poses[1].after(&twists[1], time));
    (at(STEP) - at(-STEP)) / (2.0 * STEP)
}

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

/// The site where two bodies meet at a world point.
fn site<'a>(
    terms: [&'a BodyTerms<f64>; 2],
    poses: &[Pose; 2],
    point: Vector3<f64>,
    normal: Vector3<f64>,
) -> PointConstraint<'a, f64> {
    PointConstraint {
        a: (0, terms[0]),
        b: (1, terms[1]),
        arm_a: point - poses[0].position,
        arm_b: point - poses[1].position,
        normal,
    }
}

#[test]
fn contact_row_is_the_gradient_of_the_distance_of_two_spheres() {
    let random = &mut Random::new(2);
    for _ in 0..200 {
        let poses = [Pose::random(random), Pose::random(random)];
        let twists = [random_twist(random), random_twist(random)];
        let terms = [random.body(), random.body()];
        let between = poses[1].position - poses[0].position;
        if between.norm() < 0.5 {
            continue; // too curved for the finite differences
        }
        let normal = between.normalize();
        let radius = random.within(0.2, 0.8) * between.norm();
        let site = site([&terms[0], &terms[1]], &poses, poses[0].position + normal * radius, normal);
        let row = site.normal_row(0.0, 0.01, f64::MAX);
        let distance = |a: &Pose, b: &Pose| (b.position - a.position).norm() - between.norm();
        assert_close(row.jacobian.dot(&twists[0], &twists[1]), rate(distance, &poses, &twists), 1e-7);
    }
}

#[test]
fn contact_row_is_the_gradient_of_a_corner_above_a_moving_plane() {
    let random = &mut Random::new(3);
    for _ in 0..200 {
        let poses = [Pose::random(random), Pose::random(random)];
        let twists = [random_twist(random), random_twist(random)];
        let terms = [random.body(), random.body()];
        let corner = random.vector();
        let normal = poses[0].rotation * Vector3::y();
        let site = site([&terms[0], &terms[1]], &poses, poses[1].point(&corner), normal);
        let row = site.normal_row(0.0, 0.01, f64::MAX);
        let height = |a: &Pose, b: &Pose| (a.rotation * Vector3::y()).dot(&(b.point(&corner) - a.position));
        assert_close(row.jacobian.dot(&twists[0], &twists[1]), rate(height, &poses, &twists), 1e-8);
    }
}

#[test]
fn friction_row_is_the_rate_at_which_touching_points_slip() {
    let random = &mut Random::new(4);
    for _ in 0..200 {
        let poses = [Pose::random(random), Pose::random(random)];
        let twists = [random_twist(random), random_twist(random)];
        let terms = [random.body(), random.body()];
        let (point, normal) = (random.vector(), random.direction());
        let site = site([&terms[0], &terms[1]], &poses, point, normal);
        let anchors = [0, 1].map(|body| poses[body].rotation.inverse() * (point - poses[body].position));
        for tangent in tangents(&normal) {
            let row = site.friction_row(tangent, 0.01, Bounds::Fixed(-1.0, 1.0));
            let slip = |a: &Pose, b: &Pose| tangent.dot(&(b.point(&anchors[1]) - a.point(&anchors[0])));
            assert_close(row.jacobian.dot(&twists[0], &twists[1]), rate(slip, &poses, &twists), 1e-8);
        }
    }
}

/// J as a dense row, M⁻¹ as a dense 12×12 matrix.
fn dense(pair: &RowPair<f64>, bodies: [&BodyTerms<f64>; 2]) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut jacobian = DMatrix::zeros(1, 12);
    let blocks = [pair.linear_a, pair.angular_a, pair.linear_b, pair.angular_b];
    for (block, values) in blocks.iter().enumerate() {
        jacobian.view_mut((0, 3 * block), (1, 3)).copy_from(&values.transpose());
    }
    let mut inverse_mass = DMatrix::zeros(12, 12);
    for (index, body) in bodies.iter().enumerate() {
        for axis in 0..3 {
            inverse_mass[(6 * index + axis, 6 * index + axis)] = body.inverse_mass[axis];
        }
        inverse_mass.view_mut((6 * index + 3, 6 * index + 3), (3, 3)).copy_from(&body.inverse_inertia);
    }
    (jacobian, inverse_mass)
}

#[test]
fn response_and_diagonal_are_the_dense_products() {
    let random = &mut Random::new(5);
    for _ in 0..100 {
        let (a, mut b) = (random.body(), random.body());
        b.inverse_mass.y = 0.0; // a locked axis
        let pair = RowPair::along(random.direction(), random.vector(), random.vector());
        let (jacobian, inverse_mass) = dense(&pair, [&a, &b]);
        let response = pair.response(&a, &b);
        let expected: DVector<f64> = (&inverse_mass * jacobian.transpose()).column(0).into();
        let blocks = [response.linear_a, response.angular_a, response.linear_b, response.angular_b];
        for (index, value) in blocks.iter().flatten().enumerate() {
            assert_close(*value, expected[index], 1e-12);
        }
        let diagonal = (&jacobian * &inverse_mass * jacobian.transpose())[(0, 0)];
        assert_close(pair.diagonal(&response), diagonal, 1e-12 * diagonal);
    }
}

#[test]
fn tangents_and_normal_are_a_right_handed_frame() {
    let random = &mut Random::new(6);
    let special = [Vector3::z(), -Vector3::z(), Vector3::y(), -Vector3::x()];
    for normal in special.into_iter().chain((0..500).map(|_| random.direction())) {
        let [first, second] = tangents(&normal);
        assert_close(first.norm(), 1.0, 1e-12);
        assert_close(first.dot(&normal), 0.0, 1e-12);
        assert_close((first.cross(&second) - normal).norm(), 0.0, 1e-12);
    }
}

#[test]
fn penetration_bias_follows_the_2009_engine_and_lets_gaps_close() {
    let bias = |depth| penetration_bias(depth, 0.01, 21.0, f64::INFINITY, 0.005);
    assert_close(bias(0.03), 0.42, 1e-15); // β(depth − slop)
    assert_close(bias(0.01), 0.0, 1e-15);
    assert_close(bias(0.004), -0.126, 1e-15); // not clamped at zero
    // A gap of 1 mm may close in the 5 ms of the step, and the slop be used besides.
    assert_close(bias(-0.001), -0.21 - 0.2, 1e-15);
    assert_eq!(penetration_bias(1.0, 0.01, 21.0, 3.0, 0.005), 3.0);
}
