//! The exact method: orders of its integrators, singular poses, springs, locked axes, drag, moving supports.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

const GAUSS: ExactIntegrator = ExactIntegrator::Gauss;

fn exact(integrator: ExactIntegrator, hz: f64) -> SolverSettings {
    SolverSettings { hz, exact: ExactSettings { integrator, time_budget: None }, ..SolverSettings::accurate() }
}

/// A rod of 1 kg and 1 m about its centre of mass, its length along that axis.
fn rod(world: &mut World, at: DVec3, along: DVec3) -> Entity {
    let size = DVec3::splat(0.1) + 0.9 * along.abs();
    let collider = (Collider::cuboid(size.x, size.y, size.z), CollisionLayers::NONE);
    world.spawn((RigidBody::Dynamic, collider, Position(at), Mass(1.0))).id()
}

/// Inertia of 1/12 kg m² across that axis, as of a rod without thickness.
fn thin(along: DVec3) -> Inertia {
    Inertia((DVec3::ONE - along) / 12.0 + along / 600.0)
}

fn pin(world: &mut World, at: DVec3) -> Entity {
    world.spawn((RigidBody::Static, Position(at))).id()
}

fn join(world: &mut World, a: Entity, b: Entity, anchor_a: DVec3, anchor_b: DVec3) -> Entity {
    world.spawn((BallJoint::new(a, b).with_anchors(anchor_a, anchor_b), JointLoad::default())).id()
}

/// Three rods from a pivot, level, the last kicked sideways; where they are after half a second.
fn three_rods(integrator: ExactIntegrator, hz: f64) -> Vec<DVec3> {
    let mut world = world_with(exact(integrator, hz));
    let mut before = (pin(&mut world, DVec3::ZERO), DVec3::ZERO);
    let mut rods = Vec::new();
    for index in 0..3 {
        let next = rod(&mut world, DVec3::X * (f64::from(index) + 0.5), DVec3::X);
        join(&mut world, before.0, next, before.1, -0.5 * DVec3::X);
        before = (next, 0.5 * DVec3::X);
        rods.push(next);
    }
    // About its joint with the rod before.
    let angular = DVec3::new(1.0, 3.0, 0.0);
    let linear = angular.cross(0.5 * DVec3::X);
    world.entity_mut(rods[2]).insert(Velocity { linear, angular });
    run(&mut world, 0.5);
    rods.into_iter().map(|rod| position(&world, rod)).collect()
}

#[test]
fn every_integrator_has_its_order() {
    let truth = three_rods(GAUSS, 1920.0);
    let error = |integrator, hz| {
        let places = three_rods(integrator, hz);
        places.iter().zip(&truth).map(|(one, other)| one.distance(*other)).fold(0.0, f64::max)
    };
    for (integrator, rate, order) in [(ExactIntegrator::Rattle, 480.0, 2.0), (GAUSS, 30.0, 8.0)] {
        let found = (error(integrator, rate) / error(integrator, 2.0 * rate)).log2();
        assert!((found - order).abs() < 0.4, "{integrator:?}: order {found}");
    }
}

/// Energies of a rod that swings from the horizontal, after each of so many steps, less the first.
fn swinging(integrator: ExactIntegrator, steps: u32) -> Vec<f64> {
    let mut world = world_with(exact(integrator, 60.0));
    world.init_resource::<Diagnostics>();
    let above = pin(&mut world, DVec3::ZERO);
    let hung = rod(&mut world, DVec3::X * 0.5, DVec3::X);
    join(&mut world, above, hung, DVec3::ZERO, DVec3::X * -0.5);
    let energies = (0..steps).map(|_| {
        step(&mut world);
        world.resource::<Diagnostics>().energy()
    });
    let energies: Vec<f64> = energies.collect();
    energies.iter().map(|energy| energy - energies[0]).collect()
}

/// The energy of a symmetric method stays within what a swing takes it through.
#[test]
fn a_symmetric_integrator_bounds_its_energy_for_a_million_steps() {
    let most = |energies: &[f64]| energies.iter().fold(0.0_f64, |most, energy| most.max(energy.abs()));
    let energies = swinging(ExactIntegrator::Rattle, 1_000_000);
    let (begun, all) = (most(&energies[..10_000]), most(&energies));
    assert!(begun > 1e-12 && all < 1.05 * begun, "{begun:e} J at first, then {all:e} J");
}

/// 41 upright rods, their feet pinned 1 m apart, neighbouring tops joined by 40 level rods, in one plane: a loop of
/// four bars forty times. The tops start at 1 m/s; each time the rods lie flat all loops are singular at once, and may
/// fold either way. As one pendulum: ½J(θ̇² − 1) = G(1 − cos θ), J = 41/3 + 40, G = 9.81 (41/2 + 40).
fn four_bars(loops: u32, hz: f64, seconds: f64) -> (f64, f64, f64) {
    let mut world = world_with(exact(GAUSS, hz));
    world.init_resource::<Diagnostics>();
    let planar = LockedAxes { translation: [false, false, true], rotation: [true, true, false] };
    let ground = pin(&mut world, DVec3::ZERO);
    let mut upright = Vec::new();
    for index in 0..=loops {
        let foot = DVec3::X * f64::from(index);
        let next = rod(&mut world, foot + 0.5 * DVec3::Y, DVec3::Y);
        let velocity = Velocity { linear: 0.5 * DVec3::X, angular: -DVec3::Z };
        world.entity_mut(next).insert((planar, velocity, thin(DVec3::Y)));
        join(&mut world, ground, next, foot, -0.5 * DVec3::Y);
        upright.push(next);
    }
    for index in 0..loops as usize {
        let next = rod(&mut world, DVec3::new(index as f64 + 0.5, 1.0, 0.0), DVec3::X);
        let velocity = Velocity { linear: DVec3::X, angular: DVec3::ZERO };
        world.entity_mut(next).insert((planar, velocity, thin(DVec3::X)));
        join(&mut world, upright[index], next, 0.5 * DVec3::Y, -0.5 * DVec3::X);
        join(&mut world, next, upright[index + 1], 0.5 * DVec3::X, 0.5 * DVec3::Y);
    }
    let uprights = f64::from(loops) + 1.0;
    let (inertia, weight) = (uprights / 3.0 + f64::from(loops), 9.81 * (0.5 * uprights + f64::from(loops)));
    let fall = |angle: f64| weight / inertia * angle.sin();
    let (mut angle, mut rate, mut seen, mut before): (f64, f64, f64, f64) = (0.0, 1.0, 0.0, 0.0);
    let (mut energy, mut off, mut apart): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut start = None;
    for _ in 0..(seconds * hz).round() as u32 {
        step(&mut world);
        let h = 0.1 / hz;
        for _ in 0..10 {
            let (k1, l1) = (rate, fall(angle));
            let (k2, l2) = (rate + 0.5 * h * l1, fall(angle + 0.5 * h * k1));
            let (k3, l3) = (rate + 0.5 * h * l2, fall(angle + 0.5 * h * k2));
            let (k4, l4) = (rate + h * l3, fall(angle + h * k3));
            angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        let along = |body: Entity| world.get::<Rotation>(body).unwrap().0 * DVec3::Y;
        let first = along(upright[0]);
        let now = first.x.atan2(first.y);
        let half_turn = std::f64::consts::PI;
        seen += (now - before + half_turn).rem_euclid(2.0 * half_turn) - half_turn;
        before = now;
        off = off.max((seen - angle).abs());
        apart = upright.iter().map(|&body| along(body).distance(first)).fold(apart, f64::max);
        let total = world.resource::<Diagnostics>().energy();
        energy = energy.max((total - *start.get_or_insert(total)).abs());
    }
    (energy, off, apart)
}

#[test]
fn forty_four_bar_loops_pass_flat_poses_twenty_times() {
    let (energy, off, apart) = four_bars(40, 1000.0, 20.0);
    assert!(energy < 1e-3 && off < 1e-4 && apart < 1e-5, "{energy:e} J, {off:e} rad, {apart:e}");
}

/// x = x₀ + v t φ₁ + g t² φ₂ under drag, whatever the step; and a spin about an axis decays by e^{−ct}.
#[test]
fn a_body_by_itself_moves_in_closed_form() {
    let mut world = world_with(exact(GAUSS, 10.0));
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    let drag = 0.3;
    world.entity_mut(ball).insert((
        Velocity { linear: DVec3::X * 4.0, angular: DVec3::Z * 5.0 },
        Damping { linear: drag, angular: drag },
        GravityScale(2.0),
    ));
    run(&mut world, 2.0);
    let (kept, g) = ((-2.0 * drag).exp(), 2.0 * 9.81);
    let fallen = g / drag * (2.0 - (1.0 - kept) / drag);
    assert_near(position(&world, ball), DVec3::new(4.0 * (1.0 - kept) / drag, -fallen, 0.0), 1e-12);
    assert_close(spin(&world, ball).z, 5.0 * kept, 1e-13);
}

/// A ball hung by a spring from its centre: m ẍ = −m ω²(x − x₀) − 2 m ζ ω ẋ − m g.
#[test]
fn a_soft_joint_is_a_damped_spring() {
    // Kicks take the damper's force at the velocity before, an error of first order: ζ ω h of what the ball moves.
    for (integrator, tolerance) in [(GAUSS, 1e-9), (ExactIntegrator::Rattle, 1e-3)] {
        let mut world = world_with(exact(integrator, 240.0));
        let above = pin(&mut world, DVec3::ZERO);
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
        let (frequency, damping_ratio): (f64, f64) = (0.7, 0.1);
        let softness = Softness { frequency, damping_ratio, max_force: 1e9 };
        world.spawn(BallJoint::new(above, ball).with_softness(softness));
        run(&mut world, 2.0);
        let omega = std::f64::consts::TAU * frequency;
        let (decay, turn) = (damping_ratio * omega, omega * (1.0 - damping_ratio * damping_ratio).sqrt());
        let rest = -9.81 / (omega * omega);
        let (sin, cos) = (turn * 2.0).sin_cos();
        let expected = rest - rest * (-decay * 2.0).exp() * (cos + decay / turn * sin);
        assert_near(position(&world, ball), DVec3::Y * expected, tolerance);
    }
}

/// The load of a joint at rest is the weight below it; a support that moves takes what hangs from it along.
#[test]
fn joints_report_their_loads_and_follow_moving_supports() {
    let mut world = world_with(exact(GAUSS, 60.0));
    let support = world.spawn((RigidBody::Kinematic, Position(DVec3::ZERO))).id();
    let ball = body(&mut world, Collider::sphere(0.1), -DVec3::Y);
    let joint = join(&mut world, support, ball, DVec3::ZERO, DVec3::Y);
    step(&mut world);
    let mass = world.get::<Mass>(ball).unwrap().0;
    assert_near(world.get::<JointLoad>(joint).unwrap().force, DVec3::Y * mass * 9.81, 1e-9);
    world.entity_mut(support).insert(Velocity { linear: DVec3::X, angular: DVec3::ZERO });
    for _ in 0..120 {
        step(&mut world);
        let reach = position(&world, ball).distance(position(&world, support));
        assert_close(reach, 1.0, 1e-13);
    }
    assert_near(position(&world, support), DVec3::X * 2.0, 1e-12);
}

#[test]
fn a_steady_step_allocates_nothing() {
    for integrator in [GAUSS, ExactIntegrator::Rattle] {
        let mut world = world_with(exact(integrator, 240.0));
        let mut before = (pin(&mut world, DVec3::ZERO), DVec3::ZERO);
        for index in 0..10 {
            let next = rod(&mut world, DVec3::X * (f64::from(index) + 0.5), DVec3::X);
            join(&mut world, before.0, next, before.1, -0.5 * DVec3::X);
            before = (next, 0.5 * DVec3::X);
        }
        steps(&mut world, 50);
        let used = allocation_counter::measure(|| steps(&mut world, 50));
        assert_eq!(used.count_total, 0, "{integrator:?}");
    }
}
