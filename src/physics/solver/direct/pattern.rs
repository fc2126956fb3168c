//! Which blocks of the Cholesky factor of a body graph are not zero.
//!
//! Bodies are eliminated by least degree (Tinney & Walker 1967; George & Liu 1989): the one with the fewest
//! neighbours left goes first, and its neighbours become neighbours of each other. A tree is
//! eliminated from its leaves, without fill.

use std::ops::{Mul, SubAssign};

/// Order of elimination and the blocks of each column of the factor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pattern {
    /// Where in the order each body goes.
    place: Vec<u32>,
    /// Column k has blocks `starts[k]..starts[k + 1]`.
    starts: Vec<u32>,
    /// The row of each block, ascending within a column.
    rows: Vec<u32>,
    /// For each column, and in it each block i and each block k up to it: what L_i L_kᵀ is taken from.
    targets: Vec<Target>,
}

/// A block of the matrix below the diagonal, or on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Of that row and column.
    Diagonal(u32),
    /// The block of that index.
    Below(u32),
}

impl Pattern {
    /// Of a graph of so many bodies; none if its factorisation takes more than `most` products of blocks.
    pub fn new(count: usize, edges: impl Iterator<Item = [u32; 2]>, most: usize) -> Option<Self> {
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
        for [a, b] in edges {
            link(&mut neighbours, a, b);
            link(&mut neighbours, b, a);
        }
        let (mut order, mut place) = (Vec::with_capacity(count), vec![u32::MAX; count]);
        let mut columns = Vec::with_capacity(count);
        let mut products = 0;
        for step in 0..count as u32 {
            let left = (0..count as u32).filter(|&body| place[body as usize] == u32::MAX);
            let body = left.min_by_key(|&body| neighbours[body as usize].len())?;
            place[body as usize] = step;
            order.push(body);
            let column = std::mem::take(&mut neighbours[body as usize]);
            products += column.len() * (column.len() + 3) / 2;
            if products > most {
                return None;
            }
            for (index, &one) in column.iter().enumerate() {
                neighbours[one as usize].retain(|&other| other != body);
                for &other in &column[..index] {
                    link(&mut neighbours, one, other);
                    link(&mut neighbours, other, one);
                }
            }
            columns.push(column);
        }
        Some(Self::of_columns(place, columns))
    }

    fn of_columns(place: Vec<u32>, mut columns: Vec<Vec<u32>>) -> Self {
        let mut pattern = Self { place, starts: vec![0], ..Self::default() };
        for column in &mut columns {
            column.iter_mut().for_each(|body| *body = pattern.place[*body as usize]);
            column.sort_unstable();
            pattern.rows.extend_from_slice(column);
            pattern.starts.push(pattern.rows.len() as u32);
        }
        for column in &columns {
            for (index, &row) in column.iter().enumerate() {
                for &other in &column[..index] {
                    pattern.targets.push(pattern.find(other, row));
                }
                pattern.targets.push(Target::Diagonal(row));
            }
        }
        pattern
    }

    /// The block of a column and a row after it, both by place.
    fn find(&self, column: u32, row: u32) -> Target {
        let first = self.starts[column as usize];
        let offset = self.rows(column as usize).partition_point(|&other| other < row);
        Target::Below(first + offset as u32)
    }

    /// Bodies.
    pub fn count(&self) -> usize {
        self.place.len()
    }

    /// Blocks below the diagonal.
    pub fn blocks(&self) -> usize {
        self.rows.len()
    }

    /// Products of blocks in a factorisation.
    pub fn products(&self) -> usize {
        self.rows.len() + self.targets.len()
    }

    /// Where a body goes in the order.
    pub fn place(&self, body: u32) -> u32 {
        self.place[body as usize]
    }

    /// Block of two neighbours, and whether its row is that of `b`.
    pub fn block(&self, a: u32, b: u32) -> (u32, bool) {
        let (a, b) = (self.place(a), self.place(b));
        match self.find(a.min(b), a.max(b)) {
            Target::Below(block) => (block, a < b),
            Target::Diagonal(_) => unreachable!("a block below the diagonal"),
        }
    }

    /// Index of the first block of a column.
    pub fn first(&self, column: usize) -> usize {
        self.starts[column] as usize
    }

    /// Rows of a column's blocks, by place.
    pub fn rows(&self, column: usize) -> &[u32] {
        &self.rows[self.starts[column] as usize..self.starts[column + 1] as usize]
    }

    /// x ← L⁻¹ x for the blocks of L below its diagonal, which has ones, in the order of the pattern.
    #[inline]
    pub fn substitute<B, X>(&self, below: &[B], x: &mut [X])
    where
        X: Copy + SubAssign,
        for<'b> &'b B: Mul<X, Output = X>,
    {
        for column in 0..self.count() {
            let known = x[column];
            let blocks = &below[self.first(column)..];
            for (&row, block) in self.rows(column).iter().zip(blocks) {
                x[row as usize] -= block * known;
            }
        }
    }

    /// What the products of all columns' blocks are taken from, in their order.
    pub fn targets(&self) -> &[Target] {
        &self.targets
    }
}

/// Adds `b` to the neighbours of `a`.
fn link(neighbours: &mut [Vec<u32>], a: u32, b: u32) {
    let list = &mut neighbours[a as usize];
    if !list.contains(&b) {
        list.push(b);
    }
}
