//! Hinges that are driven or stopped: `arm`, `servo`, `stop`. Nothing collides.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use bevy::math::{DQuat, DVec3};

use super::gravity::EARTH;
use super::palette;
use crate::physics::{JointAxes, JointMotor, MotorTarget, PrescribedMotion};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, LimitSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const ARM: SceneInfo = SceneInfo {
    name: "arm",
    title: "Robot arm",
    subject: Subject::Machines,
    about: "a post, an upper arm and a forearm on three hinges in series, whose motors follow cosines in time, no \
            collision",
    truth: "reference torques of the motors and trajectory of the tip",
    parameters: &[],
    seconds: 2.0,
    bodies: |_| 4.0,
    build: |_| build_arm(),
};

pub(super) const SERVO: SceneInfo = SceneInfo {
    name: "servo",
    title: "Servo",
    subject: Subject::Machines,
    about: "the rod of 'pendulum' on a hinge at its end, at rest without gravity, driven to 1 rad",
    truth: "closed form: the damped oscillator",
    parameters: &[
        Parameter::real("f", "undamped frequency of the motor, Hz", 1.0, 1e-3, 1e5),
        Parameter::real("zeta", "its damping ratio", 1.0, 0.0, 100.0),
    ],
    seconds: 5.0,
    bodies: |_| 2.0,
    build: |values| {
        let target = MotorTarget::Position { target: 1.0, frequency: values[0], damping_ratio: values[1] };
        let mut scene = SceneSpec::new("servo", DVec3::ZERO);
        let (pivot, rod) = pivoted_rod(0.0);
        scene.joints.push(JointSpec::hinge(&pivot, &rod, DVec3::ZERO, DVec3::Z).with_motor(JointMotor::new(target)));
        scene.bodies.extend([pivot, rod]);
        scene.view = Some(ViewSpec::framing(DVec3::new(0.3, 0.4, 0.0), 0.9, DVec3::new(0.0, 0.15, 1.0)));
        scene
    },
};

pub(super) const STOP: SceneInfo = SceneInfo {
    name: "stop",
    title: "Rod at a stop",
    subject: Subject::Joints,
    about: "the rod of 'pendulum' on a hinge at its end, released 60 degrees above level, which its limit does not let \
            it pass",
    truth: "closed form to the stop; then at rest, or back with e times the speed; energy",
    parameters: &[Parameter::real("e", "restitution of the limit", 0.0, 0.0, 1.0)],
    seconds: 5.0,
    bodies: |_| 2.0,
    build: |values| {
        let mut scene = SceneSpec::new("stop", EARTH);
        let (pivot, rod) = pivoted_rod(FRAC_PI_3);
        // Zero where the rod is level.
        let frame = DQuat::from_rotation_arc(DVec3::X, DVec3::Z);
        let limits = LimitSpec { swing: None, min: 0.0, max: f64::INFINITY, restitution: values[0] };
        scene.joints.push(JointSpec {
            axes: JointAxes::Frames(frame, frame),
            coordinate: FRAC_PI_3,
            limits: Some(limits),
            ..JointSpec::hinge(&pivot, &rod, DVec3::ZERO, DVec3::Z)
        });
        scene.bodies.extend([pivot, rod]);
        scene.view = Some(ViewSpec::framing(DVec3::new(0.3, 0.4, 0.0), 0.9, DVec3::new(0.0, 0.15, 1.0)));
        scene
    },
};

/// The rod of `pendulum` from a pivot at the origin, at that angle above +x, rad.
fn pivoted_rod(angle: f64) -> (BodySpec, BodySpec) {
    let rotation = DQuat::from_rotation_z(angle);
    let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.1, 0.1) };
    let rod = BodySpec::new("rod", shape, rotation * (0.5 * DVec3::X))
        .with_mass(1.0)
        .with_rotation(rotation)
        .without_collision()
        .with_color(palette::ORANGE);
    (BodySpec::pin("pivot", DVec3::ZERO), rod)
}

fn build_arm() -> SceneSpec {
    let part = |name: &str, size: DVec3, mass: f64, centre: DVec3, color| {
        BodySpec::new(name, ShapeSpec::Cuboid { size }, centre).with_mass(mass).without_collision().with_color(color)
    };
    let bodies = [
        BodySpec::pin("ground", DVec3::ZERO),
        part("post", DVec3::new(0.2, 0.5, 0.2), 5.0, DVec3::new(0.0, 0.25, 0.0), palette::SLATE),
        part("upper arm", DVec3::new(0.6, 0.1, 0.1), 2.0, DVec3::new(0.3, 0.5, 0.0), palette::ORANGE),
        part("forearm", DVec3::new(0.5, 0.08, 0.08), 1.0, DVec3::new(0.85, 0.5, 0.0), palette::TEAL),
    ];
    // Where, about what, amplitude and angular frequency of A (1 − cos ωt).
    let motors = [
        (DVec3::ZERO, DVec3::Y, 0.8, 2.0),
        (DVec3::new(0.0, 0.5, 0.0), DVec3::Z, 0.5, 3.0),
        (DVec3::new(0.6, 0.5, 0.0), DVec3::Z, -0.7, 4.0),
    ];
    let mut scene = SceneSpec::new("arm", EARTH);
    for ((at, axis, amplitude, angular_frequency), ends) in motors.into_iter().zip(bodies.windows(2)) {
        let motion = PrescribedMotion::Sine { mean: amplitude, amplitude, angular_frequency, phase: -FRAC_PI_2 };
        let motor = JointMotor::new(MotorTarget::Motion(motion));
        scene.joints.push(JointSpec::hinge(&ends[0], &ends[1], at, axis).with_motor(motor));
    }
    scene.bodies.extend(bodies);
    scene.view = Some(ViewSpec::framing(DVec3::new(0.4, 0.5, 0.0), 1.1, DVec3::new(0.4, 0.3, 1.0)));
    scene
}
