//! Spinning bodies: `top` floats free, `heavy_top` stands on its tip.

use bevy::math::{DQuat, DVec3};

use super::gravity::{EARTH, EARTH_G};
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const TOP: SceneInfo = SceneInfo {
    name: "top",
    title: "Tumbling box",
    subject: Subject::Rotation,
    about: "a box 1 x 0.6 x 0.2 m spinning without gravity about its middle axis, nudged: it flips over and over",
    truth: "closed form: angular velocity in Jacobi elliptic functions; energy, angular momentum",
    parameters: &[Parameter::real(
        "spin",
        "about the middle axis, rad/s; a thousandth of it about the first",
        10.0,
        0.01,
        1e4,
    )],
    seconds: 10.0,
    bodies: |_| 1.0,
    build: |values| {
        let mut scene = SceneSpec::new("top", DVec3::ZERO);
        let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.6, 0.2) };
        scene.bodies.push(
            BodySpec::new("top", shape, DVec3::ZERO)
                .with_velocity(DVec3::ZERO, values[0] * DVec3::new(1e-3, 1.0, 0.0))
                .without_collision()
                .with_color(palette::ORANGE),
        );
        scene.view = Some(ViewSpec::framing(DVec3::ZERO, 0.8, DVec3::new(0.5, 0.4, 1.0)));
        scene
    },
};

pub(super) const HEAVY_TOP: SceneInfo = SceneInfo {
    name: "heavy_top",
    title: "Spinning top",
    subject: Subject::Rotation,
    about: "a cone on its tip, axis 30 degrees from upright, spinning at 60 rad/s in steady slow precession",
    truth: "closed form: azimuth W t with W = 1.7551 rad/s, tilt constant; energy, L_y, L along the axis",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| 2.0,
    build: |_| build_heavy_top(),
};

fn build_heavy_top() -> SceneSpec {
    const RADIUS: f64 = 0.4;
    const HEIGHT: f64 = 0.6;
    const TILT_DEGREES: f64 = 30.0;
    const SPIN: f64 = 60.0;
    let (sin, cos) = TILT_DEGREES.to_radians().sin_cos();
    let axis = DVec3::new(sin, cos, 0.0); // from the tip to the base
    // The apex is +y in body axes, so the cone stands on its head: −y turns to the axis.
    let rotation = DQuat::from_rotation_z((180.0 - TILT_DEGREES).to_radians());
    let precession = steady_precession(RADIUS, HEIGHT, cos, SPIN);
    let angular_velocity = precession * (DVec3::Y - cos * axis) + SPIN * axis;
    let center = 0.75 * HEIGHT * axis;

    let mut scene = SceneSpec::new("heavy_top", EARTH);
    let pivot = BodySpec::pin("pivot", DVec3::ZERO);
    let top = BodySpec::new("top", ShapeSpec::Cone { radius: RADIUS, height: HEIGHT }, center)
        .with_rotation(rotation)
        .with_velocity(angular_velocity.cross(center), angular_velocity)
        .without_collision()
        .with_color(palette::TEAL);
    scene.joints.push(JointSpec::new(&pivot, DVec3::ZERO, &top, 0.75 * HEIGHT * DVec3::Y));
    scene.bodies.extend([pivot, top]);
    scene.view = Some(ViewSpec::framing(DVec3::new(0.0, 0.3, 0.0), 0.75, DVec3::new(0.5, 0.4, 1.0)));
    scene
}

/// The smaller root Ω, rad/s, of I⊥Ω² cos α − I₃ω₃Ω + mg·¾h = 0 for a cone on its tip, per
/// kilogram: I₃ = 3/10 r², I⊥ = 3/5 (h² + r²/4) about the tip.
fn steady_precession(radius: f64, height: f64, cos_tilt: f64, spin: f64) -> f64 {
    let along = 0.3 * radius * radius;
    let across = 0.6 * (height * height + radius * radius / 4.0);
    let (a, b, c) = (across * cos_tilt, along * spin, EARTH_G * 0.75 * height);
    2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())
}
