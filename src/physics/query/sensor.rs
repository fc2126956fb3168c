//! Colliders that only report: after each step, which bodies are in them.

use bevy::prelude::*;

use super::filter::QueryFilter;
use super::physics_query::PhysicsQuery;
use crate::physics::{Keep, PhysicsSchedule, PhysicsSystems, RigidBody, Sensor, SensorEnded, SensorStarted, ToldPairs};

/// The sensors and what was in each after the last step.
#[derive(Resource, Default, Clone)]
struct Sensed(ToldPairs);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Sensed>()
        .keep_resource::<Sensed>()
        .keep_component::<Sensor>()
        .add_message::<SensorStarted>()
        .add_message::<SensorEnded>()
        .add_systems(PhysicsSchedule, sense.in_set(PhysicsSystems::Events).run_if(there_may_be_news));
}

fn there_may_be_news(sensors: Query<(), With<Sensor>>, sensed: Res<Sensed>) -> bool {
    !sensors.is_empty() || !sensed.0.is_empty()
}

fn sense(
    query: PhysicsQuery,
    mut sensed: ResMut<Sensed>,
    mut started: MessageWriter<SensorStarted>,
    mut ended: MessageWriter<SensorEnded>,
    mut commands: Commands,
) {
    let sensors = query.bodies().iter().filter(|body| body.is_sensor);
    let present = sensors.flat_map(|sensor| {
        let filter = QueryFilter { layers: Some(sensor.layers), ..default() };
        let may_meet = |kind: RigidBody| kind != RigidBody::Static || sensor.kind != RigidBody::Static;
        let found = query.touched_by(sensor, &filter).into_iter();
        found.filter(move |body| may_meet(body.kind)).map(|body| (sensor.entity, body.entity))
    });
    sensed.0.update(present, |came, (sensor, body)| {
        if came {
            started.write(SensorStarted { sensor, body });
            commands.trigger(SensorStarted { sensor, body });
            return;
        }
        ended.write(SensorEnded { sensor, body });
        if commands.get_entity(sensor).is_ok() {
            commands.trigger(SensorEnded { sensor, body });
        }
    });
}
