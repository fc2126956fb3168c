//! Convex hulls as bodies: they move as the solids they are.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::HullError;
use plumb::prelude::*;

use crate::rig::*;

fn box_corners(size: DVec3) -> Vec<DVec3> {
    let signs = [-0.5, 0.5];
    signs.iter().flat_map(|&x| signs.map(|y| signs.map(|z| DVec3::new(x, y, z) * size))).flatten().collect()
}

#[test]
fn a_hull_of_a_boxs_corners_tumbles_as_the_box() {
    let size = DVec3::new(1.0, 0.6, 0.2);
    let torque = ExternalForce { torque: DVec3::new(3.0, 20.0, -8.0), ..default() };
    let spin = DVec3::new(0.01, 10.0, 0.3);
    let askew = DQuat::from_euler(bevy::math::EulerRot::XYZ, 0.3, 0.2, -0.4);
    // As the box lies, and as it would lie in the frame of some mesh.
    for (turn, place) in [(DQuat::IDENTITY, DVec3::ZERO), (askew, DVec3::new(3.0, -4.0, 5.0))] {
        let mut world = weightless(SolverSettings::default());
        let cuboid = body(&mut world, Collider::cuboid(size.x, size.y, size.z), DVec3::ZERO);
        let points: Vec<DVec3> = box_corners(size).into_iter().map(|corner| place + turn * corner).collect();
        let collider = Collider::convex_hull(&points).unwrap();
        let plumb::physics::Shape::Hull(hull) = collider.shape() else { panic!("a hull") };
        // Placed so that its corners are where the cuboid's are.
        let rotation = turn.inverse() * hull.axes();
        let hull = body(&mut world, collider, DVec3::new(10.0, 0.0, 0.0));
        world.entity_mut(hull).insert(Rotation(rotation));
        for entity in [cuboid, hull] {
            world.get_mut::<Velocity>(entity).unwrap().angular = spin;
            world.entity_mut(entity).insert(torque);
        }
        run(&mut world, 3.0);
        let [cuboid, hull] = [cuboid, hull]
            .map(|entity| (world.get::<Rotation>(entity).unwrap().0, world.get::<Velocity>(entity).unwrap().angular));
        assert_near(hull.1, cuboid.1, 1e-7);
        let apart = (hull.0 * rotation.inverse()).angle_between(cuboid.0);
        assert!(apart < 1e-7, "turned {apart} rad from the cuboid");
        assert!(cuboid.1.distance(spin) > 0.1, "the torque turns it");
    }
}

#[test]
fn a_hull_weighs_what_it_holds() {
    let mut world = weightless(SolverSettings::default());
    // A tetrahedron of a cubic metre; the default density is water's.
    let corners = [DVec3::ZERO, 2.0 * DVec3::X, 3.0 * DVec3::Y, DVec3::Z];
    let tetrahedron = body(&mut world, Collider::convex_hull(&corners).unwrap(), DVec3::ZERO);
    step(&mut world);
    assert_close(world.get::<Mass>(tetrahedron).unwrap().0, 1000.0, 1e-9);
}

#[test]
fn hulls_come_to_rest_on_the_ground_and_on_each_other() {
    let mut world = world_with(SolverSettings::default());
    ground(&mut world);
    // A wedge, a plate, and a lump of twenty points around a ball.
    let wedge = [[-0.5, 0.0], [0.5, 0.0], [0.5, 0.6]].map(|[x, y]| [-0.5, 0.5].map(|z| DVec3::new(x, y, z))).concat();
    let plate = box_corners(DVec3::new(1.5, 0.05, 1.5));
    let lump: Vec<DVec3> = (0..20)
        .map(|i| {
            let (y, turn) = (f64::from(i).mul_add(0.1, -0.95), 2.4 * f64::from(i));
            let rim = (1.0 - y * y).sqrt();
            0.4 * DVec3::new(rim * turn.cos(), y, rim * turn.sin())
        })
        .collect();
    let bodies = [(wedge, 0.5), (plate, 1.2), (lump, 2.0)].map(|(points, height)| {
        let lean = Rotation(DQuat::from_rotation_z(0.05));
        let entity = body(&mut world, Collider::convex_hull(&points).unwrap(), DVec3::new(0.0, height, 0.0));
        world.entity_mut(entity).insert(lean);
        entity
    });
    run(&mut world, 6.0);
    for entity in bodies {
        assert!(clearance(&world, entity) > -0.01, "{} m in the ground", -clearance(&world, entity));
        assert!(velocity(&world, entity).length() < 0.05, "still at {} m/s", velocity(&world, entity).length());
    }
}

#[test]
fn points_without_a_volume_are_no_collider() {
    let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    assert_eq!(Collider::convex_hull(&square), Err(HullError::Flat { count: 4 }));
}
