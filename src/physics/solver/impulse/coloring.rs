//! Graph colouring: constraints of a colour share no body that moves, so that they can be solved
//! side by side, in lanes and on threads, in any order with the same result.
//!
//! Greedy, in the order given: each constraint takes the first colour that neither of its bodies
//! has yet. Bodies of high degree run out of colours; what is left over goes into blocks of one.

use crate::physics::grouped::Grouped;
use crate::physics::lanes::{READ_ONLY, WIDTH};

/// Colours told apart: the bits of a mask.
const COLORS: usize = 64;

/// A colour of joints or contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Color {
    Joints(u32),
    Contacts(u32),
}

/// Constraints in the order in which blocks take them.
#[derive(Clone, Default)]
pub(crate) struct Coloring {
    used: Vec<u64>,
    colors: Vec<u8>,
    sorted: Grouped,
    /// Constraints, colour after colour.
    pub order: Vec<u32>,
    /// Runs of `order` that make up a block, as (start, end).
    pub blocks: Vec<(u32, u32)>,
    /// Runs of `blocks` that may be solved in any order, as (start, end).
    pub stages: Vec<(u32, u32)>,
}

impl Coloring {
    /// Takes in a group of so many bodies: stages for constraints between these, told by index, in runs of those lengths,
    /// of which each shares no block with those before and comes after them; blocks hold at most `lanes`.
    pub fn set(&mut self, bodies: usize, pairs: &[(u32, u32)], runs: impl IntoIterator<Item = usize>, lanes: usize) {
        self.order.clear();
        self.blocks.clear();
        self.stages.clear();
        let mut first = 0;
        for run in runs {
            self.add(bodies, first as u32, &pairs[first..first + run], lanes);
            first += run;
        }
    }

    /// Puts the constraints of each colour in the order of a key below `keys`, those of one key in the order that they
    /// have: blocks are alike, and the outcome is the same.
    pub fn sort_colors(&mut self, keys: u32, key: impl Fn(u32) -> u32) {
        let Self { order, blocks, stages, sorted, .. } = self;
        for &(first, last) in &*stages {
            let (start, end) = (blocks[first as usize].0, blocks[last as usize - 1].1);
            let run = &mut order[start as usize..end as usize];
            sorted.rebuild(keys, run.iter().map(|&constraint| (constraint, key(constraint))));
            run.copy_from_slice(sorted.all());
        }
    }

    /// The constraints of a block.
    pub fn lanes(&self, block: usize) -> &[u32] {
        let (start, end) = self.blocks[block];
        &self.order[start as usize..end as usize]
    }

    /// Adds stages for constraints numbered from `first`.
    fn add(&mut self, bodies: usize, first: u32, pairs: &[(u32, u32)], lanes: usize) {
        debug_assert!(lanes <= WIDTH);
        self.used.clear();
        self.used.resize(bodies, 0);
        self.colors.clear();
        let mut counts = [0_u32; COLORS + 1];
        for &(a, b) in pairs {
            let mask = |body: u32| if body & READ_ONLY == 0 { self.used[body as usize] } else { 0 };
            let color = (mask(a) | mask(b)).trailing_ones() as usize;
            for body in [a, b] {
                if color < COLORS && body & READ_ONLY == 0 {
                    self.used[body as usize] |= 1 << color;
                }
            }
            counts[color] += 1;
            self.colors.push(color as u8);
        }
        let mut starts = [0_u32; COLORS + 1];
        let mut next = self.order.len() as u32;
        for (start, count) in starts.iter_mut().zip(counts) {
            *start = next;
            next += count;
        }
        self.order.resize(next as usize, 0);
        let mut fill = starts;
        for (index, &color) in self.colors.iter().enumerate() {
            let place = &mut fill[color as usize];
            self.order[*place as usize] = first + index as u32;
            *place += 1;
        }
        for (color, (&start, &count)) in starts.iter().zip(&counts).enumerate() {
            self.add_stages(start, count, if color < COLORS { lanes } else { 1 }, color == COLORS);
        }
    }

    fn add_stages(&mut self, start: u32, count: u32, lanes: usize, apart: bool) {
        let first = self.blocks.len() as u32;
        let end = start + count;
        self.blocks.extend((start..end).step_by(lanes).map(|from| (from, (from + lanes as u32).min(end))));
        let last = self.blocks.len() as u32;
        if apart {
            self.stages.extend((first..last).map(|block| (block, block + 1)));
        } else if last > first {
            self.stages.push((first, last));
        }
    }
}
