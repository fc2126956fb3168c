//! A cone spinning on its tip in steady slow precession: its axis keeps its tilt α and turns
//! about the vertical at the smaller root Ω of I⊥ Ω² cos α − I₃ ω₃ Ω + m g l = 0. Angular momentum
//! about the tip is kept along the vertical and along the axis, since gravity's torque is across
//! both.

use bevy::math::{DQuat, DVec3};

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{Poses, Truth};
use super::bodies::{anchor_on, dynamic};
use crate::lab::angle::angle_between;
use crate::lab::simulation::Sample;
use crate::physics::BodyState;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let Steady { index, body_axis, up, precession, lever, .. } = Steady::of(scene)?;
    let top = &scene.bodies[index];
    let Some(ShapeSpec::Cone { radius, height }) = top.shape else { return None };
    let start = top.rotation * body_axis;
    let axis = move |sample: &Sample| sample.bodies[index].rotation * body_axis;
    let expected = move |sample: &Sample| DQuat::from_axis_angle(up, precession * sample.time) * start;
    let distance = move |sample: &Sample| Some(angle_between(axis(sample), expected(sample)));
    let azimuth = move |sample: &Sample| {
        let [is, should] = [axis(sample), expected(sample)].map(|axis| axis - axis.dot(up) * up);
        Some(angle_between(is, should))
    };
    let momentum = Momentum { index, pivot: top.position - start * lever, body_axis, radius, height };
    let at_start = momentum.of(&BodyState {
        position: top.position,
        rotation: top.rotation,
        linear: top.linear_velocity,
        angular: top.angular_velocity,
    });
    let change = move |sample: &Sample, along: DVec3, along_at_start: DVec3| {
        let now = momentum.of(&sample.bodies[momentum.index]).dot(along);
        Some((now - at_start.dot(along_at_start)).abs() / at_start.length())
    };
    let about_vertical = move |sample: &Sample| change(sample, up, up);
    let about_axis = move |sample: &Sample| change(sample, axis(sample), start);
    // Ω t reaches 20 rad, known to a few roundings; a start off by one wobbles by less.
    let truth = Truth::largest("direction of the axis", "rad", distance).with_uncertainty(1e-13);
    Some(
        truth
            .and(Truth::largest("azimuth of the axis", "rad", azimuth).with_uncertainty(1e-13))
            .and(Truth::largest("angular momentum about the vertical", "of its whole", about_vertical))
            .and(Truth::largest("angular momentum about the axis", "of its whole", about_axis)),
    )
}

/// What angular momentum about the tip takes, per mass.
#[derive(Clone, Copy)]
struct Momentum {
    index: usize,
    /// Where the tip is held, m.
    pivot: DVec3,
    body_axis: DVec3,
    radius: f64,
    height: f64,
}

impl Momentum {
    /// m²/s.
    fn of(&self, state: &BodyState) -> DVec3 {
        let axis = state.rotation * self.body_axis;
        let along = state.angular.dot(axis) * axis;
        let axial = 0.3 * self.radius * self.radius;
        let transverse = 0.0375 * (4.0 * self.radius * self.radius + self.height * self.height);
        let spin = axial * along + transverse * (state.angular - along);
        (state.position - self.pivot).cross(state.linear) + spin
    }
}

/// The top where the answer has it: turned by Ωt about the vertical, and by (ω₃ − Ω cos α)t
/// about its own axis.
pub(super) fn poses(scene: &SceneSpec) -> Option<Poses> {
    let Steady { index, body_axis, up, precession, spin, cos_tilt, lever } = Steady::of(scene)?;
    let top = &scene.bodies[index];
    let (start, tip) = (top.rotation, top.position - top.rotation * (lever * body_axis));
    Some(Box::new(move |time| {
        let turned = DQuat::from_axis_angle(up, precession * time) * start;
        let spun = DQuat::from_axis_angle(body_axis, (spin - precession * cos_tilt) * time);
        vec![(index, tip + turned * (lever * body_axis), turned * spun)]
    }))
}

/// Steady slow precession of a scene's top.
struct Steady {
    index: usize,
    /// From the tip to the centre, unit, body axes.
    body_axis: DVec3,
    up: DVec3,
    /// Ω, rad/s.
    precession: f64,
    /// ω₃, rad/s.
    spin: f64,
    cos_tilt: f64,
    /// From the tip to the centre, m.
    lever: f64,
}

impl Steady {
    fn of(scene: &SceneSpec) -> Option<Self> {
        let index = *dynamic(scene).first()?;
        let top = &scene.bodies[index];
        let Some(ShapeSpec::Cone { radius, height }) = top.shape else { return None };
        let to_centre = -anchor_on(scene, index)?;
        let lever = to_centre.length();
        let body_axis = to_centre / lever;
        let axis = top.rotation * body_axis;
        let up = -scene.gravity.normalize();
        let (spin, cos_tilt) = (top.angular_velocity.dot(axis), axis.dot(up));
        let precession = slow_precession(Top {
            axial: 0.3 * radius * radius,
            transverse: 0.6 * (height * height + 0.25 * radius * radius),
            spin,
            torque: scene.gravity.length() * lever,
            cos_tilt,
        })?;
        Some(Self { index, body_axis, up, precession, spin, cos_tilt, lever })
    }
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
