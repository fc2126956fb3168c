//! The bodies of one group as the impulse methods see them.
//!
//! Rotations are *whitened*: with the body's inverse inertia I⁻¹ = W Wᵀ in world axes at the start
//! of the step, the solver keeps ψ with ω = W ψ instead of ω. A row with angular part j then reads
//! j·ω = (Wᵀj)·ψ, and an impulse λ along it changes ψ by (Wᵀj) λ: the same three numbers are
//! Jacobian and response, which halves what a row must load. Linear velocities stay as they are,
//! since their response M⁻¹ n is one scaling away. Geometry is that of the start of the step, so
//! that moves within it, d = Σ h v and θ' = Σ h ψ, are seen by the same rows to first order.
//!
//! A body that constraints do not move has W = 2⁻⁴⁰: its ω reaches the rows (a power of two
//! rounds nothing), and what the rows give back is lost in rounding.
#![allow(unsafe_code)]

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::physics::body::Body;
use crate::physics::body::RigidBody;
use crate::physics::body::free_rotation::free_rotation;
use crate::physics::lanes::{Lanes, READ_ONLY, Record, WIDTH, add_scaled, dot, vector};
use crate::physics::scalar::Scalar;
use crate::physics::threads::Shared;

/// W of what constraints do not move.
const UNMOVED: f64 = 1.0 / (1_u64 << 40) as f64;

/// Turn in a step beyond which a body that is held or touched is left without gyroscopic torque, rad: by then its
/// inertia at the start of the step says too little of that at the end, and energy could come of it.
const FAST: f64 = 0.5;

/// Turn up to which a body keeps the frame that rows of contacts were made for, rad; see [`crate::physics::solver::impulse::soft_step`].
const KEPT: f64 = 0.01;

/// Angular speed up to which it does, rad/s: what leans for being soft does so slowly, and what turns by itself keeps
/// its angular momentum only in the frame that it has.
const SLOW: f64 = 0.1;

/// Records of a body's frame: the rotation that rows of contacts are made for by columns, W by columns, inverse mass,
/// the turn from that rotation to the present one.
const FRAME: usize = 3;

/// The bodies of a group, own ones first, guests after.
#[derive(Default)]
pub(crate) struct GroupBodies<S> {
    /// v, ψ.
    velocity: Vec<Record<S>>,
    /// d, θ' since the start of the step.
    moved: Vec<Record<S>>,
    /// What external forces add to v, ψ in a substep.
    kick: Vec<Record<S>>,
    /// What the impulses of the last substep added, all of it.
    carried: Vec<Record<S>>,
    /// v, ψ at the start of the substep, external forces included.
    start: Vec<Record<S>>,
    /// Factors on v, ψ for drag.
    keep: Vec<Record<S>>,
    /// [`FRAME`] records each.
    frames: Vec<Record<S>>,
    /// Centres of mass at the start of the step.
    positions: Vec<Vector3<f64>>,
    /// W, to come back from ψ.
    whitening: Vec<Matrix3<f64>>,
}

/// W and its inverse on what can turn.
fn whitening(body: &Body) -> (Matrix3<f64>, Matrix3<f64>) {
    let unmoved = body.inverse_inertia_body == Vector3::zeros();
    if body.kind != RigidBody::Dynamic || unmoved {
        return (Matrix3::from_diagonal_element(UNMOVED), Matrix3::from_diagonal_element(1.0 / UNMOVED));
    }
    let root = body.inverse_inertia_body.map(f64::sqrt);
    let (to_spin, to_psi) = if root.x == root.y && root.y == root.z {
        (Matrix3::from_diagonal_element(root.x), Matrix3::from_diagonal_element(1.0 / root.x))
    } else {
        let axes = body.rotation.to_rotation_matrix().into_inner();
        let scaled = |scale: Vector3<f64>| axes * Matrix3::from_diagonal(&scale) * axes.transpose();
        (scaled(root), scaled(root.map(f64::recip)))
    };
    if body.rotation_freedom == Vector3::repeat(1.0) {
        (to_spin, to_psi)
    } else {
        (Matrix3::from_diagonal(&body.rotation_freedom) * to_spin, to_psi)
    }
}

/// The rotation that rows of contacts are made for, the one they were made for before unless the body has turned
/// from there, and the turn from it to the present one.
fn frame_of(body: &Body) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let turn = turn_between(&body.frame, &body.rotation);
    let is_slow = body.has_stepped && body.angular.norm() < SLOW;
    let is_kept = body.kind == RigidBody::Dynamic && is_slow && turn.norm() < KEPT;
    if is_kept { (body.frame, turn) } else { (body.rotation, Vector3::zeros()) }
}

/// A small turn from one rotation to another, world axes, rad.
fn turn_between(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> Vector3<f64> {
    let turn = from.rotation_to(to);
    turn.imag() * 2.0_f64.copysign(turn.w)
}

fn record<S: Scalar>(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Record<S> {
    let zero = S::of(0.0);
    Record([
        S::of(linear.x),
        S::of(linear.y),
        S::of(linear.z),
        S::of(angular.x),
        S::of(angular.y),
        S::of(angular.z),
        zero,
        zero,
    ])
}

impl<S: Scalar + Default> GroupBodies<S> {
    /// Makes room for so many bodies.
    pub fn resize(&mut self, count: usize) {
        for records in
            [&mut self.velocity, &mut self.moved, &mut self.kick, &mut self.carried, &mut self.start, &mut self.keep]
        {
            records.resize(count, Record::default());
        }
        self.frames.resize(count * FRAME, Record::default());
        self.positions.resize(count, Vector3::zeros());
        self.whitening.resize(count, Matrix3::zeros());
    }

    /// Handles on all of it.
    pub fn share(&mut self) -> SharedBodies<'_, S> {
        SharedBodies {
            velocity: Shared::new(&mut self.velocity),
            moved: Shared::new(&mut self.moved),
            kick: Shared::new(&mut self.kick),
            carried: Shared::new(&mut self.carried),
            start: Shared::new(&mut self.start),
            keep: Shared::new(&mut self.keep),
            frames: Shared::new(&mut self.frames),
            positions: Shared::new(&mut self.positions),
            whitening: Shared::new(&mut self.whitening),
        }
    }
}

/// The bodies of a group, worked on by several threads.
#[derive(Clone, Copy)]
pub(crate) struct SharedBodies<'a, S> {
    /// v, ψ.
    pub velocity: Shared<'a, Record<S>>,
    /// d, θ' since the start of the step.
    pub moved: Shared<'a, Record<S>>,
    kick: Shared<'a, Record<S>>,
    carried: Shared<'a, Record<S>>,
    start: Shared<'a, Record<S>>,
    keep: Shared<'a, Record<S>>,
    /// [`FRAME`] records each.
    pub frames: Shared<'a, Record<S>>,
    /// Centres of mass at the start of the step.
    pub positions: Shared<'a, Vector3<f64>>,
    whitening: Shared<'a, Matrix3<f64>>,
}

/// All that is done to one body. To each, nobody else may be using the body of that index.
impl<S: Scalar + Default> SharedBodies<'_, S> {
    /// Takes a body in, for a `step` of substeps of length `h`. What turning in the step does to the angular
    /// velocity of a body that is not round is done at once.
    ///
    /// # Safety
    /// Nobody else may be using the record of that index.
    pub unsafe fn gather(self, index: usize, body: &Body, step: f64, h: f64) {
        let (to_spin, to_psi) = whitening(body);
        let push = body.inverse_mass.component_mul(&body.force) * h;
        let turn = if body.kind == RigidBody::Dynamic { to_spin.tr_mul(&body.torque) * h } else { Vector3::zeros() };
        let turns_fast = body.angular.norm() * step > FAST;
        let Body { rotation, angular, inverse_inertia_body, rotation_freedom, .. } = body;
        let turned = if turns_fast {
            None
        } else {
            free_rotation(rotation, angular, inverse_inertia_body, rotation_freedom, step)
        };
        let angular = turned.map_or(body.angular, |(angular, _)| angular);
        let (linear_drag, angular_drag) = body.drag;
        let keep = |drag: f64| Vector3::repeat(1.0 / (1.0 + drag * h));
        // SAFETY: as the caller promises.
        unsafe {
            *self.velocity.element(index) = record(&body.linear, &(to_psi * angular));
            *self.moved.element(index) = Record::default();
            *self.carried.element(index) = Record::default();
            *self.kick.element(index) = record(&push, &turn);
            *self.keep.element(index) = record(&keep(linear_drag), &keep(angular_drag));
            *self.positions.element(index) = body.position;
            *self.whitening.element(index) = to_spin;
        }
        let (frame, turned) = frame_of(body);
        let axes = frame.to_rotation_matrix().into_inner();
        let mut numbers = [S::of(0.0); FRAME * WIDTH];
        let all = axes.iter().chain(to_spin.iter()).chain(body.inverse_mass.iter()).chain(turned.iter());
        for (number, &value) in numbers.iter_mut().zip(all) {
            *number = S::of(value);
        }
        let (records, _) = numbers.as_chunks::<WIDTH>();
        for (place, &numbers) in records.iter().enumerate() {
            // SAFETY: as the caller promises.
            unsafe { *self.frames.element(index * FRAME + place) = Record(numbers) };
        }
    }

    /// Forces act, and every constraint pushes as it did in the last substep. Impulses along rows
    /// that do not turn within a step add to the same change of velocity each time, so that no row
    /// need be looked at.
    ///
    /// # Safety
    /// Nobody else may be using the record of that index.
    pub unsafe fn begin_substep(self, index: usize, is_first: bool) {
        // SAFETY: as the caller promises.
        let (velocity, start) = unsafe { (self.velocity.element(index), self.start.element(index)) };
        // SAFETY: as the caller promises.
        let (kick, carried) = unsafe { (self.kick.get(index), self.carried.get(index)) };
        for lane in 0..WIDTH {
            let free = velocity.0[lane] + kick.0[lane];
            start.0[lane] = free;
            velocity.0[lane] = if is_first { free } else { free + carried.0[lane] };
        }
    }

    /// Positions follow velocities.
    ///
    /// # Safety
    /// Nobody else may be using the record of that index.
    pub unsafe fn drift(self, index: usize, h: S) {
        // SAFETY: as the caller promises.
        let (moved, velocity) = unsafe { (self.moved.element(index), self.velocity.get(index)) };
        for lane in 0..WIDTH {
            moved.0[lane] += velocity.0[lane] * h;
        }
    }

    /// Remembers what this substep's impulses added, then drag acts.
    ///
    /// # Safety
    /// Nobody else may be using the record of that index.
    pub unsafe fn end_substep(self, index: usize) {
        // SAFETY: as the caller promises.
        let (velocity, carried) = unsafe { (self.velocity.element(index), self.carried.element(index)) };
        // SAFETY: as the caller promises.
        let (start, keep) = unsafe { (self.start.get(index), self.keep.get(index)) };
        for lane in 0..WIDTH {
            carried.0[lane] = velocity.0[lane] - start.0[lane];
            velocity.0[lane] *= keep.0[lane];
        }
    }

    /// Writes the state at the end of the step to a body.
    ///
    /// # Safety
    /// Nobody may be writing the record of that index.
    pub unsafe fn scatter(self, index: usize, body: &mut Body) {
        // SAFETY: as the caller promises.
        let (velocity, moved) = unsafe { (self.velocity.get(index), self.moved.get(index)) };
        // SAFETY: as the caller promises.
        let to_spin = unsafe { self.whitening.get(index) };
        let part = |record: &Record<S>, first: usize| Vector3::from_fn(|axis, _| record.0[first + axis].to_f64());
        (body.frame, _) = frame_of(body);
        body.linear = part(velocity, 0);
        body.angular = to_spin * part(velocity, 3);
        body.has_stepped = true;
        body.advance(&part(moved, 0), &(to_spin * part(moved, 3)));
    }
}

/// The frame of a body in each lane.
pub(crate) struct Frames<L: Lanes> {
    axes: [Vector3<L>; 3],
    whitening: [Vector3<L>; 3],
    pub inverse_mass: Vector3<L>,
    /// From the axes to those of now, rad.
    turned: Vector3<L>,
}

impl<L: Lanes> Frames<L> {
    /// Takes them in.
    ///
    /// # Safety
    /// Nobody may be writing them.
    pub unsafe fn gather(frames: Shared<Record<L::Scalar>>, bodies: &[u32; WIDTH]) -> Self {
        let part = |index: u32| {
            let places = bodies.map(|body| (body & !READ_ONLY) * FRAME as u32 + index);
            // SAFETY: as the caller promises.
            unsafe { L::gather(frames, &places) }
        };
        let (one, two, three) = (part(0), part(1), part(2));
        Self {
            axes: [vector(&one[0..]), vector(&one[3..]), Vector3::new(one[6], one[7], two[0])],
            whitening: [vector(&two[1..]), vector(&two[4..]), Vector3::new(two[7], three[0], three[1])],
            inverse_mass: vector(&three[2..]),
            turned: vector(&three[5..]),
        }
    }

    /// From body to world axes.
    pub fn turn(&self, v: &Vector3<L>) -> Vector3<L> {
        add_scaled(&add_scaled(&(self.axes[0] * v.x), &self.axes[1], v.y), &self.axes[2], v.z)
    }

    /// To where a vector of the frame has turned by now, to second order: its error is a sixth of the third power.
    pub fn turn_on(&self, v: &Vector3<L>) -> Vector3<L> {
        v + self.turned.cross(&(v + self.turned.cross(v) * L::of(0.5)))
    }

    /// Wᵀ v.
    pub fn whiten(&self, v: &Vector3<L>) -> Vector3<L> {
        Vector3::new(dot(&self.whitening[0], v), dot(&self.whitening[1], v), dot(&self.whitening[2], v))
    }

    /// n·M⁻¹n.
    pub fn inverse_mass_along(&self, n: &Vector3<L>) -> L {
        dot(&self.inverse_mass.component_mul(n), n)
    }
}
