//! Friction holds up to Coulomb's bound, and where it is off, by the setting or by the surfaces, nothing holds.

use bevy::math::DVec3;
use plumb::prelude::*;

use super::ENGINES;
use super::Engine::{self, *};
use crate::rig::*;

/// How far a speed may be off after a second, m/s.
fn expected(engine: Engine) -> f64 {
    match engine {
        // No row has a share along the ground: velocities are f64, and no force but gravity changes them.
        Classic | Steady | Primed | Nonsmooth => 1e-12,
        // Velocities go through f32 in each of 60 to 480 substeps: measured 1.1e-5.
        Game | Sequential | Xpbd => 5e-5,
        // f64 throughout.
        Accurate => 1e-12,
    }
}

/// The two ways to have none: these settings and this surface.
fn ways(engine: Engine) -> [(SolverSettings, SurfaceMaterial); 2] {
    let slippery = SurfaceMaterial { friction: 0.0, restitution: 0.0 };
    let off = SolverSettings { friction: FrictionModel::Off, ..engine.settings() };
    [(off, SurfaceMaterial::default()), (engine.settings(), slippery)]
}

#[test]
fn without_friction_a_box_keeps_its_speed() {
    for engine in ENGINES {
        for (settings, surface) in ways(engine) {
            let mut world = world_with(settings);
            ground(&mut world);
            let slider = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
            let thrown = Velocity { linear: DVec3::X * 3.0, angular: DVec3::ZERO };
            world.entity_mut(slider).insert((thrown, surface));
            run(&mut world, 1.0);
            let off = velocity(&world, slider).with_y(0.0) - thrown.linear;
            let friction = settings.friction;
            assert!(off.length() <= expected(engine), "{engine:?}, {friction:?}, {surface:?}: {off} m/s off");
        }
    }
}

#[test]
fn without_friction_nothing_holds_on_an_incline() {
    for engine in ENGINES {
        for (settings, surface) in ways(engine) {
            let (mut world, slider) = incline(settings, 20.0);
            world.entity_mut(slider).insert(surface);
            run(&mut world, 1.0);
            let off = velocity(&world, slider).x - G * 20.0_f64.to_radians().sin();
            let friction = settings.friction;
            assert!(off.abs() <= expected(engine), "{engine:?}, {friction:?}, {surface:?}: {off} m/s off");
        }
    }
}

/// What a box does on an incline at μ = 0.6.
struct OnIncline {
    /// How far it may creep in two seconds where it should stick, m.
    creep: f64,
    /// The step with which a slide is integrated, s; none where the law of friction is not Coulomb's.
    step: Option<f64>,
}

fn on_incline(engine: Engine) -> OnIncline {
    match engine {
        // Friction is bounded by weight, at each of the points that are within the slop of 1 cm just then: measured
        // 2.4 cm at 10°.
        Classic => OnIncline { creep: 0.15, step: None },
        // It settles into the slop of 2 mm and no more.
        Steady | Primed | Nonsmooth => OnIncline { creep: 2e-3, step: Some(1.0 / 240.0) },
        Game => OnIncline { creep: 1e-4, step: Some(1.0 / 240.0) },
        Sequential => OnIncline { creep: 1e-4, step: Some(1.0 / 60.0) },
        // Nothing carries over from substep to substep: it creeps.
        Xpbd => OnIncline { creep: 4e-3, step: Some(1.0 / 480.0) },
        // Coulomb's cone to 1e-10 m/s; and a step of second order has no error on a parabola.
        Accurate => OnIncline { creep: 1e-9, step: Some(0.0) },
    }
}

#[test]
fn a_box_sticks_to_an_incline_flatter_than_its_friction() {
    for engine in ENGINES {
        // tan 30° = 0.577 < 0.6.
        for degrees in [10.0, 20.0, 30.0] {
            let (mut world, slider) = incline(engine.settings(), degrees);
            run(&mut world, 2.0);
            let slid = position(&world, slider).x;
            assert!(slid.abs() <= on_incline(engine).creep, "{engine:?} at {degrees}°: {slid} m");
        }
    }
}

#[test]
fn a_box_slides_down_a_steeper_incline() {
    for engine in ENGINES {
        let Some(step) = on_incline(engine).step else { continue };
        // tan 32° = 0.625 > 0.6.
        for degrees in [32.0_f64, 40.0, 60.0] {
            let (mut world, slider) = incline(engine.settings(), degrees);
            run(&mut world, 1.0);
            let (slid, speed) = (position(&world, slider).x, velocity(&world, slider).x);
            let (sin, cos) = degrees.to_radians().sin_cos();
            let acceleration = G * (sin - 0.6 * cos);
            // Another 1 % of m g sin θ for the solver.
            let share = 0.01 * G * sin;
            let (far, fast) = (slid - 0.5 * acceleration, speed - acceleration);
            // Euler is ½ a t h early.
            let tolerance = 0.5 * acceleration * step + 0.5 * share;
            assert!(far.abs() <= tolerance, "{engine:?} at {degrees}°: {far} m too far");
            assert!(fast.abs() <= share, "{engine:?} at {degrees}°: {fast} m/s too fast");
        }
    }
}
