//! The closed forms for cones against the search over all their normals.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use super::revolved::Revolved;
use super::{Cone, Convex, Cuboid, Frame, Polyhedron, Scale, ShapePair};
use crate::physics::testing::Random;

/// A cone, and the radius of the ball that holds it.
fn sized(size: f64, aspect: f64) -> (Cone, f64) {
    let (radius, height) = if aspect < 1.0 { (size, size * aspect) } else { (size / aspect, size) };
    (Cone::new(radius, height), f64::max(0.75 * height, radius.hypot(0.25 * height)))
}

fn random_cone(random: &mut Random) -> (Cone, f64) {
    let size = 10_f64.powf(random.within(-2.0, 1.0));
    sized(size, 20_f64.powf(random.within(-1.0, 1.0)))
}

/// How two cones lie to each other.
const POSES: [fn(&Cone, &Cone, &mut Random) -> Frame; 9] = [
    // Anyhow.
    |a, b, random| {
        let rotation = random.rotation();
        let direction = random.direction();
        beside(a, b, rotation, direction, random)
    },
    // Axes parallel, or nearly.
    |a, b, random| {
        let direction = random.direction();
        beside(a, b, upright_or_not(random), direction, random)
    },
    // On one axis.
    |a, b, random| {
        let rotation = upright_or_not(random);
        beside(a, b, rotation, Vector3::y() * sign(random), random)
    },
    // Axes in one plane.
    |a, b, random| {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * random.within(-PI, PI));
        let direction = Vector3::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), 0.0).normalize();
        beside(a, b, rotation, direction, random)
    },
    // Axes at right angles.
    |a, b, random| {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::x() * (PI / 2.0));
        let direction = random.direction();
        beside(a, b, rotation, direction, random)
    },
    // Apex to apex.
    |a, b, random| meeting(a.apex_point(), b.apex_point(), random.rotation(), random),
    // Apex on base.
    |a, b, random| {
        let share = random.within(0.0, 1.0);
        let on_base = Vector3::new(share * a.radius, a.base, 0.0);
        meeting(on_base, b.apex_point(), random.rotation(), random)
    },
    // Rim on rim.
    |a, b, random| {
        let [on_a, on_b] = [a, b].map(|cone| {
            let (sin, cos) = random.within(-PI, PI).sin_cos();
            cone.rim_point([cos, sin])
        });
        meeting(on_a, on_b, random.rotation(), random)
    },
    // Generator on generator.
    |a, b, random| {
        let (share, other_share) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
        let on = |cone: &Cone, share: f64| cone.apex_point().lerp(&cone.rim_point([1.0, 0.0]), share);
        let mirrored = UnitQuaternion::from_scaled_axis(Vector3::y() * PI);
        let turn = f64::atan2(a.cosine, a.sine) + f64::atan2(b.cosine, b.sine) - PI;
        let lean = UnitQuaternion::from_scaled_axis(Vector3::z() * turn);
        let roll =
            UnitQuaternion::from_scaled_axis(a_normal(a) * random.within(-PI, PI) * f64::from(random.index(2) as u32));
        meeting(on(a, share), on(b, other_share), roll * lean * mirrored, random)
    },
];

fn a_normal(a: &Cone) -> Vector3<f64> {
    a.flank_normal([1.0, 0.0])
}

fn sign(random: &mut Random) -> f64 {
    if random.index(2) == 0 { 1.0 } else { -1.0 }
}

fn upright_or_not(random: &mut Random) -> UnitQuaternion<f64> {
    let turned = UnitQuaternion::from_scaled_axis(Vector3::x() * (PI * f64::from(random.index(2) as u32)));
    let tremble = [0.0, 1e-12, 1e-7, 1e-3][random.index(4)];
    UnitQuaternion::from_scaled_axis(random.vector() * tremble) * turned
}

/// Touching along a direction, apart, deep, or nearly touching.
fn beside(
    a: &Cone,
    b: &impl Convex,
    rotation: UnitQuaternion<f64>,
    direction: Vector3<f64>,
    random: &mut Random,
) -> Frame {
    let rotation = rotation.to_rotation_matrix().into_inner();
    let reach = a.reach(&direction) + b.reach(&-rotation.tr_mul(&direction));
    let share = match random.index(7) {
        0 => 1.0,
        1..4 => random.within(0.0, 0.9),
        4 => random.within(0.9, 1.0),
        5 => random.within(1.0, 1.2),
        _ => 1.0 + random.within(-1.0, 1.0) * 10_f64.powf(random.within(-9.0, -2.0)),
    };
    Frame { rotation, center: direction * (reach * share) }
}

/// A point of either at the same place, or nearly.
fn meeting(on_a: Vector3<f64>, on_b: Vector3<f64>, rotation: UnitQuaternion<f64>, random: &mut Random) -> Frame {
    let rotation = rotation.to_rotation_matrix().into_inner();
    let off = match random.index(3) {
        0 => 0.0,
        1 => 10_f64.powf(random.within(-9.0, -2.0)),
        _ => random.within(0.0, 0.2),
    };
    let size = on_a.norm().min(on_b.norm());
    Frame { rotation, center: on_a - rotation * on_b + random.direction() * (off * size) }
}

/// The least of all normals, by search: the bases', those across smooth surfaces and, of what is apart, at an apex.
fn least_by_search(pair: &ShapePair<Cone, Cone>) -> (Vector3<f64>, f64) {
    let mut best = pair.least_by_search();
    let mut take = |normal: Vector3<f64>| {
        let depth = pair.depth_along(&normal);
        if depth < best.1 {
            best = (normal, depth);
        }
    };
    take(Cone::base_normal());
    take(pair.out_of_a(Cone::base_normal()));
    take(pair.a.place(&pair.b_in_a.place(&pair.b.apex_point()), 1.0).normal);
    let apex = pair.b_in_a.inverse().place(&pair.a.apex_point());
    take(pair.out_of_a(pair.b.place(&apex, 1.0).normal));
    best
}

/// Pairs of which the search had to be asked, of which it found less, and of which it found more.
#[derive(Debug, Default)]
struct Tally {
    pairs: u32,
    searched: u32,
    axes: u64,
    overlapping: u32,
    missed_by_search: u32,
    turned: u32,
}

fn compare(pose: usize, count: u32, random: &mut Random) -> Tally {
    let mut tally = Tally::default();
    for _ in 0..count {
        let (a, radius_a) = random_cone(random);
        // Alike half the time, and not too different for features to meet otherwise.
        let (b, radius_b) = if random.index(2) == 0 { (a, radius_a) } else { random_cone(random) };
        let frame = POSES[pose](&a, &b, random);
        let scale = Scale::new(radius_a, radius_b, 1e3);
        let pair = ShapePair { a: &a, b: &b, b_in_a: &frame, scale: &scale };
        let (normal, depth, axes) = pair.least();
        let (search_normal, searched) = least_by_search(&pair);
        let slack = 1e-9 * (radius_a + radius_b);
        let what = || {
            format!(
                "pose {pose}, {a:?}, {b:?}, {frame:?}: {depth} along {normal:?}, search {searched} along {search_normal:?}"
            )
        };
        assert!((normal.norm() - 1.0).abs() < 1e-12, "{}", what());
        let along = pair.depth_along(&normal);
        assert!((along - depth).abs() < slack * 1e-3, "{along}: {}", what());
        assert!(depth <= searched + slack, "{}", what());
        tally.pairs += 1;
        tally.axes += u64::from(axes);
        tally.searched += u32::from(axes > 100);
        tally.overlapping += u32::from(depth > 0.0);
        tally.missed_by_search += u32::from(depth < searched - slack);
        tally.turned += u32::from(depth >= searched - slack && (normal - search_normal).norm() > 1e-4);
    }
    tally
}

fn compare_all(count: u32) {
    let mut random = Random::new(97);
    let mut all = Vec::new();
    for pose in 0..POSES.len() {
        let tally = compare(pose, count, &mut random);
        println!("{pose}: {tally:?}");
        all.push(tally);
    }
    let anyhow = &all[0];
    assert!(anyhow.searched * 4 < anyhow.pairs, "the closed forms prove too little: {anyhow:?}");
    assert!(anyhow.turned * 1000 <= anyhow.pairs, "{anyhow:?}");
    assert!(anyhow.overlapping * 4 > anyhow.pairs && anyhow.overlapping * 4 < 3 * anyhow.pairs, "{anyhow:?}");
    for tally in &all {
        assert!(tally.missed_by_search * 100 <= tally.pairs, "{tally:?}");
    }
}

#[test]
fn closed_forms_find_what_the_search_finds() {
    compare_all(100);
}

#[test]
#[ignore = "takes minutes"]
fn closed_forms_find_what_the_search_finds_for_many() {
    compare_all(20_000);
}

/// The least depth around a circle of normals, by samples and golden section between them.
fn least_around(circle: impl Fn(f64) -> Vector3<f64>, depth: impl Fn(&Vector3<f64>) -> f64) -> (Vector3<f64>, f64) {
    const SAMPLES: usize = 64;
    let at = |angle: f64| depth(&circle(angle));
    let step = TAU / SAMPLES as f64;
    let samples: Vec<f64> = (0..SAMPLES).map(|sample| at(step * sample as f64)).collect();
    let mut best = (Vector3::zeros(), f64::INFINITY);
    for sample in 0..SAMPLES {
        let neighbours = [samples[(sample + SAMPLES - 1) % SAMPLES], samples[(sample + 1) % SAMPLES]];
        if samples[sample] > neighbours[0] || samples[sample] > neighbours[1] {
            continue;
        }
        let [mut low, mut high] = [-1.0, 1.0].map(|way| step * (sample as f64 + way));
        while high - low > 1e-14 {
            let third = (high - low) / 3.0;
            if at(low + third) <= at(high - third) { high -= third } else { low += third }
        }
        if at(low) < best.1 {
            best = (circle(low), at(low));
        }
    }
    best
}

/// The least of all normals of a cone and a box, by search: across each edge, around the flank, along faces, and of
/// what is apart, at a vertex or the apex.
fn least_with_box_by_search(pair: &ShapePair<Cone, Cuboid>) -> (Vector3<f64>, f64) {
    let &ShapePair { a: cone, b: other, b_in_a, .. } = pair;
    let depth = |normal: &Vector3<f64>| pair.depth_along(normal);
    let flank = |angle: f64| cone.flank_normal([angle.cos(), angle.sin()]);
    let mut best = least_around(flank, depth);
    let mut take = |(normal, depth): (Vector3<f64>, f64)| {
        if depth < best.1 {
            best = (normal, depth);
        }
    };
    for edge in (0..other.edge_count()).map(|edge| other.edge(edge).placed(b_in_a, false)) {
        let [x, y] = crate::physics::contact::tangents(&edge.direction);
        take(least_around(|angle| x * angle.cos() + y * angle.sin(), depth));
        let apex = cone.apex_point();
        let nearest = edge.start + edge.direction * (apex - edge.start).dot(&edge.direction).clamp(0.0, edge.length);
        if let Some(normal) = (nearest - apex).try_normalize(1e-12) {
            take((normal, depth(&normal)));
        }
    }
    for face in 0..other.face_count() {
        let normal = pair.out_of_a(other.face(face).normal);
        take((normal, depth(&normal)));
    }
    for vertex in 0..other.vertex_count() {
        let normal = cone.place(&b_in_a.place(&other.vertex(vertex)), 1.0).normal;
        take((normal, depth(&normal)));
    }
    take((Cone::base_normal(), depth(&Cone::base_normal())));
    best
}

fn compare_with_boxes(count: u32) {
    let mut random = Random::new(98);
    let mut overlapping = 0;
    for trial in 0..count {
        let (a, radius_a) = random_cone(&mut random);
        let size = radius_a * 5_f64.powf(random.within(-1.0, 1.0));
        let b = Cuboid { half: Vector3::from_fn(|_, _| size * random.within(0.1, 1.0)) };
        let rotation = match trial % 4 {
            0 => upright_or_not(&mut random),
            1 => UnitQuaternion::from_scaled_axis(Vector3::z() * random.within(-PI, PI)),
            _ => random.rotation(),
        };
        let direction = random.direction();
        let mut frame = beside(&a, &b, rotation, direction, &mut random);
        if trial % 3 == 0 {
            // A corner, or a point of an edge, on the apex or the rim.
            let on_a = if random.index(2) == 0 { a.apex_point() } else { a.rim_point([1.0, 0.0]) };
            let corner = b.vertex(random.index(8));
            let on_b = if random.index(2) == 0 { corner } else { corner.component_mul(&Vector3::new(0.3, 1.0, 1.0)) };
            frame = meeting(on_a, on_b, rotation, &mut random);
        }
        let scale = Scale::new(radius_a, b.half.norm(), 1e3);
        let pair = ShapePair { a: &a, b: &b, b_in_a: &frame, scale: &scale };
        let (normal, depth) = pair.least();
        let (search_normal, searched) = least_with_box_by_search(&pair);
        let slack = 1e-9 * (radius_a + b.half.norm());
        let what = || {
            format!(
                "{trial}: {a:?}, {b:?}, {frame:?}: {depth} along {normal:?}, search {searched} along {search_normal:?}"
            )
        };
        assert!((depth - searched).abs() < 2.0 * slack, "{}", what());
        assert!((pair.depth_along(&normal) - depth).abs() < 2.0 * slack, "{}: {}", pair.depth_along(&normal), what());
        overlapping += u32::from(depth > 0.0);
    }
    assert!(overlapping * 4 > count && overlapping * 4 < 3 * count, "{overlapping}");
}

#[test]
fn closed_forms_with_boxes_find_what_the_search_finds() {
    compare_with_boxes(500);
}

#[test]
#[ignore = "takes minutes"]
fn closed_forms_with_boxes_find_what_the_search_finds_for_many() {
    compare_with_boxes(100_000);
}
