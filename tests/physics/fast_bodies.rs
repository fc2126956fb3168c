//! What is fast is stopped by what is in its way, and by nothing else.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

const H: f64 = 1.0 / 60.0;

/// Neither friction nor bounce, so that only the normal counts.
const SMOOTH: SurfaceMaterial = SurfaceMaterial { friction: 0.0, restitution: 0.0 };

fn world() -> World {
    weightless(SolverSettings::game())
}

fn put(world: &mut World, kind: RigidBody, collider: Collider, at: DVec3, linear: DVec3, turned: DQuat) -> Entity {
    let velocity = Velocity { linear, angular: DVec3::ZERO };
    world.spawn((kind, collider, Position(at), Rotation(turned), velocity, SMOOTH)).id()
}

fn fixed(world: &mut World, collider: Collider, at: DVec3) -> Entity {
    put(world, RigidBody::Static, collider, at, DVec3::ZERO, DQuat::IDENTITY)
}

fn thrown(world: &mut World, collider: Collider, at: DVec3, linear: DVec3, turned: DQuat) -> Entity {
    put(world, RigidBody::Dynamic, collider, at, linear, turned)
}

/// Small bodies of each kind, each 0.2 m across.
fn small() -> [Collider; 3] {
    [Collider::sphere(0.1), Collider::cuboid(0.2, 0.2, 0.2), Collider::cone(0.1, 0.2)]
}

/// Shares of a step, so that impacts fall anywhere in it.
fn phases() -> impl Iterator<Item = f64> {
    (0..20).map(|k| f64::from(k) / 20.0)
}

#[test]
fn thin_walls_stop_what_is_fast_and_where_they_are() {
    for collider in small() {
        for (speed, slope) in [30.0, 100.0, 1e3, 1e4].into_iter().flat_map(|speed| [(speed, 0.0), (speed, 0.8)]) {
            for phase in phases() {
                let mut world = world();
                fixed(&mut world, Collider::cuboid(0.01, 4.0, 4.0), DVec3::ZERO);
                let velocity = DVec3::new(f64::cos(slope), f64::sin(slope), 0.0) * speed;
                let start = DVec3::Z * 0.3 - velocity * (1.0 + phase) * H;
                let body = thrown(&mut world, collider.clone(), start, velocity, DQuat::from_rotation_z(TAU * phase));
                // Until the step of the impact is over; a slanted one slides on, off the wall's end.
                let mut nearest = f64::NEG_INFINITY;
                for _ in 0..3 {
                    step(&mut world);
                    let at = position(&world, body);
                    if at.y.abs() > 2.2 {
                        break;
                    }
                    nearest = nearest.max(at.x);
                }
                let case = format!("{collider:?} at {speed} m/s, slope {slope}, phase {phase}: {nearest}");
                assert!(nearest < 0.0, "through the wall: {case}");
                // Nor well before the wall.
                assert!(slope > 0.0 || nearest > -0.3 - 0.02 * speed * H, "{case}");
            }
        }
    }
}

/// Whatever passes beside edges and corners, near as it may be, is not touched.
#[test]
fn what_passes_beside_goes_on_as_it_was() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let on_edge = DQuat::from_rotation_z(FRAC_PI_4);
    let on_corner = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::Y);
    let obstacles = [
        (cube.clone(), DQuat::IDENTITY, 0.5),
        (cube.clone(), on_edge, 0.5_f64.sqrt()),
        (cube, on_corner, 0.75_f64.sqrt()),
        (Collider::sphere(0.5), DQuat::IDENTITY, 0.5),
        (Collider::cuboid(0.01, 1.0, 4.0), DQuat::IDENTITY, 0.5),
    ];
    let passing =
        [(Collider::sphere(0.1), 0.1), (Collider::cuboid(0.2, 0.2, 0.2), 0.1), (Collider::cone(0.1, 0.2), 0.05)];
    for (obstacle, turned, top) in &obstacles {
        for ((collider, below), speed) in
            passing.iter().flat_map(|passing| [10.0, 100.0, 1e3, 1e4].map(|v| (passing, v)))
        {
            for phase in phases() {
                let mut world = world();
                put(&mut world, RigidBody::Static, obstacle.clone(), DVec3::ZERO, DVec3::ZERO, *turned);
                let velocity = DVec3::X * speed;
                let over = DVec3::Y * (top + below + 0.002);
                let start = over - velocity * (1.0 + phase) * H;
                let body = thrown(&mut world, collider.clone(), start, velocity, DQuat::IDENTITY);
                steps(&mut world, 3);
                let change = self::velocity(&world, body) - velocity;
                assert!(change.length() < 1e-9 * speed, "{collider:?} over {obstacle:?} at {speed} m/s: {change}");
            }
        }
    }
}

#[test]
fn fast_bodies_meet_head_on_or_pass() {
    for collider in small().into_iter().take(2) {
        for speed in [100.0, 1e3, 1e4] {
            for phase in phases() {
                for (beside, meet) in [(0.0, true), (0.05, true), (0.205, false)] {
                    let mut world = world();
                    let (velocity, way) = (DVec3::X * speed, DVec3::X * speed * (1.0 + phase) * H);
                    let one = thrown(&mut world, collider.clone(), -way, velocity, DQuat::IDENTITY);
                    let other = DVec3::Y * beside;
                    let other = thrown(&mut world, collider.clone(), way + other, -velocity, DQuat::IDENTITY);
                    steps(&mut world, 3);
                    let [first, second] = [one, other].map(|body| self::velocity(&world, body));
                    let case =
                        format!("{collider:?} at {speed} m/s, {beside} m beside, phase {phase}: {first} {second}");
                    if meet {
                        // Equal masses without bounce: what is left of the approach is nothing, but for what turns.
                        assert!(first.x - second.x < 0.6 * speed, "{case}");
                        assert!((first + second).length() < 1e-5 * speed, "momentum: {case}");
                    } else {
                        assert!((first - velocity).length() < 1e-9 * speed, "{case}");
                    }
                }
            }
        }
    }
}

#[test]
fn walls_that_move_fast_take_small_bodies_along() {
    for collider in small() {
        for speed in [10.0, 100.0, 1e3] {
            for phase in phases() {
                let mut world = world();
                let velocity = DVec3::X * speed;
                let (thin, at) = (Collider::cuboid(0.01, 4.0, 4.0), -velocity * (1.5 + phase) * H);
                let wall = put(&mut world, RigidBody::Kinematic, thin, at, velocity, DQuat::IDENTITY);
                let turned = DQuat::from_rotation_z(TAU * phase);
                let body = thrown(&mut world, collider.clone(), DVec3::Z * 0.3, DVec3::ZERO, turned);
                steps(&mut world, 4);
                let ahead = position(&world, body).x - position(&world, wall).x;
                assert!(ahead > 0.0, "{collider:?}, {speed} m/s, phase {phase}: {ahead}");
            }
        }
    }
}

/// The first wall turns them aside, along itself and into the second.
#[test]
fn nothing_slides_out_of_the_corner_of_a_room() {
    for speed in [30.0, 100.0, 1e3, 1e4] {
        for phase in phases() {
            let mut world = world();
            fixed(&mut world, Collider::cuboid(0.01, 4.0, 4.0), DVec3::X * 0.005);
            fixed(&mut world, Collider::cuboid(4.0, 0.01, 4.0), DVec3::new(-2.0, 2.005, 0.0));
            let velocity = DVec3::new(0.7, 0.714, 0.0) * speed;
            let start = DVec3::new(-0.8 * phase, 2.0, 0.0) - velocity * (0.2 + 1.3 * phase) * H;
            let ball = thrown(&mut world, Collider::sphere(0.1), start, velocity, DQuat::IDENTITY);
            for _ in 0..4 {
                step(&mut world);
                let at = position(&world, ball);
                assert!(at.x < 0.0 && at.y < 2.0, "{speed} m/s, phase {phase}: {at}");
            }
        }
    }
}

/// A step turns it by 0.3 to 6.7 rad.
#[test]
fn a_spinning_rod_sweeps_through_no_wall() {
    for (spin, distance) in [20.0, 100.0, 200.0, 400.0].into_iter().flat_map(|spin| [(spin, 0.1), (spin, 0.45)]) {
        for phase in phases() {
            let mut world = world();
            fixed(&mut world, Collider::cuboid(0.01, 4.0, 4.0), DVec3::ZERO);
            let turned = DQuat::from_rotation_z(0.2 * phase);
            let rod =
                thrown(&mut world, Collider::cuboid(0.03, 1.0, 0.03), DVec3::X * -distance, DVec3::X * 3.0, turned);
            world.get_mut::<Velocity>(rod).unwrap().angular = DVec3::Z * spin;
            for _ in 0..30 {
                step(&mut world);
                let at = position(&world, rod);
                assert!(at.x < 0.0, "{spin} rad/s, {distance} m from the wall, phase {phase}: {at}");
                let energy = velocity(&world, rod).length_squared() + self::spin(&world, rod).length_squared() / 12.0;
                assert!(energy < (9.0 + spin * spin / 12.0) * 1.05, "{spin} rad/s: energy {energy}");
            }
        }
    }
}

/// Its ends pass the wall by, half a step before and after they would point at it.
#[test]
fn a_rod_that_spins_clear_of_a_wall_is_not_touched() {
    for spin in [50.0, 200.0] {
        let mut world = world();
        fixed(&mut world, Collider::cuboid(0.01, 4.0, 4.0), DVec3::ZERO);
        fixed(&mut world, Collider::half_space(), DVec3::Y * -0.51);
        let rod = thrown(&mut world, Collider::cuboid(0.03, 1.0, 0.03), DVec3::X * -0.51, DVec3::ZERO, DQuat::IDENTITY);
        world.get_mut::<Velocity>(rod).unwrap().angular = DVec3::Z * spin;
        steps(&mut world, 60);
        assert_near(position(&world, rod), DVec3::X * -0.51, 1e-9);
        assert_near(self::spin(&world, rod), DVec3::Z * spin, 1e-6 * spin);
    }
}

/// What was found of a pair at rest does not hold once one of the two is fast.
#[test]
fn a_body_shot_from_rest_beside_a_wall_is_stopped() {
    let mut world = world();
    fixed(&mut world, Collider::cuboid(0.01, 4.0, 4.0), DVec3::ZERO);
    let body = thrown(&mut world, Collider::cuboid(0.2, 0.2, 0.2), DVec3::X * -0.11, DVec3::ZERO, DQuat::IDENTITY);
    steps(&mut world, 10);
    world.get_mut::<Velocity>(body).unwrap().linear = DVec3::X * 1000.0;
    steps(&mut world, 3);
    assert!(position(&world, body).x < 0.0);
}

/// One in flight falls as if nothing were below until it is there.
#[test]
fn a_fall_ends_on_the_ground_and_not_before() {
    let mut world = world_with(SolverSettings::game());
    ground(&mut world);
    let body = thrown(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 5.5, DVec3::ZERO, DQuat::IDENTITY);
    let landed = (2.0 * 5.0 / 9.81_f64).sqrt();
    for index in 1..120 {
        step(&mut world);
        let time = f64::from(index) * H;
        let free = 5.5 - 0.5 * 9.81 * time * time;
        // The fall's error is of first order in the substep.
        assert_close(position(&world, body).y, if time < landed { free } else { 0.5 }, 0.03);
    }
    assert_close(position(&world, body).y, 0.5, 0.002);
}

/// A ball far away that spins, tied to a box by its middle, which two pins hold: what holds the tie is 130 m from the ball's
/// centre and flies at 4 km/s.
#[test]
fn an_arm_that_turns_too_far_to_be_followed_gives_no_energy() {
    for pins in 0..3 {
        let mut world = weightless(awake_game());
        world.init_resource::<Diagnostics>();
        let cube = body(&mut world, Collider::cuboid(0.3, 0.3, 0.3), DVec3::ZERO);
        for anchor in [DVec3::new(-0.1, 0.05, -0.1), DVec3::new(0.05, 0.0, 0.1)].into_iter().take(pins) {
            let post = world.spawn((RigidBody::Static, Position(anchor))).id();
            world.spawn(BallJoint::new(post, cube).with_anchors(DVec3::ZERO, anchor));
        }
        let at = DVec3::new(80.0, 2.0, -100.0);
        let ball = body(&mut world, Collider::sphere(0.5), at);
        world.get_mut::<Velocity>(ball).unwrap().angular = DVec3::new(-23.0, 5.0, -18.0);
        world.spawn(
            BallJoint::new(ball, cube).with_anchors(DVec3::new(0.0, 0.1, -0.1) - at, DVec3::new(0.0, 0.1, -0.1)),
        );
        let mut before = 0.5 * 0.1 * 523.6 * 0.25 * (23.0_f64.powi(2) + 25.0 + 18.0_f64.powi(2)) * 1.01;
        for _ in 0..300 {
            step(&mut world);
            let now = world.resource::<Diagnostics>().kinetic_energy;
            assert!(now <= before * 1.001, "{pins} pins: {before} J grow to {now} J");
            before = now.max(1e-3);
        }
    }
}

/// Three boxes on balls off their centres, one of which turns by radians in each substep: what held them in one substep points
/// elsewhere in the next.
#[test]
fn sweeps_give_no_energy_to_joints_that_turn_by_radians_a_substep() {
    let mut settings = awake_game();
    settings.method = Method::SequentialImpulses;
    for spin in [500.0, 2000.0, 6000.0] {
        let mut world = weightless(settings);
        world.init_resource::<Diagnostics>();
        let boxes: Vec<Entity> = (0..3)
            .map(|place| {
                let at = DVec3::X * f64::from(place) * 0.4;
                let own = body(&mut world, Collider::cuboid(0.4, 0.15, 0.1), at);
                world.entity_mut(own).insert(CollisionLayers::NONE);
                own
            })
            .collect();
        for pair in boxes.windows(2) {
            let anchors = [DVec3::new(0.2, 0.05, 0.0), DVec3::new(-0.2, 0.05, 0.0)];
            world.spawn(BallJoint::new(pair[0], pair[1]).with_anchors(anchors[0], anchors[1]));
        }
        let spin = DVec3::new(0.2, 0.3, 0.9).normalize() * spin;
        world.get_mut::<Velocity>(boxes[0]).unwrap().angular = spin;
        // 6 kg.
        let moments = DVec3::new(0.01625, 0.085, 0.09125);
        let given = 0.5 * (moments * spin).dot(spin);
        for index in 0..120 {
            step(&mut world);
            let now = world.resource::<Diagnostics>().kinetic_energy;
            assert!(now <= given * 1.001, "{spin} 1/s, step {index}: {given} J grow to {now} J");
        }
    }
}

/// A net of such boxes, the middle one of which has 120 kg and turns so fast, 1/s.
fn net_that_spins(world: &mut World, [columns, rows]: [usize; 2], spin: f64) {
    world.init_resource::<Diagnostics>();
    let boxes: Vec<Entity> = (0..columns * rows)
        .map(|place| {
            let at = DVec3::new((place % columns) as f64, (place / columns) as f64, 0.0) * 0.4;
            let own = body(world, Collider::cuboid(0.4, 0.15, 0.1), at);
            world.entity_mut(own).insert(CollisionLayers::NONE);
            own
        })
        .collect();
    let (right, up) = (DVec3::new(0.2, 0.05, 0.0), DVec3::new(0.05, 0.2, 0.0));
    for place in 0..columns * rows {
        if (place + 1) % columns != 0 {
            let beside = BallJoint::new(boxes[place], boxes[place + 1]);
            world.spawn(beside.with_anchors(right, DVec3::new(-right.x, right.y, 0.0)));
        }
        if let Some(above) = boxes.get(place + columns) {
            let above = BallJoint::new(boxes[place], *above);
            world.spawn(above.with_anchors(up, DVec3::new(up.x, -up.y, 0.0)));
        }
    }
    let middle = boxes[rows / 2 * columns + columns / 2];
    world.entity_mut(middle).insert(Mass(120.0));
    world.get_mut::<Velocity>(middle).unwrap().angular = DVec3::new(0.2, 0.3, 0.9).normalize() * spin;
}

/// What the middle box has lost to the others does not come back, by one sweep a substep in each of which it turns by eight
/// radians.
#[test]
fn sweeps_over_a_net_give_nothing_back_to_what_turns_by_radians_a_substep() {
    let mut settings = awake_game();
    (settings.method, settings.iterations) = (Method::SequentialImpulses, 1);
    let mut world = weightless(settings);
    net_that_spins(&mut world, [24, 24], 2000.0);
    step(&mut world);
    let left = world.resource::<Diagnostics>().kinetic_energy;
    for index in 0..40 {
        step(&mut world);
        let now = world.resource::<Diagnostics>().kinetic_energy;
        assert!(now <= left * 1.001, "step {index}: {left} J grow to {now} J");
    }
}

/// The same where all joints of an island are solved at once, in chains and in nets.
#[test]
fn joints_solved_at_once_give_no_energy_to_what_turns_by_radians_a_substep() {
    for sides in [[3, 1], [6, 1], [2, 2], [3, 3], [5, 5], [7, 3]] {
        for spin in [500.0, 2000.0, 6000.0, 20_000.0, 100_000.0] {
            let mut world = weightless(awake_game());
            net_that_spins(&mut world, sides, spin);
            let given = 0.5 * 120.0 / 6.0 * 0.087460 * spin * spin;
            for index in 0..60 {
                step(&mut world);
                let now = world.resource::<Diagnostics>().kinetic_energy;
                assert!(now <= given * 1.001, "{sides:?} at {spin} 1/s, step {index}: {given} J grow to {now} J");
            }
        }
    }
}

/// What is hit goes further in the step than it would by itself: into what was out of its reach when the step began, and that
/// into the next. By `accurate` all of them are told of, whether they are one group then or not.
#[test]
fn what_is_thrown_within_a_step_stops_at_what_was_out_of_its_reach() {
    let (radius, speed) = (0.02, 6.0);
    for count in [2, 4] {
        for at_wall in [false, true] {
            let mut world = weightless(SolverSettings::accurate());
            let mut ball = |place: usize, speed: f64| {
                // Two that touch, and others a diameter apart.
                let at = 2.0 * radius * (place as f64 + place.saturating_sub(1) as f64);
                thrown(&mut world, Collider::sphere(radius), DVec3::X * at, DVec3::X * speed, DQuat::IDENTITY)
            };
            let balls: Vec<Entity> =
                (0..count).map(|place| ball(place, if place == 0 { speed } else { 0.0 })).collect();
            let last = position(&world, balls[count - 1]).x;
            if at_wall {
                fixed(&mut world, Collider::cuboid(0.1, 1.0, 1.0), DVec3::X * (last + 3.0 * radius + 0.05));
            }
            for index in 1..=6 {
                step(&mut world);
                let places: Vec<f64> = balls.iter().map(|&ball| position(&world, ball).x).collect();
                let gaps = places.windows(2).map(|pair| pair[1] - pair[0] - 2.0 * radius);
                let least = gaps.fold(f64::INFINITY, f64::min);
                assert!(least > -1e-6, "{count} balls, step {index}: {least} m between two of {places:?}");
                let momentum: f64 = balls.iter().map(|&ball| velocity(&world, ball).x).sum();
                if at_wall {
                    let over = places[count - 1] - (last + 2.0 * radius);
                    assert!(over < 1e-6, "{count} balls, step {index}: {over} m in the wall");
                } else {
                    assert!((momentum - speed).abs() < 1e-9, "{count} balls, step {index}: {momentum} of {speed}");
                }
            }
        }
    }
}

/// A pair that bounces is left free until it lands. What it passed through within a step would not be seen at its end.
#[test]
fn what_bounces_passes_through_nothing_by_accurate() {
    let bouncy = SurfaceMaterial { restitution: 0.5, ..SMOOTH };
    let onto_side = DQuat::from_rotation_z(-FRAC_PI_2);
    let obstacles = [
        (RigidBody::Static, flat(4.0, 8), onto_side, 0.0),
        (RigidBody::Static, Collider::cuboid(0.01, 4.0, 4.0), DQuat::IDENTITY, 0.005),
        (RigidBody::Static, Collider::sphere(0.1), DQuat::IDENTITY, 0.1),
        (RigidBody::Dynamic, Collider::sphere(0.1), DQuat::IDENTITY, 0.1),
    ];
    for (kind, obstacle, turned, front) in obstacles {
        for collider in [Collider::sphere(0.1), Collider::cuboid(0.2, 0.2, 0.2)] {
            for (speed, phase) in [20.0, 100.0, 1e3].into_iter().flat_map(|speed| phases().map(move |at| (speed, at))) {
                let mut world = weightless(SolverSettings::accurate());
                let target = put(&mut world, kind, obstacle.clone(), DVec3::ZERO, DVec3::ZERO, turned);
                let start = DVec3::X * (front + 0.1 + speed * (0.01 + phase) * H);
                let body = thrown(&mut world, collider.clone(), start, DVec3::X * -speed, DQuat::IDENTITY);
                world.entity_mut(target).insert(bouncy);
                world.entity_mut(body).insert(bouncy);
                if kind == RigidBody::Dynamic {
                    let mass = Mass(1.0);
                    world.entity_mut(target).insert(mass);
                    world.entity_mut(body).insert(mass);
                }
                steps(&mut world, 2);
                // Of two of one mass the one that came goes on with (1 − e)/2 of its speed.
                let rebound = if kind == RigidBody::Dynamic { -0.25 * speed } else { 0.5 * speed };
                assert_near(velocity(&world, body), DVec3::X * rebound, 1e-9 * speed);
                let gap = position(&world, body).x - position(&world, target).x - front - 0.1;
                assert!(gap > -1e-9, "{obstacle:?}, {speed} m/s at {phase}: {gap} m");
            }
        }
    }
}

/// What is hit may go farther than it is thick, through what it was too slow to reach when the step began.
#[test]
fn what_is_thrown_within_a_step_passes_through_no_wall() {
    let facing = DQuat::from_rotation_z(FRAC_PI_2);
    let walls = [
        (Collider::cuboid(0.02, 4.0, 4.0), DQuat::IDENTITY, 0.01),
        (flat(4.0, 8), facing, 0.0),
        (Collider::half_space(), facing, 0.0),
    ];
    for (preset, settings) in [("game", awake_game()), ("accurate", SolverSettings::accurate())] {
        for (wall, turned, half) in walls.clone() {
            for (speed, restitution) in [30.0, 100.0].into_iter().flat_map(|speed| [0.0, 0.5, 1.0].map(|e| (speed, e)))
            {
                for distance in [0.3, 0.6] {
                    let mut world = weightless(settings);
                    let material = SurfaceMaterial { friction: 0.0, restitution };
                    let ball = |world: &mut World, x: f64, speed: f64| {
                        let at = DVec3::X * x;
                        let own = thrown(world, Collider::sphere(0.1), at, DVec3::X * speed, DQuat::IDENTITY);
                        world.entity_mut(own).insert(material).id()
                    };
                    let heavy = ball(&mut world, -0.25, speed);
                    world.entity_mut(heavy).insert(Mass(20.0));
                    let light = ball(&mut world, 0.0, 0.0);
                    world.entity_mut(light).insert(Mass(4.0));
                    let at = DVec3::X * distance;
                    let wall = put(&mut world, RigidBody::Static, wall.clone(), at, DVec3::ZERO, turned);
                    world.entity_mut(wall).insert(material);
                    // With half of the ball held in the wall at the most, by `game`.
                    let most = distance - half - if preset == "game" { 0.05 - 1e-3 } else { 0.1 - 1e-6 };
                    for index in 1..=10 {
                        step(&mut world);
                        let x = position(&world, light).x;
                        assert!(x < most, "{preset}, {speed} m/s, e {restitution}, step {index}: {x} of {most} m");
                    }
                    let speeds = [heavy, light].map(|ball| velocity(&world, ball).x.abs());
                    assert!(speeds.iter().all(|own| *own < 1.7 * speed), "{preset}, {speed} m/s: {speeds:?}");
                }
            }
        }
    }
}

/// Bodies on joints that come at a wall: one end stops, the other whips on, through the wall if nothing holds all of them back, and
/// joints part if that holds one back alone.
#[test]
fn what_hangs_together_passes_through_no_wall() {
    let walls = [
        (Collider::cuboid(0.01, 20.0, 20.0), DQuat::IDENTITY, 0.005),
        (flat(20.0, 8), DQuat::from_rotation_z(-FRAC_PI_2), 0.0),
    ];
    let rods = vec![(Collider::cuboid(0.5, 0.1, 0.1), -0.26), (Collider::cuboid(0.5, 0.1, 0.1), 0.26)];
    let plates = vec![(Collider::cuboid(0.3, 0.02, 0.3), -0.16), (Collider::cuboid(0.3, 0.02, 0.3), 0.16)];
    let beads = (-2..=2).map(|place| (Collider::sphere(0.08), 0.2 * f64::from(place))).collect::<Vec<_>>();
    for (name, parts) in [("rods", rods), ("plates", plates), ("beads", beads)] {
        let mut gaps = Vec::new();
        for (wall, turned, half) in walls.clone() {
            for (speed, phase) in
                [20.0, 50.0, 100.0, 400.0].into_iter().flat_map(|speed| phases().map(move |at| (speed, at)))
            {
                let mut world = world();
                world.init_resource::<Diagnostics>();
                put(&mut world, RigidBody::Static, wall.clone(), DVec3::ZERO, DVec3::ZERO, turned);
                let turn = DQuat::from_euler(EulerRot::XYZ, TAU * phase, 5.0 * phase, 3.0 * phase);
                let (middle, spin) = (DVec3::X * (half + 1.0 + phase * speed * H), 20.0 * (turn * DVec3::Z));
                let bodies: Vec<Entity> = parts
                    .iter()
                    .map(|(collider, along)| {
                        let arm = turn * DVec3::X * *along;
                        let linear = spin.cross(arm) - DVec3::X * speed;
                        let body = thrown(&mut world, collider.clone(), middle + arm, linear, turn);
                        world.entity_mut(body).insert(Velocity { linear, angular: spin });
                        body
                    })
                    .collect();
                for (bodies, parts) in bodies.windows(2).zip(parts.windows(2)) {
                    let between = 0.5 * (parts[0].1 + parts[1].1);
                    let anchors = [parts[0].1, parts[1].1].map(|along| DVec3::X * (between - along));
                    world.spawn(BallJoint::new(bodies[0], bodies[1]).with_anchors(anchors[0], anchors[1]));
                }
                for index in 1..=20 {
                    step(&mut world);
                    for &body in &bodies {
                        let x = position(&world, body).x;
                        assert!(x > half, "{name}, {speed} m/s at {phase}, step {index}: {x} m");
                    }
                }
                gaps.push(world.resource::<Diagnostics>().joint_error);
            }
        }
        gaps.sort_by(f64::total_cmp);
        assert!(gaps[gaps.len() / 2] < 1e-3, "{name}: {} m apart in the middle", gaps[gaps.len() / 2]);
    }
}
