//! Hulls and meshes in scenes: how they are given, where they come to be, what is wrong with them.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use bevy::math::{DQuat, DVec3};
use plumb::physics::{BallJoint, ConvexHull, Position, Rotation, headless_app, step};
use plumb::scene::{
    BodySpec, HullSpec, JointSpec, MAX_MESH_BYTES, MeshSpec, PictureMesh, SceneSpec, ShapeSpec, builtin_meshes, load,
};

/// A box of 2 x 4 x 6 m about (10, 0, 0), turned by 0.3 rad about x, as OBJ.
fn crate_obj() -> String {
    let turn = DQuat::from_rotation_x(0.3);
    let corner = |i: u32| {
        let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
        10.0 * DVec3::X + turn * DVec3::new(sign(1), 2.0 * sign(2), 3.0 * sign(4))
    };
    let vertices = (0..8).map(corner).map(|DVec3 { x, y, z }| format!("v {x:?} {y:?} {z:?}\n"));
    // Two objects, quads, a texture coordinate, a normal, a material that is not there.
    let faces = "mtllib none.mtl\no one\nusemtl wood\nvt 0 0\nvn 0 0 1\nf 1/1 3/1 4/1 2/1\nf 5 6 8 7\nf 1 2 6 5\n\
                 o two\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    vertices.chain([faces.to_owned()]).collect()
}

/// A folder with `crate.obj` in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("crate.obj"), crate_obj()).expect("a file");
    folder
}

/// A scene file there with those bodies.
fn scene_in(folder: &Path, bodies: &str) -> Result<SceneSpec, String> {
    let path = folder.join("scene.ron");
    fs::write(&path, format!("(bodies: [{bodies}])")).expect("a file");
    load(path.to_str().expect("UTF-8"), &[]).map_err(|error| {
        let message = error.to_string();
        assert!(!message.contains(['\n', '\r']), "one line: {message}");
        let place = format!("{}: ", path.display());
        message.strip_prefix(&place).unwrap_or_else(|| panic!("names the scene: {message}")).to_owned()
    })
}

fn hull(body: &BodySpec) -> &ConvexHull {
    body.shape.as_ref().and_then(ShapeSpec::convex_hull).expect("a hull")
}

fn mesh(body: &BodySpec) -> &MeshSpec {
    let Some(ShapeSpec::Mesh(mesh)) = &body.shape else { panic!("a mesh") };
    mesh
}

#[test]
fn a_hull_is_given_by_points() {
    let text =
        r#"(bodies: [(name: "a", shape: Hull(points: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0.5)]))])"#;
    let scene = SceneSpec::from_ron(text, "scene.ron").expect("a scene");
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, 0.5 * DVec3::Z];
    assert_eq!(scene.bodies, [BodySpec::new("a", ShapeSpec::hull(points), DVec3::ZERO)]);
    assert_eq!(hull(&scene.bodies[0]).vertices().len(), 4);
    let shape = scene.bodies[0].shape.as_ref().expect("a shape");
    assert!((shape.volume() - 1.0 / 6.0).abs() < 1e-15);
    assert!((shape.smallest_extent() - 1.0 / 3_f64.sqrt()).abs() < 1e-12, "its height over the slope");
}

#[test]
fn a_mesh_is_looked_for_beside_its_scene_and_read_once() {
    let folder = folder();
    fs::create_dir(folder.path().join("inner")).expect("a folder");
    fs::copy(folder.path().join("crate.obj"), folder.path().join("inner/other.obj")).expect("a copy");
    let scene = scene_in(
        folder.path(),
        r#"(name: "a", shape: Mesh(file: "crate.obj")), (name: "b", shape: Mesh(file: "crate.obj")),
           (name: "c", shape: Mesh(file: "crate.obj", scale: 0.5)), (name: "d", shape: Mesh(file: "inner/other.obj"))"#,
    );
    let bodies = scene.expect("a scene").bodies;
    assert_eq!(mesh(&bodies[0]).path(), Some(&*folder.path().join("crate.obj")));
    assert_eq!((mesh(&bodies[2]).file(), mesh(&bodies[2]).scale()), ("crate.obj", 0.5));
    assert!(Arc::ptr_eq(mesh(&bodies[0]).mesh(), mesh(&bodies[1]).mesh()));
    assert!(Arc::ptr_eq(mesh(&bodies[0]).mesh(), mesh(&bodies[2]).mesh()));
    assert_eq!(hull(&bodies[0]), hull(&bodies[3]));
    let counts = (mesh(&bodies[0]).mesh().positions.len(), mesh(&bodies[0]).mesh().triangles.len());
    assert_eq!((counts.1, hull(&bodies[0]).vertices().len(), hull(&bodies[0]).faces().len()), (12, 8, 6));
    assert!((hull(&bodies[0]).volume() - 48.0).abs() < 1e-9);
    assert!((hull(&bodies[2]).volume() - 6.0).abs() < 1e-9);
    assert!(hull(&bodies[2]).center().distance(5.0 * DVec3::X) < 1e-9, "scaled from the file's origin");
    assert!(hull(&bodies[0]).axes().angle_between(DQuat::from_rotation_x(0.3)) < 1e-7);
}

#[test]
fn a_mesh_stands_as_it_was_modelled() {
    let folder = folder();
    // Without rotation each corner is at the position + the file's coordinates − their centre of mass.
    let turn = DQuat::from_rotation_y(1.0);
    let scene = scene_in(
        folder.path(),
        r#"(name: "a", shape: Mesh(file: "crate.obj"), position: (1, 2, 3)),
           (name: "b", shape: Mesh(file: "crate.obj"), position: (1, 2, 30), rotation_degrees: (0, 57.29577951308232, 0))"#,
    )
    .expect("a scene");
    let mut world = std::mem::take(headless_app().world_mut());
    let spawned = scene.spawn(&mut world);
    for (&entity, turn) in spawned.bodies.iter().zip([DQuat::IDENTITY, turn]) {
        let entity = world.entity(entity);
        let (position, rotation) =
            (entity.get::<Position>().expect("there").0, entity.get::<Rotation>().expect("there").0);
        let PictureMesh(picture) = entity.get::<PictureMesh>().expect("a picture");
        let corners: Vec<DVec3> = picture.hull().vertices().map(|vertex| position + rotation * vertex).collect();
        for given in &picture.mesh().positions {
            let expected = position + turn * (given - 10.0 * DVec3::X);
            let nearest = corners.iter().map(|corner| corner.distance(expected)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "no corner within {nearest} of {expected}");
        }
    }
}

#[test]
fn a_joint_holds_a_hull_where_the_scene_says() {
    let folder = folder();
    let mut scene =
        scene_in(folder.path(), r#"(name: "a", shape: Mesh(file: "crate.obj"), rotation_degrees: (10, 20, 30))"#)
            .expect("a scene");
    scene.bodies.push(BodySpec::pin("pin", DVec3::new(1.0, 2.0, 3.0)));
    scene.joints.push(JointSpec::at(&scene.bodies[0], &scene.bodies[1], DVec3::new(1.0, 2.0, 3.0)));
    let mut world = std::mem::take(headless_app().world_mut());
    let spawned = scene.spawn(&mut world);
    let at = |world: &bevy::prelude::World| {
        let joint = *world.get::<BallJoint>(spawned.joints[0]).expect("a joint");
        let body = world.entity(joint.body_a);
        body.get::<Position>().expect("there").0 + body.get::<Rotation>().expect("there").0 * joint.anchor_a
    };
    assert!(at(&world).distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-9);
    for _ in 0..30 {
        step(&mut world);
    }
    assert!(at(&world).distance(DVec3::new(1.0, 2.0, 3.0)) < 0.05, "and it swings there");
}

#[test]
fn every_mesh_that_comes_with_plumb_can_be_used() {
    let files: Vec<String> = builtin_meshes().collect();
    assert!(files.len() >= 4 && files.contains(&"plumb:rock.obj".to_owned()), "{files:?}");
    for file in files {
        let text = format!(r#"(bodies: [(name: "a", shape: Mesh(file: "{file}", scale: 0.5))])"#);
        let scene = SceneSpec::from_ron(&text, "anywhere/scene.ron").unwrap_or_else(|error| panic!("{error}"));
        let mesh = mesh(&scene.bodies[0]);
        assert_eq!((mesh.file(), mesh.path()), (file.as_str(), None));
        assert!((0.1..10.0).contains(&mesh.hull().bounding_radius()), "{file}");
    }
    let hollow = MeshSpec::load("plumb:bowl.obj", Path::new(""), 1.0).expect("it comes with Plumb");
    let normals = &hollow.mesh().normals;
    assert_eq!(normals.len(), hollow.mesh().triangles.len());
    assert!(normals.iter().flatten().all(|normal| (normal.length() - 1.0).abs() < 1e-2));
}

#[test]
fn a_hull_that_was_simulated_goes_back_into_a_scene_as_it_is() {
    let points = [DVec3::ZERO, 2.0 * DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
    let hull = ConvexHull::new(&points).expect("a hull");
    let spec = HullSpec::from(hull.clone());
    assert_eq!(spec.hull().as_ref(), Ok(&hull));
    let again = HullSpec::new(spec.points());
    let again = again.hull().as_ref().expect("a hull");
    assert!((again.volume() - hull.volume()).abs() < 1e-12 && again.center().distance(hull.center()) < 1e-12);
}

#[test]
fn a_bad_hull_is_named() {
    let problem = |points: &str| {
        let text = format!(r#"(bodies: [(name: "a", shape: Hull(points: [{points}]))])"#);
        SceneSpec::from_ron(&text, "scene.ron").expect_err("it is bad").to_string()
    };
    let place = "scene.ron: bodies[0].shape.points:";
    let cure = "give at least 4 that are not in one plane";
    assert_eq!(problem(""), format!("{place} 0 points have no volume; {cure}"));
    assert_eq!(problem("(0, 0, 0), (1, 0, 0), (0, 1, 0)"), format!("{place} 3 points have no volume; {cure}"));
    assert_eq!(
        problem("(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)"),
        format!("{place} all 4 points lie in one plane; add points beside it to give it a thickness")
    );
    assert_eq!(
        problem("(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)"),
        format!("{place} all 4 points lie on one line; add points beside it")
    );
    assert_eq!(problem("(0, 0, NaN)"), "scene.ron:1:51: must be finite, is NaN");
    let mut made = SceneSpec::new("made", DVec3::ZERO);
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NAN];
    made.bodies.push(BodySpec::new("a", ShapeSpec::hull(points), DVec3::ZERO));
    assert_eq!(
        made.validate().expect_err("it is bad").to_string(),
        "made: bodies[0].shape.points: point 3 (counted from 0) is not finite; give finite coordinates"
    );
}

#[test]
fn a_bad_mesh_is_named_with_its_file() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let problem = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("a file");
        let bodies = format!(r#"(name: "ground", shape: HalfSpace), (name: "a", shape: Mesh(file: "{name}"))"#);
        let message = scene_in(folder.path(), &bodies).expect_err("it is bad");
        message
            .strip_prefix("bodies[1].shape.file: ")
            .unwrap_or_else(|| panic!("names the place: {message}"))
            .to_owned()
    };
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    assert_eq!(
        problem("empty.obj", ""),
        format!(
            "{} has no faces; a mesh needs lines that start with 'f', for points alone use Hull(points: [...])",
            at("empty.obj")
        )
    );
    assert!(problem("points.obj", vertices).contains("has no faces"));
    let not_obj = "is not a Wavefront OBJ text file";
    assert!(problem("broken.obj", "v 1 2 x\nf 1 1 1").contains(not_obj));
    assert!(problem("outside.obj", &format!("{vertices}f 1 2 5")).contains(not_obj));
    assert!(problem("negative.obj", &format!("{vertices}f -1 -2 -9")).contains(not_obj));
    assert!(problem("zero.obj", &format!("{vertices}f 0 1 2")).contains(not_obj));
    assert_eq!(
        problem("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 NaN 0\nv 0 0 1\nf 1 2 3 4"),
        format!("{} has a vertex that is not finite: [0, NaN, 0]; correct that line", at("nan.obj"))
    );
    assert_eq!(
        problem("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3"),
        format!("{}: all 4 points lie in one plane; add points beside it to give it a thickness", at("flat.obj"))
    );
    fs::write(folder.path().join("binary.obj"), b"\xff\xfe\x00\x01\n\x80").expect("a file");
    let bodies = |file: &str| format!(r#"(name: "a", shape: Mesh(file: "{file}"))"#);
    let refused = |file: &str| scene_in(folder.path(), &bodies(file)).expect_err("it is bad");
    assert!(refused("binary.obj").contains(not_obj));
    assert_eq!(
        refused("missing.obj"),
        format!(
            "bodies[0].shape.file: {} cannot be read: No such file or directory (os error 2); a mesh's path is relative to its scene's file",
            at("missing.obj")
        )
    );
    assert!(refused(".").contains("cannot be read"));
    fs::File::create(folder.path().join("large.obj"))
        .and_then(|file| file.set_len(MAX_MESH_BYTES + 1))
        .expect("a file");
    assert_eq!(
        refused("large.obj"),
        format!(
            "bodies[0].shape.file: {} is larger than 256 MiB, the limit for a mesh; export it with fewer triangles",
            at("large.obj")
        )
    );
    let unknown = refused("plumb:teapot.obj");
    assert!(
        unknown.starts_with(
            "bodies[0].shape.file: no mesh 'plumb:teapot.obj' comes with Plumb; there are plumb:bone.obj, "
        ),
        "{unknown}"
    );
    let scaled =
        SceneSpec::from_ron(r#"(bodies: [(name: "a", shape: Mesh(file: "crate.obj", scale: 0))])"#, "scene.ron");
    assert_eq!(scaled.expect_err("it is bad").to_string(), "scene.ron:1:61: must be greater than 0, is 0");
}
