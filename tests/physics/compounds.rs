//! Bodies of several solids.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::{CompoundChild, CompoundError, TriangleMesh};
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig::*;

fn child(collider: Collider, position: DVec3) -> CompoundChild {
    CompoundChild { collider, position, rotation: DQuat::IDENTITY }
}

/// A box of those sizes, cut in two across x.
fn halves(x: f64, y: f64, z: f64) -> Collider {
    let half = |side: f64| child(Collider::cuboid(x / 2.0, y, z), DVec3::X * (side * x / 4.0));
    Collider::compound(&[half(-1.0), half(1.0)]).expect("two boxes")
}

/// A bowl of slabs round about a floor, its inside 1 m wide and 0.5 m high, with where its floor is below its centre.
fn bowl() -> (Collider, f64) {
    let mut children = vec![child(Collider::cuboid(1.2, 0.1, 1.2), DVec3::Y * -0.05)];
    for side in 0..12 {
        let rotation = DQuat::from_rotation_y(TAU * f64::from(side) / 12.0);
        let position = rotation * DVec3::new(0.55, 0.25, 0.0);
        children.push(CompoundChild { collider: Collider::cuboid(0.1, 0.5, 0.35), position, rotation });
    }
    let collider = Collider::compound(&children).expect("a bowl");
    let plumb::physics::Shape::Compound(compound) = collider.shape() else { panic!("a compound") };
    let floor = -compound.center().y;
    assert!(compound.axes().is_near_identity() && compound.center().x.abs() < 1e-12);
    (collider, floor)
}

#[test]
fn two_halves_weigh_what_the_whole_does_and_move_as_it() {
    let (whole, cut) = (Collider::cuboid(0.8, 0.3, 0.5), halves(0.8, 0.3, 0.5));
    let [one, other] = [&whole, &cut].map(|collider| collider.mass_properties(700.0));
    assert!((one.mass - other.mass).abs() < 1e-12 * one.mass, "{one:?} {other:?}");
    assert!((one.inertia - other.inertia).length() < 1e-12 * one.inertia.length(), "{one:?} {other:?}");
    for (name, settings) in presets() {
        let ends = [&whole, &cut].map(|collider| {
            let mut world = world_with(settings);
            ground(&mut world);
            let own = body(&mut world, collider.clone(), DVec3::Y * 0.6);
            let turned = DQuat::from_rotation_z(0.3);
            world.entity_mut(own).insert((Rotation(turned), Velocity { linear: DVec3::X, angular: DVec3::Y }));
            // Until it has landed, fallen flat and come to rest.
            run(&mut world, if name == "classic" { 0.25 } else { 3.0 });
            position(&world, own)
        });
        let apart = (ends[0] - ends[1]).length();
        // Two contacts where there was one: friction is shared otherwise, and sweeps go through more rows.
        let most = if name == "accurate" { 1e-6 } else { 0.03 };
        assert!(apart < most, "{name}: {} and {}", ends[0], ends[1]);
    }
}

#[test]
fn a_turned_child_weighs_as_steiner_says() {
    let rotation = DQuat::from_rotation_z(0.7);
    let children = [
        child(Collider::sphere(0.3), DVec3::new(0.2, -0.4, 0.1)),
        CompoundChild { collider: Collider::cuboid(0.4, 0.9, 0.2), position: DVec3::new(-0.5, 0.3, 0.6), rotation },
    ];
    let collider = Collider::compound(&children).expect("two solids");
    let plumb::physics::Shape::Compound(compound) = collider.shape() else { panic!("a compound") };
    // ∫ x xᵀ over a grid of points in either solid.
    let (mut mass, mut center, mut points) = (0.0, DVec3::ZERO, Vec::new());
    let count = 90;
    for index in 0..count * count * count {
        let part = |place: i32| (f64::from(place) + 0.5) / f64::from(count) * 2.6 - 1.3;
        let at = DVec3::new(part(index % count), part(index / count % count), part(index / count / count));
        let in_ball = at.distance(children[0].position) <= 0.3;
        let local = (rotation.inverse() * (at - children[1].position)).abs();
        let in_box = local.x <= 0.2 && local.y <= 0.45 && local.z <= 0.1;
        if in_ball || in_box {
            mass += (2.6 / f64::from(count)).powi(3);
            center += at;
            points.push(at);
        }
    }
    center /= points.len() as f64;
    assert!((compound.center() - center).length() < 5e-3, "{} {center}", compound.center());
    let about: DVec3 = points
        .iter()
        .map(|&at| {
            let local = compound.axes().inverse() * (at - center);
            DVec3::splat(local.length_squared()) - local * local
        })
        .sum::<DVec3>()
        / points.len() as f64;
    let found = collider.mass_properties_of_mass(1.0).inertia;
    assert!((collider.volume() / mass - 1.0).abs() < 0.02, "{} {mass}", collider.volume());
    assert!((found - about).abs().max_element() < 0.02 * found.max_element(), "{found} {about}");
}

#[test]
fn a_bowl_holds_a_ball_by_every_method() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        ground(&mut world);
        let (collider, floor) = bowl();
        let own = body(&mut world, collider, DVec3::Y * (0.1 - floor));
        let ball = body(&mut world, Collider::sphere(0.2), DVec3::new(0.1, 0.35, 0.05));
        run(&mut world, if name == "classic" { 0.5 } else { 1.5 });
        let (bowl, ball) = (position(&world, own), position(&world, ball));
        let slack = if matches!(name, "classic" | "steady") { 0.03 } else { 2e-3 };
        assert!((bowl.y + floor - 0.1).abs() < slack, "{name}: the bowl is at {bowl}");
        assert!((ball.y - bowl.y - floor - 0.2).abs() < slack, "{name}: the ball at {ball}, the bowl at {bowl}");
        assert!((ball - bowl).with_y(0.0).length() < 0.3, "{name}: {ball} {bowl}");
    }
}

#[test]
fn compounds_stack_on_a_mesh_and_it_is_told_once_that_they_touch() {
    let mut world = world_with(awake_game());
    let mesh = TriangleMesh::height_field([6.0, 6.0], [12, 12], |_, _| 0.0).expect("a field");
    let ground = world.spawn((RigidBody::Static, Collider::mesh(mesh))).id();
    let all: Vec<Entity> = (0..4)
        .map(|place| body(&mut world, halves(0.8, 0.3, 0.5), DVec3::Y * (0.15 + 0.3 * f64::from(place))))
        .collect();
    let mut started = Vec::new();
    for _ in 0..120 {
        step(&mut world);
        started.extend(take::<ContactStarted>(&mut world));
    }
    for (place, own) in all.iter().enumerate() {
        let error = (position(&world, *own) - DVec3::Y * (0.15 + 0.3 * place as f64)).length();
        assert!(error < 2e-3, "{place}: {}", position(&world, *own));
    }
    let mut pairs: Vec<_> = started.iter().map(|told| (told.a.min(told.b), told.a.max(told.b))).collect();
    pairs.sort_unstable();
    let mut expected = vec![(ground.min(all[0]), ground.max(all[0]))];
    expected.extend(all.windows(2).map(|pair| (pair[0].min(pair[1]), pair[0].max(pair[1]))));
    expected.sort_unstable();
    assert_eq!(pairs, expected);
    world.despawn(all[0]);
    step(&mut world);
    let ended = take::<ContactEnded>(&mut world);
    // What stood on it falls, and pushes nothing for a while.
    let with_it = ended.iter().filter(|told| [told.a, told.b].contains(&all[0])).count();
    assert_eq!(with_it, 2, "{ended:?}");
}

/// Shots at a sheet of 1 cm that is free to move, made of four slabs; those that are compounds themselves among them.
#[test]
fn nothing_that_is_shot_passes_a_sheet_of_slabs() {
    let mut dice = Pcg64Mcg::seed_from_u64(31);
    // They overlap: between solids that only touch there is a crack.
    let slab = |x: f64, z: f64| child(Collider::cuboid(3.3, 0.01, 3.3), DVec3::new(1.35 * x, 0.0, 1.35 * z));
    let slabs = [slab(-1.0, -1.0), slab(-1.0, 1.0), slab(1.0, -1.0), slab(1.0, 1.0)];
    let sheet = Collider::compound(&slabs).expect("a sheet");
    let bullets =
        [Collider::sphere(0.1), Collider::cuboid(0.2, 0.1, 0.3), halves(0.3, 0.1, 0.2), Collider::capsule(0.05, 0.3)];
    for case in 0..400 {
        let mut world = weightless(SolverSettings::game());
        let own_sheet = body(&mut world, sheet.clone(), DVec3::ZERO);
        world.entity_mut(own_sheet).insert(Mass(5000.0));
        let start = DVec3::new(dice.random_range(-2.0..2.0), dice.random_range(2.0..8.0), dice.random_range(-2.0..2.0));
        let own = body(&mut world, bullets[case % 4].clone(), start);
        let aside = DVec3::new(dice.random_range(-0.1..0.1), -1.0, dice.random_range(-0.1..0.1));
        let spin = DVec3::new(dice.random_range(-20.0..20.0), dice.random_range(-20.0..20.0), 0.0);
        let turned = DQuat::from_rotation_z(dice.random_range(-3.0..3.0));
        world.entity_mut(own).insert((Rotation(turned), Mass(1.0), Velocity { linear: aside * 400.0, angular: spin }));
        for _ in 0..6 {
            step(&mut world);
            let apart = position(&world, own) - position(&world, own_sheet);
            let local = world.get::<Rotation>(own_sheet).unwrap().0.inverse() * apart;
            // Its middle may get into the sheet, where it is pushed out again, but not past it.
            assert!(local.y > -0.005 || local.x.abs().max(local.z.abs()) > 3.0, "case {case}: {local}");
        }
    }
}

#[test]
fn what_makes_no_compound_is_told() {
    let error = |children: &[CompoundChild]| Collider::compound(children).unwrap_err();
    let ball = child(Collider::sphere(1.0), DVec3::ZERO);
    assert_eq!(error(&[]), CompoundError::Empty);
    assert_eq!(error(&[ball.clone(), child(Collider::half_space(), DVec3::ZERO)]), CompoundError::NoSolid { index: 1 });
    assert_eq!(error(&[child(halves(1.0, 1.0, 1.0), DVec3::ZERO)]), CompoundError::Nested { index: 0 });
    assert_eq!(error(&[ball, child(Collider::sphere(0.0), DVec3::ZERO)]), CompoundError::NotFinite { index: 1 });
    assert_eq!(error(&[child(Collider::sphere(1.0), DVec3::NAN)]), CompoundError::NotFinite { index: 0 });
}
