//! A tree of bounding boxes that is made at once and does not change: of all bodies, for questions between two steps, and of
//! the parts of a shape.
//!
//! A node has four children, each an item or a node, and holds their boxes side by side in `f32`, rounded outwards: the tree
//! hands on what may matter, and now and then an item whose own box is beyond by that rounding. Items are halved along the
//! axis on which their boxes' centres spread most, so that all nodes but one of each level are full. Boxes are closed.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use wide::f32x8;

use crate::physics::BoundingBox;

/// Children of a node at most.
const CHILDREN: usize = 4;

/// Flags a child that is an item.
const ITEM: u32 = 1 << 31;

/// Nodes and items that a search has yet to look at, at most: of each level three are left behind, and there are no more than
/// 2³¹ items.
const YET_TO_LOOK_AT: usize = 52;

/// A node.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Node {
    /// By axis: the low ends of the children's boxes, and the negative high ends, so that one comparison does both.
    ends: [[f32; 2 * CHILDREN]; 3],
    /// Each an item with [`ITEM`], or a node.
    children: [u32; CHILDREN],
    /// How many children it has.
    count: u32,
}

impl Node {
    /// Without children: nothing overlaps what is NaN.
    const EMPTY: Self = Self { ends: [[f32::NAN; 2 * CHILDREN]; 3], children: [0; CHILDREN], count: 0 };

    fn push(&mut self, child: u32, bounds: &BoundingBox) {
        let slot = self.count as usize;
        for (ends, (&low, &high)) in self.ends.iter_mut().zip(bounds.low.iter().zip(&bounds.high)) {
            (ends[slot], ends[CHILDREN + slot]) = (round_down(low), round_down(-high));
        }
        self.children[slot] = child;
        self.count += 1;
    }

    /// The box of a child.
    #[inline]
    fn bounds(&self, slot: usize) -> BoundingBox {
        let end = |axis: usize| f64::from(self.ends[axis][slot]);
        let other_end = |axis: usize| -f64::from(self.ends[axis][CHILDREN + slot]);
        BoundingBox {
            low: Vector3::new(end(0), end(1), end(2)),
            high: Vector3::new(other_end(0), other_end(1), other_end(2)),
        }
    }

    /// The children whose boxes overlap one, a bit each.
    #[inline]
    fn overlapping(&self, with: &Overlap) -> u32 {
        let [x, y, z] = self.ends.map(f32x8::from);
        let both = (x.simd_le(with.0[0]) & y.simd_le(with.0[1]) & z.simd_le(with.0[2])).to_bitmask();
        both & both >> CHILDREN & ((1 << CHILDREN) - 1)
    }
}

/// A box as those of nodes are tested against it: by axis, what their low ends and negative high ends may be at most.
struct Overlap([f32x8; 3]);

impl Overlap {
    #[inline]
    fn new(bounds: &BoundingBox) -> Self {
        let most = |axis: usize| {
            let (low, high) = (-round_down(-bounds.high[axis]), -round_down(bounds.low[axis]));
            f32x8::from([low, low, low, low, high, high, high, high])
        };
        Self([most(0), most(1), most(2)])
    }
}

/// A number of `f32` that is no larger, and smaller by no more than rounding may make it, twice.
#[inline]
fn round_down(number: f64) -> f32 {
    const ROUNDING: f64 = f32::EPSILON as f64;
    const LEAST: f64 = f32::from_bits(1) as f64;
    (number - number.abs() * ROUNDING - LEAST) as f32
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxTree {
    nodes: Vec<Node>,
}

impl BoxTree {
    /// Of items with finite boxes, by numbers below 2³¹.
    pub fn new(mut items: Vec<(u32, BoundingBox)>) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(items.len().div_ceil(CHILDREN - 1)) };
        if !items.is_empty() {
            tree.add(&mut items);
        }
        tree
    }

    /// Adds a node with those items below it; its index, and their box.
    fn add(&mut self, items: &mut [(u32, BoundingBox)]) -> (u32, BoundingBox) {
        let place = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        // Of full nodes.
        let mut of_a_child = 1;
        while CHILDREN * of_a_child < items.len() {
            of_a_child *= CHILDREN;
        }
        let mut node = Node::EMPTY;
        self.split(items, of_a_child, &mut node);
        self.nodes[place] = node;
        let all = (0..node.count as usize).fold(BoundingBox::EMPTY, |all, slot| all.union(&node.bounds(slot)));
        (place as u32, all)
    }

    /// Halves items, of which there are some, until there are no more than `of_a_child`, each lot a child of the node.
    fn split(&mut self, items: &mut [(u32, BoundingBox)], of_a_child: usize, node: &mut Node) {
        match items {
            [(item, bounds)] => node.push(*item | ITEM, bounds),
            _ if items.len() <= of_a_child => {
                let (child, bounds) = self.add(items);
                node.push(child, &bounds);
            }
            _ => {
                let half = items.len().div_ceil(of_a_child).div_ceil(2) * of_a_child;
                let center = |bounds: &BoundingBox| bounds.low + bounds.high;
                let spread = items.iter().fold(BoundingBox::EMPTY, |all, (_, bounds)| {
                    all.union(&BoundingBox { low: center(bounds), high: center(bounds) })
                });
                let axis = (spread.high - spread.low).imax();
                items.select_nth_unstable_by(half, |(one, a), (other, b)| {
                    center(a)[axis].total_cmp(&center(b)[axis]).then(one.cmp(other))
                });
                let (one, other) = items.split_at_mut(half);
                self.split(one, of_a_child, node);
                self.split(other, of_a_child, node);
            }
        }
    }

    /// Looks at items, the nearer boxes first, for as long as they are not beyond the most there may be. `distance` tells
    /// how far a box is, infinite where it does not matter; `look`, what the most is after a look at an item.
    pub fn search(&self, mut most: f64, distance: impl Fn(&BoundingBox) -> f64, mut look: impl FnMut(u32, f64) -> f64) {
        let mut stack = [(0.0, 0_u32); YET_TO_LOOK_AT];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let (from, child) = stack[depth];
            if from > most {
                continue;
            }
            if child & ITEM != 0 {
                most = look(child & !ITEM, most);
                continue;
            }
            let node = &self.nodes[child as usize];
            let first = depth;
            let distances: [f64; CHILDREN] = std::array::from_fn(|slot| distance(&node.bounds(slot)));
            for (&child, away) in node.children[..node.count as usize].iter().zip(distances) {
                if away <= most && away < f64::INFINITY {
                    let mut place = depth;
                    while place > first && stack[place - 1].0 < away {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = (away, child);
                    depth += 1;
                }
            }
        }
    }

    /// All items.
    pub fn items(&self) -> impl Iterator<Item = u32> {
        let children = self.nodes.iter().flat_map(|node| &node.children[..node.count as usize]);
        children.filter(|child| *child & ITEM != 0).map(|child| child & !ITEM)
    }

    /// Hands on the items whose boxes overlap one, until `take` breaks off.
    #[inline]
    pub fn overlapping(&self, bounds: &BoundingBox, take: impl FnMut(u32) -> ControlFlow<()>) {
        self.overlapping_where(bounds, |_| true, take);
    }

    /// The same of those whose boxes, and the boxes around them, are `admitted`.
    pub fn overlapping_where(
        &self,
        bounds: &BoundingBox,
        mut admitted: impl FnMut(&BoundingBox) -> bool,
        mut take: impl FnMut(u32) -> ControlFlow<()>,
    ) {
        let with = Overlap::new(bounds);
        let mut stack = [0_u32; YET_TO_LOOK_AT];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            // With a branch for each box that overlaps: it cannot be told beforehand, but without it each node waits for the
            // last, which took half as long again.
            let mut left = node.overlapping(&with);
            while left != 0 {
                let slot = left.trailing_zeros() as usize;
                left &= left - 1;
                if !admitted(&node.bounds(slot)) {
                    continue;
                }
                let child = node.children[slot];
                if child & ITEM == 0 {
                    stack[depth] = child;
                    depth += 1;
                } else if take(child & !ITEM).is_break() {
                    return;
                }
            }
        }
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
                let within = |most: f64| items.iter().filter(move |item| distance(&item.1) <= most);
                assert_between(&mut all, within(3.0), within(3.0 + ROUNDING));
            }
        }
    }

    /// More than `f32` loses of these boxes.
    const ROUNDING: f64 = 1e-5;

    /// Whether the items found are all those that must be among them, each once, and none that may not be.
    fn assert_between<'a>(
        found: &mut [u32],
        must: impl Iterator<Item = &'a (u32, BoundingBox)>,
        may: impl Iterator<Item = &'a (u32, BoundingBox)>,
    ) {
        found.sort_unstable();
        assert!(found.is_sorted_by(|one, other| one < other), "twice");
        let may: Vec<u32> = may.map(|item| item.0).collect();
        assert!(found.iter().all(|item| may.binary_search(item).is_ok()), "{found:?} beyond {may:?}");
        for (must, _) in must {
            assert!(found.binary_search(must).is_ok(), "{must} is missing");
        }
    }

    #[test]
    fn what_overlaps_is_found() {
        let mut random = Random::new(72);
        for count in [0, 1, 2, 4, 5, 8, 9, 16, 17, 100, 3000] {
            let items = boxes(&mut random, count);
            let tree = BoxTree::new(items.clone());
            let mut all: Vec<u32> = tree.items().collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
            for (_, bounds) in boxes(&mut random, 100) {
                let overlaps = |by: f64| items.iter().filter(move |item| bounds.grown(by).overlaps(&item.1));
                let (mut found, mut first) = (Vec::new(), Vec::new());
                tree.overlapping(&bounds, |item| {
                    found.push(item);
                    ControlFlow::Continue(())
                });
                tree.overlapping(&bounds, |item| {
                    first.push(item);
                    ControlFlow::Break(())
                });
                assert_eq!(first.first(), found.first());
                assert!(first.len() <= 1);
                assert_between(&mut found, overlaps(0.0), overlaps(ROUNDING));
                let (mut looks, mut above) = (0, Vec::new());
                let is_above = |other: &BoundingBox| {
                    looks += 1;
                    other.high.y >= bounds.high.y
                };
                tree.overlapping_where(&bounds, is_above, |item| {
                    above.push(item);
                    ControlFlow::Continue(())
                });
                let is_item_above = |item: &&(u32, BoundingBox), by: f64| item.1.high.y + by >= bounds.high.y;
                let must = overlaps(0.0).filter(|item| is_item_above(item, 0.0));
                assert_between(&mut above, must, overlaps(ROUNDING).filter(|item| is_item_above(item, ROUNDING)));
                assert!(count < 3000 || looks < 600, "{looks} boxes of {count} looked at");
            }
        }
    }

    #[test]
    fn a_box_as_large_as_can_be_overlaps_all() {
        let mut random = Random::new(73);
        let all = BoundingBox { low: Vector3::repeat(f64::MIN), high: Vector3::repeat(f64::MAX) };
        for bounds in [all, BoundingBox { low: -all.high * 2.0, high: all.high * 2.0 }] {
            let mut count = 0;
            BoxTree::new(boxes(&mut random, 9)).overlapping(&bounds, |_| {
                count += 1;
                ControlFlow::Continue(())
            });
            assert_eq!(count, 9);
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
