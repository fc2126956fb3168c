//! Where the values of each block stand, columns one after the other.

use std::ops::Range;

use nalgebra::{SVector, SimdRealField};

/// Most rows of a block.
pub(crate) const MOST_ROWS: usize = 6;

/// The numbers that a factorisation is made of: one, or one in each of several lanes.
pub(crate) trait Number: SimdRealField + Copy {}

impl<N: SimdRealField + Copy> Number for N {}

/// Sizes and places of blocks.
pub(super) trait Layout: Copy {
    /// Room for a block of a vector.
    type Rows<N: Number>: AsRef<[N]> + AsMut<[N]>;

    fn zeros<N: Number>() -> Self::Rows<N>;
    /// Rows of a block row, by its place in the order of elimination.
    fn rows(self, place: usize) -> usize;
    /// Values of a block on the diagonal.
    fn diagonal(self, place: usize) -> Range<usize>;
    /// Values of a block below the diagonal; of the block after the last one, where it would begin.
    fn below(self, block: usize) -> usize;
    /// Rows of a vector.
    fn vector(self, place: usize) -> Range<usize>;
}

/// All blocks have that many rows.
#[derive(Clone, Copy)]
pub(super) struct Uniform<const R: usize>;

impl<const R: usize> Layout for Uniform<R> {
    type Rows<N: Number> = [N; R];

    #[inline]
    fn zeros<N: Number>() -> [N; R] {
        [N::zero(); R]
    }

    #[inline]
    fn rows(self, _: usize) -> usize {
        R
    }

    #[inline]
    fn diagonal(self, place: usize) -> Range<usize> {
        place * R * R..place * R * R + R * R
    }

    #[inline]
    fn below(self, block: usize) -> usize {
        block * R * R
    }

    #[inline]
    fn vector(self, place: usize) -> Range<usize> {
        place * R..place * R + R
    }
}

/// Blocks of unlike sizes: rows of each, and where its values begin, with an end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Mixed {
    pub rows: Vec<u8>,
    pub diagonal: Vec<u32>,
    pub below: Vec<u32>,
    pub vector: Vec<u32>,
}

impl Layout for &Mixed {
    type Rows<N: Number> = [N; MOST_ROWS];

    fn zeros<N: Number>() -> [N; MOST_ROWS] {
        [N::zero(); MOST_ROWS]
    }

    fn rows(self, place: usize) -> usize {
        usize::from(self.rows[place])
    }

    fn diagonal(self, place: usize) -> Range<usize> {
        self.diagonal[place] as usize..self.diagonal[place + 1] as usize
    }

    fn below(self, block: usize) -> usize {
        self.below[block] as usize
    }

    fn vector(self, place: usize) -> Range<usize> {
        self.vector[place] as usize..self.vector[place + 1] as usize
    }
}

/// A vector in blocks: one array each where all have the same size, or all numbers one after the other.
pub(crate) trait BlockVector<N> {
    /// The block at a place of the order, which has the rows of that range.
    fn block(&mut self, place: usize, rows: Range<usize>) -> &mut [N];
}

impl<N: Number, const R: usize> BlockVector<N> for [SVector<N, R>] {
    #[inline]
    fn block(&mut self, place: usize, _: Range<usize>) -> &mut [N] {
        self[place].as_mut_slice()
    }
}

impl<N: Number> BlockVector<N> for [N] {
    #[inline]
    fn block(&mut self, _: usize, rows: Range<usize>) -> &mut [N] {
        &mut self[rows]
    }
}
