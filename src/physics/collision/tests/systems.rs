use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use nalgebra::{UnitQuaternion, Vector3};

use super::hulls::{hull_body, random_hull};
use super::{KINDS, body, touch, upright};
use crate::physics::body::{Bodies, Body, CollisionLayers, RigidBody, SurfaceMaterial};
use crate::physics::collision::broad::in_step::InStep;
use crate::physics::collision::broad::near_pairs::{self, NearPairs};
use crate::physics::collision::broad::persistent_pairs::{BoundedBodies, Bounds};
use crate::physics::collision::classic::sweep_and_sort::{self, SweptPairs};
use crate::physics::collision::gap::contact_gap;
use crate::physics::collision::manifold::{ContactPoint, Contacts, Pair};
use crate::physics::collision::narrow_phase;
use crate::physics::collision::slots::graph::{ContactGraph, update_graph};
use crate::physics::joint::{JoinedPairs, Joints};
use crate::physics::settings::SolverSettings;
use crate::physics::shape::Collider;
use crate::physics::stats::StepStats;
use crate::physics::testing::Random;

fn world(list: Vec<Body>, settings: SolverSettings) -> World {
    let mut world = World::new();
    world.insert_resource(Bodies::of(list));
    world.insert_resource(settings);
    world.init_resource::<JoinedPairs>();
    world.init_resource::<Joints>();
    world.init_resource::<SweptPairs>();
    world.init_resource::<NearPairs>();
    world.init_resource::<ContactGraph>();
    world.init_resource::<Contacts>();
    world.init_resource::<StepStats>();
    world
}

fn find(world: &mut World) -> Contacts {
    world.run_system_once(sweep_and_sort::sweep).unwrap();
    world.run_system_once(near_pairs::update_pairs).unwrap();
    world.run_system_once(narrow_phase::find_contacts).unwrap();
    world.resource_mut::<StepStats>().steps += 1;
    world.resource::<Contacts>().clone()
}

/// A heap of bodies of all shapes, of several blocks of buckets and pairs.
fn heap() -> Vec<Body> {
    let mut random = Random::new(21);
    let ground = Body { kind: RigidBody::Static, ..upright(&Collider::half_space(), [0.0, -8.0, 0.0]) };
    let shapes = (0..1200).map(|index| {
        let collider = KINDS[index % 3](&mut random);
        body(&collider, random.vector() * 8.0, random.rotation())
    });
    [ground].into_iter().chain(shapes).collect()
}

#[test]
fn contacts_are_the_same_to_the_last_bit_for_any_number_of_threads() {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    for preset in [SolverSettings::classic(), SolverSettings::steady()] {
        let run = |threads| find(&mut world(heap(), SolverSettings { threads, ..preset }));
        let one = run(1);
        assert!(one.manifolds.len() > 3000 && one.points.len() > one.manifolds.len());
        for threads in [2, 4] {
            let many = run(threads);
            assert_eq!(one.manifolds, many.manifolds, "{threads} threads");
            assert_eq!(one.points, many.points, "{threads} threads");
        }
    }
}

#[test]
fn manifolds_are_in_pair_order_with_runs_of_points_and_the_material_of_the_pair() {
    let mut bodies = heap();
    for (index, body) in bodies.iter_mut().enumerate() {
        body.material = SurfaceMaterial { friction: 0.1 * (index % 7) as f64, restitution: 0.1 * (index % 5) as f64 };
    }
    let materials: Vec<_> = bodies.iter().map(|body| body.material).collect();
    let mut world = world(bodies, SolverSettings::steady());
    world.resource_mut::<StepStats>().time = 1.5;
    let contacts = find(&mut world);
    assert_eq!(contacts.time, 1.5);
    let mut pairs = world.resource::<SweptPairs>().0.iter();
    let mut next_point = 0;
    for manifold in &contacts.manifolds {
        assert!(pairs.any(|pair| *pair == manifold.pair), "not as the sweep finds them");
        assert_eq!(world.resource::<ContactGraph>().slots[manifold.slot.unwrap() as usize].pair, manifold.pair);
        assert_eq!(manifold.first_point, next_point);
        assert!(manifold.point_count > 0);
        next_point += manifold.point_count;
        let pair = materials[manifold.pair.a as usize].pair(materials[manifold.pair.b as usize]);
        assert_eq!((manifold.friction, manifold.restitution), (pair.friction, pair.restitution));
    }
    assert_eq!(next_point as usize, contacts.points.len());
    let stats = world.resource::<StepStats>();
    let counts = [world.resource::<ContactGraph>().active().count(), contacts.manifolds.len(), contacts.points.len()];
    assert_eq!([stats.pairs, stats.manifolds, stats.contact_points].map(|count| count as usize), counts);
}

fn count_step(mut stats: ResMut<StepStats>) {
    stats.steps += 1;
}

/// A schedule whose systems remember the step before.
fn schedule() -> Schedule {
    let mut schedule = Schedule::default();
    let find = (sweep_and_sort::sweep, near_pairs::update_pairs, narrow_phase::find_contacts);
    schedule.add_systems((find, count_step).chain());
    schedule.set_executor(bevy::ecs::schedule::SingleThreadedExecutor::new());
    schedule
}

#[test]
fn steps_after_the_first_allocate_nothing() {
    for preset in [SolverSettings::classic(), SolverSettings::steady()] {
        let mut world = world(heap(), preset);
        let mut schedule = schedule();
        for _ in 0..2 {
            schedule.run(&mut world);
        }
        let used = allocation_counter::measure(|| schedule.run(&mut world));
        assert_eq!(used.count_total, 0, "{used:?}");
    }
}

/// A heap whose bodies all tumble, some through others.
fn tumbling_heap() -> (Vec<Body>, Vec<Vector3<f64>>) {
    let mut random = Random::new(22);
    let hulls = (0..300).map(|_| {
        let at = random.vector() * 7.0;
        let turn = random.rotation();
        hull_body(random_hull(&mut random), at, turn)
    });
    let bodies: Vec<_> = heap().into_iter().take(300).chain(hulls).collect();
    let spins = bodies.iter().map(|_| random.vector() * 0.02).collect();
    (bodies, spins)
}

fn tumble(bodies: &mut [Body], spins: &[Vector3<f64>]) {
    for (body, spin) in bodies.iter_mut().zip(spins) {
        body.position += spin.yzx() * 0.3;
        body.rotation = UnitQuaternion::from_scaled_axis(*spin) * body.rotation;
    }
}

#[test]
fn last_axes_change_no_bit_and_save_work() {
    let (bodies, spins) = tumbling_heap();
    let mut world = world(bodies, SolverSettings::steady());
    let (mut with, mut without, mut changes) = (0, 0, 0);
    for step in 0..40 {
        let remembered = find(&mut world);
        let tested = world.resource::<StepStats>().axes_tested;
        world.insert_resource(NearPairs::default());
        world.insert_resource(ContactGraph::default());
        let forgetful = find(&mut world);
        if step > 0 {
            with += tested;
            without += world.resource::<StepStats>().axes_tested;
        }
        assert_eq!(poses_of(&remembered), poses_of(&forgetful), "step {step}");
        assert_eq!(remembered.points, forgetful.points, "step {step}");
        changes += forgetful.manifolds.len();
        tumble(&mut world.resource_mut::<Bodies>().list, &spins);
    }
    assert!(changes > 1_000, "{changes} contacts are too few to prove it");
    assert!(with < without, "{with} axes against {without}");
}

fn poses_of(contacts: &Contacts) -> Vec<(Pair, Vector3<f64>)> {
    contacts.manifolds.iter().map(|manifold| (manifold.pair, manifold.normal)).collect()
}

/// Bodies fly and turn through each other and onto the ground, which comes up, under forces.
#[test]
fn slots_have_every_pair_within_its_gap() {
    for preset in [SolverSettings::steady(), SolverSettings::accurate()] {
        let (mut bodies, spins) = tumbling_heap();
        bodies[0] = Body { kind: RigidBody::Kinematic, linear: Vector3::y(), ..bodies[0].clone() };
        for (body, spin) in bodies.iter_mut().zip(&spins).skip(1) {
            body.linear = spin.yzx() * (0.3 * preset.hz);
            body.angular = spin * (20.0 * preset.hz);
            (body.force, body.inverse_mass) = (spin.zxy() * 1e4, Vector3::repeat(1.0));
        }
        let mut world = world(bodies, preset);
        let mut ahead = 0;
        for step in 0..30 {
            let found = find(&mut world);
            let bodies = &world.resource::<Bodies>().list;
            let pairs = (0..bodies.len() as u32).flat_map(|a| (a + 1..bodies.len() as u32).map(move |b| Pair { a, b }));
            let mut expected: Vec<Pair> = pairs
                .filter(|pair| {
                    let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
                    let gap = contact_gap(a, b, &preset);
                    (b.position - a.position).norm() <= a.radius + b.radius + gap && touch(a, b, &preset).is_some()
                })
                .collect();
            let mut pairs: Vec<Pair> = found.manifolds.iter().map(|manifold| manifold.pair).collect();
            expected.sort_unstable();
            pairs.sort_unstable();
            assert_eq!(pairs, expected, "step {step}");
            let is_ahead = |points: &[ContactPoint]| points.iter().all(|point| point.depth < 0.0);
            ahead += found.manifolds.iter().filter(|manifold| is_ahead(found.points_of(manifold))).count();
            tumble(&mut world.resource_mut::<Bodies>().list, &spins);
        }
        assert!(ahead > 100, "{ahead} contacts are of what is apart");
    }
}

#[test]
fn pairs_apart_by_last_steps_axis_cost_one() {
    let at = |x: f64| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.2, 0.1));
        hull_body(random_hull(&mut Random::new(23)), Vector3::new(x, 0.0, 0.0), turn)
    };
    let (a, mut b) = (at(0.0), at(0.0));
    // Near enough for the spheres to overlap, and apart.
    b.position.x = (0..100)
        .map(|share| a.radius * 2.0 * f64::from(share) / 100.0)
        .find(|&x| touch(&a, &Body { position: Vector3::x() * x, ..b.clone() }, &SolverSettings::steady()).is_none())
        .expect("a hull is not a ball");
    let mut world = world(vec![a, b], SolverSettings::steady());
    let mut schedule = schedule();
    schedule.run(&mut world);
    assert!(world.resource::<StepStats>().axes_tested >= 1);
    schedule.run(&mut world);
    assert_eq!((world.resource::<StepStats>().axes_tested, world.resource::<StepStats>().pairs), (1, 1));
    assert!(world.resource::<Contacts>().manifolds.is_empty());
}

#[test]
fn pairs_apart_are_looked_at_again_when_they_can_be_near() {
    let settings = SolverSettings::game();
    let mut random = Random::new(24);
    let (mut looked_at, mut steps) = (0, 0);
    for round in 0..60 {
        let mut shape = |at| match KINDS.get(round % 4) {
            Some(kind) => body(&kind(&mut random), at, random.rotation()),
            None => hull_body(random_hull(&mut random), at, random.rotation()),
        };
        let (a, mut b) = (shape(Vector3::zeros()), shape(Vector3::zeros()));
        let slide = Vector3::new(0.01, 0.002, -0.001) * a.radius.min(b.radius);
        b.position = slide * (-1.2 * (a.radius + b.radius) / slide.norm());
        // What moves them is not what they know of, as where a body is moved by hand.
        let mut world = world(vec![a, b], settings);
        let mut schedule = Schedule::default();
        schedule.add_systems((near_pairs::update_pairs, update_graph, count_step).chain());
        for step in 0..400 {
            schedule.run(&mut world);
            let bodies = &mut world.resource_mut::<Bodies>().list;
            let is_near = touch(&bodies[0], &bodies[1], &settings).is_some();
            bodies[1].position += slide;
            assert_eq!(world.resource::<ContactGraph>().touching().count(), usize::from(is_near), "{round}, {step}");
            if is_near {
                break;
            }
            // Of shapes with faces and edges alone, tests are counted by their axes.
            if round % 2 == 1 {
                looked_at += u32::from(world.resource::<StepStats>().axes_tested > 0);
                steps += world.resource::<StepStats>().pairs;
            }
        }
    }
    assert!(looked_at * 2 < steps, "looked at in {looked_at} of {steps} steps");
}

#[test]
fn bodies_without_shape_find_nothing() {
    let shapeless = Body { geometry: None, radius: 0.0, ..upright(&Collider::sphere(1.0), [0.0; 3]) };
    let contacts = find(&mut world(vec![shapeless; 10], SolverSettings::default()));
    assert!(contacts.manifolds.is_empty() && contacts.points.is_empty());
}

#[test]
fn bodies_of_no_layer_have_no_box() {
    let apart = Body { layers: CollisionLayers::NONE, ..upright(&Collider::sphere(1.0), [0.0; 3]) };
    let deaf = Body { layers: CollisionLayers { filters: 0, ..CollisionLayers::ALL }, ..apart.clone() };
    for (body, has_box) in [(apart, false), (deaf, false), (upright(&Collider::sphere(1.0), [0.0; 3]), true)] {
        let bodies = InStep { bodies: &[body], joined: &JoinedPairs::default(), h: 0.1, reach: None };
        assert_eq!(matches!(bodies.bounds(0), Bounds::Within(_)), has_box);
    }
}
