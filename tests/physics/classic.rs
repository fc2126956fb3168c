//! The 2009 method against numbers worked out by hand from its equation (DESIGN.md, section 4).

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

const H: f64 = 1.0 / 60.0;
/// Rows are solved in `f64`: the numbers hold to rounding.
const ROUNDING: f64 = 1e-11;

fn classic() -> SolverSettings {
    SolverSettings { precision: Precision::F64, ..SolverSettings::classic() }
}

#[test]
fn four_sweeps_from_zero_share_a_load_as_gauss_seidel_does() {
    // Two balls of 1 kg hang one under the other. Vertical rows: λ₁ = g + λ₂ for the upper joint,
    // λ₂ = λ₁/2 for the lower one. From zero, in that order, four sweeps give λ₁ = 15/8 g and
    // λ₂ = 15/16 g of the exact 2 g and g.
    let mut world = world_with(classic());
    let post = world.spawn((RigidBody::Static, Transform::default())).id();
    let upper = body(&mut world, Collider::sphere(0.1), DVec3::Y * -1.0);
    let lower = body(&mut world, Collider::sphere(0.1), DVec3::Y * -2.0);
    for ball in [upper, lower] {
        world.entity_mut(ball).insert(Mass(1.0));
    }
    let hang = |a, b| (BallJoint::new(a, b).with_anchors(DVec3::Y * -0.5, DVec3::Y * 0.5), JointLoad::default());
    let first = world.spawn(hang(post, upper)).id();
    let second = world.spawn(hang(upper, lower)).id();
    step(&mut world);
    let load = |joint| world.get::<JointLoad>(joint).unwrap().force;
    assert_near(load(first), DVec3::Y * 15.0 / 8.0 * G, ROUNDING);
    assert_near(load(second), DVec3::Y * 15.0 / 16.0 * G, ROUNDING);
    for ball in [upper, lower] {
        assert_near(velocity(&world, ball), DVec3::Y * (-G / 16.0 * H), ROUNDING);
    }
}

#[test]
fn a_rods_first_step_on_its_pivot() {
    let mut world = world_with(classic());
    let post = world.spawn((RigidBody::Static, Transform::default())).id();
    let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), DVec3::X * 0.5);
    world.entity_mut(rod).insert(Mass(1.0));
    world.spawn(BallJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::X * -0.5));
    step(&mut world);
    // Only the vertical row works: J M⁻¹Jᵀ = 1/m + ¼/I, λ = g/(J M⁻¹Jᵀ).
    let inertia = (1.0 + 0.01) / 12.0;
    let lambda = G / (1.0 + 0.25 / inertia);
    let omega = -0.5 * lambda / inertia * H;
    let v = (lambda - G) * H;
    assert_near(velocity(&world, rod), DVec3::Y * v, ROUNDING);
    assert_near(spin(&world, rod), DVec3::Z * omega, ROUNDING);
    // Positions with the new velocities.
    assert_near(position(&world, rod), DVec3::new(0.5, v * H, 0.0), ROUNDING);
    let turned = world.get::<Rotation>(rod).unwrap().0;
    let expected = DQuat::from_rotation_z(2.0 * (0.5 * H * omega).atan());
    assert!(turned.dot(expected) > 1.0 - 1e-15 && (turned.z - expected.z).abs() < ROUNDING, "{turned}");
}

#[test]
fn a_parted_joint_closes_at_its_share_of_the_gap() {
    // β h = 0.35 of the error in a step, and no slop.
    let mut world = weightless(classic());
    let post = world.spawn((RigidBody::Static, Transform::default())).id();
    let ball = body(&mut world, Collider::sphere(0.1), DVec3::new(0.002, -0.004, 0.006));
    world.spawn(BallJoint::new(post, ball));
    step(&mut world);
    assert_near(position(&world, ball), DVec3::new(0.002, -0.004, 0.006) * 0.65, ROUNDING);
}

/// A ball of radius 0.5 and 3 kg that overlaps the ground by `depth`.
fn ball_in_ground(world: &mut World, depth: f64) -> Entity {
    ground(world);
    let ball = body(world, Collider::sphere(0.5), DVec3::Y * (0.5 - depth));
    world.entity_mut(ball).insert(Mass(3.0));
    ball
}

#[test]
fn overlap_is_pushed_out_beyond_the_slop_and_let_in_up_to_it() {
    // v = β(depth − slop), β = 0.35/h = 21/s, slop 1 cm, not clamped at zero.
    for (depth, expected) in [(0.03, 0.42), (0.01, 0.0), (0.004, -0.126)] {
        let mut world = world_with(classic());
        let ball = ball_in_ground(&mut world, depth);
        step(&mut world);
        assert_near(velocity(&world, ball), DVec3::Y * expected, ROUNDING);
        assert_close(position(&world, ball).y, 0.5 - depth + expected * H, ROUNDING);
    }
    // At 0.2 mm of overlap it may fall at 0.2058 m/s, and has fallen at g h = 0.1635 only.
    let mut world = world_with(classic());
    let ball = ball_in_ground(&mut world, 0.0002);
    step(&mut world);
    assert_near(velocity(&world, ball), DVec3::Y * (-G * H), ROUNDING);
}

/// Poses go out of their errors by the share of each sweep, and no velocity comes of it.
#[test]
fn nonlinear_projection_moves_poses_and_leaves_velocities() {
    let projected = |baumgarte| {
        let settings = classic();
        let sweeps = SweepSettings { baumgarte, nonlinear_projection: true, ..settings.sweeps };
        SolverSettings { sweeps, ..settings }
    };
    for baumgarte in [0.1_f64, 0.35, 1.0] {
        let left = (1.0 - baumgarte).powi(4);
        for (depth, ends) in [(0.03, 0.01 + 0.02 * left), (0.004, 0.004)] {
            let mut world = world_with(projected(baumgarte));
            let ball = ball_in_ground(&mut world, depth);
            step(&mut world);
            assert_near(velocity(&world, ball), DVec3::ZERO, ROUNDING);
            assert_close(position(&world, ball).y, 0.5 - ends, ROUNDING);
        }
        let mut world = weightless(projected(baumgarte));
        let post = world.spawn((RigidBody::Static, Transform::default())).id();
        let parted = DVec3::new(0.002, -0.004, 0.006);
        let ball = body(&mut world, Collider::sphere(0.1), parted);
        world.spawn(BallJoint::new(post, ball));
        step(&mut world);
        assert_near(velocity(&world, ball), DVec3::ZERO, ROUNDING);
        assert_near(position(&world, ball), parted * left, ROUNDING);
    }
}

/// A slanting rod off its pivot goes back by turning and moving. Its rows hang on each other: each sees what those before
/// it have moved, or twelve sweeps would leave 10 µm.
#[test]
fn nonlinear_projection_turns_bodies_back_onto_their_joints() {
    let settings = SolverSettings { iterations: 12, ..classic() };
    let sweeps = SweepSettings { baumgarte: 1.0, nonlinear_projection: true, ..settings.sweeps };
    let mut world = weightless(SolverSettings { sweeps, ..settings });
    let post = world.spawn((RigidBody::Static, Transform::default())).id();
    let slant = DQuat::from_rotation_z(45_f64.to_radians());
    // By 4 mm along itself, and 5 mm across.
    let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), slant * DVec3::new(0.504, 0.005, 0.0));
    world.entity_mut(rod).insert(Rotation(slant));
    world.spawn(BallJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::X * -0.5));
    step(&mut world);
    let turned = world.get::<Rotation>(rod).unwrap().0;
    let anchor = position(&world, rod) + turned * (DVec3::X * -0.5);
    assert!(anchor.length() < 1e-6, "{anchor}");
    assert_near(velocity(&world, rod), DVec3::ZERO, ROUNDING);
    assert_near(spin(&world, rod), DVec3::ZERO, ROUNDING);
    // What the end goes across it goes by the turn, but for what the centre moves: as the masses there share it.
    let inertia = (1.0 + 0.01) / 12.0;
    let share = 0.25 / inertia / (1.0 + 0.25 / inertia);
    let angle = (slant.inverse() * turned).to_scaled_axis().z;
    assert!((angle / (0.005 * share / 0.5) - 1.0).abs() < 0.02, "{angle} rad");
}

#[test]
fn contacts_push_and_never_pull() {
    let mut world = world_with(classic());
    let ball = ball_in_ground(&mut world, 0.01);
    world.get_mut::<Velocity>(ball).unwrap().linear.y = 2.0;
    step(&mut world);
    assert_near(velocity(&world, ball), DVec3::Y * (2.0 - G * H), ROUNDING);
}

#[test]
fn a_box_on_one_corner_turns_by_its_arm() {
    // One contact point: λ = (bias/h + g)/(1/m + (r×n)ᵀI⁻¹(r×n)) for a body at rest.
    let mut world = world_with(classic());
    ground(&mut world);
    let size = DVec3::new(1.0, 2.0, 3.0);
    let rotation = DQuat::from_rotation_x(0.6) * DQuat::from_rotation_z(0.8);
    let down = rotation.inverse() * DVec3::NEG_Y;
    let corner = rotation * (down.signum() * size / 2.0);
    let depth = 0.02;
    let tilted = world
        .spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 2.0, 3.0), Position(DVec3::Y * (-corner.y - depth))))
        .insert((Rotation(rotation), Mass(12.0)))
        .id();
    step(&mut world);
    let inertia = DVec3::new(13.0, 10.0, 5.0);
    let arm = corner.cross(DVec3::Y);
    let turn = rotation * ((rotation.inverse() * arm) / inertia);
    let lambda = (21.0 * (depth - 0.01) / H + G) / (1.0 / 12.0 + arm.dot(turn));
    assert_near(velocity(&world, tilted), DVec3::Y * (lambda / 12.0 - G) * H, 1e-9);
    assert_near(spin(&world, tilted), turn * lambda * H, 1e-9);
}

#[test]
fn friction_is_bounded_by_weight_whatever_the_normal_force() {
    // |λ| ≤ μ m_c g on one tangent against the slip; the static partner counts as 3 kg too.
    for load in [0.0, 300.0] {
        let mut world = world_with(classic());
        let ball = ball_in_ground(&mut world, 0.01);
        world.entity_mut(ball).insert(ExternalForce { force: DVec3::Y * -load, ..default() });
        world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::new(3.0, 0.0, 4.0);
        step(&mut world);
        let friction = 0.6 * 3.0 * G;
        let against = DVec3::new(-0.6, 0.0, -0.8);
        assert_near(velocity(&world, ball), against * (friction / 3.0 * H - 5.0), ROUNDING);
        // r × F with r = −0.49 y, I = 2/5 · 3 · ¼ = 0.3.
        assert_near(spin(&world, ball), (DVec3::Y * -0.49).cross(against * friction) / 0.3 * H, ROUNDING);
    }
}

#[test]
fn friction_grows_with_the_number_of_contacts() {
    let mut world = world_with(classic());
    ground(&mut world);
    let slider = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.49);
    let upright = LockedAxes { rotation: [true; 3], ..default() };
    world.entity_mut(slider).insert((upright, Velocity { linear: DVec3::X * 5.0, ..default() }));
    step(&mut world);
    assert_eq!(world.resource::<StepStats>().contact_points, 4);
    // Coulomb's law would take 0.6 g h; four corners take four times that.
    assert_close(velocity(&world, slider).x, 5.0 - 4.0 * 0.6 * G * H, 1e-9);
}

#[test]
fn slow_slip_makes_no_friction_row() {
    for (slip, rows) in [(0.9e-6, 1), (1.1e-6, 2)] {
        let mut world = world_with(classic());
        let ball = ball_in_ground(&mut world, 0.01);
        world.get_mut::<Velocity>(ball).unwrap().linear.x = slip;
        step(&mut world);
        assert_eq!(world.resource::<StepStats>().rows, rows, "at a slip of {slip} m/s");
    }
}

#[test]
fn lagging_contacts_answer_one_step_late() {
    for (contact_lag, late) in [(0, 0), (1, 1)] {
        let mut world =
            world_with(SolverSettings { sweeps: SweepSettings { contact_lag, ..classic().sweeps }, ..classic() });
        ground(&mut world);
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::Y * 0.7);
        let mut falling = 0.0;
        while world.resource::<StepStats>().contact_points == 0 {
            falling = velocity(&world, ball).y;
            step(&mut world);
            assert!(world.resource::<StepStats>().steps < 60, "it falls through the ground");
        }
        // The step that found the contact has run.
        for _ in 0..late {
            falling -= G * H;
            assert_close(velocity(&world, ball).y, falling, ROUNDING);
            step(&mut world);
        }
        assert!(velocity(&world, ball).y > falling + 0.5, "no answer to the contact");
    }
}

#[test]
fn nothing_bounces() {
    let mut world = world_with(classic());
    let ball = ball_in_ground(&mut world, 0.01);
    let bouncy = SurfaceMaterial { restitution: 1.0, ..default() };
    world.entity_mut(ball).insert((bouncy, Velocity { linear: DVec3::Y * -5.0, ..default() }));
    step(&mut world);
    assert_near(velocity(&world, ball), DVec3::ZERO, ROUNDING);
}
