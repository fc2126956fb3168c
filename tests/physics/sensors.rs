//! Colliders that only report.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

/// What sensors told in the last step: whether it came, the sensor, the body.
fn told(world: &mut World) -> Vec<(bool, Entity, Entity)> {
    let started = world.resource_mut::<Messages<SensorStarted>>().drain().collect::<Vec<_>>();
    let ended = world.resource_mut::<Messages<SensorEnded>>().drain().collect::<Vec<_>>();
    let started = started.into_iter().map(|SensorStarted { sensor, body }| (true, sensor, body));
    started.chain(ended.into_iter().map(|SensorEnded { sensor, body }| (false, sensor, body))).collect()
}

#[test]
fn what_falls_through_a_sensor_is_told_of_once_and_falls_on() {
    for (name, settings) in presets() {
        let fallen = |with_sensor: bool| {
            let mut world = world_with(settings);
            let slab = (RigidBody::Static, Collider::cuboid(4.0, 0.5, 4.0), Position(DVec3::Y * 8.0));
            let sensor = with_sensor.then(|| world.spawn((slab, Sensor)).id());
            let ball = body(&mut world, Collider::sphere(0.25), DVec3::Y * 10.0);
            let mut all = Vec::new();
            for index in 0..75 {
                step(&mut world);
                let y = position(&world, ball).y;
                for (came, reporter, about) in told(&mut world) {
                    assert_eq!((Some(reporter), about), (sensor, ball), "{name}");
                    let is_in = (y - 8.0).abs() <= 0.5;
                    assert_eq!(came, is_in, "{name}: step {index}, y {y}");
                    all.push(came);
                }
            }
            (all, position(&world, ball), velocity(&world, ball))
        };
        let (with, without) = (fallen(true), fallen(false));
        assert_eq!(with.0, [true, false], "{name}");
        assert!(without.0.is_empty());
        assert_eq!((with.1, with.2), (without.1, without.2), "{name}: the sensor was felt");
    }
}

#[test]
fn sensors_tell_of_what_their_layers_and_kinds_go_with() {
    let mut world = weightless(SolverSettings::game());
    let near = |x: f64| (Collider::sphere(1.0), Position(DVec3::X * x));
    let own = CollisionLayers { memberships: 0b10, filters: 0b10 };
    let sensor = world.spawn((RigidBody::Static, near(0.0), Sensor, own)).id();
    let moving = world.spawn((RigidBody::Kinematic, near(0.5), Sensor)).id();
    let ground = world.spawn((RigidBody::Static, near(-0.5), own)).id();
    let guest = world.spawn((RigidBody::Kinematic, near(1.0), own)).id();
    let other = world.spawn((RigidBody::Kinematic, near(1.2), CollisionLayers { memberships: 1, filters: 1 })).id();
    step(&mut world);
    let mut expected =
        vec![(true, sensor, guest), (true, moving, ground), (true, moving, guest), (true, moving, other)];
    expected.sort_unstable();
    let mut found = told(&mut world);
    found.sort_unstable();
    assert_eq!(found, expected);
    step(&mut world);
    assert_eq!(told(&mut world), []);
}

#[test]
fn what_goes_has_left() {
    let mut world = weightless(SolverSettings::game());
    let at = |x: f64| (Collider::sphere(1.0), Position(DVec3::X * x));
    let sensor = world.spawn((RigidBody::Static, at(0.0), Sensor)).id();
    let [one, two] = [0.5, -0.5].map(|x| world.spawn((RigidBody::Kinematic, at(x))).id());
    let heard = world.spawn_empty().id();
    world.add_observer(move |event: On<SensorEnded>, mut commands: Commands| {
        commands.entity(heard).insert(Name::new(event.body.to_string()));
    });
    step(&mut world);
    assert_eq!(told(&mut world).len(), 2);
    world.despawn(one);
    step(&mut world);
    assert_eq!(told(&mut world), [(false, sensor, one)]);
    assert_eq!(world.get::<Name>(heard), Some(&Name::new(one.to_string())));
    // One that is a sensor no more pushes again.
    world.entity_mut(sensor).remove::<Sensor>();
    step(&mut world);
    assert_eq!(told(&mut world), [(false, sensor, two)]);
    world.entity_mut(sensor).insert(Sensor);
    step(&mut world);
    assert_eq!(told(&mut world), [(true, sensor, two)]);
    world.despawn(sensor);
    step(&mut world);
    assert_eq!(told(&mut world), [(false, sensor, two)]);
}

#[test]
fn one_that_is_a_sensor_no_more_holds_what_falls() {
    for (name, settings) in presets() {
        let mut world = world_with(settings);
        let slab = (RigidBody::Static, Collider::cuboid(4.0, 0.5, 4.0), Position(DVec3::Y * 0.75));
        let sensor = world.spawn((slab, Sensor)).id();
        let ball = body(&mut world, Collider::sphere(0.25), DVec3::Y * 2.0);
        step(&mut world);
        world.entity_mut(sensor).remove::<Sensor>();
        (0..90).for_each(|_| step(&mut world));
        let y = position(&world, ball).y;
        assert!((y - 1.25).abs() < 0.02, "{name}: {y}");
    }
}
