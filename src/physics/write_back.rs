//! `WriteBack`: from packed arrays to the ECS, as changes.
//!
//! A body whose state is no longer finite goes back to the state it had before the step, frozen
//! and reported.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemChangeTick;
use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::columns::{self, set_if_other};
use super::joint::{LawAxis, LawPart, nearest_turn};
use super::{
    Bodies, Body, BodyQuarantined, BodySlot, BodyState, JointAxis, JointCoordinate, JointDefinition, JointLoad,
    JointSlot, Joints, PhysicsSchedule, PhysicsSystems, PoseHistory, Position, QuarantineReason, RigidBody, Rotation,
    Sleep, Sleeping, SolverSettings, StepStats, Velocity, set_aside,
};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        PhysicsSchedule,
        // In this order: a system may share its tick with commands applied right before it, and the
        // tick of `write_bodies` must be its own. See `Bodies::written_back`.
        (write_joint_loads, write_joint_coordinates.run_if(any_with_component::<JointCoordinate>), write_bodies)
            .chain()
            .in_set(PhysicsSystems::WriteBack),
    );
}

/// What a step writes of each body.
#[derive(QueryData)]
#[query_data(mutable, contiguous(mutable))]
pub(super) struct StateQuery {
    entity: Entity,
    slot: &'static mut BodySlot,
    position: &'static mut Position,
    rotation: &'static mut Rotation,
    velocity: &'static mut Velocity,
    history: &'static mut PoseHistory,
    sleeping: Has<Sleeping>,
}

type StateTable<'w, 's> = StateQueryContiguousItem<'w, 's>;

fn is_finite(body: &Body) -> bool {
    // Without a branch for each number.
    let finite = |numbers: &[f64]| numbers.iter().fold(true, |all, number| all & number.is_finite());
    finite(body.position.as_slice())
        & finite(body.rotation.coords.as_slice())
        & finite(body.linear.as_slice())
        & finite(body.angular.as_slice())
}

pub(super) fn write_bodies(
    mut query: Query<StateQuery, With<RigidBody>>,
    mut bodies: ResMut<Bodies>,
    sleep: Res<Sleep>,
    settings: Res<SolverSettings>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
    ticks: SystemChangeTick,
) {
    stats.count_step(&settings);
    bodies.written_back = Some(ticks.this_run());
    let Bodies { list, fixed, .. } = &mut *bodies;
    for mut table in query.contiguous_iter_mut().expect("gathered from tables") {
        // Who woke in this step is still among those that sleep.
        if table.sleeping && !sleep.has_woken {
            continue;
        }
        for row in 0..table.entity.len() {
            let entity = table.entity[row];
            let slot = table.slot.as_ref()[row];
            if fixed.contains(slot.index) {
                continue;
            }
            // Whoever became a body since the step began waits for the next.
            let Some(body) = list.get_mut(slot.index as usize).filter(|body| body.entity == entity) else { continue };
            if is_finite(body) {
                write_state(&mut table, row, body);
                continue;
            }
            restore_state(&mut table, row, body);
            stats.quarantined += 1;
            set_aside(entity, QuarantineReason::NotFinite, &mut commands, &mut quarantine);
        }
    }
}

/// What did not change in any bit is not marked as changed.
fn write_state(table: &mut StateTable, row: usize, body: &Body) {
    let previous = (table.position.as_ref()[row].0, table.rotation.as_ref()[row].0);
    table.history.bypass_change_detection()[row].previous = Some(previous);
    set_if_other(&mut table.position, row, Position(body.position.into()), |position| position.0.to_array());
    set_if_other(&mut table.rotation, row, Rotation(body.rotation.into()), |rotation| rotation.0.to_array());
    let velocity = Velocity { linear: body.linear.into(), angular: body.angular.into() };
    set_if_other(&mut table.velocity, row, velocity, |Velocity { linear: v, angular: w }| {
        [v.x, v.y, v.z, w.x, w.y, w.z]
    });
}

/// Back to the pose before the step, at rest; to be gathered again whatever becomes of it.
fn restore_state(table: &mut StateTable, row: usize, body: &mut Body) {
    let (position, rotation) = (table.position.as_ref()[row].0, table.rotation.as_ref()[row].0);
    table.history.bypass_change_detection()[row].previous = Some((position, rotation));
    table.slot.bypass_change_detection()[row].gathered_with = BodySlot::TO_GATHER;
    body.position = position.into();
    body.rotation = UnitQuaternion::new_normalize(rotation.into());
    (body.linear, body.angular) = (Vector3::zeros(), Vector3::zeros());
    columns::set(&mut table.velocity, row, Velocity::default());
}

pub(super) fn write_joint_loads(joints: Res<Joints>, mut loads: Query<(Entity, &JointSlot, &mut JointLoad)>) {
    for (entity, slot, mut load) in &mut loads {
        // One that was taken off its entity leaves its slot.
        let pieces = joints.pieces(entity, slot.index);
        if pieces.is_empty() {
            continue;
        }
        let force = DVec3::from(pieces.iter().map(|piece| piece.load().linear).sum::<Vector3<f64>>());
        let torque = DVec3::from(pieces.iter().map(|piece| piece.load().angular).sum::<Vector3<f64>>());
        let lambda = (force.length_squared() + torque.length_squared()).sqrt();
        load.set_if_neq(JointLoad { force, torque, lambda });
    }
}

/// Tells coordinates, and has the twist of the next step's rows be the value nearest to this one.
pub(super) fn write_joint_coordinates(
    mut joints: ResMut<Joints>,
    bodies: Res<Bodies>,
    settings: Res<SolverSettings>,
    mut coordinates: Query<(Entity, &JointSlot, &JointDefinition, &mut JointCoordinate)>,
) {
    for (entity, slot, definition, mut coordinate) in &mut coordinates {
        let pieces = joints.bypass_change_detection().pieces_mut(entity, slot.index);
        let (Some(axis), Some(first)) = (definition.axis, pieces.first()) else { continue };
        let states = [first.a, first.b].map(|body| BodyState::of(&bodies.list[body as usize]));
        if !states.iter().all(BodyState::is_finite) {
            continue;
        }
        // However fast it came, it did not go on beyond its limits.
        let [bare, now] = first.definition.coordinate(axis, &states);
        let rate = if coordinate.is_added() { now } else { coordinate.rate };
        let ahead = coordinate.value + rate * settings.step();
        let laws = pieces.iter().flat_map(|piece| piece.definition.laws.iter().flat_map(|laws| laws.iter()));
        let turned =
            laws.filter(|law| law.axis == LawAxis::Coordinate(axis)).fold(ahead, |ahead, law| match law.part {
                LawPart::Limit { bound, is_upper: true, .. } => ahead.min(bound),
                LawPart::Limit { bound, is_upper: false, .. } => ahead.max(bound),
                _ => ahead,
            });
        let value = if axis == JointAxis::Twist { nearest_turn(bare, turned) } else { bare };
        coordinate.set_if_neq(JointCoordinate { value, rate: now });
        pieces.iter_mut().for_each(|piece| piece.definition.turned = value);
    }
}
