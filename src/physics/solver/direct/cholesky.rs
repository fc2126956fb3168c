//! Block LDLᵀ of a symmetric positive definite matrix with 6 × 6 blocks on the pattern of a body graph:
//! A = L D Lᵀ, L with ones on its diagonal, D by blocks, in the order of [`Pattern`].
//!
//! Column j: D_j is what is left of A_jj; L_ij = A_ij D_j⁻¹; then A_ik −= L_ij D_j L_kjᵀ = L_ij A_kjᵀ for all i ≥ k of
//! the column (right-looking). On a tree that is two products a body.

use nalgebra::{ArrayStorage, SMatrix, SVector};

use super::pattern::{Pattern, Target};

/// A block: two bodies' velocities, linear and angular.
pub(crate) type Block = SMatrix<f64, 6, 6>;
/// The columns of a block.
pub(crate) type Columns = [[f64; 6]; 6];
/// What goes with one body: linear, angular.
pub(crate) type Part = SVector<f64, 6>;

/// The matrix, and then its factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockMatrix {
    /// By place: A_jj, then D_j⁻¹.
    diagonal: Vec<Block>,
    /// A_ij, then L_ij.
    below: Vec<Block>,
    /// A_ij of the column at hand.
    column: Vec<Block>,
}

impl BlockMatrix {
    /// Zero.
    pub fn clear(&mut self, pattern: &Pattern) {
        self.diagonal.clear();
        self.diagonal.resize(pattern.count(), Block::zeros());
        self.below.clear();
        self.below.resize(pattern.blocks(), Block::zeros());
    }

    /// The block on the diagonal of a body.
    pub fn diagonal_mut(&mut self, pattern: &Pattern, body: u32) -> &mut Block {
        &mut self.diagonal[pattern.place(body) as usize]
    }

    /// Adds a block whose rows are `a`'s and columns `b`'s, and its transpose.
    pub fn add(&mut self, pattern: &Pattern, a: u32, b: u32, block: &Block) {
        self.add_at(pattern.block(a, b), block);
    }

    /// The block on the diagonal at a place in the order.
    pub fn diagonal_at(&mut self, place: usize) -> &mut Block {
        &mut self.diagonal[place]
    }

    /// Adds a block whose rows are `a`'s and columns `b`'s, and its transpose, where [`Pattern::block`] of the two
    /// said.
    pub fn add_at(&mut self, (index, rows_are_b): (u32, bool), block: &Block) {
        if rows_are_b {
            self.below[index as usize] += block.transpose();
        } else {
            self.below[index as usize] += block;
        }
    }

    /// Factors it where it stands. False if it is not positive definite.
    pub fn factor(&mut self, pattern: &Pattern) -> bool {
        let mut targets = pattern.targets().iter();
        for column in 0..pattern.count() {
            let Some(inverse) = invert(&self.diagonal[column]) else { return false };
            self.diagonal[column] = inverse;
            let (first, count) = (pattern.first(column), pattern.rows(column).len());
            self.column.clear();
            self.column.extend_from_slice(&self.below[first..first + count]);
            for (index, original) in self.column.iter().enumerate() {
                let scaled = product(original, &inverse);
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
        true
    }

    /// Solves A x = b by the factor, b and x in the order of the pattern.
    pub fn solve(&self, pattern: &Pattern, x: &mut [Part]) {
        pattern.substitute(&self.below, x);
        for column in (0..pattern.count()).rev() {
            let mut sum = self.diagonal[column] * x[column];
            let blocks = &self.below[pattern.first(column)..];
            for (&row, block) in pattern.rows(column).iter().zip(blocks) {
                sum -= block.tr_mul(&x[row as usize]);
            }
            x[column] = sum;
        }
    }
}

/// a b of which b is symmetric.
#[inline]
fn product(a: &Block, b: &Block) -> Block {
    let mut result = Columns::default();
    for (column, factors) in result.iter_mut().zip(&b.data.0) {
        add_combination(column, &a.data.0, factors);
    }
    Block::from_data(ArrayStorage(result))
}

/// target −= a bᵀ.
#[inline]
fn subtract_product(target: &mut Block, a: &Block, b: &Block) {
    for (row, column) in target.data.0.iter_mut().enumerate() {
        let factors = b.data.0.map(|column| -column[row]);
        add_combination(column, &a.data.0, &factors);
    }
}

/// target += Σ columns · factors, which stays in vector registers.
#[inline]
fn add_combination(target: &mut [f64; 6], columns: &Columns, factors: &[f64; 6]) {
    for (column, factor) in columns.iter().zip(factors) {
        for (sum, entry) in target.iter_mut().zip(column) {
            *sum = entry.mul_add(*factor, *sum);
        }
    }
}

/// The inverse of a symmetric positive definite block, by sweeping its pivots one by one (Goodnight 1979).
#[inline]
fn invert(block: &Block) -> Option<Block> {
    let mut swept = block.data.0;
    for pivot in 0..6 {
        let square = swept[pivot][pivot];
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let inverse = 1.0 / square;
        let column = swept[pivot];
        for (_, other) in swept.iter_mut().enumerate().filter(|(other, _)| *other != pivot) {
            let share = other[pivot] * inverse;
            for (entry, of_pivot) in other.iter_mut().zip(&column) {
                *entry = of_pivot.mul_add(-share, *entry);
            }
            other[pivot] = share;
        }
        swept[pivot] = column.map(|entry| entry * -inverse);
        swept[pivot][pivot] = inverse;
    }
    Some(Block::from_data(ArrayStorage(swept)))
}
