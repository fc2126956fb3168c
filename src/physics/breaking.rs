//! Joints that break, and joints that reach their limits: after each step, from what they carried.
//!
//! A joint breaks where the norm of the mean of its force, or of its torque about the anchor, over a window of time is
//! over what it bears ([`Breakable`]). All that are over in a step break together at its end; their loads go elsewhere
//! from the next step on. What broke keeps its entity, marked [`BrokenJoint`], and is packed no more; while its bodies
//! overlap they do not collide.

use std::collections::VecDeque;

use bevy::prelude::*;
use nalgebra::Vector3;

use super::joint::LawPart;
use super::{
    Bodies, BodyQuarantined, BodyState, Breakable, BrokenJoint, Collider, Joint, JointBroke, JointDefinition,
    JointLimits, JointSlot, Joints, Keep, LimitReached, PhysicsSchedule, PhysicsSystems, PlacedCollider, Position,
    QuarantineReason, Quarantined, Rotation, SolverSettings, StepStats, set_aside,
};

pub(super) fn plugin(app: &mut App) {
    app.keep_component::<Breakable>()
        .keep_component::<BrokenJoint>()
        .keep_result::<LoadHistory>()
        .keep_result::<LimitWatch>();
    app.register_required_components::<Breakable, LoadHistory>();
    app.register_required_components::<JointLimits, LimitWatch>();
    let part = part_broken.run_if(any_with_component::<BrokenJoint>);
    let watch = tell_limits.run_if(any_with_component::<JointLimits>);
    let break_joints = break_joints.run_if(any_with_component::<Breakable>);
    app.add_systems(PhysicsSchedule, (part, watch, break_joints).chain().in_set(PhysicsSystems::Events));
}

/// Rate, rad/s or m/s, above which a joint that turns round at its limit has come to it and gone: less is rounding.
const LEAST_RETURN: f64 = 1e-3;

/// Gap, rad or m, from which on a joint has left its limit.
const LEFT: f64 = 1e-4;

/// What a joint carried in the last steps, as far back as its window goes: force, torque about B's anchor and length of
/// each step.
#[derive(Component, Clone, Debug, Default)]
pub(super) struct LoadHistory(VecDeque<(Vector3<f64>, Vector3<f64>, f64)>);

impl LoadHistory {
    /// Takes in a step and forgets what is out of the window, s.
    fn note(&mut self, force: Vector3<f64>, torque: Vector3<f64>, h: f64, window: f64) {
        self.0.push_back((force, torque, h));
        let mut length: f64 = self.0.iter().map(|step| step.2).sum();
        // A step that is within the window for the most part is in it.
        while self.0.len() > 1 && length - 0.5 * self.0[0].2 > window {
            length -= self.0.pop_front().map_or(0.0, |step| step.2);
        }
    }

    /// Norms of the mean force and of the mean torque.
    fn means(&self) -> [f64; 2] {
        let (mut force, mut torque, mut length) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (step_force, step_torque, h) in &self.0 {
            force += step_force * *h;
            torque += step_torque * *h;
            length += h;
        }
        [force, torque].map(|sum| sum.norm() / length)
    }
}

fn break_joints(
    mut loaded: Query<(Entity, &JointSlot, &Breakable, &mut LoadHistory), (Without<BrokenJoint>, Without<Quarantined>)>,
    joints: Res<Joints>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
    mut broke: MessageWriter<JointBroke>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
) {
    for (entity, slot, breakable, mut history) in &mut loaded {
        if !breakable.is_valid() {
            set_aside(entity, QuarantineReason::BadJointLaw, &mut commands, &mut quarantine);
            continue;
        }
        let pieces = joints.pieces(entity, slot.index);
        if pieces.is_empty() {
            continue;
        }
        let sum = |of: fn(&Joint) -> Vector3<f64>| pieces.iter().map(of).sum();
        history.note(
            sum(|piece| piece.load().linear),
            sum(|piece| piece.load().angular),
            settings.step(),
            breakable.window,
        );
        let [force, torque] = history.means();
        // A rounding of the time is no step too early.
        let counts = stats.time >= breakable.from - 0.5 * settings.step();
        if counts && (force > breakable.force || torque > breakable.torque) {
            history.0.clear();
            commands.entity(entity).insert(BrokenJoint::default());
            commands.trigger(JointBroke { joint: entity, force, torque });
            broke.write(JointBroke { joint: entity, force, torque });
        }
    }
}

/// Has the bodies of broken joints collide again once they are apart.
fn part_broken(
    mut broken: Query<(&JointDefinition, &mut BrokenJoint)>,
    bodies: Query<(Option<&Collider>, &Position, &Rotation)>,
) {
    for (joint, mut broken) in broken.iter_mut().filter(|(_, broken)| !broken.apart) {
        let [Ok(a), Ok(b)] = joint.bodies.map(|body| bodies.get(body)) else { continue };
        let placed = [a, b].map(|(collider, &position, &rotation)| {
            collider.map(|collider| PlacedCollider { collider, position, rotation })
        });
        let overlaps = match placed {
            [Some(a), Some(b)] => a.overlap(&b).is_some(),
            _ => false,
        };
        broken.apart = !overlaps;
    }
}

/// Which limits of a joint carried something in the last step, a bit each, and how fast their coordinates changed.
#[derive(Component, Clone, Debug, Default)]
pub(super) struct LimitWatch {
    pressed: u32,
    rates: [f64; 4],
}

fn tell_limits(
    mut limited: Query<(Entity, &JointSlot, &mut LimitWatch)>,
    joints: Res<Joints>,
    bodies: Res<Bodies>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    mut reached: MessageWriter<LimitReached>,
    mut commands: Commands,
) {
    for (joint, slot, mut watch) in &mut limited {
        let mut limit = 0;
        for piece in joints.pieces(joint, slot.index) {
            let states = [piece.a, piece.b].map(|body| BodyState::of(&bodies.list[body as usize]));
            let laws = piece.definition.laws.iter().flat_map(|laws| laws.iter());
            for (law, multiplier) in laws.zip(&piece.multipliers) {
                let (LawPart::Limit { bound, is_upper, .. }, Some(axis)) = (law.part, law.coordinate()) else {
                    continue;
                };
                let [value, rate] = piece.definition.coordinate(axis, &states);
                let before = watch.rates[limit];
                let (outwards, past) = if is_upper { (before, value - bound) } else { (-before, bound - value) };
                // One that went back within the step carries nothing at its end.
                let went_back =
                    before * rate < 0.0 && outwards > LEAST_RETURN && -past < 2.0 * outwards * settings.step();
                let presses = *multiplier != 0.0 || past > 0.0 || went_back;
                let bit = 1 << limit;
                if presses && watch.pressed & bit == 0 {
                    let message = LimitReached { joint, time: stats.time, speed: before.abs().max(rate.abs()) };
                    reached.write(message);
                    commands.trigger(message);
                }
                // Until it has left the limit it is not reached again.
                let stays = presses || watch.pressed & bit != 0 && past > -LEFT;
                watch.pressed = if stays && !went_back { watch.pressed | bit } else { watch.pressed & !bit };
                watch.rates[limit] = rate;
                limit += 1;
            }
        }
    }
}
