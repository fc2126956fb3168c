//! What makes no sense is frozen and reported, and the rest goes on.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::{QuarantineReason, Softness};
use plumb::prelude::*;

use crate::rig::*;

#[derive(Resource, Default)]
struct Triggered(Vec<BodyQuarantined>);

/// A world with a ball that falls freely, far from everything else.
fn world_and_witness() -> (World, Entity) {
    let mut world = world_with(SolverSettings::steady());
    world.init_resource::<Triggered>();
    world.add_observer(|event: On<BodyQuarantined>, mut seen: ResMut<Triggered>| seen.0.push(*event.event()));
    let witness = body(&mut world, Collider::sphere(0.5), DVec3::new(100.0, 1000.0, 0.0));
    (world, witness)
}

/// Steps and checks that exactly that entity is reported in all three ways, and that the witness
/// goes on.
#[track_caller]
fn assert_quarantined(world: &mut World, witness: Entity, entity: Entity, reason: QuarantineReason) {
    take::<BodyQuarantined>(world);
    world.resource_mut::<Triggered>().0.clear();
    let falling = velocity(world, witness).y;
    let mut messages = Vec::new();
    for _ in 0..10 {
        step(world);
        messages.extend(take::<BodyQuarantined>(world));
    }
    let expected = [BodyQuarantined { entity, reason }];
    assert_eq!(messages, expected, "the message");
    assert_eq!(world.resource::<Triggered>().0, expected, "the entity event");
    assert_eq!(world.get::<Quarantined>(entity), Some(&Quarantined { reason }), "the component");
    assert_close(velocity(world, witness).y, falling - 9.81 / 6.0, 1e-9);
}

const PLACE: DVec3 = DVec3::new(1.0, 20.0, 3.0);

/// What is wrong with a body from its start.
#[track_caller]
fn assert_bad_body(wrong: impl Bundle, reason: QuarantineReason) {
    let (mut world, witness) = world_and_witness();
    let bad = body(&mut world, Collider::sphere(0.5), PLACE);
    world.entity_mut(bad).insert(wrong);
    assert_quarantined(&mut world, witness, bad, reason);
    assert_eq!(world.resource::<StepStats>().quarantined, 1);
    assert_eq!(position(&world, bad), PLACE, "frozen where it was put");
    assert_eq!(*world.get::<Velocity>(bad).unwrap(), Velocity::default());
}

#[test]
fn numbers_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY] {
        let vector = DVec3::new(0.0, bad, 0.0);
        assert_bad_body(Velocity { linear: vector, ..default() }, QuarantineReason::NotFinite);
        assert_bad_body(Velocity { angular: vector, ..default() }, QuarantineReason::NotFinite);
        assert_bad_body(ExternalForce { force: vector, ..default() }, QuarantineReason::NotFinite);
        assert_bad_body(ExternalForce { torque: vector, ..default() }, QuarantineReason::NotFinite);
        assert_bad_body(GravityScale(bad), QuarantineReason::NotFinite);
    }
}

#[test]
fn masses_and_sizes_that_are_not_positive() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_bad_body(Mass(bad), QuarantineReason::BadMass);
        assert_bad_body(Density(bad), QuarantineReason::BadMass);
        assert_bad_body(Inertia(DVec3::new(1.0, bad, 1.0)), QuarantineReason::BadMass);
        assert_bad_body(Collider::sphere(bad), QuarantineReason::BadMass);
        assert_bad_body(Collider::cuboid(1.0, bad, 1.0), QuarantineReason::BadMass);
        assert_bad_body(Collider::cone(1.0, bad), QuarantineReason::BadMass);
    }
    assert_bad_body(Collider::half_space(), QuarantineReason::BadMass);
    let (mut world, witness) = world_and_witness();
    let weightless = world.spawn((RigidBody::Dynamic, Position(PLACE))).id();
    assert_quarantined(&mut world, witness, weightless, QuarantineReason::BadMass);
}

#[test]
fn surfaces_out_of_range() {
    for friction in [-0.1, f64::NAN, f64::INFINITY] {
        assert_bad_body(SurfaceMaterial { friction, restitution: 0.0 }, QuarantineReason::BadMaterial);
    }
    for restitution in [-0.1, 1.1, f64::NAN] {
        assert_bad_body(SurfaceMaterial { friction: 0.5, restitution }, QuarantineReason::BadMaterial);
    }
    assert_bad_body(Damping { linear: -1.0, angular: 0.0 }, QuarantineReason::BadMaterial);
    assert_bad_body(Damping { linear: 0.0, angular: f64::NAN }, QuarantineReason::BadMaterial);
}

#[test]
fn a_body_with_a_parent() {
    let (mut world, witness) = world_and_witness();
    let parent = world.spawn(Transform::default()).id();
    let child = body(&mut world, Collider::sphere(0.5), PLACE);
    world.entity_mut(child).insert(ChildOf(parent));
    assert_quarantined(&mut world, witness, child, QuarantineReason::HasParent);
    assert_eq!(position(&world, child), PLACE);
}

#[test]
fn a_pose_that_is_not_finite_goes_back_to_the_last_that_was() {
    let spoil_position: fn(&mut World, Entity) = |world, body| world.get_mut::<Position>(body).unwrap().0.x = f64::NAN;
    let spoil_rotation: fn(&mut World, Entity) =
        |world, body| world.get_mut::<Rotation>(body).unwrap().0 = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let spoil_transform: fn(&mut World, Entity) =
        |world, body| world.get_mut::<Transform>(body).unwrap().translation.z = f32::INFINITY;
    for spoil in [spoil_position, spoil_rotation, spoil_transform] {
        let (mut world, witness) = world_and_witness();
        let bad = body(&mut world, Collider::sphere(0.5), PLACE);
        steps(&mut world, 10);
        let last = (position(&world, bad), world.get::<Rotation>(bad).unwrap().0);
        spoil(&mut world, bad);
        assert_quarantined(&mut world, witness, bad, QuarantineReason::NotFinite);
        assert_eq!((position(&world, bad), world.get::<Rotation>(bad).unwrap().0), last);
    }
}

#[test]
fn a_state_that_the_step_itself_makes_infinite() {
    let (mut world, witness) = world_and_witness();
    let bad = body(&mut world, Collider::sphere(0.5), PLACE);
    step(&mut world);
    let last = position(&world, bad);
    // A finite force on so small a mass.
    world.entity_mut(bad).insert((ExternalForce { force: DVec3::X * f64::MAX, ..default() }, Mass(1e-3)));
    assert_quarantined(&mut world, witness, bad, QuarantineReason::NotFinite);
    assert_eq!(position(&world, bad), last);
}

#[test]
fn joints_that_make_no_sense() {
    let soft = |frequency, damping_ratio, max_force| Softness { frequency, damping_ratio, max_force };
    let wrong: [(fn(Entity, Entity, Entity, Entity) -> BallJoint, QuarantineReason); 4] = [
        (|a, _, _, _| BallJoint::new(a, a), QuarantineReason::BadJoint),
        (|_, _, post, other| BallJoint::new(post, other), QuarantineReason::BadJoint),
        (|a, b, _, _| BallJoint::new(a, b).with_anchors(DVec3::NAN, DVec3::ZERO), QuarantineReason::NotFinite),
        (
            |a, b, _, _| BallJoint::new(a, b).with_anchors(DVec3::ZERO, DVec3::X * f64::INFINITY),
            QuarantineReason::NotFinite,
        ),
    ];
    for (make, reason) in wrong {
        let (mut world, witness) = world_and_witness();
        let [a, b] = [0.0, 5.0].map(|x| body(&mut world, Collider::sphere(0.5), PLACE + DVec3::X * x));
        let [post, other] = [0.0, 5.0].map(|z| world.spawn((RigidBody::Static, Position(DVec3::Z * z))).id());
        let joint = world.spawn(make(a, b, post, other)).id();
        assert_quarantined(&mut world, witness, joint, reason);
        assert!(velocity(&world, a).y < -1.0, "its bodies are free");
    }
    for softness in [soft(0.0, 1.0, 1.0), soft(f64::NAN, 1.0, 1.0), soft(1.0, -1.0, 1.0), soft(1.0, 1.0, -1.0)] {
        let (mut world, witness) = world_and_witness();
        let bad = body(&mut world, Collider::sphere(0.5), PLACE);
        let joint = world.spawn(BallJoint::new(witness, bad).with_softness(softness)).id();
        assert_quarantined(&mut world, witness, joint, QuarantineReason::NotFinite);
    }
}

#[test]
fn a_quarantined_body_holds_up_others_and_falls_on_once_mended() {
    let (mut world, _) = world_and_witness();
    let floating = body(&mut world, Collider::cuboid(2.0, 1.0, 2.0), DVec3::ZERO);
    world.entity_mut(floating).insert(SurfaceMaterial { friction: -1.0, restitution: 0.0 });
    let carried = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 1.05);
    run(&mut world, 1.0);
    assert_eq!(position(&world, floating), DVec3::ZERO);
    assert_close(position(&world, carried).y, 1.0, 0.01);

    // Removing the component without mending brings it back at once.
    take::<BodyQuarantined>(&mut world);
    world.entity_mut(floating).remove::<Quarantined>();
    steps(&mut world, 2);
    assert!(world.get::<Quarantined>(floating).is_some());

    world.entity_mut(floating).insert(SurfaceMaterial::default());
    step(&mut world);
    assert_eq!(position(&world, floating), DVec3::ZERO, "mended and not let go yet");
    world.entity_mut(floating).remove::<Quarantined>();
    run(&mut world, 1.0);
    assert!(position(&world, floating).y < -3.0 && position(&world, carried).y < -2.0);
    assert_eq!(world.resource::<StepStats>().quarantined, 0);
}

#[test]
fn what_changed_in_quarantine_is_not_missed() {
    let (mut world, _) = world_and_witness();
    let bad = body(&mut world, Collider::sphere(0.5), PLACE);
    step(&mut world);
    world.entity_mut(bad).insert((SurfaceMaterial { friction: -1.0, restitution: 0.0 }, Mass(7.0)));
    steps(&mut world, 2);
    world.entity_mut(bad).insert(Collider::cuboid(1.0, 2.0, 3.0));
    steps(&mut world, 2);
    world.entity_mut(bad).insert(SurfaceMaterial::default()).remove::<Quarantined>();
    steps(&mut world, 2);
    assert_near(world.get::<Inertia>(bad).unwrap().0, DVec3::new(13.0, 10.0, 5.0) * 7.0 / 12.0, 1e-12);
}

#[test]
fn a_mended_joint_holds_again() {
    let (mut world, _) = world_and_witness();
    let post = world.spawn((RigidBody::Static, Position(PLACE))).id();
    let hung = body(&mut world, Collider::sphere(0.1), PLACE - DVec3::Y);
    let joint = world.spawn(BallJoint::new(post, hung).with_anchors(DVec3::NAN, DVec3::Y)).id();
    step(&mut world);
    world.entity_mut(hung).insert((Velocity::default(), Position(PLACE - DVec3::Y)));
    world.get_mut::<BallJoint>(joint).unwrap().anchor_a = DVec3::ZERO;
    world.entity_mut(joint).remove::<Quarantined>();
    run(&mut world, 1.0);
    assert_near(position(&world, hung), PLACE - DVec3::Y, 0.01);
}
