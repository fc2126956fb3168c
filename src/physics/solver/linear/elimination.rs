//! The symbolic half: the order of elimination, and which blocks of the factor are not zero.
//!
//! Block rows, one a node of a graph, are eliminated in the order of [`ordering`](super::ordering). A node's neighbours
//! become neighbours of each other as it goes.

use std::ops::Range;

use super::layout::{Layout, MOST_ROWS, Mixed, Uniform};
use super::ordering::{self, Order};

/// Order of elimination and the blocks of each column of the factor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Elimination {
    /// Where in the order each node stands.
    place: Vec<u32>,
    sizes: Sizes,
    /// Column k has blocks `starts[k]..starts[k + 1]`.
    starts: Vec<u32>,
    /// The row of each block, by place, ascending within a column.
    rows: Vec<u32>,
    /// For each column, and in it each block i and each block k up to it: the block that L_i A_kᵀ is subtracted from.
    targets: Vec<Target>,
}

/// Rows of the blocks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Sizes {
    /// 3 in all.
    Three,
    /// 6 in all.
    #[default]
    Six,
    /// Any, from 1 to 6.
    Mixed(Mixed),
}

/// A block of the matrix on its diagonal or below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Of that row and column.
    Diagonal(u32),
    /// The block of that index.
    Below(u32),
}

/// What an expression is with the layout of an elimination's blocks: compiled once for each of the sizes.
macro_rules! with_layout {
    ($elimination:expr, $layout:ident => $what:expr) => {
        match $elimination.sizes() {
            Sizes::Three => {
                let $layout = Uniform::<3>;
                $what
            }
            Sizes::Six => {
                let $layout = Uniform::<6>;
                $what
            }
            Sizes::Mixed($layout) => $what,
        }
    };
}
pub(super) use with_layout;

impl Elimination {
    /// Of a graph whose nodes have so many rows each; none if its factorisation takes more than `most` products of
    /// blocks.
    pub fn new(rows: &[u8], edges: impl Iterator<Item = [u32; 2]>, most: usize) -> Option<Self> {
        assert!(rows.iter().all(|&rows| (1..=MOST_ROWS).contains(&usize::from(rows))), "blocks have 1 to 6 rows");
        let order = ordering::find(rows.len(), edges, most)?;
        let mut elimination = Self::of_columns(order);
        elimination.sizes = match rows.first() {
            Some(3) if rows.iter().all(|&rows| rows == 3) => Sizes::Three,
            Some(6) | None if rows.iter().all(|&rows| rows == 6) => Sizes::Six,
            _ => Sizes::Mixed(elimination.lay_out(rows)),
        };
        Some(elimination)
    }

    fn of_columns(Order { place, mut columns }: Order) -> Self {
        let mut elimination = Self { place, starts: vec![0], ..Self::default() };
        for column in &mut columns {
            column.iter_mut().for_each(|node| *node = elimination.place[*node as usize]);
            column.sort_unstable();
            elimination.rows.extend_from_slice(column);
            elimination.starts.push(elimination.rows.len() as u32);
        }
        for column in &columns {
            for (index, &row) in column.iter().enumerate() {
                let below = column[..index].iter().map(|&other| Target::Below(elimination.find(other, row)));
                let below: Vec<_> = below.collect();
                elimination.targets.extend(below);
                elimination.targets.push(Target::Diagonal(row));
            }
        }
        elimination
    }

    fn lay_out(&self, of_nodes: &[u8]) -> Mixed {
        let mut rows = vec![0; of_nodes.len()];
        for (&place, &own) in self.place.iter().zip(of_nodes) {
            rows[place as usize] = own;
        }
        let size = |place: usize| u32::from(rows[place]);
        let columns = (0..self.count()).flat_map(|column| self.blocks(column).map(move |block| (column, block)));
        let below = columns.map(|(column, block)| size(column) * size(self.row(block)));
        Mixed {
            diagonal: starts(rows.iter().map(|&rows| u32::from(rows).pow(2))),
            below: starts(below),
            vector: starts(rows.iter().map(|&rows| u32::from(rows))),
            rows: rows.clone(),
        }
    }

    /// The block of a column and a row after it, both by place.
    fn find(&self, column: u32, row: u32) -> u32 {
        let blocks = self.blocks(column as usize);
        let offset = self.rows[blocks.clone()].partition_point(|&other| other < row);
        (blocks.start + offset) as u32
    }

    /// Block rows.
    pub fn count(&self) -> usize {
        self.place.len()
    }

    /// Products of blocks in a factorisation.
    pub fn products(&self) -> usize {
        self.rows.len() + self.targets.len()
    }

    /// Where a node stands in the order.
    pub fn place(&self, node: u32) -> u32 {
        self.place[node as usize]
    }

    /// The block below the diagonal of two neighbours, and whether its row is that of `b`.
    pub fn block(&self, a: u32, b: u32) -> (u32, bool) {
        let (a, b) = (self.place(a), self.place(b));
        (self.find(a.min(b), a.max(b)), a < b)
    }

    /// Blocks below the diagonal.
    pub fn below(&self) -> usize {
        self.rows.len()
    }

    /// Rows of the block row at a place.
    pub(super) fn rows_at(&self, place: usize) -> usize {
        with_layout!(self, layout => layout.rows(place))
    }

    /// Numbers in all blocks on the diagonal, and in those below it.
    pub(super) fn values(&self) -> (usize, usize) {
        with_layout!(self, layout => {
            let diagonal = self.count().checked_sub(1).map_or(0, |last| layout.diagonal(last).end);
            (diagonal, layout.below(self.below()))
        })
    }

    pub(super) fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Indices of a column's blocks.
    #[inline]
    pub(super) fn blocks(&self, column: usize) -> Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// Rows of a column's blocks, by place.
    #[inline]
    pub(super) fn rows(&self, column: usize) -> &[u32] {
        &self.rows[self.blocks(column)]
    }

    /// The row of a block, by place.
    #[inline]
    pub(super) fn row(&self, block: usize) -> usize {
        self.rows[block] as usize
    }

    /// What the products of all columns' blocks are subtracted from, in their order.
    pub(super) fn targets(&self) -> &[Target] {
        &self.targets
    }
}

/// Where each of so many numbers begins, and the end.
fn starts(sizes: impl Iterator<Item = u32>) -> Vec<u32> {
    let sums = sizes.scan(0, |sum, size| {
        *sum += size;
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}
