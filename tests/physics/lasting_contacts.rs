//! Contacts that last from step to step are those that a search from nothing finds, whatever is done
//! to the bodies in between.

use std::collections::BTreeSet;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::ContactForces;
use plumb::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::rig;

/// Bodies in a heap that cannot move: every step finds the same unless somebody changes something.
struct Heap {
    world: World,
    bodies: Vec<Entity>,
    joint: Option<Entity>,
}

impl Heap {
    fn new(settings: SolverSettings) -> Self {
        let mut world = rig::weightless(settings);
        world.init_resource::<ContactForces>();
        rig::ground(&mut world);
        let mut random = Pcg64Mcg::seed_from_u64(11);
        let mut place = |span: f64| DVec3::from_array(std::array::from_fn(|_| random.random_range(-span..span)));
        let bodies = (0..60)
            .map(|index| {
                let kind = if index % 5 == 0 { RigidBody::Static } else { RigidBody::Dynamic };
                let collider = match index % 3 {
                    0 => Collider::sphere(0.4),
                    1 => Collider::cuboid(0.6, 0.9, 0.3),
                    _ => Collider::cone(0.4, 0.8),
                };
                let position = Position(place(2.0) + DVec3::Y * 1.5);
                let rotation = Rotation(DQuat::from_scaled_axis(place(3.0)));
                let locked = LockedAxes { translation: [true; 3], rotation: [true; 3] };
                world.spawn((kind, collider, position, rotation, locked)).id()
            })
            .collect();
        Self { world, bodies, joint: None }
    }

    /// One of many edits, the same in every world.
    fn edit(&mut self, round: usize) {
        let (one, other) = (self.bodies[(7 * round + 1) % 59], self.bodies[(7 * round + 2) % 59]);
        let world = &mut self.world;
        match round {
            0 => {}
            1 => world.get_mut::<Position>(one).unwrap().0 += DVec3::new(0.3, -0.2, 0.1),
            2 => world.get_mut::<Transform>(one).unwrap().translation += Vec3::new(-0.5, 0.1, 0.4),
            3 => _ = world.entity_mut(one).insert(CollisionLayers::NONE),
            4 => _ = world.entity_mut(one).insert(Collider::sphere(0.9)),
            5 => _ = world.entity_mut(one).remove::<Collider>(),
            6 => self.joint = Some(world.spawn(BallJoint::new(self.bodies[1], self.bodies[2])).id()),
            7 => _ = world.despawn(self.joint.unwrap()),
            8 => {
                let gone: Vec<Entity> = self.bodies.drain(10..20).collect();
                gone.into_iter().for_each(|body| _ = world.despawn(body));
            }
            9 => *world.get_mut::<RigidBody>(self.bodies[4]).unwrap() = RigidBody::Static,
            10 => *world.get_mut::<RigidBody>(self.bodies[4]).unwrap() = RigidBody::Dynamic,
            11 => {
                let bundle = (RigidBody::Dynamic, Collider::cuboid(2.0, 0.2, 2.0), Position(DVec3::Y));
                let locked = LockedAxes { translation: [true; 3], rotation: [true; 3] };
                self.bodies.push(world.spawn((bundle, locked)).id());
            }
            _ => world.get_mut::<Rotation>(other).unwrap().0 = DQuat::from_rotation_x(round as f64),
        }
    }

    /// The pairs that touch after a step, entities by their place in the order of birth.
    fn touching(&mut self) -> BTreeSet<(Entity, Entity)> {
        step(&mut self.world);
        let contacts = &self.world.resource::<ContactForces>().0;
        let touching = contacts.iter().filter(|contact| contact.depth > 1e-6);
        touching.map(|contact| (contact.a.min(contact.b), contact.a.max(contact.b))).collect()
    }

    /// The same by a search from nothing: after a step of the 2009 way there is nothing in slots.
    fn touching_afresh(&mut self) -> BTreeSet<(Entity, Entity)> {
        *self.world.resource_mut::<SolverSettings>() = SolverSettings::classic();
        step(&mut self.world);
        *self.world.resource_mut::<SolverSettings>() = SolverSettings::steady();
        self.touching()
    }
}

#[test]
fn lasting_contacts_are_those_that_a_search_from_nothing_finds() {
    compare_with_search_from_nothing(SolverSettings::game());
}

#[test]
fn slots_have_for_force_level_methods_what_a_search_from_nothing_finds() {
    compare_with_search_from_nothing(SolverSettings::steady());
}

#[test]
fn slots_have_for_the_exact_method_what_a_search_from_nothing_finds() {
    compare_with_search_from_nothing(SolverSettings::accurate());
}

fn compare_with_search_from_nothing(settings: SolverSettings) {
    let mut lasting = Heap::new(settings);
    let mut afresh = Heap::new(SolverSettings::steady());
    assert_eq!(lasting.bodies, afresh.bodies);
    let mut before = BTreeSet::new();
    let mut changes = 0;
    for round in 0..16 {
        lasting.edit(round);
        afresh.edit(round);
        let (found, expected) = (lasting.touching(), afresh.touching_afresh());
        assert!(expected.len() > 25, "{} pairs touch", expected.len());
        let missing: Vec<_> = expected.symmetric_difference(&found).collect();
        assert!(missing.is_empty(), "round {round}: {missing:?}");
        changes += usize::from(found != before);
        before = found;
    }
    assert!(changes > 7, "only {changes} edits changed what touches");
}

/// Toggled in each step: no contact is left over or missing.
#[test]
fn the_way_of_contacts_can_be_changed_at_any_time() {
    let [steady, exact, classic] = [SolverSettings::steady(), SolverSettings::accurate(), SolverSettings::classic()];
    let mut toggled = Heap::new(SolverSettings::game());
    let mut afresh = Heap::new(SolverSettings::steady());
    for round in 0..16 {
        let settings = [SolverSettings::game(), steady, steady, classic, exact][round % 5];
        *toggled.world.resource_mut::<SolverSettings>() = settings;
        toggled.edit(round);
        afresh.edit(round);
        let (found, expected) = (toggled.touching(), afresh.touching_afresh());
        assert_eq!(found, expected, "round {round}");
    }
}

#[test]
fn pairs_of_bodies_that_nothing_moves_do_not_touch_and_moved_grounds_do() {
    let mut world = rig::weightless(SolverSettings::game());
    world.init_resource::<ContactForces>();
    let ground = rig::ground(&mut world);
    world.spawn((RigidBody::Static, Collider::sphere(1.0), Position(DVec3::ZERO)));
    let ball = rig::body(&mut world, Collider::sphere(0.5), DVec3::new(5.0, 3.0, 0.0));
    step(&mut world);
    assert!(world.resource::<ContactForces>().0.is_empty());
    // The ground comes up to the ball.
    world.get_mut::<Position>(ground).unwrap().0.y = 2.6;
    step(&mut world);
    let contacts = &world.resource::<ContactForces>().0;
    assert_eq!(contacts.len(), 1);
    assert!((contacts[0].depth - 0.1).abs() < 1e-6, "{}", contacts[0].depth);
    assert_eq!((contacts[0].a, contacts[0].b), (ground, ball));
}

/// Caching alone, on contacts of the 2009 way: a stack that few sweeps carry drifts half as far.
#[test]
fn extreme_vertices_carry_their_forces_over_where_settings_say_so() {
    let drift = |warm_starting| {
        let classic = SolverSettings::classic();
        let sweeps = SweepSettings { warm_starting, ..classic.sweeps };
        let mut world = rig::world_with(SolverSettings { friction: FrictionModel::TwoTangents, sweeps, ..classic });
        rig::ground(&mut world);
        let cubes = [0.5, 1.5, 2.5].map(|y| rig::body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * y));
        rig::run(&mut world, 2.0);
        cubes.map(|cube| rig::position(&world, cube).with_y(0.0).length()).into_iter().fold(0.0, f64::max)
    };
    let [cold, warm] = [false, true].map(drift);
    assert!(warm < 0.6 * cold && cold < 0.5, "{warm} m, {cold} m from nothing");
}
