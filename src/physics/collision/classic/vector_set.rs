//! The *vector set* of the 2009 engine: a set of vectors that differ from each other.
//!
//! A vector within L1 distance |Δx| + |Δy| + |Δz| ≤ ε of a kept one is dropped; the L1 norm
//! bounds the Euclidean one and needs no square root. It thins the candidate axes of the
//! separating axis test, where vectors near zero (cross products of parallel edges) are dropped
//! too and the others normalised, and the vertices of a shape when it is made.
//!
//! The first few are compared in one sweep of wide instructions; those after them are listed in
//! the cells of x and y that are within ε of them, so that the thousand axes of two fine hulls cost no million
//! comparisons: a search looks into one cell. Cells are at least ε wide, and nothing is listed in more than nine.

use std::ops::Range;

use nalgebra::Vector3;

use crate::physics::collision::constants::LEAST_AXIS;

/// Vectors that are compared in one sweep: two boxes give 21.
const SWEPT: usize = 24;

/// Vectors in one run of the sweep, which ends after a run that has one near.
const RUN: usize = 8;

/// Most cells along x, and along y.
const MOST_CELLS: usize = 32;

/// End of a list.
const END: u32 = u32::MAX;

/// A set of vectors in which no two are within ε of each other.
#[derive(Clone, Debug)]
pub(crate) struct VectorSet {
    epsilon: f64,
    merge_opposites: bool,
    /// Cells along x, and along y.
    cells: usize,
    /// Cells in a unit of x.
    scale: f64,
    vectors: Vec<Vector3<f64>>,
    /// The first of them by components, the rest of the row beyond reach of any.
    swept: [[f64; SWEPT]; 3],
    /// The others, once for each cell in reach of them: which it is, and the next entry of the cell.
    entries: Vec<[u32; 2]>,
    /// First entry of each cell; made when first needed.
    first: Vec<u32>,
}

impl Default for VectorSet {
    /// Empty, of directions, ε = 0.
    fn default() -> Self {
        Self {
            epsilon: 0.0,
            merge_opposites: false,
            cells: MOST_CELLS,
            scale: MOST_CELLS as f64 / 2.0,
            vectors: Vec::new(),
            swept: [[f64::INFINITY; SWEPT]; 3],
            entries: Vec::new(),
            first: Vec::new(),
        }
    }
}

impl VectorSet {
    /// Empties it, keeping its memory. With `merge_opposites` v and −v count as one; `reach` is
    /// about the length of the longest vector to come (a longer one is only slower to find).
    pub fn reset(&mut self, epsilon: f64, merge_opposites: bool, reach: f64) {
        self.epsilon = epsilon;
        self.merge_opposites = merge_opposites;
        self.cells = ((2.0 * reach / epsilon) as usize).clamp(1, MOST_CELLS);
        self.scale = self.cells as f64 / (2.0 * reach);
        self.vectors.clear();
        self.swept = [[f64::INFINITY; SWEPT]; 3];
        if !self.entries.is_empty() {
            self.entries.clear();
            self.first.clear();
        }
    }

    /// What was kept, in the order of insertion.
    pub fn vectors(&self) -> &[Vector3<f64>] {
        &self.vectors
    }

    /// Keeps a vector unless one within ε is there; whether it was kept.
    #[inline]
    pub fn insert(&mut self, vector: Vector3<f64>) -> bool {
        if self.has_near(&vector) {
            return false;
        }
        let index = self.vectors.len();
        if index < SWEPT {
            for axis in 0..3 {
                self.swept[axis][index] = vector[axis];
            }
        } else {
            self.first.resize(self.cells * self.cells, END);
            let [columns, rows] = self.cells_near(&vector);
            for column in columns {
                for row in rows.clone() {
                    let first = &mut self.first[column * self.cells + row];
                    self.entries.push([index as u32, *first]);
                    *first = self.entries.len() as u32 - 1;
                }
            }
        }
        self.vectors.push(vector);
        true
    }

    /// Normalises a vector and keeps it, unless it is near zero or one within ε is there. The
    /// direction if it was kept.
    #[inline]
    pub fn insert_direction(&mut self, vector: Vector3<f64>) -> Option<Vector3<f64>> {
        let length = vector.norm();
        if length < LEAST_AXIS {
            return None;
        }
        let direction = vector / length;
        self.insert(direction).then_some(direction)
    }

    /// Whether a vector within ε is there.
    #[inline]
    pub fn has_near(&self, vector: &Vector3<f64>) -> bool {
        self.is_near_swept(vector)
            || (!self.entries.is_empty()
                && (self.is_near_chained(vector) || (self.merge_opposites && self.is_near_chained(&-vector))))
    }

    #[inline]
    fn is_near_swept(&self, vector: &Vector3<f64>) -> bool {
        let [x, y, z] = &self.swept;
        let runs = self.vectors.len().min(SWEPT).div_ceil(RUN);
        (0..runs).any(|run| {
            let mut near = false;
            for index in run * RUN..(run + 1) * RUN {
                let apart = (x[index] - vector.x).abs() + (y[index] - vector.y).abs() + (z[index] - vector.z).abs();
                near |= apart <= self.epsilon;
            }
            if self.merge_opposites {
                for index in run * RUN..(run + 1) * RUN {
                    let apart = (x[index] + vector.x).abs() + (y[index] + vector.y).abs() + (z[index] + vector.z).abs();
                    near |= apart <= self.epsilon;
                }
            }
            near
        })
    }

    fn is_near_chained(&self, vector: &Vector3<f64>) -> bool {
        let mut entry = self.first[self.column(vector.x) * self.cells + self.column(vector.y)];
        while entry != END {
            let [index, next] = self.entries[entry as usize];
            let apart = self.vectors[index as usize] - vector;
            if apart.x.abs() + apart.y.abs() + apart.z.abs() <= self.epsilon {
                return true;
            }
            entry = next;
        }
        false
    }

    /// The columns and rows of the cells that vectors within ε may be in.
    #[inline]
    pub fn cells_near(&self, vector: &Vector3<f64>) -> [Range<usize>; 2] {
        [vector.x, vector.y].map(|at| self.column(at - self.epsilon)..self.column(at + self.epsilon) + 1)
    }

    /// The column of cells of an x, or the row of a y; those beyond the reach fall in the outermost.
    #[inline]
    fn column(&self, at: f64) -> usize {
        let column = at * self.scale + 0.5 * self.cells as f64;
        (column.max(0.0) as usize).min(self.cells - 1)
    }
}
