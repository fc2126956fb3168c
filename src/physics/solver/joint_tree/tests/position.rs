//! Drift and projection.

use nalgebra::{UnitQuaternion, Vector3};

use super::{Assembly, assemblies};
use crate::physics::testing::Random;

#[test]
fn projection_closes_every_joint() {
    let random = &mut Random::new(5);
    for mut assembly in assemblies(random) {
        // A hanging loop through the ground may have no closed pose within reach.
        let trees = assembly.trees().into_iter().filter(|tree| !tree.may_be_redundant());
        for mut tree in trees.collect::<Vec<_>>() {
            let separations = Assembly::of_joints(&tree, &assembly.separations);
            let left = tree.project_positions(&separations, 20, 1e-14);
            assert!(left < 1e-12, "reports {left:e}");
            for (local, change) in tree.pose_changes().enumerate() {
                assembly.turn(tree.bodies()[local], change.linear, &change.rotation);
            }
            for &joint in tree.joints() {
                let separation = assembly.separations[joint as usize].norm();
                assert!(separation < 1e-12, "joint {joint}: {separation:e}");
            }
        }
    }
}

#[test]
fn projection_conserves_the_centre_of_mass() {
    let random = &mut Random::new(6);
    let assembly = Assembly::tree(20, random, |body, random| (random.unit() * f64::from(body)) as u32);
    let mut tree = assembly.trees().remove(0);
    tree.project_positions(&Assembly::of_joints(&tree, &assembly.separations), 5, 0.0);
    let bodies = tree.bodies().to_vec();
    let moved: Vector3<f64> = tree
        .pose_changes()
        .zip(&bodies)
        .map(|(change, &body)| change.linear / assembly.inverse_masses[body as usize].x)
        .sum();
    assert!(moved.norm() < 1e-12, "{:e}", moved.norm());
}

#[test]
fn a_drift_after_an_aimed_solve_ends_on_the_joints_to_third_order() {
    let random = &mut Random::new(13);
    let mut assembly = Assembly::tree(10, random, |body, random| (random.unit() * f64::from(body)) as u32);
    assembly.targets.fill(Vector3::zeros());
    assembly.separations.fill(Vector3::zeros());
    // Velocities that the joints allow, as after the substep before.
    assembly.solve();
    let missed = |h: f64| {
        let mut tree = assembly.trees().remove(0);
        let mut twists: Vec<_> = tree.bodies().iter().map(|&body| assembly.twists[body as usize]).collect();
        let mut targets = vec![Vector3::zeros(); tree.joints().len()];
        tree.aim(&twists, h, &mut targets);
        tree.solve_velocities(&mut twists, &targets);
        let mut moved = assembly.clone();
        for (&body, twist) in tree.bodies().iter().zip(&twists) {
            moved.turn(body, twist.linear * h, &UnitQuaternion::from_scaled_axis(twist.angular * h));
        }
        moved.separations.iter().map(|separation| separation.norm()).fold(0.0, f64::max)
    };
    let order = (missed(1e-3) / missed(5e-4)).log2();
    assert!((order - 3.0).abs() < 0.1, "order {order}");
}

#[test]
fn a_projection_that_opens_joints_is_taken_back() {
    let random = &mut Random::new(15);
    for _ in 0..50 {
        let mut assembly = Assembly::tree(8, random, |body, _| body - 1);
        assembly.pin(0, random);
        assembly.pin(7, random);
        for separation in &mut assembly.separations {
            *separation = random.vector() * 2.0;
        }
        let mut tree = assembly.trees().remove(0);
        let before = assembly.separations.iter().map(|separation| separation.norm()).fold(0.0, f64::max);
        let left = tree.project_positions(&Assembly::of_joints(&tree, &assembly.separations), 10, 0.0);
        for (local, change) in tree.pose_changes().enumerate() {
            assembly.turn(tree.bodies()[local], change.linear, &change.rotation);
        }
        let after = assembly.separations.iter().map(|separation| separation.norm()).fold(0.0, f64::max);
        assert!(after <= before, "{before} m before, {after} m after");
        assert!((after - left).abs() < 1e-12, "{left} m reported, {after} m there");
    }
}

#[test]
fn a_joint_torn_wide_open_closes_in_a_few_substeps() {
    let random = &mut Random::new(16);
    for _ in 0..50 {
        let mut assembly = Assembly::tree(5, random, |body, _| body - 1);
        assembly.pin(0, random);
        for separation in &mut assembly.separations {
            *separation = random.vector() * 3.0;
        }
        for _ in 0..100 {
            let mut tree = assembly.trees().remove(0);
            tree.project_positions(&Assembly::of_joints(&tree, &assembly.separations), 1, 0.0);
            for (local, change) in tree.pose_changes().enumerate() {
                assembly.turn(tree.bodies()[local], change.linear, &change.rotation);
            }
        }
        let left = assembly.separations.iter().map(|separation| separation.norm()).fold(0.0, f64::max);
        assert!(left < 1e-9, "{left:e} m");
    }
}
