//! A contact patch and a ball joint as the direct solve sees them: rows on the relative motion at one
//! point, where body X, with the arm r from its centre of mass, moves with u = v + ω × r and turns with w = ω.
//!
//! A patch has one row for each of its points, n·u + q·w with q = ρ × n, ρ from the middle to the point, two rows
//! t·u of friction and one n·w of twist; a joint has the three rows u. Each row is a spring-damper of weight ρ_r
//! (impulse over speed) about the impulse λ̂ of the step before: λ = λ̂ − ρ_r (row + b), an augmented Lagrangian
//! (Hestenes 1969; Powell 1969), which at rest is exact whatever the weight. What rows share goes into 3 × 3 blocks:
//!
//! K_uu = Σρ_i n nᵀ + ρ_t (1 − n nᵀ), K_uw = n Σρ_i q_iᵀ, K_ww = Σρ_i q_i q_iᵀ + ρ_τ n nᵀ.

use nalgebra::{ArrayStorage, Matrix3, Vector3};

use super::Closing;
use crate::physics::collision::{ContactState, POINTS};
use crate::physics::constraint::row::bounded;
use crate::physics::lanes::Record;
use crate::physics::solver::linear::{BodyBlock as Block, BodyVector as Part};

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

impl Motion {
    /// u·f + w·τ of a motion and an impulse.
    pub fn dot(&self, impulse: &Self) -> f64 {
        self.linear.dot(&impulse.linear) + self.angular.dot(&impulse.angular)
    }

    /// It and a share of another.
    pub fn plus(&self, other: &Self, share: f64) -> Self {
        Self { linear: self.linear + other.linear * share, angular: self.angular + other.angular * share }
    }
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
    fn between(&self, x: &Vector3<f64>, y: &Vector3<f64>) -> Block {
        let (x, y) = (x.cross_matrix(), y.cross_matrix());
        let right = self.uw - self.uu * y;
        let left = self.uw.transpose() + x * self.uu;
        let turn = x * right + self.ww - self.uw.tr_mul(&y);
        let (upper, lower) = ([&self.uu, &right], [&left, &turn]);
        Block::from_fn(|row, column| {
            let half = if row < 3 { &upper } else { &lower };
            half[column / 3][(row % 3, column % 3)]
        })
    }
}

/// The same of K_uu = w alone: w (1, −[y]ₓ; [x]ₓ, (x·y) 1 − y xᵀ).
fn isotropic(w: f64, x: &Vector3<f64>, y: &Vector3<f64>) -> Block {
    let (along, scaled) = (w * x.dot(y), y * w);
    let mut block = [[0.0; 6]; 6];
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        block[axis][axis] = w;
        block[axis][3 + next] = w * x[last];
        block[axis][3 + last] = -w * x[next];
        block[3 + axis][next] = -scaled[last];
        block[3 + axis][last] = scaled[next];
        for row in 0..3 {
            block[3 + axis][3 + row] = -scaled[row] * x[axis];
        }
        block[3 + axis][3 + axis] += along;
    }
    Block::from_data(ArrayStorage(block))
}

/// What rows add to the matrix, as they were when it was last made of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    /// Of A and B, each with itself.
    pub own: [Block; 2],
    /// A's rows, B's columns.
    pub across: Block,
    of: Option<(Shape, f64)>,
}

impl Blocks {
    /// From S_XᵀKS_Y of two arms.
    fn of([a, b]: &[Side; 2], between: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Block) -> Self {
        let own = [a, b].map(|side| if side.body.is_some() { between(&side.arm, &side.arm) } else { Block::zeros() });
        let across = if a.body.and(b.body).is_some() { -between(&a.arm, &b.arm) } else { Block::zeros() };
        Self { own, across, of: None }
    }

    /// Makes them anew where rows of that weight and shape would make others.
    pub fn update(&mut self, shape: &Shape, weight: f64, made: impl FnOnce() -> Self) {
        if shape.is_springy || self.of != Some((*shape, weight)) {
            *self = Self { of: Some((*shape, weight)), ..made() };
        }
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
    across: [f64; 2],
    /// Then it is not all that the stiffness is made of.
    is_springy: bool,
}

impl Shape {
    /// Whether the same rows act in so nearly the same place that the factor will do.
    pub fn is_nearly(&self, other: &Self) -> bool {
        let size = self.arms[1].norm_squared();
        let squared = (0..2).map(|side| (self.arms[side] - other.arms[side]).norm_squared());
        let levers = (0..POINTS).map(|point| (self.levers[point] - other.levers[point]).norm_squared());
        let moved = squared.chain(levers).fold(size * (self.normal - other.normal).norm_squared(), f64::max);
        self.acts == other.acts
            && self.gives == other.gives
            && self.across == other.across
            && moved <= MOVED * MOVED * size
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
    /// What friction is bounded by, N·s: μ times what the points push.
    limit: f64,
    /// Where it slides: a unit along the tangents across the friction, times the root of how much of the
    /// stiffness is left across it.
    across: [f64; 2],
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
        (self.slides, self.twists, self.across) = (before.slides, before.twists, before.across);
    }

    /// Goes on from what a substep of length `h`, s, did, with the geometry that it has: points part as they moved.
    pub fn go_on(&mut self, motion: &Motion, h: f64) {
        let Self { normal, points, count, .. } = self;
        for point in &mut points[..*count] {
            point.separation += (normal.dot(&motion.linear) + point.lever.dot(&motion.angular)) * h;
            point.expected = point.impulse;
        }
        self.expected = self.friction;
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
            across: if self.slides { self.across } else { [0.0; 2] },
            is_springy: false,
        }
    }

    /// JᵀKJ for rows of that weight.
    pub fn blocks(&self, weight: f64) -> Blocks {
        let stiffness = self.stiffness(weight);
        Blocks::of(&self.sides, |x, y| stiffness.between(x, y))
    }

    /// K for rows of that weight.
    pub(super) fn stiffness(&self, weight: f64) -> Stiffness {
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
        let mut uu = Matrix3::from_diagonal_element(across) + square * (pressed - across);
        if self.slides {
            let turned = self.tangents[0] * self.across[0] + self.tangents[1] * self.across[1];
            uu += turned * turned.transpose() * weight;
        }
        Stiffness { uu, uw: normal * lever.transpose(), ww }
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

    /// Impulse on B that closes a share of the depths, by the rows that act in a factor.
    pub fn correction(&self, factored: &Shape, weight: f64, closing: &Closing) -> Motion {
        let mut impulse = Motion::default();
        let acting = self.points[..self.count].iter().zip(factored.acts).filter(|(_, acts)| *acts);
        for (point, _) in acting {
            let depth = (-point.separation - self.touching).max(0.0);
            let push = weight * depth * closing.rate(depth);
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
        let stuck = self.friction_if_stuck(motion, weight);
        let [x, y, twist] = self.friction;
        let [across_x, across_y] = self.across;
        // To first order about where it slid: friction turns with the slip.
        let turned = across_x * stuck[0] + across_y * stuck[1];
        let along = if self.slides { [x + across_x * turned, y + across_y * turned] } else { [stuck[0], stuck[1]] };
        [along[0], along[1], if self.twists { twist } else { stuck[2] }]
    }

    /// Takes in the motion that was solved for. False if some row turned out other than was assumed, by more than a
    /// `slight` impulse, N·s.
    pub fn take(&mut self, motion: &Motion, weight: f64, per_step: f64, slight: f64) -> bool {
        let pushes: [f64; POINTS] = std::array::from_fn(|index| {
            if index < self.count { self.push_of(&self.points[index], motion, weight, per_step) } else { 0.0 }
        });
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
        // What a row that does not act yet will push is not known.
        let pressed: f64 = self.points[..self.count].iter().map(|point| point.impulse).sum();
        self.limit = self.coefficient * pressed;
        let trial = self.friction_if_stuck(motion, weight);
        let friction = self.bounded(trial);
        let bound = |most: f64, gives: bool| if gives { most } else { most + slight };
        let slides = length(trial[0], trial[1]) > bound(self.limit, self.slides);
        let twists = trial[2].abs() > bound(self.limit * self.radius, self.twists);
        let moved = |row: usize| (friction[row] - self.friction[row]).abs();
        holds &= slides == self.slides && twists == self.twists;
        holds &= !slides || moved(0).max(moved(1)) <= slight;
        holds &= !twists || moved(2) <= slight * self.radius;
        (self.slides, self.twists, self.friction) = (slides, twists, friction);
        let size = length(trial[0], trial[1]);
        let left = if slides && size > 0.0 { (self.limit / size).sqrt() / size } else { 0.0 };
        self.across = [-trial[1] * left, trial[0] * left];
        holds
    }

    fn friction_if_stuck(&self, motion: &Motion, weight: f64) -> [f64; 3] {
        let [slip_x, slip_y] = self.tangents.map(|tangent| tangent.dot(&motion.linear));
        let twist = weight * self.radius * self.radius * self.normal.dot(&motion.angular);
        [self.expected[0] - weight * slip_x, self.expected[1] - weight * slip_y, self.expected[2] - twist]
    }

    /// The nearest that the limit admits.
    fn bounded(&self, [x, y, twist]: [f64; 3]) -> [f64; 3] {
        let size = length(x, y);
        let shrink = if size > self.limit { self.limit / size } else { 1.0 };
        let most = self.limit * self.radius;
        [x * shrink, y * shrink, twist.clamp(-most, most)]
    }

    /// Impulse on B at a motion, of rows that act as they must there, friction within the limit at hand.
    pub fn impulse_at(&self, motion: &Motion, weight: f64, per_step: f64) -> Motion {
        let mut impulse = Motion::default();
        for point in &self.points[..self.count] {
            let push = self.push_of(point, motion, weight, per_step).max(0.0);
            impulse.linear += self.normal * push;
            impulse.angular += point.lever * push;
        }
        if self.coefficient != 0.0 {
            let [x, y, twist] = self.bounded(self.friction_if_stuck(motion, weight));
            impulse.linear += self.tangents[0] * x + self.tangents[1] * y;
            impulse.angular += self.normal * twist;
        }
        impulse
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

/// A ball joint that is a spring: λ = −W (u + b), its norm within a limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spring {
    /// W, N·s over m/s.
    pub weight: Matrix3<f64>,
    /// b, m/s.
    pub bias: Vector3<f64>,
    /// Largest norm, N·s.
    pub limit: f64,
    /// Whether it pushes all it may, and what.
    is_spent: bool,
    push: Vector3<f64>,
}

impl Spring {
    pub fn new(weight: Matrix3<f64>, bias: Vector3<f64>, limit: f64) -> Self {
        Self { weight, bias, limit, ..Self::default() }
    }

    /// Takes over from the substep before whether it pushes all it may.
    pub fn resume(&mut self, before: &Self) {
        (self.is_spent, self.push) = (before.is_spent, before.push);
    }

    fn impulse_at(&self, motion: &Motion) -> Vector3<f64> {
        if self.is_spent { self.push } else { self.trial(motion) }
    }

    fn trial(&self, motion: &Motion) -> Vector3<f64> {
        -(self.weight * (motion.linear + self.bias))
    }

    /// Within the limit, whatever was assumed.
    fn bounded(&self, motion: &Motion) -> Vector3<f64> {
        bounded(self.trial(motion), self.limit)
    }

    /// Takes in the motion that was solved for. False if it turned out to push other than was assumed, by more than
    /// a `slight` impulse.
    fn take(&mut self, motion: &Motion, slight: f64) -> bool {
        let (was_spent, before) = (self.is_spent, self.push);
        self.is_spent = self.trial(motion).norm() > self.limit;
        self.push = self.bounded(motion);
        self.is_spent == was_spent && (!was_spent || (self.push - before).amax() <= slight)
    }
}

/// A ball joint.
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
    /// Of its rows, where it is rigid, kg.
    pub weight: f64,
    /// None: rigid.
    pub spring: Option<Spring>,
}

impl Link {
    /// JᵀKJ.
    pub fn blocks(&self) -> Blocks {
        match &self.spring {
            None => Blocks::of(&self.sides, |x, y| isotropic(self.weight, x, y)),
            Some(spring) if spring.is_spent => Blocks::default(),
            Some(spring) => {
                let stiffness = Stiffness { uu: spring.weight, uw: Matrix3::zeros(), ww: Matrix3::zeros() };
                Blocks::of(&self.sides, |x, y| stiffness.between(x, y))
            }
        }
    }

    /// What K is made of.
    pub fn shape(&self) -> Shape {
        let none = Vector3::zeros();
        Shape {
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: [none; POINTS],
            acts: [true; POINTS],
            gives: [self.spring.is_some_and(|spring| spring.is_spent), false],
            across: [0.0; 2],
            is_springy: self.spring.is_some(),
        }
    }

    /// Impulse on B at a motion.
    pub fn impulse_at(&self, motion: &Motion) -> Vector3<f64> {
        match &self.spring {
            None => self.expected - motion.linear * self.weight,
            Some(spring) => spring.impulse_at(motion),
        }
    }

    /// Impulse on B at a motion, whatever was assumed.
    pub fn bounded_at(&self, motion: &Motion) -> Motion {
        let linear = self.spring.map_or_else(|| self.impulse_at(motion), |spring| spring.bounded(motion));
        Motion { linear, ..Motion::default() }
    }

    /// Takes in the motion that was solved for; see [`Patch::take`].
    pub fn take(&mut self, motion: &Motion, slight: f64) -> bool {
        let holds = self.spring.as_mut().is_none_or(|spring| spring.take(motion, slight));
        self.impulse = self.impulse_at(motion);
        holds
    }
}

/// As `hypot`, which guards against overflow at ten times the cost.
fn length(x: f64, y: f64) -> f64 {
    x.mul_add(x, y * y).sqrt()
}
