//! A pendulum that falls on a stop: in closed form to the stop, then at rest there, or up again with e times the speed
//! as a pendulum released lower, and so on.

use std::f64::consts::FRAC_PI_2;

use bevy::math::DVec3;

use crate::physics::JointLoad;
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::bodies::{anchor_on, dynamic};
use super::limits;
use super::pendulum::{Swing, UNCERTAINTY};
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let body = &scene.bodies[index];
    let (mass, Some(ShapeSpec::Cuboid { size })) = (body.mass?, &body.shape) else { return None };
    let to_centre = -anchor_on(scene, index)?;
    let (lever, gravity) = (to_centre.length(), scene.gravity.length());
    let squared_frequency = gravity * lever / ((size.x * size.x + size.y * size.y) / 12.0 + lever * lever);
    let above = |along: DVec3| along.y.atan2(along.x);
    let restitution = scene.joints.first()?.limits?.restitution;
    let fall = Fall::new(above(body.rotation * to_centre), squared_frequency, restitution);
    let first_stop = fall.stops[0];
    let distance =
        move |sample: &Sample| Some((above(sample.bodies[index].rotation * to_centre) - fall.angle(sample.time)).abs());
    let start = body.rotation * to_centre;
    let energy = mass * gravity * start.y;
    let truth = Truth::largest("angle of the rod", "rad", distance).with_uncertainty(UNCERTAINTY);
    let truth = truth.with_energy_scale(EnergyScale::Known(energy)).and(limits::overshoot(scene)?);
    Some(if restitution == 0.0 { truth.and(load_at_rest(mass * gravity * lever, first_stop)) } else { truth })
}

/// The torque that the limit bears, over what holds the rod level, m g L/2.
fn load_at_rest(torque: f64, from: f64) -> Truth {
    let distance = move |sample: &Sample| {
        let JointLoad { torque: load, .. } = sample.loads.first().filter(|_| sample.time > from + SETTLES)?;
        Some((load.z / torque - 1.0).abs())
    };
    Truth::largest("torque of the limit at rest", "of m g L/2", distance).of_loads()
}

/// Time after the impact in which a method may settle, s.
const SETTLES: f64 = 0.1;

/// The rod above the stop, which is level.
struct Fall {
    /// When it meets the stop, s.
    stops: Vec<f64>,
    /// Its motions between, as pendulums released at the middle of each.
    swings: Vec<Swing>,
}

/// Of a rod that bounces for ever, this many stops are told.
const MOST_STOPS: usize = 1000;

/// Angle, rad, that a rod no longer bounces to.
const LOWEST: f64 = 1e-14;

impl Fall {
    /// Released at rest that far above level, rad.
    fn new(start: f64, squared_frequency: f64, restitution: f64) -> Self {
        let (mut fall, mut height, mut time) = (Self { stops: Vec::new(), swings: Vec::new() }, start.sin(), 0.0);
        while height > LOWEST && fall.stops.len() < MOST_STOPS {
            let swing = Swing::new(FRAC_PI_2 + height.asin(), squared_frequency);
            let lasts = swing.time_to(FRAC_PI_2);
            // It is released half a fall after it left the stop.
            time += if fall.stops.is_empty() { lasts } else { 2.0 * lasts };
            fall.stops.push(time);
            fall.swings.push(swing);
            // ½I ω² = m g l sin of the angle.
            height *= restitution * restitution;
        }
        fall
    }

    /// Above level, rad.
    fn angle(&self, time: f64) -> f64 {
        let Some(place) = self.stops.iter().position(|stop| time < *stop) else { return 0.0 };
        let released = if place == 0 { 0.0 } else { 0.5 * (self.stops[place - 1] + self.stops[place]) };
        self.swings[place].angle(time - released) - FRAC_PI_2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_meets_the_stop_when_its_equation_of_motion_says() {
        let squared_frequency = 14.0;
        let fall = Fall::new(1.0, squared_frequency, 0.5);
        // Leapfrog in steps of 10 µs, up to each stop.
        let (mut angle, mut rate, mut time, step) = (1.0_f64, 0.0_f64, 0.0, 1e-5);
        for stop in &fall.stops[..3] {
            loop {
                let before = angle;
                rate -= step * squared_frequency * angle.cos() * if time == 0.0 { 0.5 } else { 1.0 };
                angle += step * rate;
                time += step;
                if angle < 0.0 && rate < 0.0 {
                    let late = step * angle / (angle - before);
                    assert!((time - late - stop).abs() < 1e-4, "{time}, not {stop}");
                    (angle, rate) = (0.0, -0.5 * rate);
                    break;
                }
            }
        }
        assert!(fall.angle(fall.stops[0]).abs() < 1e-12 && fall.angle(0.999 * fall.stops[0]) > 0.0);
        assert_eq!(fall.angle(1e9), 0.0);
    }
}
