//! The rows of joints: their Jacobians J, errors C and velocity terms J̇v. No others stand anywhere else.
//!
//! With r the arms from the centres of mass to the frames' origins, d = x_B + r_B − x_A − r_A, a_k and b_k the axes of
//! the frames A and B, Ω = ω_B − ω_A; all in world axes. A dot is the change with time, and J̇v is C̈ where nothing
//! accelerates.
//!
//! *Translations.* Where all three are locked, C = d along the world axes e_k (Erleben 2005, p. 71):
//!
//! J = [−e_k, −r_A × e_k, e_k, r_B × e_k],  J̇v = e_k · (ω_B × (ω_B × r_B) − ω_A × (ω_A × r_A)).
//!
//! Else C = a_k · d for each that is locked; the axis turns with A, which lengthens A's arm by d:
//!
//! J = [−a_k, −(r_A + d) × a_k, a_k, r_B × a_k],
//! J̇v = a_k · (ω_B × (ω_B × r_B) − ω_A × (ω_A × r_A)) + 2 (ω_A × a_k) · ḋ + (ω_A × (ω_A × a_k)) · d.
//!
//! *Rotations* have J = [0, −u, 0, u]. With q = (w, v) the rotation of B seen from A, q̇_v = ½(wΩ + Ω × v) in A's axes.
//! Where all three are locked, C = 2v (w ≥ 0, else of −q), the sine of half the angle along the axis: its Jacobian is
//! regular up to half a turn, where it has no direction:
//!
//! u_k = w a_k + v × a_k,  J̇v = −½ Ω² v_k − u_k · (ω_A × ω_B).
//!
//! Else each swing that is locked is a right angle between an axis of A and B's x: with σ the angle of the swing about
//! an axis at φ from y to z, b_x = (cos σ, sin σ sin φ, −sin σ cos φ) in A's axes, so that −a_z · b_x and a_y · b_x are
//! sin σ along y and z, whatever the twist. With a right angle between a and b,
//!
//! C = a · b,  u = b × a,  J̇v = Ω · ((ω_B × b) × a + b × (ω_A × a)).
//!
//! The twist is τ = 2 atan2(v_x, w) = atan2(a_z · b_y − a_y · b_z, a_y · b_y + a_z · b_z). From q̇,
//! τ̇ = Ω_x + (Ω_y (w v_z + v_x v_y) + Ω_z (v_x v_z − w v_y))/(w² + v_x²), whose brackets are half the components of b_x
//! along a_y and a_z and whose divisor is ½(1 + a_x · b_x):
//!
//! u = (a_x + b_x)/s,  s = 1 + a_x · b_x,  J̇v = Ω · (ω_A × a_x + ω_B × b_x − u ṡ)/s,  ṡ = Ω · (b_x × a_x).
//!
//! Where the swing is half a turn the twist has no meaning: s = 0, and the row is zero.
//!
//! *Single coordinates* q, of which limits, motors, springs and friction are. Translations and the twist are as above;
//! besides, the swing, the angle σ between a = a_x and b = b_x, with c = a × b, n = c/|c|:
//!
//!
//! q = atan2(|c|, a · b),  u = n,  J̇v = Ω · (ċ − n (n · ċ))/|c|,  ċ = (ω_A × a) × b + a × (ω_B × b);
//!
//! where the axes are parallel, n has no direction, and the row is zero; *distance* ℓ = |d|, n = d/ℓ:
//!
//! J = [−n, −r_A × n, n, r_B × n],  J̇v = n · swirl + (|ḋ|² − ℓ̇²)/ℓ;
//!
//! *turning* about an axis a_k of A, of which there is a rate alone: u = a_k, J̇v = Ω · (ω_A × a_k).
//!
//! A limit has C = q − bound, a motion C = q − q(t) with ∂C/∂t = −q̇(t) and d/dt ∂C/∂t = −q̈(t), a rate C = 0 with
//! ∂C/∂t = −rate, a spring C = q − rest.
//!
//! So a joint that locks the twist alone is one of constant velocity; a swing alone, a universal joint (whose cross has
//! its arms along a_z and b_x, or a_y and b_x); both swings, a hinge; all three, a rigid one.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Quaternion, SimdRealField, UnitQuaternion, Vector3};

use super::constraint::{BodyState, ConstraintRow, RowFunction};
use super::definition::{Frame, Hold, JointDefinition, Laws};
use super::law::{CoordinateLaw, JointAxis, LawAxis, LawPart};
use super::softness::SpringConstants;
use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::constraint::row::{RowPair, Twist, Wrench};

/// Two joined bodies as their joint sees them, world axes, SI.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointState<N> {
    /// From each centre of mass to the frame's origin.
    pub arms: [Vector3<N>; 2],
    /// From A's frame to B's.
    pub separation: Vector3<N>,
    /// Of the frames.
    pub rotations: [UnitQuaternion<N>; 2],
    pub velocities: [Twist<N>; 2],
}

/// One row of a joint or of a user's own constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointRow<N> {
    pub jacobian: RowPair<N>,
    /// C, m or rad.
    pub error: N,
    /// Ċ = J v + ∂C/∂t.
    pub rate: N,
    /// C̈ where nothing accelerates: J̇v and the change of ∂C/∂t.
    pub velocity_term: N,
    /// ∂C/∂t.
    pub time_rate: N,
    /// A spring along the row instead of a rigid one.
    pub spring: Option<SpringConstants>,
    pub bound: Bound<N>,
    /// Whether it is of a rate alone: C is zero, whatever the pose.
    pub is_rate: bool,
    /// e of a limit: share of its approach with which C parts again; 0 elsewhere.
    pub restitution: f64,
}

/// What λ of a row may be, N or N·m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound<N> {
    None,
    Within(N, N),
    /// √(Σλ²) ≤ `most` over `count` rows that stand together, of which this is number `place`, from 0.
    Norm {
        most: N,
        place: u32,
        count: u32,
    },
}

impl Bound<f64> {
    /// How much of an error C is a gap that the rows leave open: rows that push B along J alone hold C ≥ 0.
    pub fn open(&self, error: f64) -> f64 {
        match self {
            Self::Within(0.0, _) => error.max(0.0),
            Self::Within(_, 0.0) => error.min(0.0),
            _ => 0.0,
        }
    }
}

impl Bound<f64> {
    /// Whether it is a largest force, and no gap.
    pub fn is_boxed(&self) -> bool {
        matches!(*self, Self::Within(lower, upper) if lower != 0.0 && upper != 0.0 || lower == upper)
    }
}

impl JointRow<f64> {
    /// The rate, m/s or rad/s, that a rigid row is to have over a time h, s: an open gap may close within it, what
    /// closes it faster than `least` and has a restitution goes back, and the rest does not change but with time.
    pub fn allowed_rate(&self, h: f64, least: f64) -> f64 {
        self.rebound(h, least).unwrap_or(-self.bound.open(self.error) / h)
    }

    /// The rate with which it goes back, if it closes its gap within h, s, and has a restitution.
    pub fn rebound(&self, h: f64, least: f64) -> Option<f64> {
        let closes = match self.bound {
            Bound::Within(0.0, _) => self.rate < -least && self.error + self.rate * h <= 0.0,
            Bound::Within(_, 0.0) => self.rate > least && self.error + self.rate * h >= 0.0,
            _ => false,
        };
        (closes && self.restitution > 0.0).then(|| -self.restitution * self.rate)
    }

    /// J M⁻¹ Jᵀ, 1/kg or 1/(kg·m²).
    pub fn mobility(&self, bodies: [&Body; 2]) -> f64 {
        let of = |end: usize| {
            let (body, row) = (bodies[end], self.jacobian.of(end));
            let turn = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
            let moved = Twist { linear: body.inverse_mass.component_mul(&row.linear), angular: turn * row.angular };
            row.dot(&moved)
        };
        of(0) + of(1)
    }

    /// Force on B and torque about the end of an arm from its centre of mass, for a multiplier of 1.
    pub fn wrench_about(&self, arm_b: &Vector3<f64>) -> Wrench<f64> {
        let RowPair { linear_b, angular_b, .. } = self.jacobian;
        Wrench { linear: linear_b, angular: angular_b - arm_b.cross(&linear_b) }
    }
}

impl<N: SimdRealField + Copy> JointState<N>
where
    N::Element: SimdRealField,
{
    /// Of bodies in those rotations, `offset` from A's centre of mass to B's: a difference that is exact however far
    /// the two lie from the origin.
    pub fn new(
        frames: &[Frame; 2],
        offset: Vector3<N>,
        rotations: [UnitQuaternion<N>; 2],
        velocities: [Twist<N>; 2],
    ) -> Self {
        let cast = |number: f64| nalgebra::convert::<f64, N>(number);
        let arms = [0, 1].map(|body| rotations[body] * frames[body].anchor.map(cast));
        let turned = [0, 1].map(|body| {
            let frame = Quaternion::from_vector(frames[body].rotation.coords.map(cast));
            rotations[body] * UnitQuaternion::new_unchecked(frame)
        });
        Self { arms, separation: offset + arms[1] - arms[0], rotations: turned, velocities }
    }

    /// Centripetal acceleration of B's origin less that of A's.
    fn swirl(&self) -> Vector3<N> {
        let [a, b] = [0, 1].map(|body| {
            let omega = &self.velocities[body].angular;
            omega.cross(&omega.cross(&self.arms[body]))
        });
        b - a
    }

    fn translation(&self, jacobian: RowPair<N>, error: N, velocity_term: N) -> JointRow<N> {
        let [a, b] = &self.velocities;
        let (rate, time_rate) = (jacobian.dot(a, b), N::zero());
        JointRow {
            jacobian,
            error,
            rate,
            velocity_term,
            time_rate,
            spring: None,
            bound: Bound::None,
            is_rate: false,
            restitution: 0.0,
        }
    }

    fn rotation(&self, axis: Vector3<N>, error: N, velocity_term: N) -> JointRow<N> {
        let zero = Vector3::zeros();
        let jacobian = RowPair { linear_a: zero, angular_a: -axis, linear_b: zero, angular_b: axis };
        self.translation(jacobian, error, velocity_term)
    }

    /// All three translations, along the world axes.
    fn point(&self) -> [JointRow<N>; 3] {
        let (jacobians, swirl) = (point_jacobian(self.arms[0], self.arms[1]), self.swirl());
        [0, 1, 2].map(|axis| self.translation(jacobians[axis], self.separation[axis], swirl[axis]))
    }

    /// The translation along an axis of A.
    fn along(&self, axis: Vector3<N>) -> JointRow<N> {
        let [a, b] = &self.velocities;
        let d = self.separation;
        let jacobian = RowPair::along(axis, self.arms[0] + d, self.arms[1]);
        let speed = b.linear + b.angular.cross(&self.arms[1]) - a.linear - a.angular.cross(&self.arms[0]);
        let turning = a.angular.cross(&axis);
        let twice = turning.dot(&speed) + turning.dot(&speed);
        let velocity_term = axis.dot(&self.swirl()) + twice + a.angular.cross(&turning).dot(&d);
        self.translation(jacobian, axis.dot(&d), velocity_term)
    }

    /// All three rotations, along A's axes.
    fn orientation(&self) -> [JointRow<N>; 3] {
        let [frame_a, frame_b] = &self.rotations;
        let axes = frame_a.to_rotation_matrix().into_inner();
        let q = frame_a.inverse() * frame_b;
        let sign = N::one().select(q.w.simd_ge(N::zero()), -N::one());
        let (w, v) = (q.w * sign, q.imag() * sign);
        let [a, b] = &self.velocities;
        let omega = b.angular - a.angular;
        let (square, turning) = (omega.dot(&omega), a.angular.cross(&b.angular));
        let half = (N::one() + N::one()).simd_recip();
        [0, 1, 2].map(|k| {
            let along: Vector3<N> = axes.column(k).into();
            let u = along * w + (axes * v).cross(&along);
            self.rotation(u, v[k] + v[k], -half * square * v[k] - u.dot(&turning))
        })
    }

    /// A right angle between an axis of A and one of B.
    fn right_angle(&self, of_a: Vector3<N>, of_b: Vector3<N>) -> JointRow<N> {
        let [a, b] = &self.velocities;
        let change = b.angular.cross(&of_b).cross(&of_a) + of_b.cross(&a.angular.cross(&of_a));
        let velocity_term = (b.angular - a.angular).dot(&change);
        self.rotation(of_b.cross(&of_a), of_a.dot(&of_b), velocity_term)
    }

    /// The twist, for the frames' axes.
    fn twist(&self, [of_a, of_b]: &[Matrix3<N>; 2]) -> JointRow<N> {
        let [ax, ay, az]: [Vector3<N>; 3] = [0, 1, 2].map(|k| of_a.column(k).into());
        let [bx, by, bz]: [Vector3<N>; 3] = [0, 1, 2].map(|k| of_b.column(k).into());
        let sine = az.dot(&by) - ay.dot(&bz);
        let cosine = ay.dot(&by) + az.dot(&bz);
        let sum = N::one() + ax.dot(&bx);
        let is_defined = sum.simd_gt(N::simd_default_epsilon().simd_sqrt());
        let scale = sum.select(is_defined, N::one()).simd_recip().select(is_defined, N::zero());
        let u = (ax + bx) * scale;
        let [a, b] = &self.velocities;
        let omega = b.angular - a.angular;
        let change = a.angular.cross(&ax) + b.angular.cross(&bx) - u * omega.dot(&bx.cross(&ax));
        let error = sine.simd_atan2(cosine).select(is_defined, N::zero());
        self.rotation(u, error, omega.dot(&change) * scale)
    }
}

impl JointRow<f64> {
    /// Holds nothing.
    pub const EMPTY: Self = {
        let none = Vector3::new(0.0, 0.0, 0.0);
        let jacobian = RowPair { linear_a: none, angular_a: none, linear_b: none, angular_b: none };
        let (error, rate, velocity_term, time_rate) = (0.0, 0.0, 0.0, 0.0);
        Self {
            jacobian,
            error,
            rate,
            velocity_term,
            time_rate,
            spring: None,
            bound: Bound::None,
            is_rate: false,
            restitution: 0.0,
        }
    };

    /// λ, where its bounds leave no choice.
    pub fn given(&self) -> Option<f64> {
        match self.bound {
            Bound::Within(lower, upper) if lower == upper => Some(lower),
            _ => None,
        }
    }

    /// Whether it is of rotations alone: its C is in rad.
    pub fn only_turns(&self) -> bool {
        self.jacobian.linear_a == Vector3::zeros() && self.jacobian.linear_b == Vector3::zeros()
    }
}

impl JointState<f64> {
    /// Of bodies as they are.
    fn of(frames: &[Frame; 2], [a, b]: &[BodyState; 2]) -> Self {
        let rotations = [a, b].map(|body| UnitQuaternion::new_unchecked(body.rotation.into()));
        let velocities = [a, b].map(|body| Twist { linear: body.linear.into(), angular: body.angular.into() });
        Self::new(frames, (b.position - a.position).into(), rotations, velocities)
    }
}

impl JointDefinition {
    /// Adds its rows at that state of A and B and that time, s.
    pub fn rows_at(&self, bodies: &[BodyState; 2], time: f64, rows: &mut Vec<JointRow<f64>>) {
        match &self.function {
            Some(function) => add_rows_of(function, bodies, time, rows),
            None => {
                let state = JointState::of(&self.frames, bodies);
                self.rows(&state, rows);
                let mut last: Option<(LawAxis, JointRow<f64>)> = None;
                for law in self.laws.iter().flat_map(|laws| laws.iter()) {
                    // Both ends of a range are of the same coordinate.
                    let known = last.filter(|(axis, _)| *axis == law.axis);
                    let coordinate =
                        known.map_or_else(|| law_coordinate(law.axis, &state, self.turned), |(_, row)| row);
                    rows.push(law_row(law, coordinate, time));
                    last = Some((law.axis, coordinate));
                }
            }
        }
    }

    /// A coordinate and its rate at that state of A and B; a twist is the value nearest to [`Self::turned`].
    pub fn coordinate(&self, axis: JointAxis, bodies: &[BodyState; 2]) -> [f64; 2] {
        let row = coordinate(axis, &JointState::of(&self.frames, bodies), self.turned);
        [row.error, row.rate]
    }

    /// How far what it holds rigidly is apart, m: where it holds no point at a point, the largest row, m or rad.
    pub fn separation(&self, bodies: [&Body; 2], time: f64) -> f64 {
        if self.is_ball() {
            if self.is_soft() {
                return 0.0;
            }
            let [a, b] = bodies;
            let [on_a, on_b] = &self.frames;
            return (b.position - a.position + b.rotation * on_b.anchor - a.rotation * on_a.anchor).norm();
        }
        let mut rows = Vec::new();
        self.rows_at(&bodies.map(BodyState::of), time, &mut rows);
        // What a largest force bounds may lag behind.
        let rigid = rows.iter().filter(|row| row.spring.is_none() && !row.bound.is_boxed());
        rigid.fold(0.0, |most, row| most.max((row.error - row.bound.open(row.error)).abs()))
    }

    /// Adds its rows: translations first.
    pub fn rows<N: SimdRealField + Copy>(&self, state: &JointState<N>, rows: &mut Vec<JointRow<N>>)
    where
        N::Element: SimdRealField,
    {
        let is_locked = |laws: &Laws, k: usize| laws.hold[k] == Hold::Locked;
        let first = rows.len();
        match self.translation.locked() {
            0 => {}
            3 => rows.extend(state.point()),
            _ => {
                let axes = state.rotations[0].to_rotation_matrix().into_inner();
                let locked = (0..3).filter(|&k| is_locked(&self.translation, k));
                rows.extend(locked.map(|k| state.along(axes.column(k).into())));
            }
        }
        give_way(&mut rows[first..], &self.translation);
        let first = rows.len();
        match self.rotation.locked() {
            0 => {}
            3 => rows.extend(state.orientation()),
            _ => {
                let axes = state.rotations.map(|rotation| rotation.to_rotation_matrix().into_inner());
                let [a, b] = &axes;
                let locked = (0..3).filter(|&k| is_locked(&self.rotation, k));
                rows.extend(locked.map(|k| match k {
                    0 => state.twist(&axes),
                    1 => state.right_angle(-a.column(2), b.column(0).into()),
                    _ => state.right_angle(a.column(1).into(), b.column(0).into()),
                }));
            }
        }
        give_way(&mut rows[first..], &self.rotation);
    }
}

/// J of three locked translations, along the world axes.
pub(crate) fn point_jacobian<N: SimdRealField + Copy>(arm_a: Vector3<N>, arm_b: Vector3<N>) -> [RowPair<N>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| RowPair::along(axis, arm_a, arm_b))
}

/// Adds a user's own rows.
fn add_rows_of(function: &RowFunction, bodies: &[BodyState; 2], time: f64, rows: &mut Vec<JointRow<f64>>) {
    let now = function.at(bodies, time);
    // Nothing accelerates meanwhile.
    let around = [-1.0, 1.0].map(|side| {
        let offset = side * ConstraintRow::DIFFERENCE;
        function.at(&bodies.map(|body| body.later(offset)), time + offset)
    });
    rows.extend(now.iter().enumerate().map(|(index, row)| {
        let [linear_a, linear_b] = row.linear.map(Vector3::from);
        let [angular_a, angular_b] = row.angular.map(Vector3::from);
        let difference = || {
            let [before, after] = around.each_ref().map(|rows| rows.get(index).map_or(0.0, |row| row.rate(bodies)));
            (after - before) / (2.0 * ConstraintRow::DIFFERENCE)
        };
        // What is no number bounds nothing; of bounds that contradict each other their mean is both.
        let lower = if row.bounds.0.is_nan() { f64::NEG_INFINITY } else { row.bounds.0 };
        let upper = if row.bounds.1.is_nan() { f64::INFINITY } else { row.bounds.1 };
        let mean = 0.5 * (lower + upper);
        let (lower, upper) = if lower > upper { (mean, mean) } else { (lower, upper) };
        let is_bounded = lower.is_finite() || upper.is_finite();
        JointRow {
            jacobian: RowPair { linear_a, angular_a, linear_b, angular_b },
            error: row.error,
            rate: row.rate(bodies),
            velocity_term: row.velocity_term.unwrap_or_else(difference),
            time_rate: row.time_rate,
            spring: None,
            bound: if is_bounded { Bound::Within(lower, upper) } else { Bound::None },
            is_rate: false,
            // Nor does what is no number bounce.
            restitution: if row.restitution > 0.0 { row.restitution.min(1.0) } else { 0.0 },
        }
    }));
}

/// Makes springs of rows where the laws of their group say so.
fn give_way<N: SimdRealField + Copy>(rows: &mut [JointRow<N>], laws: &Laws) {
    let Some(spring) = laws.spring else { return };
    let (most, count) = (nalgebra::convert(spring.max_force), rows.len() as u32);
    for (place, row) in (0..).zip(rows) {
        row.spring = Some(spring.into());
        row.bound = Bound::Norm { most, place, count };
    }
}

/// Sine of a swing, and distance in m, under which they have no direction.
const NO_DIRECTION: f64 = 1e-9;

/// The row that a law of that axis bounds; the twist is the value nearest to `turned`.
fn law_coordinate(axis: LawAxis, state: &JointState<f64>, turned: f64) -> JointRow<f64> {
    match axis {
        LawAxis::Coordinate(axis) => coordinate(axis, state, turned),
        LawAxis::Turning(axis) => turning(axis, state),
    }
}

/// The row of a law at that time, s.
fn law_row(law: &CoordinateLaw, coordinate: JointRow<f64>, time: f64) -> JointRow<f64> {
    let within = if law.most.is_finite() { Bound::Within(-law.most, law.most) } else { Bound::None };
    match law.part {
        LawPart::Limit { bound, is_upper, restitution } => {
            let pushes = if is_upper { (f64::NEG_INFINITY, 0.0) } else { (0.0, f64::INFINITY) };
            let error = coordinate.error - bound;
            JointRow { error, bound: Bound::Within(pushes.0, pushes.1), restitution, ..coordinate }
        }
        LawPart::Rate(rate) => {
            let (rate, time_rate) = (coordinate.rate - rate, -rate);
            JointRow { error: 0.0, rate, time_rate, is_rate: true, bound: within, ..coordinate }
        }
        LawPart::Motion(motion) => {
            let [q, rate, acceleration] = motion.at_time(time);
            JointRow {
                error: coordinate.error - q,
                rate: coordinate.rate - rate,
                time_rate: -rate,
                velocity_term: coordinate.velocity_term - acceleration,
                bound: within,
                ..coordinate
            }
        }
        LawPart::Spring { rest, stiffness, damping } => JointRow {
            error: coordinate.error - rest,
            spring: Some(SpringConstants::Given { stiffness, damping }),
            bound: Bound::Norm { most: law.most, place: 0, count: 1 },
            ..coordinate
        },
    }
}

/// The value of an angle, rad, whole turns added, that is nearest to another.
pub(crate) fn nearest_turn(angle: f64, to: f64) -> f64 {
    angle + TAU * ((to - angle) / TAU).round()
}

/// The row whose error is a coordinate.
fn coordinate(axis: JointAxis, state: &JointState<f64>, turned: f64) -> JointRow<f64> {
    match axis {
        JointAxis::X => translation(state, 0),
        JointAxis::Y => translation(state, 1),
        JointAxis::Z => translation(state, 2),
        JointAxis::Twist => {
            let row = state.twist(&state.rotations.map(|rotation| rotation.to_rotation_matrix().into_inner()));
            JointRow { error: nearest_turn(row.error, turned), ..row }
        }
        JointAxis::Swing => swing(state),
        JointAxis::Distance => distance(state),
    }
}

fn translation(state: &JointState<f64>, axis: usize) -> JointRow<f64> {
    state.along(state.rotations[0].to_rotation_matrix().into_inner().column(axis).into())
}

fn swing(state: &JointState<f64>) -> JointRow<f64> {
    let [a, b] = state.rotations.map(|rotation| rotation * Vector3::x());
    let [of_a, of_b] = state.velocities.map(|velocity| velocity.angular);
    let (across, omega) = (a.cross(&b), of_b - of_a);
    let sine = across.norm();
    let angle = sine.atan2(a.dot(&b));
    if sine < NO_DIRECTION {
        return state.rotation(Vector3::zeros(), angle, 0.0);
    }
    let about = across / sine;
    let change = of_a.cross(&a).cross(&b) + a.cross(&of_b.cross(&b));
    state.rotation(about, angle, omega.dot(&(change - about * about.dot(&change))) / sine)
}

fn distance(state: &JointState<f64>) -> JointRow<f64> {
    let d = state.separation;
    let length = d.norm();
    let [a, b] = &state.velocities;
    let along = if length > NO_DIRECTION { d / length } else { Vector3::zeros() };
    let jacobian = RowPair::along(along, state.arms[0], state.arms[1]);
    let parting = b.linear + b.angular.cross(&state.arms[1]) - a.linear - a.angular.cross(&state.arms[0]);
    let across = parting.norm_squared() - along.dot(&parting).powi(2);
    let velocity_term = along.dot(&state.swirl()) + if length > NO_DIRECTION { across / length } else { 0.0 };
    state.translation(jacobian, length, velocity_term)
}

fn turning(axis: usize, state: &JointState<f64>) -> JointRow<f64> {
    let along: Vector3<f64> = state.rotations[0].to_rotation_matrix().into_inner().column(axis).into();
    let [a, b] = &state.velocities;
    let velocity_term = (b.angular - a.angular).dot(&a.angular.cross(&along));
    state.rotation(along, 0.0, velocity_term)
}

#[cfg(test)]
mod tests;
