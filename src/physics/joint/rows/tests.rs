use simba::simd::{SimdValue, WideF32x8};

use super::*;
use crate::physics::joint::{PrescribedMotion, Softness};
use crate::physics::testing::Random;

/// Two bodies with a frame each.
#[derive(Clone, Copy)]
struct Pair {
    frames: [Frame; 2],
    offset: Vector3<f64>,
    rotations: [UnitQuaternion<f64>; 2],
    velocities: [Twist<f64>; 2],
}

impl Pair {
    /// Frames apart by up to so much, in m and about so many rad.
    fn random(random: &mut Random, apart: f64) -> Self {
        let frames = [0; 2].map(|_| Frame { anchor: random.vector(), rotation: random.rotation() });
        let rotation_a = random.rotation();
        let turned = UnitQuaternion::from_scaled_axis(random.vector() * apart);
        let rotation_b = rotation_a * frames[0].rotation * turned * frames[1].rotation.inverse();
        let arms = rotation_a * frames[0].anchor - rotation_b * frames[1].anchor;
        let velocities = [0; 2].map(|_| Twist { linear: random.vector(), angular: random.vector() });
        Self { frames, offset: arms + random.vector() * apart, rotations: [rotation_a, rotation_b], velocities }
    }

    fn state(&self) -> JointState<f64> {
        JointState::new(&self.frames, self.offset, self.rotations, self.velocities)
    }

    /// After so long without forces.
    fn later(&self, time: f64) -> JointState<f64> {
        let [a, b] = &self.velocities;
        let turned = [0, 1]
            .map(|body| UnitQuaternion::from_scaled_axis(self.velocities[body].angular * time) * self.rotations[body]);
        JointState::new(&self.frames, self.offset + (b.linear - a.linear) * time, turned, self.velocities)
    }
}

/// All 64 joints that lock some coordinates.
fn definitions() -> impl Iterator<Item = JointDefinition> {
    let hold = |bits: u32| Laws {
        hold: [0, 1, 2].map(|k| [Hold::Free, Hold::Locked][(bits >> k & 1) as usize]),
        spring: None,
    };
    (0..64).map(move |bits| JointDefinition {
        translation: hold(bits),
        rotation: hold(bits >> 3),
        ..Default::default()
    })
}

fn rows(definition: &JointDefinition, state: &JointState<f64>) -> Vec<JointRow<f64>> {
    let mut rows = Vec::new();
    definition.rows(state, &mut rows);
    rows
}

#[test]
fn rates_and_velocity_terms_are_the_derivatives_of_errors() {
    let random = &mut Random::new(40);
    for definition in definitions() {
        let locked = definition.translation.locked() + definition.rotation.locked();
        for _ in 0..20 {
            let pair = Pair::random(random, 1.0);
            let at = |time: f64| rows(&definition, &pair.later(time));
            let now = rows(&definition, &pair.state());
            assert_eq!(now.len(), locked);
            // Central differences: errors of 1e-5², and of rounding over 1e-4².
            let (short, long) = (1e-5, 1e-4);
            let around = [at(-short), at(short), at(-long), at(long)];
            for (index, row) in now.iter().enumerate() {
                let [before, after, early, late] = around.each_ref().map(|rows| rows[index].error);
                let rate = (after - before) / (2.0 * short);
                assert!((row.rate - rate).abs() < 1e-8, "row {index} of {definition:?}: {} or {rate}", row.rate);
                let second = (early - 2.0 * row.error + late) / (long * long);
                let message = format!("row {index} of {definition:?}: {} or {second}", row.velocity_term);
                assert!((row.velocity_term - second).abs() < 1e-6, "{message}");
            }
        }
    }
}

#[test]
fn errors_are_the_coordinates_that_are_locked() {
    let random = &mut Random::new(41);
    for _ in 0..200 {
        let mut pair = Pair::random(random, 0.0);
        // B's frame turned in A's by a twist, then a swing at an angle from y to z, and moved along A's axes.
        let (twist, swing, at) = (random.within(-2.5, 2.5), random.within(0.0, 1.4), random.within(-3.0, 3.0));
        let moved = random.vector();
        let about = Vector3::new(0.0, at.cos(), at.sin());
        let turned =
            UnitQuaternion::from_scaled_axis(about * swing) * UnitQuaternion::from_scaled_axis(Vector3::x() * twist);
        let frame_a = pair.rotations[0] * pair.frames[0].rotation;
        pair.rotations[1] = frame_a * turned * pair.frames[1].rotation.inverse();
        pair.offset =
            pair.rotations[0] * pair.frames[0].anchor - pair.rotations[1] * pair.frames[1].anchor + frame_a * moved;
        let world = frame_a * moved;
        let half = turned.imag() * 2.0 * turned.w.signum();
        for definition in definitions() {
            let along = if definition.translation.locked() == 3 { world } else { moved };
            let together = definition.rotation.locked() == 3;
            let across =
                if together { half } else { Vector3::new(twist, swing.sin() * at.cos(), swing.sin() * at.sin()) };
            let expected = [(&definition.translation, along), (&definition.rotation, across)];
            let expected = expected
                .iter()
                .flat_map(|(laws, values)| (0..3).filter(|&k| laws.hold[k] == Hold::Locked).map(|k| values[k]));
            for (row, expected) in rows(&definition, &pair.state()).iter().zip(expected) {
                assert!((row.error - expected).abs() < 1e-12, "{} instead of {expected}: {definition:?}", row.error);
            }
        }
    }
}

#[test]
fn a_twist_at_half_a_turn_of_swing_is_dropped() {
    let mut pair = Pair::random(&mut Random::new(42), 0.0);
    pair.rotations[1] = pair.rotations[0]
        * pair.frames[0].rotation
        * UnitQuaternion::from_scaled_axis(Vector3::y() * std::f64::consts::PI)
        * pair.frames[1].rotation.inverse();
    let rotation = Laws { hold: [Hold::Locked, Hold::Free, Hold::Free], spring: None };
    let [row] = rows(&JointDefinition { rotation, ..Default::default() }, &pair.state())[..] else { unreachable!() };
    assert_eq!(row.jacobian.angular_b, Vector3::zeros());
    assert_eq!([row.error, row.rate, row.velocity_term], [0.0; 3]);
}

#[test]
fn a_spring_bounds_the_norm_over_its_group() {
    let spring = Softness { frequency: 2.0, damping_ratio: 0.5, max_force: 7.0 };
    let translation = Laws { hold: [Hold::Locked, Hold::Free, Hold::Locked], spring: Some(spring) };
    let definition = JointDefinition { translation, rotation: Laws::LOCKED, ..Default::default() };
    let rows = rows(&definition, &Pair::random(&mut Random::new(43), 1.0).state());
    let bounds: Vec<_> = rows.iter().map(|row| (row.spring, row.bound)).collect();
    let soft = |place| (Some(spring.into()), Bound::Norm { most: 7.0, place, count: 2 });
    assert_eq!(bounds, [soft(0), soft(1), (None, Bound::None), (None, Bound::None), (None, Bound::None)]);
}

#[test]
fn eight_lanes_make_the_rows_of_eight_joints() {
    let random = &mut Random::new(44);
    let frames = [0; 2].map(|_| Frame { anchor: random.vector(), rotation: random.rotation() });
    let pairs: [Pair; 8] = std::array::from_fn(|_| Pair { frames, ..Pair::random(random, 0.7) });
    let wide = |value: &dyn Fn(&Pair) -> f64| {
        let mut lanes = WideF32x8::splat(0.0);
        pairs.iter().enumerate().for_each(|(lane, pair)| lanes.replace(lane, value(pair) as f32));
        lanes
    };
    let vector = |of: &dyn Fn(&Pair) -> Vector3<f64>| Vector3::from_fn(|k, _| wide(&|pair| of(pair)[k]));
    let rotations = [0, 1].map(|body| {
        let number = |k: usize| wide(&|pair: &Pair| pair.rotations[body].coords[k]);
        UnitQuaternion::new_unchecked(Quaternion::new(number(3), number(0), number(1), number(2)))
    });
    let velocities = [0, 1].map(|body| Twist {
        linear: vector(&|pair| pair.velocities[body].linear),
        angular: vector(&|pair| pair.velocities[body].angular),
    });
    let state = JointState::new(&frames, vector(&|pair| pair.offset), rotations, velocities);
    for definition in definitions() {
        let mut lanes = Vec::new();
        definition.rows(&state, &mut lanes);
        for (lane, pair) in pairs.iter().enumerate() {
            for (single, wide) in rows(&definition, &pair.state()).iter().zip(&lanes) {
                // `f32` is off by 6e-8 of each of some hundred products, of which some are ten times what is left.
                let close = |a: f64, b: WideF32x8| (a - f64::from(b.extract(lane))).abs() < 1e-4 * (1.0 + a.abs());
                assert!(close(single.error, wide.error) && close(single.rate, wide.rate), "{definition:?}");
                assert!(close(single.velocity_term, wide.velocity_term), "{definition:?}");
            }
        }
    }
}

/// A law of every coordinate and every turning, as a joint that is nothing else.
fn laws() -> impl Iterator<Item = JointDefinition> {
    use crate::physics::joint::JointAxis::{Distance, Swing, Twist, X, Y, Z};
    let coordinates = [X, Y, Z, Twist, Swing, Distance].map(LawAxis::Coordinate);
    let sine = PrescribedMotion::Sine { mean: 0.3, amplitude: 0.7, angular_frequency: 2.0, phase: 0.4 };
    let parts = [LawPart::Limit { bound: 0.2, is_upper: true, restitution: 0.5 }, LawPart::Motion(sine)];
    let of_coordinates = coordinates.into_iter().flat_map(move |axis| parts.map(|part| (axis, part)));
    let of_turning = (0..3).map(|axis| (LawAxis::Turning(axis), LawPart::Rate(0.0)));
    of_coordinates.chain(of_turning).map(|(axis, part)| JointDefinition {
        laws: Some([CoordinateLaw { axis, part, most: f64::INFINITY }].into()),
        ..Default::default()
    })
}

#[test]
fn rows_of_laws_are_the_derivatives_of_their_errors() {
    let random = &mut Random::new(45);
    for definition in laws() {
        let law = definition.laws.as_ref().unwrap()[0];
        for _ in 0..20 {
            let pair = Pair::random(random, 1.0);
            let start = random.within(0.0, 3.0);
            let at = |time: f64| {
                let coordinate = law_coordinate(law.axis, &pair.later(time), definition.turned);
                law_row(&law, coordinate, start + time)
            };
            let now = at(0.0);
            // Central differences: errors of 1e-5², and of rounding over 1e-4²; near half a turn the twist bends.
            let (short, long) = (1e-5, 1e-4);
            let [before, after, early, late] = [-short, short, -long, long].map(|time| at(time).error);
            let rates = [at(-short).rate, at(short).rate];
            let (rate, second) = match law.axis {
                LawAxis::Coordinate(_) => {
                    ((after - before) / (2.0 * short), (early - 2.0 * now.error + late) / (long * long))
                }
                // It has no coordinate: the change of its rate.
                LawAxis::Turning(_) => (now.rate, (rates[1] - rates[0]) / (2.0 * short)),
            };
            assert!((now.rate - rate).abs() < 1e-7, "{law:?}: {} or {rate}", now.rate);
            assert!(
                (now.velocity_term - second).abs() < 1e-5 * (1.0 + second.abs()),
                "{law:?}: {} or {second}",
                now.velocity_term
            );
            let twists = &pair.velocities;
            let moved = now.jacobian.dot(&twists[0], &twists[1]) + now.time_rate;
            assert!((moved - now.rate).abs() < 1e-12, "{law:?}: J v is {moved}, the rate {}", now.rate);
        }
    }
}

#[test]
fn a_twist_is_the_value_nearest_to_the_last() {
    let mut pair = Pair::random(&mut Random::new(46), 0.0);
    for turned in [-7.0, -3.0, 0.0, 3.5, 20.0] {
        let angle = turned + 0.8;
        pair.rotations[1] = pair.rotations[0]
            * pair.frames[0].rotation
            * UnitQuaternion::from_scaled_axis(Vector3::x() * angle)
            * pair.frames[1].rotation.inverse();
        let row = coordinate(JointAxis::Twist, &pair.state(), turned);
        assert!((row.error - angle).abs() < 1e-12, "{} instead of {angle}", row.error);
    }
}
