//! The alternating direction method of multipliers on the impulses, with one factorisation for many iterations (Le Lidec,
//! Montaut & Carpentier 2024; the same idea in Acary, Brémond & Huber 2018).
//!
//! With u = G λ + c, G = Ĵ Ĵᵀ, the shift s = μ|u_t| n taken from the iteration before, and weights of each point in units of
//! its mobility:
//!
//! (G + η + ρ) x = −(c + s) + η x₋ + ρ y − w,  y = P_K(x + w/ρ),  w += ρ (x − y),
//!
//! where −w comes to be û. The system is solved by bodies, x = D(h − Ĵ t) with (1 + ĴᵀD Ĵ) t = ĴᵀD h, D = 1/(η + ρ). It is
//! factored anew only when ρ changes: ρ = √(L η) (L/η)^p, L the largest eigenvalue of G in those units, p up or down by
//! 0.05 where one of the residuals |x − y| and |y − y₋| is ten times the other.

use nalgebra::{Vector3, Vector6};
use plumb::physics::ContactProblem;

use crate::natural_map::Impulses;
use crate::physics::linear::{BlockLdl, Elimination, Inverse};
use crate::points::{Law, Point, given, local, points};
use crate::watch::Watch;

/// η, as a share of a point's mobility.
const PROXIMAL: f64 = 1e-6;
/// The same of joints, which have no ρ: with less of it rounding spoils their residual.
const JOINT_PROXIMAL: f64 = 1e-3;
/// p at first, its change, and the least number of iterations between changes.
const FIRST_POWER: f64 = 0.2;
const POWER_CHANGE: f64 = 0.05;
const LEAST_ITERATIONS: u32 = 10;
/// Ratio of the residuals at which p changes.
const UNBALANCED: f64 = 10.0;
/// Iterations of the power method.
const POWER_ITERATIONS: u32 = 20;

/// The points, the factor and what it is of.
struct System {
    points: Vec<Point>,
    /// Of each point, its mean mobility over its rows.
    units: Vec<f64>,
    elimination: Elimination,
    factor: BlockLdl<f64, Inverse>,
    /// D.
    softness: Vec<f64>,
}

/// Iterates until the watch says that it is enough.
pub fn solve(problem: &ContactProblem, start: &Impulses, watch: &mut Watch) {
    let points = points(problem);
    let mut system = System::new(points, problem.bodies.len());
    let largest = system.largest_eigenvalue();
    let count = system.points.len();
    let (mut power, mut weight) = (FIRST_POWER, 0.0);
    let mut next = weight_of(largest, power);
    let mut x = local(&system.points, start);
    let mut y = x.clone();
    let mut w: Vec<_> = system.velocities(&x);
    for (w, point) in w.iter_mut().zip(&system.points) {
        *w = if point.law == Law::Joint { Vector3::zeros() } else { -shifted(point, w) };
    }
    let (mut h, mut since) = (vec![Vector3::zeros(); count], 0);
    while watch.goes_on(|| given(&system.points, &y)) {
        if next != weight {
            weight = next;
            system.factor(weight);
            since = 0;
        }
        since += 1;
        for (index, point) in system.points.iter().enumerate() {
            let [eta, rho] = weights(point, system.units[index], weight);
            // w is −û: its tangential part is that of −u.
            let shift = Vector3::new(friction(point) * across(&w[index]), 0.0, 0.0);
            h[index] = -(point.free + shift) + x[index] * eta + y[index] * rho - w[index];
        }
        system.solve(&h, &mut x);
        let [mut primal, mut dual]: [f64; 2] = [0.0; 2];
        for (index, point) in system.points.iter().enumerate() {
            let [_, rho] = weights(point, system.units[index], weight);
            let unit = system.units[index];
            if rho == 0.0 {
                y[index] = x[index];
                continue;
            }
            let projected = point.project(&(x[index] + w[index] / rho));
            primal = primal.max((x[index] - projected).norm() * unit);
            dual = dual.max((projected - y[index]).norm() * rho);
            w[index] += (x[index] - projected) * rho;
            y[index] = projected;
        }
        if since >= LEAST_ITERATIONS {
            let change = if primal > UNBALANCED * dual {
                POWER_CHANGE
            } else if dual > UNBALANCED * primal {
                -POWER_CHANGE
            } else {
                0.0
            };
            power += change;
            next = weight_of(largest, power);
        }
    }
}

fn weight_of(largest: f64, power: f64) -> f64 {
    (largest * PROXIMAL).sqrt() * (largest / PROXIMAL).powf(power)
}

/// η and ρ of a point. What nothing bounds needs no second copy of its impulse.
fn weights(point: &Point, unit: f64, weight: f64) -> [f64; 2] {
    let [proximal, penalty] = if point.law == Law::Joint { [JOINT_PROXIMAL, 0.0] } else { [PROXIMAL, weight] };
    [proximal * unit, penalty * unit]
}

fn friction(point: &Point) -> f64 {
    if let Law::Contact(friction) = point.law { friction } else { 0.0 }
}

fn across(vector: &Vector3<f64>) -> f64 {
    vector.y.hypot(vector.z)
}

/// û.
fn shifted(point: &Point, velocity: &Vector3<f64>) -> Vector3<f64> {
    velocity + Vector3::new(friction(point) * across(velocity), 0.0, 0.0)
}

impl System {
    fn new(points: Vec<Point>, bodies: usize) -> Self {
        let edges = points.iter().filter_map(|point| match point.sides[..] {
            [(a, _), (b, _)] => Some([a as u32, b as u32]),
            _ => None,
        });
        let elimination = Elimination::new(&vec![6; bodies], edges, usize::MAX).expect("no bound on the work");
        let unit = |point: &Point| {
            let squares = point.sides.iter().map(|(_, jacobian)| jacobian.norm_squared()).sum::<f64>();
            let rows =
                (0..3).filter(|&row| point.sides.iter().any(|(_, jacobian)| jacobian.row(row).norm_squared() > 0.0));
            // Where nothing moves any number does.
            if squares > 0.0 { squares / rows.count() as f64 } else { 1.0 }
        };
        let units = points.iter().map(unit).collect();
        Self { units, elimination, factor: BlockLdl::default(), softness: Vec::new(), points }
    }

    /// u for those impulses.
    fn velocities(&self, impulses: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut z = vec![Vector6::zeros(); self.elimination.count()];
        self.points.iter().zip(impulses).for_each(|(point, impulse)| point.apply(&mut z, impulse));
        self.points.iter().map(|point| point.velocity(&z)).collect()
    }

    /// L, by the power method on G in units of each point.
    fn largest_eigenvalue(&self) -> f64 {
        let mut vector = vec![Vector3::new(1.0, 0.5, 0.25); self.points.len()];
        let mut largest = 1.0;
        for _ in 0..POWER_ITERATIONS {
            let norm = vector.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
            let scaled: Vec<_> = vector.iter().zip(&self.units).map(|(v, unit)| v / (norm * unit.sqrt())).collect();
            let moved = self.velocities(&scaled);
            let terms = self.points.iter().zip(&moved).zip(&self.units);
            vector = terms.map(|((point, u), unit)| (u - point.free) / unit.sqrt()).collect();
            largest = vector.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        }
        largest
    }

    /// Factors 1 + ĴᵀD Ĵ.
    fn factor(&mut self, weight: f64) {
        let terms = self.points.iter().zip(&self.units);
        self.softness = terms.map(|(point, unit)| 1.0 / weights(point, *unit, weight).iter().sum::<f64>()).collect();
        let Self { points, elimination, factor, softness, .. } = self;
        factor.clear(elimination);
        (0..elimination.count()).for_each(|place| factor.diagonal_mut::<6>(place).fill_with_identity());
        for (point, softness) in points.iter().zip(softness) {
            for (body, jacobian) in &point.sides {
                let mut block = factor.diagonal_mut::<6>(elimination.place(*body as u32) as usize);
                block += jacobian.tr_mul(jacobian) * *softness;
            }
            if let [(a, of_a), (b, of_b)] = &point.sides[..] {
                factor.add(elimination.block(*a as u32, *b as u32), &(of_a.tr_mul(of_b) * *softness));
            }
        }
        assert!(factor.factor(elimination), "one more than a sum of squares is positive");
    }

    /// x of (G + 1/D) x = h.
    fn solve(&self, h: &[Vector3<f64>], x: &mut [Vector3<f64>]) {
        let Self { points, elimination, softness, .. } = self;
        let place = |body: usize| elimination.place(body as u32) as usize;
        let mut t = vec![Vector6::zeros(); elimination.count()];
        for ((point, h), softness) in points.iter().zip(h).zip(softness) {
            point.sides.iter().for_each(|(body, jacobian)| t[place(*body)] += jacobian.tr_mul(h) * *softness);
        }
        self.factor.solve(elimination, &mut t[..]);
        for (((point, h), softness), x) in points.iter().zip(h).zip(softness).zip(x) {
            let moved = point.sides.iter().fold(*h, |sum, (body, jacobian)| sum - jacobian * t[place(*body)]);
            *x = moved * *softness;
        }
    }
}
