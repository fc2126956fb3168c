//! A cone spinning on its tip in steady slow precession: its axis keeps its tilt α and turns
//! about the vertical at the smaller root Ω of I⊥ Ω² cos α − I₃ ω₃ Ω + m g l = 0.

use bevy::math::{DQuat, DVec3};

use crate::scene::{SceneSpec, ShapeSpec};

use super::super::run::Sample;
use super::{Truth, anchor_on, dynamic};

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let top = &scene.bodies[index];
    let Some(ShapeSpec::Cone { radius, height }) = top.shape else { return None };
    let to_centre = -anchor_on(scene, index)?; // from the tip, body axes
    let lever = to_centre.length();
    let body_axis = to_centre / lever;
    let start = top.rotation * body_axis;
    let up = -scene.gravity.normalize();
    let precession = slow_precession(Top {
        axial: 0.3 * radius * radius,
        transverse: 0.6 * (height * height + 0.25 * radius * radius),
        spin: top.angular_velocity.dot(start),
        torque: scene.gravity.length() * lever,
        cos_tilt: start.dot(up),
    })?;
    let distance = move |sample: &Sample| {
        let axis = sample.bodies[index].rotation * body_axis;
        Some(angle_between(axis, DQuat::from_axis_angle(up, precession * sample.time) * start))
    };
    Some(Truth::largest("direction of the axis", "rad", distance))
}

/// Moments about the tip and torque per mass, of a top whose torque about the tip is
/// `torque` × sin α.
struct Top {
    /// I₃/m, m².
    axial: f64,
    /// I⊥/m, m².
    transverse: f64,
    /// ω₃, rad/s.
    spin: f64,
    /// g l, m²/s².
    torque: f64,
    cos_tilt: f64,
}

/// Ω, rad/s; none where the spin is too slow to carry the top.
fn slow_precession(top: Top) -> Option<f64> {
    let momentum = top.axial * top.spin;
    let discriminant = momentum * momentum - 4.0 * top.transverse * top.cos_tilt * top.torque;
    // The smaller root without cancellation, also for cos α = 0.
    (discriminant >= 0.0).then(|| 2.0 * top.torque / (momentum + momentum.signum() * discriminant.sqrt()))
}

/// Exact for small angles, where acos is not.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn precession_is_that_of_the_scene_table() {
        let (radius, height): (f64, f64) = (0.4, 0.6);
        let top = |spin| Top {
            axial: 0.3 * radius * radius,
            transverse: 0.6 * (height * height + 0.25 * radius * radius),
            spin,
            torque: 9.81 * 0.75 * height,
            cos_tilt: 30_f64.to_radians().cos(),
        };
        let precession = slow_precession(top(60.0)).unwrap();
        assert!((precession - 1.7551).abs() < 5e-5, "{precession}");
        let Top { axial, transverse, spin, torque, cos_tilt } = top(60.0);
        let residual = transverse * precession * precession * cos_tilt - axial * spin * precession + torque;
        assert!(residual.abs() < 1e-13);
        assert_eq!(slow_precession(top(1.0)), None);
    }
}
