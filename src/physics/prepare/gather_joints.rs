//! Joints: packed again only when one of them or the set of bodies changed.

use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;

use crate::physics::joint::any_changed;
use crate::physics::{
    BitSet, Bodies, BodyQuarantined, BodySlot, JoinedPairs, Joint, JointDefinition, JointSlot, Joints,
    QuarantineReason, Quarantined, Refill, RigidBody, Sleep, StepStats, set_aside,
};

/// What the joints were packed for. Counts tell that one is gone or was let go; events would be lost
/// in an app that runs many frames without a step.
#[derive(Resource, Clone, Copy, Default, PartialEq)]
pub(super) struct PackedFor {
    bodies: u64,
    joints: usize,
    quarantined: usize,
}

/// Whether the joints must be packed anew. A condition of its own: it needs little of the world.
pub(super) fn joints_changed(
    joints: Query<Ref<JointDefinition>>,
    quarantined: Query<(), (With<JointDefinition>, With<Quarantined>)>,
    bodies: Res<Bodies>,
    packed_for: Res<PackedFor>,
    ticks: SystemChangeTick,
) -> bool {
    let now = PackedFor { bodies: bodies.version, joints: joints.iter().len(), quarantined: quarantined.iter().len() };
    now != *packed_for || any_changed(&joints, &ticks)
}

/// Packs the joints.
pub(super) fn gather_joints(
    mut query: Query<(Entity, Ref<JointDefinition>, &mut JointSlot, Has<Quarantined>)>,
    members: Query<(&BodySlot, &RigidBody)>,
    bodies: Res<Bodies>,
    mut joints: ResMut<Joints>,
    mut joined: ResMut<JoinedPairs>,
    mut sleep: ResMut<Sleep>,
    mut packed_for: ResMut<PackedFor>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
) {
    *packed_for = PackedFor { bodies: bodies.version, ..default() };
    let member = |entity| {
        members.get(entity).ok().filter(|(slot, _)| slot.index != u32::MAX).map(|(slot, &kind)| (slot.index, kind))
    };
    let mut stays = vec![false; joints.list.len()];
    let mut packed: Vec<(u64, Joint)> = Vec::with_capacity(query.iter().len());
    for (entity, definition, mut slot, is_quarantined) in &mut query {
        let index_before = std::mem::replace(&mut slot.index, u32::MAX);
        let [Some((a, kind_a)), Some((b, kind_b))] = definition.bodies.map(member) else {
            commands.entity(entity).despawn();
            continue;
        };
        packed_for.joints += 1;
        if is_quarantined {
            packed_for.quarantined += 1;
            continue;
        }
        if let Err(reason) = check_joint(&definition, [kind_a, kind_b]) {
            set_aside(entity, reason, &mut commands, &mut quarantine);
            packed_for.quarantined += 1;
            continue;
        }
        // A joint that stays goes on from what it carried.
        let known = joints.list.get(index_before as usize).filter(|known| known.entity == entity);
        let mut joint = Joint::new(entity, [a, b], (*definition).clone());
        if let Some(known) = known.filter(|known| known.is_finite()) {
            (joint.force, joint.torque, joint.multipliers) = (known.force, known.torque, known.multipliers);
        }
        if known.is_some() && !definition.is_changed() {
            stays[index_before as usize] = true;
        } else {
            [a, b].into_iter().for_each(|body| sleep.disturb(body, &bodies));
        }
        packed.push((slot.born, joint));
    }
    for (joint, _) in joints.list.iter().zip(stays).filter(|(_, stays)| !stays) {
        let ends = [joint.a, joint.b].into_iter().filter(|&body| body != Joint::GONE);
        ends.for_each(|body| sleep.disturb(body, &bodies));
    }
    packed.sort_unstable_by_key(|&(born, _)| born);
    joints.version += 1;
    joints.list.refill(packed.into_iter().map(|(_, joint)| joint));
    let apart = joints.list.iter().filter(|joint| !joint.definition.collide);
    joined.rebuild(apart.map(|joint| (joint.a, joint.b)));
    let Joints { list, joined, driven, .. } = &mut *joints;
    *joined = BitSet::default();
    driven.clear();
    let functions = list.iter().filter(|joint| joint.definition.function.is_some());
    driven.extend(functions.flat_map(|joint| [joint.a, joint.b]));
    list.iter().flat_map(|joint| [joint.a, joint.b]).for_each(|body| joined.set(body, true));
    for (index, joint) in (0..).zip(&joints.list) {
        if let Ok((.., mut slot, _)) = query.get_mut(joint.entity) {
            slot.index = index;
        }
    }
    stats.joints = joints.list.len() as u32;
}

/// What is held by something that may change with time never rests.
pub(super) fn keep_driven_awake(joints: Res<Joints>, bodies: Res<Bodies>, mut sleep: ResMut<Sleep>) {
    joints.driven.iter().for_each(|&body| sleep.disturb(body, &bodies));
}

fn check_joint(joint: &JointDefinition, kinds: [RigidBody; 2]) -> Result<(), QuarantineReason> {
    if !joint.is_valid() {
        return Err(QuarantineReason::NotFinite);
    }
    if joint.bodies[0] == joint.bodies[1] || !kinds.contains(&RigidBody::Dynamic) {
        return Err(QuarantineReason::BadJoint);
    }
    Ok(())
}
