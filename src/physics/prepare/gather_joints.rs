//! Joints: packed again only when one of them or the set of bodies changed.

use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;
use nalgebra::Vector3;

use crate::physics::bit_set::BitSet;
use crate::physics::body::Bodies;
use crate::physics::body::BodySlot;
use crate::physics::body::{QuarantineReason, Quarantined, RigidBody};
use crate::physics::joint::JointSlot;
use crate::physics::joint::{BallJoint, JoinedPairs, Softness};
use crate::physics::joint::{Joint, Joints};
use crate::physics::messages::{BodyQuarantined, set_aside};
use crate::physics::sleep::Sleep;
use crate::physics::stats::StepStats;

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
    joints: Query<Ref<BallJoint>>,
    quarantined: Query<(), (With<BallJoint>, With<Quarantined>)>,
    bodies: Res<Bodies>,
    packed_for: Res<PackedFor>,
    ticks: SystemChangeTick,
) -> bool {
    let now = PackedFor { bodies: bodies.version, joints: joints.iter().len(), quarantined: quarantined.iter().len() };
    now != *packed_for || any_changed(&joints, &ticks)
}

/// Packs the joints.
pub(super) fn gather_joints(
    mut query: Query<(Entity, Ref<BallJoint>, &mut JointSlot, Has<Quarantined>)>,
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
    let mut packed: Vec<(u64, Joint, bool)> = Vec::with_capacity(query.iter().len());
    for (entity, joint, mut slot, is_quarantined) in &mut query {
        let index_before = std::mem::replace(&mut slot.index, u32::MAX);
        let (Some((a, kind_a)), Some((b, kind_b))) = (member(joint.body_a), member(joint.body_b)) else {
            commands.entity(entity).despawn();
            continue;
        };
        packed_for.joints += 1;
        if is_quarantined {
            packed_for.quarantined += 1;
            continue;
        }
        if let Err(reason) = check_joint(&joint, [kind_a, kind_b]) {
            set_aside(entity, reason, &mut commands, &mut quarantine);
            packed_for.quarantined += 1;
            continue;
        }
        // A joint that stays goes on from what it carried.
        let known = joints.list.get(index_before as usize).filter(|known| known.entity == entity);
        let force = known.map_or_else(Vector3::zeros, |known| known.force);
        if known.is_some() && !joint.is_changed() {
            stays[index_before as usize] = true;
        } else {
            [a, b].into_iter().for_each(|body| sleep.disturb(body, &bodies));
        }
        let (anchor_a, anchor_b) = (joint.anchor_a.into(), joint.anchor_b.into());
        packed.push((
            slot.born,
            Joint { entity, a, b, anchor_a, anchor_b, softness: joint.softness, force },
            joint.collide,
        ));
    }
    for (joint, _) in joints.list.iter().zip(stays).filter(|(_, stays)| !stays) {
        let ends = [joint.a, joint.b].into_iter().filter(|&body| body != Joint::GONE);
        ends.for_each(|body| sleep.disturb(body, &bodies));
    }
    packed.sort_unstable_by_key(|&(born, ..)| born);
    joined.rebuild(packed.iter().filter(|(.., collide)| !collide).map(|(_, joint, _)| (joint.a, joint.b)));
    joints.version += 1;
    joints.list.clear();
    joints.list.extend(packed.into_iter().map(|(_, joint, _)| joint));
    let Joints { list, joined, .. } = &mut *joints;
    *joined = BitSet::default();
    list.iter().flat_map(|joint| [joint.a, joint.b]).for_each(|body| joined.set(body, true));
    for (index, joint) in (0..).zip(&joints.list) {
        if let Ok((.., mut slot, _)) = query.get_mut(joint.entity) {
            slot.index = index;
        }
    }
    stats.joints = joints.list.len() as u32;
}

fn any_changed(joints: &Query<Ref<BallJoint>>, ticks: &SystemChangeTick) -> bool {
    let (last_run, this_run) = (ticks.last_run(), ticks.this_run());
    joints.contiguous_iter().expect("joints are stored in tables").any(|column| {
        // Without a branch, for the vectorizer.
        let changed = column.changed_ticks_slice().iter();
        changed.fold(false, |any, tick| any | tick.is_newer_than(last_run, this_run))
    })
}

fn check_joint(joint: &BallJoint, kinds: [RigidBody; 2]) -> Result<(), QuarantineReason> {
    let soft_is_sane = joint.softness.is_none_or(|Softness { frequency, damping_ratio, max_force }| {
        frequency > 0.0
            && frequency.is_finite()
            && damping_ratio >= 0.0
            && damping_ratio.is_finite()
            && max_force >= 0.0
    });
    if !joint.anchor_a.is_finite() || !joint.anchor_b.is_finite() || !soft_is_sane {
        return Err(QuarantineReason::NotFinite);
    }
    if joint.body_a == joint.body_b || !kinds.contains(&RigidBody::Dynamic) {
        return Err(QuarantineReason::BadJoint);
    }
    Ok(())
}
