//! What needs no order among links, four at a time in the lanes of a register: where a substep takes their bodies, and how
//! far their joints are then apart.
//!
//! A body with two equal moments turns as [`free_rotation`](crate::physics::body::free_rotation) has it, in world axes. With
//! u = hω, e its axis, κ = ½ (I_axis/I_across − 1) u·e and w the part of u across e, the mean is
//!
//! hω̄ = (u·e) e + (w + κ e × w)/(1 + κ²),
//!
//! and as momentum and the spin about e stay what they are, ω⁺ = ω + (I_axis/I_across − 1) (ω·e) (e − e⁺).

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use simba::simd::{SimdComplexField, SimdPartialOrd, SimdRealField, SimdValue, WideF64x4};

use super::super::world::inertia_at;
use super::inertia::Articulated;
use super::link::{NONE, TreeJoint};
use crate::physics::body::Body;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::JointHolds;
use crate::physics::solver::exact::MemberState;

/// Links in a register.
pub(super) const FOUR: usize = 4;

pub(super) type Lane = WideF64x4;
type Vector = Vector3<Lane>;
type Rotation = UnitQuaternion<Lane>;

#[inline(always)]
pub(super) fn all(value: f64) -> Lane {
    Lane::splat(value)
}

/// One of them, read from where they lie: [`SimdValue::extract`] goes by a copy of all four.
#[inline(always)]
pub(super) fn at(v: &Vector, lane: usize) -> Vector3<f64> {
    Vector3::new(v.x.0.as_array()[lane], v.y.0.as_array()[lane], v.z.0.as_array()[lane])
}

/// Sets one of them.
#[inline(always)]
fn set(v: &mut Vector, lane: usize, value: &Vector3<f64>) {
    for (lanes, &value) in v.iter_mut().zip(value) {
        lanes.0.as_mut_array()[lane] = value;
    }
}

#[inline(always)]
fn rotation_at(rotation: &Rotation, lane: usize) -> UnitQuaternion<f64> {
    let [i, j, k, w] = [0, 1, 2, 3].map(|part| rotation.coords[part].0.as_array()[lane]);
    UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k))
}

/// Turns, rad, under which tan x and x are one.
const SMALL_TURN: f64 = 1e-9;

/// A symmetric matrix: its diagonal, and yz, zx, xy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Symmetric {
    diagonal: Vector,
    off: Vector,
}

impl Symmetric {
    fn splat(value: Lane) -> Self {
        Self { diagonal: Vector::repeat(value), off: zero() }
    }

    /// Adds a share of a aᵀ.
    #[inline(always)]
    fn add_outer(&mut self, a: &Vector, share: Lane) {
        let scaled = a * share;
        self.diagonal += scaled.component_mul(a);
        self.off += Vector::new(scaled.y * a.z, scaled.z * a.x, scaled.x * a.y);
    }

    /// Adds a share of a·a 1 − a aᵀ.
    #[inline(always)]
    fn add_across(&mut self, a: &Vector, share: Lane) {
        let along = a.dot(a) * share;
        self.diagonal += Vector::repeat(along);
        self.add_outer(a, -share);
    }

    #[inline(always)]
    fn times(&self, v: &Vector) -> Vector {
        let Self { diagonal, off } = self;
        let mixed = Vector::new(off.z * v.y + off.y * v.z, off.z * v.x + off.x * v.z, off.y * v.x + off.x * v.y);
        diagonal.component_mul(v) + mixed
    }

    /// One of them.
    #[inline(always)]
    fn at(&self, lane: usize) -> Matrix3<f64> {
        let (d, o) = (at(&self.diagonal, lane), at(&self.off, lane));
        Matrix3::new(d.x, o.z, o.y, o.z, d.y, o.x, o.y, o.x, d.z)
    }

    #[inline(always)]
    fn replace(&mut self, lane: usize, matrix: &Matrix3<f64>) {
        set(&mut self.diagonal, lane, &matrix.diagonal());
        set(&mut self.off, lane, &Vector3::new(matrix.m32, matrix.m31, matrix.m21));
    }
}

/// How four bodies answer forces, and the forces.
#[derive(Clone, Debug)]
pub(super) struct MassFour {
    mass: Lane,
    force: Vector,
    torque: Vector,
    inverse_inertia: Vector,
    /// The greatest inverse moments.
    pub greatest: [f64; FOUR],
    /// e, body axes.
    axis: Vector,
    /// I_across, kg m², and I_axis/I_across − 1.
    across: Lane,
    ratio: Lane,
    /// Those with three equal moments, whose turn is exact; those with three that differ, which go one by one.
    round: [bool; FOUR],
    uneven: [bool; FOUR],
}

impl MassFour {
    pub fn new(bodies: [&Body; FOUR]) -> Self {
        let inverse = bodies.map(|body| body.inverse_inertia_body);
        let axis_of = |i: &Vector3<f64>| (0..3).find(|&axis| i[(axis + 1) % 3] == i[(axis + 2) % 3]);
        let axes = inverse.map(|inverse| axis_of(&inverse));
        let across = [0, 1, 2, 3].map(|lane: usize| 1.0 / inverse[lane][axes[lane].map_or(0, |axis| (axis + 1) % 3)]);
        let ratio = |lane: usize| axes[lane].map_or(0.0, |axis| 1.0 / (inverse[lane][axis] * across[lane]) - 1.0);
        let round = |lane: usize| axes[lane].is_some() && inverse[lane].max() == inverse[lane].min();
        Self {
            mass: Lane::from(bodies.map(|body| body.mass)),
            force: Vector::from(bodies.map(|body| body.force)),
            torque: Vector::from(bodies.map(|body| body.torque)),
            inverse_inertia: Vector::from(inverse),
            greatest: inverse.map(|inverse| inverse.max()),
            axis: Vector::from(axes.map(|axis| Vector3::ith(axis.unwrap_or(0), 1.0))),
            across: Lane::from(across),
            ratio: Lane::from([0, 1, 2, 3].map(ratio)),
            round: [0, 1, 2, 3].map(round),
            uneven: axes.map(|axis| axis.is_none()),
        }
    }

    /// World inertias of bodies that stand so.
    #[inline(always)]
    fn inertia(&self, bodies: &BodyFour) -> Symmetric {
        let mut inertia = Symmetric::splat(self.across);
        inertia.add_outer(&bodies.axis, self.across * self.ratio);
        for lane in (0..FOUR).filter(|&lane| self.uneven[lane]) {
            let (rotation, inverse) = (bodies.rotation.extract(lane), self.inverse_inertia.extract(lane));
            inertia.replace(lane, &inertia_at(&rotation, &inverse));
        }
        inertia
    }
}

/// What four bodies do in a piece.
#[derive(Clone, Debug)]
pub(super) struct WorkFour {
    /// About their centres of mass, world axes, with stiffness.
    inertia: Symmetric,
    /// Of forces, and what stiffness takes.
    impulse: Wrench<Lane>,
    velocity: Twist<Lane>,
    /// About the points of their links: m r, inertia and impulse.
    moment: Vector,
    turning: Symmetric,
    momentum: Wrench<Lane>,
}

impl WorkFour {
    /// Of bodies that stand so, with forces that act for `kick`, s, but for stiffness.
    #[inline(always)]
    pub fn begin(masses: &MassFour, bodies: &BodyFour, kick: f64) -> Self {
        let time = all(kick);
        let impulse = Wrench { linear: masses.force * time, angular: masses.torque * time };
        let inertia = masses.inertia(bodies);
        Self { inertia, impulse, velocity: bodies.velocity, moment: zero(), turning: inertia, momentum: impulse }
    }

    /// Adds the stiffness of a pull along those arms over |r|², N/m, of which bodies that turn so take so many times h², s²,
    /// and lose so many.
    #[inline(always)]
    pub fn stiffen(&mut self, arm: &Vector, shares: &[[f64; 2]], pull: Lane, omega: &Vector) {
        let [added, lost] = [0, 1].map(|which| Lane::from([0, 1, 2, 3].map(|lane: usize| shares[lane][which])) * pull);
        self.inertia.add_across(arm, added);
        self.impulse.angular -= (omega * arm.dot(arm) - arm * arm.dot(omega)) * lost;
    }

    /// The same of one of them.
    #[inline(always)]
    pub fn stiffen_one(&mut self, lane: usize, arm: &Vector3<f64>, [added, lost]: [f64; 2], omega: &Vector3<f64>) {
        let square = arm.norm_squared();
        let across = Matrix3::from_diagonal_element(square) - arm * arm.transpose();
        let inertia = self.inertia.at(lane) + across * added;
        self.inertia.replace(lane, &inertia);
        let angular = at(&self.impulse.angular, lane) - (omega * square - arm * arm.dot(omega)) * lost;
        set(&mut self.impulse.angular, lane, &angular);
    }

    /// Goes over to the points at the ends of those arms.
    #[inline(always)]
    pub fn set_about(&mut self, masses: &MassFour, arm: &Vector) {
        self.moment = arm * masses.mass;
        self.turning = self.inertia;
        self.turning.add_across(arm, masses.mass);
        let Wrench { linear, angular } = self.impulse;
        self.momentum = Wrench { linear, angular: angular - arm.cross(&linear) };
    }

    /// Adds one of them to what its link holds.
    #[inline(always)]
    pub fn add_to(&self, masses: &MassFour, lane: usize, inertia: &mut Articulated, momentum: &mut Wrench<f64>) {
        let mass = masses.mass.0.as_array()[lane];
        for axis in 0..3 {
            inertia.mass[(axis, axis)] += mass;
        }
        inertia.mixed += at(&self.moment, lane).cross_matrix();
        inertia.turning += self.turning.at(lane);
        momentum.linear += at(&self.momentum.linear, lane);
        momentum.angular += at(&self.momentum.angular, lane);
    }

    /// Takes in how their links move, whose points stand at the ends of those arms, and hands out where that takes the
    /// bodies in h, s.
    #[inline(always)]
    pub fn advance(
        &mut self,
        masses: &MassFour,
        start: &BodyFour,
        arm: &Vector,
        motion: Twist<Lane>,
        h: f64,
    ) -> BodyFour {
        self.velocity.linear += motion.linear - motion.angular.cross(arm);
        self.velocity.angular += motion.angular;
        start.drift(masses, self.velocity, h)
    }

    /// What the bodies took of the impulses on their links besides forces that act for `kick`, s, about their points, N and
    /// N·m.
    #[inline(always)]
    pub fn load(&self, masses: &MassFour, start: &BodyFour, arm: &Vector, kick: f64) -> Wrench<Lane> {
        let rate = all(1.0 / kick);
        let gained = self.velocity.plus(&start.velocity, all(-1.0));
        let linear = (gained.linear * masses.mass - self.impulse.linear) * rate;
        let angular = (self.inertia.times(&gained.angular) - self.impulse.angular) * rate - arm.cross(&linear);
        Wrench { linear, angular }
    }
}

/// Four bodies.
#[derive(Clone, Debug)]
pub(super) struct BodyFour {
    pub position: Vector,
    pub rotation: Rotation,
    pub velocity: Twist<Lane>,
    /// e, world axes.
    pub axis: Vector,
}

impl BodyFour {
    /// Where bodies are, that turn so; nothing is known of partners.
    pub fn of(states: [&MemberState; FOUR], masses: Option<&MassFour>) -> Self {
        let rotation = Rotation::from(states.map(|state| state.rotation));
        Self {
            position: Vector::from(states.map(|state| state.position)),
            rotation,
            velocity: velocities(states.map(MemberState::twist)),
            axis: masses.map_or_else(zero, |masses| rotation * masses.axis),
        }
    }

    /// One of them.
    #[inline(always)]
    pub fn state(&self, lane: usize) -> MemberState {
        let Twist { linear, angular } = &self.velocity;
        let (position, rotation) = (at(&self.position, lane), rotation_at(&self.rotation, lane));
        MemberState { position, rotation, linear: at(linear, lane), angular: at(angular, lane) }
    }

    /// Where h, s, takes them with those velocities.
    #[inline(always)]
    pub fn drift(&self, masses: &MassFour, velocity: Twist<Lane>, h: f64) -> Self {
        let (time, half, one) = (all(h), all(0.5), all(1.0));
        let omega = velocity.angular;
        let spin = self.axis.dot(&omega);
        let turn = omega * time;
        let along = self.axis * (spin * time);
        let across = turn - along;
        let kappa = masses.ratio * spin * time * half;
        let mut mean = (along + (across + self.axis.cross(&across) * kappa) / (one + kappa * kappa)) * half;
        if masses.round != [false; FOUR] {
            mean *= exact_share(masses, &mean);
        }
        let Quaternion { coords } = self.rotation.into_inner();
        let (imaginary, real) = (coords.xyz(), coords.w);
        let turned = imaginary + mean * real + mean.cross(&imaginary);
        let real = real - mean.dot(&imaginary);
        let scale = one / (turned.dot(&turned) + real * real).simd_sqrt();
        let turned = turned * scale;
        let rotation = Rotation::new_unchecked(Quaternion::from_parts(real * scale, turned));
        let axis = rotation * masses.axis;
        let angular = omega + (self.axis - axis) * (masses.ratio * spin);
        let position = self.position + velocity.linear * time;
        let mut end = Self { position, rotation, velocity: Twist { linear: velocity.linear, angular }, axis };
        if masses.uneven != [false; FOUR] {
            end.turn_uneven(masses, &self.rotation, &omega, h);
        }
        end
    }

    /// The turns of those that go one by one.
    #[inline(never)]
    fn turn_uneven(&mut self, masses: &MassFour, rotation: &Rotation, omega: &Vector, h: f64) {
        for lane in (0..FOUR).filter(|&lane| masses.uneven[lane]) {
            let (mut rotation, mut omega) = (rotation.extract(lane), omega.extract(lane));
            turn_freely(&mut rotation, &mut omega, &masses.inverse_inertia.extract(lane), &Vector3::repeat(1.0), h);
            rotation.renormalize_fast();
            self.rotation.replace(lane, rotation);
            self.velocity.angular.replace(lane, omega);
        }
    }
}

fn zero() -> Vector {
    Vector::repeat(all(0.0))
}

pub(super) fn velocities(twists: [Twist<f64>; FOUR]) -> Twist<Lane> {
    Twist { linear: Vector::from(twists.map(|twist| twist.linear)), angular: Vector::from(twists.map(|t| t.angular)) }
}

/// tan x / x of the round bodies, with x half the turn, and 1 of the others: (1, x) is then along the exact turn.
#[inline(never)]
fn exact_share(masses: &MassFour, half_turn: &Vector) -> Lane {
    let half = half_turn.dot(half_turn).simd_sqrt();
    let share = |lane: usize| match half.extract(lane) {
        x if masses.round[lane] && x > SMALL_TURN => x.tan() / x,
        _ => 1.0,
    };
    Lane::from([0, 1, 2, 3].map(share))
}

/// Where the halves of four links are.
#[derive(Clone, Debug)]
pub(super) struct PoseFour {
    /// From the centres of mass of child and parent.
    pub arms: [Vector; 2],
    /// d, from the parent's point to the child's.
    pub gap: Vector,
    /// n, the child's axis.
    pub axis: Vector,
    /// θ.
    pub tilt: Vector,
}

impl PoseFour {
    /// The largest gap or tilt, m or rad.
    #[inline(always)]
    pub fn error(&self) -> Lane {
        let largest = |v: &Vector| v.x.simd_abs().simd_max(v.y.simd_abs()).simd_max(v.z.simd_abs());
        largest(&self.gap).simd_max(largest(&self.tilt))
    }
}

/// Four links, in the axes of their bodies: child, then parent.
#[derive(Clone, Debug)]
pub(super) struct LinkFour {
    anchors: [Vector; 2],
    axes: [Vector; 2],
    rotations: [Rotation; 2],
    /// 1 where it is a hinge, and where it holds all; 0 elsewhere.
    hinged: Lane,
    rigid: Lane,
    has_rigid: bool,
    /// Places of the parents among the bodies in the tree's order.
    pub parents: [u32; FOUR],
    /// 1/|r|² of the arms, 1/m², and forces along them over |r|² that pull, N/m.
    reaches: [Lane; 2],
    pub pulls: [Lane; 2],
    /// The links of which their children are the parents: the first of each, [`NONE`] where there is none, and others, with
    /// the place among the four.
    pub first_children: [u32; FOUR],
    pub later_children: Vec<(usize, u32)>,
    /// What it is to change.
    pub bias: Twist<Lane>,
    /// What was left to it after the prediction of the last piece, over h².
    pub lag: Twist<Lane>,
}

impl LinkFour {
    /// Of joints whose side of that index is nearer to the root; where there is none, nothing is held.
    pub fn new(joints: [Option<(&TreeJoint, usize)>; FOUR], parents: [u32; FOUR]) -> Self {
        // Child and parent.
        let of = |side: usize| {
            joints.map(|joint| match joint {
                Some((joint, parent)) => {
                    let end = if side == 0 { 1 - parent } else { parent };
                    (joint.anchors[end], joint.rotations[end])
                }
                None => (Vector3::zeros(), UnitQuaternion::identity()),
            })
        };
        let sides = [of(0), of(1)];
        let holds = |which: JointHolds| {
            Lane::from(joints.map(|joint| f64::from(u8::from(joint.is_some_and(|(joint, _)| joint.holds == which)))))
        };
        let anchors = sides.map(|side| Vector::from(side.map(|(anchor, _)| anchor)));
        let reach = |(anchor, _): (Vector3<f64>, _)| match anchor.norm_squared() {
            0.0 => 0.0,
            square => 1.0 / square,
        };
        let (none, rigid) = (Twist { linear: zero(), angular: zero() }, holds(JointHolds::All));
        Self {
            anchors,
            reaches: sides.map(|side| Lane::from(side.map(reach))),
            pulls: [all(0.0); 2],
            first_children: [NONE; FOUR],
            later_children: Vec::new(),
            axes: sides.map(|side| Vector::from(side.map(|(_, rotation)| rotation * Vector3::x()))),
            rotations: sides.map(|side| Rotation::from(side.map(|(_, rotation)| rotation))),
            hinged: holds(JointHolds::Axis),
            rigid,
            has_rigid: (0..FOUR).any(|lane| rigid.extract(lane) > 0.0),
            parents,
            bias: none,
            lag: none,
        }
    }

    /// A link that hangs on the child of one of them.
    pub fn add_child(&mut self, lane: usize, link: u32) {
        match &mut self.first_children[lane] {
            first if *first == NONE => *first = link,
            _ => self.later_children.push((lane, link)),
        }
    }

    /// What was left to it is not known.
    pub fn forget(&mut self) {
        self.lag = Twist { linear: zero(), angular: zero() };
    }

    /// What one of them is to change.
    #[inline(always)]
    pub fn bias_at(&self, lane: usize) -> Twist<f64> {
        Twist { linear: at(&self.bias.linear, lane), angular: at(&self.bias.angular, lane) }
    }

    /// Of the bodies in the tree's order.
    #[inline(always)]
    fn at_parents<T>(&self, bodies: &[BodyFour], of: impl Fn(&BodyFour, usize) -> T) -> [T; FOUR] {
        self.parents.map(|place| of(&bodies[place as usize / FOUR], place as usize % FOUR))
    }

    /// Where they are: `children` are their own, among `bodies` their parents.
    #[inline(always)]
    pub fn look(&self, children: &BodyFour, bodies: &[BodyFour]) -> PoseFour {
        let position = Vector::from(self.at_parents(bodies, |body, lane| at(&body.position, lane)));
        let rotation = Rotation::from(self.at_parents(bodies, |body, lane| rotation_at(&body.rotation, lane)));
        let arms = [children.rotation * self.anchors[0], rotation * self.anchors[1]];
        let gap = children.position - position + arms[0] - arms[1];
        let axis = children.rotation * self.axes[0];
        let mut tilt = (rotation * self.axes[1]).cross(&axis) * self.hinged;
        if self.has_rigid {
            let turn = (children.rotation * self.rotations[0]) * (rotation * self.rotations[1]).inverse();
            let nearer = all(2.0).simd_copysign(turn.w);
            tilt += turn.imag() * (nearer * self.rigid);
        }
        PoseFour { arms, gap, axis, tilt }
    }

    /// Takes in the forces on the children. The pull along the arms of children and parents, N.
    #[inline(always)]
    pub fn pull(&mut self, pose: &PoseFour, force: &Vector) -> [Lane; 2] {
        let none = all(0.0);
        let [child, parent] = &pose.arms;
        let along = [child.dot(force).simd_max(none), (-parent.dot(force)).simd_max(none)];
        self.pulls = [along[0] * self.reaches[0], along[1] * self.reaches[1]];
        along
    }

    /// The arm of the parent of one of them, m, and the pull along it over |r|², N/m.
    #[inline(always)]
    pub fn pull_on_parent(&self, pose: &PoseFour, lane: usize) -> (Vector3<f64>, f64) {
        (at(&pose.arms[1], lane), self.pulls[1].0.as_array()[lane])
    }

    /// c from the velocities when the piece begins.
    #[inline(always)]
    pub fn predict(&mut self, pose: &PoseFour, children: &BodyFour, bodies: &[BodyFour], h: f64) {
        let linear = Vector::from(self.at_parents(bodies, |body, lane| at(&body.velocity.linear, lane)));
        let angular = Vector::from(self.at_parents(bodies, |body, lane| at(&body.velocity.angular, lane)));
        let [arm_child, arm_parent] = &pose.arms;
        let own = &children.velocity;
        let [swing_child, swing_parent] = [own.angular.cross(arm_child), angular.cross(arm_parent)];
        let parting = own.linear + swing_child - linear - swing_parent;
        let swirl = own.angular.cross(&swing_child) - angular.cross(&swing_parent);
        let turning = own.angular - angular;
        let (half, rate) = (all(0.5 * h), all(1.0 / h));
        let bias = Twist {
            linear: -(parting + pose.gap * rate + swirl * half),
            angular: -(turning + pose.tilt * rate + turning.cross(&angular) * half),
        };
        self.bias = bias.plus(&self.lag, all(h * h));
    }

    /// c from what a piece of length h, s, left.
    #[inline(always)]
    pub fn mend(&mut self, end: &PoseFour, h: f64) {
        let rate = all(-1.0 / h);
        self.bias = Twist { linear: end.gap * rate, angular: end.tilt * rate };
        self.lag = self.lag.plus(&self.bias, all(1.0 / (h * h)));
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::Entity;

    use super::*;
    use crate::physics::testing::Random;

    /// Moments that all differ, that are equal about each axis, that are all equal.
    #[test]
    fn four_at_once_turn_as_one_by_one() {
        let mut random = Random::new(1);
        let moments = [[1.0, 2.0, 2.7], [0.3, 2.0, 2.0], [2.0, 3.5, 2.0], [2.0, 2.0, 0.1], [1.7, 1.7, 1.7]];
        for first in 0..moments.len() {
            let bodies = [0, 1, 2, 3].map(|lane| Body {
                mass: 2.0,
                inverse_inertia_body: Vector3::from(moments[(first + lane) % moments.len()]).map(f64::recip),
                ..Body::new(Entity::PLACEHOLDER)
            });
            let states = bodies.each_ref().map(|_| MemberState {
                position: random.vector(),
                rotation: random.rotation(),
                linear: random.vector(),
                angular: random.vector() * 20.0,
            });
            let masses = MassFour::new(bodies.each_ref());
            let starts = BodyFour::of(states.each_ref(), Some(&masses));
            let h = 0.03;
            let ends = starts.drift(&masses, starts.velocity, h);
            let inertia = masses.inertia(&starts);
            for (lane, (state, body)) in states.iter().zip(&bodies).enumerate() {
                let (mut rotation, mut angular) = (state.rotation, state.angular);
                let known = inertia_at(&rotation, &body.inverse_inertia_body);
                assert!((inertia.at(lane) - known).amax() < 1e-14, "inertia {}", inertia.at(lane));
                turn_freely(&mut rotation, &mut angular, &body.inverse_inertia_body, &Vector3::repeat(1.0), h);
                let end = ends.state(lane);
                let turn = end.rotation * rotation.inverse();
                let (turned, spin) = (2.0 * turn.imag().norm(), (end.angular - angular).norm());
                assert!(turned < 1e-13 && spin < 1e-12, "body {first} + {lane}: {turned:e} rad, {spin:e} rad/s");
                assert_eq!(end.position, state.position + state.linear * h);
            }
        }
    }
}
