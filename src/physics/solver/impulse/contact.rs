//! Contacts of as many pairs as there are lanes: up to four points, and friction of the manifold as a whole.
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
//! the point close it and no more. To relax is to solve without bias, ι = 0 and σ = 1: it takes the velocity that the
//! spring added out again.
//!
//! Separations are those of the start of the step plus n·(d_B − d_A) + j_B·θ'_B − j_A·θ'_A: the
//! same row again. Normals and arms are those of the frames that bodies keep for a little turn; arms end halfway
//! between the two points, at the same place where no body has turned.
//!
//! Friction acts at the middle of the manifold along two tangents, solved together, with |λ_t| ≤ μ Σ λ
//! (a disc, not a square), and as torsion about n with |λ_τ| ≤ μ ρ Σ λ, ρ the mean distance of the
//! points from the middle; points that hover bear less of either ([`footing`](crate::physics::contact)).

use nalgebra::{SimdBool, Vector3};

use super::bodies::{ClaimedPairs, Ends, Frames};
use super::constants::{CENTRAL, CONTACT_ROUNDS};
use super::pair::Pair;
use super::stage::Sweep;
use crate::physics::collision::{ContactGeometry, GEOMETRY, POINTS};
use crate::physics::contact::shares;
use crate::physics::lanes::{Lanes, READ_ONLY, Record, WIDTH, add_scaled, dot, inverse, vector};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms};

/// One point of each pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<L: Lanes> {
    pub angular: [Vector3<L>; 2],
    pub separation: L,
    /// Effective mass.
    pub mass: L,
    /// Effective mass when relaxed: 0 where the surfaces are still apart.
    relaxed_mass: L,
    impulse: L,
}

/// A point's row with the soft terms: λ changes by −m σ (v_n + bias) − ι λ.
#[derive(Clone, Copy, Debug)]
struct SoftRow<L> {
    bias: L,
    /// m σ.
    mass: L,
    /// ι.
    impulse_share: L,
    /// m when relaxed, if the impulse is zero.
    relaxed_mass: L,
}

/// Friction of the manifold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction<L: Lanes> {
    /// Of both tangents.
    angular: [[Vector3<L>; 2]; 2],
    /// Inverse of the 2 × 2 block: xx, xy, yy.
    mass: [L; 3],
    impulse: [L; 2],
    torsion: [Vector3<L>; 2],
    torsion_mass: L,
    torsion_impulse: L,
    /// ρ.
    radius: L,
}

/// Contacts of [`Lanes::COUNT`] pairs that share no body that moves.
#[derive(Clone, Debug)]
pub(crate) struct ContactBlock<L: Lanes> {
    pub ends: Ends,
    pub(super) normal: Vector3<L>,
    pub(super) tangents: [Vector3<L>; 2],
    pub(super) inverse_mass: [Vector3<L>; 2],
    /// μ of each pair.
    pub(super) coefficient: L,
    pub(super) points: [Point<L>; POINTS],
    pub(super) point_count: usize,
    /// Updates of points and friction in one update of the block.
    rounds: usize,
    pub(super) friction: Option<Friction<L>>,
}

/// Impulses of a contact: four points, two tangents, torsion, and the normal impulse of impacts, N·s.
pub(crate) type ContactImpulses = Record<f32>;

/// The same of the pairs of a block.
pub(super) type Impulses<L> = [L; WIDTH];

/// The contact of one pair, as its lane takes it in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactInput<'a> {
    pub geometry: &'a ContactGeometry,
    pub impulses: &'a ContactImpulses,
    /// Centre of B less centre of A, m.
    pub offset: Vector3<f64>,
}

impl<L: Lanes> ContactBlock<L> {
    /// One that does nothing.
    pub fn idle() -> Self {
        let (zero, none) = (L::zero(), Vector3::repeat(L::zero()));
        let point = Point { angular: [none; 2], separation: zero, mass: zero, relaxed_mass: zero, impulse: zero };
        Self {
            ends: [[READ_ONLY; WIDTH]; 2],
            normal: none,
            tangents: [none; 2],
            inverse_mass: [none; 2],
            coefficient: zero,
            points: [point; POINTS],
            point_count: 0,
            rounds: CONTACT_ROUNDS,
            friction: None,
        }
    }

    /// Takes in at most [`Lanes::COUNT`] pairs, whose bodies are at the block's `ends`. Lanes left over do nothing.
    pub fn take_in(&mut self, inputs: &[ContactInput], pairs: &ClaimedPairs<L>) {
        let input = |lane: usize| &inputs[lane.min(inputs.len() - 1)];
        let offset = Vector3::from_fn(|axis, _| L::each(|lane| <L::Scalar as Scalar>::of(input(lane).offset[axis])));
        let geometry: [[L; WIDTH]; GEOMETRY] =
            std::array::from_fn(|record| L::take(std::array::from_fn(|lane| &input(lane).geometry.records[record])));
        let impulses = L::take(std::array::from_fn(|lane| input(lane).impulses));
        let used = L::each(|lane| <L::Scalar as Scalar>::of(if lane < inputs.len() { 1.0 } else { 0.0 }));
        let frames = pairs.frames();
        let [of_a, of_b] = &frames;
        let normal = of_a.turn(&vector(&geometry[0]));
        let tangent = of_a.turn(&vector(&geometry[0][3..]));
        let tangents = [tangent, normal.cross(&tangent)];
        let count = geometry[0][7];
        let linear = of_a.inverse_mass_along(&normal) + of_b.inverse_mass_along(&normal);
        let half = L::of(0.5);
        // From A's and from B's centre.
        let mut arms: [Vector3<L>; POINTS] = [Vector3::repeat(L::zero()); POINTS];
        let flat = |index: usize| geometry[1 + index / WIDTH][index % WIDTH];
        let mut present = [L::zero(); POINTS];
        let mut arms_of_b = arms;
        self.points = std::array::from_fn(|index| {
            let active = used.select(count.simd_gt(L::of(index as f64)), L::zero());
            let at = |first: usize| {
                Vector3::new(flat(6 * index + first), flat(6 * index + first + 1), flat(6 * index + first + 2))
            };
            let (on_a, on_b) = (of_a.turn(&at(0)), of_b.turn(&at(3)));
            // As the bodies are turned by now.
            let to_b = of_b.turn_on(&on_b) - of_a.turn_on(&on_a) + offset;
            let to_middle = to_b * half;
            let (arm_a, arm_b) = (on_a + to_middle, on_b - to_middle);
            let angular = [of_a.whiten(&arm_a.cross(&normal)), of_b.whiten(&arm_b.cross(&normal))];
            let [of_a, of_b] = angular.map(|angular| dot(&angular, &angular));
            let mass = inverse(linear + of_a + of_b) * active;
            (arms[index], arms_of_b[index], present[index]) = (arm_a, arm_b, active);
            let impulse = impulses[index] * active;
            Point { angular, separation: dot(&normal, &to_b), mass, relaxed_mass: mass, impulse }
        });
        self.friction = inputs.iter().any(|input| input.geometry.friction() > 0.0).then(|| {
            let shares = shares(&arms, &self.points.map(|point| point.separation), &present);
            let middle = [arms, arms_of_b].map(|arms| {
                let zero = Vector3::repeat(L::zero());
                arms.iter().zip(shares).fold(zero, |sum, (arm, share)| add_scaled(&sum, arm, share))
            });
            let radius = arms.iter().zip(shares).fold(L::zero(), |sum, (arm, share)| {
                let off = arm - middle[0];
                sum + dot(&off, &off).simd_sqrt() * share
            });
            Friction::new(&frames, &normal, &tangents, &middle, radius, &impulses[POINTS..], used)
        });
        self.point_count = inputs.iter().map(|input| input.geometry.point_count()).max().unwrap_or(0);
        // Through the centres, as of balls, the one point and friction do not act on each other: a second update of
        // either changes nothing.
        let is_central = |angular: &Vector3<L>| dot(angular, angular).simd_le(linear * L::of(CENTRAL)).all();
        let is_settled_at_once = self.point_count <= 1 && self.points[0].angular.iter().all(is_central);
        self.rounds = if is_settled_at_once { 1 } else { CONTACT_ROUNDS };
        (self.normal, self.tangents, self.coefficient) = (normal, tangents, geometry[0][6]);
        self.inverse_mass = [of_a.inverse_mass, of_b.inverse_mass];
    }

    pub(super) fn velocities(&self, pairs: &ClaimedPairs<L>) -> Pair<L> {
        Pair::new(pairs.velocities(), &self.inverse_mass)
    }

    /// Adds what the impulses at hand do to the velocities.
    pub fn warm_start(&self, pairs: &mut ClaimedPairs<L>) {
        let mut pair = self.velocities(pairs);
        for point in &self.points[..self.point_count] {
            pair.apply_linear(&(self.normal * point.impulse));
            pair.apply_angular(&point.angular, point.impulse);
        }
        if let Some(friction) = &self.friction {
            for axis in 0..2 {
                pair.apply_linear(&(self.tangents[axis] * friction.impulse[axis]));
                pair.apply_angular(&friction.angular[axis], friction.impulse[axis]);
            }
            pair.apply_angular(&friction.torsion, friction.torsion_impulse);
        }
        pairs.set_velocities(pair.records());
    }

    /// One update.
    pub fn solve(&mut self, pairs: &mut ClaimedPairs<L>, soft: &SoftTerms<L>, sweep: Sweep) {
        let mut pair = self.velocities(pairs);
        if sweep == Sweep::Relax {
            for _ in 0..self.rounds {
                self.update_points(&mut pair, |_, point, speed| -(point.relaxed_mass * speed));
                self.update_friction(&mut pair);
            }
        } else {
            let rows = self.soft_rows(pairs, soft);
            // What comes fast is to stop before it is through: points of a manifold must agree on it.
            if sweep == Sweep::SoftWithFriction || self.is_closing() {
                for _ in 0..self.rounds {
                    self.update_soft_points(&mut pair, &rows);
                    self.update_friction(&mut pair);
                }
            } else {
                self.update_soft_points(&mut pair, &rows);
            }
            for (point, row) in self.points[..self.point_count].iter_mut().zip(&rows) {
                let is_loaded = point.impulse.simd_gt(L::zero());
                point.relaxed_mass = point.mass.select(is_loaded, row.relaxed_mass);
            }
        }
        pairs.set_velocities(pair.records());
    }

    /// Whether surfaces that were apart at the start of the step may come together at some point.
    fn is_closing(&self) -> bool {
        let is_apart = |point: &Point<L>| (point.separation * point.mass).simd_gt(L::zero()).any();
        self.points[..self.point_count].iter().any(is_apart)
    }

    /// Some updates of the points with the soft terms, without friction; `anew`, from zero impulse.
    pub fn solve_positions(&mut self, pairs: &mut ClaimedPairs<L>, soft: &SoftTerms<L>, anew: bool) {
        let mut pair = self.velocities(pairs);
        if anew {
            self.points.iter_mut().for_each(|point| point.impulse = L::zero());
        }
        let rows = self.soft_rows(pairs, soft);
        for _ in 0..self.rounds {
            self.update_soft_points(&mut pair, &rows);
        }
        pairs.set_velocities(pair.records());
    }

    /// One update of friction alone, from zero, bounded by the normal impulses at hand.
    pub fn solve_friction(&mut self, pairs: &mut ClaimedPairs<L>) {
        let mut pair = self.velocities(pairs);
        if let Some(friction) = &mut self.friction {
            friction.forget();
        }
        self.update_friction(&mut pair);
        pairs.set_velocities(pair.records());
    }

    /// Some updates of points with an impulse, until they neither part nor approach, and of friction.
    pub fn solve_velocities(&mut self, pairs: &mut ClaimedPairs<L>) {
        let mut pair = self.velocities(pairs);
        for _ in 0..self.rounds {
            self.update_points(&mut pair, |_, point, speed| {
                (-(point.mass * speed)).select(point.impulse.simd_gt(L::zero()), L::zero())
            });
            self.update_friction(&mut pair);
        }
        pairs.set_velocities(pair.records());
    }

    /// Moves the bodies out of a share of each point's depth.
    pub fn project(&self, pairs: &mut ClaimedPairs<L>, terms: &Projection<L>) {
        let mut pair = Pair::new(pairs.displacements(), &self.inverse_mass);
        let mut sum = L::zero();
        let mut shift = dot(&self.normal, &pair.linear());
        let inverse_mass = pair.inverse_mass_along(&self.normal);
        for point in &self.points[..self.point_count] {
            let separation = pair.row(point.separation + shift, &point.angular);
            let error = (separation + terms.slop).simd_clamp(-terms.max_correction, L::zero());
            let change = -(point.mass * error * terms.contact_share);
            sum += change;
            shift = inverse_mass.simd_mul_add(change, shift);
            pair.apply_angular(&point.angular, change);
        }
        pair.apply_linear(&(self.normal * sum));
        pairs.set_displacements(pair.records());
    }

    /// The rows of the points with the soft terms, where the bodies are now.
    #[inline(always)]
    fn soft_rows(&self, pairs: &ClaimedPairs<L>, soft: &SoftTerms<L>) -> [SoftRow<L>; POINTS] {
        let moved = Pair::new(pairs.displacements(), &self.inverse_mass);
        let shift = dot(&self.normal, &moved.linear());
        let zero = L::zero();
        let mut rows = [SoftRow { bias: zero, mass: zero, impulse_share: zero, relaxed_mass: zero }; POINTS];
        for (row, point) in rows.iter_mut().zip(&self.points[..self.point_count]) {
            let separation = moved.row(point.separation + shift, &point.angular);
            let is_apart = separation.simd_gt(zero);
            let depth = (separation + soft.slop).simd_min(zero);
            *row = SoftRow {
                bias: (separation * soft.per_step).select(is_apart, (depth * soft.rate).simd_max(-soft.max_speed)),
                mass: point.mass.select(is_apart, point.mass * soft.mass),
                impulse_share: zero.select(is_apart, soft.impulse),
                relaxed_mass: zero.select(is_apart, point.mass),
            };
        }
        rows
    }

    #[inline(always)]
    fn update_soft_points(&mut self, pair: &mut Pair<L>, rows: &[SoftRow<L>; POINTS]) {
        self.update_points(pair, |index, point, speed| {
            let SoftRow { bias, mass, impulse_share, .. } = rows[index];
            -(mass * (speed + bias)) - impulse_share * point.impulse
        });
    }

    /// One update of the points. `change` tells the change of impulse that each asks for at its separating speed.
    #[inline(always)]
    fn update_points(&mut self, pair: &mut Pair<L>, change: impl Fn(usize, &Point<L>, L) -> L) {
        let mut sum = L::zero();
        let mut approach = dot(&self.normal, &pair.linear());
        let inverse_mass = pair.inverse_mass_along(&self.normal);
        for (index, point) in self.points[..self.point_count].iter_mut().enumerate() {
            let speed = pair.row(approach, &point.angular);
            let impulse = (point.impulse + change(index, point, speed)).simd_max(L::zero());
            let change = impulse - point.impulse;
            point.impulse = impulse;
            sum += change;
            approach = inverse_mass.simd_mul_add(change, approach);
            pair.apply_angular(&point.angular, change);
        }
        pair.apply_linear(&(self.normal * sum));
    }

    fn update_friction(&mut self, pair: &mut Pair<L>) {
        let Some(friction) = &mut self.friction else { return };
        let load: L = self.points[..self.point_count].iter().fold(L::zero(), |sum, point| sum + point.impulse);
        // One point does not hinder a turn about the normal.
        friction.update(pair, &self.tangents, self.coefficient * load, self.point_count > 1);
    }

    /// The impulses of each pair, to be kept for the next step, with those of its impacts.
    pub fn impulses(&self, of_impacts: L) -> [ContactImpulses; WIDTH] {
        let [x, y, torsion] = self.friction.as_ref().map_or([L::zero(); 3], Friction::impulses);
        let [p, q, r, s] = self.points.map(|point| point.impulse);
        L::give([p, q, r, s, x, y, torsion, of_impacts])
    }
}

impl<L: Lanes> Friction<L> {
    fn new(
        frames: &[Frames<L>; 2],
        normal: &Vector3<L>,
        tangents: &[Vector3<L>; 2],
        middle: &[Vector3<L>; 2],
        radius: L,
        impulses: &[L],
        used: L,
    ) -> Self {
        let angular = tangents.map(|tangent| [0, 1].map(|end| frames[end].whiten(&middle[end].cross(&tangent))));
        let inverse_mass = |one: usize, other: usize| {
            dot(&frames[0].inverse_mass.component_mul(&tangents[one]), &tangents[other])
                + dot(&frames[1].inverse_mass.component_mul(&tangents[one]), &tangents[other])
                + dot(&angular[one][0], &angular[other][0])
                + dot(&angular[one][1], &angular[other][1])
        };
        let (xx, xy, yy) = (inverse_mass(0, 0), inverse_mass(0, 1), inverse_mass(1, 1));
        let scale = inverse(xx * yy - xy * xy) * used;
        let torsion = frames.each_ref().map(|frame| frame.whiten(normal));
        Self {
            angular,
            mass: [yy * scale, -xy * scale, xx * scale],
            impulse: [impulses[0] * used, impulses[1] * used],
            torsion,
            torsion_mass: inverse(dot(&torsion[0], &torsion[0]) + dot(&torsion[1], &torsion[1])) * used,
            torsion_impulse: (impulses[2] * used).select(radius.simd_gt(L::zero()), L::zero()),
            radius,
        }
    }

    /// Starts from zero.
    pub fn forget(&mut self) {
        self.impulse = [L::zero(); 2];
        self.torsion_impulse = L::zero();
    }

    /// Along both tangents, and torsion.
    pub fn impulses(&self) -> [L; 3] {
        let [x, y] = self.impulse;
        [x, y, self.torsion_impulse]
    }

    /// One update, for that limit on the tangential impulse, N·s.
    #[inline(always)]
    pub fn update(&mut self, pair: &mut Pair<L>, tangents: &[Vector3<L>; 2], limit: L, twists: bool) {
        if twists {
            let spin = pair.spin(&self.torsion);
            let most = limit * self.radius;
            let impulse = (self.torsion_impulse - self.torsion_mass * spin).simd_clamp(-most, most);
            pair.apply_angular(&self.torsion, impulse - self.torsion_impulse);
            self.torsion_impulse = impulse;
        }
        let linear = pair.linear();
        let slip = |axis: usize| pair.row(dot(&tangents[axis], &linear), &self.angular[axis]);
        let (x, y) = (slip(0), slip(1));
        let [xx, xy, yy] = self.mass;
        let wanted_x = self.impulse[0] - (xx * x + xy * y);
        let wanted_y = self.impulse[1] - (xy * x + yy * y);
        let squared = wanted_x * wanted_x + wanted_y * wanted_y;
        let is_over = squared.simd_gt(limit * limit);
        let shrink = (limit / squared.simd_max(L::of(1e-30)).simd_sqrt()).select(is_over, L::one());
        for (axis, wanted) in [wanted_x, wanted_y].into_iter().enumerate() {
            let impulse = wanted * shrink;
            let change = impulse - self.impulse[axis];
            self.impulse[axis] = impulse;
            pair.apply_linear(&(tangents[axis] * change));
            pair.apply_angular(&self.angular[axis], change);
        }
    }
}
