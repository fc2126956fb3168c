//! Block LU of a matrix with 6 × 6 blocks on the pattern of a body graph, whose values need not be symmetric though
//! its pattern is.
//!
//! As the block LDLᵀ of [`super::super::direct::cholesky`], with blocks above the diagonal of their own: column j gives
//! L_ij = A_ij A_jj⁻¹, and A_ik −= L_ij A_jk for all of its i and k. Within a block on the diagonal pivots are chosen,
//! between blocks they are not.

use super::super::direct::cholesky::{Block, Part};
use super::super::direct::pattern::{Pattern, Target};

/// The matrix, and then its factor.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockLu {
    /// By place: A_jj, then its inverse when its turn came.
    diagonal: Vec<Block>,
    /// A_ij of i > j, then L_ij.
    below: Vec<Block>,
    /// A_ji of i > j, then U_ji.
    above: Vec<Block>,
}

impl BlockLu {
    /// One.
    pub fn clear(&mut self, pattern: &Pattern) {
        self.diagonal.clear();
        self.diagonal.resize(pattern.count(), Block::identity());
        for blocks in [&mut self.below, &mut self.above] {
            blocks.clear();
            blocks.resize(pattern.blocks(), Block::zeros());
        }
    }

    /// The block on the diagonal at a place.
    pub fn diagonal_at(&mut self, place: usize) -> &mut Block {
        &mut self.diagonal[place]
    }

    /// Adds the block of rows a and columns b and that of rows b and columns a, where [`Pattern::block`] of a and b
    /// said.
    pub fn add_at(&mut self, (index, rows_are_b): (u32, bool), ab: &Block, ba: &Block) {
        let (below, above) = if rows_are_b { (ba, ab) } else { (ab, ba) };
        self.below[index as usize] += below;
        self.above[index as usize] += above;
    }

    /// Factors it where it stands. False if a block on the diagonal is singular.
    pub fn factor(&mut self, pattern: &Pattern) -> bool {
        let mut targets = pattern.targets().iter();
        for column in 0..pattern.count() {
            let Some(inverse) = self.diagonal[column].try_inverse() else { return false };
            self.diagonal[column] = inverse;
            let first = pattern.first(column);
            for i in first..first + pattern.rows(column).len() {
                let scaled = self.below[i] * inverse;
                self.below[i] = scaled;
                let above = self.above[i];
                for (k, target) in (first..=i).zip(&mut targets) {
                    match *target {
                        Target::Diagonal(place) => self.diagonal[place as usize] -= scaled * above,
                        Target::Below(block) => {
                            let (down, up) = (scaled * self.above[k], self.below[k] * above);
                            self.below[block as usize] -= down;
                            self.above[block as usize] -= up;
                        }
                    }
                }
            }
        }
        true
    }

    /// Solves A x = b by the factor, b and x in the order of the pattern.
    pub fn solve(&self, pattern: &Pattern, x: &mut [Part]) {
        pattern.substitute(&self.below, x);
        for column in (0..pattern.count()).rev() {
            let mut left = x[column];
            let blocks = &self.above[pattern.first(column)..];
            for (&row, block) in pattern.rows(column).iter().zip(blocks) {
                left -= block * x[row as usize];
            }
            x[column] = self.diagonal[column] * left;
        }
    }
}
