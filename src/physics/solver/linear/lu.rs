//! Block LU of a matrix with 6 × 6 blocks, whose values need not be symmetric though its pattern is.
//!
//! As [`BlockLdl`](super::BlockLdl), with blocks above the diagonal of their own: column j gives L_ij = A_ij A_jj⁻¹,
//! and A_ik −= L_ij A_jk for all of its i and k. Within a block on the diagonal pivots are chosen, between blocks they
//! are not.

use super::BodyBlock as Block;
use super::elimination::Target;
use super::{BodyVector, Elimination};
use crate::physics::Refill;

/// The matrix, and then its factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockLu {
    /// By place: A_jj, then its inverse when its turn came.
    diagonal: Vec<Block>,
    /// A_ij of i > j, then L_ij.
    below: Vec<Block>,
    /// A_ji of i > j, then U_ji.
    above: Vec<Block>,
}

impl BlockLu {
    /// One.
    pub fn clear(&mut self, elimination: &Elimination) {
        self.diagonal.reset(elimination.count(), Block::identity());
        for blocks in [&mut self.below, &mut self.above] {
            blocks.reset(elimination.below(), Block::zeros());
        }
    }

    /// The block on the diagonal at a place.
    pub fn diagonal_at(&mut self, place: usize) -> &mut Block {
        &mut self.diagonal[place]
    }

    /// Adds the block of rows a and columns b and that of rows b and columns a, where [`Elimination::block`] of a and b
    /// said.
    pub fn add_at(&mut self, (index, rows_are_b): (u32, bool), ab: &Block, ba: &Block) {
        let (below, above) = if rows_are_b { (ba, ab) } else { (ab, ba) };
        self.below[index as usize] += below;
        self.above[index as usize] += above;
    }

    /// Factors it where it stands. False if a block on the diagonal is singular.
    pub fn factor(&mut self, elimination: &Elimination) -> bool {
        let mut targets = elimination.targets().iter();
        for column in 0..elimination.count() {
            let Some(inverse) = self.diagonal[column].try_inverse() else { return false };
            self.diagonal[column] = inverse;
            let blocks = elimination.blocks(column);
            for i in blocks.clone() {
                let scaled = self.below[i] * inverse;
                self.below[i] = scaled;
                let above = self.above[i];
                for (k, target) in (blocks.start..=i).zip(&mut targets) {
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

    /// Solves A x = b by the factor, b and x in the order of elimination.
    pub fn solve(&self, elimination: &Elimination, x: &mut [BodyVector]) {
        for column in 0..elimination.count() {
            let known = x[column];
            for block in elimination.blocks(column) {
                x[elimination.row(block)] -= self.below[block] * known;
            }
        }
        for column in (0..elimination.count()).rev() {
            let mut left = x[column];
            for block in elimination.blocks(column) {
                left -= self.above[block] * x[elimination.row(block)];
            }
            x[column] = self.diagonal[column] * left;
        }
    }
}
