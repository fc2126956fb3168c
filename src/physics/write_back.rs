//! `WriteBack`: from packed arrays to the ECS, as changes.
//!
//! A body whose state is no longer finite goes back to the state it had before the step, frozen
//! and reported.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::bodies::{Bodies, Body, Joints};
use super::body::{BodySlot, Position, QuarantineReason, Quarantined, RigidBody, Rotation, Velocity};
use super::diagnostics::StepStats;
use super::joint::JointLoad;
use super::messages::BodyQuarantined;
use super::settings::SolverSettings;
use super::transform::PoseHistory;
use super::{PhysicsSchedule, PhysicsSystems};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(PhysicsSchedule, (write_bodies, write_joint_loads, count_step).in_set(PhysicsSystems::WriteBack));
}

fn is_finite(body: &Body) -> bool {
    let rotation = body.rotation.coords;
    let all = [body.position, body.linear, body.angular].iter().all(|v| v.iter().all(|x| x.is_finite()));
    all && rotation.iter().all(|x| x.is_finite())
}

fn write_bodies(
    mut query: Query<(&BodySlot, &mut Position, &mut Rotation, &mut Velocity, &mut PoseHistory), With<RigidBody>>,
    mut bodies: ResMut<Bodies>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
) {
    for (slot, mut position, mut rotation, mut velocity, mut history) in &mut query {
        let body = &mut bodies.list[slot.index as usize];
        history.previous = Some((position.0, rotation.0));
        if body.kind == RigidBody::Static {
            continue;
        }
        if !is_finite(body) {
            body.position = position.0.into();
            body.rotation = UnitQuaternion::new_normalize(rotation.0.into());
            body.linear = Vector3::zeros();
            body.angular = Vector3::zeros();
            *velocity = Velocity::default();
            stats.quarantined += 1;
            let (entity, reason) = (body.entity, QuarantineReason::NotFinite);
            commands.entity(entity).insert(Quarantined { reason });
            commands.trigger(BodyQuarantined { entity, reason });
            quarantine.write(BodyQuarantined { entity, reason });
            continue;
        }
        position.0 = DVec3::from(body.position);
        rotation.0 = DQuat::from(body.rotation);
        velocity.linear = body.linear.into();
        velocity.angular = body.angular.into();
    }
}

fn write_joint_loads(joints: Res<Joints>, mut loads: Query<&mut JointLoad>) {
    if loads.is_empty() {
        return;
    }
    for joint in &joints.list {
        if let Ok(mut load) = loads.get_mut(joint.entity) {
            let force = DVec3::from(joint.force);
            *load = JointLoad { force, torque: DVec3::ZERO, lambda: force.length() };
        }
    }
}

fn count_step(settings: Res<SolverSettings>, mut stats: ResMut<StepStats>) {
    stats.count_step(&settings);
}
