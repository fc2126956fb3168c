//! In what order the nodes of a graph are eliminated.
//!
//! Two greedy rules of Tinney & Walker (1967): the node goes first whose neighbours lack the fewest links among each other
//! (least fill), or the one with the fewest neighbours (least degree; George & Liu 1989). Both eliminate a tree from its
//! leaves, without fill. Least fill makes half the products of the other in nets, and a tenth less in heaps, but looks at all
//! neighbours of neighbours at each node: it is taken while a bit for each two nodes is little.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::physics::bit_set::BitSet;

/// Nodes up to which the order is by least fill: there may be a bit for each two of them.
const MOST_BY_FILL: usize = 4096;

/// An order of elimination.
pub(super) struct Order {
    /// Where each node stands.
    pub place: Vec<u32>,
    /// The neighbours that each node in the order has left as it goes.
    pub columns: Vec<Vec<u32>>,
}

/// The order for a graph of so many nodes; none if it makes more than `most` products of blocks.
pub(super) fn find(count: usize, edges: impl Iterator<Item = [u32; 2]>, most: usize) -> Option<Order> {
    if count <= MOST_BY_FILL { least_fill(count, edges, most) } else { least_degree(count, edges, most) }
}

/// Nodes that go one by one.
struct Progress {
    order: Order,
    products: usize,
    most: usize,
}

impl Progress {
    fn new(count: usize, most: usize) -> Self {
        let order = Order { place: vec![u32::MAX; count], columns: Vec::with_capacity(count) };
        Self { order, products: 0, most }
    }

    fn is_gone(&self, node: u32) -> bool {
        self.order.place[node as usize] != u32::MAX
    }

    /// Takes in the next node with its neighbours. None if that makes too many products.
    fn add(&mut self, node: u32, neighbours: Vec<u32>) -> Option<()> {
        self.products += neighbours.len() * (neighbours.len() + 3) / 2;
        self.order.place[node as usize] = self.order.columns.len() as u32;
        self.order.columns.push(neighbours);
        (self.products <= self.most).then_some(())
    }
}

/// The neighbours of each node.
struct Neighbours(Vec<BitSet>);

/// What a node is chosen by: the least goes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    /// Links that its neighbours lack among each other.
    missing: u32,
    neighbours: u32,
    node: u32,
}

impl Neighbours {
    fn new(count: usize, edges: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut sets = vec![BitSet::default(); count];
        for [a, b] in edges {
            sets[a as usize].set(b, true);
            sets[b as usize].set(a, true);
        }
        Self(sets)
    }

    fn rank(&self, node: u32) -> Rank {
        let own = &self.0[node as usize];
        let neighbours = own.len();
        let links: u32 = own.iter().map(|other| self.0[other as usize].common(own)).sum();
        Rank { missing: (neighbours * neighbours.saturating_sub(1) - links) / 2, neighbours, node }
    }

    /// Makes the neighbours of a node each other's, and no more its own. All whose ranks that may change: these and their
    /// neighbours.
    fn eliminate(&mut self, node: u32) -> BitSet {
        let own = std::mem::take(&mut self.0[node as usize]);
        let mut near = own.clone();
        for one in own.iter() {
            let theirs = &mut self.0[one as usize];
            theirs.add(&own);
            [one, node].into_iter().for_each(|gone| theirs.set(gone, false));
            near.add(theirs);
        }
        near
    }
}

fn least_fill(count: usize, edges: impl Iterator<Item = [u32; 2]>, most: usize) -> Option<Order> {
    let mut neighbours = Neighbours::new(count, edges);
    let mut ranks: Vec<Rank> = (0..count as u32).map(|node| neighbours.rank(node)).collect();
    // Of nodes whose rank has changed, older entries are passed over.
    let mut queue: BinaryHeap<_> = ranks.iter().copied().map(Reverse).collect();
    let mut progress = Progress::new(count, most);
    while let Some(Reverse(rank)) = queue.pop() {
        let node = rank.node;
        if progress.is_gone(node) || ranks[node as usize] != rank {
            continue;
        }
        progress.add(node, neighbours.0[node as usize].iter().collect())?;
        for one in neighbours.eliminate(node).iter() {
            let now = neighbours.rank(one);
            if now != std::mem::replace(&mut ranks[one as usize], now) {
                queue.push(Reverse(now));
            }
        }
    }
    Some(progress.order)
}

fn least_degree(count: usize, edges: impl Iterator<Item = [u32; 2]>, most: usize) -> Option<Order> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
    for [a, b] in edges {
        link(&mut neighbours, a, b);
        link(&mut neighbours, b, a);
    }
    let entry = |node: u32, neighbours: &[Vec<u32>]| Reverse((neighbours[node as usize].len(), node));
    let mut queue: BinaryHeap<_> = (0..count as u32).map(|node| entry(node, &neighbours)).collect();
    let mut progress = Progress::new(count, most);
    while let Some(Reverse((degree, node))) = queue.pop() {
        if progress.is_gone(node) || neighbours[node as usize].len() != degree {
            continue;
        }
        let column = std::mem::take(&mut neighbours[node as usize]);
        for (index, &one) in column.iter().enumerate() {
            neighbours[one as usize].retain(|&other| other != node);
            for &other in &column[..index] {
                link(&mut neighbours, one, other);
                link(&mut neighbours, other, one);
            }
        }
        queue.extend(column.iter().map(|&node| entry(node, &neighbours)));
        progress.add(node, column)?;
    }
    Some(progress.order)
}

/// Adds `b` to the neighbours of `a`.
fn link(neighbours: &mut [Vec<u32>], a: u32, b: u32) {
    let list = &mut neighbours[a as usize];
    if !list.contains(&b) {
        list.push(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The joints of a net of so many balls a side, two joined where they share a ball.
    fn net(side: u32) -> (usize, Vec<[u32; 2]>) {
        let mut at = vec![Vec::new(); (side * side) as usize];
        let mut count = 0;
        for ball in 0..side * side {
            for (is_there, next) in [((ball + 1) % side != 0, ball + 1), (ball + side < side * side, ball + side)] {
                if is_there {
                    [ball, next].into_iter().for_each(|end| at[end as usize].push(count));
                    count += 1;
                }
            }
        }
        let edges = at.iter().flat_map(|joints: &Vec<u32>| {
            (1..joints.len()).flat_map(move |later| joints[..later].iter().map(move |&one| [one, joints[later]]))
        });
        (count as usize, edges.collect())
    }

    fn products(order: &Order) -> usize {
        order.columns.iter().map(|column| column.len() * (column.len() + 3) / 2).sum()
    }

    #[test]
    fn both_orders_eliminate_each_node_once_and_least_fill_makes_fewer_products_in_a_net() {
        let (count, edges) = net(20);
        let orders = [least_fill, least_degree].map(|order| order(count, edges.iter().copied(), usize::MAX).unwrap());
        for Order { place, columns } in &orders {
            let mut places = place.clone();
            places.sort_unstable();
            assert!(places.iter().copied().eq(0..count as u32));
            for (own, column) in (0..).zip(columns) {
                assert!(column.iter().all(|&node| place[node as usize] > own), "a neighbour was gone");
            }
        }
        let [by_fill, by_degree] = orders.each_ref().map(products);
        assert!(5 * by_fill < 3 * by_degree, "{by_fill} and {by_degree} products");
        assert!(least_fill(count, edges.iter().copied(), by_fill).is_some());
        assert!(least_fill(count, edges.iter().copied(), by_fill - 1).is_none());
    }

    #[test]
    fn a_chain_of_any_length_has_no_fill() {
        for count in [100, MOST_BY_FILL + 1] {
            let order = find(count, (1..count as u32).map(|node| [node - 1, node]), usize::MAX).unwrap();
            assert!(order.columns.iter().all(|column| column.len() <= 1), "{count}");
        }
    }
}
