//! An arm whose motors follow motions prescribed in time: the reference trajectory of its tip, kept in
//! `assets/reference/`, and the torques that the motors must exert, by the recursion of Newton and Euler from the angles
//! alone (Featherstone 2008, Rigid Body Dynamics Algorithms, 5.3).

use bevy::math::{DQuat, DVec3};

use crate::physics::{MotorTarget, PrescribedMotion};
use crate::scene::{JointSpec, SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::instant::{Instant, Table};
use super::table::rows;
use crate::lab::joined::joined;
use crate::lab::simulation::Sample;

/// The columns are the time, three angles, three torques and the tip.
const TABLE: &str = include_str!("../../../assets/reference/arm.csv");

/// Time from which on torques are compared, s: the first of the table's after the start, at which a method whose
/// velocities lag by half a substep has impulses that are not those of a whole step.
const FIRST: f64 = 0.05;

/// `at_end`: whether loads are those at the end of a step, or means over it.
pub(super) fn truth(scene: &SceneSpec, at_end: bool) -> Option<Truth> {
    let forearm = scene.bodies.len() - 1;
    let Some(ShapeSpec::Cuboid { size }) = scene.bodies[forearm].shape else { return None };
    let tip = 0.5 * size.x * DVec3::X;
    let mut table = Table::new(rows(TABLE).map(|row| (row[0], vec![DVec3::from_slice(&row[7..])])).collect());
    let distance =
        move |sample: &Sample| table.distance(vec![Instant::of_point(sample.time, &sample.bodies[forearm], tip)]);
    let arm = Arm::of(scene)?;
    let peaks: Vec<f64> =
        (0..arm.links.len()).map(|link| rows(TABLE).map(|row| row[4 + link].abs()).fold(0.0, f64::max)).collect();
    let errors = move || {
        let (arm, mut before) = (arm.clone(), 0.0);
        move |sample: &Sample| {
            let from = std::mem::replace(&mut before, sample.time);
            (from >= FIRST && !sample.loads.is_empty())
                .then(|| arm.errors(sample, if at_end { sample.time } else { from }))
        }
    };
    let (mut absolute, mut relative) = (errors.clone()(), errors());
    let absolute = move |sample: &Sample| Some(absolute(sample)?.into_iter().fold(0.0, f64::max));
    let relative = move |sample: &Sample| {
        let shares = relative(sample)?.into_iter().zip(&peaks).map(|(error, peak)| error / peak);
        Some(shares.fold(0.0, f64::max))
    };
    Some(
        Truth::largest("tip of the forearm", "m", distance)
            .with_energy_scale(EnergyScale::NotKept)
            .and(Truth::largest("torques of the motors", "N·m", absolute).of_loads())
            .and(Truth::largest("torques of the motors", "of their peaks", relative).of_loads()),
    )
}

/// A link with the hinge to the one before.
#[derive(Clone)]
struct Link {
    mass: f64,
    /// Principal, kg·m².
    inertia: DVec3,
    /// The hinge, from the centre of the link before and of this one, body axes, m.
    anchors: [DVec3; 2],
    /// Of the hinge in the link before.
    axis: DVec3,
    motion: PrescribedMotion,
}

/// Links in series, from the ground outwards, whose axes are the world's where all angles are zero.
#[derive(Clone)]
struct Arm {
    links: Vec<Link>,
    gravity: DVec3,
}

/// What a link does at a time.
#[derive(Clone, Copy, Default)]
struct Motion {
    rotation: DQuat,
    angular: DVec3,
    angular_acceleration: DVec3,
    acceleration: DVec3,
}

impl Motion {
    /// Acceleration of a point of the link that far from its centre, world axes, m/s².
    fn at(&self, arm: DVec3) -> DVec3 {
        let turning = self.angular_acceleration.cross(arm) + self.angular.cross(self.angular.cross(arm));
        self.acceleration + turning
    }
}

impl Arm {
    fn of(scene: &SceneSpec) -> Option<Self> {
        let link = |(joint, ends): (&JointSpec, [usize; 2])| {
            let body = &scene.bodies[ends[1]];
            let (mass, Some(ShapeSpec::Cuboid { size })) = (body.mass?, &body.shape) else { return None };
            let MotorTarget::Motion(motion) = joint.motor?.target else { return None };
            let squares = *size * *size;
            let inertia = mass / 12.0 * (DVec3::splat(squares.element_sum()) - squares);
            let axis = joint.axes.frames(ends.map(|end| scene.bodies[end].rotation))[0] * DVec3::X;
            Some(Link { mass, inertia, anchors: [joint.anchor_a, joint.anchor_b], axis, motion })
        };
        Some(Self { links: joined(scene).map(link).collect::<Option<_>>()?, gravity: scene.gravity })
    }

    /// The axis of each hinge, and the torque on the link beyond it about the hinge, N·m, world axes.
    fn torques(&self, time: f64) -> Vec<(DVec3, DVec3)> {
        let mut before = Motion::default();
        let outward = self.links.iter().map(|link| {
            let [angle, rate, gain] = link.motion.at_time(time);
            let axis = before.rotation * link.axis;
            let rotation = DQuat::from_axis_angle(axis, angle) * before.rotation;
            let angular = before.angular + rate * axis;
            let angular_acceleration = before.angular_acceleration + gain * axis + before.angular.cross(rate * axis);
            let hinge = before.at(before.rotation * link.anchors[0]);
            let of_hinge = Motion { rotation, angular, angular_acceleration, acceleration: hinge };
            before = Motion { acceleration: of_hinge.at(rotation * -link.anchors[1]), ..of_hinge };
            (before, axis)
        });
        let motions: Vec<(Motion, DVec3)> = outward.collect();
        // Force and torque that the links beyond ask of this one, at their hinge, from this link's centre.
        let (mut force, mut torque, mut at) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        let mut torques = Vec::new();
        for (link, (motion, axis)) in self.links.iter().zip(&motions).rev() {
            let to_body = motion.rotation.inverse();
            let spin = motion.rotation * (link.inertia * (to_body * motion.angular));
            let gain = motion.rotation * (link.inertia * (to_body * motion.angular_acceleration));
            let own = link.mass * (motion.acceleration - self.gravity);
            let hinge = motion.rotation * link.anchors[1];
            torque += gain + motion.angular.cross(spin) + (at - hinge).cross(force) - hinge.cross(own);
            force += own;
            torques.push((*axis, torque));
            let inner = torques.len() - 1;
            let before =
                self.links.len().checked_sub(inner + 2).map_or(DQuat::IDENTITY, |place| motions[place].0.rotation);
            at = before * link.anchors[0];
        }
        torques.reverse();
        torques
    }

    /// How far the motors' torques are off from their means from that time to the sample's, N·m.
    fn errors(&self, sample: &Sample, from: f64) -> Vec<f64> {
        let (middle, half) = (0.5 * (from + sample.time), 0.5 * (sample.time - from));
        // Gauss's quadrature of order 6.
        let points = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
        let at = points.map(|(node, weight)| (self.torques(middle + half * node), weight));
        let error = |hinge: usize| {
            let mean: DVec3 = at.iter().map(|(torques, weight)| *weight * torques[hinge].1).sum();
            // The axis of the middle: across it the error is of no motor.
            (sample.loads[hinge].torque - mean).dot(at[1].0[hinge].0).abs()
        };
        (0..self.links.len()).map(error).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    #[test]
    fn torques_are_those_of_the_reference_table() {
        let arm = Arm::of(&load("arm", &[]).expect("a scene")).expect("an arm");
        for row in rows(TABLE) {
            for (hinge, (axis, torque)) in arm.torques(row[0]).into_iter().enumerate() {
                let error = (torque.dot(axis) - row[4 + hinge]).abs();
                assert!(error < 1e-9, "hinge {hinge} at {} s: {error:e} N·m", row[0]);
            }
        }
    }
}
