//! The shortest runs: a body falls, a pendulum swings.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

#[test]
fn a_free_body_falls_as_the_integrator_says() {
    let mut app = headless_app();
    let world = app.world_mut();
    world.insert_resource(SolverSettings::classic());
    let body = world.spawn((RigidBody::Dynamic, Collider::cuboid(1., 1., 1.), Transform::from_xyz(0., 4., 0.))).id();
    for _ in 0..60 {
        step(world);
    }
    // Euler with the new velocity: y = y0 - g h² n(n+1)/2.
    let expected = 4.0 - 9.81 / 3600.0 * 60.0 * 61.0 / 2.0;
    let y = world.get::<Position>(body).unwrap().y;
    assert!((y - expected).abs() < 1e-12, "{y} instead of {expected}");
    assert_eq!(world.get::<Mass>(body), Some(&Mass(1000.0)));
    let time = world.resource::<StepStats>().time;
    assert!((time - 1.0).abs() < 1e-15, "{time}");
}

#[test]
fn a_pendulum_stays_on_its_pivot() {
    for settings in [SolverSettings::classic(), SolverSettings::steady()] {
        let mut app = headless_app();
        let world = app.world_mut();
        world.insert_resource(settings);
        let post = world.spawn((RigidBody::Static, Transform::default())).id();
        let rod = world
            .spawn((RigidBody::Dynamic, Collider::cuboid(1., 0.1, 0.1), Mass(1.0), Transform::from_xyz(0.5, 0., 0.)))
            .id();
        let joint = world
            .spawn((
                BallJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::new(-0.5, 0., 0.)),
                JointLoad::default(),
            ))
            .id();
        for _ in 0..120 {
            step(world);
            let position = world.get::<Position>(rod).unwrap();
            assert!((position.length() - 0.5).abs() < 0.05, "{position:?}");
        }
        assert!(world.get::<JointLoad>(joint).unwrap().lambda > 1.0);
    }
}
