use std::collections::HashSet;

use nalgebra::Vector3;
use rand::RngExt;

use crate::physics::collision::classic::vector_set::VectorSet;
use crate::physics::testing::Random;

fn l1(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    (a - b).abs().sum()
}

#[test]
fn keeps_what_a_plain_search_keeps() {
    let mut random = Random::new(1);
    let mut set = VectorSet::default();
    for (epsilon, merge) in [(0.0, false), (1e-3, false), (1e-3, true), (0.07, false), (0.3, true)] {
        set.reset(epsilon, merge, 1.0);
        let mut kept: Vec<Vector3<f64>> = Vec::new();
        // Clusters about a few directions and their opposites, within and beyond ε; some beyond
        // the reach.
        let centers: Vec<_> = (0..40).map(|_| random.direction() * random.random_range(0.5..1.5)).collect();
        for _ in 0..2000 {
            let sign = if random.random() { 1.0 } else { -1.0 };
            let center = centers[random.random_range(0..centers.len())];
            let vector = center * sign + random.vector() * epsilon;
            let near =
                |other: &Vector3<f64>| l1(other, &vector) <= epsilon || (merge && l1(other, &-vector) <= epsilon);
            let new = !kept.iter().any(near);
            assert_eq!(set.insert(vector), new, "ε {epsilon}, merge {merge}");
            if new {
                kept.push(vector);
            }
        }
        assert_eq!(set.vectors(), kept);
        assert!(kept.len() >= if merge { 40 } else { 80 }, "the clusters fell together");
    }
}

/// Among a thousand directions, as two fine hulls give: a search looks into one cell, and whatever ε is, nothing is in
/// more than nine. Looking into every chain within ε, nearly all empty, cost more than all else once.
#[test]
fn no_vector_is_listed_in_more_than_nine_cells() {
    let mut random = Random::new(2);
    let directions: Vec<_> = (0..1300).map(|_| random.direction()).collect();
    let mut set = VectorSet::default();
    for epsilon in [0.0, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5] {
        set.reset(epsilon, false, 1.0);
        let near: Vec<_> = directions.iter().map(|direction| set.cells_near(direction)).collect();
        let listed: Vec<_> = near.iter().map(|[columns, rows]| columns.len() * rows.len()).collect();
        assert!(listed.iter().all(|cells| (1..=9).contains(cells)), "ε {epsilon}: {listed:?}");
        let first: HashSet<_> = near.iter().map(|[columns, rows]| (columns.start, rows.start)).collect();
        assert!(epsilon > 0.1 || first.len() > 200, "ε {epsilon}: in {} cells only", first.len());
        // Where cells are much larger than ε, most are within reach of no other.
        let all: usize = listed.iter().sum();
        assert!(epsilon > 0.001 || all < 14 * directions.len() / 10, "ε {epsilon}: {all} cells");
    }
}

#[test]
fn epsilon_is_in_the_l1_norm_and_inclusive() {
    let mut set = VectorSet::default();
    set.reset(0.25, false, 1.0);
    assert!(set.insert(Vector3::new(1.0, 0.0, 0.0)));
    assert!(!set.insert(Vector3::new(0.875, 0.125, 0.0)), "at L1 distance 0.25, Euclidean 0.18");
    assert!(set.insert(Vector3::new(0.875, 0.125, 0.125)), "at L1 distance 0.375, Euclidean 0.22");
}

#[test]
fn opposites_count_as_one_only_if_asked() {
    let mut set = VectorSet::default();
    for merge in [false, true] {
        set.reset(1e-3, merge, 1.0);
        assert!(set.insert(Vector3::y()));
        assert_eq!(set.insert(-Vector3::y()), !merge);
    }
}

#[test]
fn directions_are_normalised_and_zero_is_dropped() {
    let mut set = VectorSet::default();
    let slant = Vector3::new(3.0, 0.0, 4.0);
    assert_eq!(set.insert_direction(slant), Some(slant / 5.0));
    // The cross product of two edges that are parallel but for rounding.
    let edge = slant.normalize();
    assert_eq!(set.insert_direction(edge.cross(&(edge + Vector3::y() * 1e-9))), None);
    assert_eq!(set.vectors().len(), 1);
}

#[test]
fn reset_forgets() {
    let mut set = VectorSet::default();
    set.insert(Vector3::x());
    set.reset(0.0, false, 1.0);
    assert!(set.vectors().is_empty());
    assert!(set.insert(Vector3::x()));
}
