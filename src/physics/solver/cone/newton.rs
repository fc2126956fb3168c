//! Semismooth Newton iterations on Alart & Curnier's map, with a compliance.
//!
//! With a compliance ε/ρ about λ_k the law is to hold for ũ = u + (ε/ρ)(λ − λ_k) instead of u. It does where (Alart & Curnier
//! 1991)
//!
//! F(λ) = λ − C(λ − ρ ũ) = 0,  C(x) = (x_n⁺, x_t or as much of it as is within μ x_n⁺).
//!
//! Unlike the projection on the cone, on which the residual is measured, C is smooth where a point sticks, and needs no shift
//! of u. Where x = λ − ρ ũ lands says what the iteration dλ = h − D Ĵ dz, dz = Ĵᵀdλ, aims at:
//!
//! - open, x_n ≤ 0: λ = 0.
//! - sticking, |x_t| ≤ μ x_n: ũ = 0, so that D = ρ/ε and h = −(ρ/ε) ũ.
//! - slipping: ũ_n = 0 likewise, and λ_t = μ λ_n x_t/|x_t|. Along t = x_t/|x_t| the friction follows the normal,
//!   D_tn = μ D_nn, so that D is not symmetric; across it, with κ = μ x_n/|x_t|, D = κρ/(1 − (1 − ε)κ).
//!
//! Points may be redundant: without the compliance the system would be singular. It acts on λ − λ_k alone, and so is no error
//! where λ changes no more. Which points stick or slip follows from λ and u in units of ρ, not of ρ/ε: the least change of u
//! does not send stiff points to and fro, as it does if λ is eliminated, λ = C(λ_k − (ρ/ε) u).

use nalgebra::{Matrix3, Vector3};

use super::constants::{HALVINGS, JOINT_SOFTNESS, LEAST_JOINT_SOFTNESS, MOST_POOR, POOR_GAIN};
use super::law::width;
use super::{ConePoint, Iterate, Law};
use crate::physics::Refill;

/// Kept from solve to solve.
#[derive(Clone, Debug, Default)]
pub(super) struct NewtonBuffers {
    /// dλ.
    step: Vec<Vector3<f64>>,
    /// Ĵ dz.
    motion: Vec<Vector3<f64>>,
}

/// One point's part in an iteration.
#[derive(Clone, Copy, Debug, Default)]
struct Linearised {
    /// D and h.
    stiffness: Matrix3<f64>,
    offset: Vector3<f64>,
    is_symmetric: bool,
}

impl Iterate {
    /// Iterates towards the λ at which the law holds with a compliance of `softness`/ρ about the present λ, which is left in
    /// [`Self::kept`]. True once no |F|/ρ is more than `wanted`, m/s.
    pub(super) fn reach(&mut self, buffers: &mut NewtonBuffers, softness: f64, wanted: f64, most: u32) -> bool {
        self.kept.clone_from(&self.impulses);
        let mut poor = 0;
        for count in 0..=most {
            let (largest, square, is_symmetric) = self.linearise(softness);
            if largest <= wanted * wanted {
                return true;
            }
            if count == most || poor == MOST_POOR || self.is_late() {
                break;
            }
            self.outcome.steps += 1;
            let Self { points, linear, elimination, .. } = self;
            if !linear.factor(points, elimination, is_symmetric) {
                break;
            }
            linear.apply_offsets(points, elimination);
            linear.solve(points, elimination);
            buffers.motion.refill(points.iter().map(|point| point.relative(&linear.solution)));
            let terms = linear.offset.iter().zip(&linear.stiffness).zip(&buffers.motion);
            buffers.step.refill(terms.map(|((offset, stiffness), motion)| offset - stiffness * motion));
            let (after, share) = self.share(buffers, softness, square);
            poor += u32::from(after > POOR_GAIN * POOR_GAIN * square);
            // Where none is better, the whole step often leads out within two or three.
            let share = share.unwrap_or(1.0);
            for (impulse, step) in self.impulses.iter_mut().zip(&buffers.step) {
                *impulse += share * step;
            }
            self.refresh();
            if self.trace.is_some() {
                self.traced_residual();
            }
        }
        false
    }

    /// Whether some point has friction, without which nothing wedges.
    pub(super) fn may_wedge(&self) -> bool {
        self.points.iter().any(|point| matches!(point.law, Law::Friction(_)))
    }

    /// λ such that nothing that comes together moves, but for a compliance: where a point would slip away under a load that
    /// its slip only raises (Painlevé 1895), no iterations from nothing find that.
    pub(super) fn wedge(&mut self, softness: f64) {
        self.impulses.fill(Vector3::zeros());
        self.refresh();
        let Self { points, linear, elimination, impulses, velocities, .. } = self;
        linear.clear();
        for (point, velocity) in points.iter().zip(&*velocities) {
            let holds = point.is_movable() && (point.law == Law::Joint || !point.law.is_single() && velocity.x < 0.0);
            let stiff = if holds { point.mass / of_point(point, softness) } else { 0.0 };
            linear.stiffness.push(Matrix3::from_diagonal_element(stiff));
            linear.offset.push(-stiff * velocity);
        }
        if linear.factor(points, elimination, true) {
            linear.apply_offsets(points, elimination);
            linear.solve(points, elimination);
            let terms = points.iter().zip(&linear.offset).zip(&linear.stiffness);
            impulses.refill(
                terms.map(|((point, offset), stiffness)| offset - stiffness * point.relative(&linear.solution)),
            );
        }
        self.refresh();
    }

    /// D and h of all points; the largest |F/ρ|², their sum, and whether all D are symmetric.
    fn linearise(&mut self, softness: f64) -> (f64, f64, bool) {
        let Self { points, linear, impulses, kept, velocities, .. } = self;
        linear.clear();
        let (mut largest, mut sum, mut is_symmetric) = (0.0, 0.0, true);
        for (((point, impulse), kept), velocity) in points.iter().zip(&*impulses).zip(&*kept).zip(&*velocities) {
            if !point.is_movable() {
                linear.stiffness.push(Matrix3::zeros());
                linear.offset.push(Vector3::zeros());
                continue;
            }
            let softness = of_point(point, softness);
            let velocity = velocity + (impulse - kept) * (softness / point.mass);
            let square = defect(point, impulse, &velocity).norm_squared();
            largest = f64::max(largest, square);
            sum += square;
            let own = linearised(point, softness, impulse, &velocity);
            is_symmetric &= own.is_symmetric;
            linear.stiffness.push(own.stiffness);
            linear.offset.push(own.offset);
        }
        (largest, sum, is_symmetric)
    }

    /// The sum of |F/ρ|² after the longest of the shares tried with which it falls as it should, else after the one with which
    /// it is least; no share where it falls with none.
    fn share(&self, buffers: &NewtonBuffers, softness: f64, before: f64) -> (f64, Option<f64>) {
        let now = |share: f64| {
            let mut sum = 0.0;
            for (index, point) in self.points.iter().enumerate().filter(|(_, point)| point.is_movable()) {
                let impulse = self.impulses[index] + share * buffers.step[index];
                let velocity = self.velocities[index]
                    + share * buffers.motion[index]
                    + (impulse - self.kept[index]) * (of_point(point, softness) / point.mass);
                sum += defect(point, &impulse, &velocity).norm_squared();
            }
            sum
        };
        let mut best = (before, None);
        for halvings in 0..=HALVINGS {
            let share = 0.5_f64.powi(halvings);
            let sum = now(share);
            if sum < best.0 {
                best = (sum, Some(share));
            }
            if sum.sqrt() <= (1.0 - 0.1 * share) * before.sqrt() {
                break;
            }
        }
        best
    }
}

/// ε of a point.
fn of_point(point: &ConePoint, softness: f64) -> f64 {
    if point.law == Law::Joint { (JOINT_SOFTNESS * point.slack * softness).max(LEAST_JOINT_SOFTNESS) } else { softness }
}

/// F/ρ for ũ.
fn defect(point: &ConePoint, impulse: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
    if point.law == Law::Joint {
        return *velocity;
    }
    (impulse - point.law.clamp(&(impulse - point.mass * velocity))) / point.mass
}

/// D and h for ũ.
fn linearised(point: &ConePoint, softness: f64, impulse: &Vector3<f64>, velocity: &Vector3<f64>) -> Linearised {
    let (mass, stiff) = (point.mass, point.mass / softness);
    let wanted = impulse - mass * velocity;
    let symmetric = |stiffness, offset| Linearised { stiffness, offset, is_symmetric: true };
    let sticking = || symmetric(Matrix3::from_diagonal_element(stiff), -stiff * velocity);
    let pushing = || {
        let first = |value| Vector3::new(value, 0.0, 0.0);
        symmetric(Matrix3::from_diagonal(&first(stiff)), first(-stiff * velocity.x))
    };
    let open = || symmetric(Matrix3::zeros(), point.law.clamp(&wanted) - impulse);
    let friction = match point.law {
        Law::Joint => return sticking(),
        Law::Frictionless => return if wanted.x > 0.0 { pushing() } else { open() },
        Law::Within(lower, upper) => return if lower < wanted.x && wanted.x < upper { pushing() } else { open() },
        Law::Friction(friction) => friction,
    };
    let width = width(&wanted);
    if wanted.x <= 0.0 {
        return open();
    }
    if width <= friction * wanted.x {
        return sticking();
    }
    let along = Vector3::new(0.0, wanted.y / width, wanted.z / width);
    let girth = Vector3::new(0.0, -along.z, along.y);
    let share = friction * wanted.x / width;
    let regular = 1.0 / (1.0 - (1.0 - softness) * share);
    let pressing = Vector3::new(1.0, 0.0, 0.0) + friction * along;
    let off = impulse - pressing * impulse.x;
    let push = -stiff * velocity.x;
    Linearised {
        stiffness: stiff * pressing * Vector3::x().transpose() + (share * mass * regular) * girth * girth.transpose(),
        offset: push * pressing - off.dot(&along) * along - (off.dot(&girth) * regular) * girth,
        is_symmetric: false,
    }
}
