use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::Vector3;

use super::gather_bodies::gather_bodies;
use super::gather_joints::{gather_joints, joints_changed};
use crate::physics::body::{Bodies, Body};
use crate::physics::body::{
    CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass, Position, Quarantined,
    ReportCollisions, RigidBody, Rotation, SurfaceMaterial, Velocity,
};
use crate::physics::joint::{BallJoint, JointLoad, Joints};
use crate::physics::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::physics::settings::{Gravity, SolverSettings};
use crate::physics::shape::Collider;
use crate::physics::stats::StepStats;
use crate::physics::write_back::{write_bodies, write_joint_loads};
use crate::physics::{RenderOrigin, headless_app, step};

fn world() -> World {
    let mut world = std::mem::take(headless_app().world_mut());
    world.insert_resource(SolverSettings::steady());
    world.insert_resource(Gravity(DVec3::ZERO));
    world
}

fn ball(world: &mut World, x: f64) -> Entity {
    world.spawn((RigidBody::Dynamic, Collider::sphere(0.5), Position(DVec3::X * x))).id()
}

fn packed(world: &World, entity: Entity) -> &Body {
    world.resource::<Bodies>().list.iter().find(|body| body.entity == entity).expect("a packed body")
}

/// Spoils what only gathering mends.
fn spoil(world: &mut World, entity: Entity) {
    let mut bodies = world.resource_mut::<Bodies>();
    bodies.list.iter_mut().find(|body| body.entity == entity).unwrap().torque = Vector3::x();
}

fn is_spoilt(world: &World, entity: Entity) -> bool {
    packed(world, entity).torque == Vector3::x()
}

/// A world with two moving balls that has settled into gathering nothing.
fn steady() -> (World, [Entity; 2]) {
    let mut world = world();
    let balls = [0.0, 5.0].map(|x| ball(&mut world, x));
    for ball in balls {
        world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::Y;
    }
    (0..4).for_each(|_| step(&mut world));
    (world, balls)
}

#[test]
fn what_nobody_writes_to_is_not_gathered_again() {
    let (mut world, [moving, _]) = steady();
    spoil(&mut world, moving);
    step(&mut world);
    assert!(is_spoilt(&world, moving), "its own write-back made it gathered again");
}

#[test]
fn whatever_is_written_is_gathered_with_the_next_step() {
    let writes: [fn(EntityWorldMut); 15] = [
        |mut body| body.get_mut::<Position>().unwrap().0.z = 3.0,
        |mut body| body.get_mut::<Rotation>().unwrap().0 = DQuat::from_rotation_x(1.0),
        |mut body| body.get_mut::<Velocity>().unwrap().angular.z = 3.0,
        |mut body| body.get_mut::<RigidBody>().unwrap().set_changed(),
        |mut body| body.get_mut::<Collider>().unwrap().set_changed(),
        |mut body| body.get_mut::<Transform>().unwrap().translation.z = 3.0,
        |mut body| _ = body.insert(Density(7.0)),
        |mut body| _ = body.insert(Mass(7.0)),
        |mut body| _ = body.insert(Inertia(DVec3::ONE)),
        |mut body| _ = body.insert(ExternalForce::default()),
        |mut body| _ = body.insert(SurfaceMaterial::default()),
        |mut body| _ = body.insert(CollisionLayers::NONE),
        |mut body| _ = body.insert(LockedAxes::default()),
        |mut body| _ = body.insert((GravityScale(2.0), Damping::default())),
        |mut body| _ = body.insert(ReportCollisions),
    ];
    for (index, write) in writes.into_iter().enumerate() {
        let (mut world, [written, other]) = steady();
        // Once by inserting or writing, once again where the component is there already.
        for round in 0..2 {
            for ball in [written, other] {
                spoil(&mut world, ball);
            }
            if round == 0 || index != 14 {
                write(world.entity_mut(written));
            }
            step(&mut world);
            let expected = round == 1 && (index == 14 || index == 5);
            assert_eq!(is_spoilt(&world, written), expected, "write {index}, round {round}");
            assert!(is_spoilt(&world, other), "write {index} to another body");
            step(&mut world);
            step(&mut world);
        }
    }
}

#[test]
fn a_scale_of_the_users_is_no_teleport() {
    let (mut world, [scaled, _]) = steady();
    spoil(&mut world, scaled);
    world.get_mut::<Transform>(scaled).unwrap().scale = Vec3::splat(2.0);
    step(&mut world);
    assert!(is_spoilt(&world, scaled));
}

#[test]
fn a_removed_force_stops_pushing_at_the_next_step() {
    let (mut world, [pushed, _]) = steady();
    world.entity_mut(pushed).insert(ExternalForce { force: DVec3::X * 1e3, ..default() });
    step(&mut world);
    let speed = world.get::<Velocity>(pushed).unwrap().linear.x;
    assert!(speed > 0.0);
    step(&mut world);
    assert!(world.get::<Velocity>(pushed).unwrap().linear.x > speed, "a force lasts");
    let speed = world.get::<Velocity>(pushed).unwrap().linear.x;
    world.entity_mut(pushed).remove::<ExternalForce>();
    step(&mut world);
    assert_eq!(world.get::<Velocity>(pushed).unwrap().linear.x, speed);
}

#[test]
fn each_component_that_goes_leaves_its_default() {
    let mut world = world();
    world.insert_resource(Gravity(DVec3::NEG_Y));
    let body = ball(&mut world, 0.0);
    step(&mut world);
    let plain = packed(&world, body).clone();
    let full = (
        (Density(500.0), SurfaceMaterial { friction: 0.1, restitution: 0.2 }, CollisionLayers::NONE),
        (LockedAxes { translation: [true; 3], rotation: [true; 3] }, GravityScale(3.0)),
        (Damping { linear: 1.0, angular: 2.0 }, ReportCollisions),
    );
    world.entity_mut(body).insert(full);
    // Mass and inertia that follow from a density are known to be Plumb's own a step later.
    (0..3).for_each(|_| step(&mut world));
    let full = packed(&world, body).clone();
    assert!(full.mass < plain.mass && full.material != plain.material && full.layers != plain.layers);
    assert!(full.inverse_mass != plain.inverse_mass && full.rotation_freedom != plain.rotation_freedom);
    assert!(full.force != plain.force && full.drag != plain.drag && full.reports);
    let removals: [fn(&mut EntityWorldMut); 7] = [
        |body| _ = body.remove::<Density>(),
        |body| _ = body.remove::<SurfaceMaterial>(),
        |body| _ = body.remove::<CollisionLayers>(),
        |body| _ = body.remove::<LockedAxes>(),
        |body| _ = body.remove::<GravityScale>(),
        |body| _ = body.remove::<Damping>(),
        |body| _ = body.remove::<ReportCollisions>(),
    ];
    let mut kept = full;
    for (index, remove) in removals.into_iter().enumerate() {
        remove(&mut world.entity_mut(body));
        // As an app that draws many frames between two steps.
        (0..3).for_each(|_| world.clear_trackers());
        step(&mut world);
        match index {
            0 => (kept.mass, kept.force) = (plain.mass, plain.force * 3.0),
            1 => kept.material = plain.material,
            2 => kept.layers = plain.layers,
            3 => (kept.inverse_mass, kept.rotation_freedom) = (plain.inverse_mass, plain.rotation_freedom),
            4 => kept.force = plain.force,
            5 => kept.drag = plain.drag,
            _ => kept.reports = plain.reports,
        }
        let now = packed(&world, body);
        assert_eq!((now.mass, now.material, now.layers), (kept.mass, kept.material, kept.layers), "removal {index}");
        assert_eq!((now.rotation_freedom, now.force), (kept.rotation_freedom, kept.force), "removal {index}");
        assert_eq!((now.drag, now.reports), (kept.drag, kept.reports), "removal {index}");
    }
    assert_eq!(packed(&world, body).inverse_mass, plain.inverse_mass);
    world.entity_mut(body).remove::<Collider>();
    (0..3).for_each(|_| world.clear_trackers());
    step(&mut world);
    assert!(packed(&world, body).geometry.is_none() && packed(&world, body).radius == 0.0);
}

#[test]
fn gravity_and_drag_reach_every_body() {
    let (mut world, balls) = steady();
    world.insert_resource(Gravity(DVec3::X));
    world.resource_mut::<SolverSettings>().drag = 0.25;
    step(&mut world);
    for ball in balls {
        let body = packed(&world, ball);
        assert_eq!(body.force, Vector3::x() * body.mass);
        assert_eq!(body.drag, (0.25, 0.25));
    }
}

#[test]
fn a_write_in_the_step_that_wrote_back_is_seen() {
    let (mut world, [moving, resting]) = steady();
    *world.get_mut::<RigidBody>(resting).unwrap() = RigidBody::Static;
    step(&mut world);
    // Right after the write-back, and by commands applied right before it to what it does not write.
    world.schedule_scope(PhysicsSchedule, |_, schedule| {
        let push = move |mut bodies: Query<&mut Velocity>| bodies.get_mut(moving).unwrap().linear = DVec3::Z * 6.0;
        let lift = move |mut commands: Commands, stats: Res<StepStats>| {
            commands.entity(resting).insert(Position(DVec3::Y * stats.steps as f64));
        };
        schedule.add_systems((
            push.in_set(PhysicsSystems::Events),
            (lift, ApplyDeferred).chain().after(PhysicsSystems::Solve).before(PhysicsSystems::WriteBack),
        ));
    });
    step(&mut world);
    let (before, put) = (packed(&world, moving).position, *world.get::<Position>(resting).unwrap());
    step(&mut world);
    assert!((packed(&world, moving).position.z - before.z - 0.1).abs() < 1e-12);
    assert_eq!(DVec3::from(packed(&world, resting).position), put.0);
}

fn changed(bodies: Query<(Entity, Ref<Position>, Ref<Rotation>, Ref<Velocity>)>) -> Vec<(Entity, [bool; 3])> {
    bodies.iter().map(|(entity, x, q, v)| (entity, [x.is_changed(), q.is_changed(), v.is_changed()])).collect()
}

#[test]
fn only_what_moved_in_a_bit_counts_as_changed() {
    let mut world = world();
    let moving = ball(&mut world, 0.0);
    world.get_mut::<Velocity>(moving).unwrap().linear = DVec3::Y;
    let spinning = ball(&mut world, 5.0);
    world.get_mut::<Velocity>(spinning).unwrap().angular = DVec3::Y;
    let pushed = ball(&mut world, 10.0);
    world.entity_mut(pushed).insert(ExternalForce { force: DVec3::X, ..default() });
    let resting = ball(&mut world, 15.0);
    let shelf = world.spawn((RigidBody::Static, Collider::sphere(0.5), Position(DVec3::X * 20.0))).id();
    step(&mut world);
    world.run_system_cached(changed).unwrap();
    step(&mut world);
    let mut expected = [
        (moving, [true, false, false]),
        (spinning, [false, true, false]),
        (pushed, [true, false, true]),
        (resting, [false; 3]),
        (shelf, [false; 3]),
    ];
    let mut found = world.run_system_cached(changed).unwrap();
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn a_body_let_go_before_the_next_step_and_not_mended_is_caught_again() {
    let (mut world, [bad, _]) = steady();
    world.entity_mut(bad).insert(SurfaceMaterial { friction: -1.0, restitution: 0.0 });
    for _ in 0..3 {
        step(&mut world);
        assert_eq!(world.resource::<StepStats>().quarantined, 1);
        assert!(world.entity_mut(bad).take::<Quarantined>().is_some());
    }
    world.entity_mut(bad).insert(SurfaceMaterial::default());
    let before = packed(&world, bad).position;
    step(&mut world);
    assert_eq!(world.resource::<StepStats>().quarantined, 0);
    world.get_mut::<Velocity>(bad).unwrap().linear = DVec3::Y;
    step(&mut world);
    assert!(packed(&world, bad).position.y > before.y);
}

#[test]
fn bodies_that_change_places_by_being_disabled_keep_their_states_apart() {
    let (mut world, [first, second]) = steady();
    world.entity_mut(first).insert(Disabled);
    step(&mut world);
    let frozen = world.get::<Position>(first).unwrap().0;
    // As many bodies as before, another one.
    world.entity_mut(first).remove::<Disabled>();
    world.entity_mut(second).insert(Disabled);
    let kept = world.get::<Position>(second).unwrap().0;
    step(&mut world);
    assert_eq!(world.resource::<Bodies>().list.len(), 1);
    let moved = world.get::<Position>(first).unwrap().0;
    assert!((moved - frozen - DVec3::Y / 60.0).length() < 1e-12, "{moved} from {frozen}");
    assert_eq!(world.get::<Position>(second).unwrap().0, kept);
}

/// Two balls that hang from a post, one of 1 kg, one of 3 kg.
fn pendulums(world: &mut World) -> [Entity; 2] {
    world.insert_resource(Gravity(DVec3::NEG_Y * 10.0));
    let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
    [1.0, 3.0].map(|mass| {
        let arm = DVec3::new(mass, 1.0, 0.0);
        let bob = ball(world, 0.0);
        world.entity_mut(bob).insert((Mass(mass), Position(DVec3::X * mass - DVec3::Y)));
        world.spawn(BallJoint::new(post, bob).with_anchors(DVec3::X * mass, arm - DVec3::X * mass)).id()
    })
}

#[test]
fn a_load_is_that_of_its_own_joint_alone() {
    let mut world = world();
    let [light, heavy] = pendulums(&mut world);
    world.entity_mut(heavy).insert(JointLoad::default());
    (0..60).for_each(|_| step(&mut world));
    let load = world.get::<JointLoad>(heavy).unwrap();
    assert!((load.force.y - 30.0).abs() < 0.1, "{load:?}");
    assert!(world.get::<JointLoad>(light).is_none());
    // Packed anew, it has another place.
    world.despawn(light);
    world.get_mut::<JointLoad>(heavy).unwrap().force = DVec3::ZERO;
    step(&mut world);
    let load = world.get::<JointLoad>(heavy).unwrap();
    assert!((load.force.y - 30.0).abs() < 0.1, "{load:?}");
}

#[test]
fn joints_are_packed_anew_only_when_one_or_the_bodies_changed() {
    let mut world = world();
    let [light, heavy] = pendulums(&mut world);
    (0..4).for_each(|_| step(&mut world));
    let version = |world: &World| world.resource::<Joints>().version;
    let before = version(&world);
    (0..4).for_each(|_| step(&mut world));
    assert_eq!(version(&world), before, "nothing changed");

    world.get_mut::<BallJoint>(light).unwrap().anchor_a.x += 0.001;
    step(&mut world);
    assert_eq!(version(&world), before + 1, "an anchor");

    let extra = ball(&mut world, 50.0);
    step(&mut world);
    assert_eq!(version(&world), before + 2, "a body more");
    *world.get_mut::<RigidBody>(extra).unwrap() = RigidBody::Kinematic;
    step(&mut world);
    assert_eq!(version(&world), before + 3, "another kind");
    world.despawn(extra);
    step(&mut world);
    assert_eq!(version(&world), before + 4, "a body less");

    // As an app that draws many frames between two steps: removal events are forgotten by then.
    world.despawn(light);
    (0..3).for_each(|_| world.clear_trackers());
    step(&mut world);
    assert_eq!(version(&world), before + 5, "a joint less");
    assert_eq!(world.resource::<StepStats>().joints, 1);

    world.get_mut::<BallJoint>(heavy).unwrap().anchor_a.x = f64::NAN;
    (0..3).for_each(|_| step(&mut world));
    assert_eq!(version(&world), before + 6, "a bad joint");
    assert_eq!(world.resource::<StepStats>().joints, 0);
    world.entity_mut(heavy).remove::<Quarantined>();
    (0..3).for_each(|_| world.clear_trackers());
    step(&mut world);
    assert_eq!(version(&world), before + 7, "let go, still bad");
    assert!(world.get::<Quarantined>(heavy).is_some());
}

#[test]
fn steady_steps_allocate_nothing_here() {
    let mut world = world();
    let joints = pendulums(&mut world);
    world.entity_mut(joints[0]).insert(JointLoad::default());
    let bodies: Vec<Entity> = (0..200).map(|x| ball(&mut world, f64::from(x) * 3.0)).collect();
    world.entity_mut(bodies[0]).insert(ExternalForce::default());
    step(&mut world);
    let mut schedule = Schedule::default();
    schedule
        .add_systems((gather_bodies, gather_joints.run_if(joints_changed), write_joint_loads, write_bodies).chain());
    schedule.set_executor(SingleThreadedExecutor::new());
    let mut run = |world: &mut World| {
        // Some bodies move, some are written to.
        world.resource_mut::<Bodies>().list.iter_mut().for_each(|body| body.position.x += 0.1);
        world.get_mut::<ExternalForce>(bodies[0]).unwrap().force.x += 1.0;
        world.get_mut::<Transform>(bodies[1]).unwrap().translation.x += 1.0;
        schedule.run(world);
    };
    (0..3).for_each(|_| run(&mut world));
    let used = allocation_counter::measure(|| run(&mut world));
    assert_eq!(used.count_total, 0, "{used:?}");
}

#[test]
fn a_jump_of_a_static_body_is_not_drawn_as_a_glide() {
    let (mut world, [body, _]) = steady();
    *world.get_mut::<RigidBody>(body).unwrap() = RigidBody::Static;
    step(&mut world);
    world.get_mut::<Position>(body).unwrap().0 = DVec3::splat(9.0);
    step(&mut world);
    world.insert_resource(Time::<Fixed>::default());
    world.insert_resource(RenderOrigin(DVec3::ZERO));
    world.run_system_cached(crate::physics::transform::write_interpolated).unwrap();
    assert_eq!(world.get::<Transform>(body).unwrap().translation, Vec3::splat(9.0));
}
