//! Impacts: what comes together fast parts again, before forces act and rows are solved.
//!
//! **Newton's law.** Points whose surfaces come together at the speed u > `restitution_speed` and would meet within the
//! substep, s < u h for a gap s, are to part at e u. What comes more slowly is left to the rows, which let it come to
//! rest on the surface. Forces have no part in it: what lies under its weight has no approach at the start of a substep,
//! so that it does not bounce, and a row never asks for a bounce of what it stopped by itself.
//!
//! **One pair at a time.** A ball that hits the first of a row of balls stops, and the last flies off, because the impact
//! goes from pair to pair. Rows solved all at once know nothing of that: they would have balls that touch go on together,
//! and to remember the approaches of the start of the step and make up for them at its end gives bodies that met others
//! in between the speed of an approach which is past; heaps gained any amount of energy by it. So impacts are solved pair
//! by pair, with the velocities as they are by then, and again for as long as some points approach, [`IMPACT_SWEEPS`]
//! times at most: an impact goes on by at least one pair in each sweep, by more where colours follow one another that
//! way. What is left then is for the rows, which take the approach away.
//!
//! **Energy.** With normal impulses p ≥ 0 on the points of a pair, u and u′ their separating speeds before and after,
//! u′ = u + K p with the Delassus operator K = J M⁻¹Jᵀ of the pair, the energy changes by
//!
//! ΔE = pᵀu + ½ pᵀK p = ½ pᵀ(u + u′).
//!
//! With Newton's law at all points that have an impulse, u′ = −e u, that is −½ (1 − e) |pᵀu| ≤ 0. Points of one manifold
//! are solved together: first in the shares in which each would take it alone, by as much as is best for all, which is
//! the answer where a face lands flat, then by some rounds one after the other. As these may not have ended, σ p is
//! applied with the largest σ ≤ 1 for which ΔE ≤ 0, σ = min(1, 2 |pᵀu|/pᵀK p). Friction, from zero and within its disc of
//! what the points pushed, acts against slip and never turns it round: it takes energy. What comes after keeps the energy of
//! what rows do not touch: it drifts by the mean of its velocities at both ends of the substep
//! ([`Stage::Drift`](super::stage::Stage::Drift)), and where it spins, its angular velocity in its own axes is that after
//! free rotation ([`Stage::Scatter`](super::stage::Stage::Scatter)).
//!
//! Bodies turn round where they would meet within the substep, up to u h before they do.

use nalgebra::SimdBool;

use super::bodies::ClaimedPairs;
use super::constants::IMPACT_ROUNDS;
use super::contact::{ContactBlock, Impulses};
use super::pair::Pair;
use crate::physics::collision::{IMPACT, POINTS};
use crate::physics::contact::rebound;
use crate::physics::lanes::{Lanes, WIDTH, dot, inverse};
use crate::physics::scalar::Scalar;

/// What a block of contacts of which some bounce has besides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Restitution<L> {
    /// e of each pair.
    coefficient: L,
    /// Impulses of the impacts that are not recorded yet, N·s, in the order of a contact's; of normal impulses in
    /// [`IMPACT`] those of the whole step.
    impacts: Impulses<L>,
}

impl<L: Lanes> Restitution<L> {
    /// None where no lane's `coefficient` is over 0.
    pub fn new(coefficient: impl Fn(usize) -> f64) -> Option<Self> {
        if (0..L::COUNT).all(|lane| coefficient(lane) == 0.0) {
            return None;
        }
        let coefficient = L::each(|lane| <L::Scalar as Scalar>::of(coefficient(lane)));
        Some(Self { coefficient, impacts: [L::zero(); WIDTH] })
    }

    /// Goes on from the rows that the block had before, in the same step.
    pub fn resume(&mut self, before: &Self) {
        self.impacts = before.impacts;
    }

    fn add(&mut self, impulses: &[L; POINTS], friction: [L; 3]) {
        let sum = impulses.iter().fold(L::zero(), |sum, &impulse| sum + impulse);
        for (total, &now) in self.impacts.iter_mut().zip(impulses.iter().chain(&friction).chain([&sum])) {
            *total += now;
        }
    }

    /// Takes the impulses that are not recorded yet.
    pub fn take_impacts(&mut self) -> Impulses<L> {
        let mut taken = [L::zero(); WIDTH];
        taken[..IMPACT].swap_with_slice(&mut self.impacts[..IMPACT]);
        taken
    }

    /// Normal impulse of all impacts in the step, N·s.
    pub fn of_step(&self) -> L {
        self.impacts[IMPACT]
    }
}

impl<L: Lanes> ContactBlock<L> {
    /// The impact of points that come together within the substep, of length h, s, faster than `least`, m/s. Whether there
    /// is one.
    pub fn bounce(&self, pairs: &mut ClaimedPairs<L>, restitution: &mut Restitution<L>, [least, h]: [L; 2]) -> bool {
        let zero = L::zero();
        let before = self.velocities(pairs);
        let moved = Pair::new(pairs.displacements(), &self.inverse_mass);
        let (approach, shift) = (dot(&self.normal, &before.linear()), dot(&self.normal, &moved.linear()));
        let (mut speeds, mut rebounds, mut bounces) = ([zero; POINTS], [zero; POINTS], false);
        for (index, point) in self.points[..self.point_count].iter().enumerate() {
            let speed = before.row(approach, &point.angular);
            let separation = moved.row(point.separation + shift, &point.angular);
            // Lanes and points that are not used have no mass.
            let meets = (point.mass * (separation + speed * h)).simd_lt(zero);
            speeds[index] = speed;
            rebounds[index] = rebound(restitution.coefficient, -speed, least).select(meets, zero);
            bounces |= rebounds[index].simd_gt(zero).any();
        }
        if !bounces {
            return false;
        }
        let impulses = self.meet(&before, &speeds, &rebounds);
        let mut after = before;
        let load = self.push(&mut after, &impulses);
        let friction = self.friction.map_or([zero; 3], |mut friction| {
            friction.forget();
            friction.update(&mut after, &self.tangents, self.coefficient * load, self.point_count > 1);
            friction.impulses()
        });
        restitution.add(&impulses, friction);
        pairs.set_velocities(after.records());
        true
    }

    /// Impulses of points that part at these speeds, 0 for those that do not meet: no more than gain no energy.
    fn meet(&self, before: &Pair<L>, speeds: &[L; POINTS], rebounds: &[L; POINTS]) -> [L; POINTS] {
        let zero = L::zero();
        let count = self.point_count;
        // As each would take it alone, by as much as is best for all.
        let alone: [L; POINTS] = std::array::from_fn(|index| {
            let wanted = self.points[index].mass * (rebounds[index] - speeds[index]);
            wanted.select(rebounds[index].simd_gt(zero), zero)
        });
        let wanted = (0..count).fold(zero, |sum, index| sum + alone[index] * (rebounds[index] - speeds[index]));
        let share = wanted * inverse(self.growth(before, speeds, &alone));
        let mut impulses = alone.map(|impulse| impulse * share);
        if count > 1 {
            let mut pair = before.clone();
            self.push(&mut pair, &impulses);
            for _ in 0..IMPACT_ROUNDS {
                for (index, point) in self.points[..count].iter().enumerate() {
                    let speed = pair.row(dot(&self.normal, &pair.linear()), &point.angular);
                    let wanted = (point.mass * (rebounds[index] - speed)).simd_max(-impulses[index]);
                    let change = wanted.select(rebounds[index].simd_gt(zero), zero);
                    impulses[index] += change;
                    pair.apply_linear(&(self.normal * change));
                    pair.apply_angular(&point.angular, change);
                }
            }
        }
        let given = (0..count).fold(zero, |sum, index| sum - impulses[index] * speeds[index]);
        let growth = self.growth(before, speeds, &impulses);
        let share = (given * L::of(2.0) * inverse(growth)).simd_clamp(zero, L::one());
        impulses.map(|impulse| impulse * share)
    }

    /// pᵀK p of normal impulses p on points at these separating speeds.
    fn growth(&self, before: &Pair<L>, speeds: &[L; POINTS], impulses: &[L; POINTS]) -> L {
        let mut after = before.clone();
        self.push(&mut after, impulses);
        let parting = dot(&self.normal, &after.linear());
        let points = self.points[..self.point_count].iter().zip(impulses).zip(speeds);
        points.fold(L::zero(), |sum, ((point, &impulse), &speed)| {
            sum + impulse * (after.row(parting, &point.angular) - speed)
        })
    }

    /// Adds what normal impulses do to the velocities. Returns their sum.
    fn push(&self, pair: &mut Pair<L>, impulses: &[L; POINTS]) -> L {
        let load = impulses[..self.point_count].iter().fold(L::zero(), |sum, &impulse| sum + impulse);
        pair.apply_linear(&(self.normal * load));
        for (point, &impulse) in self.points[..self.point_count].iter().zip(impulses) {
            pair.apply_angular(&point.angular, impulse);
        }
        load
    }
}
