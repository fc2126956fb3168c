//! The bodies of one group as the impulse methods see them.
//!
//! Rotations are *whitened*: with the body's inverse inertia I⁻¹ = W Wᵀ in world axes at the start
//! of the step, the solver keeps ψ with ω = W ψ instead of ω. A row with angular part j then reads
//! j·ω = (Wᵀj)·ψ, and an impulse λ along it changes ψ by (Wᵀj) λ: the same three numbers are
//! Jacobian and response, which halves what a row must load. Linear velocities stay as they are,
//! since their response M⁻¹ n is one scaling away. Geometry is that of the start of the step, so
//! that moves within it, d = Σ h v and θ' = Σ h ψ, are seen by the same rows to first order.
//!
//! What turning by itself does to the angular velocity of a body that is not round comes at the start, in the body's axes:
//! Euler's equations over the step. In its axes it stays, too, while the body turns: ω goes along with all of its rotation,
//! that out of errors included. So its energy ½ ω·Iω changes by impulses alone, which take some. Were ω left as it was in the
//! world, or taken to the axes of free rotation before impulses are known, a capsule that spins at 28 rad/s on ice would have
//! four times its energy after 3 s.
//!
//! A body that constraints do not move has W = 2⁻⁴⁰: its ω reaches the rows (a power of two
//! rounds nothing), and what the rows give back is lost in rounding.
#![allow(unsafe_code)]

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::constants::{FRAME_SPEED, FRAME_TURN, UNMOVED_WHITENING};
use crate::physics::body::free_rotation::{free_step, wobbles};
use crate::physics::body::{Body, RigidBody};
use crate::physics::lanes::{Lanes, READ_ONLY, Record, WIDTH, add_scaled, dot, vector};
use crate::physics::scalar::Scalar;
use crate::physics::threads::{Claims, Shared};

/// Records of a body's frame: the rotation that rows of contacts are made for by columns, W by columns, inverse mass,
/// the turn from that rotation to the present one.
const FRAME: usize = 3;

/// The bodies of a group, own ones first, guests after.
#[derive(Clone, Default)]
pub(crate) struct GroupBodies<S> {
    velocity: Vec<Record<S>>,
    displacement: Vec<Record<S>>,
    kick: Vec<Record<S>>,
    carried: Vec<Record<S>>,
    start: Vec<Record<S>>,
    keep: Vec<Record<S>>,
    frames: Vec<Record<S>>,
    traced: Vec<Record<S>>,
    positions: Vec<Vector3<f64>>,
    whitening: Vec<Matrix3<f64>>,
    /// Of bodies, and of the records of frames.
    claims: [Claims; 2],
}

/// W and its inverse on what can turn.
fn whitening(body: &Body) -> (Matrix3<f64>, Matrix3<f64>) {
    let unmoved = body.inverse_inertia_body == Vector3::zeros();
    if body.kind != RigidBody::Dynamic || unmoved {
        return (
            Matrix3::from_diagonal_element(UNMOVED_WHITENING),
            Matrix3::from_diagonal_element(1.0 / UNMOVED_WHITENING),
        );
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
    let is_slow = body.has_stepped && body.angular.norm() < FRAME_SPEED;
    let is_kept = body.kind == RigidBody::Dynamic && is_slow && turn.norm() < FRAME_TURN;
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
        for records in [
            &mut self.velocity,
            &mut self.displacement,
            &mut self.kick,
            &mut self.carried,
            &mut self.start,
            &mut self.keep,
        ] {
            records.resize(count, Record::default());
        }
        self.frames.resize(count * FRAME, Record::default());
        self.positions.resize(count, Vector3::zeros());
        self.whitening.resize(count, Matrix3::zeros());
    }

    /// Handles on all of it; `traces`: what sweeps change is followed.
    pub fn share(&mut self, traces: bool) -> SharedBodies<'_, S> {
        self.traced.resize(if traces { self.velocity.len() } else { 0 }, Record::default());
        let [of_bodies, of_frames] = &mut self.claims;
        of_bodies.cover(self.velocity.len());
        SharedBodies {
            velocity: Shared::with(&mut self.velocity, of_bodies),
            displacement: Shared::with(&mut self.displacement, of_bodies),
            kick: Shared::with(&mut self.kick, of_bodies),
            carried: Shared::with(&mut self.carried, of_bodies),
            start: Shared::with(&mut self.start, of_bodies),
            keep: Shared::with(&mut self.keep, of_bodies),
            traced: Shared::with(&mut self.traced, of_bodies),
            frames: Shared::new(&mut self.frames, of_frames),
            positions: Shared::with(&mut self.positions, of_bodies),
            whitening: Shared::with(&mut self.whitening, of_bodies),
        }
    }
}

/// The bodies of a group, worked on by several threads.
#[derive(Clone, Copy)]
pub(crate) struct SharedBodies<'a, S> {
    /// v, ψ.
    velocity: Shared<'a, Record<S>>,
    /// d, θ' since the start of the step.
    displacement: Shared<'a, Record<S>>,
    /// What external forces add to v, ψ in a substep.
    kick: Shared<'a, Record<S>>,
    /// What the impulses of the last substep added, all of it.
    carried: Shared<'a, Record<S>>,
    /// v, ψ at the start of the substep, external forces included.
    start: Shared<'a, Record<S>>,
    /// Factors on v, ψ for drag.
    keep: Shared<'a, Record<S>>,
    /// v, ψ when they were last traced; of none unless somebody reads that.
    traced: Shared<'a, Record<S>>,
    /// [`FRAME`] records each.
    frames: Shared<'a, Record<S>>,
    /// Centres of mass at the start of the step.
    positions: Shared<'a, Vector3<f64>>,
    /// W, to come back from ψ.
    whitening: Shared<'a, Matrix3<f64>>,
}

impl<'a, S: Scalar + Default> SharedBodies<'a, S> {
    /// The body of that index, for this thread.
    ///
    /// # Safety
    /// While it lives, nobody else may read or write that body.
    pub unsafe fn claim(&self, index: usize) -> ClaimedBody<'_, 'a, S> {
        ClaimedBody { bodies: self, index }
    }

    /// The bodies of a block, for this thread.
    ///
    /// # Safety
    /// While it lives, nobody else may read or write bodies that are not [`READ_ONLY`], nor write those that are.
    #[inline(always)]
    pub unsafe fn claim_pairs<L: Lanes<Scalar = S>>(&self, ends: Ends) -> ClaimedPairs<'_, 'a, L> {
        ClaimedPairs { bodies: self, ends }
    }

    /// Centre of B less centre of A, m, at the start of the step; [`READ_ONLY`] flags do not matter.
    ///
    /// # Safety
    /// Nobody may be writing the two.
    pub unsafe fn offset(&self, a: u32, b: u32) -> Vector3<f64> {
        // SAFETY: as the caller promises.
        let [a, b] = [a, b].map(|body| unsafe { self.positions.read((body & !READ_ONLY) as usize) });
        b - a
    }
}

/// One body of a group, for one thread.
pub(crate) struct ClaimedBody<'b, 'a, S> {
    bodies: &'b SharedBodies<'a, S>,
    index: usize,
}

impl<S: Scalar + Default> ClaimedBody<'_, '_, S> {
    fn get<T: Copy>(&self, list: Shared<T>) -> T {
        // SAFETY: nobody else has the body, as whoever claimed it promised.
        unsafe { list.read(self.index) }
    }

    fn set<T>(&mut self, list: Shared<T>, value: T) {
        // SAFETY: nobody else has the body, as whoever claimed it promised.
        unsafe { *list.element(self.index) = value }
    }

    fn set_frame(&mut self, records: [Record<S>; FRAME]) {
        for (place, record) in records.into_iter().enumerate() {
            // SAFETY: nobody else has the body, as whoever claimed it promised.
            unsafe { *self.bodies.frames.element(self.index * FRAME + place) = record }
        }
    }

    /// Takes a body in, for a `step` of substeps of length `h`.
    pub fn gather(&mut self, body: &Body, step: f64, h: f64) {
        let (to_spin, to_psi) = whitening(body);
        let linear_kick = body.inverse_mass.component_mul(&body.force) * h;
        let angular_kick =
            if body.kind == RigidBody::Dynamic { to_spin.tr_mul(&body.torque) * h } else { Vector3::zeros() };
        let Body { rotation, angular, inverse_inertia_body, rotation_freedom, .. } = body;
        let turned = free_step(rotation, angular, inverse_inertia_body, rotation_freedom, step);
        let angular = turned.map_or(*angular, |turned| rotation * turned.angular);
        let (linear_drag, angular_drag) = body.drag;
        let keep = |drag: f64| Vector3::repeat(1.0 / (1.0 + drag * h));
        let SharedBodies { velocity, displacement, carried, .. } = *self.bodies;
        self.set(velocity, record(&body.linear, &(to_psi * angular)));
        self.set(displacement, Record::default());
        self.set(carried, Record::default());
        self.set(self.bodies.kick, record(&linear_kick, &angular_kick));
        self.set(self.bodies.keep, record(&keep(linear_drag), &keep(angular_drag)));
        self.set(self.bodies.positions, body.position);
        self.set(self.bodies.whitening, to_spin);
        let (frame, turned) = frame_of(body);
        let axes = frame.to_rotation_matrix().into_inner();
        let mut numbers = [S::of(0.0); FRAME * WIDTH];
        let all = axes.iter().chain(to_spin.iter()).chain(body.inverse_mass.iter()).chain(turned.iter());
        for (number, &value) in numbers.iter_mut().zip(all) {
            *number = S::of(value);
        }
        let (records, _) = numbers.as_chunks::<WIDTH>();
        self.set_frame(std::array::from_fn(|place| Record(records[place])));
    }

    /// Forces act, and in all but the first substep the impulses of the last one again. Impulses along rows
    /// that do not turn within a step add to the same change of velocity each time, so that no row need be read.
    pub fn begin_substep(&mut self, is_first: bool) {
        let SharedBodies { velocity, start, kick, carried, .. } = *self.bodies;
        let (mut now, kick) = (self.get(velocity), self.get(kick));
        (0..WIDTH).for_each(|lane| now.0[lane] += kick.0[lane]);
        self.set(start, now);
        if !is_first {
            let carried = self.get(carried);
            (0..WIDTH).for_each(|lane| now.0[lane] += carried.0[lane]);
        }
        self.set(velocity, now);
    }

    /// Positions follow velocities.
    pub fn drift(&mut self, h: S) {
        let SharedBodies { velocity, displacement, .. } = *self.bodies;
        let (mut moved, velocity) = (self.get(displacement), self.get(velocity));
        (0..WIDTH).for_each(|lane| moved.0[lane] += velocity.0[lane] * h);
        self.set(displacement, moved);
    }

    /// The same where bodies bounce: what no impulse touched in the substep moves freely, and goes by the mean of its
    /// velocities, which keeps its energy.
    pub fn drift_freely(&mut self, h: S) {
        let SharedBodies { velocity, displacement, start, kick, .. } = *self.bodies;
        if self.get(velocity) == self.get(start) {
            let (mut moved, kick, half) = (self.get(displacement), self.get(kick), S::of(0.5 * h.to_f64()));
            (0..WIDTH).for_each(|lane| moved.0[lane] -= kick.0[lane] * half);
            self.set(displacement, moved);
        }
        self.drift(h);
    }

    /// Remembers what this substep's impulses added, then drag acts.
    pub fn end_substep(&mut self) {
        let SharedBodies { velocity, start, keep, carried, .. } = *self.bodies;
        let (mut now, mut change) = (self.get(velocity), self.get(velocity));
        let (start, keep) = (self.get(start), self.get(keep));
        for lane in 0..WIDTH {
            change.0[lane] -= start.0[lane];
            now.0[lane] *= keep.0[lane];
        }
        self.set(carried, change);
        self.set(velocity, now);
    }

    /// How much the velocity of a point of the body, which is of that bounding radius, m, may have changed since this was
    /// asked last, m/s.
    pub fn change(&mut self, radius: f64) -> f64 {
        let SharedBodies { velocity, traced, whitening, .. } = *self.bodies;
        let (now, before) = (self.get(velocity), self.get(traced));
        self.set(traced, now);
        let half =
            |first: usize| Vector3::from_fn(|axis, _| now.0[first + axis].to_f64() - before.0[first + axis].to_f64());
        half(0).norm() + radius * (self.get(whitening) * half(3)).norm()
    }

    /// Writes the state at the end of the step to a body.
    pub fn scatter(&self, body: &mut Body) {
        let (velocity, moved) = (self.get(self.bodies.velocity), self.get(self.bodies.displacement));
        let to_spin = self.get(self.bodies.whitening);
        let half = |record: &Record<S>, first: usize| Vector3::from_fn(|axis, _| record.0[first + axis].to_f64());
        (body.frame, _) = frame_of(body);
        body.linear = half(&velocity, 0);
        body.angular = to_spin * half(&velocity, 3);
        body.has_stepped = true;
        let wobbles = wobbles(&body.inverse_inertia_body, &body.rotation_freedom);
        let spin = wobbles.then(|| body.rotation.inverse_transform_vector(&body.angular));
        body.advance(&half(&moved, 0), &(to_spin * half(&moved, 3)));
        if let Some(spin) = spin {
            body.angular = body.rotation * spin;
        }
    }
}

/// The bodies A and B of each pair of a block, by their indices in the group, [`READ_ONLY`] flagged.
pub(crate) type Ends = [[u32; WIDTH]; 2];

/// Numbers of the bodies A and B of each pair of a block.
pub(crate) type PairRecords<L> = [[L; WIDTH]; 2];

/// The bodies of a block's pairs, for one thread.
pub(crate) struct ClaimedPairs<'b, 'a, L: Lanes> {
    bodies: &'b SharedBodies<'a, L::Scalar>,
    ends: Ends,
}

impl<L: Lanes> ClaimedPairs<'_, '_, L> {
    /// v, ψ.
    #[inline(always)]
    pub fn velocities(&self) -> PairRecords<L> {
        self.gather(self.bodies.velocity)
    }

    #[inline(always)]
    pub fn set_velocities(&mut self, records: PairRecords<L>) {
        self.scatter(self.bodies.velocity, records);
    }

    /// d, θ' since the start of the step.
    #[inline(always)]
    pub fn displacements(&self) -> PairRecords<L> {
        self.gather(self.bodies.displacement)
    }

    #[inline(always)]
    pub fn set_displacements(&mut self, records: PairRecords<L>) {
        self.scatter(self.bodies.displacement, records);
    }

    /// The frames of A's and of B's.
    #[inline(always)]
    pub fn frames(&self) -> [Frames<L>; 2] {
        [self.frame(0), self.frame(1)]
    }

    /// Written where it is to stand: both at once would be copied.
    fn frame(&self, end: usize) -> Frames<L> {
        let places = |place: u32| self.ends[end].map(|body| (body & !READ_ONLY) * FRAME as u32 + place);
        let records = |place| {
            // SAFETY: nobody writes what the claim covers, as whoever made it promised.
            unsafe { L::gather(self.bodies.frames, &places(place)) }
        };
        Frames::new(&records(0), &records(1), &records(2))
    }

    #[inline(always)]
    fn gather(&self, list: Shared<Record<L::Scalar>>) -> PairRecords<L> {
        let places = |bodies: &[u32; WIDTH]| bodies.map(|body| body & !READ_ONLY);
        let [a, b] = &self.ends;
        // SAFETY: nobody writes what the claim covers, as whoever made it promised.
        unsafe { [L::gather(list, &places(a)), L::gather(list, &places(b))] }
    }

    #[inline(always)]
    fn scatter(&mut self, list: Shared<Record<L::Scalar>>, [a, b]: PairRecords<L>) {
        // SAFETY: nobody else has what the claim covers, as whoever made it promised.
        unsafe {
            L::scatter(a, list, &self.ends[0]);
            L::scatter(b, list, &self.ends[1]);
        }
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
    fn new(one: &[L; WIDTH], two: &[L; WIDTH], three: &[L; WIDTH]) -> Self {
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
