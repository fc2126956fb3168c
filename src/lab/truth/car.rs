//! A car on the level whose wheels roll: each motor's torque T drives it by T/r, and its inertia is that of all masses
//! and of the wheels' turning, a = Σ T/r / (M + Σ(m + I/r²)), until the wheels turn as fast as asked for.

use crate::physics::{MotorTarget, RigidBody};
use crate::scene::{JointKindSpec, SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use crate::lab::joined::joined;
use crate::lab::simulation::Sample;

/// None where it is sprung.
pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    if scene.joints.iter().any(|joint| joint.kind == JointKindSpec::Slider) {
        return None;
    }
    let moving = scene.bodies.iter().filter(|body| body.kind == RigidBody::Dynamic);
    let mut inertia: f64 = moving.map(|body| body.mass).sum::<Option<f64>>()?;
    let (mut drive, mut most) = (0.0, 0.0);
    for (joint, [_, wheel]) in joined(scene) {
        let (Some(motor), Some(ShapeSpec::Sphere { radius })) = (joint.motor, &scene.bodies[wheel].shape) else {
            continue;
        };
        let MotorTarget::Speed(speed) = motor.target else { continue };
        drive += motor.max_force.copysign(speed) / radius;
        inertia += 0.4 * scene.bodies[wheel].mass?;
        most = speed.abs() * radius;
    }
    let chassis = scene.bodies.iter().position(|body| body.name == "chassis")?;
    let distance = move |sample: &Sample| {
        let speed = (drive / inertia * sample.time).clamp(-most, most);
        Some((sample.bodies[chassis].linear.x - speed).abs())
    };
    let truth = Truth::largest("speed of the chassis", "m/s", distance);
    Some(truth.with_energy_scale(EnergyScale::NotKept))
}
