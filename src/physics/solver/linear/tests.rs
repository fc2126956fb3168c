//! Against dense factorisations, on random graphs with blocks of all sizes.

use nalgebra::{DMatrix, DVector, SMatrix};
use simba::simd::{SimdValue, WideF64x4};

use super::elimination::{Sizes, with_layout};
use super::layout::{Layout, Number, Uniform};
use super::pivot::Pivot;
use super::{BlockLdl, BlockLu, BodyBlock, BodyVector, Elimination, Inverse, Triangular};
use crate::physics::testing::Random;

/// A chain with that many further edges.
fn graph(count: u32, further: usize, random: &mut Random) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = (1..count).map(|node| [node - 1, node]).collect();
    let pick = |random: &mut Random| random.within(0.0, f64::from(count)) as u32;
    while edges.len() < count as usize - 1 + further {
        let edge = [pick(random), pick(random)];
        if edge[0] != edge[1] {
            edges.push(edge);
        }
    }
    edges
}

/// A matrix on a graph: where each node's rows begin, its edges, and all values.
struct Sample {
    rows: Vec<u8>,
    starts: Vec<usize>,
    edges: Vec<[u32; 2]>,
    dense: DMatrix<f64>,
}

impl Sample {
    /// 1 + Σ JᵀJ over the edges, J of so many rows with entries up to 30.
    fn new(rows: Vec<u8>, edges: Vec<[u32; 2]>, random: &mut Random) -> Self {
        let starts: Vec<usize> =
            (0..=rows.len()).map(|node| rows[..node].iter().map(|&rows| usize::from(rows)).sum()).collect();
        let size = starts[rows.len()];
        let mut sample = Self { rows, starts, edges, dense: DMatrix::identity(size, size) };
        for edge in sample.edges.clone() {
            let mut jacobian = DMatrix::zeros(6, size);
            for node in edge {
                for column in sample.range(node) {
                    (0..6).for_each(|row| jacobian[(row, column)] = 30.0 * random.within(-1.0, 1.0));
                }
            }
            sample.dense += jacobian.tr_mul(&jacobian);
        }
        sample
    }

    fn range(&self, node: u32) -> std::ops::Range<usize> {
        self.starts[node as usize]..self.starts[node as usize + 1]
    }

    fn elimination(&self) -> Elimination {
        Elimination::new(&self.rows, self.edges.iter().copied(), usize::MAX).expect("no bound on the work")
    }

    fn block(&self, row: u32, column: u32) -> Vec<f64> {
        let columns = self.range(column);
        columns.flat_map(|column| self.range(row).map(move |row| self.dense[(row, column)])).collect()
    }

    fn fill<N: Number + SimdValue<Element = f64>, P: Pivot<N>>(
        &self,
        ldl: &mut BlockLdl<N, P>,
        elimination: &Elimination,
    ) {
        ldl.clear(elimination);
        let copy = |to: &mut [N], values: Vec<f64>| {
            assert_eq!(to.len(), values.len());
            to.iter_mut().zip(values).for_each(|(to, value)| *to = N::splat(value));
        };
        for node in 0..self.rows.len() as u32 {
            let place = elimination.place(node) as usize;
            let values = with_layout!(elimination, layout => layout.diagonal(place));
            copy(&mut ldl.diagonal[values], self.block(node, node));
        }
        for &[a, b] in &self.edges {
            let (block, row_is_b) = elimination.block(a, b);
            let (row, column) = if row_is_b { (b, a) } else { (a, b) };
            let block = block as usize;
            let values = with_layout!(elimination, layout => layout.below(block)..layout.below(block + 1));
            copy(&mut ldl.below[values], self.block(row, column));
        }
    }

    /// A vector by nodes, in the order of elimination; and back.
    fn ordered(&self, elimination: &Elimination, b: &DVector<f64>) -> Vec<f64> {
        let mut nodes: Vec<u32> = (0..self.rows.len() as u32).collect();
        nodes.sort_unstable_by_key(|&node| elimination.place(node));
        nodes.into_iter().flat_map(|node| self.range(node).map(|row| b[row])).collect()
    }

    /// The solution by the factor is the dense one to 1e-9: conditions are up to 1e5, and rounding 1e-16 of it.
    fn check<N: Number + SimdValue<Element = f64>, P: Pivot<N>>(
        &self,
        ldl: &mut BlockLdl<N, P>,
        elimination: &Elimination,
        random: &mut Random,
        each: impl Fn(N) -> Vec<f64>,
    ) {
        let b = DVector::from_fn(self.dense.nrows(), |_, _| random.within(-1.0, 1.0));
        let expected = self.dense.clone().cholesky().expect("a positive definite matrix").solve(&b);
        self.fill(ldl, elimination);
        assert!(ldl.factor(elimination));
        let mut x: Vec<N> = self.ordered(elimination, &b).into_iter().map(N::splat).collect();
        ldl.solve(elimination, &mut x[..]);
        for (x, expected) in x.into_iter().zip(self.ordered(elimination, &expected)) {
            for x in each(x) {
                assert!((x - expected).abs() < 1e-9 * 30.0, "{x}, not {expected}");
            }
        }
    }
}

fn sizes(random: &mut Random) -> [Vec<u8>; 4] {
    let mixed = (0..20).map(|_| random.within(1.0, 7.0) as u8).collect();
    [vec![3; 20], vec![6; 20], vec![5; 20], mixed]
}

#[test]
fn the_factor_solves_what_a_dense_one_solves() {
    let mut random = Random::new(1);
    for further in [0, 1, 5, 40] {
        for rows in sizes(&mut random) {
            let edges = graph(20, further, &mut random);
            let sample = Sample::new(rows, edges, &mut random);
            let elimination = sample.elimination();
            sample.check(&mut BlockLdl::<f64, Inverse>::default(), &elimination, &mut random, |x| vec![x]);
            sample.check(&mut BlockLdl::<f64, Triangular>::default(), &elimination, &mut random, |x| vec![x]);
        }
    }
}

#[test]
fn each_lane_is_solved_as_by_itself() {
    let mut random = Random::new(3);
    let sample = Sample::new(vec![3; 20], graph(20, 5, &mut random), &mut random);
    let lanes = |x: WideF64x4| (0..4).map(|lane| x.extract(lane)).collect();
    let elimination = sample.elimination();
    sample.check(&mut BlockLdl::<WideF64x4, Triangular>::default(), &elimination, &mut random, lanes);
}

#[test]
fn one_elimination_serves_for_other_values() {
    let mut random = Random::new(4);
    for rows in sizes(&mut random) {
        let edges = graph(20, 5, &mut random);
        let elimination = Elimination::new(&rows, edges.iter().copied(), usize::MAX).unwrap();
        let mut ldl = BlockLdl::<f64, Triangular>::default();
        for _ in 0..3 {
            let sample = Sample::new(rows.clone(), edges.clone(), &mut random);
            sample.check(&mut ldl, &elimination, &mut random, |x| vec![x]);
        }
    }
}

#[test]
fn trees_have_no_fill_and_loops_have_little() {
    let mut random = Random::new(2);
    let edges: Vec<[u32; 2]> = (1..50).map(|node| [random.within(0.0, f64::from(node)) as u32, node]).collect();
    let tree = Elimination::new(&[6; 50], edges.iter().copied(), usize::MAX).unwrap();
    assert_eq!(tree.below(), 49);
    let ring = (0..50).map(|node| [node, (node + 1) % 50]);
    assert_eq!(Elimination::new(&[6; 50], ring.clone(), usize::MAX).unwrap().below(), 49 + 48);
    assert_eq!(Elimination::new(&[6; 50], ring, 100), None, "more products than were allowed");
}

#[test]
fn inverse_pivots_refuse_a_matrix_that_is_not_positive_definite() {
    let elimination = Elimination::new(&[6, 6], [[0, 1]].into_iter(), usize::MAX).unwrap();
    let mut ldl = BlockLdl::<f64, Inverse>::default();
    ldl.clear(&elimination);
    (0..2).for_each(|place| ldl.diagonal_mut::<6>(place).fill_with_identity());
    ldl.add(elimination.block(0, 1), &(BodyBlock::identity() * 2.0));
    assert!(!ldl.factor(&elimination));
}

/// J Jᵀ of three constraints on six coordinates, of which the second repeats rows of the first: small integers, so that
/// the pivots of repeated rows are zero without rounding.
fn redundant(rows: &[u8; 3]) -> (Sample, DMatrix<f64>) {
    let starts: Vec<usize> = (0..=3).map(|node| rows[..node].iter().map(|&rows| usize::from(rows)).sum()).collect();
    let mut jacobian = DMatrix::from_fn(starts[3], 12, |row, column| f64::from(u8::from(row == column)));
    for row in starts[1]..starts[2] {
        let first = jacobian.row(row - starts[1]).clone_owned();
        jacobian.set_row(row, &first);
    }
    let sample = Sample {
        rows: rows.to_vec(),
        starts,
        edges: vec![[0, 1], [1, 2], [0, 2]],
        dense: &jacobian * jacobian.transpose(),
    };
    (sample, jacobian)
}

#[test]
fn triangular_pivots_drop_redundant_rows() {
    for rows in [[3, 3, 3], [6, 6, 6], [5, 2, 4]] {
        let (sample, jacobian) = redundant(&rows);
        let elimination = sample.elimination();
        let mut ldl = BlockLdl::<f64, Triangular>::default();
        sample.fill(&mut ldl, &elimination);
        assert!(ldl.factor(&elimination));
        let b = &jacobian * DVector::from_fn(12, |row, _| 1.0 + row as f64);
        let right = sample.ordered(&elimination, &b);
        let mut x = right.clone();
        ldl.solve(&elimination, &mut x[..]);
        let total: f64 = x.iter().map(|x| x.abs()).sum();
        assert!(total.is_finite() && total > 0.0);
        let mut back = DVector::zeros(b.len());
        let places = sample.ordered(&elimination, &DVector::from_fn(b.len(), |row, _| row as f64));
        places.iter().zip(&x).for_each(|(&place, &x)| back[place as usize] = x);
        let left = &sample.dense * back - b;
        assert!(left.amax() < 1e-12, "{rows:?}: {left}");
    }
}

#[test]
fn a_shift_and_multipliers_share_the_load_of_redundant_rows() {
    let (sample, jacobian) = redundant(&[3, 3, 3]);
    let elimination = sample.elimination();
    let mut ldl = BlockLdl::<f64, Triangular>::default();
    sample.fill(&mut ldl, &elimination);
    ldl.shift(&elimination, 1e-6);
    assert!(ldl.factor(&elimination));
    let b = &jacobian * DVector::from_fn(12, |row, _| 1.0 + row as f64);
    let least = jacobian.clone().transpose().pseudo_inverse(1e-9).expect("a pseudoinverse");
    // (J Jᵀ)⁺ = (Jᵀ)⁺ J⁺.
    let expected = &least * least.transpose() * &b;
    let places = sample.ordered(&elimination, &DVector::from_fn(b.len(), |row, _| row as f64));
    let mut x = DVector::zeros(b.len());
    for _ in 0..3 {
        let left = &b - &sample.dense * &x;
        let mut more = sample.ordered(&elimination, &left);
        ldl.solve(&elimination, &mut more[..]);
        places.iter().zip(&more).for_each(|(&place, &more)| x[place as usize] += more);
    }
    // Each of three solves leaves a share of 3e-6 / 2 of the error; rounding of the right side along the redundant rows,
    // 1e-16 of it, is divided by the shift and stays.
    assert!((&x - &expected).amax() < 1e-9 * b.amax(), "{x}, not {expected}");
}

#[test]
fn the_lu_solves_what_a_dense_one_solves() {
    let mut random = Random::new(5);
    for further in [0, 1, 5, 40] {
        let edges = graph(20, further, &mut random);
        let elimination = Elimination::new(&[6; 20], edges.iter().copied(), usize::MAX).unwrap();
        let (mut lu, mut dense) = (BlockLu::default(), DMatrix::identity(120, 120) * 10.0);
        lu.clear(&elimination);
        for node in 0..20 {
            let block = lu.diagonal_at(elimination.place(node) as usize);
            *block *= 10.0;
            // Every third has no pivots but in another order of rows.
            if node % 3 == 0 {
                let first = 6 * node as usize;
                block.swap_rows(1, 4);
                dense.swap_rows(first + 1, first + 4);
            }
        }
        for &[a, b] in &edges {
            let [ab, ba] = [0, 1].map(|_| SMatrix::<f64, 6, 6>::from_fn(|_, _| 0.3 * random.within(-1.0, 1.0)));
            let [own_ab, own_ba] = lu.blocks_at(elimination.block(a, b));
            *own_ab += ab;
            *own_ba += ba;
            for (row, column, values) in [(a, b, ab), (b, a, ba)] {
                let mut view = dense.view_mut((6 * row as usize, 6 * column as usize), (6, 6));
                view += values;
            }
        }
        let b = DVector::from_fn(120, |_, _| random.within(-1.0, 1.0));
        let expected = dense.lu().solve(&b).expect("a regular matrix");
        assert!(lu.factor(&elimination));
        let mut x = vec![BodyVector::zeros(); 20];
        for node in 0..20 {
            x[elimination.place(node) as usize] = b.fixed_rows::<6>(6 * node as usize).into();
        }
        lu.solve(&elimination, &mut x);
        for node in 0..20 {
            let error = (x[elimination.place(node) as usize] - expected.fixed_rows::<6>(6 * node as usize)).amax();
            // The diagonal dominates: nothing grows beyond rounding.
            assert!(error < 1e-12, "{further} further edges, node {node}: {error}");
        }
    }
}
