//! Rows between two bodies as the direct solver sees them.
//!
//! A constraint has up to six coordinates, told as a [`Twist`]: its relative motion S_B V_B − S_A V_A and, dual to it,
//! its impulse, a [`Wrench`]. Most constraints see the relative motion at one point, where body X, with the arm r from
//! its centre of mass, moves with u = v + ω × r and turns with w = ω; then S_X = (1, −[r]ₓ; 0, 1). Each row is
//! a spring-damper of a penalty ρ (impulse over speed) about the impulse λ̂ of the step before: λ = λ̂ − ρ (row + b), an
//! augmented Lagrangian (Hestenes 1969; Powell 1969), which at rest is exact whatever the penalty. All rows of a
//! constraint add S_XᵀKS_Y to the matrix, K their [`Stiffness`].

use nalgebra::{ArrayStorage, Matrix3, Vector3};

use super::constants::{ARM_CHANGE, CURVING_TURNS};
use crate::physics::body::Body;
use crate::physics::collision::POINTS;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::solver::linear::{BodyBlock, BodyVector};

/// A constraint's rows.
pub(super) trait Rows {
    fn sides(&self) -> &[Side; 2];

    /// S_X V_X of one side.
    fn motion_of(&self, side: usize, velocity: &BodyVector) -> Twist<f64> {
        self.sides()[side].motion(velocity)
    }

    /// S_Xᵀ times an impulse.
    fn wrench_on(&self, side: usize, impulse: &Wrench<f64>) -> BodyVector {
        self.sides()[side].wrench(impulse)
    }

    /// Relative motion that bodies without a place among those that move give.
    fn prescribed(&self) -> &Twist<f64>;

    /// Whether some row may have an impulse with what is assumed of them.
    fn acts(&self) -> bool {
        true
    }

    /// What the stiffness is made of.
    fn key(&self) -> RowKey;

    /// What the active rows add to the matrix.
    fn blocks(&self, blocks: &mut RowBlocks);

    /// Impulse on B of the active rows where nothing moves but what is prescribed.
    fn impulse_at_rest(&self) -> Wrench<f64>;

    /// Impulse on B at a relative motion, whichever rows are active there.
    fn impulse_at(&self, motion: &Twist<f64>) -> Wrench<f64>;

    /// Takes in the relative motion that was solved for, and which rows are active at it. False if that, or what the
    /// rows were assumed to do, turned out wrong by more than an impulse of `tolerance`, N·s.
    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool;

    /// Impulse on B that corrects position errors, by the rows that are active in a factor of that key.
    fn correction(&self, factored: &RowKey, correction: &Correction) -> Wrench<f64>;
}

/// One body of a constraint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    /// Its place among those that move.
    pub body: Option<u32>,
    /// From the centre of mass.
    pub arm: Vector3<f64>,
}

impl Side {
    /// Its motion for the velocity of its body.
    pub fn motion(&self, velocity: &BodyVector) -> Twist<f64> {
        let (linear, angular) = halves(velocity);
        Twist { linear: linear + angular.cross(&self.arm), angular }
    }

    /// What an impulse is to its body.
    pub fn wrench(&self, impulse: &Wrench<f64>) -> BodyVector {
        body_vector(&impulse.linear, &(self.arm.cross(&impulse.linear) + impulse.angular))
    }
}

/// Share of J̇V that a substep of length `h`, s, takes in: less where a body turns so far in it that what is of second
/// order in its turn no longer tells where it gets to, and would feed it energy instead.
pub(super) fn curving_share(bodies: [&Body; 2], h: f64) -> f64 {
    let [most, none] = CURVING_TURNS;
    let turn = bodies.map(|body| body.angular.norm() * h).into_iter().fold(0.0, f64::max);
    ((none - turn) / (none - most)).clamp(0.0, 1.0)
}

pub(super) fn body_vector(linear: &Vector3<f64>, angular: &Vector3<f64>) -> BodyVector {
    BodyVector::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// Linear and angular.
pub(super) fn halves(vector: &BodyVector) -> (Vector3<f64>, Vector3<f64>) {
    (vector.fixed_rows::<3>(0).into_owned(), vector.fixed_rows::<3>(3).into_owned())
}

/// How fast position errors are corrected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correction {
    /// Of depths and of gaps, 1/s.
    pub rates: [f64; 2],
    /// Largest speeds, m/s.
    pub speeds: [f64; 2],
}

impl Correction {
    /// Speed over a depth of that size, 1/s.
    pub fn of_depth(&self, depth: f64) -> f64 {
        self.rate(0, depth)
    }

    /// Speed over a gap of that size, 1/s.
    pub fn of_gap(&self, gap: f64) -> f64 {
        self.rate(1, gap)
    }

    fn rate(&self, kind: usize, error: f64) -> f64 {
        let (rate, speed) = (self.rates[kind], self.speeds[kind]);
        if error * rate > speed { speed / error } else { rate }
    }
}

/// K of rows at a point: what they add to impulses for relative velocities and spins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffness {
    pub uu: Matrix3<f64>,
    pub uw: Matrix3<f64>,
    pub ww: Matrix3<f64>,
}

impl Stiffness {
    /// S_XᵀKS_Y for arms of two sides.
    pub fn between(&self, x: &Vector3<f64>, y: &Vector3<f64>) -> BodyBlock {
        let (x, y) = (x.cross_matrix(), y.cross_matrix());
        let right = self.uw - self.uu * y;
        let left = self.uw.transpose() + x * self.uu;
        let turn = x * right + self.ww - self.uw.tr_mul(&y);
        let (upper, lower) = ([&self.uu, &right], [&left, &turn]);
        BodyBlock::from_fn(|row, column| {
            let half = if row < 3 { &upper } else { &lower };
            half[column / 3][(row % 3, column % 3)]
        })
    }
}

/// S_XᵀKS_Y of K_uu = w alone: w (1, −[y]ₓ; [x]ₓ, (x·y) 1 − y xᵀ).
pub(super) fn isotropic(w: f64, x: &Vector3<f64>, y: &Vector3<f64>) -> BodyBlock {
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
    BodyBlock::from_data(ArrayStorage(block))
}

/// What a constraint's rows add to the matrix, as they were when it was last made of them.
#[derive(Clone, Debug, Default)]
pub(super) struct RowBlocks {
    /// Of A and B, each with itself.
    pub own: [BodyBlock; 2],
    /// A's rows, B's columns.
    pub across: BodyBlock,
    key: Option<RowKey>,
}

impl RowBlocks {
    /// Sets them from S_XᵀKS_Y of two sides that stand where those do.
    pub fn set<S>(&mut self, sides: &[Side; 2], [a, b]: [&S; 2], between: impl Fn(&S, &S) -> BodyBlock) {
        let [moves_a, moves_b] = [0, 1].map(|side| sides[side].body.is_some());
        let block = |is_there: bool, x, y| if is_there { between(x, y) } else { BodyBlock::zeros() };
        self.own = [block(moves_a, a, a), block(moves_b, b, b)];
        self.across = -block(moves_a && moves_b, a, b);
    }

    /// From S_XᵀKS_Y of two arms.
    pub fn set_at_arms(&mut self, sides: &[Side; 2], between: impl Fn(&Vector3<f64>, &Vector3<f64>) -> BodyBlock) {
        self.set(sides, sides.each_ref().map(|side| &side.arm), between);
    }

    /// Makes them anew where rows of that key would make others.
    pub fn update(&mut self, key: &RowKey, make: impl FnOnce(&mut Self)) {
        if key.is_soft || self.key != Some(*key) {
            make(self);
            self.key = Some(*key);
        }
    }
}

/// What the stiffness of a constraint's rows is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowKey {
    pub penalty: f64,
    /// Penalty of friction, where it has one of its own; else 0.
    pub friction: f64,
    pub arms: [Vector3<f64>; 2],
    pub normal: Vector3<f64>,
    pub levers: [Vector3<f64>; POINTS],
    /// Which rows are active, a bit each.
    pub active: u32,
    pub across: [f64; 2],
    /// Then it is not all that the stiffness is made of.
    pub is_soft: bool,
    /// How often the rows were made, where that is not all either; a factor may serve for another.
    pub revision: u32,
}

/// A bit for each that is so.
pub(super) fn bits(are: impl IntoIterator<Item = bool>) -> u32 {
    are.into_iter().enumerate().fold(0, |bits, (index, is)| bits | u32::from(is) << index)
}

impl RowKey {
    /// Whether the same rows are active in so nearly the same place that a factor of one serves for the other.
    pub fn is_nearly(&self, other: &Self) -> bool {
        let is_same = self.active == other.active && self.across == other.across && self.friction == other.friction;
        if !is_same {
            return false;
        }
        let size = self.arms[1].norm_squared();
        let squared = (0..2).map(|side| (self.arms[side] - other.arms[side]).norm_squared());
        let levers = (0..POINTS).map(|point| (self.levers[point] - other.levers[point]).norm_squared());
        let moved = squared.chain(levers).fold(size * (self.normal - other.normal).norm_squared(), f64::max);
        moved <= ARM_CHANGE * ARM_CHANGE * size
    }
}
