//! Long runs leave memory and message buffers flat.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

/// Balls that bounce for ever (contacts start and end), a pendulum, a body that is thrown out
/// and replaced every now and then.
fn lively(world: &mut World) {
    ground(world);
    let elastic = SurfaceMaterial { friction: 0.0, restitution: 1.0 };
    for index in 0..4 {
        let ball = body(world, Collider::sphere(0.2), DVec3::new(f64::from(index), 0.5 + 0.1 * f64::from(index), 0.0));
        world.entity_mut(ball).insert((elastic, ReportCollisions, ObserveContacts));
    }
    let post = world.spawn((RigidBody::Static, Transform::from_xyz(0.0, 5.0, 5.0))).id();
    let bob = body(world, Collider::sphere(0.2), DVec3::new(1.0, 5.0, 5.0));
    world.spawn((BallJoint::new(post, bob).with_anchors(DVec3::ZERO, -DVec3::X), JointLoad::default()));
}

fn buffered(world: &World) -> usize {
    world.resource::<Messages<ContactStarted>>().len()
        + world.resource::<Messages<ContactEnded>>().len()
        + world.resource::<Messages<Collision>>().len()
        + world.resource::<Messages<BodyQuarantined>>().len()
}

#[test]
fn ten_thousand_steps_leave_buffers_and_memory_flat() {
    let mut world = world_with(SolverSettings { restitution_speed: Some(0.0), ..SolverSettings::steady() });
    lively(&mut world);
    let (mut started, mut most) = (0, 0);
    let mut advance = |world: &mut World, count: u32| {
        for index in 0..count {
            if index % 100 == 0 {
                // A box that is gone again after fifty steps, while it touches the ground.
                let passing = body(world, Collider::cuboid(0.4, 0.4, 0.4), DVec3::new(-3.0, 0.3, 0.0));
                world.entity_mut(passing).insert(Name::new("passing"));
            } else if index % 100 == 50 {
                let mut named = world.query_filtered::<Entity, With<Name>>();
                let passing = named.single(world).unwrap();
                world.despawn(passing);
            }
            step(world);
            // Each message lives for two steps.
            started += world.resource::<Messages<ContactStarted>>().len();
            most = most.max(buffered(world));
        }
    };
    advance(&mut world, 2_000);
    let memory = allocation_counter::measure(|| advance(&mut world, 8_000));
    assert!(started > 1_000, "{started} contacts began: too few to prove it");
    assert!(most < 200, "{most} messages wait");
    // Room for a buffer that reaches a new peak; a leak of one byte a step would show.
    assert!(memory.bytes_current < 8_000, "{} bytes more after 8000 steps", memory.bytes_current);
    assert!(memory.count_current < 50, "{} allocations more after 8000 steps", memory.count_current);
}
