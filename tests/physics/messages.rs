//! What the step tells a game: contacts, collisions, layers, joints of gone bodies.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

fn pair_of(a: Entity, b: Entity) -> (Entity, Entity) {
    (a.min(b), a.max(b))
}

#[test]
fn a_contact_starts_once_and_ends_once() {
    let mut world = world_with(SolverSettings::steady());
    let floor = ground(&mut world);
    let block = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.6);
    let (mut started, mut ended) = (Vec::new(), Vec::new());
    let mut after = |world: &mut World, count: u32| {
        for _ in 0..count {
            step(world);
            started.extend(take::<ContactStarted>(world).iter().map(|contact| pair_of(contact.a, contact.b)));
            ended.extend(take::<ContactEnded>(world).iter().map(|contact| pair_of(contact.a, contact.b)));
        }
        (started.clone(), ended.clone())
    };
    let touch = pair_of(floor, block);
    assert_eq!(after(&mut world, 120), (vec![touch], vec![]));
    world.get_mut::<Velocity>(block).unwrap().linear.y = 3.0;
    assert_eq!(after(&mut world, 12), (vec![touch], vec![touch]));
    // Back down, and gone while touching.
    assert_eq!(after(&mut world, 120), (vec![touch; 2], vec![touch]));
    world.despawn(block);
    assert_eq!(after(&mut world, 1), (vec![touch; 2], vec![touch; 2]));
    assert_eq!(after(&mut world, 5), (vec![touch; 2], vec![touch; 2]));
}

#[derive(Resource, Default)]
struct Heard(Vec<(&'static str, Entity, Entity)>);

#[test]
fn contact_events_reach_those_who_observe() {
    let mut world = world_with(SolverSettings::steady());
    world.init_resource::<Heard>();
    world.add_observer(|event: On<ContactStarted>, mut heard: ResMut<Heard>| {
        heard.0.push(("start", event.a, event.b));
    });
    world.add_observer(|event: On<ContactEnded>, mut heard: ResMut<Heard>| heard.0.push(("end", event.a, event.b)));
    let floor = ground(&mut world);
    let heard = body(&mut world, Collider::sphere(0.5), DVec3::Y * 0.55);
    let unheard = body(&mut world, Collider::sphere(0.5), DVec3::new(3.0, 0.55, 0.0));
    world.entity_mut(heard).insert(ObserveContacts);
    steps(&mut world, 30);
    assert_eq!(world.resource::<Heard>().0, [("start", heard, floor)]);
    for ball in [heard, unheard] {
        world.get_mut::<Velocity>(ball).unwrap().linear.y = 5.0;
    }
    steps(&mut world, 10);
    assert_eq!(world.resource::<Heard>().0, [("start", heard, floor), ("end", heard, floor)]);
    // Both of a pair, each as its own `a`.
    world.entity_mut(floor).insert(ObserveContacts);
    run(&mut world, 2.0);
    let all = std::mem::take(&mut world.resource_mut::<Heard>().0);
    for expected in [("start", heard, floor), ("start", floor, heard), ("start", floor, unheard)] {
        assert_eq!(all[2..].iter().filter(|&&event| event == expected).count(), 1, "{expected:?} in {all:?}");
    }
    assert_eq!(all.len(), 5, "{all:?}");
}

#[test]
fn collisions_are_told_of_those_who_report_them() {
    let mut world = weightless(SolverSettings::classic());
    ground(&mut world);
    let start = DVec3::new(0.0, 0.62, 0.0);
    let motion = Velocity { linear: DVec3::new(2.0, -3.0, 0.0), angular: DVec3::new(0.0, 0.0, 4.0) };
    let reported = body(&mut world, Collider::sphere(0.5), start);
    let silent = body(&mut world, Collider::sphere(0.5), start + DVec3::Z * 4.0);
    world.entity_mut(reported).insert((ReportCollisions, motion));
    world.entity_mut(silent).insert(motion);
    // At 5 cm a step it overlaps the ground after three.
    steps(&mut world, 3);
    take::<Collision>(&mut world);
    let (place, velocity) = (position(&world, reported), *world.get::<Velocity>(reported).unwrap());
    step(&mut world);
    let seen = take::<Collision>(&mut world);
    assert_eq!(seen.len(), 1, "{seen:?}");
    let Collision { a, b, point, normal, depth, relative_velocity, time } = seen[0];
    assert!([a, b].contains(&reported));
    let sign = if b == reported { 1.0 } else { -1.0 };
    assert_near(normal, DVec3::Y * sign, 1e-12);
    assert_close(depth, 0.5 - place.y, 1e-12);
    assert!(depth > 0.01);
    // Somewhere between the ball's lowest point and the surface above it.
    assert_close(point.x, place.x, 1e-12);
    assert!(point.y <= 1e-12 && point.y >= -depth - 1e-12, "{point}");
    let of_point = velocity.linear + velocity.angular.cross(point - place);
    assert_near(relative_velocity, of_point * sign, 1e-12);
    assert_close(time, 3.0 / 60.0, 1e-15);
}

#[test]
fn layers_choose_who_touches_whom() {
    let mut world = world_with(SolverSettings::steady());
    let floor = ground(&mut world);
    let layers = |memberships, filters| CollisionLayers { memberships, filters };
    world.entity_mut(floor).insert(layers(0b001, 0b110));
    let mut drop_in = |x: f64, layers: CollisionLayers| {
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::new(x, 0.6, 0.0));
        world.entity_mut(ball).insert(layers);
        ball
    };
    let held = drop_in(0.0, layers(0b010, 0b001));
    let not_filtered_for = drop_in(3.0, layers(0b1000, 0b001));
    let filters_for_others = drop_in(6.0, layers(0b010, 0b100));
    let in_no_layer = drop_in(9.0, CollisionLayers::NONE);
    run(&mut world, 1.0);
    assert_close(position(&world, held).y, 0.5, 0.01);
    for ball in [not_filtered_for, filters_for_others, in_no_layer] {
        assert!(position(&world, ball).y < -3.0);
    }
}

/// Two overlapping balls joined at their centres' middle; the joint as given.
fn overlapping_pair(world: &mut World, joint: impl Fn(BallJoint) -> BallJoint) -> (Entity, Entity, Entity) {
    let left = body(world, Collider::sphere(0.5), DVec3::X * -0.4);
    let right = body(world, Collider::sphere(0.5), DVec3::X * 0.4);
    let between = BallJoint::new(left, right).with_anchors(DVec3::X * 0.4, DVec3::X * -0.4);
    let joint = world.spawn(joint(between)).id();
    (left, right, joint)
}

#[test]
fn joined_bodies_do_not_collide_unless_asked() {
    let mut world = weightless(SolverSettings::steady());
    let (_, _, joint) = overlapping_pair(&mut world, |joint| joint);
    steps(&mut world, 2);
    assert_eq!(world.resource::<StepStats>().manifolds, 0);
    world.get_mut::<BallJoint>(joint).unwrap().collide = true;
    step(&mut world);
    assert_eq!(world.resource::<StepStats>().manifolds, 1);
    world.despawn(joint);
    step(&mut world);
    assert_eq!(world.resource::<StepStats>().manifolds, 1, "no longer joined, they collide");

    let mut world = weightless(SolverSettings::steady());
    overlapping_pair(&mut world, BallJoint::with_collision);
    step(&mut world);
    assert_eq!(world.resource::<StepStats>().manifolds, 1);
}

#[test]
fn a_gone_body_takes_its_joints_along_in_the_same_step() {
    let mut world = world_with(SolverSettings::steady());
    let post = world.spawn((RigidBody::Static, Transform::from_xyz(0.0, 10.0, 0.0))).id();
    let hung = body(&mut world, Collider::sphere(0.2), DVec3::Y * 9.0);
    let lower = body(&mut world, Collider::sphere(0.2), DVec3::Y * 8.0);
    let upper_joint = world.spawn(BallJoint::new(post, hung).with_anchors(DVec3::ZERO, DVec3::Y)).id();
    let lower_joint = world.spawn(BallJoint::new(hung, lower).with_anchors(-DVec3::Y, DVec3::ZERO)).id();
    run(&mut world, 0.5);
    assert_close(position(&world, lower).y, 8.0, 0.01);
    world.despawn(hung);
    step(&mut world);
    for joint in [upper_joint, lower_joint] {
        assert!(world.get_entity(joint).is_err(), "its joint is still there");
    }
    assert_eq!(world.resource::<StepStats>().joints, 0);
    let falling = velocity(&world, lower).y;
    assert_close(falling, -9.81 / 60.0, 0.02);
    run(&mut world, 0.5);
    assert_close(velocity(&world, lower).y, falling - 9.81 * 0.5, 1e-9);
}
