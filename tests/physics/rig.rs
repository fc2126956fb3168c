//! What the tests share: worlds, bodies, reading the state.

// The unit tests of the library have it, too.
#[path = "../../src/physics/testing/runge_kutta.rs"]
mod runge_kutta;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use plumb::physics::{Diagnostics, Shape, TriangleMesh, hash_state};
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub use runge_kutta::runge_kutta;

/// The default preset without sleep.
pub fn awake_game() -> SolverSettings {
    let mut game = SolverSettings::game();
    game.impulse.sleep_speed = None;
    game
}

/// The same with full effort for what rests, if so asked.
pub fn with_effort(mut settings: SolverSettings, fitted_effort: bool) -> SolverSettings {
    settings.impulse.fitted_effort = fitted_effort;
    settings
}

/// Every preset, by name.
pub fn presets() -> [(&'static str, SolverSettings); 4] {
    [
        ("game", SolverSettings::game()),
        ("steady", SolverSettings::steady()),
        ("classic", SolverSettings::classic()),
        ("accurate", SolverSettings::accurate()),
    ]
}

/// Starts a compute pool of four threads on any machine. The first pool of a process stays, so
/// every test that makes an app of its own calls this before.
pub fn start_pool() {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
}

/// A headless world with these settings.
pub fn world_with(settings: SolverSettings) -> World {
    start_pool();
    let mut world = std::mem::take(headless_app().world_mut());
    world.insert_resource(settings);
    world
}

/// A world without gravity.
pub fn weightless(settings: SolverSettings) -> World {
    let mut world = world_with(settings);
    world.insert_resource(Gravity(DVec3::ZERO));
    world
}

/// The ground: y ≤ 0.
pub fn ground(world: &mut World) -> Entity {
    world.spawn((RigidBody::Static, Collider::half_space(), Transform::default())).id()
}

/// A flat mesh of so many squares along each side.
pub fn flat(size: f64, squares: u32) -> Collider {
    Collider::mesh(TriangleMesh::height_field([size; 2], [squares; 2], |_, _| 0.0).expect("a field"))
}

/// A dynamic body of that shape there.
pub fn body(world: &mut World, collider: Collider, position: DVec3) -> Entity {
    world.spawn((RigidBody::Dynamic, collider, Position(position))).id()
}

/// Acceleration of gravity of new worlds, m/s².
pub const G: f64 = 9.81;

/// Level ground under gravity turned by an angle, so that it slopes down along x, and a box at rest on it.
pub fn incline(settings: SolverSettings, degrees: f64) -> (World, Entity) {
    let mut world = world_with(settings);
    let (sin, cos) = degrees.to_radians().sin_cos();
    world.insert_resource(Gravity(DVec3::new(sin, -cos, 0.0) * G));
    ground(&mut world);
    let slider = body(&mut world, Collider::cuboid(2.0, 0.5, 1.0), DVec3::Y * 0.25);
    (world, slider)
}

pub fn steps(world: &mut World, count: u32) {
    for _ in 0..count {
        step(world);
    }
}

/// As many steps as fit in that time, s.
pub fn run(world: &mut World, seconds: f64) {
    let hz = world.resource::<SolverSettings>().hz;
    steps(world, (seconds * hz).round() as u32);
}

pub fn position(world: &World, body: Entity) -> DVec3 {
    world.get::<Position>(body).unwrap().0
}

pub fn velocity(world: &World, body: Entity) -> DVec3 {
    world.get::<Velocity>(body).unwrap().linear
}

pub fn spin(world: &World, body: Entity) -> DVec3 {
    world.get::<Velocity>(body).unwrap().angular
}

/// Kinetic and potential, of a world with [`Diagnostics`], J.
pub fn energy(world: &World) -> f64 {
    let told = world.resource::<Diagnostics>();
    told.kinetic_energy + told.potential_energy
}

/// So many steps in none of which the energy is more than ever before by more than `gain` says of that, J.
#[track_caller]
pub fn assert_gains_nothing(world: &mut World, count: u32, name: &str, gain: impl Fn(f64) -> f64) {
    let mut most = energy(world);
    for index in 0..count {
        step(world);
        let now = energy(world);
        assert!(now <= most + gain(most), "{name}, step {index}: {most} J grow to {now} J");
        most = most.min(now);
    }
}

/// A hundred shots at 400 m/s at a sheet of 1 cm.
#[track_caller]
pub fn assert_none_passes_a_sheet(collider: &Collider, seed: u64) {
    let mut dice = Pcg64Mcg::seed_from_u64(seed);
    for case in 0..100 {
        let mut world = weightless(SolverSettings::game());
        world.spawn((RigidBody::Static, Collider::cuboid(0.01, 6.0, 6.0)));
        let start = DVec3::new(-dice.random_range(2.0..8.0), dice.random_range(-1.0..1.0), 0.0);
        let own = body(&mut world, collider.clone(), start);
        let turned = DQuat::from_rotation_z(dice.random_range(-3.0..3.0));
        let velocity = Velocity { linear: DVec3::X * 400.0, angular: DVec3::Z * dice.random_range(-20.0..20.0) };
        world.entity_mut(own).insert((Rotation(turned), velocity));
        for _ in 0..6 {
            step(&mut world);
            assert!(position(&world, own).x < 0.05, "case {case}");
        }
    }
}

/// Takes all messages of a kind that are in the buffers.
pub fn take<M: Message>(world: &mut World) -> Vec<M> {
    world.resource_mut::<Messages<M>>().drain().collect()
}

/// A hash of every bit that the next step depends on.
pub fn state_hash(world: &World) -> u64 {
    use std::hash::{DefaultHasher, Hasher};
    let mut hasher = DefaultHasher::new();
    hash_state(world, &mut hasher);
    hasher.finish()
}

/// The lowest point of a body above y = 0.
pub fn clearance(world: &World, body: Entity) -> f64 {
    let rotation = world.get::<Rotation>(body).unwrap().0;
    let up = rotation.inverse() * DVec3::Y;
    let reach = match world.get::<Collider>(body).unwrap().shape() {
        Shape::Sphere { radius } => *radius,
        Shape::Cuboid { size } => (up * *size / 2.0).abs().element_sum(),
        Shape::Cone { radius, height } => {
            f64::max(-0.75 * height * up.y, 0.25 * height * up.y + radius * up.x.hypot(up.z))
        }
        Shape::Cylinder { radius, height } => 0.5 * height * up.y.abs() + radius * up.x.hypot(up.z),
        Shape::Capsule { radius, length } => radius + 0.5 * length * up.y.abs(),
        Shape::Hull(hull) => hull.vertices().map(|vertex| -up.dot(vertex)).fold(f64::NEG_INFINITY, f64::max),
        Shape::Compound(_) | Shape::Mesh(_) => unreachable!("none is asked how high it is"),
        Shape::HalfSpace => unreachable!("a half-space does not move"),
    };
    position(world, body).y - reach
}

#[track_caller]
pub fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}, more than {tolerance} off");
}

#[track_caller]
pub fn assert_near(value: DVec3, expected: DVec3, tolerance: f64) {
    assert!((value - expected).length() <= tolerance, "{value} instead of {expected}, more than {tolerance} off");
}
