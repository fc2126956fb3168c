//! Each engine has the scene's bodies where the scene has them, and moves what is free as Newton
//! says.

use ::plumb::scene::{ChildSpec, CompoundSpec, HullSpec, ShapeSpec, SurfaceSpec};
use bevy::math::{DQuat, DVec3};

use super::*;

const SETTINGS: Settings = Settings { hz: 60.0, substeps: None, threads: 1, sleep: false };

/// f32 at a few metres, over a few operations.
const ROUNDING: f64 = 2e-6;

fn scene(text: &str) -> Scene {
    Scene::parse(text).unwrap()
}

#[test]
fn bodies_are_where_the_scene_has_them() {
    // Turned bodies on joints; a top that spins about all axes; cubes on the ground.
    for scene in [scene("ragdolls"), scene("heavy_top"), scene("stack 2")] {
        for kind in EngineKind::all() {
            let mut run = kind.start(&scene, &SETTINGS).unwrap();
            let states = run.read().unwrap();
            assert_eq!(states.len(), scene.bodies.len());
            for (state, body) in states.iter().zip(&scene.bodies) {
                assert!(state.position.distance(body.position) < ROUNDING, "{kind}: {body:?}");
                assert!(state.rotation.dot(body.rotation).abs() > 1.0 - ROUNDING, "{kind}: {body:?}");
                assert!(state.linear.distance(body.velocity.linear) < 1e-5, "{kind}: {body:?}");
                assert!(state.angular.distance(body.velocity.angular) < 1e-4, "{kind}: {body:?}");
            }
            for joint in &scene.joints {
                assert!(joint.separation(states) < ROUNDING, "{kind}");
            }
        }
    }
}

#[test]
fn a_free_body_falls_and_spins_as_newton_says() {
    let mut falling = scene("top");
    falling.spec.gravity = DVec3::new(1.0, -10.0, 3.0);
    let body = &mut falling.spec.bodies[0];
    body.rotation = DQuat::from_rotation_x(0.7);
    // About a principal axis: it keeps spinning so.
    body.angular_velocity = body.rotation * DVec3::new(0.0, 0.0, 2.0);
    body.linear_velocity = DVec3::new(3.0, 2.0, 1.0);
    let start = body.clone();
    let falling = Scene::of(falling.spec);
    for kind in EngineKind::all() {
        let mut run = kind.start(&falling, &SETTINGS).unwrap();
        for _ in 0..30 {
            run.step().unwrap();
        }
        assert_eq!((run.steps(), run.time()), (30, 0.5));
        let state = run.read().unwrap()[0];
        let linear = start.linear_velocity + 0.5 * falling.spec.gravity;
        assert!(state.linear.distance(linear) < 1e-4, "{kind}: {}", state.linear);
        // Symplectic Euler with whole steps is ½ g t h off.
        let position = start.position + 0.5 * start.linear_velocity + 0.125 * falling.spec.gravity;
        assert!(state.position.distance(position) < 0.05, "{kind}: {}", state.position);
        let rotation = DQuat::from_axis_angle(start.rotation * DVec3::Z, 1.0) * start.rotation;
        assert!(state.rotation.angle_between(rotation) < 1e-3, "{kind}: {}", state.rotation);
        assert!(state.angular.distance(start.angular_velocity) < 1e-3, "{kind}: {}", state.angular);
    }
}

/// How far a body has moved from its start after a second.
fn moved_after_a_second(kind: EngineKind, scene: &Scene) -> DVec3 {
    let mut run = kind.start(scene, &SETTINGS).unwrap();
    for _ in 0..60 {
        run.step().unwrap();
    }
    run.read().unwrap()[1].position - scene.bodies[1].position
}

/// The 2009 engine lets things sink and slide.
fn holds_things_still() -> impl Iterator<Item = EngineKind> {
    EngineKind::all().into_iter().filter(|kind| kind.to_string() != "plumb:classic")
}

#[test]
fn every_shape_rests_on_the_ground() {
    let corners: Vec<DVec3> =
        (0..8).map(|i| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into())).collect();
    let shapes = [
        (ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.4, 1.0) }, 0.2),
        (ShapeSpec::Sphere { radius: 0.3 }, 0.3),
        (ShapeSpec::Cone { radius: 0.5, height: 0.8 }, 0.2),
        // Its corners are not about its centre of mass.
        (ShapeSpec::Hull(HullSpec::new(corners)), 0.5),
        // A plate on two feet, off its middle.
        (plate_on_feet(), 0.0),
    ];
    for (shape, height) in shapes {
        let mut resting = scene("stack 1").spec;
        resting.bodies[1].shape = Some(shape.clone());
        resting.bodies[1].position.y = height;
        if let ShapeSpec::Compound(compound) = &shape {
            resting.bodies[1].position = compound.compound().center();
        }
        let resting = Scene::of(resting);
        for kind in holds_things_still() {
            let moved = moved_after_a_second(kind, &resting);
            assert!(moved.length() < 0.01, "{kind}, {shape:?}: {moved}");
        }
    }
}

/// Its feet stand on the plane through its origin.
fn plate_on_feet() -> ShapeSpec {
    let part = |size: DVec3, x: f64, y: f64| ChildSpec {
        shape: ShapeSpec::Cuboid { size },
        position: DVec3::new(x, y, 0.0),
        rotation: DQuat::IDENTITY,
    };
    let foot = DVec3::new(0.3, 0.4, 1.0);
    let parts = vec![part(DVec3::new(2.0, 0.2, 1.0), 0.3, 0.5), part(foot, -0.4, 0.2), part(foot, 0.9, 0.2)];
    ShapeSpec::Compound(CompoundSpec::new(parts).unwrap())
}

#[test]
fn bodies_rest_on_a_surface_of_triangles() {
    for (shape, height) in [(ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.4, 1.0) }, 0.2), (plate_on_feet(), 0.0)] {
        let mut resting = scene("stack 1").spec;
        let surface = SurfaceSpec::heights([7.0, 7.0], vec![vec![0.0; 6]; 6]).unwrap();
        resting.bodies[0].shape = Some(ShapeSpec::Surface(surface));
        resting.bodies[1].position.y = height;
        if let ShapeSpec::Compound(compound) = &shape {
            resting.bodies[1].position = compound.compound().center();
        }
        resting.bodies[1].shape = Some(shape.clone());
        let resting = Scene::of(resting);
        for kind in holds_things_still() {
            let moved = moved_after_a_second(kind, &resting);
            assert!(moved.length() < 0.02, "{kind}, {shape:?}: {moved}");
        }
    }
}

#[test]
fn a_kinematic_body_goes_where_its_velocity_takes_it() {
    let mut moving = scene("stack 1").spec;
    moving.bodies[0].position.y = -50.0;
    let body = &mut moving.bodies[1];
    body.kind = RigidBody::Kinematic;
    (body.linear_velocity, body.angular_velocity) = (DVec3::new(1.0, 2.0, 3.0), 0.5 * DVec3::Z);
    let moving = Scene::of(moving);
    for kind in EngineKind::all() {
        let mut run = kind.start(&moving, &SETTINGS).unwrap();
        for _ in 0..60 {
            run.step().unwrap();
        }
        let state = run.read().unwrap()[1];
        let moved = state.position - moving.bodies[1].position;
        assert!(moved.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-4, "{kind}: {moved}");
        assert!(state.rotation.angle_between(DQuat::from_rotation_z(0.5)) < 1e-3, "{kind}: {}", state.rotation);
    }
}

#[test]
fn a_force_lasts_and_friction_resists_it() {
    let mut pushed = scene("stack 1").spec;
    // 1000 kg under 10 m/s² with μ 0.6 holds 6000 N.
    pushed.bodies[1].force = DVec3::new(8000.0, 0.0, 0.0);
    let pushed = Scene::of(pushed);
    for kind in holds_things_still() {
        // (8000 − 6000) N on 1000 kg for 1 s.
        let moved = moved_after_a_second(kind, &pushed);
        assert!((moved.x - 1.0).abs() < 0.1, "{kind}: {moved}");
    }
}

#[test]
fn what_is_not_translated_is_refused_by_peers_alone() {
    let mut locked = scene("rods 1");
    locked.spec.bodies[1].locked.translation[0] = true;
    let refusal = EngineKind::Rapier.start(&locked, &SETTINGS).err();
    assert_eq!(refusal, Some(Unable::NotTranslated("locked axes")));
    assert!(EngineKind::all()[0].start(&locked, &SETTINGS).is_ok());
}

/// A step of two static bodies on one joint, beside a body that can move.
#[test]
fn avian_says_that_it_cannot_join_static_bodies() {
    let mut spec = scene("rods 2").spec;
    spec.bodies[1].kind = RigidBody::Static;
    let joined = Scene::of(spec);
    for kind in EngineKind::all() {
        let outcome = kind.start(&joined, &SETTINGS).and_then(|mut run| run.step());
        assert_eq!(matches!(outcome, Err(Unable::Panicked(_))), kind == EngineKind::Avian, "{kind}");
    }
}

#[test]
fn a_panic_ends_the_run_with_its_message() {
    struct Fragile;
    impl Engine for Fragile {
        fn step(&mut self) {
            panic!("two static bodies {}", 1);
        }
        fn read(&mut self, _: &mut Vec<BodyState>) {}
    }
    let mut run = Run { engine: Some(Box::new(Fragile)), states: Vec::new(), steps: 0, hz: 60.0 };
    assert_eq!(run.step().err(), Some(Unable::Panicked("two static bodies 1".into())));
    assert!(run.step().is_err() && run.read().is_err());
    assert_eq!(run.steps(), 0);
}

#[test]
fn engines_are_found_by_the_name_they_show() {
    for kind in EngineKind::all() {
        assert_eq!(kind.to_string().parse(), Ok(kind));
    }
    assert!("bullet".parse::<EngineKind>().unwrap_err().contains("rapier"));
}

#[test]
fn versions_are_those_of_the_lock_file() {
    assert_eq!(locked_version("rapier3d"), "0.36.1");
    assert_eq!(locked_version("avian3d"), "0.7.0");
    assert_eq!(locked_version("no such package"), "unknown");
}
