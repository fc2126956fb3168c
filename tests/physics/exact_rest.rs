//! The exact method where nothing moves any more: it solves nothing, tells the forces that it found, and goes on when
//! something changes.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::{AddConstraint, BodyState, Constraint, ConstraintRow, ConstraintRows, ContactForces, StepStats};
use plumb::prelude::*;

use crate::rig::*;

const ROWS: usize = 4;
const CUBES: usize = ROWS * (ROWS + 1) / 2;
const MASS: f64 = 2.0;

/// A wall of cubes on a floor that could move, and beside it two that a joint holds together; all at rest for a second.
struct Standing {
    world: World,
    floor: Entity,
    cubes: Vec<Entity>,
    joint: Entity,
}

fn standing() -> Standing {
    let mut world = world_with(SolverSettings::accurate());
    world.init_resource::<ContactForces>();
    let floor = body(&mut world, Collider::cuboid(40.0, 1.0, 40.0), DVec3::Y * -0.5);
    world.entity_mut(floor).insert(RigidBody::Kinematic);
    let mut cube = |x: f64, y: usize| {
        let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::new(x, y as f64 + 0.5, 0.0));
        // Given, so that a new shape changes nothing else.
        world.entity_mut(cube).insert((Mass(MASS), Inertia(DVec3::splat(MASS / 6.0))));
        cube
    };
    let mut cubes = Vec::new();
    for row in 0..ROWS {
        cubes.extend((0..ROWS - row).map(|place| cube(1.1 * place as f64 + 0.55 * row as f64, row)));
    }
    let pair = [cube(-5.0, 0), cube(-3.9, 0)];
    let anchors = [DVec3::new(0.55, 0.2, 0.0), DVec3::new(-0.55, 0.2, 0.0)];
    let joint = world.spawn(BallJoint::new(pair[0], pair[1]).with_anchors(anchors[0], anchors[1])).id();
    cubes.extend(pair);
    run(&mut world, 1.5);
    Standing { world, floor, cubes, joint }
}

/// Bodies at rest, and row updates of the last step.
fn effort(world: &World) -> (u32, u64) {
    let stats = world.resource::<StepStats>();
    (stats.resting, stats.row_updates)
}

#[test]
fn what_stands_still_is_solved_no_more() {
    let Standing { mut world, cubes, .. } = standing();
    let before = state_hash(&world);
    for _ in 0..10 {
        steps(&mut world, 1);
        assert_eq!(effort(&world), (cubes.len() as u32, 0));
        assert_eq!(state_hash(&world), before);
        let forces = &world.resource::<ContactForces>().0;
        let on_floor = forces.iter().filter(|force| force.point.y < 0.1).map(|force| force.force.y.abs()).sum::<f64>();
        assert_close(on_floor, (CUBES + 2) as f64 * MASS * 9.81, 1e-7);
    }
    for &cube in &cubes {
        assert_eq!((velocity(&world, cube), spin(&world, cube)), (DVec3::ZERO, DVec3::ZERO));
    }
}

/// Two balls roll past each other elsewhere on the floor, in reach of each other for a while: islands are numbered anew.
#[test]
fn what_stands_still_rests_whatever_comes_and_goes_beside_it() {
    let Standing { mut world, cubes, .. } = standing();
    for (x, way) in [(12.0, 1.0), (13.02, -1.0)] {
        let ball = body(&mut world, Collider::sphere(0.5), DVec3::new(x, 0.5, -6.0 * way));
        world.get_mut::<Velocity>(ball).expect("a ball").linear.z = 6.0 * way;
    }
    run(&mut world, 1.0);
    let mut islands = Vec::new();
    for _ in 0..40 {
        steps(&mut world, 1);
        assert_eq!(effort(&world).0, cubes.len() as u32);
        islands.push(world.resource::<StepStats>().islands);
    }
    islands.dedup();
    assert_eq!(islands, [4, 3, 4], "the balls meet and part");
}

#[test]
fn whatever_is_changed_is_solved_again() {
    let changes: [(&str, fn(&mut Standing)); 12] = [
        ("velocity", |it| it.world.get_mut::<Velocity>(it.cubes[9]).expect("a cube").linear.x = 1e-9),
        ("place", |it| it.world.get_mut::<Position>(it.cubes[9]).expect("a cube").0.x += 1e-6),
        ("rotation", |it| it.world.get_mut::<Rotation>(it.cubes[9]).expect("a cube").0 = DQuat::from_rotation_y(1e-3)),
        ("mass", |it| {
            it.world.entity_mut(it.cubes[9]).insert(Mass(3.0));
        }),
        ("inertia", |it| {
            it.world.entity_mut(it.cubes[9]).insert(Inertia(DVec3::ONE));
        }),
        ("shape", |it| {
            it.world.entity_mut(it.cubes[9]).insert(Collider::cuboid(0.9, 1.0, 1.0));
        }),
        ("surface", |it| {
            let smooth = SurfaceMaterial { friction: 0.1, restitution: 0.0 };
            it.world.entity_mut(it.cubes[0]).insert(smooth);
        }),
        ("weight", |it| it.world.resource_mut::<Gravity>().0.y = -9.0),
        ("floor", |it| it.world.get_mut::<Velocity>(it.floor).expect("a floor").linear.x = 0.1),
        ("a body less", |it| assert!(it.world.despawn(it.cubes[0]))),
        ("joint", |it| assert!(it.world.despawn(it.joint))),
        ("step", |it| it.world.resource_mut::<SolverSettings>().hz = 120.0),
    ];
    for (name, change) in changes {
        let mut it = standing();
        assert_eq!(effort(&it.world).0, it.cubes.len() as u32, "{name}: at rest before");
        change(&mut it);
        steps(&mut it.world, 1);
        let resting = effort(&it.world).0;
        // The pair and the wall are two groups, of which most changes touch one.
        assert!(resting < it.cubes.len() as u32 - 1, "{name}: {resting} still rest");
        run(&mut it.world, 1.5);
        if name != "floor" {
            let left = it.cubes.iter().filter(|&&cube| it.world.get_entity(cube).is_ok()).count();
            assert_eq!(effort(&it.world), (left as u32, 0), "{name}: at rest after");
        }
    }
}

/// Keeps a body from falling below where it is, and from two seconds on below a place that rises.
#[derive(Component, Clone)]
struct Lift {
    floor: Entity,
    body: Entity,
}

impl Constraint for Lift {
    fn bodies(&self) -> [Entity; 2] {
        [self.floor, self.body]
    }

    fn rows(&self, [_, body]: &[BodyState; 2], time: f64) -> ConstraintRows {
        let (height, rate) = if time < 2.0 { (0.5, 0.0) } else { (0.5 + 0.1 * (time - 2.0), 0.1) };
        let (error, linear) = (body.position.y - height, [DVec3::NEG_Y, DVec3::Y]);
        [ConstraintRow { linear, error, time_rate: -rate, bounds: (0.0, f64::INFINITY), ..default() }].into()
    }
}

#[test]
fn what_time_alone_moves_does_not_rest() {
    let mut app = headless_app();
    app.add_constraint::<Lift>();
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(SolverSettings::accurate());
    let floor = ground(&mut world);
    let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
    world.spawn(Lift { floor, body: cube });
    run(&mut world, 2.0);
    assert_near(position(&world, cube), DVec3::Y * 0.5, 1e-9);
    run(&mut world, 1.0);
    assert_close(position(&world, cube).y, 0.6, 1e-6);
}

/// A capsule on its end leans by 1e-9 rad: by θ = θ₀ cosh σt it rolls over, σ² = m g l/(I + m (l + r)²), with its centre
/// of mass at l over that of the end.
#[test]
fn a_rod_that_leans_by_little_falls() {
    let (radius, length, lean) = (0.1, 1.0, 1e-9);
    let mut world = world_with(SolverSettings::accurate());
    ground(&mut world);
    let half = 0.5 * length;
    let place = DVec3::new(-half * f64::sin(lean), radius + half * f64::cos(lean), 0.0);
    let rod = body(&mut world, Collider::capsule(radius, length), place);
    let properties = Collider::capsule(radius, length).mass_properties(1000.0);
    world.entity_mut(rod).insert((Rotation(DQuat::from_rotation_z(lean)), Mass(properties.mass)));
    let about_contact = properties.inertia.x + properties.mass * (half + radius).powi(2);
    let rate = (properties.mass * 9.81 * half / about_contact).sqrt();
    let leans = |world: &World| (world.get::<Rotation>(rod).expect("a rod").0 * DVec3::Y).x.abs();
    let mut time = 0.0;
    while leans(&world) < 1e-3 && time < 20.0 {
        steps(&mut world, 1);
        time += 1.0 / 60.0;
    }
    let expected = (leans(&world) / lean).acosh() / rate;
    assert!((time / expected - 1.0).abs() < 0.02, "{time} s, {expected} s expected");
}
