//! Redundant rows, locked axes, extreme masses: all stays finite.

use nalgebra::{Matrix3, Vector3};

use super::Assembly;
use crate::physics::constraint::row::Twist;
use crate::physics::testing::Random;

#[test]
fn mass_ratios_of_a_million_are_solved() {
    let random = &mut Random::new(7);
    for heavy in [0, 10, 19] {
        for shape in 0..2 {
            let mut assembly = Assembly::tree(20, random, |body, _| if shape == 0 { body - 1 } else { (body - 1) / 3 });
            assembly.inverse_masses[heavy] *= 1e-6;
            assembly.inverse_inertias[heavy] *= 1e-6;
            assembly.pin(0, random);
            assembly.solve();
            assert!(assembly.velocity_error() < 1e-8, "{:e}", assembly.velocity_error());
        }
    }
}

#[test]
fn a_body_pinned_twice_is_a_hinge() {
    let random = &mut Random::new(8);
    let mut assembly = Assembly::new();
    let rod = assembly.body(1.0, random);
    let ends = [Vector3::new(0.3, 0.4, 0.0), Vector3::new(-0.3, -0.4, 0.0)];
    for end in ends {
        let fixed = assembly.fixed(random);
        assembly.twists[fixed as usize] = Twist::zero();
        assembly.joints.push([fixed, rod]);
        assembly.arms.push([Vector3::zeros(), end]);
        assembly.separations.push(Vector3::zeros());
        assembly.targets.push(Vector3::zeros());
    }
    assert!(assembly.trees()[0].may_be_redundant());
    let impulses = assembly.solve();
    assert!(impulses.iter().all(|impulse| impulse.norm() < 100.0), "{impulses:?}");
    assert!(assembly.velocity_error() < 1e-12, "{:e}", assembly.velocity_error());
    let spin = assembly.twists[rod as usize].angular;
    assert!(spin.cross(&ends[0]).norm() < 1e-12 && spin.norm() > 0.01, "turns about the line of the pins: {spin}");
}

#[test]
fn a_straight_chain_between_two_pins_stays_finite() {
    let random = &mut Random::new(9);
    for sag in [0.0, 1e-9, 1e-6, 1e-3] {
        let mut assembly = Assembly::tree(10, random, |body, _| body - 1);
        assembly.pin(0, random);
        assembly.pin(9, random);
        let half = Vector3::new(0.5, 0.0, 0.0);
        for (joint, bodies) in assembly.joints.clone().into_iter().enumerate() {
            let arm = |body: u32, other: u32| {
                let on_right = other > body && other < 10 || other > 10;
                let bent = Vector3::new(0.0, sag * random_sign(body), 0.0);
                if body < 10 { (half + bent) * if on_right { 1.0 } else { -1.0 } } else { Vector3::zeros() }
            };
            assembly.arms[joint] = [arm(bodies[0], bodies[1]), arm(bodies[1], bodies[0])];
            assembly.targets[joint] = Vector3::zeros();
            // Pulled apart: no pose closes the joints.
            assembly.separations[joint] = half * 0.1;
        }
        for twist in &mut assembly.twists[10..] {
            *twist = Twist::zero();
        }
        let impulses = assembly.solve();
        assert!(impulses.iter().all(|impulse| impulse.iter().all(|x| x.is_finite())), "sag {sag:e}");
        for mut tree in assembly.trees() {
            let separations = Assembly::of_joints(&tree, &assembly.separations);
            let left = tree.project_positions(&separations, 5, 0.0);
            assert!(left <= 0.0500001, "sag {sag:e}: left {left}");
            for change in tree.pose_changes() {
                assert!(change.linear.norm() < 1.0, "sag {sag:e}: moves by {}", change.linear.norm());
            }
        }
    }
}

fn random_sign(body: u32) -> f64 {
    if body.is_multiple_of(3) { 1.0 } else { -1.0 }
}

#[test]
fn locked_axes_take_no_part() {
    let random = &mut Random::new(10);
    // All bodies in a plane: no motion along z, no rotation about x or y.
    let mut assembly = Assembly::tree(12, random, |body, random| (random.unit() * f64::from(body)) as u32);
    assembly.pin(0, random);
    for body in 0..12 {
        assembly.inverse_masses[body].z = 0.0;
        assembly.inverse_inertias[body] = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 3.0));
    }
    for body in 0..13 {
        assembly.twists[body].linear.z = 0.0;
        assembly.twists[body].angular = Vector3::z() * random.within(-1.0, 1.0);
    }
    for target in &mut assembly.targets {
        target.z = 0.0;
    }
    let impulses = assembly.solve();
    assert!(impulses.iter().all(|impulse| impulse.z == 0.0));
    assert!(assembly.velocity_error() < 1e-11, "{:e}", assembly.velocity_error());
    // Bodies that cannot turn, and one that cannot move at all.
    let mut assembly = Assembly::tree(5, random, |body, _| body - 1);
    for body in 0..5 {
        assembly.lock(body, 0, 1);
    }
    assembly.inverse_masses[2] = Vector3::zeros();
    assembly.inverse_inertias[2] = Matrix3::zeros();
    assert!(assembly.solve().iter().all(|impulse| impulse.iter().all(|x| x.is_finite())));
}

#[test]
fn pins_that_pull_a_body_apart_do_no_harm() {
    let random = &mut Random::new(14);
    for _ in 0..20 {
        let mut assembly = Assembly::new();
        let rod = assembly.body(1.0, random);
        let end = random.direction() * 0.5;
        for (arm, speed) in [(end, end), (-end, -end)] {
            let fixed = assembly.fixed(random);
            assembly.twists[fixed as usize] = Twist { linear: speed, angular: Vector3::zeros() };
            assembly.joints.push([fixed, rod]);
            assembly.arms.push([Vector3::zeros(), arm]);
            assembly.separations.push(-speed * 0.1);
            assembly.targets.push(Vector3::zeros());
        }
        let mut trees = assembly.trees();
        let separations = Assembly::of_joints(&trees[0], &assembly.separations);
        let left = trees[0].project_positions(&separations, 3, 0.0);
        let change = trees[0].pose_changes().next().expect("one body moves");
        assert!(change.linear.norm() < 0.1 && left <= 0.1, "moves by {}", change.linear.norm());
        let impulses = assembly.solve();
        assert!(impulses.iter().all(|impulse| impulse.norm() < 100.0), "{impulses:?}");
    }
}
