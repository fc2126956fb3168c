//! A tree of bounding boxes that is made at once and does not change: of all bodies, for questions between two steps, and of
//! the parts of a shape.
//!
//! Items are halved by the median of their boxes' centres along the axis on which these spread most. A node's first child
//! follows it in the list, so that a look goes through memory in order. Boxes are closed.

use nalgebra::Vector3;

use crate::physics::BoundingBox;

/// Items of a leaf at most: to look at as many boxes costs about as much as a node.
const LEAF_ITEMS: usize = 4;

/// A node, before its first child.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: BoundingBox,
    /// Of a leaf the place of its first item, else the node of its second child.
    next: u32,
    /// Of a leaf how many items it has, else 0.
    count: u32,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxTree {
    nodes: Vec<Node>,
    /// Items by leaf, with their boxes.
    items: Vec<(u32, BoundingBox)>,
}

impl BoxTree {
    /// Of items with finite boxes.
    pub fn new(items: Vec<(u32, BoundingBox)>) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(items.len()), items };
        if !tree.items.is_empty() {
            tree.split(0, tree.items.len());
        }
        tree
    }

    fn split(&mut self, first: usize, end: usize) {
        let items = &mut self.items[first..end];
        let bounds = items.iter().fold(BoundingBox::EMPTY, |all, (_, bounds)| all.union(bounds));
        let place = self.nodes.len();
        self.nodes.push(Node { bounds, next: first as u32, count: items.len() as u32 });
        if items.len() <= LEAF_ITEMS {
            return;
        }
        let center = |bounds: &BoundingBox| bounds.low + bounds.high;
        let spread = items.iter().fold(BoundingBox::EMPTY, |all, (_, bounds)| {
            all.union(&BoundingBox { low: center(bounds), high: center(bounds) })
        });
        let axis = (spread.high - spread.low).imax();
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |(one, a), (other, b)| {
            center(a)[axis].total_cmp(&center(b)[axis]).then(one.cmp(other))
        });
        self.split(first, first + half);
        self.nodes[place].next = self.nodes.len() as u32;
        self.nodes[place].count = 0;
        self.split(first + half, end);
    }

    /// Looks at items, the nearer boxes first, for as long as they are not beyond the most there may be. `distance` tells
    /// how far a box is, infinite where it does not matter; `look`, what the most is after a look at an item.
    pub fn search(&self, mut most: f64, distance: impl Fn(&BoundingBox) -> f64, mut look: impl FnMut(u32, f64) -> f64) {
        let Some(root) = self.nodes.first() else { return };
        let is_within = |distance: f64, most: f64| distance <= most && distance < f64::INFINITY;
        // A level leaves one node behind, and halves are equal.
        let mut stack = [(0.0, 0_u32); 40];
        stack[0] = (distance(&root.bounds), 0);
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (from, index) = stack[depth];
            if !is_within(from, most) {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for (item, bounds) in &self.items[node.next as usize..][..node.count as usize] {
                    if is_within(distance(bounds), most) {
                        most = look(*item, most);
                    }
                }
                continue;
            }
            let children = [index + 1, node.next];
            let [one, other] = children.map(|child| (distance(&self.nodes[child as usize].bounds), child));
            let (near, far) = if other.0 < one.0 { (other, one) } else { (one, other) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
    }

    /// Hands on the items whose boxes overlap one.
    pub fn overlapping(&self, bounds: &BoundingBox, mut take: impl FnMut(u32)) {
        let distance = |other: &BoundingBox| if bounds.overlaps(other) { 0.0 } else { f64::INFINITY };
        self.search(0.0, distance, |item, most| {
            take(item);
            most
        });
    }
}

/// A ray as boxes are tested against it.
pub(crate) struct Way {
    origin: Vector3<f64>,
    /// One over each part of the direction.
    inverse: Vector3<f64>,
}

impl Way {
    /// Of a ray from a point along a direction.
    pub fn new(origin: &Vector3<f64>, direction: &Vector3<f64>) -> Self {
        // Finite, so that nothing times it is a number.
        let inverse = direction.map(|part| if part.abs() < 1e-300 { 1e300_f64.copysign(part) } else { part.recip() });
        Self { origin: *origin, inverse }
    }

    /// How far along the ray a box begins, 0 inside, infinite where it is missed (Kay and Kajiya 1986).
    pub fn enters(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> f64 {
        let one = (low - self.origin).component_mul(&self.inverse);
        let other = (high - self.origin).component_mul(&self.inverse);
        // Comparisons, one instruction each, as nothing is NaN.
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let most = |a: f64, b: f64| if a > b { a } else { b };
        let (enters, leaves) = (one.zip_map(&other, least), one.zip_map(&other, most));
        let first = most(most(enters.x, enters.y), most(enters.z, 0.0));
        let last = least(least(leaves.x, leaves.y), leaves.z);
        if first <= last { first } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing::Random;

    fn boxes(random: &mut Random, count: u32) -> Vec<(u32, BoundingBox)> {
        let bounds = |_| {
            let (at, half) = (random.vector() * 10.0, random.vector().abs());
            BoundingBox { low: at - half, high: at + half }
        };
        (0..count).zip((0..count).map(bounds)).collect()
    }

    #[test]
    fn the_nearest_box_is_what_looking_at_all_finds() {
        let mut random = Random::new(71);
        for count in [0, 1, 4, 5, 9, 100, 3000] {
            let items = boxes(&mut random, count);
            let tree = BoxTree::new(items.clone());
            for _ in 0..100 {
                let point: Vector3<f64> = random.vector() * 15.0;
                let distance = |bounds: &BoundingBox| (point - point.sup(&bounds.low).inf(&bounds.high)).norm();
                let nearest = items.iter().map(|(_, bounds)| distance(bounds)).fold(f64::INFINITY, f64::min);
                let (mut found, mut looks) = (f64::INFINITY, 0);
                tree.search(f64::INFINITY, distance, |item, most| {
                    found = found.min(distance(&items[item as usize].1));
                    looks += 1;
                    found.min(most)
                });
                assert_eq!(found, nearest);
                assert!(count < 3000 || looks < 200, "{looks} boxes of {count} looked at");
                let mut all = Vec::new();
                tree.search(3.0, distance, |item, most| {
                    all.push(item);
                    most
                });
                all.sort_unstable();
                let expected: Vec<u32> =
                    items.iter().filter(|item| distance(&item.1) <= 3.0).map(|item| item.0).collect();
                assert_eq!(all, expected);
            }
        }
    }

    #[test]
    fn boxes_in_one_place_are_all_found() {
        let bounds = BoundingBox { low: Vector3::zeros(), high: Vector3::repeat(1.0) };
        let tree = BoxTree::new((0..1000).map(|item| (item, bounds)).collect());
        let mut count = 0;
        tree.search(
            0.0,
            |_| 0.0,
            |_, most| {
                count += 1;
                most
            },
        );
        assert_eq!(count, 1000);
    }
}
