//! The built-in scenes: that they are what DESIGN says, valid at both ends of every parameter, and
//! sound at the start.

use std::path::Path;

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, Collider, Gravity, Mass, Position, RenderOrigin, RigidBody, Rotation, Velocity};
use plumb::scene::{BodySpec, JointSpec, MAX_BODIES, SceneEntity, SceneInfo, SceneSpec, catalog, find, load};

/// A built-in scene with some parameters given.
fn built(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(name, &parameters).unwrap_or_else(|error| panic!("{error}"))
}

/// Its defaults, then each parameter at its least and at its greatest with the rest at default;
/// where the greatest is too many bodies, the greatest that is not.
fn corners(scene: &SceneInfo) -> Vec<Vec<f64>> {
    let mut corners = vec![scene.defaults()];
    for (i, parameter) in scene.parameters.iter().enumerate() {
        for extreme in [parameter.min, parameter.max] {
            let mut values = scene.defaults();
            values[i] = extreme;
            while (scene.bodies)(&values) > MAX_BODIES as f64 {
                values[i] -= 1.0;
            }
            corners.push(values);
        }
    }
    corners
}

fn body<'a>(scene: &'a SceneSpec, name: &str) -> &'a BodySpec {
    scene.bodies.iter().find(|body| body.name == name).unwrap_or_else(|| panic!("no body '{name}' in {}", scene.name))
}

#[test]
fn all_scenes_are_there_the_start_scene_first() {
    let names: Vec<_> = catalog().iter().map(|scene| scene.name).collect();
    let expected = "limbs pendulum rods chain joint_grid top heavy_top incline slide_roll rolling bounce spheres \
                    cradle stack pyramid pyramids sandwich far";
    assert_eq!(names.join(" "), expected);
    for scene in catalog() {
        assert!(scene.seconds > 0.0 && !scene.about.is_empty() && !scene.truth.is_empty(), "{}", scene.name);
        assert!(find(scene.name).is_some_and(|found| std::ptr::eq(found, scene)));
        for parameter in scene.parameters {
            assert!(parameter.allows(parameter.default), "{} {}", scene.name, parameter.name);
        }
    }
}

#[test]
fn every_scene_is_valid_at_its_defaults_and_at_both_ends_of_each_parameter() {
    for info in catalog() {
        for values in corners(info) {
            let scene = info.make(&values).unwrap_or_else(|error| panic!("{error} {values:?}"));
            assert_eq!(scene.name, info.name);
            assert_eq!(scene.bodies.len() as f64, (info.bodies)(&values), "{} {values:?}: bodies foretold", info.name);
            assert!(scene.view.is_some(), "{}: view", info.name);
        }
    }
}

#[test]
fn anchors_of_every_joint_coincide_at_the_start() {
    for info in catalog() {
        for values in corners(info) {
            let scene = info.make(&values).unwrap_or_else(|error| panic!("{error}"));
            let by_name: std::collections::HashMap<_, _> = scene.bodies.iter().map(|b| (b.name.as_str(), b)).collect();
            for JointSpec { body_a, body_b, anchor_a, anchor_b, .. } in &scene.joints {
                let gap = by_name[body_a.as_str()].point(*anchor_a) - by_name[body_b.as_str()].point(*anchor_b);
                assert!(gap.length() <= 1e-12, "{} {values:?}: {body_a} to {body_b} {gap}", info.name);
            }
        }
    }
}

#[test]
fn body_counts_are_as_designed() {
    let count = |name, parameters: &[(&str, f64)]| built(name, parameters).bodies.len();
    assert_eq!(count("pyramid", &[("n", 40.0)]), 820 + 1);
    assert_eq!(count("pyramids", &[("n", 8.0)]), 3521);
    assert_eq!(count("joint_grid", &[("n", 100.0)]), 10_000);
    assert_eq!(count("chain", &[]), 12);
    assert_eq!(count("rods", &[("n", 5.0)]), 6);
    assert_eq!(count("stack", &[("n", 10.0)]), 11);
    assert_eq!(count("bounce", &[]), 50);
    assert_eq!(count("spheres", &[]), 217);
    assert_eq!(count("rolling", &[]), 27);
    assert_eq!(count("far", &[]), 11 + 12);
}

#[test]
fn spawning_makes_each_body_and_joint_as_described() {
    let scene = built("chain", &[("r", 1000.0)]);
    let mut world = World::new();
    world.insert_resource(RenderOrigin(DVec3::new(1.0, 2.0, 3.0)));
    let spawned = scene.spawn(&mut world);
    assert_eq!((spawned.bodies.len(), spawned.joints.len()), (scene.bodies.len(), scene.joints.len()));
    assert_eq!(world.resource::<Gravity>().0, scene.gravity);
    for (body, &entity) in scene.bodies.iter().zip(&spawned.bodies) {
        let entity = world.entity(entity);
        assert!(entity.contains::<SceneEntity>());
        assert_eq!(entity.get::<Name>().map(Name::as_str), Some(body.name.as_str()));
        assert_eq!(entity.get::<RigidBody>(), Some(&body.kind));
        assert_eq!(entity.get::<Position>(), Some(&Position(body.position)));
        assert_eq!(entity.get::<Rotation>(), Some(&Rotation(body.rotation)));
        assert_eq!(entity.get::<Velocity>(), Some(&Velocity::default()));
        assert_eq!(entity.get::<Mass>().map(|mass| mass.0), body.mass);
        assert_eq!(entity.contains::<Collider>(), body.shape.is_some());
        let drawn = entity.get::<Transform>().expect("a body has a transform").translation;
        assert_eq!(drawn, (body.position - DVec3::new(1.0, 2.0, 3.0)).as_vec3());
    }
    for (i, &entity) in spawned.joints.iter().enumerate() {
        let joint = world.get::<BallJoint>(entity).expect("a joint");
        assert_eq!([joint.body_a, joint.body_b], [spawned.bodies[i], spawned.bodies[i + 1]], "a chain");
        assert!(world.entity(entity).contains::<SceneEntity>());
    }
}

/// First row of a reference file: the position at t = 0.
fn reference_start(file: &str) -> DVec3 {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/reference").join(file);
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{file}: {error}"));
    let first = text.lines().nth(1).expect("a row under the header");
    let row: Vec<f64> = first.split(',').map(|field| field.parse().expect("a number")).collect();
    assert_eq!(row[0], 0.0);
    DVec3::new(row[1], row[2], row[3])
}

#[test]
fn rods_and_chain_start_where_their_references_do() {
    for n in [1, 2, 5] {
        let tip = DVec3::new(f64::from(n), 0.0, 0.0);
        let scene = built("rods", &[("n", f64::from(n))]);
        assert_eq!(body(&scene, &format!("rod {}", n - 1)).point(0.5 * DVec3::X), tip);
        assert_eq!(reference_start(&format!("rods-{n}.csv")), tip);
    }
    for r in [1, 100, 1000, 1_000_000] {
        let center = DVec3::new(11.0, 0.0, 0.0);
        let scene = built("chain", &[("r", f64::from(r))]);
        assert_eq!(body(&scene, "ball").position, center);
        assert_eq!(body(&scene, "ball").mass, Some(f64::from(r)));
        assert_eq!(reference_start(&format!("chain-{r}.csv")), center);
    }
}
