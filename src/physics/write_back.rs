//! `WriteBack`: from packed arrays to the ECS, as changes.
//!
//! A body whose state is no longer finite goes back to the state it had before the step, frozen
//! and reported.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemChangeTick;
use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::joint::{LawAxis, LawPart, nearest_turn};
use super::{
    Bodies, Body, BodyQuarantined, BodySlot, BodyState, GatheredWith, JointAxis, JointCoordinate, JointDefinition,
    JointLoad, JointSlot, Joints, PhysicsSchedule, PhysicsSystems, PoseHistory, Position, QuarantineReason, RigidBody,
    Rotation, Sleep, Sleeping, SolverSettings, StepStats, Velocity, set_aside,
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

/// Rows of tables that are walked in the time that it takes to find one body by its entity. Noticed by the clock alone
/// (`large_world`).
const ROWS_OF_FINDING: usize = 16;

/// What a step writes of each body.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct StateQuery {
    entity: Entity,
    slot: &'static BodySlot,
    gathered_with: &'static mut GatheredWith,
    position: &'static mut Position,
    rotation: &'static mut Rotation,
    velocity: &'static mut Velocity,
    history: &'static mut PoseHistory,
    sleeping: Has<Sleeping>,
}

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
    let mut write = |mut item: StateQueryItem, body: &mut Body| {
        if is_finite(body) {
            write_state(&mut item, body);
            return;
        }
        restore_state(&mut item, body);
        stats.quarantined += 1;
        set_aside(item.entity, QuarantineReason::NotFinite, &mut commands, &mut quarantine);
    };
    // Among many that do not move, the few that do are looked for; where some just fell asleep, these still change.
    if !sleep.has_changed && bodies.awake().count() * ROWS_OF_FINDING < bodies.list.len() {
        let Bodies { list, fixed, asleep, .. } = &mut *bodies;
        for index in asleep.in_neither(fixed, 0..list.len() as u32) {
            let body = &mut list[index as usize];
            if let Some(item) = query.get_mut(body.entity).ok().filter(|item| item.slot.index == index) {
                write(item, body);
            }
        }
        return;
    }
    let Bodies { list, fixed, .. } = &mut *bodies;
    for item in &mut query {
        let index = item.slot.index;
        // Who woke in this step is still among those that sleep.
        if fixed.contains(index) || item.sleeping && !sleep.has_changed {
            continue;
        }
        // Whoever became a body since the step began waits for the next.
        if let Some(body) = list.get_mut(index as usize).filter(|body| body.entity == item.entity) {
            write(item, body);
        }
    }
}

/// What did not change in any bit is not marked as changed.
fn write_state(item: &mut StateQueryItem, body: &Body) {
    item.history.bypass_change_detection().previous = Some((item.position.0, item.rotation.0));
    set_if_other(&mut item.position, Position(body.position.into()), |position| position.0.to_array());
    set_if_other(&mut item.rotation, Rotation(body.rotation.into()), |rotation| rotation.0.to_array());
    let velocity = Velocity { linear: body.linear.into(), angular: body.angular.into() };
    set_if_other(&mut item.velocity, velocity, |Velocity { linear: v, angular: w }| [v.x, v.y, v.z, w.x, w.y, w.z]);
}

/// Writes what is made of those numbers, if that changes any bit of it.
fn set_if_other<T, const N: usize>(component: &mut Mut<T>, value: T, numbers: impl Fn(&T) -> [f64; N]) {
    let bits = |value: &T| numbers(value).map(f64::to_bits);
    if bits(component) != bits(&value) {
        **component = value;
    }
}

/// Back to the pose before the step, at rest; to be gathered again whatever becomes of it.
fn restore_state(item: &mut StateQueryItem, body: &mut Body) {
    let (position, rotation) = (item.position.0, item.rotation.0);
    item.history.bypass_change_detection().previous = Some((position, rotation));
    *item.gathered_with.bypass_change_detection() = GatheredWith::NOTHING;
    body.position = position.into();
    body.rotation = UnitQuaternion::new_normalize(rotation.into());
    (body.linear, body.angular) = (Vector3::zeros(), Vector3::zeros());
    *item.velocity = Velocity::default();
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
