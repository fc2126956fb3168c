//! The interior point: from no guess at all to near a solution, in twenty or so steps.
//!
//! With T = diag(μ, 1, 1), x = Tλ and y = T⁻¹û are both in the cone Q of [`super::second_order_cone`], and the law is x
//! ∘ y = 0. Steps hold x and y inside and lower their product along x ∘ y = σ(1, 0, 0): Newton's method in the scaling
//! of Nesterov & Todd, with Mehrotra's prediction and correction (1992). y is an unknown of its own; how far it is from
//! T⁻¹û falls with each step too. De Saxcé's shift is taken from the present u: its change in the step is left to the
//! next. (Acary, Armand, Nguyen & Shpakovych 2023 compare ways to take the shift along.) The product is not let fall
//! below what the gap between y and û is worth: an x and y pressed to the cone's side can no longer follow.
//!
//! Rows whose impulse is bounded on both sides keep the impulse nearest to zero meanwhile.
//!
//! dλ = h − D Ĵ dz, D = T⁻¹W²T⁻¹ softened by the compliance ε/ρ, as for [`super::newton`]. Joints are stiff rows.

use nalgebra::{Matrix3, Vector3};

use super::constants::{
    FAR_CENTRING, FAR_GAP, INTERIOR_STEPS, LEAST_CENTRING, NEWTON_AGAIN, NEWTON_PRODUCT, SHORT_STEP, SHORT_STEPS,
    SOFTNESS, TO_BOUNDARY,
};
use super::second_order_cone::{Scaling, product, quotient, reach};
use super::{ConePoint, Iterate, Law};
use crate::physics::Refill;

/// Kept from solve to solve.
#[derive(Clone, Debug, Default)]
pub(super) struct InteriorBuffers {
    /// y of each point.
    slack: Vec<Vector3<f64>>,
    /// x's and y's change.
    change: Vec<[Vector3<f64>; 2]>,
    /// dλ.
    step: Vec<Vector3<f64>>,
    /// 1/(1 + (ε/ρ) D) of each point.
    softening: Vec<Matrix3<f64>>,
    /// λ, while Newton steps are tried.
    kept: Vec<Vector3<f64>>,
}

impl Iterate {
    /// From inside the cones towards a solution, with Newton steps on the way. True once within the tolerance.
    pub(super) fn interior_point(&mut self, buffers: &mut InteriorBuffers) -> bool {
        let cones = self.cones().count();
        if cones == 0 {
            return false;
        }
        let typical = self.begin(buffers) / cones as f64;
        let (mut first, mut next, mut short) = (None, f64::INFINITY, 0);
        let mut is_done = false;
        for _ in 0..INTERIOR_STEPS {
            self.refresh();
            let residual = self.traced_residual();
            let (gap, mean) = self.progress(buffers, cones);
            let first = *first.get_or_insert(mean);
            if residual.largest < next && mean < NEWTON_PRODUCT * first {
                next = NEWTON_AGAIN * residual.largest;
                buffers.kept.clone_from(&self.impulses);
                is_done = self.newton();
                if is_done {
                    break;
                }
                self.impulses.clone_from(&buffers.kept);
                self.refresh();
            }
            self.outcome.steps += 1;
            self.outcome.interior += 1;
            let is_far = gap * gap * typical.exp() > FAR_GAP * mean;
            let share = self.inner_step(buffers, mean, cones, is_far);
            short = if share < SHORT_STEP { short + 1 } else { 0 };
            if short > SHORT_STEPS || !share.is_finite() {
                break;
            }
        }
        if !is_done {
            self.refresh();
            self.note();
        }
        is_done
    }

    /// The contacts of bodies that move, with their places among the points.
    fn cones(&self) -> impl Iterator<Item = (usize, &ConePoint)> {
        self.points.iter().enumerate().filter(|(_, point)| is_cone(point))
    }

    /// x and y in the middle of their cones, as large as the free velocities. The sum of log ρ.
    fn begin(&mut self, buffers: &mut InteriorBuffers) -> f64 {
        let movable = self.points.iter().zip(&self.free).filter(|(point, _)| point.is_movable());
        let speed = movable.map(|(_, free)| free.norm_squared()).fold(0.0, f64::max).sqrt();
        buffers.slack.clear();
        let mut logarithms = 0.0;
        for (point, impulse) in self.points.iter().zip(&mut self.impulses) {
            let start = if is_cone(point) { speed } else { 0.0 };
            if is_cone(point) {
                *impulse = from_cone(point.law, &Vector3::new(start * point.mass, 0.0, 0.0));
                logarithms += point.mass.ln();
            } else {
                *impulse = point.law.project(&Vector3::zeros());
            }
            buffers.slack.push(Vector3::new(start, 0.0, 0.0));
        }
        logarithms
    }

    /// The largest |y − T⁻¹û| and the mean of x·y.
    fn progress(&self, buffers: &InteriorBuffers, cones: usize) -> (f64, f64) {
        let (mut gap, mut sum) = (0.0, 0.0);
        for (index, point) in self.cones() {
            let slack = &buffers.slack[index];
            gap = f64::max(gap, (slack - to_dual(point.law, &self.velocities[index])).norm());
            sum += to_cone(point.law, &self.impulses[index]).dot(slack);
        }
        (gap, sum / cones as f64)
    }

    /// Prediction, correction, and as much of it as stays inside: the share taken.
    fn inner_step(&mut self, buffers: &mut InteriorBuffers, mean: f64, cones: usize, is_far: bool) -> f64 {
        if !self.direction(buffers, None) {
            return f64::NAN;
        }
        let share = self.share(buffers);
        let mut after = 0.0;
        for (index, point) in self.cones() {
            let [x, y] = &buffers.change[index];
            after += (to_cone(point.law, &self.impulses[index]) + share * x).dot(&(buffers.slack[index] + share * y));
        }
        let ratio = after / (cones as f64 * mean);
        let least = if is_far { FAR_CENTRING } else { LEAST_CENTRING };
        let target = ratio.max(0.0).powi(3).clamp(least, 1.0) * mean;
        self.direction(buffers, Some(target));
        let share = self.share(buffers);
        for ((impulse, step), (slack, [_, y])) in
            self.impulses.iter_mut().zip(&buffers.step).zip(buffers.slack.iter_mut().zip(&buffers.change))
        {
            *impulse += share * step;
            *slack += share * y;
        }
        share
    }

    /// How much of the changes stays inside, at most all.
    fn share(&self, buffers: &InteriorBuffers) -> f64 {
        self.cones().fold(1.0, |share, (index, point)| {
            let [x, y] = &buffers.change[index];
            let most = reach(&to_cone(point.law, &self.impulses[index]), x).min(reach(&buffers.slack[index], y));
            f64::min(share, TO_BOUNDARY * most)
        })
    }

    /// Changes of λ, x and y: the prediction's, or those of the correction to a product σ, which takes the prediction's
    /// factor and the products of its changes off. False where the linear system is singular.
    fn direction(&mut self, buffers: &mut InteriorBuffers, aim: Option<f64>) -> bool {
        let Self { points, linear, elimination, impulses, velocities, .. } = self;
        if aim.is_none() {
            linear.stiffness.clear();
            buffers.softening.clear();
            buffers.change.reset(points.len(), [Vector3::zeros(); 2]);
        }
        linear.offset.clear();
        for (index, ((point, impulse), velocity)) in points.iter().zip(&*impulses).zip(&*velocities).enumerate() {
            let (stiffness, offset) = match point.law {
                _ if !point.is_movable() => (Matrix3::zeros(), Vector3::zeros()),
                Law::Within(..) => (Matrix3::zeros(), Vector3::zeros()),
                Law::Joint => {
                    let stiffness = point.mass / SOFTNESS;
                    (Matrix3::from_diagonal_element(stiffness), -stiffness * velocity)
                }
                _ => cone_terms(point.law, impulse, velocity, &buffers.slack[index], &buffers.change[index], aim),
            };
            if aim.is_none() {
                let compliance = if is_cone(point) { SOFTNESS / point.mass } else { 0.0 };
                let softening = (Matrix3::identity() + compliance * stiffness).try_inverse();
                buffers.softening.push(softening.unwrap_or_else(Matrix3::identity));
                linear.stiffness.push(buffers.softening[index] * stiffness);
            }
            linear.offset.push(buffers.softening[index] * offset);
        }
        if aim.is_none() && !linear.factor(points, elimination, true) {
            return false;
        }
        linear.apply_offsets(points, elimination);
        linear.solve(points, elimination);
        buffers.step.clear();
        for (index, point) in points.iter().enumerate() {
            let motion = point.relative(&linear.solution);
            let step = linear.offset[index] - linear.stiffness[index] * motion;
            buffers.step.push(step);
            if is_cone(point) {
                let softened = motion + SOFTNESS / point.mass * step;
                let gap = buffers.slack[index] - to_dual(point.law, &velocities[index]);
                buffers.change[index] = [to_cone(point.law, &step), from_cone(point.law, &softened) - gap];
            }
        }
        true
    }
}

/// T⁻¹W²T⁻¹ and h of a contact: dλ = h − T⁻¹W²T⁻¹ du.
fn cone_terms(
    law: Law,
    impulse: &Vector3<f64>,
    velocity: &Vector3<f64>,
    slack: &Vector3<f64>,
    [dx, dy]: &[Vector3<f64>; 2],
    aim: Option<f64>,
) -> (Matrix3<f64>, Vector3<f64>) {
    let gap = slack - to_dual(law, velocity);
    if law == Law::Frictionless {
        let cross = if aim.is_some() { dx.x * dy.x } else { 0.0 };
        let stiffness = impulse.x / slack.x;
        let push = (aim.unwrap_or(0.0) - impulse.x * slack.x - cross) / slack.x + stiffness * gap.x;
        let mut block = Matrix3::zeros();
        block.m11 = stiffness;
        return (block, Vector3::new(push, 0.0, 0.0));
    }
    let scaling = Scaling::new(&to_cone(law, impulse), slack);
    let scaled = scaling.times(slack);
    let mut wanted = -product(&scaled, &scaled);
    wanted.x += aim.unwrap_or(0.0);
    if aim.is_some() {
        wanted -= product(&scaling.under(dx), &scaling.times(dy));
    }
    let push = scaling.times(&quotient(&scaled, &wanted));
    let square = scaling.squared();
    let inverse = Matrix3::from_diagonal(&Vector3::new(1.0 / law.friction(), 1.0, 1.0));
    (inverse * square * inverse, from_cone(law, &(push + square * gap)))
}

/// A contact of a body that moves, or a limit.
fn is_cone(point: &ConePoint) -> bool {
    point.is_movable() && !matches!(point.law, Law::Joint | Law::Within(..))
}

/// T λ.
fn to_cone(law: Law, impulse: &Vector3<f64>) -> Vector3<f64> {
    match law {
        Law::Friction(friction) => Vector3::new(friction * impulse.x, impulse.y, impulse.z),
        Law::Frictionless | Law::Joint | Law::Within(..) => *impulse,
    }
}

/// T⁻¹ x, and T⁻¹ u.
fn from_cone(law: Law, velocity: &Vector3<f64>) -> Vector3<f64> {
    match law {
        Law::Friction(friction) => Vector3::new(velocity.x / friction, velocity.y, velocity.z),
        Law::Frictionless | Law::Joint | Law::Within(..) => *velocity,
    }
}

/// T⁻¹ û.
fn to_dual(law: Law, velocity: &Vector3<f64>) -> Vector3<f64> {
    from_cone(law, &law.shifted(velocity))
}
