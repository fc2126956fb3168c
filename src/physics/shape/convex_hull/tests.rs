//! Hulls of friendly and unfriendly points against what a hull is.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use nalgebra::Matrix3;

use super::*;
use crate::physics::testing::Random;

/// As the docs say, of half the largest extent: what the reduction and the merging may cut off.
const TOLERANCE: f64 = 0.012;

/// Of half the largest extent, where there are not enough vertices to be as near.
const ROUND: f64 = 0.04;

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
    let vertices: Vec<DVec3> = hull.vertices().collect();
    for (corners, (normal, offset)) in hull.faces().zip(planes(hull)) {
        assert!(offset > 0.0, "a face looks inward");
        for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let [from, to] = [from, to].map(|corner| vertices[corner as usize]);
            let inward = normal.cross(to - from).normalize();
            let beyond = corners.iter().map(|&corner| inward.dot(from - vertices[corner as usize])).fold(0.0, f64::max);
            assert!(beyond <= BEND * size, "a face is not convex: a corner is {} beyond a side", beyond / size);
        }
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
    let mut random = Random::new(5);
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
    let mut random = Random::new(1);
    for round in 0..600 {
        let count = 4 + (random.unit().powi(3) * 300.0) as usize;
        let flatness = DVec3::new(1.0, 10_f64.powf(random.within(-3.0, 0.0)), 10_f64.powf(random.within(-3.0, 0.0)));
        let turn = random.rotation();
        let on_sphere = round % 2 == 0;
        let points: Vec<DVec3> = (0..count)
            .map(|_| if on_sphere { random.direction() } else { random.vector() })
            .map(|point| dvec(turn * Vector3::from(dvec(point) * flatness)))
            .collect();
        let tolerance = if count > ConvexHull::MAX_VERTICES { ROUND } else { TOLERANCE };
        hull_within(&points, tolerance);
    }
}

#[test]
fn needles_and_plates_keep_their_thickness() {
    let mut random = Random::new(2);
    for thin in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        // Cross products of a needle's long sides round to its thinness squared.
        let rounding = 1e-11 + 1e-16 / (thin * thin);
        for size in [DVec3::new(1.0, thin, 1.0), DVec3::new(1.0, thin, thin), DVec3::new(1.0, thin, 0.1)] {
            for _ in 0..20 {
                let turn = quaternion(&random.rotation());
                let corners: Vec<DVec3> = box_corners(size).into_iter().map(|corner| turn * corner).collect();
                let hull = hull_within(&corners, 0.02 * thin);
                assert_eq!(counts(&hull), (8, 6), "{size}");
                let volume = hull.volume() / size.element_product() - 1.0;
                assert!(volume.abs() < rounding, "{size}: volume {volume} off");
                let thickness = hull.thickness() / thin - 1.0;
                assert!(thickness.abs() < rounding, "{size}: thickness {thickness} off");
            }
        }
    }
}

#[test]
fn clusters_of_near_and_equal_points_are_one_vertex_each() {
    let mut random = Random::new(3);
    for spread in [0.0, 1e-14, 1e-9, 1e-5, 1e-3] {
        let points: Vec<DVec3> = (0..300)
            .flat_map(|_| box_corners(DVec3::new(2.0, 1.0, 1.5)))
            .map(|corner| corner + spread * dvec(random.vector()))
            .collect();
        let hull = hull_of(&points);
        assert_eq!(hull.vertices().len(), 8, "spread {spread}");
    }
}

#[test]
fn vertices_nearer_than_the_reduction_are_one() {
    let cut = |depth: f64| {
        let corners = box_corners(DVec3::new(2.0, 1.5, 1.0)).into_iter();
        let points: Vec<DVec3> =
            corners.flat_map(|corner| DVec3::AXES.map(|axis| corner - depth * corner.signum() * axis)).collect();
        hull_of(&points)
    };
    // Twice the depth is their L1 distance from each other; the reduction is by 0.01.
    assert_eq!(cut(4e-3).vertices().len(), 8);
    assert_eq!(counts(&cut(6e-3)), (24, 14));
}

#[test]
fn place_and_scale_do_not_matter() {
    let mut random = Random::new(4);
    let points: Vec<DVec3> = (0..60).map(|_| dvec(random.direction()) * DVec3::new(1.0, 0.8, 0.6)).collect();
    let here = hull_of(&points);
    for (scale, offset) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e6), (1e-3, 1e6), (1e30, 0.0), (1e-30, 0.0)] {
        let place = DVec3::new(1.0, -2.0, 3.0) * offset;
        let moved: Vec<DVec3> = points.iter().map(|point| point * scale + place).collect();
        let there = hull_of(&moved);
        assert_eq!(counts(&there), counts(&here), "{scale} {offset}");
        // Of the coordinates as they are given.
        let rounding = 1e-12 + 1e-15 * offset / scale;
        assert!((there.volume() / scale.powi(3) / here.volume() - 1.0).abs() < rounding, "{scale} {offset}");
        assert!(
            (there.center() - place - here.center() * scale).length() < 10.0 * rounding * scale,
            "{scale} {offset}"
        );
    }
}

#[test]
fn a_million_points_become_a_few() {
    let mut random = Random::new(6);
    let sphere: Vec<DVec3> = (0..1_000_000).map(|_| dvec(random.direction())).collect();
    let hull = hull_without_names(&sphere, ROUND);
    assert!((hull.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 0.05, "{}", hull.volume());
    let filled: Vec<DVec3> = (0..1_000_000).map(|_| dvec(random.vector()) * DVec3::new(1.0, 0.5, 2.0)).collect();
    let hull = hull_without_names(&filled, TOLERANCE);
    assert!((hull.volume() / 8.0 - 1.0).abs() < 0.02, "{}", hull.volume());
    let clustered: Vec<DVec3> =
        (0..1_000_000).map(|i| box_corners(DVec3::ONE)[i % 8] + 5e-4 * dvec(random.vector())).collect();
    assert_eq!(hull_without_names(&clustered, TOLERANCE).vertices().len(), 8);
}

/// As [`hull_within`], without looking for each vertex among a million points.
fn hull_without_names(points: &[DVec3], tolerance: f64) -> ConvexHull {
    let hull = ConvexHull::new(points).unwrap_or_else(|error| panic!("{error}"));
    let vertices: Vec<DVec3> = hull.vertices().map(|vertex| hull.center() + hull.axes() * vertex).collect();
    assert_is_polyhedron(&vertices, &hull);
    let outside = farthest_outside(points, &hull);
    assert!(outside <= tolerance, "a point lies {outside} of half the extent outside");
    hull
}

#[test]
fn round_things_keep_within_four_per_cent() {
    let mut random = Random::new(8);
    for count in [200, 1000, 20_000] {
        for stretch in [DVec3::ONE, DVec3::new(1.0, 0.3, 0.7), DVec3::new(1.0, 0.05, 1.0)] {
            let points: Vec<DVec3> = (0..count).map(|_| dvec(random.direction()) * stretch).collect();
            hull_within(&points, ROUND);
        }
        // On a lattice of one sphere, where four and more points share each plane.
        let rings = (f64::from(count) / 2.0).sqrt() as i32;
        let points: Vec<DVec3> = (0..=rings)
            .flat_map(|i| {
                (0..2 * rings)
                    .map(move |j| (PI * f64::from(i) / f64::from(rings), PI * f64::from(j) / f64::from(rings)))
            })
            .map(|(polar, turn)| DVec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()))
            .collect();
        hull_within(&points, ROUND);
    }
}

#[test]
fn a_prism_has_two_polygons() {
    for sides in [3, 5, 12, 24, 48, 64] {
        let ring = |y: f64| {
            (0..sides).map(move |i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
                DVec3::new(sin, y, cos)
            })
        };
        let points: Vec<DVec3> = ring(-0.7).chain(ring(0.7)).collect();
        assert_eq!(counts(&hull_of(&points)), (2 * sides as usize, sides as usize + 2));
    }
}

#[test]
fn the_same_points_give_the_same_bits() {
    let mut random = Random::new(9);
    let points: Vec<DVec3> = (0..5000).map(|_| dvec(random.vector())).collect();
    let (one, other) = (hull_of(&points), hull_of(&points));
    assert_eq!(one, other);
    assert_eq!(format!("{one:?}"), format!("{other:?}"));
    assert_ne!(one, hull_of(&points[..4000]));
}

#[test]
fn what_has_no_volume_is_refused_in_one_line() {
    let refused = |points: &[DVec3]| {
        let error = ConvexHull::new(points).expect_err("no volume");
        assert!(!error.to_string().contains('\n'));
        error
    };
    let mut random = Random::new(10);
    assert_eq!(refused(&[]), HullError::TooFewPoints { count: 0 });
    assert_eq!(refused(&[DVec3::ZERO, DVec3::X, DVec3::Y]), HullError::TooFewPoints { count: 3 });
    assert_eq!(refused(&[DVec3::ONE; 9]), HullError::Coincident { count: 9 });
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.0, 0.0, bad), DVec3::Z];
        assert_eq!(refused(&points), HullError::NotFinite { index: 3 });
    }
    for noise in [0.0, 1e-15, 1e-9, 1e-7] {
        for place in [DVec3::ZERO, DVec3::new(5.0, 6.0, 7.0)] {
            let (along, across) = (dvec(random.direction()), dvec(random.direction()));
            let mut near = |point: DVec3| place + point + noise * dvec(random.vector());
            let line: Vec<DVec3> = (0..50).map(|i| near(f64::from(i) / 25.0 * along)).collect();
            assert_eq!(refused(&line), HullError::Collinear { count: 50 }, "noise {noise}");
            let plane: Vec<DVec3> =
                (0..50).map(|i| near(f64::from(i % 7) / 3.0 * along + f64::from(i / 7) / 3.0 * across)).collect();
            assert_eq!(refused(&plane), HullError::Flat { count: 50 }, "noise {noise}");
        }
    }
    for size in [1e80, 1e300, 1e-80, 1e-300] {
        let corners: Vec<DVec3> = box_corners(DVec3::ONE).into_iter().map(|corner| corner * size).collect();
        assert!(matches!(refused(&corners), HullError::Extent { .. }), "size {size}");
    }
}

fn quaternion(rotation: &nalgebra::UnitQuaternion<f64>) -> DQuat {
    DQuat::from_xyzw(rotation.i, rotation.j, rotation.k, rotation.w)
}

/// Volume, centre and principal moments per kilogram of an ellipsoidal, boxy or other body, and
/// the axes, must be those of the given points however the body is placed.
#[track_caller]
fn assert_measures(hull: &ConvexHull, volume: f64, center: DVec3, axes: DQuat, moments: DVec3, tolerance: f64) {
    let size = hull.bounding_radius();
    assert!((hull.volume() / volume - 1.0).abs() < tolerance, "volume {} for {volume}", hull.volume());
    assert!(hull.center().distance(center) < tolerance * size, "center {} for {center}", hull.center());
    let turned = hull.axes().angle_between(axes);
    assert!(turned < tolerance.sqrt().max(1e-6), "axes turned by {turned} rad");
    let off = (hull.measures().moments / moments - 1.0).abs().max_element();
    assert!(off < tolerance, "moments {} for {moments}", hull.measures().moments);
}

#[test]
fn a_box_askew_is_the_box() {
    let mut random = Random::new(11);
    let size = DVec3::new(0.5, 1.3, 2.1);
    let moments = crate::physics::shape::cuboid::measures(size).moments;
    for angle in [1e-7, 1e-3, 0.1, 0.3, 0.7] {
        for _ in 0..20 {
            // Below a turn of 45° no other order of the axes is nearer.
            let turn = DQuat::from_axis_angle(dvec(random.direction()), angle);
            let place = 5.0 * dvec(random.vector());
            let points: Vec<DVec3> = box_corners(size).into_iter().map(|corner| place + turn * corner).collect();
            let hull = hull_of(&points);
            assert_measures(&hull, size.element_product(), place, turn, moments, 1e-12);
        }
    }
}

#[test]
fn equal_moments_leave_the_axes_as_near_as_can_be() {
    let axes_of = |size: DVec3, turn: DQuat| {
        let points: Vec<DVec3> = box_corners(size).into_iter().map(|corner| turn * corner).collect();
        hull_of(&points).axes()
    };
    let turn = DQuat::from_euler(bevy::math::EulerRot::XYZ, 0.4, -0.7, 1.1);
    assert_eq!(axes_of(DVec3::ONE, turn), DQuat::IDENTITY, "a cube has no axes of its own");
    assert_eq!(axes_of(DVec3::new(1.0, 2.0, 1.0), DQuat::from_rotation_y(0.3)), DQuat::IDENTITY);
    // A square rod: only its length has a direction, and the shortest way there is no spin about it.
    for (size, unit) in [(DVec3::new(1.0, 3.0, 1.0), DVec3::Y), (DVec3::new(1.0, 1.0, 0.2), DVec3::Z)] {
        let turn =
            DQuat::from_axis_angle(DVec3::new(1.0, 0.5, 0.25).normalize(), 0.5) * DQuat::from_axis_angle(unit, 0.7);
        let axes = axes_of(size, turn);
        assert!((axes * unit).distance(turn * unit) < 1e-9);
        assert!(axes.angle_between(DQuat::from_rotation_arc(unit, turn * unit)) < 1e-7);
    }
}

#[test]
fn a_tetrahedron_has_its_closed_form() {
    // One corner at the origin and one on each axis: centroid a quarter of each leg; about it
    // ∫x² = 3/80 a² and ∫xy = −ab/80 of the mass.
    let legs = DVec3::new(1.0, 2.0, 3.0);
    let place = DVec3::new(-3.0, 10.0, 0.5);
    let points: Vec<DVec3> =
        [DVec3::ZERO, legs.x * DVec3::X, legs.y * DVec3::Y, legs.z * DVec3::Z].map(|corner| place + corner).to_vec();
    let hull = hull_of(&points);
    assert_eq!(counts(&hull), (4, 4));
    assert!((hull.volume() - legs.element_product() / 6.0).abs() < 1e-14);
    assert!(hull.center().distance(place + legs / 4.0) < 1e-14);
    let square = 3.0 / 80.0 * legs * legs;
    let across = DVec3::new(square.y + square.z, square.z + square.x, square.x + square.y);
    let expected = Matrix3::new(
        across.x,
        legs.x * legs.y / 80.0,
        legs.x * legs.z / 80.0, //
        legs.x * legs.y / 80.0,
        across.y,
        legs.y * legs.z / 80.0, //
        legs.x * legs.z / 80.0,
        legs.y * legs.z / 80.0,
        across.z,
    );
    let turn = Matrix3::from_columns(&DVec3::AXES.map(|axis| Vector3::from(hull.axes() * axis)));
    let inertia = turn * Matrix3::from_diagonal(&Vector3::from(hull.measures().moments)) * turn.transpose();
    assert!((inertia - expected).abs().max() < 1e-14, "{inertia} for {expected}");
}

#[test]
fn a_polygonal_cone_nears_the_cone() {
    let (radius, height) = (0.6, 1.1);
    let Measures { volume, moments, .. } = crate::physics::shape::cone::measures(radius, height);
    for sides in [12, 24, 48] {
        let rim = (0..sides).map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            DVec3::new(radius * sin, 0.0, radius * cos)
        });
        let points: Vec<DVec3> = rim.chain([height * DVec3::Y]).collect();
        // The polygon's area is sin(2π/n)/(2π/n) of the circle's: 6.6/n² of it are missing.
        let tolerance = 10.0 / f64::from(sides * sides);
        assert_measures(&hull_of(&points), volume, height / 4.0 * DVec3::Y, DQuat::IDENTITY, moments, tolerance);
    }
}

#[test]
fn any_hull_has_the_volume_integrals_of_a_grid() {
    let mut random = Random::new(12);
    for _ in 0..3 {
        let points: Vec<DVec3> = (0..40).map(|_| dvec(random.vector()) * DVec3::new(1.0, 0.6, 0.8)).collect();
        let hull = hull_of(&points);
        let planes = planes(&hull);
        let reach = hull.vertices().fold(DVec3::ZERO, |reach, vertex| reach.max(vertex.abs()));
        crate::physics::shape::tests::assert_matches_integral(&crate::physics::Collider::hull(hull), reach, |point| {
            planes.iter().all(|(normal, offset)| normal.dot(point) <= *offset)
        });
    }
}
