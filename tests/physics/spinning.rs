//! What spins fast on a plane, on ice or nearly so.

use std::f64::consts::FRAC_PI_2;

use bevy::math::{DQuat, DVec3};
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

/// How something starts.
struct Start {
    collider: Collider,
    height: f64,
    turned: DQuat,
    angular: DVec3,
}

/// The largest energy in 3 s, potential included, over that after the first step.
fn largest_energy(start: &Start, friction: f64, settings: SolverSettings) -> f64 {
    let mut world = world_with(settings);
    world.init_resource::<Diagnostics>();
    let ground = ground(&mut world);
    let body = body(&mut world, start.collider.clone(), DVec3::Y * start.height);
    for entity in [ground, body] {
        world.entity_mut(entity).insert(SurfaceMaterial { friction, ..SurfaceMaterial::default() });
    }
    world.entity_mut(body).insert((Rotation(start.turned), Velocity { angular: start.angular, ..Velocity::default() }));
    steps(&mut world, 1);
    let first = energy(&world);
    let count = (3.0 * settings.hz) as u32;
    let most = (1..count).map(|_| {
        steps(&mut world, 1);
        energy(&world)
    });
    most.fold(0.0, f64::max) / first
}

/// Whatever impulses do at one pose, turning on to the next one adds nothing: the spin goes along with the body. Left in the
/// world, it would come to four times the energy.
#[test]
fn what_spins_on_ice_gains_no_energy() {
    let lying = DQuat::from_rotation_z(FRAC_PI_2);
    let leaning = DQuat::from_rotation_x(1.287);
    for speed in [20.0, 28.0, 45.0] {
        let along = DVec3::new(speed, 0.01, 0.0);
        let starts = [
            Start { collider: Collider::capsule(0.13, 0.4), height: 0.13, turned: lying, angular: along },
            Start { collider: Collider::cylinder(0.13, 0.4), height: 0.13, turned: lying, angular: along },
            Start {
                collider: Collider::cylinder(0.3, 0.05),
                height: 0.32,
                turned: leaning,
                angular: DVec3::new(1.0, speed, 0.0),
            },
        ];
        for (start, friction, hz) in starts
            .iter()
            .flat_map(|start| [(0.0, 60.0), (0.0, 240.0), (0.05, 240.0)].map(|(friction, hz)| (start, friction, hz)))
        {
            let gained = largest_energy(start, friction, SolverSettings { hz, ..SolverSettings::game() }) - 1.0;
            assert!(gained < 0.01, "{:?} {speed} rad/s {friction} {hz} Hz: {gained:.3}", start.collider);
        }
    }
}
