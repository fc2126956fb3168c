use std::f64::consts::{FRAC_PI_4, SQRT_2, TAU};

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;

use super::{assert_close, body, exact, random_pair, touch, upright};
use crate::physics::body::Body;
use crate::physics::collision::manifold::Overlap;
use crate::physics::settings::ContactModel;
use crate::physics::shape::{Collider, Geometry};
use crate::physics::testing::Random;

/// The extreme-vertex model takes the least depth as it is.
fn overlap(a: &Body, b: &Body) -> Option<Overlap> {
    touch(a, b, &exact(ContactModel::ExtremeVertices)).map(|(overlap, _)| overlap)
}

/// A body by its vertices alone, or its centre and radius.
struct Extent {
    position: Vector3<f64>,
    radius: f64,
    /// About the centre, world axes.
    vertices: Vec<Vector3<f64>>,
}

impl Extent {
    fn of(body: &Body) -> Self {
        let (radius, local): (f64, Vec<Vector3<f64>>) = match body.geometry.as_ref().unwrap() {
            Geometry::HalfSpace | Geometry::Parts(_) => unreachable!(),
            Geometry::Sphere { radius } => (*radius, vec![Vector3::zeros()]),
            Geometry::Cuboid { half } => {
                let corner = |index: u32| {
                    Vector3::from_fn(|axis, _| if index >> axis & 1 == 0 { half[axis] } else { -half[axis] })
                };
                (0.0, (0..8).map(corner).collect())
            }
            curved_or_hull => (0.0, curved_or_hull.polyhedron().expect("it has vertices").vertices.clone()),
        };
        let vertices = local.iter().map(|vertex| body.rotation * vertex).collect();
        Self { position: body.position, radius, vertices }
    }

    /// How far it reaches along a direction, from its centre.
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.vertices.iter().map(|vertex| vertex.dot(direction)).fold(f64::NEG_INFINITY, f64::max) + self.radius
    }
}

/// How far B must move along a direction to be clear of A.
fn overlap_along(a: &Extent, b: &Extent, direction: &Vector3<f64>) -> f64 {
    a.reach(direction) + b.reach(&-direction) - (b.position - a.position).dot(direction)
}

/// The least overlap over all directions: the best of many, then of smaller and smaller steps
/// from the best of these. Never less than the truth, nearly always within 1e-4.
fn least_by_search(a: &Body, b: &Body, random: &mut Random) -> f64 {
    let (a, b) = (&Extent::of(a), &Extent::of(b));
    let mut tried: Vec<_> = (0..300)
        .map(|_| {
            let direction = random.direction();
            (overlap_along(a, b, &direction), direction)
        })
        .collect();
    tried.sort_by(|one, other| one.0.total_cmp(&other.0));
    let descend = |&(mut least, mut direction): &(f64, Vector3<f64>)| {
        let mut step = 0.2;
        while step > 1e-5 {
            let better = (0..16).map(|_| (direction + random.direction() * step).normalize()).find_map(|near| {
                let along = overlap_along(a, b, &near);
                (along < least).then_some((along, near))
            });
            match better {
                Some(found) => (least, direction) = found,
                None => step *= 0.7,
            }
        }
        least
    };
    tried[..12].iter().map(descend).fold(f64::INFINITY, f64::min)
}

/// Axes of all faces and edges, from what each shape is, with none left out.
fn face_normals_and_edges(body: &Body) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let turned = |local: Vec<Vector3<f64>>| local.iter().map(|vector| body.rotation * vector).collect::<Vec<_>>();
    match body.geometry.as_ref().unwrap() {
        Geometry::Cuboid { .. } => {
            let axes = turned(vec![Vector3::x(), Vector3::y(), Vector3::z()]);
            (axes.clone(), axes)
        }
        Geometry::Cone { .. } => {
            // A cone: 24 base vertices, then the apex.
            let corners = Extent::of(body).vertices;
            let (base, apex) = (&corners[..24], corners[24]);
            let sides = || base.iter().zip(base.iter().cycle().skip(1));
            let edges = sides().map(|(from, to)| to - from).chain(base.iter().map(|from| apex - from)).collect();
            let flanks = sides().map(|(from, to)| (to - from).cross(&(apex - from)));
            (flanks.chain([body.rotation * Vector3::y()]).map(|normal| normal.normalize()).collect(), edges)
        }
        _ => unreachable!(),
    }
}

fn least_of_all_axes(a: &Body, b: &Body) -> f64 {
    let ((faces_a, edges_a), (faces_b, edges_b)) = (face_normals_and_edges(a), face_normals_and_edges(b));
    let crosses = edges_a.iter().flat_map(|one| edges_b.iter().map(|other| one.cross(other)));
    let (a, b) = (&Extent::of(a), &Extent::of(b));
    faces_a
        .iter()
        .chain(&faces_b)
        .copied()
        .chain(crosses.filter(|cross| cross.norm() > 1e-9).map(|cross| cross.normalize()))
        .flat_map(|axis| [axis, -axis])
        .map(|axis| overlap_along(a, b, &axis))
        .fold(f64::INFINITY, f64::min)
}

fn for_each_random_pair(count: u32, mut check: impl FnMut(&Body, &Body, [usize; 2], &mut Random)) {
    let mut random = Random::new(7);
    for one in 0..3 {
        for other in 0..3 {
            for _ in 0..count {
                let [a, b] = random_pair(&mut random, [one, other]);
                check(&a, &b, [one, other], &mut random);
            }
        }
    }
}

#[test]
fn depth_is_the_least_over_all_directions() {
    let (mut touching, mut apart, mut missed) = ([0; 9], [0; 9], 0);
    for_each_random_pair(80, |a, b, kinds, random| {
        let searched = least_by_search(a, b, random);
        let index = 3 * kinds[0] + kinds[1];
        if let Some(Overlap { normal, depth, .. }) = overlap(a, b) {
            touching[index] += 1;
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            assert!(
                (overlap_along(&Extent::of(a), &Extent::of(b), &normal) - depth).abs() < 1e-9,
                "{kinds:?}: depth is not that of the normal"
            );
            assert!(depth <= searched + 1e-9, "{kinds:?}: depth {depth}, a direction found gives {searched}");
            // The search can miss a narrow valley, so not all need to match.
            missed += u32::from(depth < searched - 1e-3);
        } else {
            apart[index] += 1;
            assert!(searched < 1e-3, "{kinds:?}: called apart, but every direction overlaps by {searched}");
        }
    });
    assert!(touching.iter().chain(&apart).all(|&count| count >= 5), "touching {touching:?}, apart {apart:?}");
    assert!(missed * 50 < touching.iter().sum(), "{missed} of {touching:?} are less than any direction found gives");
}

#[test]
fn depth_of_polyhedra_is_the_least_over_all_their_axes() {
    for_each_random_pair(60, |a, b, kinds, _| {
        if kinds.contains(&0) {
            return;
        }
        let least = least_of_all_axes(a, b);
        match overlap(a, b) {
            Some(Overlap { depth, .. }) => assert!((depth - least).abs() < 1e-9, "{kinds:?}: {depth} against {least}"),
            None => assert!(least < 0.0, "{kinds:?}: called apart at {least}"),
        }
    });
}

#[test]
fn swapping_the_bodies_turns_the_normal_and_keeps_the_depth() {
    for_each_random_pair(300, |a, b, kinds, _| {
        let (forward, backward) = (overlap(a, b), overlap(b, a));
        assert_eq!(forward.is_some(), backward.is_some(), "{kinds:?}");
        if let (Some(forward), Some(backward)) = (forward, backward) {
            assert!((forward.depth - backward.depth).abs() < 1e-12, "{kinds:?}");
            assert_close(forward.normal, -backward.normal, 1e-9);
        }
    });
}

#[test]
fn merging_opposite_axes_changes_nothing_at_epsilon_zero() {
    let mut merging = exact(ContactModel::ExtremeVertices);
    merging.sweeps.merge_opposite_axes = true;
    for_each_random_pair(100, |a, b, kinds, _| {
        let (all, merged) = (overlap(a, b), touch(a, b, &merging).map(|(overlap, _)| overlap));
        assert_eq!(all.is_some(), merged.is_some(), "{kinds:?}");
        if let (Some(all), Some(merged)) = (all, merged) {
            assert!((all.depth - merged.depth).abs() < 1e-12, "{kinds:?}");
        }
    });
}

#[test]
fn reducing_the_axes_loses_no_contact_and_little_depth() {
    // Between unit vectors within L1 distance ε of each other the overlap of shapes of radius R
    // differs by at most 2 R ε; dropped ones are within ε of a kept one.
    let epsilon = 1e-3;
    let mut reduced = exact(ContactModel::ExtremeVertices);
    reduced.sweeps.axis_epsilon = epsilon;
    for_each_random_pair(300, |a, b, kinds, _| {
        let (all, few) = (overlap(a, b), touch(a, b, &reduced).map(|(overlap, _)| overlap));
        let allowed = 2.0 * (a.radius + b.radius) * epsilon;
        match (all, few) {
            (Some(all), Some(few)) => {
                assert!(few.depth >= all.depth - 1e-12 && few.depth <= all.depth + allowed, "{kinds:?}");
            }
            (Some(_), None) => panic!("{kinds:?}: lost"),
            (None, Some(few)) => assert!(few.depth <= allowed, "{kinds:?}: a contact {} deep made up", few.depth),
            (None, None) => {}
        }
    });
}

/// The table of `docs/the_2009_engine.md`, *Fewer axes*: of 500 random pairs of boxes and as many of cones none is lost,
/// so many are made up, and the depth exceeds the least by so many millimetres at most.
#[test]
fn large_epsilons_lose_nothing_and_make_up_a_little() {
    let shapes = [Collider::cuboid(1.0, 0.5, 0.3), Collider::cone(0.4, 1.0)];
    let mut random = Random::new(2009);
    let pairs = shapes.map(|shape| -> Vec<[Body; 2]> {
        let pair = |_| {
            let a = body(&shape, Vector3::zeros(), random.rotation());
            let apart = random.direction() * random.random_range(0.2..0.9);
            [a, body(&shape, apart, random.rotation())]
        };
        (0..500).map(pair).collect()
    });
    let counted = |epsilon: f64, pairs: &[[Body; 2]]| {
        let mut reduced = exact(ContactModel::ExtremeVertices);
        reduced.sweeps.axis_epsilon = epsilon;
        let (mut made_up, mut too_deep) = (0, 0.0_f64);
        for [a, b] in pairs {
            match (overlap(a, b), touch(a, b, &reduced)) {
                (Some(all), Some((few, _))) => too_deep = too_deep.max(few.depth - all.depth),
                (Some(_), None) => panic!("lost at {epsilon}"),
                (None, few) => made_up += u32::from(few.is_some()),
            }
        }
        (made_up, (1e3 * too_deep).round())
    };
    let apart = |pairs: &[[Body; 2]]| pairs.iter().filter(|[a, b]| overlap(a, b).is_none()).count();
    assert_eq!([&pairs[0], &pairs[1]].map(|pairs| apart(pairs)), [118, 127]);
    for (epsilon, boxes, cones) in [
        (0.001, (0, 0.0), (0, 0.0)),
        (0.01, (0, 2.0), (0, 4.0)),
        (0.1, (0, 36.0), (1, 33.0)),
        (0.2, (1, 59.0), (2, 38.0)),
        (0.3, (5, 104.0), (2, 56.0)),
        (0.5, (14, 158.0), (12, 98.0)),
    ] {
        assert_eq!([counted(epsilon, &pairs[0]), counted(epsilon, &pairs[1])], [boxes, cones], "{epsilon}");
    }
}

#[test]
fn half_space_depth_is_that_of_the_lowest_point() {
    let mut random = Random::new(8);
    let mut touching = 0;
    for trial in 0..900 {
        let plane = body(&Collider::half_space(), Vector3::new(1.0, 2.0, 3.0), random.rotation());
        let normal = plane.rotation * Vector3::y();
        let [_, mut other] = random_pair(&mut random, [0, trial % 3]);
        other.position = plane.position + random.direction() * random.random_range(0.0..2.0);
        let depth = Extent::of(&other).reach(&-normal) - (other.position - plane.position).dot(&normal);
        let found = overlap(&plane, &other);
        assert_eq!(found.is_some(), depth >= 0.0);
        if let Some(found) = found {
            touching += 1;
            assert!((found.depth - depth).abs() < 1e-12);
            assert_eq!(found.normal, plane.rotation.to_rotation_matrix() * Vector3::y());
            let turned = overlap(&other, &plane).expect("touches both ways");
            assert_eq!((turned.normal, turned.depth), (-found.normal, found.depth));
        }
    }
    assert!(touching > 300);
}

#[test]
fn known_depths() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let ball = Collider::sphere(0.5);
    let check = |a: &Body, b: &Body, normal: Vector3<f64>, depth: f64| {
        let found = overlap(a, b).expect("touch");
        assert_close(found.normal, normal, 1e-12);
        assert!((found.depth - depth).abs() < 1e-12, "{} is not {depth}", found.depth);
    };
    let origin = upright(&cube, [0.0; 3]);
    check(&origin, &upright(&cube, [0.1, 0.9, 0.2]), Vector3::y(), 0.1);
    // A ball beside, before an edge, before a corner of the cube, and with its centre inside.
    check(&origin, &upright(&ball, [0.9, 0.1, 0.0]), Vector3::x(), 0.1);
    let edge = Vector3::new(1.0, 1.0, 0.0) / SQRT_2;
    check(&origin, &upright(&ball, [0.7, 0.7, 0.3]), edge, 0.5 - 0.2 * SQRT_2);
    let corner = Vector3::repeat(1.0 / 3f64.sqrt());
    check(
        &origin,
        &upright(&ball, [-0.6, 0.6, 0.6]),
        corner.component_mul(&Vector3::new(-1.0, 1.0, 1.0)),
        0.5 - 0.1 * 3f64.sqrt(),
    );
    check(&origin, &upright(&ball, [0.1, -0.3, 0.2]), -Vector3::y(), 0.7);
    // Balls.
    check(&upright(&ball, [0.0; 3]), &upright(&ball, [0.0, 0.0, 0.6]), Vector3::z(), 0.4);
    check(&upright(&ball, [0.0; 3]), &upright(&ball, [0.0; 3]), Vector3::y(), 1.0);
    // A cube that stands on an edge, on a cube whose top edge runs across: edge on edge.
    let lower = body(&cube, Vector3::zeros(), UnitQuaternion::from_scaled_axis(Vector3::z() * FRAC_PI_4));
    let upper = UnitQuaternion::from_scaled_axis(Vector3::x() * FRAC_PI_4);
    check(&lower, &body(&cube, Vector3::new(0.1, SQRT_2 - 0.02, -0.1), upper), Vector3::y(), 0.02);
    // A cone's apex in a cube: 3/4 of its height above its centre.
    let cone = Collider::cone(0.4, 0.8);
    check(&upright(&cone, [0.2, -1.05, 0.0]), &origin, Vector3::y(), 0.05);
    // Its base on the cube, and the rim of its base in a wall.
    check(&origin, &upright(&cone, [0.2, 0.69, 0.0]), Vector3::y(), 0.01);
    let wall =
        body(&Collider::half_space(), Vector3::zeros(), UnitQuaternion::from_scaled_axis(Vector3::z() * -TAU / 4.0));
    check(&wall, &upright(&cone, [0.38, 0.0, 0.0]), Vector3::x(), 0.02);
}

#[test]
fn touching_is_a_contact_and_a_gap_is_not() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let plane = upright(&Collider::half_space(), [0.0; 3]);
    // 0.1 + 0.2 style sums: gaps of a few 1e-16 above zero must count as zero.
    for height in [0.5, 0.5 + 1e-15, 0.5 - 1e-15] {
        assert_eq!(overlap(&plane, &upright(&cube, [0.0, height, 0.0])).map(|found| found.depth < 1e-12), Some(true));
    }
    for height in [1.0, 1.0 + 1e-14, 3.0 * 0.1 + 0.7] {
        let found = overlap(&upright(&cube, [0.3, 0.0, 0.1]), &upright(&cube, [0.0, height, 0.0])).expect("touch");
        assert_close(found.normal, Vector3::y(), 1e-15);
    }
    assert!(overlap(&upright(&cube, [0.0; 3]), &upright(&cube, [0.0, 1.0 + 1e-6, 0.0])).is_none());
    assert!(overlap(&plane, &upright(&cube, [0.0, 0.5 + 1e-6, 0.0])).is_none());
    let ball = Collider::sphere(0.1);
    assert!(overlap(&upright(&ball, [0.1, 0.0, 0.0]), &upright(&ball, [0.3, 0.0, 0.0])).is_some());
    assert!(overlap(&upright(&ball, [0.1, 0.0, 0.0]), &upright(&ball, [0.3 + 1e-6, 0.0, 0.0])).is_none());
}

#[test]
fn result_does_not_depend_on_the_distance_from_the_origin() {
    // A power of two, so that positions are exact there.
    let far = Vector3::new(2f64.powi(23), -2f64.powi(24), 2f64.powi(22));
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let place = |at: Vector3<f64>| {
        overlap(
            &body(&cube, at, UnitQuaternion::identity()),
            &body(&cube, at + Vector3::new(0.25, 0.875, 0.5), UnitQuaternion::identity()),
        )
        .map(|found| (found.normal, found.depth))
    };
    assert_eq!(place(Vector3::zeros()), place(far));
    assert_eq!(place(far), Some((Vector3::y(), 0.125)));
}
