//! Which parts of two bodies are looked at.

use bevy::math::{DQuat, DVec3};
use nalgebra::Vector3;

use super::body;
use crate::physics::Body;
use crate::physics::collision::manifold::{ContactPoint, PartPair};
use crate::physics::collision::narrow::contact_pair::{PairSearch, touch};
use crate::physics::collision::narrow::triangle::nearest_on_triangle;
use crate::physics::collision::parts::{Way, near_parts, parts_within};
use crate::physics::shape::{Collider, CompoundChild, PartList, TriangleMesh};
use crate::physics::testing::Random;

/// One of each kind, alone or as a part.
fn solid(random: &mut Random, kind: usize) -> Collider {
    let mut size = || random.within(0.1, 1.0);
    let solid = match kind % 6 {
        0 => Collider::sphere(size()),
        1 => Collider::cuboid(size(), size(), size()),
        2 => Collider::cone(size(), size()),
        3 => Collider::cylinder(0.5 * size(), size()),
        4 => Collider::capsule(0.5 * size(), size()),
        _ => {
            let points: Vec<DVec3> = (0..10).map(|_| DVec3::new(size(), size(), size()) - 0.5).collect();
            Collider::convex_hull(&points).expect("points that span a volume")
        }
    };
    if kind < 6 {
        return solid;
    }
    let parts = [-1.2, 0.0, 1.5].map(|x| CompoundChild {
        collider: solid.clone(),
        position: DVec3::X * x,
        rotation: DQuat::from_rotation_y(x),
    });
    Collider::compound(&parts).expect("a compound")
}

#[test]
fn no_part_that_touches_a_facet_is_left_out_and_few_others_are_looked_at() {
    let mut random = Random::new(62);
    let bumps = |x: f64, z: f64| 0.4 * (3.0 * x).sin() * (2.0 * z).cos();
    let ground = Collider::mesh(TriangleMesh::height_field([4.0, 4.0], [16, 16], bumps).expect("a field"));
    let geometry = ground.geometry();
    let Some(PartList::Triangles(triangles)) = geometry.parts().map(|parts| &parts.list) else { panic!("a mesh") };
    assert_eq!(triangles.facet_count(), triangles.count(), "a facet of each");
    let (mut near, mut search, mut points) = (Vec::new(), PairSearch::default(), Vec::new());
    let (mut touching, mut looked_at) = (0, 0);
    for case in 0..600 {
        let collider = solid(&mut random, case % 12);
        let mut position: Vector3<f64> = random.vector() * 2.0;
        position.y = 0.3 * position.y + 0.5;
        let moved = random.rotation();
        let above = body(&collider, moved * position, moved * random.rotation());
        let below = body(&ground, Vector3::zeros(), moved);
        let gap = [0.0, 0.02, 0.3][case % 3];
        let pair = if case % 2 == 0 { [&below, &above] } else { [&above, &below] };
        parts_within(pair[0], pair[1], 0.5 * gap, &mut near);
        near.sort_unstable();
        looked_at += near.len();
        let parts = if case % 12 < 6 { 1 } else { 3 };
        for (facet, part) in (0..512).flat_map(|facet| (0..parts).map(move |part| (facet, part))) {
            let parts = PartPair { a: facet, b: part };
            let parts = if case % 2 == 0 { parts } else { parts.swapped() };
            points.clear();
            search.last = None;
            let Some(found) = touch(pair, parts, gap, &mut search, &mut points) else { continue };
            // Half way between the surfaces; what is deep may be in the pyramid behind the triangle and beside this.
            let is_there = |point: &ContactPoint| {
                let local = moved.inverse_transform_vector(&point.point);
                let away = (local - nearest_on_triangle(&triangles.corners_of(facet), &local)).norm();
                away <= 0.5 * point.depth.abs() + 1e-6
            };
            if found.depth < 0.05 && points.iter().any(is_there) {
                touching += 1;
                assert!(near.binary_search(&parts).is_ok(), "case {case}: {parts:?} of {near:?}");
            }
        }
    }
    assert!(touching > 500 && looked_at < 25_000, "{looked_at} looked at, {touching} touch");
}

/// How far bodies move that do not.
fn still(_: &Body, _: &Vector3<f64>, _: f64) -> f64 {
    0.0
}

/// Over clusters polyhedra are tested along the normals of triangles alone: against the exact test of each, which tries all.
#[test]
fn over_a_cluster_what_touches_is_as_deep_along_the_normals_of_triangles_alone() {
    let mut random = Random::new(64);
    let waves = |x: f64, z: f64| 0.25 * x.sin() * (1.5 * z).cos();
    let ground = Collider::mesh(TriangleMesh::height_field([6.0, 6.0], [24, 24], waves).expect("a field"));
    let geometry = ground.geometry();
    let Some(PartList::Triangles(triangles)) = geometry.parts().map(|parts| &parts.list) else { panic!("a mesh") };
    let clusters: Vec<u32> = triangles.clustered().iter().copied().filter(|&part| triangles.is_cluster(part)).collect();
    let in_clusters: usize = clusters.iter().map(|&cluster| triangles.triangles_of(cluster).len()).sum();
    // All but those that have a corner at the border.
    assert_eq!(in_clusters, 2 * 22 * 22);
    assert!((4..30).contains(&clusters.len()), "{} clusters", clusters.len());
    let below = body(&ground, Vector3::zeros(), Default::default());
    let (mut near, mut points, mut search) = (Vec::new(), Vec::new(), PairSearch::default());
    let (mut touching, mut most_apart, mut lowest) = (0, 0.0_f64, f64::INFINITY);
    for case in 0..3000 {
        let mut position: Vector3<f64> = random.vector() * 1.5;
        position.y = 0.5 + 0.3 * position.y;
        let above = body(&solid(&mut random, [1, 5][case % 2]), position, random.rotation());
        let mut deepest = |by_cluster: bool| {
            search.is_exact = !by_cluster;
            near.clear();
            near_parts([&below, &above], by_cluster.then_some(&still as &Way), |_, _, _| 0.0, &mut near);
            points.clear();
            for &parts in &near {
                search.last = None;
                let first = points.len();
                let found = touch([&below, &above], parts, 0.0, &mut search, &mut points);
                if let Some(found) = found.filter(|_| by_cluster) {
                    assert!((1..=4).contains(&(points.len() - first)));
                    lowest = lowest.min(found.normal.y);
                }
            }
            points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max)
        };
        let [alone, all] = [true, false].map(&mut deepest);
        if (1e-3..0.05).contains(&all) {
            touching += 1;
            most_apart = most_apart.max((alone - all).abs() / all);
        }
    }
    assert!(touching > 100 && most_apart < 0.05, "{touching} touch, apart by {most_apart}");
    assert!(lowest > 0.9, "a normal {lowest} up");
}

/// What is known of the distance to a cluster never is more than it is.
#[test]
fn what_is_apart_from_a_cluster_is_so_by_as_much_as_told() {
    let mut random = Random::new(65);
    let waves = |x: f64, z: f64| 0.2 * x.sin() * (1.5 * z).cos();
    let ground = Collider::mesh(TriangleMesh::height_field([6.0, 6.0], [24, 24], waves).expect("a field"));
    let below = body(&ground, Vector3::zeros(), Default::default());
    let (mut near, mut points, mut search) = (Vec::new(), Vec::new(), PairSearch::default());
    let (mut told, mut sharp) = (0, 0);
    for case in 0..6000 {
        let mut position: Vector3<f64> = random.vector() * 1.5;
        position.y = 0.9 + 0.5 * position.y;
        let mut above = body(&solid(&mut random, [1, 5][case % 2]), position, random.rotation());
        near.clear();
        near_parts([&below, &above], Some(&still), |_, _, _| 0.5, &mut near);
        for parts in std::mem::take(&mut near) {
            search.last = None;
            points.clear();
            let found = touch([&below, &above], parts, 0.0, &mut search, &mut points);
            let apart = search.apart;
            if found.is_some() || apart <= 1e-6 {
                continue;
            }
            // By less than that in any direction, nothing touches.
            let at = above.position;
            for _ in 0..4 {
                above.position = at + random.direction() * (0.999 * apart);
                points.clear();
                let found = touch([&below, &above], parts, 0.0, &mut search, &mut points);
                assert!(found.is_none(), "case {case}: {apart} {found:?}");
                told += 1;
            }
            above.position = at - Vector3::y() * (2.0 * apart);
            points.clear();
            sharp += u32::from(touch([&below, &above], parts, 0.0, &mut search, &mut points).is_some());
            above.position = at;
        }
    }
    assert!(told > 4000 && sharp > 50, "{told} told, {sharp} touch where twice as far down");
}

/// A surface has normals of its own where edges meet; what is round, and overlaps it, finds one of them with some facet.
#[test]
fn what_is_round_touches_a_surface_along_a_normal_that_the_surface_has() {
    let mut random = Random::new(63);
    let (mut near, mut search, mut points) = (Vec::new(), PairSearch::default(), Vec::new());
    let (mut overlapping, mut lost) = (0, 0);
    for case in 0..60_000 {
        let ends =
            [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| [1.0, -1.0].map(|side| axis * (side * random.within(0.2, 1.5))));
        let vertices: Vec<DVec3> = ends.into_iter().flatten().collect();
        let triangle = |octant: u32| {
            let [x, y, z] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
            if octant.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
        };
        let triangles: Vec<[u32; 3]> = (0..8).map(triangle).collect();
        let mesh = body(
            &Collider::mesh(TriangleMesh::new(&vertices, &triangles).expect("eight triangles")),
            Vector3::zeros(),
            random.rotation(),
        );
        let round = body(&solid(&mut random, 2 + case % 2), random.vector() * 1.2, random.rotation());
        parts_within(&mesh, &round, 0.0, &mut near);
        let mut touches = |any_normal: bool, near: &[PartPair]| {
            (search.any_normal, search.is_sheet) = (any_normal, any_normal);
            near.iter().any(|&parts| {
                points.clear();
                search.last = None;
                touch([&mesh, &round], parts, 0.0, &mut search, &mut points).is_some_and(|found| found.depth > 1e-3)
            })
        };
        if touches(true, &near) {
            overlapping += 1;
            lost += u32::from(!touches(false, &near));
        }
    }
    assert!(overlapping > 10_000 && lost * 400 < overlapping, "{lost} of {overlapping} are lost");
}
