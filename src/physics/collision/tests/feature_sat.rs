use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::hulls::{Features, depth_along, hull_body, least_depths, random_hull};
use super::{assert_close, body, exact, random_size, touch, upright};
use crate::physics::body::Body;
use crate::physics::settings::{ContactModel, SolverSettings};
use crate::physics::shape::{Collider, Geometry};
use crate::physics::testing::Random;

fn clipping() -> SolverSettings {
    exact(ContactModel::Clipping)
}

/// A box, or a hull, at the origin or away from it.
fn random_polyhedron(random: &mut Random, at: Vector3<f64>) -> Body {
    let turn = random.rotation();
    if random.random_range(0..3) == 0 {
        let cuboid = Collider::cuboid(random_size(random), random_size(random), random_size(random));
        body(&cuboid, at, turn)
    } else {
        hull_body(random_hull(random), at, turn)
    }
}

/// Two polyhedra in all relative poses, from one about the other's centre to far apart.
fn random_polyhedra(random: &mut Random) -> [Body; 2] {
    let (a, b) = (random_polyhedron(random, Vector3::zeros()), random_polyhedron(random, Vector3::zeros()));
    let distance = (a.radius + b.radius) * random.random_range(0.0..1.0);
    let position = random.direction() * distance;
    [a, Body { position, ..b }]
}

/// The depth that the preference for faces makes of the least along faces of A, faces of B and
/// edges; none where the choice is within rounding.
fn preferred([of_a, of_b, of_edges]: [f64; 3], size: f64) -> Option<f64> {
    let mut best = of_a;
    for rival in [of_b, of_edges] {
        let limit = 0.95 * best - 1e-4 * size;
        if (rival - limit).abs() < 1e-9 {
            return None;
        }
        best = if rival < limit { rival } else { best };
    }
    Some(best)
}

#[test]
fn depth_and_normal_are_the_least_over_all_faces_and_edges() {
    let mut random = Random::new(31);
    let (mut touching, mut apart, mut deep, mut across) = (0, 0, 0, 0);
    for _ in 0..6000 {
        let [a, b] = random_polyhedra(&mut random);
        let size = a.radius.min(b.radius);
        let depths = least_depths(&a, &b);
        let least = depths.into_iter().fold(f64::INFINITY, f64::min);
        if least.abs() < 1e-8 {
            continue;
        }
        let found = touch(&a, &b, &clipping());
        assert_eq!(found.is_some(), least > 0.0, "least depth {least}");
        let Some((found, _)) = found else {
            apart += 1;
            continue;
        };
        touching += 1;
        deep += u32::from(least > 0.5 * size);
        across += u32::from(depths[2] < 0.9 * depths[0].min(depths[1]));
        let along = depth_along(&Features::of(&a), &Features::of(&b), &(b.position - a.position), &found.normal);
        assert!((along - found.depth).abs() < 1e-9, "depth {} is not that of the normal, {along}", found.depth);
        if let Some(expected) = preferred(depths, size) {
            assert!((found.depth - expected).abs() < 1e-9, "{} is not {expected}, of {depths:?}", found.depth);
        }
    }
    assert!(touching > 2000 && apart > 500 && deep > 500 && across > 100, "{touching} {apart} {deep} {across}");
}

#[test]
fn boxes_are_tested_as_hulls_are() {
    let mut random = Random::new(32);
    let mut touching = 0;
    for _ in 0..3000 {
        let [a, b] = [(); 2].map(|()| {
            let size = Vector3::from_fn(|_, _| random_size(&mut random));
            // Some turns are by right angles about axes, with parallel edges and faces.
            let turn = if random.random_range(0..3) == 0 {
                UnitQuaternion::from_scaled_axis(Vector3::z() * (FRAC_PI_4 * f64::from(random.random_range(0..8))))
            } else {
                random.rotation()
            };
            body(&Collider::cuboid(size.x, size.y, size.z), random.direction() * 0.8, turn)
        });
        let least = preferred(least_depths(&a, &b), a.radius.min(b.radius));
        match (touch(&a, &b, &clipping()), least) {
            (Some((found, _)), Some(least)) => {
                touching += 1;
                assert!((found.depth - least).abs() < 1e-9, "{} is not {least}", found.depth);
            }
            (None, Some(least)) => assert!(least < 0.0, "called apart at {least}"),
            (_, None) => {}
        }
    }
    assert!(touching > 1000);
}

#[test]
fn edge_on_edge_has_the_normal_of_the_edges() {
    let edge_up = |axis: Vector3<f64>| UnitQuaternion::from_scaled_axis(axis * FRAC_PI_4);
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let mut random = Random::new(33);
    for _ in 0..200 {
        // A cube on its edge under another across it, at any angle but near parallel, where
        // a face would be less deep.
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * random.random_range(0.8..2.3));
        let depth = random.random_range(0.0..0.02);
        let lower = body(&cube, Vector3::zeros(), edge_up(Vector3::z()));
        let shift = Vector3::new(random.random_range(-0.1..0.1), SQRT_2 - depth, random.random_range(-0.1..0.1));
        let upper = body(&cube, shift, turn * edge_up(Vector3::z()));
        let (found, points) = touch(&lower, &upper, &clipping()).expect("touch");
        assert_close(found.normal, Vector3::y(), 1e-9);
        assert!((found.depth - depth).abs() < 1e-9);
        assert_eq!(points.len(), 1);
        // The edges cross over the lower one's line, x = 0, on the way to the upper one's.
        assert!(points[0].point.x.abs() < 1e-9, "{:?}", points[0].point);
        assert!((points[0].point.y - (SQRT_2 / 2.0 - depth / 2.0)).abs() < 1e-9);
    }
}

#[test]
fn normal_and_depth_are_continuous_but_where_two_axes_tie() {
    let mut random = Random::new(34);
    let (mut smooth, mut all) = (0, 0);
    for _ in 0..2000 {
        let [a, b] = random_polyhedra(&mut random);
        let turn = UnitQuaternion::from_scaled_axis(random.direction() * 1e-6);
        let turned = Body { rotation: turn * b.rotation, ..b.clone() };
        let (Some((before, _)), Some((after, _))) = (touch(&a, &b, &clipping()), touch(&a, &turned, &clipping()))
        else {
            continue;
        };
        all += 1;
        let jump = (before.normal - after.normal).norm();
        smooth += u32::from(jump < 1e-3);
        // Where the axis changes, both are within the preference for faces of the least.
        let allowed = 1e-4 * before.depth + if jump < 1e-3 { 1e-5 } else { 0.11 * before.depth + 1e-3 };
        assert!((before.depth - after.depth).abs() < allowed, "{} to {}", before.depth, after.depth);
    }
    assert!(all > 1000 && smooth * 1000 > all * 995, "{smooth} of {all}");
}

#[test]
fn points_lie_on_both_hulls() {
    let mut random = Random::new(35);
    let mut checked = 0;
    for _ in 0..5000 {
        let [a, b] = random_polyhedra(&mut random);
        let Some((overlap, points)) = touch(&a, &b, &clipping()) else { continue };
        assert!((1..=4).contains(&points.len()));
        let size = a.radius.min(b.radius);
        for point in &points {
            assert!(point.depth >= 0.0 && point.depth <= overlap.depth + 1e-9);
            // In deep overlaps of thin bodies a corner below the reference face may have come out
            // on the far side.
            if overlap.depth < 0.1 * size {
                checked += 1;
                let apart = height_over(&a, &point.point).max(height_over(&b, &point.point));
                assert!(apart < 0.5 * point.depth + 1e-4 * size, "{apart} m outside, depth {}", point.depth);
            }
        }
    }
    assert!(checked > 200, "{checked}");
}

/// Height of a point over the highest of the planes of a polyhedron.
fn height_over(body: &Body, point: &Vector3<f64>) -> f64 {
    let features = Features::of(body);
    let arm = point - body.position;
    let top = |normal: &Vector3<f64>| {
        features.vertices.iter().map(|vertex| vertex.dot(normal)).fold(f64::NEG_INFINITY, f64::max)
    };
    features.normals.iter().map(|normal| normal.dot(&arm) - top(normal)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn faces_of_many_sides_give_four_named_points() {
    // Two drums of 300 sides, one on the other, aside and turned.
    let drum = |radius: f64| {
        let rim = |side: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(side) / 300.0).sin_cos();
            [-0.5, 0.5].map(|y| Vector3::new(radius * sin, y, radius * cos))
        };
        let vertices: Vec<_> = (0..300).flat_map(rim).collect();
        let next = |side: u32| (side + 1) % 300;
        let top = (0..300).map(|side| 2 * side + 1).collect();
        let bottom = (0..300).rev().map(|side| 2 * side).collect();
        let sides = (0..300).map(|side| vec![2 * side, 2 * next(side), 2 * next(side) + 1, 2 * side + 1]);
        crate::physics::shape::Hull::new(vertices, [top, bottom].into_iter().chain(sides).collect())
    };
    let lower = hull_body(drum(1.0), Vector3::zeros(), UnitQuaternion::identity());
    for shift in [0.0, 0.7, 1.6] {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * 0.4);
        let upper = hull_body(drum(0.8), Vector3::new(shift, 0.99, 0.0), turn);
        let (found, points) = touch(&lower, &upper, &clipping()).expect("touch");
        assert_close(found.normal, Vector3::y(), 1e-12);
        assert_eq!(points.len(), 4);
        for (index, point) in points.iter().enumerate() {
            assert!((point.depth - 0.01).abs() < 1e-12);
            assert!(points[..index].iter().all(|other| other.feature != point.feature), "a name twice");
            let [from_lower, from_upper] = [0.0, shift].map(|x| (point.point - Vector3::x() * x).xz().norm());
            assert!(from_lower < 1.0 + 1e-4 && from_upper < 0.8 + 1e-4);
        }
    }
}

#[test]
fn slivers_and_faces_edge_on_stay_finite() {
    let mut random = Random::new(36);
    for _ in 0..2000 {
        let sliver = |random: &mut Random| {
            let sizes = Vector3::from_fn(|_, _| 10_f64.powf(random.random_range(-4.0..0.5)));
            let turn = UnitQuaternion::from_scaled_axis(
                random.direction() * if random.random_range(0..2) == 0 { 1e-8 } else { 1.0 },
            );
            body(&Collider::cuboid(sizes.x, sizes.y, sizes.z), Vector3::zeros(), turn)
        };
        let (a, b) = (sliver(&mut random), sliver(&mut random));
        let mut b = Body { position: random.direction() * 0.3 * a.radius, ..b };
        if random.random_range(0..2) == 0 {
            let Some(Geometry::Cuboid { half }) = b.geometry else { unreachable!() };
            let corners: Vec<_> = (0..8)
                .map(|bits| half.map_with_location(|row, _, half| if bits >> row & 1 == 0 { half } else { -half }))
                .collect();
            b = hull_body(
                crate::physics::shape::Hull::new(
                    corners,
                    vec![
                        vec![0, 2, 6, 4],
                        vec![1, 5, 7, 3],
                        vec![0, 4, 5, 1],
                        vec![2, 3, 7, 6],
                        vec![0, 1, 3, 2],
                        vec![4, 6, 7, 5],
                    ],
                ),
                b.position,
                b.rotation,
            );
        }
        let Some((overlap, points)) = touch(&a, &b, &clipping()) else { continue };
        assert!((overlap.normal.norm() - 1.0).abs() < 1e-9 && overlap.depth.is_finite());
        assert!((1..=4).contains(&points.len()));
        for point in points {
            assert!(point.point.iter().all(|along| along.is_finite()) && point.depth.is_finite());
            assert!((point.point - b.position).norm() < 2.0 * (a.radius + b.radius));
        }
    }
}

#[test]
fn cubes_that_share_a_centre_part_along_a_face() {
    let cube = upright(&Collider::cuboid(1.0, 2.0, 3.0), [0.0; 3]);
    let (found, points) = touch(&cube, &cube, &clipping()).expect("touch");
    assert_close(found.normal, Vector3::x(), 1e-15);
    assert_eq!(found.depth, 1.0);
    assert_eq!(points.len(), 4);
}
