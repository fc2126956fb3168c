//! Contacts of as many pairs as there are lanes: up to four points that push, and friction of the
//! patch as a whole.
//!
//! With n from A to B, r the arms from the centres of mass to the point and W the bodies'
//! whitening, a point's row is v_n = n·(v_B − v_A) + j_B·ψ_B − j_A·ψ_A, j = Wᵀ(r × n). One update,
//! with the effective mass m = 1/(n·M_A⁻¹n + n·M_B⁻¹n + |j_A|² + |j_B|²), is
//!
//! λ ← max(0, λ − m σ (v_n + bias) − ι λ).
//!
//! Soft contact (Catto 2011, 2024): a spring of frequency f and damping ratio ζ, integrated
//! implicitly over a substep h, comes to bias = ω s/(2ζ + hω), σ = a/(1 + a), ι = 1/(1 + a) with
//! ω = 2πf, a = hω(2ζ + hω), where s < 0 is the separation. Across a gap, s > 0, bias = s/h lets
//! the point close it and no more. To relax is to solve with bias, ι = 0 and σ = 1: it takes out of
//! the velocity what the spring put in.
//!
//! Separations are those of the start of the step plus n·(d_B − d_A) + j_B·θ'_B − j_A·θ'_A: the
//! same row again. Normals and arms are those of the frames that bodies keep for a little turn; arms end halfway
//! between the two points, at the same place where no body has turned.
//!
//! Friction acts at the middle of the patch along two tangents, solved together, with |λ_t| ≤ μ Σ λ
//! (a disc, not a square), and as a twist about n with |λ_τ| ≤ μ ρ Σ λ, ρ the mean distance of the
//! points from the middle.
#![allow(unsafe_code)]

use nalgebra::{SimdBool, Vector3};

use super::bodies::Frames;
use super::stage::Sweep;
use crate::physics::collision::{ContactGeometry, GEOMETRY, POINTS};
use crate::physics::lanes::{Lanes, READ_ONLY, Record, WIDTH, add_scaled, dot, inverse, vector};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms};
use crate::physics::threads::Shared;

/// Rounds of points and friction in one update. The second costs no memory and lets points and friction of a patch
/// agree: columns rock a third as much.
const ROUNDS: usize = 2;

/// One point of each pair.
#[derive(Clone, Copy, Debug)]
struct Point<L: Lanes> {
    angular_a: Vector3<L>,
    angular_b: Vector3<L>,
    separation: L,
    mass: L,
    /// Effective mass when relaxed: 0 where the surfaces are still apart.
    relaxed: L,
    impulse: L,
}

/// What a point's spring asks for: λ changes by −m σ (v_n + bias) − ι λ.
#[derive(Clone, Copy, Debug)]
struct Spring<L> {
    bias: L,
    /// m σ.
    mass: L,
    /// ι.
    kept: L,
    /// m when relaxed, if nothing is pushed.
    relaxed: L,
}

/// Friction of the patch.
#[derive(Clone, Copy, Debug)]
struct Friction<L: Lanes> {
    angular_a: [Vector3<L>; 2],
    angular_b: [Vector3<L>; 2],
    /// Inverse of the 2 × 2 block: xx, xy, yy.
    mass: [L; 3],
    impulse: [L; 2],
    twist_a: Vector3<L>,
    twist_b: Vector3<L>,
    twist_mass: L,
    twist_impulse: L,
    /// ρ.
    radius: L,
}

/// Contacts of [`Lanes::COUNT`] pairs that share no body that moves.
#[derive(Clone, Debug)]
pub(crate) struct ContactBlock<L: Lanes> {
    a: [u32; WIDTH],
    b: [u32; WIDTH],
    normal: Vector3<L>,
    tangents: [Vector3<L>; 2],
    inverse_mass_a: Vector3<L>,
    inverse_mass_b: Vector3<L>,
    coefficient: L,
    points: [Point<L>; POINTS],
    point_count: usize,
    friction: Option<Friction<L>>,
}

/// What contact carried: four points, two tangents, twist, N·s.
pub(crate) type ContactImpulses = Record<f32>;

/// One pair as a block takes it in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSite<'a> {
    /// Indices into the group's bodies, [`READ_ONLY`] flagged.
    pub a: u32,
    pub b: u32,
    pub geometry: &'a ContactGeometry,
    pub impulses: &'a ContactImpulses,
    /// Centre of B less centre of A, m.
    pub apart: Vector3<f64>,
}

/// The arms of a point.
struct Arms<L: Lanes> {
    a: Vector3<L>,
    b: Vector3<L>,
}

impl<L: Lanes> ContactBlock<L> {
    /// One that does nothing.
    pub fn idle() -> Self {
        let (zero, none) = (L::zero(), Vector3::repeat(L::zero()));
        let point =
            Point { angular_a: none, angular_b: none, separation: zero, mass: zero, relaxed: zero, impulse: zero };
        Self {
            a: [READ_ONLY; WIDTH],
            b: [READ_ONLY; WIDTH],
            normal: none,
            tangents: [none; 2],
            inverse_mass_a: none,
            inverse_mass_b: none,
            coefficient: zero,
            points: [point; POINTS],
            point_count: 0,
            friction: None,
        }
    }

    /// Takes in at most [`Lanes::COUNT`] pairs. Lanes left over do nothing.
    ///
    /// # Safety
    /// Nobody may be writing the frames.
    pub unsafe fn new(sites: &[ContactSite], frames: Shared<Record<L::Scalar>>) -> Self {
        let frictional = sites.iter().any(|site| site.geometry.friction() > 0.0);
        let site = |lane: usize| &sites[lane.min(sites.len() - 1)];
        let mut a: [u32; WIDTH] = std::array::from_fn(|lane| site(lane).a);
        let mut b: [u32; WIDTH] = std::array::from_fn(|lane| site(lane).b);
        for lane in sites.len()..WIDTH {
            a[lane] |= READ_ONLY;
            b[lane] |= READ_ONLY;
        }
        let apart = Vector3::from_fn(|axis, _| L::each(|lane| <L::Scalar as Scalar>::of(site(lane).apart[axis])));
        let geometry: [[L; WIDTH]; GEOMETRY] =
            std::array::from_fn(|record| L::take(std::array::from_fn(|lane| &site(lane).geometry.records[record])));
        let impulses = L::take(std::array::from_fn(|lane| site(lane).impulses));
        let used = L::each(|lane| <L::Scalar as Scalar>::of(if lane < sites.len() { 1.0 } else { 0.0 }));
        // SAFETY: as the caller promises.
        unsafe { Self::from_lanes(a, b, &geometry, &impulses, &apart, used, frames, frictional, sites) }
    }

    #[inline(always)]
    unsafe fn from_lanes(
        a: [u32; WIDTH],
        b: [u32; WIDTH],
        geometry: &[[L; WIDTH]; GEOMETRY],
        impulses: &[L; WIDTH],
        apart: &Vector3<L>,
        used: L,
        frames: Shared<Record<L::Scalar>>,
        frictional: bool,
        sites: &[ContactSite],
    ) -> Self {
        // SAFETY: as the caller promises.
        let (of_a, of_b) = unsafe { (Frames::<L>::gather(frames, &a), Frames::<L>::gather(frames, &b)) };
        let normal = of_a.turn(&vector(&geometry[0]));
        let tangent = of_a.turn(&vector(&geometry[0][3..]));
        let tangents = [tangent, normal.cross(&tangent)];
        let count = geometry[0][7];
        let linear = of_a.inverse_mass_along(&normal) + of_b.inverse_mass_along(&normal);
        let half = L::of(0.5);
        let mut middle = Arms { a: Vector3::repeat(L::zero()), b: Vector3::repeat(L::zero()) };
        let mut arms: [Vector3<L>; POINTS] = [Vector3::repeat(L::zero()); POINTS];
        let point_count = sites.iter().map(|site| site.geometry.point_count()).max().unwrap_or(0);
        let flat = |index: usize| geometry[1 + index / WIDTH][index % WIDTH];
        let share = inverse(count);
        let points = std::array::from_fn(|index| {
            let active = used.select(count.simd_gt(L::of(index as f64)), L::zero());
            let at = |first: usize| {
                Vector3::new(flat(6 * index + first), flat(6 * index + first + 1), flat(6 * index + first + 2))
            };
            let (on_a, on_b) = (of_a.turn(&at(0)), of_b.turn(&at(3)));
            // As the bodies are turned by now.
            let to_b = of_b.turn_on(&on_b) - of_a.turn_on(&on_a) + apart;
            let separation = dot(&normal, &to_b);
            let to_middle = to_b * half;
            let (arm_a, arm_b) = (on_a + to_middle, on_b - to_middle);
            let angular_a = of_a.whiten(&arm_a.cross(&normal));
            let angular_b = of_b.whiten(&arm_b.cross(&normal));
            let mass = inverse(linear + dot(&angular_a, &angular_a) + dot(&angular_b, &angular_b)) * active;
            middle.a = add_scaled(&middle.a, &arm_a, share * active);
            middle.b = add_scaled(&middle.b, &arm_b, share * active);
            arms[index] = arm_a;
            Point { angular_a, angular_b, separation, mass, relaxed: mass, impulse: impulses[index] * active }
        });
        let friction = frictional.then(|| {
            let mut radius = L::zero();
            for (index, arm) in arms.iter().enumerate() {
                let off = arm - middle.a;
                let distance = dot(&off, &off).simd_sqrt();
                radius += (distance * share).select(count.simd_gt(L::of(index as f64)), L::zero());
            }
            Self::friction(&of_a, &of_b, &normal, &tangents, &middle, radius, &impulses[POINTS..], used)
        });
        Self {
            a,
            b,
            normal,
            tangents,
            inverse_mass_a: of_a.inverse_mass,
            inverse_mass_b: of_b.inverse_mass,
            coefficient: geometry[0][6],
            points,
            point_count,
            friction,
        }
    }

    fn friction(
        of_a: &Frames<L>,
        of_b: &Frames<L>,
        normal: &Vector3<L>,
        tangents: &[Vector3<L>; 2],
        middle: &Arms<L>,
        radius: L,
        impulses: &[L],
        used: L,
    ) -> Friction<L> {
        let angular_a = tangents.map(|tangent| of_a.whiten(&middle.a.cross(&tangent)));
        let angular_b = tangents.map(|tangent| of_b.whiten(&middle.b.cross(&tangent)));
        let mass_between = |one: usize, other: usize| {
            dot(&of_a.inverse_mass.component_mul(&tangents[one]), &tangents[other])
                + dot(&of_b.inverse_mass.component_mul(&tangents[one]), &tangents[other])
                + dot(&angular_a[one], &angular_a[other])
                + dot(&angular_b[one], &angular_b[other])
        };
        let (xx, xy, yy) = (mass_between(0, 0), mass_between(0, 1), mass_between(1, 1));
        let scale = inverse(xx * yy - xy * xy) * used;
        let (twist_a, twist_b) = (of_a.whiten(normal), of_b.whiten(normal));
        Friction {
            angular_a,
            angular_b,
            mass: [yy * scale, -xy * scale, xx * scale],
            impulse: [impulses[0] * used, impulses[1] * used],
            twist_a,
            twist_b,
            twist_mass: inverse(dot(&twist_a, &twist_a) + dot(&twist_b, &twist_b)) * used,
            twist_impulse: impulses[2] * used,
            radius,
        }
    }

    /// Adds what the impulses at hand do to the velocities.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn warm_start(&self, velocity: Shared<Record<L::Scalar>>) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        for point in &self.points[..self.point_count] {
            pair.push(&self.normal, point.impulse);
            pair.turn(&point.angular_a, &point.angular_b, point.impulse);
        }
        if let Some(friction) = &self.friction {
            for axis in 0..2 {
                pair.push(&self.tangents[axis], friction.impulse[axis]);
                pair.turn(&friction.angular_a[axis], &friction.angular_b[axis], friction.impulse[axis]);
            }
            pair.turn(&friction.twist_a, &friction.twist_b, friction.twist_impulse);
        }
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// One update.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn solve(
        &mut self,
        velocity: Shared<Record<L::Scalar>>,
        moved: Shared<Record<L::Scalar>>,
        soft: &SoftTerms<L>,
        sweep: Sweep,
    ) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        if sweep == Sweep::Relax {
            for _ in 0..ROUNDS {
                self.solve_points(&mut pair, |_, point, speed| -(point.relaxed * speed));
                self.solve_friction(&mut pair);
            }
        } else {
            let springs = self.springs(moved, soft);
            // What comes fast is to stop before it is through: points of a patch must agree on it.
            if sweep == Sweep::Whole || self.is_closing() {
                for _ in 0..ROUNDS {
                    self.solve_springs(&mut pair, &springs);
                    self.solve_friction(&mut pair);
                }
            } else {
                self.solve_springs(&mut pair, &springs);
            }
            for (point, spring) in self.points[..self.point_count].iter_mut().zip(&springs) {
                let pushes = point.impulse.simd_gt(L::zero());
                point.relaxed = point.mass.select(pushes, spring.relaxed);
            }
        }
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// Whether surfaces that were apart at the start of the step may come together at some point.
    fn is_closing(&self) -> bool {
        let apart = |point: &Point<L>| (point.separation * point.mass).simd_gt(L::zero()).any();
        self.points[..self.point_count].iter().any(apart)
    }

    /// [`ROUNDS`] updates of the points, with springs, without friction; `anew`, as if nothing had pushed before.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn press(
        &mut self,
        velocity: Shared<Record<L::Scalar>>,
        moved: Shared<Record<L::Scalar>>,
        soft: &SoftTerms<L>,
        anew: bool,
    ) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        if anew {
            self.points.iter_mut().for_each(|point| point.impulse = L::zero());
        }
        let springs = self.springs(moved, soft);
        for _ in 0..ROUNDS {
            self.solve_springs(&mut pair, &springs);
        }
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// One update of friction alone, from none, bounded by what the points push at hand.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn rub(&mut self, velocity: Shared<Record<L::Scalar>>) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        if let Some(friction) = &mut self.friction {
            friction.impulse = [L::zero(); 2];
            friction.twist_impulse = L::zero();
        }
        self.solve_friction(&mut pair);
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// [`ROUNDS`] updates of points that push, until they neither part nor approach, and of friction.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn settle(&mut self, velocity: Shared<Record<L::Scalar>>) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        for _ in 0..ROUNDS {
            self.solve_points(&mut pair, |_, point, speed| {
                (-(point.mass * speed)).select(point.impulse.simd_gt(L::zero()), L::zero())
            });
            self.solve_friction(&mut pair);
        }
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// Moves the bodies out of a share of each point's depth.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn project(&self, moved: Shared<Record<L::Scalar>>, terms: &Projection<L>) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, moved) };
        let mut pushed = L::zero();
        let mut shift = dot(&self.normal, &(pair.linear_b - pair.linear_a));
        let give = pair.give(&self.normal);
        for point in &self.points[..self.point_count] {
            let separation = point.separation + shift + dot(&point.angular_b, &pair.angular_b)
                - dot(&point.angular_a, &pair.angular_a);
            let error = (separation + terms.slop).simd_clamp(-terms.most, L::zero());
            let push = -(point.mass * error * terms.contact);
            pushed += push;
            shift = give.simd_mul_add(push, shift);
            pair.turn(&point.angular_a, &point.angular_b, push);
        }
        pair.push(&self.normal, pushed);
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, moved) };
    }

    /// What the springs of the points ask for where the bodies are now.
    #[inline(always)]
    fn springs(&self, moved: Shared<Record<L::Scalar>>, soft: &SoftTerms<L>) -> [Spring<L>; POINTS] {
        // SAFETY: positions rest during a sweep.
        let (moved_a, moved_b) = unsafe { (L::gather(moved, &self.a), L::gather(moved, &self.b)) };
        let shift = dot(&self.normal, &(vector(&moved_b) - vector(&moved_a)));
        let (turned_a, turned_b) = (vector(&moved_a[3..]), vector(&moved_b[3..]));
        let zero = L::zero();
        let mut springs = [Spring { bias: zero, mass: zero, kept: zero, relaxed: zero }; POINTS];
        for (spring, point) in springs.iter_mut().zip(&self.points[..self.point_count]) {
            let separation =
                point.separation + shift + dot(&point.angular_b, &turned_b) - dot(&point.angular_a, &turned_a);
            let apart = separation.simd_gt(zero);
            let sunk = (separation + soft.slop).simd_min(zero);
            *spring = Spring {
                bias: (separation * soft.per_step).select(apart, (sunk * soft.rate).simd_max(-soft.push)),
                mass: point.mass.select(apart, point.mass * soft.mass),
                kept: zero.select(apart, soft.impulse),
                relaxed: zero.select(apart, point.mass),
            };
        }
        springs
    }

    /// One update of the points with springs.
    #[inline(always)]
    fn solve_springs(&mut self, pair: &mut Pair<L>, springs: &[Spring<L>; POINTS]) {
        self.solve_points(pair, |index, point, speed| {
            let Spring { bias, mass, kept, .. } = springs[index];
            -(mass * (speed + bias)) - kept * point.impulse
        });
    }

    /// One update of the points, by the change of impulse wanted of each for its speed of parting.
    #[inline(always)]
    fn solve_points(&mut self, pair: &mut Pair<L>, change: impl Fn(usize, &Point<L>, L) -> L) {
        let mut pushed = L::zero();
        let mut approach = dot(&self.normal, &(pair.linear_b - pair.linear_a));
        let give = pair.give(&self.normal);
        for (index, point) in self.points[..self.point_count].iter_mut().enumerate() {
            let speed = approach + dot(&point.angular_b, &pair.angular_b) - dot(&point.angular_a, &pair.angular_a);
            let impulse = (point.impulse + change(index, point, speed)).simd_max(L::zero());
            let change = impulse - point.impulse;
            point.impulse = impulse;
            pushed += change;
            approach = give.simd_mul_add(change, approach);
            pair.turn(&point.angular_a, &point.angular_b, change);
        }
        pair.push(&self.normal, pushed);
    }

    fn solve_friction(&mut self, pair: &mut Pair<L>) {
        let Some(friction) = &mut self.friction else { return };
        let pressed: L = self.points[..self.point_count].iter().fold(L::zero(), |sum, point| sum + point.impulse);
        let limit = self.coefficient * pressed;

        let spin = dot(&friction.twist_b, &pair.angular_b) - dot(&friction.twist_a, &pair.angular_a);
        let most = limit * friction.radius;
        let impulse = (friction.twist_impulse - friction.twist_mass * spin).simd_clamp(-most, most);
        pair.turn(&friction.twist_a, &friction.twist_b, impulse - friction.twist_impulse);
        friction.twist_impulse = impulse;

        let slide = pair.linear_b - pair.linear_a;
        let slip = |axis: usize, pair: &Pair<L>| {
            dot(&self.tangents[axis], &slide) + dot(&friction.angular_b[axis], &pair.angular_b)
                - dot(&friction.angular_a[axis], &pair.angular_a)
        };
        let (x, y) = (slip(0, pair), slip(1, pair));
        let [xx, xy, yy] = friction.mass;
        let wanted_x = friction.impulse[0] - (xx * x + xy * y);
        let wanted_y = friction.impulse[1] - (xy * x + yy * y);
        let squared = wanted_x * wanted_x + wanted_y * wanted_y;
        let too_much = squared.simd_gt(limit * limit);
        let shrink = (limit / squared.simd_max(L::of(1e-30)).simd_sqrt()).select(too_much, L::one());
        for (axis, wanted) in [wanted_x, wanted_y].into_iter().enumerate() {
            let impulse = wanted * shrink;
            let change = impulse - friction.impulse[axis];
            friction.impulse[axis] = impulse;
            pair.push(&self.tangents[axis], change);
            pair.turn(&friction.angular_a[axis], &friction.angular_b[axis], change);
        }
    }

    /// How fast each point's surfaces come together, m/s.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn approach(&self, velocity: Shared<Record<L::Scalar>>) -> [L; POINTS] {
        // SAFETY: as the caller promises.
        let pair = unsafe { Pair::gather(self, velocity) };
        let approach = dot(&self.normal, &(pair.linear_b - pair.linear_a));
        self.points
            .map(|point| -(approach + dot(&point.angular_b, &pair.angular_b) - dot(&point.angular_a, &pair.angular_a)))
    }

    /// What each point pushes with now, N·s.
    pub fn pushes(&self) -> [L; POINTS] {
        self.points.map(|point| point.impulse)
    }

    /// Gives points the speed of parting asked for (none: 0 or less) if they have less.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn bounce(&mut self, velocity: Shared<Record<L::Scalar>>, parting: &[L; POINTS]) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { Pair::gather(self, velocity) };
        let zero = L::zero();
        for (point, &wanted) in self.points[..self.point_count].iter_mut().zip(parting) {
            let speed = dot(&self.normal, &(pair.linear_b - pair.linear_a)) + dot(&point.angular_b, &pair.angular_b)
                - dot(&point.angular_a, &pair.angular_a);
            let change = (point.mass * (wanted - speed)).simd_max(-point.impulse).select(wanted.simd_gt(zero), zero);
            point.impulse += change;
            pair.push(&self.normal, change);
            pair.turn(&point.angular_a, &point.angular_b, change);
        }
        // SAFETY: as the caller promises.
        unsafe { pair.scatter(self, velocity) };
    }

    /// The impulses of each pair, to be kept for the next step.
    pub fn impulses(&self) -> [ContactImpulses; WIDTH] {
        let zero = L::zero();
        let [x, y, twist] = self.friction.as_ref().map_or([zero; 3], |f| [f.impulse[0], f.impulse[1], f.twist_impulse]);
        let [p, q, r, s] = [0, 1, 2, 3].map(|index: usize| self.points[index].impulse);
        L::give([p, q, r, s, x, y, twist, zero])
    }
}

/// The velocities of both bodies of each pair.
struct Pair<L: Lanes> {
    linear_a: Vector3<L>,
    angular_a: Vector3<L>,
    linear_b: Vector3<L>,
    angular_b: Vector3<L>,
    rest: [L; 4],
    inverse_mass_a: Vector3<L>,
    inverse_mass_b: Vector3<L>,
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    unsafe fn gather(block: &ContactBlock<L>, velocity: Shared<Record<L::Scalar>>) -> Self {
        // SAFETY: as the caller promises.
        let (a, b) = unsafe { (L::gather(velocity, &block.a), L::gather(velocity, &block.b)) };
        Self {
            linear_a: vector(&a),
            angular_a: vector(&a[3..]),
            linear_b: vector(&b),
            angular_b: vector(&b[3..]),
            rest: [a[6], a[7], b[6], b[7]],
            inverse_mass_a: block.inverse_mass_a,
            inverse_mass_b: block.inverse_mass_b,
        }
    }

    #[inline(always)]
    unsafe fn scatter(self, block: &ContactBlock<L>, velocity: Shared<Record<L::Scalar>>) {
        let record = |linear: Vector3<L>, angular: Vector3<L>, rest: [L; 2]| {
            [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z, rest[0], rest[1]]
        };
        let a = record(self.linear_a, self.angular_a, [self.rest[0], self.rest[1]]);
        let b = record(self.linear_b, self.angular_b, [self.rest[2], self.rest[3]]);
        // SAFETY: as the caller promises.
        unsafe {
            L::scatter(a, velocity, &block.a);
            L::scatter(b, velocity, &block.b);
        }
    }

    /// How much faster the bodies part along n for a unit impulse through their centres.
    #[inline(always)]
    fn give(&self, n: &Vector3<L>) -> L {
        dot(&(self.inverse_mass_a + self.inverse_mass_b).component_mul(n), n)
    }

    #[inline(always)]
    fn push(&mut self, direction: &Vector3<L>, impulse: L) {
        let push = direction * impulse;
        self.linear_a -= self.inverse_mass_a.component_mul(&push);
        self.linear_b += self.inverse_mass_b.component_mul(&push);
    }

    #[inline(always)]
    fn turn(&mut self, angular_a: &Vector3<L>, angular_b: &Vector3<L>, impulse: L) {
        self.angular_a = add_scaled(&self.angular_a, angular_a, -impulse);
        self.angular_b = add_scaled(&self.angular_b, angular_b, impulse);
    }
}
