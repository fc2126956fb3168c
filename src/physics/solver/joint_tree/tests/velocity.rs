//! Impulses against the dense system, and what they conserve; geometric stiffness.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{Assembly, assemblies, partition};
use crate::physics::constraint::row::Twist;
use crate::physics::testing::Random;

#[test]
fn impulses_are_those_of_the_dense_system() {
    let random = &mut Random::new(1);
    for mut assembly in assemblies(random) {
        let expected = assembly.dense_impulses();
        let impulses = assembly.solve();
        let scale = expected.amax();
        for (joint, impulse) in impulses.iter().enumerate() {
            let error = (impulse - expected.fixed_rows::<3>(3 * joint)).norm() / scale;
            assert!(error < 1e-9, "joint {joint} of {}: {error:e}", impulses.len());
        }
        assert!(assembly.velocity_error() < 1e-10, "{:e}", assembly.velocity_error());
    }
}

#[test]
fn jacobian_is_the_derivative_of_the_separation() {
    let random = &mut Random::new(3);
    let step = 1e-5;
    for assembly in assemblies(random) {
        let (jacobian, _) = assembly.dense();
        let expected = jacobian * assembly.velocities();
        let end = |body: u32, arm: &Vector3<f64>, time: f64| {
            let twist = &assembly.twists[body as usize];
            twist.linear * time + UnitQuaternion::from_scaled_axis(twist.angular * time) * arm
        };
        for (joint, (&[a, b], arms)) in assembly.joints.iter().zip(&assembly.arms).enumerate() {
            let separation = |time| end(b, &arms[1], time) - end(a, &arms[0], time);
            let slope = (separation(step) - separation(-step)) / (2.0 * step);
            assert!((slope - expected.fixed_rows::<3>(3 * joint)).norm() < 1e-8, "joint {joint}");
        }
    }
}

#[test]
fn impulses_keep_both_momenta_of_a_free_tree() {
    let random = &mut Random::new(4);
    for shape in 0..3 {
        let mut assembly = Assembly::tree(20, random, |body, random| match shape {
            0 => body - 1,
            1 => 0,
            _ => (random.unit() * f64::from(body)) as u32,
        });
        let positions = assembly.closed_positions();
        let momenta = |assembly: &Assembly| {
            let bodies = assembly.twists.iter().enumerate().map(|(body, twist)| {
                let linear = twist.linear / assembly.inverse_masses[body].x;
                let inertia = assembly.inverse_inertias[body].try_inverse().expect("regular");
                (linear, positions[body].cross(&linear) + inertia * twist.angular)
            });
            bodies.fold((Vector3::zeros(), Vector3::zeros()), |sum, momentum| (sum.0 + momentum.0, sum.1 + momentum.1))
        };
        let before = momenta(&assembly);
        assembly.solve();
        let after = momenta(&assembly);
        assert!((after.0 - before.0).norm() < 1e-10, "linear {:e}", (after.0 - before.0).norm());
        assert!((after.1 - before.1).norm() < 1e-10, "angular {:e}", (after.1 - before.1).norm());
    }
}

#[test]
fn a_hub_of_a_thousand_joints_is_exact() {
    let random = &mut Random::new(12);
    let mut assembly = Assembly::tree(1001, random, |_, _| 0);
    assembly.pin(0, random);
    assembly.solve();
    assert!(assembly.velocity_error() < 1e-9, "{:e}", assembly.velocity_error());
}

#[test]
fn pull_along_an_arm_stiffens_across_it_only() {
    let mut tree = partition(&[[1, 0]], &[true, false]).trees.remove(0);
    let inverse = Matrix3::from_diagonal(&Vector3::new(50.0, 12.0, 12.0));
    let (force, arm, h) = (3e4, Vector3::new(-0.5, 0.0, 0.0), 1.0 / 240.0);
    tree.set_arms(0, Vector3::zeros(), arm);
    for (pull, changes) in [(force, true), (-force, false), (1.0, false)] {
        tree.set_inertia(0, Vector3::repeat(1.0), inverse);
        tree.set_impulse(0, Vector3::new(-pull * h, 0.0, 0.0));
        tree.stiffen(h);
        let stiffened = *tree.inverse_inertia(0);
        assert_eq!(stiffened != inverse, changes, "pull {pull}");
        if changes {
            assert!((stiffened.m11 - 50.0).abs() < 1e-12);
            // I + s (β + δ) h² K, K = force × arm across; between ½ and 1 of h² K here.
            let added = 1.0 / stiffened.m22 - 1.0 / 12.0;
            let full = h * h * force * 0.5;
            assert!(added > 0.5 * full && added < full, "{added} of {full}");
            let mut twist = [Twist { linear: Vector3::zeros(), angular: Vector3::repeat(1.0) }];
            tree.damp(&mut twist);
            let left = twist[0].angular;
            assert!((left.x - 1.0).abs() < 1e-12 && left.y > 0.3 && left.y < 1.0 && left.y == left.z, "{left}");
        }
    }
}

#[test]
fn a_push_along_one_arm_takes_nothing_from_the_pull_along_another() {
    let inverse = Matrix3::from_diagonal(&Vector3::new(50.0, 12.0, 12.0));
    let stiffened = |push: f64| {
        let mut tree = partition(&[[1, 0], [2, 0]], &[true, false, false]).trees.remove(0);
        tree.set_inertia(0, Vector3::repeat(1.0), inverse);
        for (joint, force, arm) in [(0, 3e4, 0.5), (1, -push, -0.5)] {
            tree.set_arms(joint, Vector3::zeros(), Vector3::x() * arm);
            tree.set_impulse(joint, Vector3::x() * (force * arm.signum() / 240.0));
        }
        tree.stiffen(1.0 / 240.0);
        *tree.inverse_inertia(0)
    };
    assert_ne!(stiffened(0.0), inverse);
    assert_eq!(stiffened(2e4), stiffened(0.0));
}
