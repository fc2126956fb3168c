//! A cone moves as a cone does, not as a polygon that stands for it.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

/// A cone of those sizes on its side on the ground, rolling with that spin along the line on which
/// it lies.
fn lying(world: &mut World, radius: f64, height: f64, spin: f64) -> Entity {
    let half_angle = f64::atan2(radius, height);
    let arm = 0.75 * height;
    let cone = body(world, Collider::cone(radius, height), arm * DVec3::new(half_angle.cos(), half_angle.sin(), 0.0));
    world.entity_mut(cone).insert((
        Rotation(DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2 + half_angle)),
        Velocity { linear: DVec3::Z * (spin * arm * half_angle.sin()), angular: DVec3::X * spin },
        SurfaceMaterial { friction: 1.0, restitution: 0.0 },
    ));
    cone
}

/// On its side a cone rolls in a circle about its apex: with half angle γ and spin ω along the
/// line on which it lies, it goes round at ω tan γ. A polygon of 24 sides would lift its centre
/// and drop it by 0.9 % of its radius each 15° (2.6 mm here), and each drop would cost speed. What
/// is left is the step's: its centre sinks by ½ r (ωh)² a step, and is lifted again.
#[test]
fn on_its_side_it_rolls_round_its_apex() {
    let settings = SolverSettings {
        hz: 960.0,
        substeps: 1,
        iterations: 40,
        slop: 0.0,
        precision: Precision::F64,
        ..SolverSettings::steady()
    };
    let mut world = world_with(settings);
    ground(&mut world);
    let (radius, height, spin) = (0.3, 0.8, 2.0);
    let cone = lying(&mut world, radius, height, spin);
    let start = position(&world, cone);
    let turn_time = std::f64::consts::TAU * height / (spin * radius);
    let (mut lowest, mut highest, mut slowest, mut fastest) = (f64::MAX, f64::MIN, f64::MAX, f64::MIN);
    for _ in 0..(turn_time * settings.hz).round() as u32 {
        step(&mut world);
        let (at, turning) = (position(&world, cone), spin_of(&world, cone));
        (lowest, highest) = (lowest.min(at.y), highest.max(at.y));
        (slowest, fastest) = (slowest.min(turning), fastest.max(turning));
    }
    assert!(highest - lowest < 1e-6, "its centre rose and fell by {} m", highest - lowest);
    assert!(slowest > 0.999 * spin && fastest < 1.001 * spin, "{slowest} to {fastest} rad/s");
    assert_near(position(&world, cone), start, 2e-3);
}

#[test]
fn what_rolls_keeps_its_speed_at_the_default_settings() {
    let mut world = world_with(SolverSettings::steady());
    ground(&mut world);
    let cone = lying(&mut world, 0.3, 0.8, 2.0);
    let ball = body(&mut world, Collider::sphere(0.3), DVec3::new(5.0, 0.3, 0.0));
    world.entity_mut(ball).insert(Velocity { linear: DVec3::X * 0.6, angular: -DVec3::Z * 2.0 });
    run(&mut world, 5.0);
    for (name, rolling) in [("cone", cone), ("ball", ball)] {
        let share = spin_of(&world, rolling) / 2.0;
        assert!((0.97..1.03).contains(&share), "the {name} has {share} of its spin");
    }
}

fn spin_of(world: &World, body: Entity) -> f64 {
    spin(world, body).length()
}

#[test]
fn on_its_base_it_stands_still() {
    let mut world = world_with(SolverSettings::steady());
    ground(&mut world);
    let table = world.spawn((RigidBody::Static, Collider::cuboid(2.0, 0.5, 2.0), Position(DVec3::new(5.0, 0.25, 0.0))));
    let top = table.get::<Position>().unwrap().0.y + 0.25;
    let cones = [
        body(&mut world, Collider::cone(0.4, 0.9), DVec3::new(0.0, 0.225, 0.0)),
        body(&mut world, Collider::cone(0.4, 0.9), DVec3::new(5.0, top + 0.225, 0.0)),
    ];
    let starts = cones.map(|cone| position(&world, cone));
    run(&mut world, 5.0);
    for (cone, start) in cones.into_iter().zip(starts) {
        assert_near(position(&world, cone), start, 0.003);
        assert!(velocity(&world, cone).length() < 1e-4, "{}", velocity(&world, cone));
        assert!(spin_of(&world, cone) < 1e-3, "{}", spin(&world, cone));
    }
}

/// Friction at the four points of the rim on which it stands slows it by μ m g r/I = μ g/(0.3 r).
#[test]
fn spun_on_its_base_it_slows_evenly() {
    let mut world = world_with(SolverSettings::steady());
    ground(&mut world);
    let cone = body(&mut world, Collider::cone(0.4, 0.5), DVec3::Y * 0.125);
    world.entity_mut(cone).insert((
        Velocity { linear: DVec3::ZERO, angular: DVec3::Y * 40.0 },
        // Of the pair it is the geometric mean with the ground's 0.6.
        SurfaceMaterial { friction: 0.04 / 0.6, restitution: 0.0 },
    ));
    let start = position(&world, cone);
    let expected = 0.2 * 9.81 / (0.3 * 0.4);
    let mut before = 40.0;
    for _ in 0..8 {
        run(&mut world, 0.25);
        let now = spin_of(&world, cone);
        assert_close((before - now) / 0.25, expected, 0.05 * expected);
        before = now;
    }
    assert_near(position(&world, cone), start, 0.01);
}

/// It turns about its apex, which is over the box, while its base is beside it: each forecast tilts it about the edge by a
/// little, where the least overlap tells of one point alone.
#[test]
fn a_cone_rolls_over_the_edge_of_a_box() {
    let mut world = world_with(SolverSettings::accurate());
    world.init_resource::<Diagnostics>();
    let below = body(&mut world, Collider::cuboid(0.8, 1.0, 0.8), DVec3::Y * 0.5);
    world.entity_mut(below).insert(RigidBody::Static);
    let (apex, height, slant) = (DVec3::new(-0.1, 1.0, 0.0), 0.6, (0.25_f64 / 0.6).atan());
    let along = DVec3::new(0.2_f64.cos(), 0.0, 0.2_f64.sin());
    let axis = along * slant.cos() + DVec3::Y * slant.sin();
    let center = apex + axis * (0.75 * height);
    let cone = body(&mut world, Collider::cone(0.25, height), center);
    let (angular, linear) = (along * 0.32, along.cross(center - apex) * 0.32);
    world.entity_mut(cone).insert((Rotation(DQuat::from_rotation_arc(DVec3::Y, -axis)), Velocity { linear, angular }));
    steps(&mut world, 1);
    let kinetic = |world: &World| world.resource::<Diagnostics>().kinetic_energy;
    let start = kinetic(&world);
    for _ in 0..59 {
        steps(&mut world, 1);
        assert_eq!(world.resource::<StepStats>().cuts, 0);
    }
    assert_close(kinetic(&world), start, 1e-3 * start);
    assert!(spin(&world, cone).length() > 0.3, "it has stopped");
}
