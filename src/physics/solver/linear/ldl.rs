//! Block LDLᵀ of a symmetric matrix: A = L D Lᵀ, L with ones on its diagonal, D by blocks, in the order of
//! [`Elimination`].
//!
//! Column j: D_j is the remainder of A_jj; L_ij = A_ij D_j⁻¹; then A_ik −= L_ij D_j L_kjᵀ = L_ij A_kjᵀ for all i ≥ k of
//! the column (right-looking). On a tree that is two products of blocks a column.

use std::marker::PhantomData;

use nalgebra::{SMatrix, SMatrixViewMut};

use super::elimination::{Elimination, Sizes, Target, with_layout};
use super::layout::{BlockVector, Layout, MOST_ROWS, Number, Uniform, with_rows};
use super::pivot::Pivot;

/// The matrix, and then its factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockLdl<N, P> {
    /// By place: A_jj, then what [`Pivot`] makes of D_j.
    pub(super) diagonal: Vec<N>,
    /// A_ij, then L_ij.
    pub(super) below: Vec<N>,
    /// A_ij of the column at hand.
    column: Vec<N>,
    /// D_j and L_ij at hand, where blocks are of unlike sizes.
    pivot: Vec<N>,
    scaled: Vec<N>,
    pivots: PhantomData<P>,
}

impl<N: Number, P: Pivot<N>> BlockLdl<N, P> {
    /// Sets all blocks to zero.
    pub fn clear(&mut self, elimination: &Elimination) {
        let (diagonal, below) = elimination.values();
        for (blocks, values) in [(&mut self.diagonal, diagonal), (&mut self.below, below)] {
            blocks.clear();
            blocks.resize(values, N::zero());
        }
    }

    /// The block on the diagonal at a place in the order, where all blocks have R rows.
    #[inline]
    pub fn diagonal_mut<const R: usize>(&mut self, place: usize) -> SMatrixViewMut<'_, N, R, R> {
        SMatrixViewMut::from_slice(&mut self.diagonal[Uniform::<R>.diagonal(place)])
    }

    /// The block below the diagonal of that index, where all blocks have R rows.
    #[inline]
    pub fn below_mut<const R: usize>(&mut self, block: usize) -> SMatrixViewMut<'_, N, R, R> {
        let layout = Uniform::<R>;
        SMatrixViewMut::from_slice(&mut self.below[layout.below(block)..layout.below(block + 1)])
    }

    /// The columns of the block on the diagonal at a place in the order.
    pub fn diagonal_at(&mut self, elimination: &Elimination, place: usize) -> &mut [N] {
        match elimination.sizes() {
            Sizes::Three => &mut self.diagonal[Uniform::<3>.diagonal(place)],
            Sizes::Six => &mut self.diagonal[Uniform::<6>.diagonal(place)],
            Sizes::Mixed(mixed) => &mut self.diagonal[mixed.diagonal(place)],
        }
    }

    /// The columns of the block below the diagonal of that index.
    pub fn below_at(&mut self, elimination: &Elimination, block: usize) -> &mut [N] {
        match elimination.sizes() {
            Sizes::Three => &mut self.below[Uniform::<3>.below(block)..Uniform::<3>.below(block + 1)],
            Sizes::Six => &mut self.below[Uniform::<6>.below(block)..Uniform::<6>.below(block + 1)],
            Sizes::Mixed(mixed) => &mut self.below[mixed.below(block)..mixed.below(block + 1)],
        }
    }

    /// Adds a block and its transpose below and above the diagonal, where [`Elimination::block`] of its two nodes said.
    pub fn add<const R: usize>(&mut self, (block, is_transposed): (u32, bool), values: &SMatrix<N, R, R>) {
        let mut own = self.below_mut::<R>(block as usize);
        if is_transposed {
            own += values.transpose();
        } else {
            own += values;
        }
    }

    /// Adds that share of its trace to the diagonal of each block on the diagonal.
    pub fn shift(&mut self, elimination: &Elimination, share: N) {
        let mut rest = &mut self.diagonal[..];
        for place in 0..elimination.count() {
            let n = elimination.rows_at(place);
            let block;
            (block, rest) = std::mem::take(&mut rest).split_at_mut(n * n);
            let trace = block.iter().step_by(n + 1).fold(N::zero(), |sum, &value| sum + value);
            let shift = share * trace;
            block.iter_mut().step_by(n + 1).for_each(|value| *value += shift);
        }
    }

    /// Factors it where it stands. False if a block on the diagonal is refused.
    pub fn factor(&mut self, elimination: &Elimination) -> bool {
        with_layout!(elimination, layout => self.factor_as(elimination, layout))
    }

    /// Solves A x = b by the factor, b and x in the order of elimination.
    #[inline]
    pub fn solve<X: BlockVector<N> + ?Sized>(&self, elimination: &Elimination, x: &mut X) {
        with_layout!(elimination, layout => self.solve_as(elimination, layout, x))
    }

    #[inline]
    fn factor_as<L: Layout>(&mut self, elimination: &Elimination, layout: L) -> bool {
        let Self { diagonal, below, column: originals, pivot: pivot_buffer, scaled: scaled_buffer, .. } = self;
        let mut targets = elimination.targets().iter();
        for column in 0..elimination.count() {
            let n = layout.rows(column);
            let place = layout.diagonal(column);
            let mut local = L::Block::default();
            let pivot = L::copy(&diagonal[place.clone()], &mut local, pivot_buffer);
            if !P::factor(pivot, n) {
                return false;
            }
            diagonal[place].copy_from_slice(pivot);
            let blocks = elimination.blocks(column);
            originals.clear();
            originals.extend_from_slice(&below[layout.below(blocks.start)..layout.below(blocks.end)]);
            for block in blocks.clone() {
                let rows = layout.rows(elimination.row(block));
                let values = layout.below(block)..layout.below(block + 1);
                let first = layout.below(blocks.start);
                let original = &originals[values.start - first..values.end - first];
                let mut local = L::Block::default();
                let scaled = L::copy(original, &mut local, scaled_buffer);
                P::divide(scaled, original, pivot, rows, n);
                below[values].copy_from_slice(scaled);
                let mut rest = &originals[..];
                for (&other, target) in elimination.rows(column)[..=block - blocks.start].iter().zip(&mut targets) {
                    let columns = layout.rows(other as usize);
                    let original;
                    (original, rest) = rest.split_at(columns * n);
                    let target = match *target {
                        Target::Diagonal(place) => &mut diagonal[layout.diagonal(place as usize)],
                        Target::Below(block) => {
                            &mut below[layout.below(block as usize)..layout.below(block as usize + 1)]
                        }
                    };
                    L::change(target, |sum| {
                        subtract_product(sum, scaled, original, [rows, n, columns], P::IS_FUSED);
                    });
                }
            }
        }
        true
    }

    #[inline]
    fn solve_as<L: Layout, X: BlockVector<N> + ?Sized>(&self, elimination: &Elimination, layout: L, x: &mut X) {
        let column_of = |column: usize| {
            let blocks = elimination.blocks(column);
            (elimination.rows(column), &self.below[layout.below(blocks.start)..layout.below(blocks.end)])
        };
        for column in 0..elimination.count() {
            let n = layout.rows(column);
            let mut known = [N::zero(); MOST_ROWS];
            let known = &mut known[..n];
            known.copy_from_slice(x.block(column, layout.vector(column)));
            let (rows, values) = column_of(column);
            for (row, block) in layout.blocks(values, rows, n) {
                subtract_times(x.block(row, layout.vector(row)), block, known);
            }
        }
        for column in (0..elimination.count()).rev() {
            let n = layout.rows(column);
            let mut sums = [N::zero(); MOST_ROWS];
            let sums = &mut sums[..n];
            sums.copy_from_slice(x.block(column, layout.vector(column)));
            P::solve(&self.diagonal[layout.diagonal(column)], sums, n);
            let (rows, values) = column_of(column);
            for (row, block) in layout.blocks(values, rows, n) {
                subtract_transposed_times(sums, block, x.block(row, layout.vector(row)));
            }
            x.block(column, layout.vector(column)).copy_from_slice(sums);
        }
    }
}

/// y −= A x.
#[inline(always)]
fn subtract_times<N: Number>(y: &mut [N], a: &[N], x: &[N]) {
    let rows = y.len();
    for (row, y) in y.iter_mut().enumerate() {
        let first = a[row] * x[0];
        *y -= (1..x.len()).fold(first, |sum, column| sum + a[column * rows + row] * x[column]);
    }
}

/// y −= Aᵀ x.
#[inline(always)]
fn subtract_transposed_times<N: Number>(y: &mut [N], a: &[N], x: &[N]) {
    let rows = x.len();
    for (column, y) in y.iter_mut().enumerate() {
        let first = a[column * rows] * x[0];
        *y -= (1..rows).fold(first, |sum, row| sum + a[column * rows + row] * x[row]);
    }
}

/// target −= a bᵀ for blocks of rows × inner and columns × inner.
#[inline(always)]
fn subtract_product<N: Number>(target: &mut [N], a: &[N], b: &[N], sizes: [usize; 3], is_fused: bool) {
    let [rows, inner, columns] = sizes;
    with_rows!(rows, R => {
        let (targets, a) = (target.as_chunks_mut::<R>().0, a.as_chunks::<R>().0);
        for column in 0..columns {
            let target = &mut targets[column];
            // Along the rows, which lie side by side.
            let mut sums = if is_fused { *target } else { a[0].map(|value| value * b[column]) };
            for k in usize::from(!is_fused)..inner {
                let factor = b[k * columns + column];
                for (sum, &value) in sums.iter_mut().zip(&a[k]) {
                    if is_fused { *sum = value.simd_mul_add(-factor, *sum) } else { *sum += value * factor }
                }
            }
            if is_fused {
                *target = sums;
            } else {
                target.iter_mut().zip(sums).for_each(|(target, sum)| *target -= sum);
            }
        }
    });
}
