//! Rows with bounds under the exact method: limits, dry friction, motors with a largest torque.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::{AddConstraint, BodyState, Constraint, ConstraintRow, ConstraintRows};
use plumb::prelude::*;

use crate::rig::*;

const INF: f64 = f64::INFINITY;

/// What one row wants of the angle about z of B against A, rad, or of B's place along x, m.
#[derive(Clone, Copy, Debug)]
enum Wants {
    /// No less than that, with restitution.
    Least(f64, f64),
    /// No more than that.
    Most(f64, f64),
    /// That speed, rad/s or m/s, with a largest force.
    Speed(f64, f64),
    /// To be at that speed times the time, with a largest force.
    Place(f64, f64),
}

#[derive(Component, Clone)]
struct Law {
    bodies: [Entity; 2],
    slides: bool,
    wants: Wants,
}

impl Constraint for Law {
    fn bodies(&self) -> [Entity; 2] {
        self.bodies
    }

    fn collide(&self) -> bool {
        true
    }

    fn rows(&self, [a, b]: &[BodyState; 2], time: f64) -> ConstraintRows {
        let coordinate = if self.slides {
            b.position.x - a.position.x
        } else {
            let along = a.rotation.inverse() * (b.rotation * DVec3::X);
            along.y.atan2(along.x)
        };
        let (error, time_rate, bounds, restitution) = match self.wants {
            Wants::Least(least, e) => (coordinate - least, 0.0, (0.0, INF), e),
            Wants::Most(most, e) => (coordinate - most, 0.0, (-INF, 0.0), e),
            Wants::Speed(speed, most) => (0.0, -speed, (-most, most), 0.0),
            Wants::Place(speed, most) => (coordinate - speed * time, -speed, (-most, most), 0.0),
        };
        let mut row = ConstraintRow { error, time_rate, bounds, restitution, ..default() };
        if self.slides {
            row.linear = [DVec3::NEG_X, DVec3::X];
        } else {
            row.angular = [DVec3::NEG_Z, DVec3::Z];
        }
        [row].into()
    }
}

/// Holds B on the line along x through A, without turning.
#[derive(Component, Clone)]
struct OnRail([Entity; 2]);

impl Constraint for OnRail {
    fn bodies(&self) -> [Entity; 2] {
        self.0
    }

    fn rows(&self, [a, b]: &[BodyState; 2], _: f64) -> ConstraintRows {
        let from = b.position - a.position;
        let turn = b.rotation.to_scaled_axis();
        let along = |axis: DVec3| ConstraintRow { linear: [-axis, axis], error: axis.dot(from), ..default() };
        let about = |axis: DVec3| ConstraintRow { angular: [-axis, axis], error: axis.dot(turn), ..default() };
        [along(DVec3::Y), along(DVec3::Z), about(DVec3::X), about(DVec3::Y), about(DVec3::Z)].into()
    }
}

fn world() -> World {
    start_pool();
    let mut app = headless_app();
    app.add_constraint::<Law>().add_constraint::<OnRail>();
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(SolverSettings { hz: 240.0, substeps: 1, ..SolverSettings::accurate() });
    world
}

/// About the pivot at its end, kg m²: a rod of 1 × 0.1 × 0.1 m and 1 kg.
const INERTIA: f64 = 1.01 / 12.0 + 0.25;

/// A rod that is so far up from level, rad, by the end that another holds at `pivot`.
fn rod(world: &mut World, on: Entity, pivot: DVec3, up: f64) -> Entity {
    let rotation = DQuat::from_rotation_z(up);
    let rod = body(world, Collider::cuboid(1.0, 0.1, 0.1), pivot + rotation * (DVec3::X * 0.5));
    world.entity_mut(rod).insert((Rotation(rotation), Mass(1.0)));
    let (at, turned) = (position(world, on), world.get::<Rotation>(on).unwrap().0);
    let anchor = turned.inverse() * (pivot - at);
    world.spawn(BallJoint::new(on, rod).with_anchors(anchor, DVec3::X * -0.5));
    rod
}

fn post(world: &mut World) -> Entity {
    world.spawn((RigidBody::Static, Position(DVec3::ZERO), Rotation::default())).id()
}

fn law(world: &mut World, bodies: [Entity; 2], wants: Wants) -> Entity {
    world.spawn((Law { bodies, slides: false, wants }, JointLoad::default())).id()
}

/// Angle about z.
fn angle(world: &World, body: Entity) -> f64 {
    let along = world.get::<Rotation>(body).unwrap().0 * DVec3::X;
    along.y.atan2(along.x)
}

fn settled(world: &World) {
    let stats = world.resource::<StepStats>();
    assert_eq!(stats.unsettled, 0, "at {} s", stats.time);
}

/// A rod 60° above a limit at level, at rest.
fn stop(restitution: f64) -> (World, Entity, Entity) {
    let mut world = world();
    let post = post(&mut world);
    let rod = rod(&mut world, post, DVec3::ZERO, 60_f64.to_radians());
    let limit = law(&mut world, [post, rod], Wants::Least(0.0, restitution));
    (world, rod, limit)
}

/// Angle and its rate of a rod that falls freely for a time: θ̈ = −(m g L/2) cos θ/I, by the classical Runge–Kutta method
/// in steps of 0.1 ms.
fn fallen(time: f64) -> [f64; 2] {
    let change = |[angle, speed]: [f64; 2]| [speed, -0.5 * G * angle.cos() / INERTIA];
    runge_kutta([60_f64.to_radians(), 0.0], time, (time * 1e4).ceil() as u32, change)
}

/// When it comes to level, s.
fn landing() -> f64 {
    let mut time = 0.5;
    for _ in 0..6 {
        let [angle, speed] = fallen(time);
        time -= angle / speed;
    }
    time
}

#[test]
fn a_rod_stops_at_its_limit_in_its_time_and_rests_there() {
    let (mut world, rod, limit) = stop(0.0);
    let time = landing();
    let h = 1.0 / world.resource::<SolverSettings>().hz;
    let before = (time / h).floor();
    steps(&mut world, before as u32);
    assert_close(angle(&world, rod), fallen(before * h)[0], 1e-10);
    let mut overshoot: f64 = 0.0;
    for count in 0..240 {
        step(&mut world);
        settled(&world);
        overshoot = overshoot.max(-angle(&world, rod));
        let torque = world.get::<JointLoad>(limit).unwrap().torque.z;
        if count == 0 {
            // The momentum that it stopped, then the weight's torque, over the step.
            let stopped = -fallen(time)[1] * INERTIA;
            let rested = (torque * h - stopped) / (0.5 * G);
            assert_close((before + 1.0) * h - rested, time, 1e-9);
        } else {
            assert_close(torque, 0.5 * G, 1e-9);
            assert!(spin(&world, rod).length() < 1e-12);
        }
        assert_eq!(world.resource::<StepStats>().cuts, u32::from(count == 0));
    }
    println!("overshot by {overshoot:.1e} rad");
    assert!(overshoot <= 1e-10, "{overshoot} rad");
    assert!(angle(&world, rod).abs() < 1e-12);
}

#[test]
fn a_limit_without_loss_gives_all_back_at_its_time() {
    let (mut world, rod, _) = stop(1.0);
    let time = landing();
    let h = 1.0 / world.resource::<SolverSettings>().hz;
    let count = (time / h).ceil();
    steps(&mut world, count as u32);
    let mirrored = fallen(2.0 * time - count * h)[0];
    // Twice the error of the time, times the speed of 5 rad/s.
    assert_close(angle(&world, rod), mirrored, 1e-9);
    let energy = |world: &World| 0.5 * INERTIA * spin(world, rod).z.powi(2) + 0.5 * G * angle(world, rod).sin();
    let start = 0.5 * G * 60_f64.to_radians().sin();
    let (mut stops, mut worst, mut lowest, mut falls) = (0, 0.0_f64, 0.0_f64, true);
    while stops < 100 {
        step(&mut world);
        settled(&world);
        let rises = spin(&world, rod).z > 0.0;
        stops += u32::from(falls && rises);
        falls = !rises;
        worst = worst.max((energy(&world) / start - 1.0).abs());
        lowest = lowest.min(angle(&world, rod));
    }
    println!("energy off by {worst:.1e}, lowest at {lowest:.1e} rad, {:?}", spin(&world, rod));
    assert!(worst < 1e-9, "{worst}");
    assert!(lowest > -1e-10, "{lowest} rad");
}

#[test]
fn a_limit_of_some_restitution_comes_to_rest() {
    let (mut world, rod, limit) = stop(0.5);
    let time = landing();
    let h = 1.0 / world.resource::<SolverSettings>().hz;
    steps(&mut world, (time / h).ceil() as u32);
    // Up again with half the speed, in what is left of the step.
    let left = (time / h).ceil() * h - time;
    let parted = -0.5 * fallen(time)[1];
    let gained = -0.5 * G / INERTIA * left;
    assert_close(spin(&world, rod).z, parted + gained, 1e-6);
    for _ in 0..720 {
        step(&mut world);
        settled(&world);
        assert!(angle(&world, rod) > -1e-10);
    }
    assert!(angle(&world, rod).abs() < 1e-11 && spin(&world, rod).length() < 1e-11);
    assert_close(world.get::<JointLoad>(limit).unwrap().torque.z, 0.5 * G, 1e-9);
}

/// A limit that is left by a push in the other direction lets go.
#[test]
fn a_limit_only_pushes() {
    let (mut world, rod, limit) = stop(0.0);
    run(&mut world, 1.0);
    world.get_mut::<Velocity>(rod).unwrap().angular.z = 1.0;
    world.get_mut::<Velocity>(rod).unwrap().linear.y = 0.5;
    step(&mut world);
    settled(&world);
    assert!(world.get::<JointLoad>(limit).unwrap().torque.length() < 1e-12);
    assert!(angle(&world, rod) > 1e-3);
    run(&mut world, 1.0);
    world.insert_resource(Gravity(DVec3::Y * G));
    step(&mut world);
    settled(&world);
    let h = 1.0 / world.resource::<SolverSettings>().hz;
    assert_close(angle(&world, rod), 0.25 * G / INERTIA * h * h, 1e-9);
}

/// Six rods end to end, each turned against the one before by 10° at most.
#[test]
fn limits_in_a_chain_hold_where_it_comes_to_rest() {
    let mut world = world();
    let mut on = post(&mut world);
    let most = 10_f64.to_radians();
    let mut rods = Vec::new();
    for index in 0..6 {
        let next = rod(&mut world, on, DVec3::X * f64::from(index), 0.0);
        law(&mut world, [on, next], Wants::Least(-most, 0.0));
        law(&mut world, [on, next], Wants::Most(most, 0.0));
        rods.push((on, next));
        on = next;
    }
    let mut worst: f64 = 0.0;
    for _ in 0..720 {
        step(&mut world);
        settled(&world);
        for &(a, b) in &rods {
            let turned = angle(&world, b) - angle(&world, a);
            worst = worst.max(turned.abs() - most);
        }
    }
    println!("overshot by {worst:.1e} rad");
    assert!(worst < 1e-8, "{worst} rad");
    // All hang down from the post as far as they may.
    for &(a, b) in &rods {
        assert_close(angle(&world, b) - angle(&world, a), -most, 1e-10);
        assert!(spin(&world, b).length() < 1e-10);
    }
}

/// A box on a rail along x, under gravity that pulls along it.
fn slider(pull: f64) -> (World, Entity, Entity) {
    let mut world = world();
    world.insert_resource(Gravity(DVec3::new(pull, -5.0, 0.0)));
    let post = post(&mut world);
    let slider = body(&mut world, Collider::cuboid(0.5, 0.5, 0.5), DVec3::X);
    world.entity_mut(slider).insert(Mass(2.0));
    world.spawn(OnRail([post, slider]));
    (world, post, slider)
}

#[test]
fn a_slider_sticks_below_its_friction_and_slides_above() {
    for (friction, acceleration) in [(6.1, 0.0), (4.0, 1.0)] {
        let (mut world, post, slider) = slider(3.0);
        let own = Law { bodies: [post, slider], slides: true, wants: Wants::Speed(0.0, friction) };
        let own = world.spawn((own, JointLoad::default())).id();
        for count in 1..=480 {
            step(&mut world);
            settled(&world);
            let time = f64::from(count) / 240.0;
            assert_close(position(&world, slider).x, 1.0 + 0.5 * acceleration * time * time, 1e-10);
            let load = world.get::<JointLoad>(own).unwrap().force.x;
            assert_close(load, -f64::min(friction, 6.0), 1e-9);
            assert_eq!(world.resource::<StepStats>().cuts, 0);
        }
    }
}

#[test]
fn friction_stops_a_thrown_slider_at_its_time() {
    let (mut world, post, slider) = slider(0.0);
    world.spawn(Law { bodies: [post, slider], slides: true, wants: Wants::Speed(0.0, 3.0) });
    let thrown = 1.234;
    world.get_mut::<Velocity>(slider).unwrap().linear.x = thrown;
    let mut cuts = 0;
    for _ in 0..480 {
        step(&mut world);
        settled(&world);
        cuts += world.resource::<StepStats>().cuts;
    }
    // v²/2a, with a = f/m = 1.5 m/s².
    assert_close(position(&world, slider).x, 1.0 + thrown * thrown / 3.0, 1e-11);
    assert!(velocity(&world, slider).length() < 1e-12);
    assert_eq!(cuts, 1);
}

#[test]
fn a_swing_with_friction_comes_to_rest_out_of_its_lowest_place() {
    let mut world = world();
    let post = post(&mut world);
    let rod = rod(&mut world, post, DVec3::ZERO, 0.0);
    let friction = law(&mut world, [post, rod], Wants::Speed(0.0, 0.8));
    let mut cuts = 0;
    for _ in 0..1920 {
        step(&mut world);
        settled(&world);
        cuts += world.resource::<StepStats>().cuts;
    }
    let rests = angle(&world, rod);
    assert!(spin(&world, rod).length() < 1e-12);
    let torque = world.get::<JointLoad>(friction).unwrap().torque.z;
    assert_close(torque, 0.5 * G * rests.cos(), 1e-9);
    println!("{cuts} events, rests at {rests} with {torque} N·m");
    assert!(torque.abs() < 0.8 && torque.abs() > 1e-3 && cuts < 20, "{torque} N·m, {cuts} events");
}

#[test]
fn a_motor_lags_at_its_largest_torque_and_then_holds_its_speed() {
    let mut world = world();
    world.insert_resource(Gravity(DVec3::ZERO));
    let post = post(&mut world);
    let rod = rod(&mut world, post, DVec3::ZERO, 0.0);
    let motor = law(&mut world, [post, rod], Wants::Speed(2.0, 0.5));
    // 2 rad/s after I ω/τ.
    let reached = 2.0 * INERTIA / 0.5;
    let mut cuts = 0;
    for count in 1..=720 {
        step(&mut world);
        settled(&world);
        cuts += world.resource::<StepStats>().cuts;
        let time = f64::from(count) / 240.0;
        let expected = f64::min(time / reached, 1.0) * 2.0;
        assert_close(spin(&world, rod).z, expected, 1e-9);
        let torque = world.get::<JointLoad>(motor).unwrap().torque.z;
        if time < reached {
            assert_close(torque, 0.5, 1e-9);
        } else if time > reached + 0.01 {
            assert!(torque.abs() < 1e-9, "{torque}");
        }
    }
    assert_eq!(cuts, 1);
}

#[test]
fn a_motor_that_lagged_comes_back_to_its_place() {
    let (mut world, post, slider) = slider(0.0);
    world.get_mut::<Position>(slider).unwrap().0.x = 0.0;
    // From rest it takes 2 s to get to the speed, and is 1 m behind then.
    world.spawn(Law { bodies: [post, slider], slides: true, wants: Wants::Place(1.0, 1.0) });
    run(&mut world, 2.0);
    settled(&world);
    assert_close(position(&world, slider).x, 1.0, 1e-9);
    run(&mut world, 14.0);
    settled(&world);
    // It swings about its place less and less, and then comes closer with its time constant.
    println!("{:.1e} m off", position(&world, slider).x - 16.0);
    assert_close(position(&world, slider).x, 16.0, 1e-6);
}

/// Two rods on the ground that are so far up from level, rad, and a bar on ball joints that joins their ends.
fn parallelogram(world: &mut World, post: Entity, up: f64) -> [Entity; 2] {
    let rods = [0.0, 1.0].map(|x| rod(world, post, DVec3::X * x, up));
    let end =
        |world: &World, rod: Entity| position(world, rod) + world.get::<Rotation>(rod).unwrap().0 * DVec3::X * 0.5;
    let middle = (end(world, rods[0]) + end(world, rods[1])) / 2.0;
    let bar = body(world, Collider::cuboid(1.0, 0.1, 0.1), middle);
    world.entity_mut(bar).insert(Mass(1.0));
    for (rod, side) in rods.into_iter().zip([-0.5, 0.5]) {
        world.spawn(BallJoint::new(rod, bar).with_anchors(DVec3::X * 0.5, DVec3::X * side));
    }
    for body in [rods[0], rods[1], bar] {
        world.entity_mut(body).insert(CollisionLayers::NONE);
    }
    rods
}

/// Two upright rods whose tops a level one joins fall over sideways together, until one of them comes to its limit.
#[test]
fn a_limit_that_closes_inside_a_loop_bears_the_loop() {
    let mut world = world();
    let post = post(&mut world);
    let upright = std::f64::consts::FRAC_PI_2;
    let least = 0.7;
    let rods = parallelogram(&mut world, post, upright - 0.1);
    let limit = law(&mut world, [post, rods[0]], Wants::Least(least, 0.0));
    let mut overshoot: f64 = 0.0;
    for _ in 0..480 {
        step(&mut world);
        settled(&world);
        overshoot = overshoot.max(least - angle(&world, rods[0]));
    }
    let torque = world.get::<JointLoad>(limit).unwrap().torque.z;
    println!("overshot by {overshoot:.1e} rad, {torque} N·m");
    assert!(overshoot < 1e-8, "{overshoot} rad");
    // By virtual work: half a rod's weight twice, and the bar's.
    assert_close(torque, 2.0 * G * least.cos(), 1e-6);
}

/// Two rods and a bar of one length fall until they lie on each other but for 3e-4 rad, near the singular pose of that
/// loop, where a limit stops one of them.
#[test]
fn a_limit_beside_a_loop_that_is_nearly_flat_takes_few_events() {
    let mut world = world();
    let post = post(&mut world);
    let least = 3e-4;
    let rods = parallelogram(&mut world, post, 0.1);
    law(&mut world, [post, rods[0]], Wants::Least(least, 0.0));
    let (mut cuts, mut overshoot) = (0, 0.0_f64);
    for _ in 0..120 {
        step(&mut world);
        settled(&world);
        overshoot = overshoot.max(least - angle(&world, rods[0]));
        cuts += world.resource::<StepStats>().cuts;
    }
    println!("{cuts} cuts, overshot by {overshoot:.1e} rad, rests at {:.3e} rad", angle(&world, rods[0]));
    assert!(cuts < 4 && overshoot < 1e-10, "{cuts} cuts, overshot by {overshoot} rad");
}

#[test]
fn rattle_stops_at_a_limit_too() {
    let (mut world, rod, limit) = stop(0.0);
    let exact = ExactSettings { integrator: ExactIntegrator::Rattle, time_budget: None };
    world.insert_resource(SolverSettings { exact, ..*world.resource::<SolverSettings>() });
    let post = world.get::<Law>(limit).unwrap().bodies[0];
    law(&mut world, [post, rod], Wants::Speed(0.0, 0.5));
    let mut overshoot: f64 = 0.0;
    for _ in 0..480 {
        step(&mut world);
        settled(&world);
        overshoot = overshoot.max(-angle(&world, rod));
    }
    assert!(overshoot < 1e-10 && angle(&world, rod).abs() < 1e-11, "{overshoot} rad");
    let torque = world.get::<JointLoad>(limit).unwrap().torque.z;
    assert!(torque > 0.5 * G - 0.5 - 1e-9 && torque < 0.5 * G + 0.5 + 1e-9, "{torque}");
}

/// A limit thrice, and one against them: loads are not unique.
#[test]
fn limits_that_share_a_load_stay_finite() {
    let mut world = world();
    let post = post(&mut world);
    let rod = rod(&mut world, post, DVec3::ZERO, 0.5);
    let limits: Vec<Entity> = (0..3).map(|_| law(&mut world, [post, rod], Wants::Least(0.0, 0.0))).collect();
    law(&mut world, [post, rod], Wants::Most(0.0, 0.0));
    run(&mut world, 1.0);
    settled(&world);
    let loads = limits.iter().map(|&limit| world.get::<JointLoad>(limit).unwrap().torque.z);
    let sum: f64 = loads.clone().sum();
    println!("{:?}", loads.collect::<Vec<_>>());
    assert_close(sum, 0.5 * G, 1e-6);
    assert!(angle(&world, rod).abs() < 1e-8);
}

/// A rod rests on its limit, and a box of 1 kg on the rod, which falls onto it from a little above.
#[test]
fn a_limit_bears_what_lies_on_its_rod() {
    for drop in [0.0, 0.05] {
        let mut world = world();
        let post = post(&mut world);
        let rod = rod(&mut world, post, DVec3::ZERO, 0.0);
        let limit = law(&mut world, [post, rod], Wants::Least(0.0, 0.0));
        let load = body(&mut world, Collider::cuboid(0.2, 0.2, 0.2), DVec3::new(0.75, 0.15 + drop, 0.0));
        world.entity_mut(load).insert(Mass(1.0));
        let mut overshoot: f64 = 0.0;
        for _ in 0..240 {
            step(&mut world);
            settled(&world);
            overshoot = overshoot.max(-angle(&world, rod));
        }
        let torque = world.get::<JointLoad>(limit).unwrap().torque.z;
        println!("overshot by {overshoot:.1e} rad, {torque} N·m");
        // The cone solver's residual of 1e-10 m/s over a step.
        assert_close(torque, 1.25 * G, 1e-6);
        assert!(overshoot < 1e-8 && angle(&world, rod).abs() < 1e-8, "{overshoot} rad");
        assert_close(position(&world, load).y, 0.15, 1e-8);
    }
}

/// A rod falls onto its limit a hair above a table that it never touches: they are in reach of each other.
fn stop_over_a_table(restitution: f64) -> (World, Entity, Entity) {
    let (mut world, rod, limit) = stop(restitution);
    let table = (RigidBody::Static, Collider::cuboid(0.4, 0.2, 1.0), Position(DVec3::new(0.8, -0.151, 0.0)));
    world.spawn(table);
    (world, rod, limit)
}

#[test]
fn a_limit_stops_and_gives_back_with_something_in_reach() {
    for restitution in [0.0, 0.5, 1.0] {
        let (mut world, rod, limit) = stop_over_a_table(restitution);
        let (time, h) = (landing(), 1.0 / world.resource::<SolverSettings>().hz);
        let mut lowest: f64 = 0.0;
        let count = (time / h).ceil();
        for _ in 0..count as u32 {
            step(&mut world);
            settled(&world);
            lowest = lowest.min(angle(&world, rod));
        }
        assert!(world.resource::<StepStats>().manifolds > 0);
        let left = count * h - time;
        let parted = -restitution * fallen(time)[1];
        let expected = if restitution > 0.0 { parted - 0.5 * G / INERTIA * left } else { 0.0 };
        println!("e = {restitution}: {} rad/s, lowest {lowest:.1e} rad", spin(&world, rod).z);
        // Of second order, as steps near contacts are.
        assert_close(spin(&world, rod).z, expected, 1e-3);
        assert!(lowest > -1e-8, "{lowest} rad");
        if restitution == 0.0 {
            run(&mut world, 0.5);
            assert_close(world.get::<JointLoad>(limit).unwrap().torque.z, 0.5 * G, 1e-6);
        }
    }
}

/// A box on the ground, which is without friction, held by a row that has some.
#[test]
fn dry_friction_of_a_joint_holds_beside_contacts() {
    for (friction, acceleration) in [(6.1, 0.0), (4.0, 1.0)] {
        let mut world = world();
        world.insert_resource(Gravity(DVec3::new(3.0, -5.0, 0.0)));
        let floor = ground(&mut world);
        let slick = SurfaceMaterial { friction: 0.0, ..default() };
        world.entity_mut(floor).insert(slick);
        let slider = body(&mut world, Collider::cuboid(0.5, 0.5, 0.5), DVec3::new(1.0, 0.25, 0.0));
        world.entity_mut(slider).insert((Mass(2.0), slick));
        let own = Law { bodies: [floor, slider], slides: true, wants: Wants::Speed(0.0, friction) };
        let own = world.spawn((own, JointLoad::default())).id();
        for count in 1..=240 {
            step(&mut world);
            settled(&world);
            let time = f64::from(count) / 240.0;
            assert_close(position(&world, slider).x, 1.0 + 0.5 * acceleration * time * time, 1e-8);
            let load = world.get::<JointLoad>(own).unwrap().force.x;
            assert_close(load, -f64::min(friction, 6.0), 1e-6);
        }
        assert!(world.resource::<StepStats>().manifolds > 0);
    }
}

/// Two limits and a motor with a largest torque on a rod that a box lies against.
#[test]
fn a_motor_presses_a_box_against_a_wall_with_its_largest_torque() {
    let mut world = world();
    world.insert_resource(Gravity(DVec3::ZERO));
    let post = post(&mut world);
    let rod = rod(&mut world, post, DVec3::ZERO, 0.0);
    let motor = law(&mut world, [post, rod], Wants::Speed(-1.0, 2.0));
    let wall = (RigidBody::Static, Collider::cuboid(1.0, 0.2, 1.0), Position(DVec3::new(0.8, -0.4, 0.0)));
    world.spawn((wall, Rotation::default()));
    run(&mut world, 2.0);
    settled(&world);
    assert!(spin(&world, rod).length() < 1e-9, "{:?}", spin(&world, rod));
    assert_close(world.get::<JointLoad>(motor).unwrap().torque.z, -2.0, 1e-9);
    assert!(angle(&world, rod) < -0.1);
}
