//! A contact patch and a ball joint as the direct solve sees them: rows on the relative motion at one
//! point, where body X, with the arm r from its centre of mass, moves with u = v + ω × r and turns with w = ω.
//!
//! A patch has one row for each of its points, n·u + q·w with q = ρ × n, ρ from the middle to the point, two rows
//! t·u of friction and one n·w of twist; a joint has the three rows u. Each row is a spring-damper of weight ρ_r
//! (impulse over speed) about the impulse λ̂ of the step before: λ = λ̂ − ρ_r (row + b), an augmented Lagrangian
//! (Hestenes 1969; Powell 1969), which at rest is exact whatever the weight. What rows share goes into 3 × 3 blocks:
//!
//! K_uu = Σρ_i n nᵀ + ρ_t (1 − n nᵀ), K_uw = n Σρ_i q_iᵀ, K_ww = Σρ_i q_i q_iᵀ + ρ_τ n nᵀ.

use nalgebra::{Matrix3, Vector3};

use super::cholesky::{Block, Part};
use crate::physics::collision::{ContactState, POINTS};
use crate::physics::lanes::Record;

/// Depth or gap, over the arm, at which surfaces count as just touching: single precision cannot tell.
const TOUCHING: f64 = 1e-5;

/// Way of a row over its arm that a factor bears: what it then solves is off by that share, and the next step makes
/// up for it.
const MOVED: f64 = 1e-4;

/// One side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    /// Its body among those that move.
    pub body: Option<u32>,
    /// From the centre of mass.
    pub arm: Vector3<f64>,
}

/// Velocity or impulse at the point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// u, or force.
    pub linear: Vector3<f64>,
    /// w, or torque.
    pub angular: Vector3<f64>,
}

/// What rows share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffness {
    pub uu: Matrix3<f64>,
    pub uw: Matrix3<f64>,
    pub ww: Matrix3<f64>,
}

impl Stiffness {
    /// S_Xᵀ K S_Y for arms of two sides, S = (1, −[r]ₓ; 0, 1).
    pub fn between(&self, x: &Vector3<f64>, y: &Vector3<f64>) -> Block {
        let (x, y) = (x.cross_matrix(), y.cross_matrix());
        let right = self.uw - self.uu * y;
        let left = self.uw.transpose() + x * self.uu;
        let turn = x * right + self.ww - self.uw.tr_mul(&y);
        let mut block = Block::zeros();
        block.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.uu);
        block.fixed_view_mut::<3, 3>(0, 3).copy_from(&right);
        block.fixed_view_mut::<3, 3>(3, 0).copy_from(&left);
        block.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        block
    }
}

/// The motion of a side for the velocity of its body.
pub(super) fn motion(part: &Part, arm: &Vector3<f64>) -> Motion {
    let (linear, angular) = (part.fixed_rows::<3>(0), part.fixed_rows::<3>(3).into_owned());
    Motion { linear: linear + angular.cross(arm), angular }
}

/// What an impulse at the point is to a body.
pub(super) fn wrench(impulse: &Motion, arm: &Vector3<f64>) -> Part {
    let torque = arm.cross(&impulse.linear) + impulse.angular;
    let force = impulse.linear;
    Part::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

/// A row that can only push.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    /// q.
    lever: Vector3<f64>,
    /// Negative: depth.
    separation: f64,
    /// λ̂.
    expected: f64,
    /// λ.
    impulse: f64,
    pushes: bool,
}

/// What a factor knows of a patch or joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    arms: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    levers: [Vector3<f64>; POINTS],
    acts: [bool; POINTS],
    gives: [bool; 2],
}

impl Shape {
    /// Whether the same rows act in so nearly the same place that the factor will do.
    pub fn is_nearly(&self, other: &Self) -> bool {
        let size = self.arms[1].norm_squared();
        let squared = (0..2).map(|side| (self.arms[side] - other.arms[side]).norm_squared());
        let levers = (0..POINTS).map(|point| (self.levers[point] - other.levers[point]).norm_squared());
        let moved = squared.chain(levers).fold(size * (self.normal - other.normal).norm_squared(), f64::max);
        self.acts == other.acts && self.gives == other.gives && moved <= MOVED * MOVED * size
    }
}

/// A contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    pub sides: [Side; 2],
    /// Motion that sides which do not move here give it, B's less A's.
    pub given: Motion,
    normal: Vector3<f64>,
    tangents: [Vector3<f64>; 2],
    points: [Point; POINTS],
    count: usize,
    coefficient: f64,
    /// Mean distance of the points from the middle.
    radius: f64,
    /// Gap that counts as none.
    touching: f64,
    expected: [f64; 3],
    /// Two tangents and twist.
    friction: [f64; 3],
    slides: bool,
    twists: bool,
}

impl Patch {
    /// From the state of a contact, with what turns A's and B's axes into the world's, and `apart` the centre of B
    /// less the origin of A's axes, from which A's arms count. Impulses are taken `scale` times.
    pub fn new(state: &ContactState, [turn_a, turn_b]: &[Matrix3<f64>; 2], apart: &Vector3<f64>, scale: f64) -> Self {
        let ContactState { geometry, impulses } = state;
        let (normal, tangent) = (turn_a * geometry.normal(), turn_a * geometry.tangent());
        let count = geometry.point_count();
        let mut patch = Self {
            normal,
            tangents: [tangent, normal.cross(&tangent)],
            count,
            coefficient: f64::from(geometry.friction()),
            ..Self::default()
        };
        let mut arms = [Vector3::zeros(); POINTS];
        let mut middle = Vector3::zeros();
        for (index, (point, arm)) in patch.points[..count].iter_mut().zip(&mut arms).enumerate() {
            let (on_a, on_b) = geometry.point(index);
            let (on_a, on_b) = (turn_a * on_a, turn_b * on_b + apart);
            *arm = (on_a + on_b) * 0.5;
            middle += *arm;
            let expected = f64::from(impulses.0[index]) * scale;
            *point = Point { separation: normal.dot(&(on_b - on_a)), expected, impulse: expected, ..Point::default() };
        }
        middle /= count as f64;
        patch.sides = [Side { body: None, arm: middle }, Side { body: None, arm: middle - apart }];
        patch.touching = TOUCHING * patch.sides[1].arm.norm();
        for (point, arm) in patch.points[..count].iter_mut().zip(&arms) {
            let offset = arm - middle;
            point.lever = offset.cross(&normal);
            point.pushes = point.expected > 0.0 || point.separation <= patch.touching;
            patch.radius += offset.norm() / count as f64;
        }
        patch.expected = std::array::from_fn(|row| f64::from(impulses.0[POINTS + row]) * scale);
        patch.friction = patch.expected;
        patch
    }

    /// Takes over which rows act from the step before, of points that are still where they were.
    pub fn resume(&mut self, before: &Self) {
        let near = MOVED * self.radius;
        for (point, old) in self.points[..self.count].iter_mut().zip(&before.points[..before.count]) {
            if point.expected == 0.0 && (point.lever - old.lever).norm_squared() <= near * near {
                point.pushes = old.pushes;
            }
        }
        (self.slides, self.twists) = (before.slides, before.twists);
    }

    /// How many points it has.
    pub fn points(&self) -> usize {
        self.count
    }

    /// What K is made of.
    pub fn shape(&self) -> Shape {
        Shape {
            arms: self.sides.map(|side| side.arm),
            normal: self.normal,
            levers: self.points.map(|point| point.lever),
            acts: self.points.map(|point| point.pushes),
            gives: [self.slides, self.twists].map(|gives| gives || self.coefficient == 0.0),
        }
    }

    /// K for rows of that weight.
    pub fn stiffness(&self, weight: f64) -> Stiffness {
        let normal = &self.normal;
        let (mut pressed, mut lever, mut ww) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for point in self.points[..self.count].iter().filter(|point| point.pushes) {
            pressed += weight;
            lever += point.lever * weight;
            ww += point.lever * point.lever.transpose() * weight;
        }
        let square = normal * normal.transpose();
        let across = if self.slides || self.coefficient == 0.0 { 0.0 } else { weight };
        if !self.twists && self.coefficient != 0.0 {
            ww += square * (weight * self.radius * self.radius);
        }
        Stiffness {
            uu: Matrix3::from_diagonal_element(across) + square * (pressed - across),
            uw: normal * lever.transpose(),
            ww,
        }
    }

    /// Impulse on B of the rows where nothing moves but what is given.
    pub fn impulse_at_rest(&self, weight: f64, per_step: f64) -> Motion {
        let given = &self.given;
        let mut impulse = Motion::default();
        for point in self.points[..self.count].iter().filter(|point| point.pushes) {
            let push = self.push_of(point, given, weight, per_step);
            impulse.linear += self.normal * push;
            impulse.angular += point.lever * push;
        }
        if self.coefficient != 0.0 {
            let [x, y, twist] = self.friction_trial(given, weight);
            impulse.linear += self.tangents[0] * x + self.tangents[1] * y;
            impulse.angular += self.normal * twist;
        }
        impulse
    }

    /// Impulse on B that closes a share of the depths, at most so fast.
    pub fn correction(&self, weight: f64, share_per_step: f64, fastest: f64) -> Motion {
        let mut impulse = Motion::default();
        for point in self.points[..self.count].iter().filter(|point| point.pushes) {
            let depth = (-point.separation - self.touching).max(0.0);
            let push = weight * (depth * share_per_step).min(fastest);
            impulse.linear += self.normal * push;
            impulse.angular += point.lever * push;
        }
        impulse
    }

    fn push_of(&self, point: &Point, motion: &Motion, weight: f64, per_step: f64) -> f64 {
        let speed = self.normal.dot(&motion.linear) + point.lever.dot(&motion.angular);
        let gap = (point.separation - self.touching).max(0.0);
        point.expected - weight * (speed + gap * per_step)
    }

    /// Friction at a motion, as the rows stand: those that slide push as they did.
    fn friction_trial(&self, motion: &Motion, weight: f64) -> [f64; 3] {
        let [x, y, twist] = self.friction;
        let [slip_x, slip_y] = self.tangents.map(|tangent| tangent.dot(&motion.linear));
        let stuck = [self.expected[0] - weight * slip_x, self.expected[1] - weight * slip_y];
        let [x, y] = if self.slides { [x, y] } else { stuck };
        let spin = self.normal.dot(&motion.angular);
        [x, y, if self.twists { twist } else { self.expected[2] - weight * self.radius * self.radius * spin }]
    }

    /// Takes in the motion that was solved for. False if some row turned out other than was assumed, by more than a
    /// `slight` impulse, N·s.
    pub fn take(&mut self, motion: &Motion, weight: f64, per_step: f64, slight: f64) -> bool {
        let pushes: [f64; POINTS] = std::array::from_fn(|index| {
            if index < self.count { self.push_of(&self.points[index], motion, weight, per_step) } else { 0.0 }
        });
        let pressed: f64 = pushes.iter().map(|push| push.max(0.0)).sum();
        let mut holds = true;
        for (point, push) in self.points[..self.count].iter_mut().zip(pushes) {
            let is_wrong = (push > 0.0) != point.pushes;
            if is_wrong && push.abs() > slight {
                holds = false;
                point.pushes = push > 0.0;
            }
            point.impulse = if is_wrong { 0.0 } else { push.max(0.0) };
        }
        if self.coefficient == 0.0 {
            return holds;
        }
        let limit = self.coefficient * pressed;
        let [slip_x, slip_y] = self.tangents.map(|tangent| tangent.dot(&motion.linear));
        let (x, y) = (self.expected[0] - weight * slip_x, self.expected[1] - weight * slip_y);
        let size = x.hypot(y);
        let bound = |most: f64, gives: bool| if gives { most } else { most + slight };
        let slides = size > bound(limit, self.slides);
        let shrink = if size > limit { limit / size } else { 1.0 };
        let most = limit * self.radius;
        let twist = self.expected[2] - weight * self.radius * self.radius * self.normal.dot(&motion.angular);
        let twists = twist.abs() > bound(most, self.twists);
        let friction = [x * shrink, y * shrink, twist.clamp(-most, most)];
        let moved = |row: usize| (friction[row] - self.friction[row]).abs();
        holds &= slides == self.slides && twists == self.twists;
        holds &= !slides || moved(0).max(moved(1)) <= slight;
        holds &= !twists || moved(2) <= slight * self.radius;
        (self.slides, self.twists, self.friction) = (slides, twists, friction);
        holds
    }

    /// What it pushed, divided by `scale`, N·s.
    pub fn impulses(&self, scale: f64) -> Record<f32> {
        let mut record = Record::default();
        for (place, point) in record.0.iter_mut().zip(&self.points[..self.count]) {
            *place = (point.impulse / scale) as f32;
        }
        for (place, friction) in record.0[POINTS..].iter_mut().zip(self.friction) {
            *place = (friction / scale) as f32;
        }
        record
    }
}

/// A rigid ball joint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Link {
    pub sides: [Side; 2],
    pub given: Motion,
    /// Anchor of B less anchor of A.
    pub separation: Vector3<f64>,
    /// λ̂.
    pub expected: Vector3<f64>,
    /// λ on B.
    pub impulse: Vector3<f64>,
}

impl Link {
    /// K for rows of that weight.
    pub fn stiffness(weight: f64) -> Stiffness {
        Stiffness { uu: Matrix3::from_diagonal_element(weight), uw: Matrix3::zeros(), ww: Matrix3::zeros() }
    }

    /// What K is made of.
    pub fn shape(&self) -> Shape {
        let none = Vector3::zeros();
        Shape {
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: [none; POINTS],
            acts: [true; POINTS],
            gives: [false; 2],
        }
    }

    /// Impulse on B at a motion.
    pub fn impulse_at(&self, motion: &Motion, weight: f64) -> Vector3<f64> {
        self.expected - motion.linear * weight
    }
}
