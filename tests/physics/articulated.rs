//! Trees of points, hinges and rigid joints, which `game` solves by articulated inertias, and joints that are still.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::StepStats;
use plumb::prelude::*;

use crate::rig::*;

/// What a joint of a tree has that nobody feels.
#[derive(Clone, Copy, PartialEq)]
enum Unfelt {
    Nothing,
    /// Limits that nothing reaches.
    Limits,
    /// Friction of next to nothing, which keeps it from being a tree of plain joints.
    Friction,
}

/// A tree of six boxes with a body of four joints, on a pin or free, and its joints.
fn tree(world: &mut World, is_pinned: bool, unfelt: Unfelt) -> ([Entity; 6], Vec<Entity>) {
    let at = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [-1.0, 0.0, 0.3], [0.0, -1.0, 0.0], [1.6, 1.0, 0.0], [1.0, -0.9, 0.4]];
    // All moments different, two equal about each axis, and all equal.
    let sizes = [[0.4, 0.5, 0.3], [0.4, 0.5, 0.5], [0.4, 0.4, 0.4], [0.5, 0.2, 0.5], [0.4, 0.5, 0.3], [0.3, 0.3, 0.6]];
    let bodies = [0, 1, 2, 3, 4, 5].map(|index: usize| {
        let [x, y, z] = sizes[index];
        let body = body(world, Collider::cuboid(x, y, z), DVec3::from(at[index]));
        world.entity_mut(body).insert(CollisionLayers::NONE);
        body
    });
    world
        .entity_mut(bodies[4])
        .insert((Mass(50.0), Velocity { linear: DVec3::new(3.0, -2.0, 4.0), angular: DVec3::Z }));
    let place = |body: usize| DVec3::from(at[body]);
    let anchors = |a: usize, b: usize| {
        let point = 0.5 * (place(a) + place(b)) + DVec3::Y * 0.1;
        [point - place(a), point - place(b)]
    };
    let hinge = |a: usize, b: usize, axis: DVec3| {
        let [on_a, on_b] = anchors(a, b);
        HingeJoint::new(bodies[a], bodies[b]).with_anchors(on_a, on_b).with_axis(axis)
    };
    let ball = |a: usize, b: usize| {
        let [on_a, on_b] = anchors(a, b);
        BallJoint::new(bodies[a], bodies[b]).with_anchors(on_a, on_b)
    };
    let limited = world.spawn(hinge(0, 1, DVec3::Z)).id();
    match unfelt {
        Unfelt::Nothing => {}
        Unfelt::Limits => _ = world.entity_mut(limited).insert(JointLimits::range(-1000.0, 1000.0)),
        Unfelt::Friction => _ = world.entity_mut(limited).insert(JointFriction(1e-12)),
    }
    let [on_a, on_b] = anchors(5, 1);
    let mut joints = vec![
        limited,
        // The child is A.
        world.spawn(hinge(2, 0, DVec3::new(1.0, 2.0, 2.0))).id(),
        world.spawn(ball(0, 3)).id(),
        world.spawn(hinge(1, 4, DVec3::X)).id(),
        world.spawn(FixedJoint::new(bodies[5], bodies[1]).with_anchors(on_a, on_b)).id(),
    ];
    if is_pinned {
        let pin = world.spawn((RigidBody::Static, Position(DVec3::Y * 0.5))).id();
        joints.push(world.spawn(HingeJoint::new(bodies[0], pin).with_anchors(DVec3::Y * 0.5, DVec3::ZERO)).id());
    }
    for &joint in &joints {
        world.entity_mut(joint).insert(JointLoad::default());
    }
    (bodies, joints)
}

#[test]
fn a_tree_goes_as_its_rows_say() {
    for is_pinned in [true, false] {
        let [one, limited, other] = [Unfelt::Nothing, Unfelt::Limits, Unfelt::Friction].map(|unfelt| {
            let mut world = if is_pinned { world_with(awake_game()) } else { weightless(awake_game()) };
            let (bodies, joints) = tree(&mut world, is_pinned, unfelt);
            let mut moved: f64 = 0.0;
            for _ in 0..60 {
                step(&mut world);
                moved = bodies.map(|body| spin(&world, body).length()).into_iter().fold(moved, f64::max);
            }
            assert!(moved > 0.2, "pinned {is_pinned}: {moved} rad/s");
            let loads: Vec<_> = joints.iter().map(|&joint| *world.get::<JointLoad>(joint).unwrap()).collect();
            (bodies.map(|body| (position(&world, body), spin(&world, body))), loads)
        });
        for ((at, spin), (known, turns)) in one.0.iter().zip(&other.0) {
            let (apart, turned) = ((*at - *known).length(), (*spin - *turns).length());
            assert!(apart < 2e-5 && turned < 2e-4, "pinned {is_pinned}: {apart:e} m, {turned:e} rad/s apart");
        }
        for ((at, spin), (known, turns)) in one.0.iter().zip(&limited.0) {
            let (apart, turned) = ((*at - *known).length(), (*spin - *turns).length());
            assert!(
                apart < 1e-11 && turned < 1e-10,
                "pinned {is_pinned}: {apart:e} m, {turned:e} rad/s with open limits"
            );
        }
        let most = other.1.iter().map(|load| load.lambda).fold(0.0, f64::max);
        for (load, known) in one.1.iter().zip(&other.1) {
            let apart = (load.force - known.force).length().max((load.torque - known.torque).length());
            assert!(apart < 1e-3 * most, "pinned {is_pinned}: {load:?} instead of {known:?}");
        }
    }
}

/// Momentum and energy of a tree that nothing holds.
#[test]
fn a_free_tree_keeps_its_momenta_and_energy() {
    let mut world = weightless(awake_game());
    tree(&mut world, false, Unfelt::Nothing);
    world.init_resource::<plumb::physics::Diagnostics>();
    step(&mut world);
    let told = |world: &World| *world.resource::<plumb::physics::Diagnostics>();
    let before = told(&world);
    for _ in 0..600 {
        step(&mut world);
        assert!(told(&world).joint_error < 1e-6, "{:e}", told(&world).joint_error);
    }
    let after = told(&world);
    let linear = (after.linear_momentum - before.linear_momentum).length();
    let angular = (after.angular_momentum - before.angular_momentum).length() / before.angular_momentum.length();
    let energy = (after.kinetic_energy / before.kinetic_energy - 1.0).abs();
    assert!(linear < 1e-9 && angular < 1e-3 && energy < 1e-2, "{linear:e} kg m/s, {angular:e}, {energy:e}");
}

/// A rope of hinges between two banks, straight but for its weight: left alone once it is still, until somebody changes
/// something.
#[test]
fn still_joints_cost_nothing_until_something_changes() {
    let hang = || {
        let mut world = world_with(awake_game());
        let plank = body(&mut world, Collider::cuboid(1.0, 0.1, 1.0), DVec3::ZERO);
        world.entity_mut(plank).insert(CollisionLayers::NONE);
        let joints = [-0.5, 0.5].map(|end| {
            let bank = world.spawn((RigidBody::Static, Position(DVec3::X * end))).id();
            let hinge = HingeJoint::new(bank, plank).with_anchors(DVec3::ZERO, DVec3::X * end).with_axis(DVec3::Z);
            world.spawn((hinge, JointLoad::default())).id()
        });
        (world, plank, joints)
    };
    let updates = |world: &World| world.resource::<StepStats>().row_updates;
    let (mut world, plank, joints) = hang();
    steps(&mut world, 60);
    assert_eq!(updates(&world), 0, "it is still");
    let load = world.get::<JointLoad>(joints[0]).unwrap().force.y;
    let mass = world.get::<Mass>(plank).map_or(100.0, |mass| mass.0);
    assert!((load / (0.5 * mass * G) - 1.0).abs() < 1e-6, "half its weight: {load} of {mass} kg");
    for change in 0..4 {
        let (mut world, plank, joints) = hang();
        steps(&mut world, 60);
        match change {
            0 => world.insert_resource(Gravity(DVec3::new(0.0, -20.0, 0.0))),
            1 => world.get_mut::<Velocity>(plank).unwrap().linear.y = 1.0,
            2 => _ = world.despawn(joints[1]),
            _ => {
                let mut hinge = *world.get::<HingeJoint>(joints[1]).unwrap();
                hinge.anchor_b.y += 0.01;
                world.entity_mut(joints[1]).insert(hinge);
            }
        }
        step(&mut world);
        assert!(updates(&world) > 0, "change {change}");
    }
}
