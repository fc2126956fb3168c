use bevy::prelude::Entity;
use nalgebra::{UnitQuaternion, Vector3};

use super::{System, drift, euler, kick, verlet};
use crate::physics::body::Body;
use crate::physics::constraint::row::Twist;
use crate::physics::solver::sweeps::local::LocalBody;

/// One body of 2 kg held to the origin by a spring of ω² = `stiffness`.
struct Oscillator {
    body: LocalBody,
    stiffness: f64,
    pull: Twist<f64>,
    solves: u32,
}

impl Oscillator {
    fn new(stiffness: f64) -> Self {
        let mut body = Body::new(Entity::PLACEHOLDER);
        body.mass = 2.0;
        body.inverse_mass = Vector3::repeat(0.5);
        body.inverse_inertia_body = Vector3::repeat(4.0);
        Self { body: LocalBody::new(0, &body), stiffness, pull: Twist::zero(), solves: 0 }
    }

    fn run(&mut self, substep: impl Fn(&mut Self, f64), steps: u32, time: f64) {
        for _ in 0..steps {
            substep(self, time / f64::from(steps));
        }
    }
}

impl System for Oscillator {
    fn solve(&mut self, _h: f64) {
        self.solves += 1;
        self.pull.linear = -self.body.body.position * self.stiffness;
    }
    fn kick(&mut self, h: f64) {
        kick(&mut self.body, &self.pull, h);
    }
    fn drift(&mut self, h: f64) {
        drift(&mut self.body, h);
    }
    fn move_contacts(&mut self) {}
}

type Substep = fn(&mut Oscillator, f64);
const EULER: Substep = |system, h| euler(system, h);
const VERLET: Substep = |system, h| verlet(system, h);

/// Distance from cos ωt after 0.7 s.
fn oscillator_error(substep: Substep, steps: u32) -> f64 {
    let mut system = Oscillator::new(9.0);
    system.body.body.position.x = 1.0;
    system.run(substep, steps, 0.7);
    (system.body.body.position.x - (3.0_f64 * 0.7).cos()).abs()
}

#[test]
fn euler_is_of_first_order_and_verlet_of_second() {
    for (substep, order) in [(EULER, 1.0), (VERLET, 2.0)] {
        let measured = (oscillator_error(substep, 400) / oscillator_error(substep, 800)).log2();
        assert!((measured - order).abs() < 0.05, "order {measured} instead of {order}");
    }
}

#[test]
fn verlet_is_exact_under_constant_force_and_solves_twice() {
    let mut system = Oscillator::new(0.0);
    system.body.body.force = Vector3::new(3.0, -19.62, 1.0);
    system.body.body.linear = Vector3::new(1.0, 2.0, 3.0);
    system.run(VERLET, 10, 1.0);
    let expected = Vector3::new(1.0, 2.0, 3.0) + system.body.body.force * 0.5 * 0.5;
    assert!((system.body.body.position - expected).norm() < 1e-13, "{}", system.body.body.position);
    assert_eq!(system.solves, 20);
}

#[test]
fn euler_moves_with_the_new_velocity() {
    let mut system = Oscillator::new(0.0);
    system.body.body.force = Vector3::y() * 2.0;
    system.body.body.torque = Vector3::z() * 3.0;
    system.run(EULER, 1, 0.1);
    // a = F/m = 1: v = 0.1, x = 0.1 · 0.1. α = I⁻¹τ = 12: ω = 1.2, and half the turn has the
    // tangent ½ h ω.
    assert!((system.body.body.position.y - 0.01).abs() < 1e-16);
    let expected = UnitQuaternion::from_scaled_axis(Vector3::z() * (2.0 * 0.06_f64.atan()));
    assert!(system.body.body.rotation.angle_to(&expected) < 1e-7, "{}", system.body.body.rotation);
    assert!((system.body.body.rotation.k - expected.k).abs() < 1e-15);
}

#[test]
fn drag_divides_the_velocity_after_forces() {
    let mut system = Oscillator::new(0.0);
    system.body.body.drag = (0.5, 2.0);
    system.body.body.linear.x = 4.0;
    system.body.body.angular.y = 4.0;
    system.body.body.force.x = 2.0;
    system.run(EULER, 1, 0.1);
    assert!((system.body.body.linear.x - 4.1 / 1.05).abs() < 1e-15);
    assert!((system.body.body.angular.y - 4.0 / 1.2).abs() < 1e-15);
}

#[test]
fn rotation_is_of_second_order_and_stays_unit() {
    let spin = Vector3::new(1.0, -2.0, 0.5);
    let error = |steps| {
        let mut system = Oscillator::new(0.0);
        system.body.body.angular = spin;
        system.run(EULER, steps, 1.0);
        assert!((system.body.body.rotation.norm() - 1.0).abs() < 1e-14);
        (system.body.body.rotation.into_inner() - UnitQuaternion::from_scaled_axis(spin).into_inner()).norm()
    };
    let order = (error(100) / error(200)).log2();
    assert!((order - 2.0).abs() < 0.05, "order {order}");
}

/// Renormalised, a step turns by 2 atan(ω h/2) instead of ω h: by (ω h)³/12 too little.
#[test]
fn a_step_turns_too_little_by_a_twelfth_of_the_cube_of_its_angle() {
    for angle in [0.01_f64, 0.03, 0.1, 0.3] {
        let mut system = Oscillator::new(0.0);
        let axis = Vector3::new(0.6, 0.0, 0.8);
        system.body.body.angular = axis * 60.0 * angle;
        system.run(EULER, 1, 1.0 / 60.0);
        let short = angle - system.body.body.rotation.scaled_axis().dot(&axis);
        let expected = angle.powi(3) / 12.0;
        assert!((short / expected - 1.0).abs() < 0.2 * angle * angle + 1e-5, "{angle} rad: {short}, not {expected}");
    }
}
