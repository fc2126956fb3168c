//! Block LU of a matrix with 6 × 6 blocks, whose values need not be symmetric though its pattern is.
//!
//! As [`BlockLdl`](super::BlockLdl), with blocks above the diagonal of their own: column j gives L_ij = A_ij A_jj⁻¹,
//! and A_ik −= L_ij A_jk for all of its i and k. Within a block on the diagonal pivots are chosen, between blocks they
//! are not.

use nalgebra::ArrayStorage;

use super::BodyBlock as Block;
use super::elimination::Target;
use super::pivot::invert;
use super::{BodyVector, Elimination};
use crate::physics::Refill;

/// Pivot of a block over the largest number below it up to which rows are exchanged: numbers grow to no more than its
/// inverse in a column.
const SMALL_PIVOT: f64 = 0.1;

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

    /// The block of rows a and columns b and that of rows b and columns a, where [`Elimination::block`] of a and b said.
    pub fn blocks_at(&mut self, (index, rows_are_b): (u32, bool)) -> [&mut Block; 2] {
        let (below, above) = (&mut self.below[index as usize], &mut self.above[index as usize]);
        if rows_are_b { [above, below] } else { [below, above] }
    }

    /// Factors it where it stands. False if a block on the diagonal is singular.
    pub fn factor(&mut self, elimination: &Elimination) -> bool {
        let mut targets = elimination.targets().iter();
        for column in 0..elimination.count() {
            let Some(inverse) = inverse(&self.diagonal[column]) else { return false };
            self.diagonal[column] = inverse;
            let blocks = elimination.blocks(column);
            for i in blocks.clone() {
                let scaled = self.below[i] * inverse;
                self.below[i] = scaled;
                let above = self.above[i];
                for (k, target) in (blocks.start..=i).zip(&mut targets) {
                    match *target {
                        Target::Diagonal(place) => {
                            subtract_product(&mut self.diagonal[place as usize], &scaled, &above)
                        }
                        Target::Below(block) => {
                            subtract_product(&mut self.below[block as usize], &scaled, &self.above[k]);
                            subtract_product(&mut self.above[block as usize], &self.below[k], &above);
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

/// C −= A B, each product of numbers subtracted with one rounding (FMA).
#[inline(always)]
fn subtract_product(target: &mut Block, a: &Block, b: &Block) {
    for (target, factors) in target.data.0.iter_mut().zip(&b.data.0) {
        let mut sums = *target;
        for (column, factor) in a.data.0.iter().zip(factors) {
            for (sum, value) in sums.iter_mut().zip(column) {
                *sum = value.mul_add(-factor, *sum);
            }
        }
        *target = sums;
    }
}

/// The inverse; none of a singular block. Without pivots chosen as long as none is much smaller than what is below it, as it
/// seldom is: to exchange rows takes several times as long as all the rest.
fn inverse(block: &Block) -> Option<Block> {
    let mut columns = block.data.0;
    let is_inverted = invert(&mut columns, |pivot, column| {
        let largest = column.iter().fold(0.0, |most, value| if value.abs() > most { value.abs() } else { most });
        pivot.abs() > SMALL_PIVOT * largest
    });
    if is_inverted { Some(Block::from_data(ArrayStorage(columns))) } else { block.try_inverse() }
}
