//! Newton's cradle with restitution 1: one pendulum's swing, carried by the first ball on its side
//! of the vertical and by the last on the other, while those between hang still.

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::bodies::{anchor_on, dynamic};
use super::pendulum::{Swing, UNCERTAINTY};
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let balls = dynamic(scene);
    let first = &scene.bodies[*balls.first()?];
    let Some(ShapeSpec::Sphere { radius }) = first.shape else { return None };
    let to_centre = -anchor_on(scene, balls[0])?; // from the pivot, body axes
    let lever = to_centre.length();
    let gravity = scene.gravity.length();
    let down = scene.gravity / gravity;
    let start = first.rotation * to_centre / lever;
    let lifted = (start - start.dot(down) * down).normalize();
    let angle_of = move |along: DVec3| along.dot(lifted).atan2(along.dot(down));
    let swing = Swing::new(angle_of(start), gravity * lever / (lever * lever + 0.4 * radius * radius));

    let distance = move |sample: &Sample| {
        let angle = swing.angle(sample.time);
        let carrier = if angle >= 0.0 { 0 } else { balls.len() - 1 };
        let errors = balls.iter().enumerate().map(|(place, &body)| {
            let expected = if place == carrier { angle } else { 0.0 };
            (angle_of(sample.bodies[body].rotation * to_centre) - expected).abs()
        });
        Some(errors.fold(0.0, f64::max))
    };
    let fall = first.mass? * gravity * lever * (1.0 - start.dot(down));
    let truth = Truth::largest("angle of the balls", "rad", distance).with_uncertainty(UNCERTAINTY);
    Some(truth.with_energy_scale(EnergyScale::Known(fall)))
}
