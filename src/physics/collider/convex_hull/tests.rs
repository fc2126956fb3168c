//! Hulls of friendly and unfriendly points against what a hull is.

use std::collections::BTreeSet;

use super::*;
use crate::physics::testing::Random;

/// As the docs say, of half the largest extent: what the reduction and the merging may cut off.
const TOLERANCE: f64 = 0.012;

/// Of half the largest extent: faces may bend by a thousandth, and lean by as much.
const BEND: f64 = 2e-3;

fn half_extent(points: &[DVec3]) -> f64 {
    let [low, high] = points.iter().fold([points[0]; 2], |[low, high], &p| [low.min(p), high.max(p)]);
    (high - low).max_element() / 2.0
}

/// Unit normal and offset of each face, from its corners alone.
fn planes(hull: &ConvexHull) -> Vec<(DVec3, f64)> {
    let vertices: Vec<DVec3> = hull.vertices().collect();
    let plane = |corners: &[u32]| {
        let at = |index: usize| vertices[corners[index % corners.len()] as usize];
        let middle = (0..corners.len()).map(at).sum::<DVec3>() / corners.len() as f64;
        let area: DVec3 = (0..corners.len()).map(|i| (at(i) - middle).cross(at(i + 1) - middle)).sum();
        let normal = area.normalize();
        (normal, normal.dot(middle))
    };
    hull.faces().map(plane).collect()
}

/// Closed, convex, outward, with vertices that are among the points.
#[track_caller]
fn assert_is_polyhedron(points: &[DVec3], hull: &ConvexHull) {
    let size = half_extent(points);
    let count = hull.vertices().len();
    assert!((4..=ConvexHull::MAX_VERTICES).contains(&count), "{count} vertices");
    let mut sides = BTreeSet::new();
    let mut used: BTreeSet<u32> = BTreeSet::new();
    for corners in hull.faces() {
        assert!(corners.len() >= 3);
        used.extend(corners);
        for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            assert!(sides.insert((from, to)), "two faces on the same side of an edge");
        }
    }
    assert!(sides.iter().all(|&(from, to)| sides.contains(&(to, from))), "an edge has one face");
    assert_eq!(used.len(), count, "a vertex has no face");
    assert_eq!(count + hull.faces().len(), sides.len() / 2 + 2, "Euler: V + F = E + 2");
    for (normal, offset) in planes(hull) {
        assert!(offset > 0.0, "a face looks inward");
        let highest = hull.vertices().map(|vertex| normal.dot(vertex) - offset).fold(0.0, f64::max);
        assert!(highest <= BEND * size, "a vertex {} in front of a face", highest / size);
    }
    for vertex in hull.vertices() {
        let given = hull.center() + hull.axes() * vertex;
        let nearest = points.iter().map(|point| point.distance(given)).fold(f64::INFINITY, f64::min);
        assert!(
            nearest <= 1e-14 * (given.length() + hull.center().length() + size),
            "a vertex of its own, {nearest} off"
        );
    }
}

/// How far a point is in front of a face at most, of half the largest extent.
fn farthest_outside(points: &[DVec3], hull: &ConvexHull) -> f64 {
    let (planes, to_body) = (planes(hull), hull.axes().inverse());
    let outside = |point: &DVec3| {
        let local = to_body * (point - hull.center());
        planes.iter().map(|(normal, offset)| normal.dot(local) - offset).fold(f64::NEG_INFINITY, f64::max)
    };
    points.iter().map(outside).fold(f64::NEG_INFINITY, f64::max) / half_extent(points)
}

#[track_caller]
fn hull_within(points: &[DVec3], tolerance: f64) -> ConvexHull {
    let hull = ConvexHull::new(points).unwrap_or_else(|error| panic!("{error}"));
    assert_is_polyhedron(points, &hull);
    let outside = farthest_outside(points, &hull);
    assert!(outside <= tolerance, "a point lies {outside} of half the extent outside");
    hull
}

#[track_caller]
fn hull_of(points: &[DVec3]) -> ConvexHull {
    hull_within(points, TOLERANCE)
}

fn dvec(v: Vector3<f64>) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

fn box_corners(size: DVec3) -> Vec<DVec3> {
    let signs = [-0.5, 0.5];
    signs.iter().flat_map(|&x| signs.map(|y| signs.map(|z| DVec3::new(x, y, z) * size))).flatten().collect()
}

fn counts(hull: &ConvexHull) -> (usize, usize) {
    (hull.vertices().len(), hull.faces().len())
}

#[test]
fn a_box_keeps_its_exact_corners() {
    for size in [
        DVec3::ONE,
        DVec3::new(1.0, 0.04, 0.7),
        DVec3::new(0.2, 1.0, 0.5),
        DVec3::new(1.0, 1e-3, 1.0),
        DVec3::new(1e-3, 1e-3, 5.0),
    ] {
        let corners = box_corners(size);
        let hull = hull_of(&corners);
        assert_eq!(counts(&hull), (8, 6), "{size}");
        assert_eq!((hull.center(), hull.axes()), (DVec3::ZERO, DQuat::IDENTITY));
        assert!(hull.vertices().eq(corners), "{size}");
        assert!((hull.volume() / size.element_product() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_cube_of_lattice_points_has_eight_vertices() {
    let line = || (0..=6).map(|i| f64::from(i) / 6.0 - 0.5);
    let points: Vec<DVec3> =
        line().flat_map(|x| line().flat_map(move |y| line().map(move |z| DVec3::new(x, y, z)))).collect();
    let hull = hull_of(&points);
    assert_eq!(counts(&hull), (8, 6));
    assert!(hull.vertices().eq(box_corners(DVec3::ONE)));
}

#[test]
fn noise_on_faces_merges() {
    let mut random = Random(5);
    for noise in [1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4] {
        let line = || (0..=9).map(|i| f64::from(i) / 9.0 - 0.5);
        let points: Vec<DVec3> = line()
            .flat_map(|x| line().flat_map(move |y| line().map(move |z| DVec3::new(x, y, z))))
            .map(|point| point + noise * dvec(random.vector()))
            .collect();
        assert_eq!(counts(&hull_of(&points)), (8, 6), "noise {noise}");
    }
    for noise in [3e-4, 1e-3, 3e-3, 1e-2, 0.1] {
        for _ in 0..20 {
            let line = || (0..=5).map(|i| f64::from(i) / 5.0 - 0.5);
            let points: Vec<DVec3> = line()
                .flat_map(|x| line().flat_map(move |y| line().map(move |z| DVec3::new(x, y, z))))
                .map(|point| point + noise * dvec(random.vector()))
                .collect();
            hull_of(&points);
        }
    }
}

#[test]
fn random_points_of_any_number_and_proportion() {
    let mut random = Random(1);
    for round in 0..600 {
        let count = 4 + (random.unit().powi(3) * 300.0) as usize;
        let flatness = DVec3::new(1.0, 10_f64.powf(random.within(-3.0, 0.0)), 10_f64.powf(random.within(-3.0, 0.0)));
        let turn = random.rotation();
        let on_sphere = round % 2 == 0;
        let points: Vec<DVec3> = (0..count)
            .map(|_| if on_sphere { random.direction() } else { random.vector() })
            .map(|point| dvec(turn * vector(dvec(point) * flatness)))
            .collect();
        let tolerance = if count > ConvexHull::MAX_VERTICES { 0.03 } else { TOLERANCE };
        hull_within(&points, tolerance);
    }
}
