//! Cones are true circular cones in clipped contacts.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::hulls::{Features, hull_body, random_hull};
use super::{assert_close, body, deepest, exact, random_size, touch, upright};
use crate::physics::body::Body;
use crate::physics::settings::{ContactModel, SolverSettings};
use crate::physics::shape::{Collider, Geometry};
use crate::physics::testing::Random;

fn clipping() -> SolverSettings {
    exact(ContactModel::Clipping)
}

/// Radius and height of a body that is a cone.
fn cone_size(body: &Body) -> Option<(f64, f64)> {
    match body.geometry.as_ref()? {
        Geometry::Cone { radius, height, .. } => Some((*radius, *height)),
        _ => None,
    }
}

/// Radius and half the height of a body that is a cylinder.
fn cylinder_size(body: &Body) -> Option<(f64, f64)> {
    match body.geometry.as_ref()? {
        Geometry::Cylinder { radius, half, .. } => Some((*radius, *half)),
        _ => None,
    }
}

/// How far a shape reaches along a world direction from its centre.
pub fn reach(body: &Body, direction: &Vector3<f64>) -> f64 {
    if let Some((radius, height)) = cone_size(body) {
        let local = body.rotation.inverse() * direction;
        return f64::max(0.75 * height * local.y, -0.25 * height * local.y + radius * local.xz().norm());
    }
    if let Some((radius, half)) = cylinder_size(body) {
        let local = body.rotation.inverse() * direction;
        return half * local.y.abs() + radius * local.xz().norm();
    }
    Features::of(body).vertices.iter().map(|vertex| vertex.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}

fn depth_along(a: &Body, b: &Body, direction: &Vector3<f64>) -> f64 {
    reach(a, direction) + reach(b, &-direction) - (b.position - a.position).dot(direction)
}

/// The least overlap over all directions: of many, then from the best of these down in smaller and
/// smaller steps. Never less than the truth.
fn least_by_search(a: &Body, b: &Body, random: &mut Random) -> f64 {
    let mut tried: Vec<_> = (0..400)
        .map(|_| {
            let direction = random.direction();
            (depth_along(a, b, &direction), direction)
        })
        .collect();
    tried.sort_by(|one, other| one.0.total_cmp(&other.0));
    let descend = |&(mut least, mut direction): &(f64, Vector3<f64>)| {
        let mut step = 0.2;
        while step > 1e-6 {
            let better = (0..12).map(|_| (direction + random.direction() * step).normalize()).find_map(|near| {
                let along = depth_along(a, b, &near);
                (along < least).then_some((along, near))
            });
            match better {
                Some(found) => (least, direction) = found,
                None => step *= 0.6,
            }
        }
        least
    };
    tried[..16].iter().map(descend).fold(f64::INFINITY, f64::min)
}

pub fn random_cone(random: &mut Random) -> Body {
    // Needles and coins too.
    let stretch = 3_f64.powf(random.random_range(-1.0..1.0));
    let cone = Collider::cone(random_size(random) / stretch, random_size(random) * stretch);
    body(&cone, Vector3::zeros(), random.rotation())
}

pub fn random_cylinder(random: &mut Random) -> Body {
    let stretch = 3_f64.powf(random.random_range(-1.0..1.0));
    let cylinder = Collider::cylinder(random_size(random) / stretch, random_size(random) * stretch);
    body(&cylinder, Vector3::zeros(), random.rotation())
}

const ROUND: [fn(&mut Random) -> Body; 2] = [random_cone, random_cylinder];

const PARTNERS: [fn(&mut Random) -> Body; 4] = [
    |random| {
        let cuboid = Collider::cuboid(random_size(random), random_size(random), random_size(random));
        body(&cuboid, Vector3::zeros(), random.rotation())
    },
    |random| hull_body(random_hull(random), Vector3::zeros(), random.rotation()),
    random_cone,
    random_cylinder,
];

/// Each round shape with each partner.
const KINDS: usize = ROUND.len() * PARTNERS.len();

fn for_each_random_pair(count: u32, mut check: impl FnMut(&Body, &Body, usize, &mut Random)) {
    let mut random = Random::new(41);
    for kind in 0..KINDS {
        let (own, partner) = (ROUND[kind / PARTNERS.len()], PARTNERS[kind % PARTNERS.len()]);
        for trial in 0..count {
            let (round, other) = (own(&mut random), partner(&mut random));
            let apart = random.direction() * (round.radius + other.radius) * random.random_range(0.0..0.9);
            let [a, b] = if trial % 2 == 0 { [round, other] } else { [other, round] };
            check(&a, &Body { position: apart, ..b }, kind, &mut random);
        }
    }
}

/// The depths along the normals of flat faces; those of a cone are its base's, of a cylinder its ends'.
fn least_along_faces(a: &Body, b: &Body) -> f64 {
    let normals = |body: &Body| match body.geometry {
        Some(Geometry::Cone { .. }) => vec![body.rotation * -Vector3::y()],
        Some(Geometry::Cylinder { .. }) => [1.0, -1.0].map(|end| body.rotation * Vector3::y() * end).to_vec(),
        _ => Features::of(body).normals,
    };
    let along = |normal: Vector3<f64>| depth_along(a, b, &normal);
    normals(a).into_iter().chain(normals(b).into_iter().map(|normal| -normal)).map(along).fold(f64::INFINITY, f64::min)
}

#[test]
fn depth_is_the_least_over_all_directions() {
    let (mut touching, mut apart, mut smooth, mut missed) = ([0; KINDS], [0; KINDS], [0; KINDS], 0);
    for_each_random_pair(600, |a, b, kind, random| {
        let searched = least_by_search(a, b, random);
        let size = a.radius.min(b.radius);
        let Some((found, points)) = touch(a, b, &clipping()) else {
            apart[kind] += 1;
            assert!(searched < 1e-3 * size, "{kind}: called apart, but every direction overlaps by {searched}");
            return;
        };
        touching[kind] += 1;
        assert!(!points.is_empty() && points.len() <= 4);
        assert!((found.normal.norm() - 1.0).abs() < 1e-12);
        let along = depth_along(a, b, &found.normal);
        assert!((along - found.depth).abs() < 1e-9, "{kind}: depth {} is not that of the normal, {along}", found.depth);
        assert!(searched > -1e-8, "{kind}: called touching {} deep, but {searched} apart", found.depth);
        // Faces are preferred to what is less deep by little, and bases to others.
        let faces = least_along_faces(a, b);
        let is_face = found.depth > faces - 1e-9;
        let allowed = if is_face { (searched + 1e-4 * size) / (0.95 * 0.95) + 1e-4 * size } else { searched + 1e-8 };
        assert!(found.depth <= allowed, "{kind}: depth {}, a direction found gives {searched}", found.depth);
        smooth[kind] += u32::from(!is_face);
        missed += u32::from(found.depth < searched - 1e-3 * size);
    });
    assert!(
        touching.iter().chain(&smooth).chain(&apart).all(|&count| count >= 50),
        "touching {touching:?}, across smooth surfaces {smooth:?}, apart {apart:?}"
    );
    assert!(missed * 50 < touching.iter().sum(), "{missed} of {touching:?} are less than any direction found gives");
}

/// How far a point lies outside of a body; negative inside.
pub fn outside(body: &Body, point: &Vector3<f64>) -> f64 {
    let arm = point - body.position;
    if let Some((radius, height)) = cone_size(body) {
        let local = body.rotation.inverse() * arm;
        let slant = radius.hypot(height);
        let over_flank = (height * local.xz().norm() + radius * (local.y - 0.75 * height)) / slant;
        return f64::max(over_flank, -local.y - 0.25 * height);
    }
    if let Some((radius, half)) = cylinder_size(body) {
        let local = body.rotation.inverse() * arm;
        return (local.xz().norm() - radius).max(local.y.abs() - half);
    }
    let features = Features::of(body);
    let top = |normal: &Vector3<f64>| reach(body, normal);
    features.normals.iter().map(|normal| normal.dot(&arm) - top(normal)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn points_lie_on_both_bodies() {
    let mut checked = [0; KINDS];
    for_each_random_pair(3000, |a, b, kind, _| {
        let Some((overlap, points)) = touch(a, b, &clipping()) else { return };
        let size = a.radius.min(b.radius);
        for point in &points {
            assert!((-1e-12..=overlap.depth + 1e-9).contains(&point.depth), "{} of {}", point.depth, overlap.depth);
            if overlap.depth < 0.05 * size {
                checked[kind] += 1;
                // The polygon that faces are clipped to lies on the rim.
                let apart = outside(a, &point.point).max(outside(b, &point.point));
                assert!(apart < 0.5 * point.depth + 1e-4 * size, "{kind}: {apart} m outside, depth {}", point.depth);
            }
        }
    });
    assert!(checked.iter().all(|&count| count > 50), "{checked:?}");
}

#[test]
fn swapping_the_bodies_turns_the_normal() {
    for_each_random_pair(500, |a, b, kind, _| {
        let (forward, backward) = (touch(a, b, &clipping()), touch(b, a, &clipping()));
        assert_eq!(forward.is_some(), backward.is_some(), "{kind}");
        if let (Some((forward, _)), Some((backward, _))) = (forward, backward) {
            // Of two round shapes an end of the first is preferred.
            let are_round = kind % PARTNERS.len() >= 2;
            let slack = 1e-9 + 0.11 * forward.depth * f64::from(u8::from(are_round));
            assert!((forward.depth - backward.depth).abs() < slack, "{kind}: {} {}", forward.depth, backward.depth);
            if forward.depth == backward.depth {
                assert_close(forward.normal, -backward.normal, 1e-6);
            }
        }
    });
}

/// Points of a cone's surface, about a hundred thousand.
fn surface(radius: f64, height: f64) -> impl Iterator<Item = Vector3<f64>> {
    let turn = |step: i32| (TAU * f64::from(step) / 720.0).sin_cos();
    let ring = move |y: f64, radius: f64| {
        (0..720).map(move |step| Vector3::new(turn(step).0 * radius, y, turn(step).1 * radius))
    };
    let base = (0..70).flat_map(move |step| ring(-0.25 * height, radius * f64::from(step) / 70.0));
    let flank = (0..=70).flat_map(move |step| {
        let share = f64::from(step) / 70.0;
        ring(0.75 * height - height * share, radius * share)
    });
    base.chain(flank)
}

#[test]
fn ball_meets_the_nearest_point_of_the_cone() {
    let mut random = Random::new(42);
    let (mut outside_count, mut inside_count) = (0, 0);
    for _ in 0..150 {
        let cone = random_cone(&mut random);
        let (radius, height) = cone_size(&cone).unwrap();
        let ball_radius = random_size(&mut random);
        let at = random.direction() * cone.radius * random.random_range(0.0..1.3);
        let ball = body(&Collider::sphere(ball_radius), at, random.rotation());
        let local = cone.rotation.inverse() * at;
        let nearest = surface(radius, height).map(|point| (point - local).norm()).fold(f64::INFINITY, f64::min);
        let is_inside = outside(&cone, &at) < 0.0;
        let expected = if is_inside { ball_radius + nearest } else { ball_radius - nearest };
        // Samples lie up to 1.3 % of the size apart; nearer than that, distances are off by as much.
        let spacing = 0.013 * cone.radius;
        let slack = if nearest > 3.0 * spacing { spacing * spacing / nearest } else { spacing };
        match touch(&cone, &ball, &clipping()) {
            None => assert!(expected < slack),
            Some((overlap, points)) => {
                assert!((overlap.depth - expected).abs() < slack, "{} is not {expected}", overlap.depth);
                assert_eq!(points.len(), 1);
                let surface = points[0].point + overlap.normal * (overlap.depth / 2.0);
                assert!(outside(&cone, &surface).abs() < 1e-9, "the point is not on the cone");
                outside_count += u32::from(!is_inside);
                inside_count += u32::from(is_inside);
            }
        }
    }
    assert!(outside_count > 20 && inside_count > 20, "{outside_count} {inside_count}");
}

#[test]
fn lowest_point_over_a_plane_is_exact_however_it_is_turned() {
    let ground = upright(&Collider::half_space(), [0.0; 3]);
    let mut random = Random::new(43);
    for _ in 0..2000 {
        let cone = random_cone(&mut random);
        let lowest = -reach(&cone, &-Vector3::y());
        let depth = random.random_range(0.0..0.01);
        let cone = Body { position: Vector3::y() * (-lowest - depth), ..cone };
        let (overlap, points) = touch(&ground, &cone, &clipping()).expect("touch");
        assert!((overlap.depth - depth).abs() < 1e-12, "{} is not {depth}", overlap.depth);
        assert!((deepest(&points) - depth).abs() < 1e-12);
    }
}

fn on_plane(cone: &Collider, tilt: UnitQuaternion<f64>, depth: f64) -> Vec<Vector3<f64>> {
    let ground = upright(&Collider::half_space(), [0.0; 3]);
    let cone = body(cone, Vector3::zeros(), tilt);
    let height = reach(&cone, &-Vector3::y());
    let cone = Body { position: Vector3::y() * (height - depth), ..cone };
    let (_, points) = touch(&ground, &cone, &clipping()).expect("touch");
    points.iter().map(|point| point.point).collect()
}

#[test]
fn cone_stands_on_four_points_lies_on_two_and_rolls_on_one() {
    let cone = Collider::cone(0.3, 0.4);
    let about_x = |angle: f64| UnitQuaternion::from_scaled_axis(Vector3::x() * angle);
    let flat = on_plane(&cone, about_x(0.0), 1e-4);
    assert_eq!(flat.len(), 4);
    let area = (flat[2] - flat[0]).cross(&(flat[3] - flat[1])).norm() / 2.0;
    assert!((area - 2.0 * 0.3 * 0.3).abs() < 1e-9, "not a square in the rim: {area}");
    // On its side: ends of a generator line, 0.5 long.
    let lying = on_plane(&cone, about_x(std::f64::consts::FRAC_PI_2 + f64::atan2(0.3, 0.4)), 1e-4);
    assert_eq!(lying.len(), 2);
    assert!(((lying[1] - lying[0]).norm() - 0.5).abs() < 1e-9);
    for angle in [0.05, 0.5, 1.5] {
        assert_eq!(on_plane(&cone, about_x(angle), 1e-4).len(), 1, "on its rim, tilted by {angle}");
    }
    assert_eq!(on_plane(&cone, about_x(std::f64::consts::PI), 1e-4).len(), 1, "on its apex");
}

#[test]
fn rolling_on_the_rim_moves_the_point_evenly() {
    // Spun about its own axis at one tilt, a cone touches the ground below the same place.
    let cone = Collider::cone(0.3, 0.4);
    let first = on_plane(&cone, UnitQuaternion::from_scaled_axis(Vector3::x() * 0.4), 1e-3)[0];
    for step in 0..100 {
        let spin = UnitQuaternion::from_scaled_axis(Vector3::y() * (0.063 * f64::from(step)));
        let points = on_plane(&cone, UnitQuaternion::from_scaled_axis(Vector3::x() * 0.4) * spin, 1e-3);
        assert_close(points[0], first, 1e-12);
    }
}

#[test]
fn standing_cone_keeps_its_points_while_it_trembles() {
    let cone = Collider::cone(0.5, 1.0);
    let slab = Collider::cuboid(3.0, 1.0, 3.0);
    let mut random = Random::new(44);
    for base in [upright(&Collider::half_space(), [0.0, 0.5, 0.0]), upright(&slab, [0.0; 3])] {
        let features = |tilt: Vector3<f64>| {
            let standing = body(&cone, Vector3::y() * (0.75 - 1e-3), UnitQuaternion::from_scaled_axis(tilt));
            let (_, points) = touch(&base, &standing, &clipping()).expect("touch");
            assert_eq!(points.len(), 4);
            points.iter().map(|point| point.feature).collect::<Vec<_>>()
        };
        let first = features(Vector3::zeros());
        for _ in 0..50 {
            assert_eq!(features(random.vector() * 1e-6), first);
        }
    }
}

#[test]
fn cones_side_by_side_touch_along_a_line() {
    // Both on their sides, flank to flank, apices the same way: generators are parallel.
    let cone = Collider::cone(0.3, 0.4);
    let half_angle = f64::atan2(0.3, 0.4);
    let side = |way: f64| UnitQuaternion::from_scaled_axis(Vector3::z() * (way * half_angle));
    // Upright, leaning away from each other so that the flanks between them are vertical.
    let (left, right) = (body(&cone, Vector3::zeros(), side(-1.0)), body(&cone, Vector3::zeros(), side(1.0)));
    let reach_between = reach(&left, &Vector3::x()) + reach(&right, &-Vector3::x());
    let right = Body { position: Vector3::x() * (reach_between - 1e-3), ..right };
    let (overlap, points) = touch(&left, &right, &clipping()).expect("touch");
    assert_close(overlap.normal, Vector3::x(), 1e-6);
    assert_eq!(points.len(), 2);
    assert!((points[1].point - points[0].point).norm() > 0.49, "{points:?}");
    assert_ne!(points[0].feature, points[1].feature);
}
