//! Block LDLᵀ of a symmetric, positive semidefinite matrix with 3 × 3 blocks, one row of blocks a joint.
//!
//! The matrix is A + E with E = ε diag A: the shift makes a factor of what redundant or singular joints leave singular.
//! Whoever solves does so by residuals, λ ← λ + (A + E)⁻¹(b − A λ), the method of multipliers (Hestenes 1969; Powell
//! 1969) or proximal point iteration (Rockafellar 1976; Carpentier, Budhiraja and Mansard 2021, "Proximal and sparse
//! resolution of constrained dynamics"): each turn divides the error along an eigenvector of eigenvalue σ by 1 + σ/E,
//! and where σ = 0 it stays at zero, so that λ is the least one that gives the same motion.
//!
//! Column j: D_j is what is left of A_jj; L_ij = A_ij D_j⁻¹; then A_ik −= L_ij A_kjᵀ for all i ≥ k of the column. On a
//! tree of bodies with two joints each that is two products a joint.

use nalgebra::{Matrix3, Vector3};

use crate::physics::solver::direct::pattern::{Pattern, Target};

/// The matrix, and then its factor, its rows in the order of elimination.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockFactor {
    /// A_jj, then D_j.
    pub diagonal: Vec<Matrix3<f64>>,
    pivots: Vec<Pivot>,
    /// A_ij, then L_ij.
    pub below: Vec<Matrix3<f64>>,
    /// A_ij of the column at hand.
    column: Vec<Matrix3<f64>>,
}

impl BlockFactor {
    /// Zero.
    pub fn clear(&mut self, pattern: &Pattern) {
        self.diagonal.clear();
        self.diagonal.resize(pattern.count(), Matrix3::zeros());
        self.below.clear();
        self.below.resize(pattern.blocks(), Matrix3::zeros());
    }

    /// Factors A + E where A stands.
    pub fn factor(&mut self, pattern: &Pattern, shift: f64) {
        for block in &mut self.diagonal {
            let shift = shift * block.trace();
            for axis in 0..3 {
                block[(axis, axis)] += shift;
            }
        }
        self.pivots.clear();
        let mut targets = pattern.targets().iter();
        for column in 0..pattern.count() {
            let pivot = Pivot::new(&self.diagonal[column]);
            self.pivots.push(pivot);
            let (first, count) = (pattern.first(column), pattern.rows(column).len());
            self.column.clear();
            self.column.extend_from_slice(&self.below[first..first + count]);
            for (index, original) in self.column.iter().enumerate() {
                let scaled = pivot.divide(original);
                self.below[first + index] = scaled;
                for (other, target) in self.column[..=index].iter().zip(&mut targets) {
                    let target = match *target {
                        Target::Diagonal(place) => &mut self.diagonal[place as usize],
                        Target::Below(block) => &mut self.below[block as usize],
                    };
                    subtract_product(target, &scaled, other);
                }
            }
        }
    }

    /// x ← (A + E)⁻¹ x.
    pub fn solve(&self, pattern: &Pattern, x: &mut [Vector3<f64>]) {
        pattern.substitute(&self.below, x);
        for column in (0..pattern.count()).rev() {
            let mut sum = self.pivots[column].solve(&x[column]);
            let blocks = &self.below[pattern.first(column)..];
            for (&row, block) in pattern.rows(column).iter().zip(blocks) {
                sum -= block.tr_mul(&x[row as usize]);
            }
            x[column] = sum;
        }
    }
}

/// target −= a bᵀ.
#[inline]
fn subtract_product(target: &mut Matrix3<f64>, a: &Matrix3<f64>, b: &Matrix3<f64>) {
    for column in 0..3 {
        for row in 0..3 {
            let sum = a[(row, 0)] * b[(column, 0)] + a[(row, 1)] * b[(column, 1)] + a[(row, 2)] * b[(column, 2)];
            target[(row, column)] -= sum;
        }
    }
}

/// LDLᵀ of a block on the diagonal. (Its inverse would spoil all directions where the pivots of one are tiny.)
#[derive(Clone, Copy, Debug)]
struct Pivot {
    /// L below its diagonal: (1, 0), (2, 0), (2, 1).
    lower: [f64; 3],
    /// D⁻¹; zero along what does not move.
    inverse: [f64; 3],
}

impl Pivot {
    #[inline]
    fn new(m: &Matrix3<f64>) -> Self {
        let safe = |pivot: f64| if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
        let d0 = safe(m[(0, 0)]);
        let (l10, l20) = (m[(1, 0)] * d0, m[(2, 0)] * d0);
        let d1 = safe(m[(1, 1)] - l10 * m[(1, 0)]);
        let rest = m[(2, 1)] - l20 * m[(1, 0)];
        let l21 = rest * d1;
        let d2 = safe(m[(2, 2)] - l20 * m[(2, 0)] - l21 * rest);
        Self { lower: [l10, l20, l21], inverse: [d0, d1, d2] }
    }

    #[inline]
    fn solve(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let [l10, l20, l21] = self.lower;
        let y = x.y - l10 * x.x;
        let z = (x.z - l20 * x.x - l21 * y) * self.inverse[2];
        let y = y * self.inverse[1] - l21 * z;
        Vector3::new(x.x * self.inverse[0] - l10 * y - l20 * z, y, z)
    }

    /// m D⁻¹.
    #[inline]
    fn divide(&self, m: &Matrix3<f64>) -> Matrix3<f64> {
        let row = |row: usize| self.solve(&Vector3::new(m[(row, 0)], m[(row, 1)], m[(row, 2)]));
        let (x, y, z) = (row(0), row(1), row(2));
        Matrix3::new(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z)
    }
}
