//! Colliders that only report: after each step, which bodies are in them.

use bevy::prelude::*;

use super::filter::QueryFilter;
use super::physics_query::PhysicsQuery;
use crate::physics::{Keep, PhysicsSchedule, PhysicsSystems, RigidBody, Sensor, SensorEnded, SensorStarted};

/// The sensors and what was in each after the last step, sorted.
#[derive(Resource, Default, Clone)]
struct Sensed {
    pairs: Vec<(Entity, Entity)>,
    present: Vec<(Entity, Entity)>,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Sensed>()
        .keep_resource::<Sensed>()
        .keep_component::<Sensor>()
        .add_message::<SensorStarted>()
        .add_message::<SensorEnded>()
        .add_systems(PhysicsSchedule, sense.in_set(PhysicsSystems::Events).run_if(there_may_be_news));
}

fn there_may_be_news(sensors: Query<(), With<Sensor>>, sensed: Res<Sensed>) -> bool {
    !sensors.is_empty() || !sensed.pairs.is_empty()
}

fn sense(
    query: PhysicsQuery,
    mut sensed: ResMut<Sensed>,
    mut started: MessageWriter<SensorStarted>,
    mut ended: MessageWriter<SensorEnded>,
    mut commands: Commands,
) {
    let Sensed { pairs, present } = &mut *sensed;
    present.clear();
    for sensor in query.bodies().iter().filter(|body| body.is_sensor) {
        let filter = QueryFilter { layers: Some(sensor.layers), ..default() };
        let may_meet = |kind: RigidBody| kind != RigidBody::Static || sensor.kind != RigidBody::Static;
        let found = query.touched_by(sensor, &filter).filter(|body| may_meet(body.kind));
        present.extend(found.map(|body| (sensor.entity, body.entity)));
    }
    present.sort_unstable();
    for &(sensor, body) in present.iter().filter(|pair| pairs.binary_search(pair).is_err()) {
        started.write(SensorStarted { sensor, body });
        commands.trigger(SensorStarted { sensor, body });
    }
    for &(sensor, body) in pairs.iter().filter(|pair| present.binary_search(pair).is_err()) {
        ended.write(SensorEnded { sensor, body });
        if commands.get_entity(sensor).is_ok() {
            commands.trigger(SensorEnded { sensor, body });
        }
    }
    std::mem::swap(pairs, present);
}
