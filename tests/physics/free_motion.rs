//! Bodies that touch nothing: integrators, forces, drag, locks, kinematic motion, mass.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

fn with_integrator(integrator: Integrator) -> SolverSettings {
    let classic = SolverSettings::classic();
    SolverSettings { sweeps: SweepSettings { integrator, ..classic.sweeps }, ..classic }
}

#[test]
fn velocity_verlet_falls_exactly() {
    for substeps in [1, 3] {
        let mut world = world_with(SolverSettings { substeps, ..with_integrator(Integrator::VelocityVerlet) });
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::new(0.0, 100.0, 0.0));
        world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::new(3.0, 2.0, 0.0);
        run(&mut world, 2.0);
        assert_near(position(&world, ball), DVec3::new(6.0, 100.0 + 4.0 - 0.5 * 9.81 * 4.0, 0.0), 1e-11);
        assert_near(velocity(&world, ball), DVec3::new(3.0, 2.0 - 9.81 * 2.0, 0.0), 1e-11);
    }
}

#[test]
fn euler_falls_half_a_step_too_far() {
    for hz in [30.0, 60.0, 240.0] {
        let mut world = world_with(SolverSettings { hz, ..with_integrator(Integrator::Euler) });
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
        run(&mut world, 2.0);
        // x = −g h² n(n+1)/2 = −½ g t² − ½ g t h.
        assert_close(position(&world, ball).y, -0.5 * 9.81 * (4.0 + 2.0 / hz), 1e-11);
    }
}

#[test]
fn a_ball_keeps_its_spin_and_a_unit_quaternion() {
    for integrator in [Integrator::Euler, Integrator::VelocityVerlet] {
        let mut world = weightless(with_integrator(integrator));
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
        let omega = DVec3::new(3.0, -7.0, 20.0);
        world.get_mut::<Velocity>(ball).unwrap().angular = omega;
        for _ in 0..10_000 {
            step(&mut world);
            let length = world.get::<Rotation>(ball).unwrap().length();
            assert_close(length, 1.0, 1e-12);
        }
        assert_eq!(spin(&world, ball), omega);
    }
}

#[test]
fn a_spin_turns_by_its_rate() {
    let mut world = weightless(SolverSettings { hz: 1000.0, ..SolverSettings::classic() });
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    world.get_mut::<Velocity>(ball).unwrap().angular = DVec3::new(0.0, 2.0, 0.0);
    run(&mut world, 1.0);
    let turned = world.get::<Rotation>(ball).unwrap().0 * DVec3::X;
    // A step turns by 2 atan(hω/2), short of hω by (hω)³/12: 7e-7 rad in all.
    assert_near(turned, DVec3::new(2.0_f64.cos(), 0.0, -(2.0_f64.sin())), 1e-6);
}

#[test]
fn locked_axes_do_not_move() {
    let mut world = world_with(SolverSettings::steady());
    let lock = LockedAxes { translation: [false, true, false], rotation: [true, false, true] };
    let start = DVec3::new(0.0, 0.3, 0.0);
    let force = ExternalForce { force: DVec3::splat(500.0), torque: DVec3::splat(90.0) };
    let velocity = Velocity { linear: DVec3::new(1.0, 5.0, 0.0), angular: DVec3::new(2.0, 1.0, 3.0) };
    // Skewed on the locked axes, so that the inertia couples all three.
    let rotation = Rotation(bevy::math::DQuat::from_rotation_y(0.5));
    let locked = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.4, 2.0), Position(start), rotation);
    let locked = world.spawn((locked, lock, force, velocity)).id();
    ground(&mut world);
    let hammer = body(&mut world, Collider::sphere(0.3), DVec3::new(0.3, 1.2, 0.4));
    run(&mut world, 1.0);
    assert_eq!(position(&world, locked).y, start.y);
    assert!(position(&world, locked).x > 1.0 && position(&world, locked).z > 0.1);
    let turn = world.get::<Rotation>(locked).unwrap().0;
    assert_near(turn * DVec3::Y, DVec3::Y, 1e-12);
    assert!(spin(&world, locked).y.abs() > 0.1);
    assert!(position(&world, hammer).y < 1.0, "the hammer fell on it");
}

#[test]
fn drag_and_damping_divide_the_velocity() {
    let mut world = weightless(SolverSettings { drag: 0.5, ..SolverSettings::classic() });
    let plain = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    let damped = body(&mut world, Collider::sphere(0.5), DVec3::X * 9.0);
    world.entity_mut(damped).insert(Damping { linear: 1.0, angular: 2.0 });
    for ball in [plain, damped] {
        *world.get_mut::<Velocity>(ball).unwrap() = Velocity { linear: DVec3::Z, angular: DVec3::Y };
    }
    run(&mut world, 1.0);
    let left = |rate: f64| (1.0 + rate / 60.0).powi(-60);
    assert_close(velocity(&world, plain).z, left(0.5), 1e-12);
    assert_close(spin(&world, plain).y, left(0.5), 1e-12);
    assert_close(velocity(&world, damped).z, left(1.5), 1e-12);
    assert_close(spin(&world, damped).y, left(2.5), 1e-12);
}

#[test]
fn gravity_scale_scales_gravity() {
    let mut world = world_with(SolverSettings::classic());
    for scale in [0.0, 0.5, -1.0] {
        let ball = body(&mut world, Collider::sphere(0.1), DVec3::X * scale * 10.0);
        world.entity_mut(ball).insert(GravityScale(scale));
    }
    run(&mut world, 1.0);
    let mut balls = world.query::<(&GravityScale, &Velocity)>();
    for (scale, velocity) in balls.iter(&world) {
        assert_near(velocity.linear, DVec3::Y * -9.81 * scale.0, 1e-12);
    }
}

#[test]
fn external_force_lasts_until_changed() {
    let mut world = weightless(SolverSettings::classic());
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    let push = ExternalForce { force: DVec3::new(4.0, 0.0, 0.0), torque: DVec3::new(0.0, 0.3, 0.0) };
    world.entity_mut(ball).insert((Mass(2.0), push));
    run(&mut world, 1.0);
    // I = 2/5 m r² = 0.2.
    assert_near(velocity(&world, ball), DVec3::X * 2.0, 1e-12);
    assert_near(spin(&world, ball), DVec3::Y * 1.5, 1e-12);
    world.entity_mut(ball).remove::<ExternalForce>();
    run(&mut world, 1.0);
    assert_near(velocity(&world, ball), DVec3::X * 2.0, 1e-12);
}

#[test]
fn a_kinematic_body_moves_by_its_velocity_pushes_and_is_not_pushed() {
    let mut world = world_with(SolverSettings { drag: 1.0, ..SolverSettings::steady() });
    ground(&mut world);
    let velocity_of_pusher = Velocity { linear: DVec3::new(1.0, 0.0, 0.0), angular: DVec3::new(0.0, 0.0, 0.0) };
    let pusher = (RigidBody::Kinematic, Collider::cuboid(1.0, 1.0, 1.0), Position(DVec3::new(0.0, 0.6, 0.0)));
    let pusher = world.spawn((pusher, velocity_of_pusher)).id();
    let pushed = body(&mut world, Collider::cuboid(0.5, 0.5, 0.5), DVec3::new(1.0, 0.25, 0.0));
    let dropped = body(&mut world, Collider::cuboid(0.5, 0.5, 0.5), DVec3::new(0.0, 1.5, 0.0));
    run(&mut world, 2.0);
    assert_near(position(&world, pusher), DVec3::new(2.0, 0.6, 0.0), 1e-12);
    assert_eq!(*world.get::<Velocity>(pusher).unwrap(), velocity_of_pusher);
    // Pushed by the face at x = 2.5 that it lies against.
    assert_close(position(&world, pushed).x, 2.75, 0.01);
    assert!(position(&world, dropped).y > 1.0, "{}", position(&world, dropped));
}

#[test]
fn a_kinematic_body_turns_by_its_velocity() {
    let mut world = world_with(SolverSettings::steady());
    let wheel = world.spawn((RigidBody::Kinematic, Collider::cuboid(1.0, 2.0, 3.0), Transform::default())).id();
    world.get_mut::<Velocity>(wheel).unwrap().angular = DVec3::new(0.0, 0.0, 1.0);
    run(&mut world, 1.0);
    let turned = world.get::<Rotation>(wheel).unwrap().0 * DVec3::X;
    assert_near(turned, DVec3::new(1.0_f64.cos(), 1.0_f64.sin(), 0.0), 1e-5);
}

#[test]
fn mass_follows_collider_and_density_unless_given() {
    let mut world = weightless(SolverSettings::classic());
    let computed = body(&mut world, Collider::cuboid(1.0, 2.0, 3.0), DVec3::ZERO);
    let given = body(&mut world, Collider::cuboid(1.0, 2.0, 3.0), DVec3::X * 9.0);
    world.entity_mut(given).insert((Mass(12.0), Density(3.0)));
    step(&mut world);
    let mass = |world: &World, body| world.get::<Mass>(body).unwrap().0;
    let inertia = |world: &World, body| world.get::<Inertia>(body).unwrap().0;
    assert_eq!(mass(&world, computed), 6000.0);
    assert_near(inertia(&world, computed), DVec3::new(6500.0, 5000.0, 2500.0), 1e-9);
    assert_eq!(mass(&world, given), 12.0);
    assert_near(inertia(&world, given), DVec3::new(13.0, 10.0, 5.0), 1e-12);

    for entity in [computed, given] {
        world.entity_mut(entity).insert((Collider::cuboid(2.0, 2.0, 3.0), Density(500.0)));
    }
    steps(&mut world, 2);
    assert_eq!(mass(&world, computed), 6000.0);
    assert_near(inertia(&world, computed), DVec3::new(6500.0, 6500.0, 4000.0), 1e-9);
    assert_eq!(mass(&world, given), 12.0);
    assert_near(inertia(&world, given), DVec3::new(13.0, 13.0, 8.0), 1e-12);

    // Changed while it was no dynamic body.
    world.entity_mut(computed).insert(RigidBody::Kinematic);
    step(&mut world);
    world.entity_mut(computed).insert(Density(1.0));
    step(&mut world);
    world.entity_mut(computed).insert(RigidBody::Dynamic);
    step(&mut world);
    assert_eq!(mass(&world, computed), 12.0);
}
