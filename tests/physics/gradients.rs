//! Sweeps primed by conjugate residuals, nonsmooth conjugate gradients and sweeps in joint space, in whole scenes.

use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;
use plumb::scene::load;

use crate::rig::*;

const METHODS: [Method; 3] = [Method::PrimedGaussSeidel, Method::NonsmoothConjugateGradient, Method::JointSpace];

/// The greatest separation of a joint, the greatest rise of the energy over its start, and the row updates of all
/// steps, after that many seconds.
fn measured(scene: &str, parameters: &[(&str, f64)], settings: SolverSettings, seconds: f64) -> (f64, f64, u64) {
    let mut world = world_with(settings);
    world.init_resource::<Diagnostics>();
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(scene, &parameters).unwrap().spawn(&mut world);
    step(&mut world);
    let start = world.resource::<Diagnostics>().energy();
    let (mut separation, mut rise, mut updates) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..(seconds * settings.hz) as u32 {
        step(&mut world);
        let diagnostics = world.resource::<Diagnostics>();
        separation = separation.max(diagnostics.joint_error);
        rise = rise.max(diagnostics.energy() - start);
        updates += world.resource::<StepStats>().row_updates;
    }
    assert!(separation.is_finite() && rise.is_finite(), "{scene} with {settings:?}");
    (separation, rise, updates)
}

#[test]
fn few_passes_gain_no_energy() {
    // Forces: the weight of each scene, over a way of 1 mm.
    for (scene, parameter, weight) in
        [("chain", ("r", 100.0), 1.1e3), ("stack", ("n", 10.0), 1e5), ("joint_grid", ("n", 10.0), 2e4)]
    {
        for method in METHODS {
            for iterations in [1, 2, 3, 4, 6, 10] {
                let settings = SolverSettings { method, iterations, ..SolverSettings::steady() };
                let (_, rise, _) = measured(scene, &[parameter], settings, 1.0);
                assert!(rise <= 1e-3 * weight, "{scene}, {method:?}, {iterations} iterations: {rise} J");
            }
        }
    }
}

/// Measured: 25 mm, 0.6 mm primed and in joint space, 4.2 mm by conjugate directions. With a ball of 1000 kg none of
/// them holds: there the rods sway faster than the substep can follow, ω h ≈ 2 with ω² = 12 P/(m L), however well its
/// rows are solved.
#[test]
fn a_heavy_chain_parts_by_a_fraction_of_what_as_many_sweeps_allow() {
    let separation = |method| {
        let settings = SolverSettings { method, iterations: 30, ..SolverSettings::steady() };
        let (separation, _, updates) = measured("chain", &[("r", 100.0)], settings, 2.0);
        assert!(updates <= 120 * 4 * 30 * 33, "{method:?}: {updates} row updates");
        separation
    };
    let of_sweeps = separation(Method::ProjectedGaussSeidel);
    let [primed, nonsmooth, in_joint_space] = METHODS.map(separation);
    assert!(of_sweeps > 0.02, "{of_sweeps} m: nothing to gain");
    assert!(primed < 0.05 * of_sweeps, "{primed} m, {of_sweeps} m");
    assert!(in_joint_space < 0.05 * of_sweeps, "{in_joint_space} m, {of_sweeps} m");
    assert!(nonsmooth < 0.25 * of_sweeps, "{nonsmooth} m, {of_sweeps} m");
}

/// Sheets whose joints follow from each other: rounding in `f32` asks for what no motion gives.
#[test]
fn redundant_joints_hold_in_joint_space() {
    for precision in [Precision::F32, Precision::F64] {
        let settings = SolverSettings { method: Method::JointSpace, precision, ..SolverSettings::steady() };
        let (level, ..) = measured("joint_grid", &[("n", 10.0)], settings, 1.0);
        assert!(level < 1e-8, "{precision:?}: {level} m");
        let (tilted, ..) = measured("joint_grid", &[("n", 6.0), ("tilt", 30.0)], settings, 4.0);
        assert!(tilted < 1e-3, "{precision:?}: {tilted} m");
    }
}

/// Figures on the ground, by one sweep: joints hold as after any number, but for what limits, which are bounded rows, push
/// them apart by.
#[test]
fn figures_that_touch_the_ground_keep_their_joints() {
    let parted = |method| {
        let settings = SolverSettings { method, iterations: 1, substeps: 16, ..SolverSettings::steady() };
        measured("limbs", &[], settings, 3.0).0
    };
    let [swept, in_joint_space] = [Method::ProjectedGaussSeidel, Method::JointSpace].map(parted);
    assert!(in_joint_space < 0.03 && in_joint_space < 0.2 * swept, "{in_joint_space} m, {swept} m");
}
