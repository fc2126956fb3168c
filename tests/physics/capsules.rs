//! Capsules: where they touch, how they lie, stand, roll and fall.

use std::f64::consts::FRAC_PI_2;

use bevy::ecs::system::SystemState;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

const LYING: DQuat = DQuat::from_xyzw(0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2);

fn capsule(world: &mut World, at: DVec3, turned: DQuat) -> Entity {
    let own = body(world, Collider::capsule(0.2, 0.8), at);
    world.entity_mut(own).insert(Rotation(turned));
    own
}

#[test]
fn moments_and_volume_are_those_of_its_points() {
    let (radius, length) = (0.7, 1.3);
    let of_mass = Collider::capsule(radius, length).mass_properties(1.0);
    let mut dice = Pcg64Mcg::seed_from_u64(7);
    let (size, count) = (DVec3::new(radius, 0.5 * length + radius, radius), 2_000_000);
    let (mut mass, mut inertia) = (0.0, DVec3::ZERO);
    for _ in 0..count {
        let at = DVec3::from_array(size.to_array().map(|half| dice.random_range(-half..half)));
        let beside = at - DVec3::Y * at.y.clamp(-0.5 * length, 0.5 * length);
        if beside.length_squared() <= radius * radius {
            mass += 1.0;
            inertia += DVec3::splat(at.length_squared()) - at * at;
        }
    }
    let share = 8.0 * size.element_product() / f64::from(count);
    assert!((mass * share / of_mass.mass - 1.0).abs() < 2e-3, "{} and {of_mass:?}", mass * share);
    let error = (inertia * share / of_mass.inertia - DVec3::ONE).abs().max_element();
    assert!(error < 3e-3, "{} and {of_mass:?}", inertia * share);
}

/// Points of the segment one by one, by how far each is from the other shape.
#[test]
fn depths_are_those_of_the_nearest_point_of_the_segment() {
    let mut dice = Pcg64Mcg::seed_from_u64(8);
    let mut within = |low: f64, high: f64| dice.random_range(low..high);
    let corners: Vec<DVec3> =
        (0..8).map(|k| DVec3::new(k as f64 % 2.0, (k / 2) as f64 % 2.0, (k / 4) as f64)).collect();
    let others = [
        Collider::half_space(),
        Collider::sphere(0.6),
        Collider::cuboid(1.0, 0.5, 1.5),
        Collider::cone(0.6, 1.2),
        Collider::capsule(0.4, 0.7),
        Collider::convex_hull(&corners).expect("a cube"),
    ];
    let mut touching = 0;
    for (kind, other) in others.iter().enumerate() {
        for case in 0..300 {
            let axis = DVec3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
            let turned = DQuat::from_axis_angle((axis + DVec3::Y * 1e-3).normalize(), within(-3.0, 3.0));
            let at = DVec3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
            let [radius, length] = [within(0.1, 0.5), within(0.1, 1.5)];
            let own = Collider::capsule(radius, length);
            let mut world = weightless(SolverSettings::game());
            world.spawn((RigidBody::Static, other.clone()));
            step(&mut world);
            let mut state = SystemState::<PhysicsQuery>::new(&mut world);
            let query = state.get(&world).expect("a question");
            let along = turned * DVec3::Y;
            let distances = (0..=4000).map(|part| {
                let point = at + along * (length * (f64::from(part) / 4000.0 - 0.5));
                query.nearest_point(point, f64::INFINITY, &QueryFilter::default()).expect("it is there").distance
            });
            let nearest = distances.fold(f64::INFINITY, f64::min);
            let placed = |collider, position, rotation| PlacedCollider {
                collider,
                position: Position(position),
                rotation: Rotation(rotation),
            };
            let capsule = placed(&own, at, turned);
            let still = placed(other, DVec3::ZERO, DQuat::IDENTITY);
            for found in [capsule.overlap(&still), still.overlap(&capsule)] {
                match found {
                    // With the segment itself inside, no point tells how deep.
                    Some(depth) if nearest > 0.0 => {
                        touching += 1;
                        assert!(
                            (depth - (radius - nearest)).abs() < 2e-6,
                            "{kind} {case}: {depth}, {}",
                            radius - nearest
                        );
                    }
                    Some(depth) => assert!(depth >= radius * (1.0 - 1e-9), "{kind} {case}: {depth}"),
                    None => assert!(nearest > radius - 1e-9, "{kind} {case}: apart, and {}", radius - nearest),
                }
            }
        }
    }
    assert!(touching > 600, "{touching}");
}

#[test]
fn it_lies_and_stands_on_everything_by_every_method() {
    for (name, settings) in presets() {
        // Force-level methods rest as deep as their slop.
        let slack = match name {
            "classic" => 0.03,
            "steady" => 5e-3,
            _ => 1e-3,
        };
        // What is below, and how high its top is.
        let floors = [
            (Collider::half_space(), DVec3::ZERO),
            (Collider::cuboid(3.0, 0.5, 3.0), DVec3::NEG_Y * 0.25),
            (Collider::cone(3.0, 1.0), DVec3::NEG_Y * 0.25),
        ];
        for (place, (floor, at)) in floors.into_iter().enumerate() {
            let turned = if place == 2 { DQuat::from_rotation_x(std::f64::consts::PI) } else { DQuat::IDENTITY };
            for (stands, turn, height) in [(false, LYING, 0.2), (true, DQuat::IDENTITY, 0.6)] {
                let mut world = world_with(settings);
                world.spawn((RigidBody::Static, floor.clone(), Position(at), Rotation(turned)));
                let own = capsule(&mut world, DVec3::Y * height, turn);
                run(&mut world, if name == "classic" { 0.3 } else { 2.0 });
                let now = position(&world, own);
                let error = (now - DVec3::Y * height).length();
                assert!(error < slack, "{name}, floor {place}, stands {stands}: {now}");
            }
        }
    }
}

#[test]
fn lying_ones_make_a_pile_that_stays() {
    let mut world = world_with(awake_game());
    ground(&mut world);
    let across = DQuat::from_rotation_y(FRAC_PI_2) * LYING;
    let mut all = Vec::new();
    for layer in 0..5 {
        for side in [-0.3, 0.3] {
            let (turn, aside) = if layer % 2 == 0 { (LYING, DVec3::Z) } else { (across, DVec3::X) };
            all.push(capsule(&mut world, aside * side + DVec3::Y * (0.2 + 0.4 * f64::from(layer)), turn));
        }
    }
    let before: Vec<DVec3> = all.iter().map(|own| position(&world, *own)).collect();
    run(&mut world, 5.0);
    for (own, before) in all.iter().zip(before) {
        let moved = position(&world, *own).distance(before);
        assert!(moved < 5e-3, "{moved} m from {before}");
    }
}

/// a = g sin θ / (1 + I/(m r²)) for one that rolls on its side.
#[test]
fn it_rolls_down_a_slope_as_its_moment_says() {
    let slope = 20.0_f64.to_radians();
    for (name, settings) in presets() {
        if name == "classic" {
            continue; // a polygon
        }
        let mut world = world_with(settings);
        world.insert_resource(Gravity(DVec3::new(slope.sin(), -slope.cos(), 0.0) * G));
        ground(&mut world);
        let own = capsule(&mut world, DVec3::Y * 0.2, DQuat::from_rotation_x(FRAC_PI_2));
        let moment = Collider::capsule(0.2, 0.8).mass_properties_of_mass(1.0).inertia.y;
        let expected = G * slope.sin() / (1.0 + moment / 0.04);
        run(&mut world, 2.0);
        let found = velocity(&world, own).x / 2.0;
        assert!((found / expected - 1.0).abs() < 0.01, "{name}: {found} m/s², not {expected}");
    }
}

#[test]
fn one_that_stood_falls_over_without_a_gain_and_lies() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        world.init_resource::<Diagnostics>();
        ground(&mut world);
        let own = capsule(&mut world, DVec3::Y * 0.601, DQuat::from_rotation_z(0.05));
        step(&mut world);
        let mass = world.get::<Mass>(own).unwrap().0;
        assert_gains_nothing(&mut world, 360, name, |_| 0.02 * mass * G * 0.2);
        let lies = position(&world, own).y;
        // The polygon that stands for it in classic is narrower.
        assert!((lies - 0.2).abs() < if name == "classic" { 0.03 } else { 5e-3 }, "{name}: {lies}");
    }
}

#[test]
fn none_that_is_shot_passes_a_sheet() {
    assert_none_passes_a_sheet(&Collider::capsule(0.05, 0.3), 9);
}
