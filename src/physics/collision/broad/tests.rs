//! What tests look at inside the broad phase.

use super::bounding_tree::{BoundingBox, BoundingTree, NONE};
use super::pair_slots::{PairSlot, PairSlots};
use super::persistent_pairs::PersistentPairs;
use crate::physics::collision::manifold::Pair;

impl BoundingTree {
    /// Checks every link and box; gives the number of leaves and the depth.
    pub fn check(&self) -> (usize, usize) {
        let (mut leaves, mut depth, mut stack) = (0, 0, vec![(self.root, NONE, 1)]);
        if self.root == NONE {
            return (0, 0);
        }
        let mut seen = 0;
        while let Some((index, parent, level)) = stack.pop() {
            let node = &self.nodes[index as usize];
            seen += 1;
            depth = depth.max(level);
            assert_eq!(node.parent, parent, "parent of node {index}");
            if node.is_leaf() {
                leaves += 1;
            } else {
                let [left, right] = node.children.map(|child| self.nodes[child as usize].bounds);
                assert_eq!(node.bounds, left.union(&right), "box of node {index}");
                stack.extend(node.children.map(|child| (child, index, level + 1)));
            }
        }
        let mut free = self.free;
        while free != NONE {
            seen += 1;
            free = self.nodes[free as usize].parent;
        }
        assert_eq!(seen, self.nodes.len(), "nodes lost");
        (leaves, depth)
    }

    /// The cost C over the root's area.
    pub fn cost(&self) -> f64 {
        let (mut sum, mut stack) = (0.0, vec![self.root]);
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !node.is_leaf() {
                sum += node.bounds.half_area();
                stack.extend(node.children);
            }
        }
        sum / self.nodes[self.root as usize].bounds.half_area()
    }
}

impl PersistentPairs {
    /// Checks the tree against the bodies.
    pub fn check(&self) {
        let (leaves, _) = self.tree.check();
        assert_eq!(leaves, self.leaves.iter().flatten().count());
        assert_eq!(self.fat, self.previous);
        assert!(!self.has_moved.contains(&true) && !self.is_paired.contains(&true));
    }

    pub fn fat_box(&self, body: u32) -> BoundingBox {
        self.fat[body as usize]
    }
    /// How many bodies got a new fat box in the last update.
    pub fn moved_count(&self) -> usize {
        self.moved.len()
    }
}

impl PairSlots {
    /// All pairs in the order of their slots.
    pub fn iter(&self) -> impl Iterator<Item = (PairSlot, Pair)> {
        let slots = (0..self.slot_count() as u32).map(PairSlot);
        slots.filter_map(|slot| self.get(slot).map(|pair| (slot, pair)))
    }

    /// The number of pairs.
    pub fn len(&self) -> usize {
        self.iter().count()
    }
}
