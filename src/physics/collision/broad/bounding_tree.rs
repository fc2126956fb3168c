//! A dynamic tree of axis-aligned bounding boxes (bounding volume hierarchy).
//!
//! Every node encloses its two children; the leaves hold the bodies' boxes. A query visits a node
//! that it overlaps, and by the surface area heuristic the chance of that grows with the node's
//! area (Goldsmith and Salmon 1987), so a good tree has a small sum of inner areas,
//!
//! C = Σ SA(N) over inner nodes N.
//!
//! - **Insertion**: putting leaf L beside node S makes a parent of area SA(S ∪ L) and enlarges each
//!   ancestor A of S by ΔSA(A) = SA(A ∪ L) − SA(A). One path is followed down. Nothing under a child
//!   K can cost less than SA(L) + Σ ΔSA over K and its ancestors: where that bound exceeds the best
//!   cost yet for both children, the descent ends (the branch and bound of Bittner, Hapala and
//!   Havran 2013, kept to one path).
//! - **Rotation**: on the way back up, a child is swapped with a grandchild on the other side where
//!   that makes the inner node between them smaller (Kopta et al. 2012).
//! - **Update**: a leaf that moved is taken out and put back by a descent that starts at the lowest
//!   of its old ancestors that encloses its new box; for what moves a little that is a few levels.
//!
//! Boxes are closed: touching is overlapping. What the leaves mean is the caller's business.

use nalgebra::Vector3;

/// No node.
pub(super) const NONE: u32 = u32::MAX;

/// An axis-aligned box, world axes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoundingBox {
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

impl BoundingBox {
    /// Overlaps nothing, and is neutral in [`Self::union`].
    pub const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Whether two boxes have a point in common. Without branches: which of the six comparisons
    /// fails cannot be predicted.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        let (a, b) = (self, other);
        let low = (a.low.x <= b.high.x) & (a.low.y <= b.high.y) & (a.low.z <= b.high.z);
        let high = (b.low.x <= a.high.x) & (b.low.y <= a.high.y) & (b.low.z <= a.high.z);
        low & high
    }

    /// Whether the other box lies inside this one; sharing a face counts.
    #[inline]
    pub fn contains(&self, other: &Self) -> bool {
        let (a, b) = (self, other);
        let low = (a.low.x <= b.low.x) & (a.low.y <= b.low.y) & (a.low.z <= b.low.z);
        let high = (b.high.x <= a.high.x) & (b.high.y <= a.high.y) & (b.high.z <= a.high.z);
        low & high
    }

    /// The least box around both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        // Comparisons instead of f64::min, whose care for NaN costs two more instructions each.
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let most = |a: f64, b: f64| if a > b { a } else { b };
        Self { low: self.low.zip_map(&other.low, least), high: self.high.zip_map(&other.high, most) }
    }

    /// Larger by that much on all sides, m.
    pub fn grown(&self, by: f64) -> Self {
        Self { low: self.low.add_scalar(-by), high: self.high.add_scalar(by) }
    }

    /// How far a point is outside, m; 0 inside.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        let beyond = |low: f64, high: f64| if low > high { low } else { high };
        let outside = (self.low - point).zip_map(&(point - self.high), beyond);
        outside.map(|by| if by > 0.0 { by } else { 0.0 }).norm()
    }

    /// Half the surface area, m².
    #[inline]
    pub(super) fn half_area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// Names a leaf for as long as it is in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf(u32);

/// One cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    pub bounds: BoundingBox,
    /// In a free node: the next free one.
    pub parent: u32,
    /// `[NONE, item]` in a leaf.
    pub children: [u32; 2],
}

impl Node {
    pub fn is_leaf(&self) -> bool {
        self.children[0] == NONE
    }
}

/// The tree: a pool of nodes, the free ones in a list.
#[derive(Clone, Debug)]
pub(crate) struct BoundingTree {
    pub(super) nodes: Vec<Node>,
    pub(super) root: u32,
    pub(super) free: u32,
}

impl Default for BoundingTree {
    fn default() -> Self {
        Self { nodes: Vec::new(), root: NONE, free: NONE }
    }
}

impl BoundingTree {
    /// Adds a box; `item` is what queries will report.
    pub fn insert(&mut self, bounds: BoundingBox, item: u32) -> Leaf {
        let leaf = self.allocate(Node { bounds, parent: NONE, children: [NONE, item] });
        if self.root == NONE {
            self.root = leaf;
        } else {
            self.attach(leaf, self.root);
        }
        Leaf(leaf)
    }

    /// Takes a leaf out.
    pub fn remove(&mut self, leaf: Leaf) {
        let above = self.detach(leaf.0);
        self.refit(above);
        self.release(leaf.0);
    }

    /// Gives a leaf a new box.
    pub fn update(&mut self, leaf: Leaf, bounds: BoundingBox) {
        let parent = self.nodes[leaf.0 as usize].parent;
        self.nodes[leaf.0 as usize].bounds = bounds;
        if parent == NONE {
            return;
        }
        let above = self.detach(leaf.0);
        self.refit(above);
        let mut start = if above == NONE { self.root } else { above };
        while !self.nodes[start as usize].bounds.contains(&bounds) && self.nodes[start as usize].parent != NONE {
            start = self.nodes[start as usize].parent;
        }
        self.attach(leaf.0, start);
    }

    /// Gives a leaf another item.
    pub fn set_item(&mut self, leaf: Leaf, item: u32) {
        self.nodes[leaf.0 as usize].children[1] = item;
    }

    /// Calls `found` with the item of each leaf that overlaps the box, in an order that depends on
    /// the tree's past. The stack is scratch; its content on entry does not matter.
    #[inline]
    pub fn query(&self, bounds: &BoundingBox, stack: &mut Vec<u32>, mut found: impl FnMut(u32)) {
        stack.clear();
        if self.root == NONE || !self.nodes[self.root as usize].bounds.overlaps(bounds) {
            return;
        }
        let mut node = &self.nodes[self.root as usize];
        loop {
            let [left, right] = node.children;
            if left == NONE {
                found(right);
            } else {
                let (left_node, right_node) = (&self.nodes[left as usize], &self.nodes[right as usize]);
                let hits = (left_node.bounds.overlaps(bounds), right_node.bounds.overlaps(bounds));
                if hits.0 {
                    if hits.1 {
                        stack.push(right);
                    }
                    node = left_node;
                    continue;
                }
                if hits.1 {
                    node = right_node;
                    continue;
                }
            }
            match stack.pop() {
                Some(next) => node = &self.nodes[next as usize],
                None => return,
            }
        }
    }

    fn allocate(&mut self, node: Node) -> u32 {
        if self.free == NONE {
            self.nodes.push(node);
            return self.nodes.len() as u32 - 1;
        }
        let index = self.free;
        self.free = self.nodes[index as usize].parent;
        self.nodes[index as usize] = node;
        index
    }

    fn release(&mut self, index: u32) {
        self.nodes[index as usize].parent = self.free;
        self.free = index;
    }

    /// Where under `start` the box is to be put: the sibling it gets.
    fn best_sibling(&self, bounds: &BoundingBox, start: u32, mut tie: u32) -> u32 {
        let area = bounds.half_area();
        let mut node = &self.nodes[start as usize];
        let direct = node.bounds.union(bounds).half_area();
        let mut best = (start, direct);
        // Σ ΔSA over the node and its ancestors from `start`.
        let mut enlarged = direct - node.bounds.half_area();
        while !node.is_leaf() {
            let [left, right] = node.children.map(|child| {
                let bounds_of_child = &self.nodes[child as usize].bounds;
                let direct = bounds_of_child.union(bounds).half_area();
                let bound = enlarged + direct - bounds_of_child.half_area();
                (child, enlarged + direct, bound)
            });
            // Boxes that all coincide cost the same everywhere: the bits of `tie` spread them.
            let take_left = if left.2 == right.2 { tie & 1 == 0 } else { left.2 < right.2 };
            tie = tie.rotate_right(1);
            let (child, cost, bound) = if take_left { left } else { right };
            if cost <= best.1 {
                best = (child, cost);
            }
            if bound + area > best.1 {
                break;
            }
            enlarged = bound;
            node = &self.nodes[child as usize];
        }
        best.0
    }

    /// Puts a detached leaf in, looking for its place under `start`.
    fn attach(&mut self, leaf: u32, start: u32) {
        let bounds = self.nodes[leaf as usize].bounds;
        // An odd constant (2³² over the golden ratio) mixes the low bits of the index upwards;
        // the upper ones then differ between neighbours.
        let sibling = self.best_sibling(&bounds, start, leaf.wrapping_mul(0x9e37_79b9).swap_bytes());
        let above = self.nodes[sibling as usize].parent;
        let parent = self.allocate(Node { bounds, parent: above, children: [sibling, leaf] });
        self.replace_child(above, sibling, parent);
        self.nodes[sibling as usize].parent = parent;
        self.nodes[leaf as usize].parent = parent;
        self.nodes[parent as usize].bounds = bounds.union(&self.nodes[sibling as usize].bounds);
        self.refit(above);
    }

    /// Cuts a leaf out with its parent, and tells what is above; boxes there are left too large.
    fn detach(&mut self, leaf: u32) -> u32 {
        let parent = self.nodes[leaf as usize].parent;
        if parent == NONE {
            self.root = NONE;
            return NONE;
        }
        let Node { parent: above, children, .. } = self.nodes[parent as usize];
        let sibling = if children[0] == leaf { children[1] } else { children[0] };
        self.nodes[sibling as usize].parent = above;
        self.replace_child(above, parent, sibling);
        self.release(parent);
        above
    }

    fn replace_child(&mut self, parent: u32, old: u32, new: u32) {
        if parent == NONE {
            self.root = new;
        } else {
            let children = &mut self.nodes[parent as usize].children;
            children[usize::from(children[0] != old)] = new;
        }
    }

    /// Brings the boxes from a node upwards up to date, and rotates on the way.
    fn refit(&mut self, mut index: u32) {
        while index != NONE {
            self.rotate(index);
            let Node { bounds: old, parent, children: [left, right] } = self.nodes[index as usize];
            let bounds = self.nodes[left as usize].bounds.union(&self.nodes[right as usize].bounds);
            if bounds == old {
                return;
            }
            self.nodes[index as usize].bounds = bounds;
            index = parent;
        }
    }

    /// Of the four swaps of a child with a grandchild on the other side, does the one that makes
    /// the inner child smallest, if any does. What hangs under the node stays the same.
    fn rotate(&mut self, index: u32) {
        let children = self.nodes[index as usize].children;
        let mut best = (0.0, [NONE; 3]);
        for side in 0..2 {
            let (child, inner) = (children[side], children[1 - side]);
            let Node { bounds, children: grandchildren, .. } = self.nodes[inner as usize];
            if grandchildren[0] == NONE {
                continue;
            }
            let area = bounds.half_area();
            for place in 0..2 {
                let (goes_up, stays) = (grandchildren[place], grandchildren[1 - place]);
                let joined = self.nodes[child as usize].bounds.union(&self.nodes[stays as usize].bounds);
                let gain = area - joined.half_area();
                if gain > best.0 {
                    best = (gain, [child, inner, goes_up]);
                }
            }
        }
        let (gain, [child, inner, goes_up]) = best;
        // Rounding must not make two trees of one cost change places for ever.
        if gain > 1e-9 * self.nodes[index as usize].bounds.half_area() {
            self.replace_child(index, child, goes_up);
            self.replace_child(inner, goes_up, child);
            self.nodes[goes_up as usize].parent = index;
            self.nodes[child as usize].parent = inner;
            let [left, right] = self.nodes[inner as usize].children;
            self.nodes[inner as usize].bounds =
                self.nodes[left as usize].bounds.union(&self.nodes[right as usize].bounds);
        }
    }
}
