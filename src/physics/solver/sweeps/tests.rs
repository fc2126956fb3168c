//! Projected Gauss–Seidel against dense solutions of the same rows.

mod gradients;
mod joint_space;

use nalgebra::{DMatrix, DVector, Matrix3, SimdRealField, SimdValue, Vector3};
use simba::simd::WideF32x8;

use super::pgs;
use crate::physics::constraint::row::{BodyTerms, Bounds, Row, RowPair, Spring, Twist};
use crate::physics::contact::{PointConstraint, tangents};
use crate::physics::joint::point_jacobian;
use crate::physics::testing::{Random, immovable};

const H: f64 = 1.0 / 60.0;

/// Bodies and the rows between them.
#[derive(Clone)]
struct Rows {
    bodies: Vec<BodyTerms<f64>>,
    rows: Vec<Row<f64>>,
}

impl Rows {
    /// The first body does not move.
    fn random(bodies: usize, random: &mut Random) -> Self {
        let bodies = std::iter::once(immovable()).chain((0..bodies).map(|_| random.body())).collect();
        Self { bodies, rows: Vec::new() }
    }

    fn with(&self, body: usize) -> (u32, &BodyTerms<f64>) {
        (body as u32, &self.bodies[body])
    }

    /// Three rows that hold a point of one body at a point of another.
    fn join(&mut self, a: usize, b: usize, random: &mut Random) {
        for pair in point_jacobian(random.vector(), random.vector()) {
            let unbounded = Bounds::Fixed(f64::MIN, f64::MAX);
            let row = Row::rigid(self.with(a), self.with(b), pair, random.within(-1.0, 1.0), H, unbounded);
            self.rows.push(row);
        }
    }

    /// A normal row, then friction rows with the bounds that `friction` gives by their distance
    /// from it.
    fn touch(&mut self, a: usize, b: usize, friction: &[fn(u32) -> Bounds<f64>], random: &mut Random) {
        let site = PointConstraint {
            a: self.with(a),
            b: self.with(b),
            arm_a: random.vector(),
            arm_b: random.vector(),
            normal: random.direction(),
        };
        let mut rows = vec![site.normal_row(random.within(-1.0, 1.0), H, f64::MAX)];
        for ((back, tangent), bounds) in (1..).zip(tangents(&site.normal)).zip(friction) {
            rows.push(site.friction_row(tangent, H, bounds(back)));
        }
        self.rows.append(&mut rows);
    }

    /// J as a dense matrix of one row per constraint and M⁻¹ of all bodies.
    fn dense(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let width = 6 * self.bodies.len();
        let mut jacobian = DMatrix::zeros(self.rows.len(), width);
        for (index, row) in self.rows.iter().enumerate() {
            let RowPair { linear_a, angular_a, linear_b, angular_b } = row.jacobian;
            let (a, b) = (6 * row.a as usize, 6 * row.b as usize);
            for (column, block) in [(a, linear_a), (a + 3, angular_a), (b, linear_b), (b + 3, angular_b)] {
                jacobian.view_mut((index, column), (1, 3)).copy_from(&block.transpose());
            }
        }
        let mut inverse_mass = DMatrix::zeros(width, width);
        for (index, body) in self.bodies.iter().enumerate() {
            let at = 6 * index;
            inverse_mass.view_mut((at, at), (3, 3)).copy_from(&Matrix3::from_diagonal(&body.inverse_mass));
            inverse_mass.view_mut((at + 3, at + 3), (3, 3)).copy_from(&body.inverse_inertia);
        }
        (jacobian, inverse_mass)
    }

    /// J M⁻¹ Jᵀ + Γ.
    fn matrix(&self) -> DMatrix<f64> {
        let (jacobian, inverse_mass) = self.dense();
        let softness = DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.softness));
        &jacobian * inverse_mass * jacobian.transpose() + DMatrix::from_diagonal(&softness)
    }

    fn targets(&self) -> DVector<f64> {
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.target))
    }

    /// M⁻¹Jᵀλ, six numbers a body.
    fn accelerations(&self, lambda: &DVector<f64>) -> DVector<f64> {
        let (jacobian, inverse_mass) = self.dense();
        inverse_mass * jacobian.transpose() * lambda
    }

    /// Sweeps until nothing changes any more; λ and M⁻¹Jᵀλ as the solver kept it.
    fn solve_by_sweeping(&mut self) -> (DVector<f64>, DVector<f64>) {
        let mut accelerations = vec![Twist::zero(); self.bodies.len()];
        pgs::solve(&mut self.rows, &mut accelerations, 20_000, |_| ());
        let lambda = DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.lambda));
        (lambda, flat(&accelerations))
    }
}

/// Six numbers a body.
fn flat(twists: &[Twist<f64>]) -> DVector<f64> {
    let vectors = twists.iter().flat_map(|twist| [twist.linear, twist.angular]);
    DVector::from_vec(vectors.flat_map(|vector: Vector3<f64>| vector.data.0[0]).collect())
}

/// Solves A λ + w = b with w complementary to the bounds by trying which rows sit at which bound:
/// 3ⁿ linear systems. A is positive semidefinite, so M⁻¹Jᵀλ is unique where λ is not.
fn solve_by_enumeration(matrix: &DMatrix<f64>, targets: &DVector<f64>, bounds: &[(f64, f64)]) -> DVector<f64> {
    const SLACK: f64 = 1e-9;
    let rows = targets.len();
    for mut code in 0..3_usize.pow(rows as u32) {
        let mut lambda = DVector::zeros(rows);
        let mut free = Vec::new();
        let mut possible = true;
        for (row, &(lower, upper)) in bounds.iter().enumerate() {
            match code % 3 {
                0 => free.push(row),
                1 => lambda[row] = lower,
                _ => lambda[row] = upper,
            }
            possible &= lambda[row].abs() < f64::MAX;
            code /= 3;
        }
        if !possible {
            continue;
        }
        let rest = targets - matrix * &lambda;
        if !free.is_empty() {
            let part = matrix.select_rows(&free).select_columns(&free);
            let Some(solution) = part.lu().solve(&rest.select_rows(&free)) else { continue };
            for (&row, &value) in free.iter().zip(solution.iter()) {
                lambda[row] = value;
            }
        }
        let missing = targets - matrix * &lambda;
        let holds = bounds.iter().enumerate().all(|(row, &(lower, upper))| {
            let inside = lambda[row] >= lower - SLACK && lambda[row] <= upper + SLACK;
            let pushes_up = missing[row] <= SLACK || lambda[row] >= upper - SLACK;
            let pushes_down = missing[row] >= -SLACK || lambda[row] <= lower + SLACK;
            inside && pushes_up && pushes_down
        });
        if holds {
            return lambda;
        }
    }
    panic!("no choice of active bounds solves the system");
}

fn assert_close(value: &DVector<f64>, expected: &DVector<f64>, tolerance: f64) {
    let error = (value - expected).amax();
    assert!(error <= tolerance * expected.amax().max(1.0), "off by {error}: {value} instead of {expected}");
}

#[test]
fn joints_alone_solve_the_linear_system() {
    let random = &mut Random::new(11);
    for _ in 0..20 {
        let mut system = Rows::random(3, random);
        for body in 0..3 {
            system.join(body, body + 1, random);
        }
        let exact = system.matrix().lu().solve(&system.targets()).expect("a chain has independent rows");
        let (lambda, accelerations) = system.solve_by_sweeping();
        assert_close(&lambda, &exact, 1e-6);
        assert_close(&accelerations, &system.accelerations(&exact), 1e-6);
    }
}

#[test]
fn contacts_with_fixed_friction_solve_the_boxed_complementarity_problem() {
    let random = &mut Random::new(12);
    let mut at_bounds = [0; 3];
    for _ in 0..15 {
        let mut system = Rows::random(2, random);
        let friction: [fn(u32) -> Bounds<f64>; 1] = [|_| Bounds::Fixed(-3.0, 3.0)];
        for (a, b) in [(0, 1), (1, 2), (0, 2), (0, 1)] {
            system.touch(a, b, &friction, random);
        }
        let bounds: Vec<(f64, f64)> = system
            .rows
            .iter()
            .map(|row| match row.bounds {
                Bounds::Fixed(lower, upper) => (lower, upper),
                Bounds::Friction { .. } | Bounds::Norm { .. } => unreachable!("all bounds here are fixed"),
            })
            .collect();
        let exact = solve_by_enumeration(&system.matrix(), &system.targets(), &bounds);
        let (lambda, accelerations) = system.solve_by_sweeping();
        assert_close(&accelerations, &system.accelerations(&exact), 1e-6);
        for (&value, (lower, upper)) in lambda.iter().zip(bounds) {
            at_bounds[if value <= lower { 0 } else { 1 + usize::from(value >= upper) }] += 1;
        }
    }
    assert!(at_bounds.iter().all(|&count| count > 10), "one-sided cases prove little: {at_bounds:?}");
}

#[test]
fn friction_under_its_own_normal_force_ends_at_a_fixed_point_of_coulombs_law() {
    const FRICTION: f64 = 0.4;
    let random = &mut Random::new(13);
    let (mut sticking, mut sliding, mut apart) = (0, 0, 0);
    for _ in 0..20 {
        let mut system = Rows::random(3, random);
        let bound: fn(u32) -> Bounds<f64> = |back| Bounds::Friction { coefficient: FRICTION, normal_rows_back: back };
        for (a, b) in [(0, 1), (1, 2), (2, 3), (0, 3)] {
            system.touch(a, b, &[bound, bound], random);
        }
        system.join(1, 3, random);
        let (lambda, accelerations) = system.solve_by_sweeping();
        assert_close(&accelerations, &system.accelerations(&lambda), 1e-9);
        let missing = system.targets() - system.matrix() * &lambda;
        for contact in 0..4 {
            let normal = 3 * contact;
            assert!(lambda[normal] >= 0.0 && missing[normal] <= 1e-6, "pulls or sinks");
            assert!(lambda[normal] * missing[normal].abs() < 1e-5, "pushes although apart");
            apart += usize::from(lambda[normal] == 0.0);
            for row in [normal + 1, normal + 2] {
                let limit = FRICTION * lambda[normal];
                assert!(lambda[row].abs() <= limit + 1e-9, "{} over {limit}", lambda[row]);
                let is_sliding = lambda[row].abs() >= limit - 1e-9;
                assert!(is_sliding || missing[row].abs() < 1e-6, "slips within its bound: {}", missing[row]);
                assert!(missing[row] * lambda[row] >= -1e-5, "friction pushes along the slip");
                if limit > 0.0 {
                    *(if is_sliding { &mut sliding } else { &mut sticking }) += 1;
                }
            }
        }
    }
    assert!(sticking > 20 && sliding > 20 && apart > 20, "{sticking} stick, {sliding} slide, {apart} apart");
}

#[test]
fn soft_row_is_the_implicit_euler_step_of_a_damped_spring() {
    let (mass, gravity) = (2.5, -9.81);
    let (stiffness, damping) = (400.0, 6.0); // ω² and 2ζω
    let row_of = |position: f64, velocity: f64, limit: f64| {
        let body = BodyTerms {
            inverse_mass: Vector3::repeat(1.0 / mass),
            inverse_inertia: Matrix3::identity(),
            free: Twist { linear: Vector3::y() * (velocity / H + gravity), angular: Vector3::zeros() },
        };
        let pair = RowPair::along(Vector3::y(), Vector3::zeros(), Vector3::zeros());
        let spring = Spring { stiffness, damping, error: position };
        let mut rows = [Row::soft((0, &immovable()), (1, &body), pair, spring, H, Bounds::Fixed(-limit, limit))];
        let mut accelerations = [Twist::zero(); 2];
        pgs::solve(&mut rows, &mut accelerations, 1, |_| ());
        (rows[0].lambda, accelerations[1].linear.y)
    };
    let (mut position, mut velocity): (f64, f64) = (0.3, -1.0);
    for _ in 0..200 {
        // v' = v + h(g − ω²x' − 2ζω v') with x' = x + h v'.
        let expected = (velocity + H * gravity - H * stiffness * position) / (1.0 + H * damping + H * H * stiffness);
        let (_, acceleration) = row_of(position, velocity, f64::MAX);
        velocity += H * (gravity + acceleration);
        assert!((velocity - expected).abs() < 1e-12, "{velocity} instead of {expected}");
        position += H * velocity;
    }
    // 200 steps of damping time 1/3 s: at rest where the spring carries the weight.
    assert!((position - gravity / stiffness).abs() < 1e-4, "{position}");
    assert_eq!(row_of(5.0, 0.0, 7.0).0, -7.0, "a bounded spring pulls no harder than its bound");
}

/// A spring between points beside the centres of two bodies, whose axes feel each other: in the end its force is
/// (η − J a)/γ, what it asks for, or that scaled to the bound. Near the bound as far beyond it.
#[test]
fn a_spring_at_the_bound_of_its_norm_pulls_along_what_it_asks_for() {
    let random = &mut Random::new(31);
    let mut at_bound = 0;
    for _ in 0..200 {
        let mut system = Rows::random(2, random);
        let error = random.vector();
        let far = 10.0_f64.powf(random.within(-3.0, 2.0));
        for (place, pair) in (0..).zip(point_jacobian(random.vector(), random.vector())) {
            let spring = Spring { stiffness: 900.0, damping: 20.0, error: error[place as usize] * far };
            let bounds = Bounds::Norm { most: 5.0, place, count: 3 };
            system.rows.push(Row::soft(system.with(1), system.with(2), pair, spring, H, bounds));
        }
        let (lambda, accelerations) = system.solve_by_sweeping();
        let lambda = Vector3::new(lambda[0], lambda[1], lambda[2]);
        let pulled = system.dense().0 * accelerations;
        let asked = Vector3::from_fn(|place, _| {
            let row = &system.rows[place];
            (row.target - pulled[place]) / row.softness
        });
        let expected = asked * (5.0 / asked.norm()).min(1.0);
        assert!((lambda - expected).norm() < 1e-9, "{lambda} instead of {expected}");
        at_bound += usize::from(asked.norm() > 5.0);
    }
    assert!((40..160).contains(&at_bound), "{at_bound} of 200 at their bounds");
}

/// With conjugate directions it ends where sweeps do.
#[test]
fn conjugate_directions_bound_the_norm_as_sweeps_do() {
    let random = &mut Random::new(32);
    for _ in 0..50 {
        let mut system = Rows::random(3, random);
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let error = random.vector() * 10.0_f64.powf(random.within(-2.0, 2.0));
            for (place, pair) in (0..).zip(point_jacobian(random.vector(), random.vector())) {
                let spring = Spring { stiffness: 900.0, damping: 20.0, error: error[place as usize] };
                let bounds = Bounds::Norm { most: 5.0, place, count: 3 };
                system.rows.push(Row::soft(system.with(a), system.with(b), pair, spring, H, bounds));
            }
        }
        let start = system.rows.clone();
        let (expected, _) = system.solve_by_sweeping();
        for (name, solve) in gradients::methods::<f64>() {
            let mut rows = start.clone();
            let mut accelerations = vec![Twist::zero(); system.bodies.len()];
            solve(&mut rows, &mut accelerations, 20_000);
            for (row, expected) in rows.iter().zip(&expected) {
                assert!((row.lambda - expected).abs() < 1e-8, "{name}: {} instead of {expected}", row.lambda);
            }
        }
    }
}

#[test]
fn a_row_that_nothing_can_move_stays_without_force() {
    let pair = RowPair::along(Vector3::y(), Vector3::x(), Vector3::z());
    let mut rows = [Row::rigid((0, &immovable()), (1, &immovable()), pair, 1.0, H, Bounds::Fixed(f64::MIN, f64::MAX))];
    let mut accelerations = [Twist::zero(); 2];
    pgs::solve(&mut rows, &mut accelerations, 10, |_| ());
    assert_eq!(rows[0].lambda, 0.0);
}

/// One vector of lanes from one scalar vector a lane.
fn lanes<const R: usize, const C: usize>(
    each: [nalgebra::SMatrix<f64, R, C>; 8],
) -> nalgebra::SMatrix<WideF32x8, R, C> {
    nalgebra::SMatrix::from_fn(|row, column| {
        let mut wide = WideF32x8::splat(0.0);
        each.iter().enumerate().for_each(|(lane, matrix)| wide.replace(lane, matrix[(row, column)] as f32));
        wide
    })
}

fn single<const R: usize, const C: usize>(matrix: nalgebra::SMatrix<f64, R, C>) -> nalgebra::SMatrix<f32, R, C> {
    matrix.map(|value| value as f32)
}

/// Two bodies on the ground and on each other, held together at a point: every kind of row.
fn every_kind_of_row<N: SimdRealField + Copy>(
    bodies: &[BodyTerms<N>; 3],
    vectors: &[Vector3<N>; 5],
    number: impl Fn(f32) -> N,
) -> Vec<Row<N>> {
    let [arm_a, arm_b, normal, first, second] = *vectors;
    let h = number(H as f32);
    let infinite = number(f32::INFINITY);
    let mut rows = Vec::new();
    for (a, b) in [(0, 1), (1, 2)] {
        let (body_a, body_b) = ((a as u32, &bodies[a]), (b as u32, &bodies[b]));
        let site = PointConstraint { a: body_a, b: body_b, arm_a, arm_b, normal };
        rows.push(site.normal_row(number(0.3), h, infinite));
        for (back, tangent) in [(1, first), (2, second)] {
            let bounds = Bounds::Friction { coefficient: number(0.5), normal_rows_back: back };
            rows.push(site.friction_row(tangent, h, bounds));
        }
    }
    for (axis, pair) in point_jacobian(arm_b, arm_a).into_iter().enumerate() {
        let (a, b) = ((0, &bodies[0]), (2, &bodies[2]));
        rows.push(if axis == 0 {
            let spring = Spring { stiffness: number(900.0), damping: number(20.0), error: number(0.1) };
            Row::soft(a, b, pair, spring, h, Bounds::Fixed(number(-3.0), number(3.0)))
        } else {
            Row::rigid(a, b, pair, number(-0.2), h, Bounds::Fixed(-infinite, infinite))
        });
    }
    rows
}

#[test]
fn eight_lanes_solve_eight_systems_as_one_lane_solves_each() {
    let random = &mut Random::new(14);
    let systems: [([BodyTerms<f64>; 3], [Vector3<f64>; 5]); 8] = std::array::from_fn(|_| {
        let normal = random.direction();
        let [first, second] = tangents(&normal);
        ([immovable(), random.body(), random.body()], [random.vector(), random.vector(), normal, first, second])
    });
    let bodies: [BodyTerms<WideF32x8>; 3] = std::array::from_fn(|body| BodyTerms {
        inverse_mass: lanes(systems.map(|(bodies, _)| bodies[body].inverse_mass)),
        inverse_inertia: lanes(systems.map(|(bodies, _)| bodies[body].inverse_inertia)),
        free: Twist {
            linear: lanes(systems.map(|(bodies, _)| bodies[body].free.linear)),
            angular: lanes(systems.map(|(bodies, _)| bodies[body].free.angular)),
        },
    });
    let vectors = std::array::from_fn(|vector| lanes(systems.map(|(_, vectors)| vectors[vector])));
    let mut wide_rows = every_kind_of_row(&bodies, &vectors, WideF32x8::splat);
    let mut wide_accelerations = [Twist::zero(); 3];
    pgs::solve(&mut wide_rows, &mut wide_accelerations, 20, |_| ());

    let (mut at_bound, mut apart) = (0, 0);
    for (lane, (bodies, vectors)) in systems.into_iter().enumerate() {
        let bodies = bodies.map(|body| BodyTerms {
            inverse_mass: single(body.inverse_mass),
            inverse_inertia: single(body.inverse_inertia),
            free: Twist { linear: single(body.free.linear), angular: single(body.free.angular) },
        });
        let mut rows = every_kind_of_row(&bodies, &vectors.map(single), |value| value);
        let mut accelerations = [Twist::zero(); 3];
        pgs::solve(&mut rows, &mut accelerations, 20, |_| ());
        for (row, wide) in rows.iter().zip(&wide_rows) {
            assert_eq!(row.lambda, wide.lambda.extract(lane), "lane {lane}");
            apart += usize::from(row.lambda == 0.0);
            at_bound += usize::from(row.lambda.abs() == 3.0);
        }
        for (body, wide) in accelerations.iter().zip(&wide_accelerations) {
            assert_eq!(body.linear, wide.linear.map(|value| value.extract(lane)), "lane {lane}");
        }
    }
    assert!(apart > 0 && at_bound > 0, "lanes that all do the same prove little: {apart} apart, {at_bound} at bound");
}
