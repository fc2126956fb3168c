//! Preconditioned conjugate residuals on those rows that no bound holds.
//!
//! With the free rows' A = J M⁻¹Jᵀ + Γ, its diagonal D and residual r = η − γλ − J a, the method (E. Stiefel,
//! *Relaxationsmethoden bester Strategie zur Lösung linearer Gleichungssysteme*, 1955; Y. Saad, *Iterative Methods for
//! Sparse Linear Systems*, algorithm 6.20) makes |r| least in the norm of D⁻¹ over all that k products with D⁻¹A can
//! reach. Conjugate gradients make the energy ½λᵀAλ − ηᵀλ least instead and let r grow meanwhile, eightfold on a
//! chain with a heavy end: bad where iterations are few. Redundant rows do no harm: what of r lies outside the range
//! of A is left.
//!
//! z = D⁻¹r, w = Az, β = zᵀw/(zᵀw)_last, p ← z + βp, q = Ap ← w + βq, α = zᵀw/(qᵀD⁻¹q), λ += αp, r −= αq,
//!
//! and t = M⁻¹Jᵀp in the bodies alongside. A product is one pass over the rows that costs what a sweep does.

use super::pgs;
use crate::physics::constraint::row::{Row, Twist};
use crate::physics::scalar::Scalar;

/// The free rows with the method's vectors; in `of_z` and `response` as many twists as bodies.
#[derive(Clone, Default)]
pub(super) struct Face<N> {
    free: Vec<FreeRow<N>>,
    /// M⁻¹Jᵀz.
    of_z: Vec<Twist<N>>,
    /// t = M⁻¹Jᵀp.
    response: Vec<Twist<N>>,
}

/// A row that may move within its bounds.
#[derive(Clone)]
struct FreeRow<N> {
    index: u32,
    lower: N,
    upper: N,
    /// r.
    residual: N,
    /// z.
    scaled: N,
    /// p.
    direction: N,
    /// w.
    product: N,
    /// q.
    image: N,
}

/// zᵀr and zᵀw.
struct Products {
    residual: f64,
    curvature: f64,
}

impl<N: Scalar> Face<N> {
    /// Moves λ of the free rows towards where their residuals vanish, in at most `passes` over the rows, at least 2,
    /// the one that finds r included. Ends as soon as a row comes to a bound, and puts those that came beyond on
    /// theirs: the free rows are others then. Returns the passes.
    pub fn solve(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>], passes: u32) -> u32 {
        self.find_free(rows, accelerations);
        self.response.clear();
        self.response.resize(accelerations.len(), Twist::zero());
        let (mut first, mut last_curvature) = (None, f64::INFINITY);
        for pass in 2..=passes {
            let Products { residual, curvature } = self.multiply(rows, accelerations.len());
            let first = *first.get_or_insert(residual);
            // Solved to rounding, or what is left lies where no force can change it.
            if residual <= N::EPSILON * N::EPSILON * first || curvature <= N::EPSILON * residual {
                return pass;
            }
            let image = self.turn(rows, N::of(curvature / last_curvature));
            last_curvature = curvature;
            if self.advance(rows, accelerations, N::of(curvature / image)) {
                return pass;
            }
        }
        passes
    }

    /// The rows that are within their bounds, or at one that their residual leads away from.
    fn find_free(&mut self, rows: &[Row<N>], accelerations: &[Twist<N>]) {
        self.free.clear();
        let zero = N::zero();
        for (index, row) in (0..).zip(rows) {
            let (lower, upper) = pgs::limits(rows, index as usize);
            let residual = pgs::residual(row, accelerations);
            let held = row.lambda <= lower && residual <= zero || row.lambda >= upper && residual >= zero;
            let held = held || pgs::is_at_norm(rows, index as usize);
            if !held && lower < upper && row.inverse_diagonal > zero {
                let [scaled, direction, product, image] = [zero; 4];
                self.free.push(FreeRow { index, lower, upper, residual, scaled, direction, product, image });
            }
        }
    }

    /// z and w.
    fn multiply(&mut self, rows: &[Row<N>], bodies: usize) -> Products {
        self.of_z.clear();
        self.of_z.resize(bodies, Twist::zero());
        for free in &mut self.free {
            let row = &rows[free.index as usize];
            free.scaled = free.residual * row.inverse_diagonal;
            pgs::add_response(row, free.scaled, &mut self.of_z);
        }
        let mut products = Products { residual: 0.0, curvature: 0.0 };
        for free in &mut self.free {
            let row = &rows[free.index as usize];
            let (a, b) = (&self.of_z[row.a as usize], &self.of_z[row.b as usize]);
            free.product = row.jacobian.dot(a, b) + row.softness * free.scaled;
            products.residual += free.scaled.to_f64() * free.residual.to_f64();
            products.curvature += free.scaled.to_f64() * free.product.to_f64();
        }
        products
    }

    /// p, q and t. Returns qᵀD⁻¹q.
    fn turn(&mut self, rows: &[Row<N>], beta: N) -> f64 {
        for (response, of_z) in self.response.iter_mut().zip(&self.of_z) {
            *response = of_z.plus(response, beta);
        }
        let mut square = 0.0;
        for free in &mut self.free {
            free.direction = free.scaled + free.direction * beta;
            free.image = free.product + free.image * beta;
            square += free.image.to_f64().powi(2) * rows[free.index as usize].inverse_diagonal.to_f64();
        }
        square
    }

    /// λ, r and a, by α along p. Returns whether a row came to a bound.
    fn advance(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>], alpha: N) -> bool {
        for (acceleration, response) in accelerations.iter_mut().zip(&self.response) {
            *acceleration = acceleration.plus(response, alpha);
        }
        let mut bounded = false;
        for free in &mut self.free {
            let row = &mut rows[free.index as usize];
            let wanted = row.lambda + free.direction * alpha;
            row.lambda = wanted.simd_clamp(free.lower, free.upper);
            free.residual -= free.image * alpha;
            if row.lambda != wanted {
                bounded = true;
                pgs::add_response(row, row.lambda - wanted, accelerations);
            }
        }
        bounded
    }
}
