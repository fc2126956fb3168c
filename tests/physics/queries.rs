//! Questions about where bodies are, against other ways to find out.

use bevy::ecs::system::SystemState;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

/// Cases of each test that compares with another way: of seconds on one core at opt-level 1.
const CASES: usize = 10_000;

/// Angle between a ray and a surface, as a sine, under which it grazes: how far off it is then tells little of where.
const GRAZING: f64 = 1e-3;

struct Dice(Pcg64Mcg);

impl Dice {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.within(-size, size)))
    }

    fn rotation(&mut self) -> DQuat {
        let axis = loop {
            let axis = self.vector(1.0);
            if (0.01..1.0).contains(&axis.length_squared()) {
                break axis.normalize();
            }
        };
        DQuat::from_axis_angle(axis, self.within(-3.0, 3.0))
    }

    /// One of each kind of shape in turn.
    fn collider(&mut self, kind: usize) -> Collider {
        match kind % 7 {
            0 => Collider::sphere(self.within(0.2, 1.0)),
            1 => Collider::cuboid(self.within(0.2, 2.0), self.within(0.2, 2.0), self.within(0.2, 2.0)),
            2 => Collider::cone(self.within(0.2, 1.0), self.within(0.3, 2.0)),
            3 => {
                // Of flat faces: facets that are nearly in one plane are merged, and are not where they were.
                let sides = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * self.within(0.3, 1.0) + self.vector(0.2));
                let points: Vec<DVec3> = match kind / 7 % 2 {
                    0 => sides.into_iter().flat_map(|side| [side, -side]).collect(),
                    _ => (0..8)
                        .map(|corner| (0..3).map(|axis| sides[axis] * [1.0, -1.0][corner >> axis & 1]).sum())
                        .collect(),
                };
                Collider::convex_hull(&points).expect("points that span a volume")
            }
            4 => Collider::half_space(),
            5 => Collider::cylinder(self.within(0.1, 0.8), self.within(0.1, 1.5)),
            _ => Collider::capsule(self.within(0.1, 0.6), self.within(0.1, 1.5)),
        }
    }
}

/// A world of bodies of all kinds that do not move, after a step.
fn scattered(dice: &mut Dice, count: usize, room: f64) -> (World, Vec<Entity>) {
    let mut world = world_with(SolverSettings::game());
    let spawn = |kind| {
        let other = 7 * dice.0.random_range(0..2);
        let (collider, at, turn) = (dice.collider(kind + other), dice.vector(room), dice.rotation());
        let at = if kind % 7 == 4 { at + DVec3::NEG_Y * 3.0 * room } else { at };
        world.spawn((RigidBody::Static, collider, Position(at), Rotation(turn))).id()
    };
    let bodies = (0..count).map(spawn).collect();
    step(&mut world);
    (world, bodies)
}

fn ask<T>(world: &mut World, question: impl FnOnce(PhysicsQuery) -> T) -> T {
    let mut state = SystemState::<PhysicsQuery>::new(world);
    question(state.get(world).expect("all that a question needs is there"))
}

/// Where a ray comes to a body, by going on by how far the body is, again and again.
fn marched(query: &PhysicsQuery, ray: &Ray, radius: f64, filter: &QueryFilter) -> Option<f64> {
    let (unit, mut gone) = (ray.direction.normalize(), 0.0);
    for _ in 0..5000 {
        let here = query.nearest_point(ray.origin + unit * gone, f64::INFINITY, filter)?;
        if here.distance - radius < 1e-11 {
            return Some(gone);
        }
        gone += here.distance - radius;
        if gone > ray.length {
            return None;
        }
    }
    Some(gone)
}

#[test]
fn rays_meet_each_shape_where_marching_along_them_does() {
    let mut dice = Dice::new(1);
    let (mut hits, mut misses) = (0, 0);
    for case in 0..CASES / 5 {
        let (mut world, bodies) = scattered(&mut dice, 6, 0.5);
        for &body in &bodies {
            let only = |other: Entity| other == body;
            let filter = QueryFilter { accepts: Some(&only), ..default() };
            let origin = dice.vector(4.0);
            let ray = Ray { origin, direction: dice.vector(0.7) - origin * 0.9, length: dice.within(1.0, 20.0) };
            ask(&mut world, |query| match (query.ray(&ray, &filter), marched(&query, &ray, 0.0, &filter)) {
                (Some(hit), expected) => {
                    hits += 1;
                    let slope = -hit.normal.dot(ray.direction.normalize());
                    assert!(slope > 0.0 && hit.entity == body && (hit.normal.length() - 1.0).abs() < 1e-12, "{hit:?}");
                    let on_it = query.nearest_point(hit.point, 1.0, &filter).expect("it is there").distance;
                    assert!(on_it < 1e-12, "case {case}: {on_it} m off");
                    if slope > GRAZING {
                        let expected = expected.unwrap_or(f64::INFINITY);
                        assert!((hit.distance - expected).abs() < 1e-7, "case {case}: {hit:?}, {expected} m");
                    }
                }
                (None, None) => misses += 1,
                (None, Some(expected)) => {
                    let here = ray.origin + ray.direction.normalize() * expected;
                    // Only where it just touches.
                    let beyond = here + ray.direction.normalize() * 1e-3;
                    let apart = query.nearest_point(beyond, 1.0, &filter).map(|near| near.distance);
                    assert!(
                        apart.is_none_or(|apart| apart > 0.0) || (expected - ray.length).abs() < 1e-9,
                        "case {case}: {body} missed at {expected} m"
                    );
                }
            });
        }
    }
    assert!(hits > CASES / 4 && misses > CASES / 20, "{hits} hits, {misses} misses");
}

#[test]
fn the_nearest_point_is_on_the_body_and_none_of_its_points_is_nearer() {
    let mut dice = Dice::new(2);
    for case in 0..CASES / 50 {
        let (mut world, bodies) = scattered(&mut dice, 6, 0.5);
        let (points, tries): (Vec<_>, Vec<_>) = (0..10).map(|_| (dice.vector(3.0), dice.vector(1.5))).unzip();
        ask(&mut world, |query| {
            for &body in &bodies {
                let only = |other: Entity| other == body;
                let filter = QueryFilter { accepts: Some(&only), ..default() };
                let nearest = |at: DVec3| query.nearest_point(at, f64::INFINITY, &filter).expect("it is there");
                // Points of the body: those that are inside, and the nearest of those that are not.
                let own: Vec<DVec3> = tries.iter().map(|&at| nearest(at).point).collect();
                for &point in &points {
                    let hit = nearest(point);
                    assert!((hit.point.distance(point) - hit.distance).abs() < 1e-12, "case {case}: {hit:?}");
                    assert!(
                        nearest(hit.point).distance < 1e-12,
                        "case {case}: {hit:?} is {} m off its body",
                        nearest(hit.point).distance
                    );
                    let nearer = own.iter().find(|at| at.distance(point) < hit.distance - 1e-12);
                    assert_eq!(nearer, None, "case {case}: of {point}, and not {hit:?}");
                    let within = query.nearest_point(point, hit.distance * 0.999, &filter);
                    assert_eq!(within.is_some(), hit.distance == 0.0, "case {case}: {within:?} is nearer than {hit:?}");
                }
            }
        });
    }
}

#[test]
fn a_ball_on_its_way_touches_where_marching_along_it_does() {
    let mut dice = Dice::new(3);
    let mut hits = 0;
    for case in 0..CASES / 5 {
        let (mut world, bodies) = scattered(&mut dice, 6, 0.5);
        for &body in &bodies {
            let only = |other: Entity| other == body;
            let filter = QueryFilter { accepts: Some(&only), ..default() };
            let radius = dice.within(0.05, 0.5);
            let (origin, ball) = (dice.vector(4.0), Collider::sphere(radius));
            let ray = Ray { origin, direction: dice.vector(0.7) - origin * 0.9, length: dice.within(1.0, 20.0) };
            let placed = PlacedCollider { collider: &ball, position: Position(origin), rotation: Rotation::default() };
            ask(&mut world, |query| {
                let hit = query.shape_cast(&placed, ray.direction, ray.length, &filter);
                let expected = marched(&query, &ray, radius, &filter);
                let Some(hit) = hit else {
                    // Only where it just touches, or at the very end.
                    if let Some(expected) = expected {
                        let beyond = ray.origin + ray.direction.normalize() * (expected + 1e-3);
                        let apart =
                            query.nearest_point(beyond, 2.0, &filter).map_or(2.0, |near| near.distance) - radius;
                        assert!(
                            apart > 0.0 || (expected - ray.length).abs() < 1e-9,
                            "case {case}: {body} at {expected}"
                        );
                    }
                    return;
                };
                hits += 1;
                let slope = -hit.normal.dot(ray.direction.normalize());
                if hit.distance > 0.0 && slope > GRAZING {
                    let expected = expected.unwrap_or(f64::INFINITY);
                    assert!((hit.distance - expected).abs() < 1e-7, "case {case}: {hit:?}, {expected} m");
                    let center = ray.origin + ray.direction.normalize() * hit.distance;
                    assert!((hit.point.distance(center) - radius).abs() < 1e-6, "case {case}: {hit:?}");
                }
            });
        }
    }
    assert!(hits > CASES / 4, "{hits} hits");
}

#[test]
fn what_is_cast_overlaps_nothing_on_its_way_and_just_touches_where_it_ends() {
    let mut dice = Dice::new(4);
    let mut hits = 0;
    for case in 0..CASES / 20 {
        let (mut world, bodies) = scattered(&mut dice, 6, 0.5);
        for (&body, kind) in bodies.iter().zip(0..) {
            let only = |other: Entity| other == body;
            let filter = QueryFilter { accepts: Some(&only), ..default() };
            let collider = dice.collider([0, 1, 2, 3, 5, 6][(kind + case) % 6] + 7 * (case % 2));
            let (origin, rotation) = (dice.vector(5.0), Rotation(dice.rotation()));
            let way = (dice.vector(0.7) - origin).normalize();
            let at =
                |gone: f64| PlacedCollider { collider: &collider, position: Position(origin + way * gone), rotation };
            ask(&mut world, |query| {
                let touches = |gone: f64| query.overlap(&at(gone), &filter).is_some();
                let Some(hit) = query.shape_cast(&at(0.0), way, 8.0, &filter) else {
                    assert!(
                        (0..80).all(|part| !touches(0.1 * f64::from(part))),
                        "case {case}: {body} was passed through"
                    );
                    return;
                };
                if hit.distance == 0.0 {
                    assert!(touches(0.0), "case {case}");
                    return;
                }
                hits += 1;
                let parts = (0..40).map(|part| hit.distance * f64::from(part) / 40.0);
                assert!(!parts.into_iter().any(touches), "case {case}: {hit:?} is late");
                if -hit.normal.dot(way) > GRAZING {
                    assert!(!touches(hit.distance - 1e-6) && touches(hit.distance + 1e-6), "case {case}: {hit:?}");
                }
            });
        }
    }
    assert!(hits > CASES / 20, "{hits} hits");
}

#[test]
fn among_many_the_first_is_that_of_each_alone() {
    let mut dice = Dice::new(5);
    for count in [1, 3, 30, 300] {
        let (mut world, bodies) = scattered(&mut dice, count, 6.0);
        let rays: Vec<Ray> = (0..CASES / 200).map(|_| Ray::new(dice.vector(12.0), dice.vector(1.0))).collect();
        let (collider, rotation) = (dice.collider(1), Rotation(dice.rotation()));
        ask(&mut world, |query| {
            let all = QueryFilter::default();
            for ray in &rays {
                let place = PlacedCollider { collider: &collider, position: Position(ray.origin), rotation };
                let (mut by_ray, mut by_cast, mut nearest, mut touched) = (vec![], vec![], vec![], vec![]);
                for &body in &bodies {
                    let only = |other: Entity| other == body;
                    let alone = QueryFilter { accepts: Some(&only), ..default() };
                    by_ray.extend(query.ray(ray, &alone));
                    by_cast.extend(query.shape_cast(&place, ray.direction, 30.0, &alone));
                    nearest.extend(query.nearest_point(ray.origin, 5.0, &alone));
                    touched.extend(query.overlap(&place, &alone));
                }
                by_ray.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                by_cast.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                nearest.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.entity.cmp(&b.entity)));
                touched.sort_unstable();
                assert_eq!(query.ray(ray, &all), by_ray.first().copied());
                assert_eq!(query.ray_all(ray, &all), by_ray);
                assert_eq!(
                    query.shape_cast(&place, ray.direction, 30.0, &all).map(|hit| hit.entity),
                    by_cast.first().map(|hit| hit.entity)
                );
                assert_eq!(query.shape_cast_all(&place, ray.direction, 30.0, &all), by_cast);
                assert_eq!(query.nearest_point(ray.origin, 5.0, &all), nearest.first().copied());
                assert_eq!(query.nearest_points(ray.origin, 5.0, &all), nearest);
                assert_eq!(query.overlap_all(&place, &all), touched);
            }
        });
    }
}

#[test]
fn many_rays_on_threads_find_what_each_finds() {
    let mut dice = Dice::new(6);
    let (mut world, _) = scattered(&mut dice, 200, 6.0);
    world.resource_mut::<SolverSettings>().threads = 4;
    let rays: Vec<Ray> = (0..1000).map(|_| Ray::new(dice.vector(12.0), dice.vector(1.0))).collect();
    ask(&mut world, |query| {
        let all = QueryFilter::default();
        let alone: Vec<Option<RayHit>> = rays.iter().map(|ray| query.ray(ray, &all)).collect();
        assert!(alone.iter().flatten().count() > 100);
        assert_eq!(query.rays(&rays, &all), alone);
    });
}

#[test]
fn after_each_step_answers_are_of_where_bodies_are_by_every_method() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::Y * 10.0);
        let down = Ray::new(DVec3::Y * 20.0, DVec3::NEG_Y);
        for _ in 0..30 {
            step(&mut world);
            let top = position(&world, ball).y + 0.5;
            let hit = ask(&mut world, |query| query.ray(&down, &QueryFilter::default())).expect("it is below");
            assert!(hit.entity == ball && (20.0 - hit.distance - top).abs() < 1e-9, "{name}: {hit:?}, {top}");
        }
        assert!(position(&world, ball).y < 9.0, "{name}: it did not fall");
    }
}

#[test]
fn a_filter_leaves_out_what_it_says() {
    let mut world = weightless(SolverSettings::game());
    let at = |x: f64| (Collider::sphere(0.5), Position(DVec3::X * x));
    let own = CollisionLayers { memberships: 0b10, filters: 0b10 };
    let near = world.spawn((RigidBody::Static, at(2.0))).id();
    let layered = world.spawn((RigidBody::Dynamic, at(4.0), own)).id();
    let moved = world.spawn((RigidBody::Kinematic, at(6.0))).id();
    let deaf = world.spawn((RigidBody::Static, at(8.0), CollisionLayers::NONE)).id();
    world.spawn((RigidBody::Static, at(1.0), Sensor));
    step(&mut world);
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    let is_far = |entity: Entity| entity == deaf;
    let only_own = CollisionLayers { memberships: 0b10, filters: u32::MAX };
    let all = QueryFilter::default();
    let filters = [
        (all, vec![near, layered, moved, deaf]),
        (QueryFilter { kind: Some(RigidBody::Kinematic), ..all }, vec![moved]),
        (QueryFilter { without: &[near, moved], ..all }, vec![layered, deaf]),
        (QueryFilter { accepts: Some(&is_far), ..all }, vec![deaf]),
        (QueryFilter { layers: Some(only_own), ..all }, vec![near, layered, moved]),
        (QueryFilter { layers: Some(CollisionLayers { filters: 0b01, ..only_own }), ..all }, vec![near, moved]),
    ];
    ask(&mut world, |query| {
        for (place, (filter, expected)) in filters.iter().enumerate() {
            let found: Vec<Entity> = query.ray_all(&ray, filter).iter().map(|hit| hit.entity).collect();
            assert_eq!(found, *expected, "filter {place}");
        }
    });
}

#[test]
fn what_makes_no_sense_finds_nothing() {
    let mut world = weightless(SolverSettings::game());
    let ball = body(&mut world, Collider::sphere(1.0), DVec3::ZERO);
    step(&mut world);
    let (all, collider) = (QueryFilter::default(), Collider::cuboid(0.1, 0.1, 0.1));
    let nowhere = [DVec3::NAN, DVec3::INFINITY, DVec3::new(0.0, f64::NAN, 0.0)];
    ask(&mut world, |query| {
        for bad in nowhere {
            let placed = PlacedCollider { collider: &collider, position: Position(bad), rotation: Rotation::default() };
            assert_eq!(query.ray(&Ray::new(bad, DVec3::X), &all), None);
            assert_eq!(query.ray(&Ray::new(DVec3::X * -5.0, bad), &all), None);
            assert_eq!(query.nearest_point(bad, 9.0, &all), None);
            assert_eq!(query.shape_cast(&placed, DVec3::X, 9.0, &all), None);
            assert_eq!(query.overlap(&placed, &all), None);
            let here = PlacedCollider { position: Position(DVec3::X * -5.0), ..placed };
            assert_eq!(query.shape_cast(&here, bad, 9.0, &all), None);
        }
        assert_eq!(query.ray(&Ray::new(DVec3::X * -5.0, DVec3::ZERO), &all), None);
        let short = Ray { length: f64::NAN, ..Ray::new(DVec3::X * -5.0, DVec3::X) };
        assert_eq!(query.ray(&short, &all), None);
        // And a ray that begins inside is at its end.
        let inside = query.ray(&Ray::new(DVec3::X * 0.3, DVec3::Y), &all).expect("it is in it");
        assert_eq!((inside.entity, inside.distance, inside.normal), (ball, 0.0, DVec3::NEG_Y));
    });
}
