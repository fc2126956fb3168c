//! A rod whose lower edge slides on the ground: motion in a plane under gravity, a normal force
//! N ≥ 0 and friction −μN along the slip.
//!
//! With r from the centre of mass to the edge, s the sign of the slip, m k² the moment of inertia
//! and ω̇ = (N/m)(rₓ + μ s r_y)/k², the edge stays on the ground where
//!   (N/m) D = g + ω² r_y,  D = m n·W(n − μ t̂) = 1 + rₓ(rₓ + μ s r_y)/k².
//! For D > 0 that is an ordinary differential equation till the edge lifts off (N = 0), slip stops,
//! or another edge meets the ground. For D ≤ 0 no rigid motion exists (Painlevé 1895); then all
//! that is asked is that no energy is gained.

use bevy::math::{DVec2, DVec3};

use crate::physics::RigidBody;
use crate::scene::{BodySpec, SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let rod = &scene.bodies[index];
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let friction = (rod.material.friction * ground.material.friction).sqrt();
    let (slide, start) = Slide::new(rod, friction, scene.gravity.length())?;
    if slide.upward_gain(&start) <= 0.0 {
        return Some(no_energy_gained(index, rod, &slide));
    }
    let (half_length, edge) = (slide.half_length, slide.edge);
    let mut motion = Some(Motion { time: 0.0, state: start, step: FIRST_STEP });
    let distance = move |sample: &Sample| {
        motion = motion.take().and_then(|motion| motion.until(sample.time, &slide));
        let state = motion.as_ref()?.state;
        let body = sample.bodies[index];
        let errors = [edge, DVec2::new(half_length, 0.0)].map(|point| {
            let expected = state.place + turned(point - edge, state.angle);
            (body.position + body.rotation * point.extend(0.0)).distance(expected.extend(0.0))
        });
        Some(errors[0].max(errors[1]))
    };
    Some(Truth::largest("ends of the sliding rod", "m", distance).with_uncertainty(UNCERTAINTY))
}

fn no_energy_gained(index: usize, rod: &BodySpec, slide: &Slide) -> Truth {
    let mass = rod.mass.unwrap_or_else(|| rod.density * rod.shape.as_ref().map_or(0.0, ShapeSpec::volume));
    let (gravity, square_radius) = (slide.gravity, slide.square_radius);
    let energy = move |height: f64, linear: DVec3, angular: DVec3| {
        mass * (0.5 * linear.length_squared() + 0.5 * square_radius * angular.z * angular.z + gravity * height)
    };
    let start = energy(rod.position.y, rod.linear_velocity, rod.angular_velocity);
    let distance = move |sample: &Sample| {
        let body = sample.bodies[index];
        Some((energy(body.position.y, body.linear, body.angular) - start).max(0.0))
    };
    Truth::largest("energy gained where no rigid motion exists", "J", distance)
}

/// What stays the same of a rod in the plane z = 0, its long axis x.
#[derive(Clone, Copy, Debug)]
struct Slide {
    gravity: f64,
    friction: f64,
    /// k² = I/m, m².
    square_radius: f64,
    half_length: f64,
    /// The edge on the ground from the centre of mass, body axes.
    edge: DVec2,
}

/// The edge's place and velocity along the ground; the rod's angle and rate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    place: DVec2,
    speed: f64,
    angle: f64,
    rate: f64,
}

impl Slide {
    fn new(rod: &BodySpec, friction: f64, gravity: f64) -> Option<(Self, State)> {
        let Some(ShapeSpec::Cuboid { size }) = rod.shape else { return None };
        let along = rod.rotation * DVec3::X;
        let angle = along.y.atan2(along.x);
        let corners = [DVec2::ONE, DVec2::new(-1.0, 1.0), DVec2::NEG_ONE, DVec2::new(1.0, -1.0)];
        let height = |corner: &DVec2| turned(*corner, angle).y;
        let edge = corners
            .map(|corner| 0.5 * corner * DVec2::new(size.x, size.y))
            .into_iter()
            .min_by(|a, b| height(a).total_cmp(&height(b)))?;
        let arm = turned(edge, angle);
        let rate = rod.angular_velocity.z;
        let state =
            State { place: rod.position.truncate() + arm, speed: rod.linear_velocity.x - rate * arm.y, angle, rate };
        let square_radius = (size.x * size.x + size.y * size.y) / 12.0;
        Some((Self { gravity, friction, square_radius, half_length: 0.5 * size.x, edge }, state))
    }

    /// D: how the edge accelerates upwards per unit of N/m.
    fn upward_gain(&self, state: &State) -> f64 {
        let arm = turned(self.edge, state.angle);
        1.0 + arm.x * self.turning(arm, state) / self.square_radius
    }

    /// Torque about the centre of mass per unit of N.
    fn turning(&self, arm: DVec2, state: &State) -> f64 {
        arm.x + self.friction * state.speed.signum() * arm.y
    }

    /// N/m.
    fn support(&self, state: &State) -> f64 {
        let arm = turned(self.edge, state.angle);
        (self.gravity + state.rate * state.rate * arm.y) / self.upward_gain(state)
    }

    /// Whether the edge slides on the ground, alone, and a rigid motion exists.
    fn holds(&self, state: &State, slip: f64) -> bool {
        let arm = turned(self.edge, state.angle);
        // The rod lies flat, or stands on its end, where a neighbour of the edge is as low.
        let alone = [-1.0, 1.0].iter().all(|sign| {
            let neighbour = self.edge * DVec2::new(*sign, -sign);
            turned(neighbour, state.angle).y > arm.y
        });
        alone && self.upward_gain(state) > 0.0 && self.support(state) > 0.0 && state.speed * slip > 0.0
    }

    /// The state's rate of change.
    fn slope(&self, state: &State) -> State {
        let arm = turned(self.edge, state.angle);
        let support = self.support(state);
        let turning = support * self.turning(arm, state) / self.square_radius;
        let friction = -self.friction * state.speed.signum() * support;
        State {
            place: DVec2::new(state.speed, 0.0),
            speed: friction - turning * arm.y - state.rate * state.rate * arm.x,
            angle: state.rate,
            rate: turning,
        }
    }

    /// One step of the classical Runge–Kutta method.
    fn advance(&self, state: &State, step: f64) -> State {
        let k1 = self.slope(state);
        let k2 = self.slope(&state.plus(&k1, 0.5 * step));
        let k3 = self.slope(&state.plus(&k2, 0.5 * step));
        let k4 = self.slope(&state.plus(&k3, step));
        state.plus(&k1, step / 6.0).plus(&k2, step / 3.0).plus(&k3, step / 3.0).plus(&k4, step / 6.0)
    }
}

impl State {
    fn plus(&self, slope: &Self, by: f64) -> Self {
        Self {
            place: self.place + by * slope.place,
            speed: self.speed + by * slope.speed,
            angle: self.angle + by * slope.angle,
            rate: self.rate + by * slope.rate,
        }
    }

    fn distance(&self, other: &Self) -> f64 {
        [self.place.distance(other.place), self.speed - other.speed, self.angle - other.angle, self.rate - other.rate]
            .into_iter()
            .fold(0.0, |largest, difference| largest.max(difference.abs()))
    }
}

/// A state on its way, with the step that did well last.
#[derive(Clone, Copy, Debug)]
struct Motion {
    time: f64,
    state: State,
    step: f64,
}

/// s.
const FIRST_STEP: f64 = 1e-4;
/// Steps shorter than this, s, mean that the equation ends here.
const LEAST_STEP: f64 = 1e-13;
/// Difference between one step and two of half its length: m, m/s, rad and rad/s.
const TOLERANCE: f64 = 1e-11;
/// What those differences come to over the whole motion, m.
const UNCERTAINTY: f64 = 1e-9;

impl Motion {
    /// On to a time; none where the equation ends before.
    fn until(mut self, time: f64, slide: &Slide) -> Option<Self> {
        let slip = self.state.speed;
        while self.time < time {
            let step = self.step.min(time - self.time);
            let whole = slide.advance(&self.state, step);
            let middle = slide.advance(&self.state, 0.5 * step);
            let halves = slide.advance(&middle, 0.5 * step);
            let error = whole.distance(&halves);
            if error <= TOLERANCE && slide.holds(&middle, slip) && slide.holds(&halves, slip) {
                let done = step == time - self.time;
                self = Self {
                    time: if done { time } else { self.time + step },
                    state: halves,
                    step: if error < TOLERANCE / 64.0 { 2.0 * self.step } else { self.step },
                };
            } else if step < LEAST_STEP {
                return None;
            } else {
                self.step = 0.5 * step;
            }
        }
        slide.holds(&self.state, slip).then_some(self)
    }
}

fn turned(vector: DVec2, angle: f64) -> DVec2 {
    DVec2::from_angle(angle).rotate(vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    fn slide(friction: f64) -> (Slide, State) {
        let scene = load("painleve", &[("mu".to_owned(), friction)]).expect("a scene");
        Slide::new(&scene.bodies[1], friction, 9.81).expect("a rod")
    }

    /// Where the equation ends, to a hundredth of a millisecond.
    fn end(friction: f64) -> Motion {
        let (slide, start) = slide(friction);
        let mut motion = Motion { time: 0.0, state: start, step: FIRST_STEP };
        while let Some(next) = motion.until(motion.time + 1e-5, &slide) {
            motion = next;
        }
        motion
    }

    #[test]
    fn a_thin_rod_starts_with_the_textbook_acceleration() {
        let (cos, sin) = (0.5, 0.75_f64.sqrt());
        for friction in [0.0, 0.5, 1.3, 1.5] {
            let (slide, start) = slide(friction);
            let thin = Slide { square_radius: 1.0 / 12.0, edge: DVec2::new(-0.5, 0.0), ..slide };
            // 1 + 3 cos θ (cos θ − μ sin θ), Génot and Brogliato 1999.
            let gain = 1.0 + 3.0 * cos * (cos - friction * sin);
            assert!((thin.upward_gain(&start) - gain).abs() < 1e-14, "{}", thin.upward_gain(&start));
            let slope = thin.slope(&start);
            let support = 9.81 / gain;
            assert!((slope.rate - 6.0 * support * (cos - friction * sin)).abs() < 1e-10);
            // Of the edge: what the turning adds to what friction takes.
            assert!((slope.speed - (slope.rate * 0.5 * sin - friction * support)).abs() < 1e-10);
        }
    }

    #[test]
    fn no_motion_exists_from_the_critical_friction_on() {
        // The edge is 0.25 − 0.005√3 beside and 0.25√3 + 0.005 below the centre of mass.
        let (beside, below) = (0.25 - 0.005 * 3_f64.sqrt(), 0.25 * 3_f64.sqrt() + 0.005);
        let critical = ((1.0 + 0.02 * 0.02) / 12.0 + beside * beside) / (beside * below);
        assert!((critical - 1.3396).abs() < 1e-4, "{critical}");
        let gain = |friction: f64| {
            let (slide, start) = slide(friction);
            slide.upward_gain(&start)
        };
        assert!(gain(critical).abs() < 1e-14);
        assert!(gain(critical - 1e-6) > 0.0 && gain(critical + 1e-6) < 0.0);
    }

    /// Solved elsewhere as three equations of motion and one constraint in x, y and angle, by
    /// Runge–Kutta steps of 10 µs: (end, x, y, angle, vx, vy, rate).
    #[test]
    fn the_edge_lifts_off_where_another_formulation_says() {
        let expected = [0.05613, -0.02422108, 0.4755019, 1.90573791, 3.49487427, 0.70363614, -4.54214619];
        let (slide, _) = slide(1.2);
        let Motion { time, state, .. } = end(1.2);
        let arm = turned(slide.edge, state.angle);
        let center = state.place - arm;
        let velocity = DVec2::new(state.speed, 0.0) - state.rate * arm.perp();
        let found = [time, center.x, center.y, state.angle, velocity.x, velocity.y, state.rate];
        for (found, expected) in found.into_iter().zip(expected) {
            // Ends are found to 10 µs at accelerations of up to 200 m/s².
            assert!((found - expected).abs() < 3e-3, "{found} {expected}");
        }
    }

    #[test]
    fn steps_are_short_enough_for_the_stated_uncertainty() {
        for friction in [0.3, 1.0, 1.2] {
            let (slide, start) = slide(friction);
            let last = end(friction);
            let steps = 1 << 17;
            let fine = (0..steps).fold(start, |state, _| slide.advance(&state, last.time / f64::from(steps)));
            let error = fine.place.distance(last.state.place).max((fine.angle - last.state.angle).abs());
            assert!(error < UNCERTAINTY, "μ = {friction}: {error:e}");
        }
    }

    #[test]
    fn what_friction_takes_is_what_the_motion_loses() {
        let (slide, start) = slide(1.0);
        let energy = |state: &State| {
            let arm = turned(slide.edge, state.angle);
            let velocity = DVec2::new(state.speed, 0.0) - state.rate * arm.perp();
            0.5 * velocity.length_squared() + 0.5 * slide.square_radius * state.rate * state.rate
                - slide.gravity * arm.y
        };
        let mut motion = Motion { time: 0.0, state: start, step: FIRST_STEP };
        let power = |state: &State| slide.friction * slide.support(state) * state.speed;
        let (mut work, step) = (0.0, 1e-5);
        while let Some(next) = motion.until(motion.time + step, &slide) {
            work += 0.5 * step * (power(&motion.state) + power(&next.state));
            motion = next;
        }
        let lost = energy(&start) - energy(&motion.state);
        // The trapezoidal rule is off by h² of a power that changes by 1e4 W/s.
        assert!(lost > 1.0 && (lost - work).abs() < 1e-6, "{lost} J lost, {work} J of work");
    }
}
