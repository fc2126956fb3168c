//! Shapes apart by less than a gap, and what of touching ones stands off by less.

use std::f64::consts::{FRAC_PI_4, PI, SQRT_2};

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::hulls::{hull_body, hull_of, least_depths, random_hull};
use super::{assert_close, body, cones, random_size, upright};
use crate::physics::body::Body;
use crate::physics::collision::manifold::{ContactPoint, FeatureId, Overlap, PartPair};
use crate::physics::collision::narrow::clipping::keep_touching_spread;
use crate::physics::collision::narrow::contact_pair::{self, PairSearch};
use crate::physics::shape::{Collider, Geometry};
use crate::physics::testing::Random;

fn touch_within(gap: f64, a: &Body, b: &Body) -> Option<(Overlap, Vec<ContactPoint>)> {
    let mut points = Vec::new();
    let overlap = contact_pair::touch([a, b], PartPair::default(), gap, &mut PairSearch::default(), &mut points)?;
    assert!((1..=4).contains(&points.len()));
    for (index, point) in points.iter().enumerate() {
        assert!(points[..index].iter().all(|other| other.feature != point.feature), "a name twice: {points:x?}");
        assert!(point.depth >= -gap - 1e-8);
    }
    Some((overlap, points))
}

fn cube() -> Body {
    upright(&Collider::cuboid(1.0, 1.0, 1.0), [0.0; 3])
}

fn cube_hull() -> Body {
    let corner = |bits: u32| Vector3::from_fn(|row, _| if bits >> row & 1 == 0 { 0.5 } else { -0.5 });
    hull_body(hull_of(&(0..8).map(corner).collect::<Vec<_>>()), Vector3::zeros(), UnitQuaternion::identity())
}

fn ball() -> Body {
    upright(&Collider::sphere(0.5), [0.0; 3])
}

/// Base up or down, at y = ±1/2.
fn cone(base_up: bool) -> Body {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * if base_up { PI } else { 0.0 });
    body(&Collider::cone(0.4, 2.0), Vector3::zeros(), turn)
}

/// As high as a cube.
fn cylinder(lying: bool) -> Body {
    let turn = Vector3::z() * if lying { PI / 2.0 } else { 0.0 };
    body(&Collider::cylinder(0.4, 1.0), Vector3::zeros(), UnitQuaternion::from_scaled_axis(turn))
}

fn turned(body: Body, axis: Vector3<f64>) -> Body {
    Body { rotation: UnitQuaternion::from_scaled_axis(axis * FRAC_PI_4), ..body }
}

fn at(position: Vector3<f64>, body: &Body) -> Body {
    Body { position, ..body.clone() }
}

fn reach(body: &Body, direction: &Vector3<f64>) -> f64 {
    match body.geometry {
        Some(Geometry::Sphere { radius }) => radius,
        _ => cones::reach(body, direction),
    }
}

fn outside(body: &Body, point: &Vector3<f64>) -> f64 {
    match body.geometry {
        Some(Geometry::Sphere { radius }) => (point - body.position).norm() - radius,
        _ => cones::outside(body, point),
    }
}

/// How far B is beyond A along a unit direction; at most their distance.
fn separation(a: &Body, b: &Body, direction: &Vector3<f64>) -> f64 {
    (b.position - a.position).dot(direction) - reach(a, direction) - reach(b, &-direction)
}

/// What lies one above the other, the distance of the centres and the number of points.
fn stacks() -> Vec<(&'static str, Body, Body, f64, usize)> {
    let crossing = [turned(cube(), Vector3::z()), turned(cube(), Vector3::x())];
    let crossing_hull = turned(cube_hull(), Vector3::x());
    vec![
        ("box, box", cube(), cube(), 1.0, 4),
        ("box, hull", cube(), cube_hull(), 1.0, 4),
        ("hull, hull", cube_hull(), cube_hull(), 1.0, 4),
        ("ball, ball", ball(), ball(), 1.0, 1),
        ("ball, box", ball(), cube(), 1.0, 1),
        ("ball, hull", ball(), cube_hull(), 1.0, 1),
        ("ball, cone", ball(), cone(false), 1.0, 1),
        ("ball, apex", ball(), cone(true), 2.0, 1),
        ("cone on box", cube(), cone(false), 1.0, 4),
        ("cone on hull", cube_hull(), cone(false), 1.0, 4),
        ("base on base", cone(true), cone(false), 1.0, 4),
        ("apex on box", cube(), cone(true), 2.0, 1),
        ("cylinder on box", cube(), cylinder(false), 1.0, 4),
        ("cylinder on hull", cube_hull(), cylinder(false), 1.0, 4),
        ("cylinder on cylinder", cylinder(false), cylinder(false), 1.0, 4),
        ("roller on box", cube(), cylinder(true), 0.9, 2),
        ("roller on cylinder", cylinder(false), cylinder(true), 0.9, 2),
        ("cone on cylinder", cylinder(false), cone(false), 1.0, 4),
        ("apex on cylinder", cylinder(false), cone(true), 2.0, 1),
        ("ball on cylinder", cylinder(false), ball(), 1.0, 1),
        ("edge on edge", crossing[0].clone(), crossing[1].clone(), SQRT_2, 1),
        ("edge on edge of a hull", crossing[0].clone(), crossing_hull, SQRT_2, 1),
        ("edge on face", cube(), turned(cube(), Vector3::x()), 0.5 + SQRT_2 / 2.0, 2),
    ]
}

#[test]
fn shapes_one_above_the_other_touch_within_the_gap_only() {
    for (name, below, above, height, count) in stacks() {
        for distance in [1e-6, 0.01, 0.3] {
            let above = at(Vector3::new(0.0, height + distance, 0.0), &above);
            for (a, b, up) in [(&below, &above, 1.0), (&above, &below, -1.0)] {
                assert!(touch_within(0.0, a, b).is_none(), "{name}");
                assert!(touch_within(0.99 * distance, a, b).is_none(), "{name}: beyond the gap");
                let (overlap, points) = touch_within(1.01 * distance, a, b).unwrap_or_else(|| panic!("{name}: apart"));
                assert_close(overlap.normal, Vector3::y() * up, 1e-6);
                assert!((overlap.depth + distance).abs() < 1e-9, "{name}: {} of {distance}", overlap.depth);
                assert_eq!(points.len(), count, "{name}");
                for point in points {
                    assert!((point.depth + distance).abs() < 1e-9, "{name}: {} of {distance}", point.depth);
                    let top = if name.starts_with("edge on edge") { SQRT_2 / 2.0 } else { 0.5 };
                    assert!((point.point.y - top - distance / 2.0).abs() < 1e-6, "{name}: {}", point.point);
                }
            }
        }
    }
}

#[test]
fn corners_of_a_tilted_box_hover_by_their_height() {
    let tilt = 0.1_f64;
    let slab = Collider::cuboid(3.0, 1.0, 3.0);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * tilt);
    // Overlapping, and apart.
    for height in [1.0, 1.07] {
        let at_corner = |side: f64| 0.5 * (tilt.cos() + side * tilt.sin()) - (height - 0.5);
        for upper in [cube(), cube_hull()] {
            let upper = Body { position: Vector3::y() * height, rotation: turn, ..upper };
            let (_, points) = touch_within(-at_corner(-1.0) + 0.001, &upright(&slab, [0.0; 3]), &upper).unwrap();
            assert_eq!(points.len(), 4);
            for point in points {
                let expected = at_corner(-point.point.x.signum());
                assert!((point.depth - expected).abs() < 1e-12, "{} is not {expected}", point.depth);
                assert!((point.point.y - (0.5 - expected / 2.0)).abs() < 1e-12, "half-way");
            }
            let (_, points) = touch_within(-at_corner(-1.0) - 0.001, &upright(&slab, [0.0; 3]), &upper).unwrap();
            assert_eq!(points.len(), 2, "the others are beyond the gap");
        }
    }
}

#[test]
fn beside_each_other_the_distance_is_that_of_corners_and_edges() {
    for upper in [cube(), cube_hull()] {
        let corner = at(Vector3::new(1.02, 1.01, 1.015), &upper);
        let apart = Vector3::new(0.02, 0.01, 0.015);
        let (overlap, points) = touch_within(apart.norm() + 1e-6, &cube(), &corner).unwrap();
        assert_close(overlap.normal, apart.normalize(), 1e-9);
        assert!((overlap.depth + apart.norm()).abs() < 1e-9);
        assert_eq!(points.len(), 1);
        assert_close(points[0].point, Vector3::repeat(0.5) + apart / 2.0, 1e-9);
        assert!(touch_within(apart.norm() - 1e-6, &cube(), &corner).is_none(), "the axes' 0.02 are not the distance");

        // Along z half of the edges is beside each other.
        let edge = at(Vector3::new(1.01, 1.02, 0.5), &upper);
        let apart = Vector3::new(0.01, 0.02, 0.0);
        for (a, b, sign) in [(&cube(), &edge, 1.0), (&edge, &cube(), -1.0)] {
            let (overlap, points) = touch_within(0.05, a, b).unwrap();
            assert_close(overlap.normal, apart.normalize() * sign, 1e-9);
            assert_eq!(points.len(), 2);
            for point in points {
                assert!((point.depth + apart.norm()).abs() < 1e-9);
                assert!(point.point.z.abs() < 1e-9 || (point.point.z - 0.5).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn normals_turn_continuously_as_a_box_slides_off_another() {
    for upper in [cube(), cube_hull()] {
        let mut last: Option<Vector3<f64>> = None;
        for step in 0..600 {
            let beyond = 1e-4 * f64::from(step - 200);
            let above = at(Vector3::new(1.0 + beyond, 1.01, 0.3), &upper);
            let (overlap, _) = touch_within(0.06, &cube(), &above).unwrap();
            let distance = beyond.max(0.0).hypot(0.01);
            assert!((overlap.depth + distance).abs() < 1e-6, "{} is not {distance}", overlap.depth);
            // 0.1 mm at 1 cm.
            assert!(last.is_none_or(|last| last.angle(&overlap.normal) < 0.0101), "a leap at {beyond}");
            last = Some(overlap.normal);
        }
    }
}

fn random_body(random: &mut Random, kind: usize) -> Body {
    match kind {
        0 => body(&Collider::sphere(random_size(random)), Vector3::zeros(), random.rotation()),
        1 => {
            let cuboid = Collider::cuboid(random_size(random), random_size(random), random_size(random));
            body(&cuboid, Vector3::zeros(), random.rotation())
        }
        2 => cones::random_cone(random),
        3 => cones::random_cylinder(random),
        _ => hull_body(random_hull(random), Vector3::zeros(), random.rotation()),
    }
}

/// At least the distance of two shapes, near to it: the nearest of A's points less B's to the
/// origin, on segments to ever new support points (Gilbert 1966).
fn distance_from_above(a: &Body, b: &Body) -> f64 {
    let foremost = |body: &Body, direction: &Vector3<f64>| {
        let local = body.rotation.inverse() * direction;
        let farthest = |points: &mut dyn Iterator<Item = Vector3<f64>>| {
            points.max_by(|one, other| one.dot(&local).total_cmp(&other.dot(&local))).unwrap()
        };
        let point = match body.geometry.as_ref().unwrap() {
            Geometry::Sphere { radius } => local * (*radius / local.norm()),
            Geometry::Cuboid { half } => half.zip_map(&local, |half, along| half.copysign(along)),
            Geometry::Capsule { radius, half, .. } => {
                Vector3::y() * half.copysign(local.y) + local * (*radius / local.norm())
            }
            Geometry::Cylinder { radius, half, .. } => {
                Vector3::new(local.x, 0.0, local.z).normalize() * *radius + Vector3::y() * half.copysign(local.y)
            }
            Geometry::Cone { radius, height, .. } => {
                let rim = Vector3::new(local.x, 0.0, local.z).normalize() * *radius - Vector3::y() * (0.25 * height);
                farthest(&mut [Vector3::y() * (0.75 * height), rim].into_iter())
            }
            Geometry::Hull(hull) => farthest(&mut hull.vertices.iter().copied()),
            Geometry::HalfSpace | Geometry::Parts(_) => unreachable!(),
        };
        body.position + body.rotation * point
    };
    let mut nearest = b.position - a.position;
    for _ in 0..3000 {
        let next = foremost(b, &-nearest) - foremost(a, &nearest);
        let along = next - nearest;
        let length = along.norm_squared();
        if length < 1e-24 {
            break;
        }
        nearest += along * (-nearest.dot(&along) / length).clamp(0.0, 1.0);
    }
    nearest.norm()
}

/// The kinds of two bodies, balls to hulls.
fn kinds() -> impl Iterator<Item = [usize; 2]> {
    (0..5).flat_map(|one| (0..5).map(move |other| [one, other]))
}

#[test]
fn separation_is_that_of_the_normal_and_at_most_the_distance() {
    let mut random = Random::new(61);
    let (mut tested, mut exact) = (0, 0);
    for kinds in kinds() {
        for _ in 0..60 {
            let [a, b] = kinds.map(|kind| random_body(&mut random, kind));
            let along = random.direction();
            // Touching bounds along the direction, then some more.
            let apart = reach(&a, &along) + reach(&b, &-along);
            let size = a.radius.min(b.radius);
            let b = at(along * (apart + random.random_range(0.0..0.2) * size), &b);
            let distance = distance_from_above(&a, &b);
            let Some((overlap, points)) = touch_within(2.0 * size, &a, &b) else {
                assert!(distance > 2.0 * size - 1e-9, "{kinds:?}: {distance} is within the gap");
                continue;
            };
            tested += 1;
            let measured = separation(&a, &b, &overlap.normal);
            assert!((measured + overlap.depth).abs() < 1e-9, "{kinds:?}: {} is not {measured}", overlap.depth);
            assert!(-overlap.depth <= distance + 1e-9, "{kinds:?}: {} of {distance}", overlap.depth);
            // Faces may be preferred, twice by a twentieth.
            exact += u32::from(-overlap.depth > 0.9 * distance - 2e-4 * size);
            if kinds.contains(&0) {
                // The two ends of the way across are points of the bodies: it is no less than the distance.
                let half = overlap.normal * (overlap.depth / 2.0);
                let [on_a, on_b] = [points[0].point + half, points[0].point - half];
                assert!(outside(&a, &on_a).max(outside(&b, &on_b)) < 1e-9, "{kinds:?}: not the true distance");
            }
            if kinds.iter().all(|kind| [1, 4].contains(kind)) {
                let least = least_depths(&a, &b).into_iter().fold(f64::INFINITY, f64::min);
                assert!(
                    overlap.depth < 0.9 * least + 2.1e-4 * size,
                    "{kinds:?}: {} by all axes {least}",
                    overlap.depth
                );
            }
            for point in &points {
                assert!(point.depth <= overlap.depth + 1e-9, "{kinds:?}: {} of {}", point.depth, overlap.depth);
            }
        }
    }
    assert!(exact * 10 > tested * 8, "the distance itself is found for {exact} of {tested}");
}

#[test]
fn over_a_face_the_separation_is_the_distance() {
    let mut random = Random::new(62);
    let (mut along_face, mut tested) = (0, 0);
    for trial in 0..1600 {
        let over = if trial < 1200 { [1, 2, 4][trial / 2 % 3] } else { 3 };
        let [a, b] = [[1, 4][trial % 2], over].map(|kind| random_body(&mut random, kind));
        // A face of A, and the point in the middle of its corners.
        let features = super::hulls::Features::of(&a);
        let normal = features.normals[random.random_range(0..features.normals.len())];
        let level = reach(&a, &normal);
        let corners: Vec<_> = features.vertices.iter().filter(|corner| corner.dot(&normal) > level - 1e-9).collect();
        let middle = corners.iter().copied().sum::<Vector3<f64>>() / corners.len() as f64;
        // B's foremost point is over it: the gradient of the support function.
        let size = a.radius.min(b.radius);
        let distance = random.random_range(0.001..0.1) * size;
        let nudge = |axis: Vector3<f64>| {
            let step = 1e-6;
            (reach(&b, &(-normal + axis * step)) - reach(&b, &(-normal - axis * step))) / (2.0 * step)
        };
        let foremost = Vector3::new(nudge(Vector3::x()), nudge(Vector3::y()), nudge(Vector3::z()));
        let b = at(middle + normal * distance - foremost, &b);
        let distance = separation(&a, &b, &normal);
        let (overlap, points) = touch_within(0.2 * size, &a, &b).expect("within the gap");
        tested += 1;
        assert!(-overlap.depth <= distance + 1e-9);
        assert!(-overlap.depth > 0.9 * distance - 2e-4 * size, "{} of {distance}", overlap.depth);
        if overlap.normal.dot(&normal) > 1.0 - 1e-12 {
            along_face += 1;
            assert!((overlap.depth + distance).abs() < 1e-9);
            let nearest = points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
            // The face of a hull that is clipped need not hold its foremost vertex.
            let is_hull = matches!(b.geometry, Some(Geometry::Hull(_)));
            let slack = if is_hull { 0.5 * size } else { 3e-4 * size };
            assert!((-distance - slack..=-distance + 1e-9).contains(&nearest), "{nearest} of {distance}");
            for point in points {
                // Both ends of the way across are on the surfaces.
                let half = normal * (point.depth / 2.0);
                let off = outside(&a, &(point.point + half)).max(outside(&b, &(point.point - half)));
                assert!(off < 1e-3 * size, "{off} of {size}");
            }
        }
    }
    assert!(along_face * 10 > tested * 8, "{along_face} of {tested}");
}

#[test]
fn a_gap_adds_hovering_points_to_touching_shapes_and_changes_nothing_else() {
    let mut random = Random::new(63);
    let (mut compared, mut hovering) = (0, 0);
    for kinds in kinds() {
        for _ in 0..150 {
            let [a, b] = kinds.map(|kind| random_body(&mut random, kind));
            let size = a.radius.min(b.radius);
            let b = at(random.direction() * (a.radius + b.radius) * random.random_range(0.1..0.8), &b);
            let Some((overlap, points)) = touch_within(0.0, &a, &b) else { continue };
            assert!(overlap.depth >= 0.0 && points.iter().all(|point| point.depth >= 0.0), "{kinds:?}");
            // Less deep overlaps, as in stacks.
            let b = at(b.position + overlap.normal * 0.99 * overlap.depth, &b);
            let Some((overlap, points)) = touch_within(0.0, &a, &b) else { continue };
            let (within, more) = touch_within(0.1 * size, &a, &b).expect("touching");
            assert_eq!((within.normal, within.depth), (overlap.normal, overlap.depth), "{kinds:?}");
            hovering += more.iter().filter(|point| point.depth < 0.0).count();
            if more.iter().any(|point| point.depth < 0.0 && point.depth > -2e-4 * size) {
                continue; // which counts as touching in the choice of four
            }
            compared += 1;
            for point in points.iter().filter(|point| point.depth > 0.0) {
                assert!(more.contains(point), "{kinds:?}: {point:?} is not among {more:?}");
            }
        }
    }
    assert!(compared > 1000 && hovering > 200, "{compared} {hovering}");
}

#[test]
fn hovering_boxes_keep_their_normal_and_features() {
    let mut random = Random::new(64);
    for (height, upper) in [(1.002, cube()), (1.002, cube_hull()), (1.002, cone(false))] {
        let pose = |random: &mut Random| Body {
            position: Vector3::new(0.2, height, -0.1) + random.vector() * 1e-6,
            rotation: UnitQuaternion::from_scaled_axis(random.vector() * 1e-5),
            ..upper.clone()
        };
        let names = |points: Vec<ContactPoint>| points.iter().map(|point| point.feature).collect::<Vec<_>>();
        let first = names(touch_within(0.01, &cube(), &pose(&mut random)).unwrap().1);
        for _ in 0..50 {
            let (overlap, points) = touch_within(0.01, &cube(), &pose(&mut random)).unwrap();
            assert_close(overlap.normal, Vector3::y(), 1e-3);
            assert_eq!(names(points), first);
        }
    }
}

#[test]
fn touching_points_are_kept_before_far_ones() {
    let mut random = Random::new(65);
    for touching in 0..9_usize {
        for _ in 0..200 {
            let mut found: Vec<_> = (0..touching + 6)
                .map(|index| {
                    let range = if index < touching { 0.0..0.01 } else { -0.1..-0.001 };
                    // Far ones spread wider.
                    let reach = if index < touching { 0.3 } else { 1.0 };
                    let [x, z] = [(); 2].map(|()| random.random_range(-reach..reach));
                    let depth = random.random_range(range);
                    ContactPoint { point: Vector3::new(x, 0.0, z), depth, feature: FeatureId(index as u64) }
                })
                .collect();
            let mut kept = Vec::new();
            let deepest = found.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
            keep_touching_spread(&mut found, &Vector3::y(), 1.0, &mut kept);
            assert_eq!(kept.iter().filter(|point| point.depth >= 0.0).count(), touching.min(4).min(kept.len()));
            assert!(kept.len() <= 4 && kept.len() >= touching.clamp(2, 3));
            assert!(kept.iter().any(|point| point.depth > deepest - 2e-4), "the deepest is not kept");
        }
    }
}

/// Moved by so little, an overlap changes by no more where the least is asked for, whatever axis it is along; where faces
/// are preferred it jumps by some of the margin that they have.
#[test]
fn another_axis_makes_no_overlap_where_the_least_is_asked_for() {
    const STEP: f64 = 1e-5;
    let mut random = Random::new(11);
    let mut worst = [0.0_f64; 2];
    for case in 0..150 {
        let [a, b] = [0, 1].map(|_| random_body(&mut random, [1, 4][case % 2]));
        let (a, b) = (at(Vector3::zeros(), &a), at(Vector3::zeros(), &b));
        let normal = random.direction();
        let mut touching = normal * (0.5 * (reach(&a, &normal) + reach(&b, &-normal)));
        for _ in 0..3 {
            let (overlap, _) = touch_within(0.5, &a, &at(touching, &b)).expect("they are near");
            touching += overlap.normal * overlap.depth;
        }
        let across = normal.cross(&random.direction()).normalize();
        for (is_exact, worst) in [true, false].into_iter().zip(&mut worst) {
            let mut search = PairSearch { is_exact, ..PairSearch::default() };
            let mut before: Option<f64> = None;
            for step in -400..400 {
                let moved = at(touching + across * (STEP * f64::from(step)), &b);
                let found = contact_pair::touch([&a, &moved], PartPair::default(), 0.05, &mut search, &mut Vec::new());
                let depth = found.map(|overlap| overlap.depth);
                if let (Some(depth), Some(before)) = (depth, before) {
                    *worst = worst.max((depth - before).abs());
                }
                before = depth;
            }
        }
    }
    let [exact, preferred] = worst;
    assert!(exact < 1.1 * STEP, "{exact:e}");
    assert!(preferred > 4.0 * STEP, "no case was one: {preferred:e}");
}

/// A cylinder that lies across an end of another, or across the base of a cone, tilted so that one end of its line is deepest:
/// between a side of the polygon that stands for the disc and the rim it is as deep as it overlaps, where the least is asked for.
#[test]
fn what_lies_over_a_rim_is_as_deep_as_it_overlaps() {
    const DEPTH: f64 = 1e-4;
    let (bar, half) = (Collider::cylinder(0.1, 0.6), 0.3);
    let discs = [upright(&Collider::cylinder(0.4, 1.0), [0.0; 3]), cone(true)];
    let mut short = 0;
    for disc in &discs {
        for step in 0..48 {
            let (angle, out) = (f64::from(step) * PI / 48.0, 0.4 * if step % 2 == 0 { 0.998 } else { 1.01 });
            let aside = Vector3::new(angle.cos(), 0.0, angle.sin());
            let turned = UnitQuaternion::rotation_between(&Vector3::y(), &aside).expect("no half turn");
            let tilted = UnitQuaternion::from_scaled_axis(Vector3::y().cross(&aside) * 0.01) * turned;
            let [along, down] = [Vector3::y(), turned.inverse() * -Vector3::y()].map(|way| tilted * way);
            let (end, foot) = (along * half + down * 0.1, aside * out + Vector3::y() * (0.5 - DEPTH));
            let bar = body(&bar, foot - end, tilted);
            for is_exact in [true, false] {
                let (mut search, mut points) = (PairSearch { is_exact, ..PairSearch::default() }, Vec::new());
                let pair = [disc, &bar];
                let overlap = contact_pair::touch(pair, PartPair::default(), 0.01, &mut search, &mut points);
                let overlap = overlap.expect("they overlap");
                let deepest = points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
                if is_exact {
                    assert!((deepest - overlap.depth).abs() < 1e-9, "{step}: {deepest} of {}", overlap.depth);
                } else {
                    short += u32::from(deepest < overlap.depth - 1e-6);
                }
            }
        }
    }
    assert!(short > 10, "{short} are deeper than the polygon says");
}
