//! Joints: packed again only when one of them or the set of bodies changed.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::{SystemChangeTick, SystemParam};
use bevy::prelude::*;

use crate::physics::joint::{Attached, any_changed};
use crate::physics::{
    Bodies, BodyQuarantined, BodySlot, BrokenJoint, JoinedPairs, Joint, JointCoordinate, JointDefinition,
    JointFriction, JointLimits, JointMotor, JointSlot, Joints, QuarantineReason, Quarantined, Refill, RigidBody, Sleep,
    StepStats, bury, set_aside,
};

/// What the joints were packed for. Counts tell that one is gone or was let go; events would be lost
/// in an app that runs many frames without a step.
#[derive(Resource, Clone, Copy, Default, PartialEq)]
pub(super) struct PackedFor {
    bodies: u64,
    joints: usize,
    quarantined: usize,
    /// Those that broke, and of them those whose bodies have been apart since.
    broken: [usize; 2],
    attached: [usize; 3],
    /// Whether something beside a joint changed what it is packed as.
    is_stale: bool,
}

/// The components beside joints that stand for laws.
#[derive(SystemParam)]
pub(super) struct Attachments<'w, 's> {
    limits: Query<'w, 's, Ref<'static, JointLimits>, With<JointDefinition>>,
    motors: Query<'w, 's, Ref<'static, JointMotor>, With<JointDefinition>>,
    frictions: Query<'w, 's, Ref<'static, JointFriction>, With<JointDefinition>>,
}

impl Attachments<'_, '_> {
    /// How many there are of each kind.
    fn counts(&self) -> [usize; 3] {
        [self.limits.iter().len(), self.motors.iter().len(), self.frictions.iter().len()]
    }
}

/// A joint with all that it is packed from.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct JointQuery {
    entity: Entity,
    definition: Ref<'static, JointDefinition>,
    slot: &'static mut JointSlot,
    limits: Option<&'static JointLimits>,
    motor: Option<&'static JointMotor>,
    friction: Option<&'static JointFriction>,
    coordinate: Option<&'static JointCoordinate>,
    quarantined: Has<Quarantined>,
    broken: Option<&'static BrokenJoint>,
}

/// Whether something beside a joint changed.
pub(super) fn attachments_changed(attachments: Attachments, ticks: SystemChangeTick) -> bool {
    let Attachments { limits, motors, frictions } = &attachments;
    any_changed(limits, &ticks) || any_changed(motors, &ticks) || any_changed(frictions, &ticks)
}

/// Takes in new numbers of limits, motors and friction where the joints stay of the same laws.
pub(super) fn renew_laws(
    query: Query<JointQuery>,
    bodies: Res<Bodies>,
    mut joints: ResMut<Joints>,
    mut sleep: ResMut<Sleep>,
    mut packed_for: ResMut<PackedFor>,
) {
    for joint in &query {
        let known = joints.pieces_mut(joint.entity, joint.slot.index);
        let Some([a, b]) = known.first().map(|first| [first.a, first.b]) else { continue };
        if [a, b].contains(&Joint::GONE) || a.max(b) as usize >= bodies.list.len() {
            continue;
        }
        let attached = Attached { limits: joint.limits, motor: joint.motor, friction: joint.friction };
        let ends = [a, b].map(|body| &bodies.list[body as usize]);
        let Ok(whole) = attached.attach(&joint.definition, ends) else {
            packed_for.is_stale = true;
            continue;
        };
        let pieces: Vec<JointDefinition> = whole.pieces().collect();
        let is_alike = |(known, piece): (&Joint, &JointDefinition)| known.definition.is_alike(piece);
        if pieces.len() != known.len() || !known.iter().zip(&pieces).all(is_alike) {
            packed_for.is_stale = true;
            continue;
        }
        for (known, piece) in known.iter_mut().zip(pieces) {
            if known.definition.laws != piece.laws {
                known.definition.laws = piece.laws;
                [a, b].into_iter().for_each(|body| sleep.disturb(body, &bodies));
            }
        }
    }
}

/// Whether the joints must be packed anew. A condition of its own: it needs little of the world.
pub(super) fn joints_changed(
    joints: Query<Ref<JointDefinition>>,
    quarantined: Query<(), (With<JointDefinition>, With<Quarantined>)>,
    broken: Query<&BrokenJoint, With<JointDefinition>>,
    attachments: Attachments,
    bodies: Res<Bodies>,
    packed_for: Res<PackedFor>,
    ticks: SystemChangeTick,
) -> bool {
    let now = PackedFor {
        bodies: bodies.version,
        joints: joints.iter().len(),
        quarantined: quarantined.iter().len(),
        broken: [broken.iter().len(), broken.iter().filter(|broken| broken.apart).count()],
        attached: attachments.counts(),
        is_stale: false,
    };
    now != *packed_for || any_changed(&joints, &ticks)
}

/// Packs the joints.
pub(super) fn gather_joints(
    mut query: Query<JointQuery>,
    attachments: Attachments,
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
    *packed_for = PackedFor { bodies: bodies.version, attached: attachments.counts(), ..default() };
    let member = |entity| {
        members.get(entity).ok().filter(|(slot, _)| slot.index != u32::MAX).map(|(slot, &kind)| (slot.index, kind))
    };
    let mut stays = vec![false; joints.list.len()];
    let mut overlapping = Vec::new();
    let mut packed: Vec<(u64, Joint)> = Vec::with_capacity(query.iter().len());
    for mut joint in &mut query {
        let index_before = std::mem::replace(&mut joint.slot.index, u32::MAX);
        let [Some((a, kind_a)), Some((b, kind_b))] = joint.definition.bodies.map(member) else {
            let joint = joint.entity;
            commands.queue(move |world: &mut World| _ = bury(world, joint));
            continue;
        };
        packed_for.joints += 1;
        if let Some(broken) = joint.broken {
            packed_for.broken[0] += 1;
            packed_for.broken[1] += usize::from(broken.apart);
        }
        if joint.quarantined {
            packed_for.quarantined += 1;
            continue;
        }
        if let Some(broken) = joint.broken {
            if !broken.apart && !joint.definition.collide {
                overlapping.push((a, b));
            }
            continue;
        }
        let whole = check_joint(&joint.definition, [kind_a, kind_b]).and_then(|()| {
            let attached = Attached { limits: joint.limits, motor: joint.motor, friction: joint.friction };
            attached.attach(&joint.definition, [a, b].map(|body| &bodies.list[body as usize]))
        });
        let mut whole = match whole {
            Ok(whole) => whole,
            Err(reason) => {
                set_aside(joint.entity, reason, &mut commands, &mut quarantine);
                packed_for.quarantined += 1;
                continue;
            }
        };
        whole.turned = joint.coordinate.map_or(0.0, |coordinate| coordinate.value);
        let known = joints.pieces(joint.entity, index_before);
        let mut has_same = !joint.definition.is_changed();
        let count = packed.len();
        for (index, definition) in whole.pieces().enumerate() {
            // A joint that stays goes on from what it carried.
            let known = known.get(index);
            has_same &= known.is_some_and(|known| known.definition.laws == definition.laws);
            let mut piece = Joint::new(joint.entity, [a, b], definition);
            if let Some(known) = known.filter(|known| known.is_finite() && known.definition.is_alike(&piece.definition))
            {
                (piece.force, piece.torque, piece.multipliers) = (known.force, known.torque, known.multipliers);
                piece.is_doubtful = known.is_doubtful;
            }
            packed.push((joint.slot.born, piece));
        }
        if has_same && packed.len() - count == known.len() {
            stays[index_before as usize..][..known.len()].fill(true);
        } else {
            [a, b].into_iter().for_each(|body| sleep.disturb(body, &bodies));
        }
    }
    for (joint, _) in joints.list.iter().zip(stays).filter(|(_, stays)| !stays) {
        let ends = [joint.a, joint.b].into_iter().filter(|&body| body != Joint::GONE);
        ends.for_each(|body| sleep.disturb(body, &bodies));
    }
    // The pieces of a joint stay in their order.
    packed.sort_by_key(|&(born, _)| born);
    joints.version += 1;
    joints.list.refill(packed.into_iter().map(|(_, joint)| joint));
    let apart = joints.list.iter().filter(|joint| !joint.definition.collide);
    joined.rebuild(apart.map(|joint| (joint.a, joint.b)).chain(overlapping));
    joints.take_stock();
    for (index, joint) in (0..).zip(&joints.list) {
        if let Ok(mut known) = query.get_mut(joint.entity)
            && known.slot.index == u32::MAX
        {
            known.slot.index = index;
        }
    }
    stats.joints = joints.entities;
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
