use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{UnitQuaternion, Vector3};

use super::hulls::{hull_body, random_hull};
use super::{assert_close, body, deepest, exact, random_pair, touch, upright};
use crate::physics::body::Body;
use crate::physics::collision::manifold::{ContactPoint, PartPair};
use crate::physics::collision::narrow::contact_pair::{self, PairSearch};
use crate::physics::settings::{ContactModel, SolverSettings};
use crate::physics::shape::{Collider, Geometry, TriangleMesh};
use crate::physics::testing::Random;

fn unit_cube() -> Collider {
    Collider::cuboid(1.0, 1.0, 1.0)
}

fn clipped(a: &Body, b: &Body) -> Vec<ContactPoint> {
    touch(a, b, &exact(ContactModel::Clipping)).expect("touch").1
}

fn extreme(a: &Body, b: &Body) -> Vec<ContactPoint> {
    touch(a, b, &exact(ContactModel::ExtremeVertices)).expect("touch").1
}

/// Points without their order, rounded to 1e-4 m.
fn rounded(points: &[ContactPoint]) -> BTreeSet<[i64; 3]> {
    points.iter().map(|point| std::array::from_fn(|axis| (point.point[axis] * 1e4).round() as i64)).collect()
}

fn rounded_positions(points: &[[f64; 3]]) -> BTreeSet<[i64; 3]> {
    points.iter().map(|point| point.map(|along| (along * 1e4).round() as i64)).collect()
}

fn features(points: &[ContactPoint]) -> BTreeSet<u64> {
    points.iter().map(|point| point.feature.0).collect()
}

/// Area of the convex polygon of four points in order.
fn area(points: &[ContactPoint]) -> f64 {
    let at = |index: usize| points[index % points.len()].point - points[0].point;
    (0..points.len()).map(|index| at(index).cross(&at(index + 1))).sum::<Vector3<f64>>().norm() / 2.0
}

/// How far a point lies outside a body; negative inside.
fn outside(body: &Body, point: &Vector3<f64>) -> f64 {
    let local = body.rotation.inverse() * (point - body.position);
    match body.geometry.as_ref().unwrap() {
        Geometry::HalfSpace => local.y,
        Geometry::Sphere { radius } => local.norm() - radius,
        Geometry::Cuboid { half } => (local.abs() - half).max(),
        Geometry::Capsule { radius, half, .. } => (local - Vector3::y() * local.y.clamp(-half, *half)).norm() - radius,
        Geometry::Cylinder { radius, half, .. } => (local.xz().norm() - radius).max(local.y.abs() - half),
        Geometry::Cone { radius, height, .. } => {
            let over_flank = (height * local.xz().norm() + radius * (local.y - 0.75 * height)) / radius.hypot(*height);
            over_flank.max(-local.y - 0.25 * height)
        }
        Geometry::Hull(hull) => {
            hull.faces.iter().map(|face| face.normal.dot(&local) - face.offset).fold(f64::NEG_INFINITY, f64::max)
        }
        Geometry::Parts(_) => unreachable!(),
    }
}

#[test]
fn aligned_boxes_touch_in_four_corners_half_way_between_the_faces() {
    let points = clipped(&upright(&unit_cube(), [0.0; 3]), &upright(&unit_cube(), [0.0, 0.98, 0.0]));
    let corners = [[0.5, 0.49, 0.5], [-0.5, 0.49, 0.5], [-0.5, 0.49, -0.5], [0.5, 0.49, -0.5]];
    assert_eq!(rounded(&points), rounded_positions(&corners));
    assert!(points.iter().all(|point| (point.depth - 0.02).abs() < 1e-12));
    assert_eq!(features(&points).len(), 4);
}

#[test]
fn overhang_is_cut_off() {
    let points = clipped(&upright(&unit_cube(), [0.0; 3]), &upright(&unit_cube(), [0.4, 1.0, 0.0]));
    let corners = [[0.5, 0.5, 0.5], [-0.1, 0.5, 0.5], [-0.1, 0.5, -0.5], [0.5, 0.5, -0.5]];
    assert_eq!(rounded(&points), rounded_positions(&corners));
    assert!(points.iter().all(|point| point.depth < 1e-12), "they only touch");
}

#[test]
fn corners_cut_off_get_names_of_their_own() {
    let below = upright(&unit_cube(), [0.0; 3]);
    let [aligned, shifted] = [0.0, 0.4].map(|x| features(&clipped(&below, &upright(&unit_cube(), [x, 0.98, 0.0]))));
    assert_eq!(aligned.intersection(&shifted).count(), 2, "of {aligned:x?} and {shifted:x?}");
}

#[test]
fn each_point_of_a_tilted_box_has_its_own_depth() {
    let tilt = 0.1_f64;
    let slab = Collider::cuboid(3.0, 1.0, 3.0);
    let upper = body(&unit_cube(), Vector3::new(0.0, 1.0, 0.0), UnitQuaternion::from_scaled_axis(Vector3::z() * tilt));
    let points = clipped(&upright(&slab, [0.0; 3]), &upper);
    // The corners are 1/2 below and 1/2 beside the centre: sin and cos of the tilt, halved.
    let low = 0.5 * (tilt.cos() + tilt.sin()) - 0.5;
    assert_eq!(points.len(), 2, "the other two corners are above the slab: {points:?}");
    for point in points {
        assert!((point.depth - low).abs() < 1e-12);
        assert!((point.point.x + 0.5 * (tilt.cos() - tilt.sin())).abs() < 1e-9);
        assert!((point.point.y - (0.5 - low / 2.0)).abs() < 1e-12, "half-way between the surfaces");
    }
}

#[test]
fn four_of_an_octagon_keep_its_square() {
    let turned = UnitQuaternion::from_scaled_axis(Vector3::y() * FRAC_PI_4);
    let points = clipped(&upright(&unit_cube(), [0.0; 3]), &body(&unit_cube(), Vector3::new(0.0, 0.99, 0.0), turned));
    assert_eq!(points.len(), 4);
    // A regular octagon of inradius 1/2: four of its corners, a quarter turn apart, span 2 ρ².
    let circumradius_squared = 0.25 / (FRAC_PI_4 / 2.0).cos().powi(2);
    assert!((area(&points) / (2.0 * circumradius_squared) - 1.0).abs() < 1e-3, "area {}", area(&points));
}

#[test]
fn reduction_keeps_the_deepest_point() {
    let mut random = Random::new(3);
    let mut reduced = 0;
    for _ in 0..2000 {
        // A cone standing on its base, nearly upright, in a slab.
        let cone = Collider::cone(0.7, 1.0);
        let tilt = UnitQuaternion::from_scaled_axis(random.vector() * 0.1);
        let ground = upright(&Collider::cuboid(4.0, 2.0, 4.0), [0.0, -1.0, 0.0]);
        let cone = body(&cone, Vector3::new(0.0, 0.2, 0.0), tilt);
        let Some((overlap, points)) = touch(&ground, &cone, &exact(ContactModel::Clipping)) else { continue };
        assert!(points.len() <= 4);
        reduced += u32::from(points.len() == 4);
        assert!(deepest(&points) > overlap.depth - 2e-4 * cone.radius, "{} of {}", deepest(&points), overlap.depth);
        assert_eq!(features(&points).len(), points.len(), "a point twice");
    }
    assert!(reduced > 1000);
}

#[test]
fn cone_on_its_base_keeps_a_wide_stand() {
    let ground = upright(&Collider::half_space(), [0.0; 3]);
    let points = clipped(&ground, &upright(&Collider::cone(1.0, 2.0), [0.0, 0.499, 0.0]));
    assert_eq!(points.len(), 4);
    assert!(area(&points) > 1.95, "a square in the unit circle has area 2, this {}", area(&points));
    let on_box = clipped(
        &upright(&Collider::cuboid(4.0, 1.0, 4.0), [0.0, -0.5, 0.0]),
        &upright(&Collider::cone(1.0, 2.0), [0.0, 0.499, 0.0]),
    );
    assert_eq!(on_box.len(), 4);
    assert!(area(&on_box) > 1.95);
}

#[test]
fn crossing_edges_touch_in_one_point() {
    let quarter = |axis: Vector3<f64>| UnitQuaternion::from_scaled_axis(axis * FRAC_PI_4);
    let lower = body(&unit_cube(), Vector3::new(0.3, 0.0, 0.0), quarter(Vector3::z()));
    let upper = body(&unit_cube(), Vector3::new(0.1, SQRT_2 - 0.02, 0.2), quarter(Vector3::x()));
    for points in [clipped(&lower, &upper), clipped(&upper, &lower)] {
        assert_eq!(points.len(), 1);
        assert!((points[0].depth - 0.02).abs() < 1e-12);
        assert_close(points[0].point, Vector3::new(0.3, SQRT_2 / 2.0 - 0.01, 0.2), 1e-12);
    }
}

#[test]
fn ball_touches_in_one_point() {
    let ball = Collider::sphere(0.5);
    let (ground, cube) = (upright(&Collider::half_space(), [0.0; 3]), upright(&unit_cube(), [0.0, -0.5, 0.0]));
    let resting = upright(&ball, [0.2, 0.4, 0.3]);
    for other in [&ground, &cube] {
        for points in [clipped(other, &resting), clipped(&resting, other)] {
            assert_eq!(points.len(), 1);
            assert_close(points[0].point, Vector3::new(0.2, -0.05, 0.3), 1e-12);
            assert!((points[0].depth - 0.1).abs() < 1e-12);
        }
    }
    let points = clipped(&upright(&ball, [0.0; 3]), &upright(&Collider::sphere(1.0), [1.3, 0.0, 0.0]));
    assert_close(points[0].point, Vector3::new(0.4, 0.0, 0.0), 1e-12);
    assert_eq!(points.len(), 1);
}

#[test]
fn points_lie_in_both_bodies_and_the_deepest_has_the_depth_of_the_overlap() {
    let mut random = Random::new(4);
    for one in 0..3 {
        for other in 0..3 {
            for _ in 0..300 {
                let [a, b] = random_pair(&mut random, [one, other]);
                let Some((overlap, points)) = touch(&a, &b, &exact(ContactModel::Clipping)) else { continue };
                let kinds = [one, other];
                assert!((1..=4).contains(&points.len()), "{kinds:?}");
                let size = a.radius.min(b.radius);
                // Off by the outward margin of the sides, by the choice among nearly deepest,
                // and by the preference for faces: their least overlap counts, and where it is
                // up to 5 % deeper than an edge's, the deepest vertex may be beyond the face.
                let found = deepest(&points);
                let slack = 0.2 * overlap.depth + 3e-4 * size;
                assert!(found <= overlap.depth + 1e-9, "{kinds:?}: {found} of {}", overlap.depth);
                assert!(found >= overlap.depth - slack, "{kinds:?}: {found} of {}", overlap.depth);
                for point in &points {
                    assert!((0.0..=overlap.depth + 1e-9).contains(&point.depth));
                    let apart = outside(&a, &point.point).max(outside(&b, &point.point));
                    // Half-way between two surfaces that are not parallel may be outside of one
                    // of the bodies, by half the depth at most. In deep overlaps of thin bodies a
                    // corner below the reference face may have come out on the far side.
                    if overlap.depth < 0.1 * size {
                        assert!(apart < 0.5 * point.depth + 1e-4 * size, "{kinds:?}: {apart} m outside");
                    }
                }
            }
        }
    }
}

/// Whether a pair's features are the same after a motion of B by 1e-7 m and rad; none if the two
/// do not touch.
fn keeps_features(a: &Body, b: &Body, random: &mut Random) -> Option<bool> {
    let moved = Body {
        position: b.position + random.direction() * 1e-7,
        rotation: UnitQuaternion::from_scaled_axis(random.direction() * 1e-7) * b.rotation,
        ..b.clone()
    };
    let (_, before) = touch(a, b, &SolverSettings::steady())?;
    let (_, after) = touch(a, &moved, &SolverSettings::steady())?;
    Some(features(&before) == features(&after))
}

#[test]
fn resting_contacts_keep_their_features() {
    let mut random = Random::new(5);
    let lower = upright(&unit_cube(), [0.0; 3]);
    let ground = upright(&Collider::half_space(), [0.0, 0.5, 0.0]);
    // Aligned, with an overhang, turned, all with equal depths at every corner.
    for turn in [0.0, 0.3, FRAC_PI_4] {
        for [x, z] in [[0.0, 0.0], [0.2, 0.0], [0.3, -0.4]] {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::y() * turn);
            for (shape, height) in [(unit_cube(), 0.998), (Collider::cone(0.5, 1.0), 0.748)] {
                let upper = body(&shape, Vector3::new(x, height, z), rotation);
                for base in [&lower, &ground] {
                    for _ in 0..5 {
                        assert_eq!(keeps_features(base, &upper, &mut random), Some(true), "{shape:?} {turn} {x} {z}");
                    }
                }
            }
        }
    }
}

#[test]
fn features_change_under_small_motion_only_on_a_border() {
    let mut random = Random::new(6);
    let kept: Vec<bool> = (0..1000)
        .filter_map(|trial| {
            let [a, b] = random_pair(&mut random, [1 + trial % 2, 1 + trial / 2 % 2]);
            keeps_features(&a, &b, &mut random)
        })
        .collect();
    let same = kept.iter().filter(|&&kept| kept).count();
    assert!(kept.len() > 300 && same * 100 >= kept.len() * 99, "{same} of {}", kept.len());
}

#[test]
fn extreme_vertices_are_moved_by_the_depth_and_share_it() {
    let points = extreme(&upright(&unit_cube(), [0.0; 3]), &upright(&unit_cube(), [0.25, 0.98, 0.0]));
    // Four of A, moved down into it, then four of B, moved up out of A.
    let level = |points: &[ContactPoint], height: f64, shift: f64| {
        let corners = [[0.5, 0.5], [-0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]];
        let expected: Vec<_> = corners.iter().map(|corner| [corner[0] + shift, height, corner[1]]).collect();
        assert_eq!(rounded(points), rounded_positions(&expected));
    };
    assert_eq!(points.len(), 8);
    level(&points[..4], 0.48, 0.0);
    level(&points[4..], 0.5, 0.25);
    assert!(points.iter().all(|point| (point.depth - 0.02).abs() < 1e-12));
    assert_eq!(features(&points).len(), 8);
}

#[test]
fn extreme_vertices_on_the_ground_end_up_on_it() {
    let ground = upright(&Collider::half_space(), [0.0, 1.0, 0.0]);
    for (tilt, count) in [(0.0, 4), (1e-4, 4), (0.1, 2)] {
        let tilt = UnitQuaternion::from_scaled_axis(Vector3::z() * tilt);
        let points = extreme(&ground, &body(&unit_cube(), Vector3::new(0.0, 1.45, 0.0), tilt));
        assert_eq!(points.len(), count);
        assert!(points.iter().all(|point| (point.point.y - 1.0).abs() < 1e-3 && point.depth == points[0].depth));
    }
    let ball = extreme(&ground, &upright(&Collider::sphere(0.5), [0.0, 1.4, 0.0]));
    assert_eq!(ball.len(), 1);
    assert_close(ball[0].point, Vector3::new(0.0, 1.0, 0.0), 1e-12);
    let cone = extreme(&ground, &upright(&Collider::cone(0.5, 1.0), [0.0, 1.25, 0.0]));
    assert_eq!(cone.len(), 24, "the whole base");
}

/// The single point is the foremost vertex in the other body: of the cube, not a corner of the slab far away; among
/// those as far the first; and the lowest corner once it tilts.
#[test]
fn a_single_point_is_the_foremost_vertex_in_the_other_body() {
    let single = |a: &Body, b: &Body| {
        let (overlap, points) = touch(a, b, &exact(ContactModel::SinglePoint)).expect("touch");
        assert_eq!((points.len(), points[0].depth), (1, overlap.depth));
        points.into_iter().next().expect("a point")
    };
    let ground = upright(&Collider::half_space(), [0.0; 3]);
    let slab = upright(&Collider::cuboid(20.0, 1.0, 20.0), [0.0, -0.5, 0.0]);
    for base in [&ground, &slab] {
        let level = upright(&unit_cube(), [3.0, 0.48, 1.0]);
        let first =
            extreme(base, &level).into_iter().find(|point| point.point.x.abs() < 4.0).expect("a corner of the cube");
        let point = single(base, &level);
        assert_eq!((point.point, point.feature), (first.point, first.feature));
        let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(-2e-4, 0.0, 1e-4));
        let point = single(base, &body(&unit_cube(), Vector3::new(3.0, 0.48, 1.0), tilt));
        assert_close(point.point, Vector3::new(2.5, 0.0, 0.5), 1e-3);
    }
    // Edges that cross hold no vertex of each other: an end of one of them.
    let quarter = |axis: Vector3<f64>| UnitQuaternion::from_scaled_axis(axis * FRAC_PI_4);
    let lower = body(&unit_cube(), Vector3::zeros(), quarter(Vector3::z()));
    single(&lower, &body(&unit_cube(), Vector3::new(0.1, SQRT_2 - 0.02, -0.1), quarter(Vector3::x())));
}

/// Its documented weakness: the corners of a wide slab count, however far from where the ball is.
#[test]
fn extreme_vertices_of_a_slab_under_a_ball_are_its_far_corners() {
    let slab = upright(&Collider::cuboid(20.0, 1.0, 20.0), [0.0; 3]);
    let points = extreme(&slab, &upright(&Collider::sphere(0.5), [2.0, 0.99, 0.0]));
    assert_eq!(points.len(), 5);
    assert_eq!(points.iter().filter(|point| point.point.x.abs() > 9.9).count(), 4);
    let balls = extreme(&upright(&Collider::sphere(0.5), [0.0; 3]), &upright(&Collider::sphere(0.5), [0.9, 0.0, 0.0]));
    assert_eq!(balls.len(), 1);
}

#[test]
fn points_are_in_world_axes_anywhere() {
    let mut random = Random::new(6);
    let far = Vector3::new(2f64.powi(20), 2f64.powi(21), -2f64.powi(20));
    for model in [ContactModel::Clipping, ContactModel::ExtremeVertices, ContactModel::SinglePoint] {
        for _ in 0..200 {
            let [mut a, mut b] = random_pair(&mut random, [1, 2]);
            let turn = random.rotation();
            (a.rotation, b.rotation) = (turn * a.rotation, turn * b.rotation);
            // Steps that positions far away can take exactly.
            let grid = |position: Vector3<f64>| position.map(|along| (along * 1024.0).round() / 1024.0);
            (a.position, b.position) = (grid(a.position), grid(b.position));
            let near = touch(&a, &b, &exact(model));
            (a.position, b.position) = (a.position + far, b.position + far);
            let there = touch(&a, &b, &exact(model));
            assert_eq!(near.is_some(), there.is_some());
            if let (Some((near_overlap, near)), Some((overlap, there))) = (near, there) {
                assert_eq!((near_overlap.normal, near_overlap.depth), (overlap.normal, overlap.depth));
                for (near, there) in near.iter().zip(&there) {
                    assert_close(near.point + far, there.point, 1e-9);
                    assert_eq!((near.depth, near.feature), (there.depth, there.feature));
                }
            }
        }
    }
}

/// Of an irregular hull the face that looks down most need not hold its lowest corner.
#[test]
fn over_a_flat_face_the_deepest_point_is_where_a_hull_is_lowest() {
    let mut random = Random::new(74);
    let slab = upright(&Collider::cuboid(20.0, 2.0, 20.0), [0.0, -1.0, 0.0]);
    let field = TriangleMesh::height_field([20.0, 20.0], [2, 2], |_, _| 0.0).expect("a field");
    let grounds = [slab, upright(&Collider::mesh(field), [0.0; 3])];
    let (mut search, mut points, mut beside) = (PairSearch::default(), Vec::new(), 0);
    for case in 0..2000 {
        let hull = random_hull(&mut random);
        let rotation = random.rotation();
        let heights = hull.vertices.iter().map(|vertex| (rotation * vertex).y);
        let lowest = heights.fold(f64::INFINITY, f64::min);
        let faces = hull.faces.iter().map(|face| ((rotation * face.normal).y, face));
        let (_, flattest) = faces.min_by(|one, other| one.0.total_cmp(&other.0)).expect("faces");
        let level = |vertex: &u32| (rotation * hull.vertices[*vertex as usize]).y;
        beside += u32::from(flattest.vertices.iter().all(|vertex| level(vertex) > lowest + 1e-9));
        let depth = 0.1 * -lowest * random.within(-1.0, 1.0);
        let above = hull_body(hull, Vector3::new(0.3, -lowest - depth, -0.2), rotation);
        for below in &grounds {
            points.clear();
            (search.is_exact, search.last) = (true, None);
            let overlap = contact_pair::touch([below, &above], PartPair::default(), 1.0, &mut search, &mut points);
            assert!(overlap.expect("in reach").normal.y > 1.0 - 1e-12, "case {case}");
            let found = points.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
            assert!((found - depth).abs() < 1e-12, "case {case}: {found} m of {depth}");
        }
    }
    assert!(beside > 10, "{beside} hulls stand on a corner beside a flat face");
}
