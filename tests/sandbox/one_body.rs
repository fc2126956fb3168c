//! One body of several, and bodies of its parts.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, Collider, HingeJoint, Position, RigidBody, Rotation, Velocity};
use plumb::sandbox::{Notice, SandboxAction, Selection};
use plumb::scene::{BodySpec, SceneSpec, ShapeSpec};

use crate::stage::Stage;

/// Of bodies: kg, kg·m/s, kg·m²/s about the origin, J.
struct Motion {
    mass: f64,
    momentum: DVec3,
    angular: DVec3,
    energy: f64,
}

impl Motion {
    fn of(stage: &mut Stage, bodies: &[Entity]) -> Self {
        let mut all = Self { mass: 0.0, momentum: DVec3::ZERO, angular: DVec3::ZERO, energy: 0.0 };
        for &body in bodies {
            let spec = spec(stage, body);
            let collider = spec.shape.as_ref().expect("a shape").collider();
            let mass = spec.mass.unwrap_or(spec.density * collider.volume());
            let moments = spec.inertia.unwrap_or(collider.mass_properties_of_mass(mass).inertia);
            let rotation = spec.principal_rotation();
            let spin = rotation * (moments * (rotation.inverse() * spec.angular_velocity));
            all.mass += mass;
            all.momentum += mass * spec.linear_velocity;
            all.angular += spin + spec.position.cross(mass * spec.linear_velocity);
            all.energy += 0.5 * (mass * spec.linear_velocity.length_squared() + spin.dot(spec.angular_velocity));
        }
        all
    }

    /// To 1e-12 of each, which leaves room for a thousand roundings.
    #[track_caller]
    fn assert_same(&self, other: &Self) {
        let numbers = [(self.mass, other.mass), (self.energy, other.energy)];
        for (one, other) in numbers {
            assert!((one - other).abs() <= 1e-12 * one, "{one} is not {other}");
        }
        for (one, other) in [(self.momentum, other.momentum), (self.angular, other.angular)] {
            assert!((one - other).length() <= 1e-12 * one.length(), "{one} is not {other}");
        }
    }
}

fn spec(stage: &mut Stage, body: Entity) -> BodySpec {
    BodySpec::of_entity(stage.world(), body).expect("a body")
}

/// The scene as it stands, in an order that does not tell when what was made.
fn stands(stage: &mut Stage) -> SceneSpec {
    let mut scene = SceneSpec::of_world(stage.world(), "as it stands");
    scene.bodies.sort_by(|one, other| one.name.cmp(&other.name));
    scene.joints.sort_by(|one, other| (&one.body_a, &one.body_b).cmp(&(&other.body_a, &other.body_b)));
    scene
}

fn pick(stage: &mut Stage, bodies: &[Entity]) {
    stage.world().insert_resource(Selection::of_bodies(bodies.iter().copied()));
}

fn picked(stage: &mut Stage) -> Vec<Entity> {
    stage.world().resource::<Selection>().bodies().collect()
}

fn said(stage: &mut Stage) -> String {
    match stage.world().resource::<Notice>().clone() {
        Notice::Info(text) | Notice::Error(text) => text,
        Notice::None => String::new(),
    }
}

/// Has bodies move as parts of one that turns about the origin as it goes along.
fn move_as_one(stage: &mut Stage, bodies: &[Entity]) {
    let (along, angular) = (DVec3::new(0.3, -0.2, 0.5), DVec3::new(0.7, 1.1, -0.4));
    for &body in bodies {
        let place = stage.world().get::<Position>(body).unwrap().0;
        let linear = along + angular.cross(place);
        stage.world().entity_mut(body).insert(Velocity { linear, angular });
    }
}

/// Four solids of one density without weight, the first two joined, the second hinged to the third and the first held by the
/// world; and what cannot be a part.
const YARD: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace, position: (0, -5, 0)),
        (name: "hills", kind: Static, position: (9, -4, 0),
            shape: Heights(size: (2, 2), rows: [[0, 0], [0, 0]])),
        (name: "post", kind: Static, shape: Sphere(radius: 0.3), position: (-4, 0, 0)),
        (name: "wall", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (-6, 0, 0)),
        (name: "box", shape: Cuboid(size: (1, 0.6, 0.4)), position: (0, 0, 0), rotation_degrees: (20, 40, -30),
            color: (1, 0, 0), friction: 0.9),
        (name: "ball", shape: Sphere(radius: 0.4), position: (1, 0.5, 0.2)),
        (name: "cone", shape: Cone(radius: 0.3, height: 0.7), position: (2, 0, -0.3), rotation_degrees: (50, 0, 10)),
        (name: "far", shape: Capsule(radius: 0.2, length: 0.5), position: (3.5, 1, 0)),
        (name: "eye", shape: Sphere(radius: 0.2), position: (0, 3, 0), sensor: true),
        (name: "lead", shape: Sphere(radius: 0.4), density: 9000, position: (1, -1, 0)),
    ],
    joints: [
        (body_a: "box", body_b: "ball", at: (0.6, 0.3, 0.1)),
        (body_a: "ball", body_b: "far", kind: Hinge, at: (2, 1, 0), axis: (0.2, 1, 0.3)),
        (body_a: "world", body_b: "box", at: (-0.5, 0, 0)),
    ],
    view: (eye: (0, 2, 12), target: (0, 0, 0)),
)"#;

#[test]
fn bodies_that_are_made_one_move_on_as_they_did() {
    let mut stage = Stage::open_paused(YARD);
    let parts = ["box", "ball", "cone"].map(|name| stage.body(name));
    move_as_one(&mut stage, &parts);
    let (before, scene) = (Motion::of(&mut stage, &parts), stands(&mut stage));
    pick(&mut stage, &parts);
    stage.act(SandboxAction::MakeOneBody);
    let [whole] = picked(&mut stage)[..] else { panic!("{}", said(&mut stage)) };
    before.assert_same(&Motion::of(&mut stage, &[whole]));
    let now = spec(&mut stage, whole);
    assert!((now.angular_velocity - DVec3::new(0.7, 1.1, -0.4)).length() < 1e-12, "{}", now.angular_velocity);
    assert_eq!((now.color, now.material.friction), (Some([1.0, 0.0, 0.0]), 0.9), "those of the first");
    let Some(ShapeSpec::Compound(compound)) = now.shape else { panic!("no compound") };
    assert_eq!(compound.children().len(), 3);
    assert_eq!(stands(&mut stage).bodies.len(), scene.bodies.len() - 2);

    stage.act(SandboxAction::Undo);
    assert_eq!(stands(&mut stage), scene, "one step takes it back");
    stage.act(SandboxAction::Redo);
    assert_eq!(stands(&mut stage).bodies.len(), scene.bodies.len() - 2);
    stage.act(SandboxAction::TogglePause);
    stage.frames(20);
    stage.replays();
}

/// Where the ends of each joint of that kind are in the world, and which way its frames' x points there.
fn hinge(stage: &mut Stage) -> [(DVec3, DVec3); 2] {
    let world = stage.world();
    let hinge = *world.query::<&HingeJoint>().single(world).expect("one hinge");
    let bodies = [hinge.body_a, hinge.body_b];
    let rotations = bodies.map(|body| world.get::<Rotation>(body).unwrap().0);
    let frames = hinge.axes.frames(rotations);
    let end = |i: usize, anchor: DVec3| {
        let place = world.get::<Position>(bodies[i]).unwrap().0 + rotations[i] * anchor;
        (place, rotations[i] * (frames[i] * DVec3::X))
    };
    [end(0, hinge.anchor_a), end(1, hinge.anchor_b)]
}

fn balls(stage: &mut Stage) -> Vec<[DVec3; 2]> {
    let world = stage.world();
    let joints: Vec<BallJoint> = world.query::<&BallJoint>().iter(world).copied().collect();
    let place = |body: Entity, anchor: DVec3| {
        world.get::<Position>(body).unwrap().0 + world.get::<Rotation>(body).unwrap().0 * anchor
    };
    joints.iter().map(|joint| [place(joint.body_a, joint.anchor_a), place(joint.body_b, joint.anchor_b)]).collect()
}

#[track_caller]
fn assert_hinge_is(stage: &mut Stage, before: [(DVec3, DVec3); 2]) {
    for (now, before) in hinge(stage).into_iter().zip(before) {
        assert!(now.0.distance(before.0) < 1e-12 && now.1.distance(before.1) < 1e-12, "{now:?} is not {before:?}");
    }
}

#[test]
fn joints_between_parts_go_and_those_to_others_hold_the_whole_at_the_same_places() {
    let mut stage = Stage::open_paused(YARD);
    stage.act(SandboxAction::StepOnce);
    let parts = ["box", "ball"].map(|name| stage.body(name));
    let before = hinge(&mut stage);
    assert_eq!(balls(&mut stage).len(), 2);
    pick(&mut stage, &parts);
    stage.act(SandboxAction::MakeOneBody);
    assert_hinge_is(&mut stage, before);
    let [[on_world, on_whole]] = balls(&mut stage)[..] else { panic!("one ball joint, that to the world") };
    assert!(on_world.distance(DVec3::new(-0.5, 0.0, 0.0)) < 1e-12 && on_whole.distance(on_world) < 1e-12);

    // Each part gets back what held there.
    stage.act(SandboxAction::TakeApart);
    assert_hinge_is(&mut stage, before);
    let scene = stands(&mut stage);
    let [hinge, pin] = &scene.joints[..] else { panic!("{:?}", scene.joints) };
    assert_eq!([&*hinge.body_a, &hinge.body_b, &pin.body_b], ["ball", "far", "box"]);
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::Undo);
    assert_hinge_is(&mut stage, before);
    assert_eq!(balls(&mut stage).len(), 2);
}

#[test]
fn a_whole_of_several_densities_has_their_mean_and_turns_no_faster_for_it() {
    let mut stage = Stage::open_paused(YARD);
    let parts = ["ball", "lead"].map(|name| stage.body(name));
    for part in parts {
        stage.world().get_mut::<Velocity>(part).unwrap().linear = DVec3::new(0.0, 0.0, 2.0);
    }
    let before = Motion::of(&mut stage, &parts);
    pick(&mut stage, &parts);
    stage.act(SandboxAction::MakeOneBody);
    let [whole] = picked(&mut stage)[..] else { panic!("{}", said(&mut stage)) };
    let (after, now) = (Motion::of(&mut stage, &[whole]), spec(&mut stage, whole));
    assert!((after.mass - before.mass).abs() < 1e-12 * before.mass);
    assert!((now.density - 5000.0).abs() < 1e-9, "{}", now.density);
    assert!(after.momentum.distance(before.momentum) < 1e-12 * before.momentum.length());
    assert!((after.energy - before.energy).abs() < 1e-12 * before.energy);
    assert!(now.angular_velocity.length() < 1e-12, "{}", now.angular_velocity);
}

#[test]
fn what_cannot_be_a_part_is_told_with_its_cure() {
    let mut stage = Stage::open_paused(YARD);
    let scene = stands(&mut stage);
    for (names, words) in [
        (&["box"][..], "pick what is to be one body"),
        (&["box", "ground"], "ground cannot be a part: it is a half-space"),
        (&["hills", "wall"], "hills cannot be a part: it is a surface"),
        (&["box", "post"], "box is dynamic and post is static: make both the same"),
        (&["box", "eye"], "eye only reports and box does not"),
    ] {
        let bodies: Vec<Entity> = names.iter().map(|name| stage.body(name)).collect();
        pick(&mut stage, &bodies);
        stage.act(SandboxAction::MakeOneBody);
        let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("{names:?} were taken") };
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert_eq!(stands(&mut stage), scene);
    }
    let body = stage.body("box");
    pick(&mut stage, &[body]);
    stage.act(SandboxAction::TakeApart);
    assert!(said(&mut stage).contains("a compound, or a mesh in pieces"), "{}", said(&mut stage));
    // What stands still can be one that stands still.
    let fixed = ["post", "wall"].map(|name| stage.body(name));
    pick(&mut stage, &fixed);
    stage.act(SandboxAction::MakeOneBody);
    let [whole] = picked(&mut stage)[..] else { panic!("{}", said(&mut stage)) };
    assert_eq!(stage.world().get::<RigidBody>(whole), Some(&RigidBody::Static));
}

#[test]
fn a_compound_that_becomes_a_part_gives_its_own_parts() {
    let mut stage = Stage::open_paused(YARD);
    let [first, second, third] = ["box", "ball", "cone"].map(|name| stage.body(name));
    let before = [first, second, third].map(|body| place(&mut stage, body));
    pick(&mut stage, &[first, second]);
    stage.act(SandboxAction::MakeOneBody);
    let pair = picked(&mut stage)[0];
    pick(&mut stage, &[pair, third]);
    stage.act(SandboxAction::MakeOneBody);
    stage.act(SandboxAction::TakeApart);
    let parts = picked(&mut stage);
    assert_eq!(parts.len(), 3, "{}", said(&mut stage));
    for (part, before) in parts.iter().zip(before) {
        let now = place(&mut stage, *part);
        assert!(now.distance(before) < 1e-12, "{now} is not {before}");
    }
}

fn place(stage: &mut Stage, body: Entity) -> DVec3 {
    stage.world().get::<Position>(body).unwrap().0
}

/// A bowl in pieces and a hammer, both turning, the hammer hinged to a post by its handle.
const TURNING: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "bowl", shape: Mesh(file: "plumb:bowl.obj", pieces: 8), mass: 7, position: (3, 1, 0),
            rotation_degrees: (10, 50, 30), velocity: (1, 2, -0.5), angular_velocity: (0.5, 2, -1)),
        (name: "hammer", position: (-2, 0, 0), rotation_degrees: (0, 0, 25), velocity: (0, 0.3, 0),
            angular_velocity: (0.4, -0.2, 0.9), force: (1, 2, 3), shape: Compound(children: [
            (shape: Cuboid(size: (0.2, 1.6, 0.2))),
            (shape: Cylinder(radius: 0.3, height: 0.9), position: (0.1, 1, 0.1), rotation_degrees: (0, 0, 80)),
        ])),
        (name: "post", kind: Static, shape: Sphere(radius: 0.2), position: (-2.5, -2, 0)),
    ],
    joints: [(body_a: "post", body_b: "hammer", kind: Hinge, at: (-1.9, -1.5, 0), axis: (0.1, 0.2, 1))],
    view: (eye: (0, 2, 12), target: (0, 0, 0)),
)"#;

#[test]
fn parts_move_on_as_they_did_in_the_whole() {
    let mut stage = Stage::open_paused(TURNING);
    let scene = stands(&mut stage);
    for name in ["bowl", "hammer"] {
        let whole = stage.body(name);
        let (before, was) = (Motion::of(&mut stage, &[whole]), spec(&mut stage, whole));
        pick(&mut stage, &[whole]);
        stage.act(SandboxAction::TakeApart);
        let parts = picked(&mut stage);
        assert!(parts.len() > 1, "{}", said(&mut stage));
        before.assert_same(&Motion::of(&mut stage, &parts));
        let forces: DVec3 = parts.iter().map(|part| spec(&mut stage, *part).force).sum();
        assert!((forces - was.force).length() < 1e-12);
        for part in &parts {
            assert_eq!(spec(&mut stage, *part).angular_velocity, was.angular_velocity);
        }
        stage.act(SandboxAction::Undo);
        let now = stands(&mut stage);
        // A whole that lies askew in its own axes is turned back and forth between these and its principal ones.
        for (now, was) in now.bodies.iter().zip(&scene.bodies) {
            assert!(now.rotation.abs_diff_eq(was.rotation, 1e-12), "{} is not {}", now.rotation, was.rotation);
            assert_eq!(BodySpec { rotation: was.rotation, ..now.clone() }, *was);
        }
        assert_eq!(now.joints, scene.joints);
    }
}

#[test]
fn a_joint_holds_the_part_that_is_nearest() {
    let mut stage = Stage::open_paused(TURNING);
    stage.act(SandboxAction::StepOnce);
    let before = hinge(&mut stage);
    let hammer = stage.body("hammer");
    pick(&mut stage, &[hammer]);
    stage.act(SandboxAction::TakeApart);
    assert_hinge_is(&mut stage, before);
    let handle = picked(&mut stage)[0];
    let world = stage.world();
    let hinge = *world.query::<&HingeJoint>().single(world).unwrap();
    assert_eq!(hinge.body_b, handle, "the handle, not the head");
    assert!(world.get::<Collider>(handle).is_some());
    stage.act(SandboxAction::TogglePause);
    stage.frames(20);
    stage.replays();
}

#[test]
fn a_joint_is_where_a_scene_puts_it_on_a_compound_that_lies_askew() {
    let mut stage = Stage::open_paused(TURNING);
    for (place, _) in hinge(&mut stage) {
        assert!(place.distance(DVec3::new(-1.9, -1.5, 0.0)) < 1e-9, "it is at {place}");
    }
}
