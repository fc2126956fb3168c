//! A car on four driven wheels: `car`.

use bevy::math::DVec3;

use super::gravity::{EARTH, EARTH_G};
use super::palette;
use crate::physics::{JointAxis, JointMotor, MotorTarget};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointKindSpec, JointSpec, MotorKeys, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const CAR: SceneInfo = SceneInfo {
    name: "car",
    title: "Car",
    subject: Subject::Machines,
    about: "a chassis on four driven balls for wheels, the front ones steered, on a plane with ramps, driven with the \
            arrow keys",
    truth: "unsprung, on the level, without steering: a = sum(T/r)/(M + sum(m + I/r^2)), up to the speed asked for",
    parameters: &[
        Parameter::whole("sprung", "1: hubs on sprung sliders; 0: on the chassis itself", 1.0, 0.0, 1.0),
        Parameter::real("torque", "largest of each motor, N m", 100.0, 0.0, 1e4),
        Parameter::real("speed", "of the wheels while no key is held, rad/s", 0.0, -1e4, 1e4),
    ],
    seconds: 5.0,
    bodies: |_| 12.0,
    build: |values| build(values[0] == 1.0, values[1], values[2]),
};

const CHASSIS_MASS: f64 = 800.0;

/// Of the balls that the wheels are. A rigid cylinder touches the ground along a line, whose friction keeps it from turning:
/// one 0.25 m wide, steered by 0.1 rad, goes straight on, and by 0.3 rad takes a curve of 12 to 15 m radius for 8 m.
const WHEEL_RADIUS: f64 = 0.35;

/// rad/s of the wheels while a key is held, ahead and back.
const KEY_SPEEDS: [f64; 2] = [60.0, -20.0];

/// Steering angle while a key is held, rad.
const STEERING: f64 = 0.5;

/// Of a hub on its slider, N/m and N·s/m: 1.5 Hz, ζ 0.5 under a quarter of the chassis.
const SPRING: [f64; 2] = [2e4, 2e3];

fn build(sprung: bool, torque: f64, speed: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("car", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    add_ramps(&mut scene);
    let size = DVec3::new(3.0, 0.5, 1.5);
    let chassis = BodySpec::new("chassis", ShapeSpec::Cuboid { size }, 0.6 * DVec3::Y)
        .with_mass(CHASSIS_MASS)
        .with_color(palette::RED);
    let drive = JointMotor::new(MotorTarget::Speed(speed)).with_max_force(torque);
    let driven_by = keys(["ArrowUp", "ArrowDown"], KEY_SPEEDS, speed);
    let mut wheels = Vec::new();
    for (name, x, z) in
        [("front left", 1.0, -1.0), ("front right", 1.0, 1.0), ("rear left", -1.0, -1.0), ("rear right", -1.0, 1.0)]
    {
        let centre = DVec3::new(1.05 * x, WHEEL_RADIUS, 1.15 * z);
        let axle = ShapeSpec::Cuboid { size: DVec3::new(0.12, 0.12, 0.8) };
        let hub = BodySpec::new(format!("{name} hub"), axle, centre).with_mass(10.0).without_collision();
        let tyre = ShapeSpec::Sphere { radius: WHEEL_RADIUS };
        let wheel = BodySpec::new(format!("{name} wheel"), tyre, centre).with_mass(20.0).with_color(palette::SLATE);
        hang_hub(&mut scene.joints, &chassis, &hub, sprung, x > 0.0);
        // About −z: forwards is along +x.
        let hinge = JointSpec::hinge(&hub, &wheel, centre, DVec3::NEG_Z).with_motor(drive);
        scene.joints.push(JointSpec { keys: Some(driven_by.clone()), ..hinge });
        wheels.extend([hub.with_color(palette::STEEL), wheel]);
    }
    scene.bodies.push(chassis);
    scene.bodies.extend(wheels);
    scene.view = Some(ViewSpec { eye: DVec3::new(-7.0, 4.5, 7.0), target: DVec3::new(2.0, 0.3, 0.0) });
    scene
}

/// Beside the way straight ahead.
fn add_ramps(scene: &mut SceneSpec) {
    let (length, height, half_width) = (5.0, 0.7, 1.8);
    let side = [(0.0, 0.0), (length, 0.0), (length, height)];
    let points: Vec<DVec3> =
        side.into_iter().flat_map(|(x, y)| [-half_width, half_width].map(|z| DVec3::new(x, y, z))).collect();
    let centre = DVec3::new(2.0 * length / 3.0, height / 3.0, 0.0);
    for (name, corner) in [("left ramp", DVec3::new(8.0, 0.0, -5.0)), ("right ramp", DVec3::new(14.0, 0.0, 5.0))] {
        let ramp = BodySpec::new(name, ShapeSpec::hull(points.clone()), corner + centre);
        scene.bodies.push(ramp.fixed().with_color(palette::WOOD));
    }
}

/// Joins a hub to the chassis: steered or not, sprung or not.
fn hang_hub(joints: &mut Vec<JointSpec>, chassis: &BodySpec, hub: &BodySpec, sprung: bool, steered: bool) {
    let of_kind = |kind| JointSpec::of_kind(kind, chassis, hub, hub.position).with_axis(DVec3::Y);
    let steering = JointMotor::new(MotorTarget::Position { target: 0.0, frequency: 8.0, damping_ratio: 1.0 });
    let [stiffness, damping] = SPRING;
    // At rest it carries a quarter of the chassis: a hub that is pushed down.
    let target = -0.25 * CHASSIS_MASS * EARTH_G / stiffness;
    let spring = JointMotor::new(MotorTarget::Spring { target, stiffness, damping });
    let turns = |joint: JointSpec| JointSpec {
        keys: Some(keys(["ArrowLeft", "ArrowRight"], [STEERING, -STEERING], 0.0)),
        ..joint.with_motor(steering)
    };
    let free = |locked, axis| JointKindSpec::Generic { translations: locked, rotations: locked, axis: Some(axis) };
    match (sprung, steered) {
        (false, false) => joints.push(of_kind(JointKindSpec::Fixed)),
        (false, true) => joints.push(turns(of_kind(JointKindSpec::Hinge))),
        (true, false) => joints.push(of_kind(JointKindSpec::Slider).with_motor(spring)),
        (true, true) => {
            // A hub that slides and turns on its pin: one joint for each motor.
            joints.push(of_kind(free([false, true, true], JointAxis::X)).with_motor(spring));
            joints.push(turns(of_kind(free([false; 3], JointAxis::Twist))));
        }
    }
}

fn keys(keys: [&str; 2], values: [f64; 2], rest: f64) -> MotorKeys {
    MotorKeys { keys: keys.map(str::to_owned), values, rest }
}
