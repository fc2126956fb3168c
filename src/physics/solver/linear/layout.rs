//! Where the values of each block stand, columns one after the other.

use std::ops::Range;

use nalgebra::{SMatrix, SVector, SimdRealField};

/// A block of two bodies' velocities, linear and angular.
pub(crate) type BodyBlock = SMatrix<f64, 6, 6>;
/// A velocity, a momentum or a wrench of one body: linear, angular.
pub(crate) type BodyVector = SVector<f64, 6>;

/// Most rows of a block.
pub(crate) const MOST_ROWS: usize = 6;

/// What an expression is with the rows of a block, 1 to 6, as a constant: compiled once for each. With a number that is not
/// known when compiling, numbers that lie side by side are taken one at a time, or by masks, which wait for each other.
macro_rules! with_rows {
    ($rows:expr, $constant:ident => $what:expr) => {
        match $rows {
            1 => with_rows!(@ 1, $constant => $what),
            2 => with_rows!(@ 2, $constant => $what),
            3 => with_rows!(@ 3, $constant => $what),
            4 => with_rows!(@ 4, $constant => $what),
            5 => with_rows!(@ 5, $constant => $what),
            6 => with_rows!(@ 6, $constant => $what),
            _ => unreachable!("blocks have 1 to 6 rows"),
        }
    };
    (@ $rows:literal, $constant:ident => $what:expr) => {{
        const $constant: usize = $rows;
        $what
    }};
}
pub(super) use with_rows;

/// The numbers that a factorisation is made of: one, or one in each of several lanes.
pub(crate) trait Number: SimdRealField + Copy {}

impl<N: SimdRealField + Copy> Number for N {}

/// The row, by its place, and the values of a block of a column.
pub(super) type Placed<'v, N> = (usize, &'v [N]);

/// Sizes and places of blocks.
pub(super) trait Layout: Copy {
    /// Room for a block of a known size: kernels on local arrays stay in registers.
    type Block<N: Number>: Default;

    /// A copy of a block: in `local` where blocks have a known size, else in `buffer`.
    fn copy<'a, N: Number>(values: &[N], local: &'a mut Self::Block<N>, buffer: &'a mut Vec<N>) -> &'a mut [N];
    /// Has a kernel change a block: a local copy where blocks have a known size, else where it stands.
    fn change<N: Number>(block: &mut [N], kernel: impl FnOnce(&mut [N]));
    /// Rows of a block row, by its place in the order of elimination.
    fn rows(self, place: usize) -> usize;
    /// Values of a block on the diagonal.
    fn diagonal(self, place: usize) -> Range<usize>;
    /// Values of a block below the diagonal; of the block after the last one, where it would begin.
    fn below(self, block: usize) -> usize;
    /// Rows of a vector.
    fn vector(self, place: usize) -> Range<usize>;
    /// The blocks of a column of `n` columns, with the places of their rows.
    fn blocks<'v, N: Number>(self, values: &'v [N], rows: &'v [u32], n: usize) -> impl Iterator<Item = Placed<'v, N>>;
}

/// All blocks have that many rows.
#[derive(Clone, Copy)]
pub(super) struct Uniform<const R: usize>;

impl<const R: usize> Layout for Uniform<R> {
    type Block<N: Number> = Option<[[N; R]; R]>;

    #[inline(always)]
    fn copy<'a, N: Number>(values: &[N], local: &'a mut Option<[[N; R]; R]>, _: &'a mut Vec<N>) -> &'a mut [N] {
        local.insert(block_of(values)).as_flattened_mut()
    }

    #[inline(always)]
    fn change<N: Number>(block: &mut [N], kernel: impl FnOnce(&mut [N])) {
        let mut local: [[N; R]; R] = block_of(block);
        kernel(local.as_flattened_mut());
        block.copy_from_slice(local.as_flattened());
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

    #[inline(always)]
    fn blocks<'v, N: Number>(self, values: &'v [N], rows: &'v [u32], _: usize) -> impl Iterator<Item = Placed<'v, N>> {
        let blocks = values.as_chunks::<R>().0.as_chunks::<R>().0;
        rows.iter().zip(blocks).map(|(&row, block)| (row as usize, block.as_flattened()))
    }
}

#[inline(always)]
fn block_of<N: Number, const R: usize>(values: &[N]) -> [[N; R]; R] {
    *<&[[N; R]; R]>::try_from(values.as_chunks::<R>().0).expect("a whole block")
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
    type Block<N: Number> = ();

    #[inline]
    fn copy<'a, N: Number>(values: &[N], (): &'a mut (), buffer: &'a mut Vec<N>) -> &'a mut [N] {
        buffer.clear();
        buffer.extend_from_slice(values);
        buffer
    }

    #[inline]
    fn change<N: Number>(block: &mut [N], kernel: impl FnOnce(&mut [N])) {
        kernel(block);
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

    fn blocks<'v, N: Number>(self, values: &'v [N], rows: &'v [u32], n: usize) -> impl Iterator<Item = Placed<'v, N>> {
        let mut values = values;
        rows.iter().map(move |&row| {
            let block;
            (block, values) = values.split_at(self.rows(row as usize) * n);
            (row as usize, block)
        })
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
