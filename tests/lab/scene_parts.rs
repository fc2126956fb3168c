//! Compounds and surfaces in scenes: how they are given and written, and what is wrong with them.

use std::fs;

use bevy::math::{DQuat, DVec3};
use plumb::physics::{Position, RigidBody, Rotation, headless_app, step};
use plumb::scene::{SceneSpec, ShapeSpec, SurfaceForm, load};

const TEXT: &str = r#"(
    bodies: [
        (name: "dumb-bell", position: (0, 2, 0), rotation_degrees: (0, 0, 30), shape: Compound(children: [
            (shape: Sphere(radius: 0.3), position: (-0.5, 0, 0.1)),
            (shape: Capsule(radius: 0.1, length: 0.8), rotation_degrees: (0, 0, 90)),
            (shape: Hull(points: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]), position: (0.5, 0, 0)),
        ])),
        (name: "hills", shape: Heights(size: (4, 6), rows: [[0, 0, 0.5], [0.1, 0.2, 0.5], [0, 0, 0], [0.3, 0, 0]])),
        (name: "door", kind: Kinematic, position: (9, 0, 0), shape: Surface(
            vertices: [(0, 0, 0), (0, 2, 0), (0, 2, 1), (0, 0, 1)],
            triangles: [(0, 1, 2), (0, 2, 3)],
            two_sided: true,
        )),
    ],
)"#;

#[test]
fn they_are_written_as_they_were_given_and_come_back_from_a_world() {
    let scene = SceneSpec::from_ron(TEXT, "parts.ron").expect("a scene");
    let text = scene.to_ron(None).expect("a text");
    let again = SceneSpec::from_ron(&text, "parts.ron").expect("a scene");
    assert_eq!(again, scene, "{text}");
    assert_eq!(again.to_ron(None).expect("a text"), text);
    assert_eq!(
        scene.bodies.iter().map(|body| body.kind).collect::<Vec<_>>(),
        [RigidBody::Dynamic, RigidBody::Static, RigidBody::Kinematic]
    );
    let mut app = headless_app();
    let spawned = scene.spawn(app.world_mut());
    let captured = SceneSpec::of_world(app.world_mut(), "parts");
    for (body, given) in captured.bodies.iter().zip(&scene.bodies) {
        assert_eq!(body.shape, given.shape);
        assert!((body.position - given.position).length() < 1e-15);
        assert!(body.rotation.angle_between(given.rotation) < 1e-7, "{} {}", body.rotation, given.rotation);
    }
    // Where a corner of the hull is that the file has at (1.5, 0, 0) before the turn.
    let Some(ShapeSpec::Compound(compound)) = &scene.bodies[0].shape else { panic!("a compound") };
    let (compound, own) = (compound.compound(), app.world().entity(spawned.bodies[0]));
    let turned = own.get::<Rotation>().unwrap().0 * compound.axes().inverse();
    let expected = DQuat::from_rotation_z(30.0_f64.to_radians());
    assert!(turned.angle_between(expected) < 1e-7, "{turned} {expected}");
    step(app.world_mut());
    assert!(app.world().get::<Position>(spawned.bodies[0]).unwrap().y < 2.0);
}

#[test]
fn heights_are_rows_along_z_each_along_x() {
    let scene = SceneSpec::from_ron(TEXT, "parts.ron").expect("a scene");
    let Some(ShapeSpec::Surface(surface)) = &scene.bodies[1].shape else { panic!("a surface") };
    let SurfaceForm::Heights { size, rows } = surface.form() else { panic!("heights") };
    assert_eq!((*size, rows.len(), rows[0].len()), ([4.0, 6.0], 4, 3));
    let has = |at: DVec3| surface.mesh().vertices().any(|vertex| (vertex - at).length() < 1e-12);
    for at in [[2.0, 0.5, -3.0], [0.0, 0.2, -1.0], [-2.0, 0.3, 3.0], [-2.0, 0.1, -1.0]] {
        assert!(has(at.into()), "{at:?}");
    }
    assert_eq!(surface.mesh().triangles().len(), 12);
}

#[test]
fn a_surface_of_a_file_has_its_triangles_and_may_be_flat() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("floor.obj"), "v 0 0 0\nv 0 0 2\nv 2 0 2\nv 2 0 0\nf 1 2 3 4\n").expect("a file");
    let path = folder.path().join("scene.ron");
    let shape = r#"Surface(file: "floor.obj", scale: 3)"#;
    fs::write(&path, format!(r#"(bodies: [(name: "floor", shape: {shape})])"#)).expect("a file");
    let scene = load(path.to_str().expect("UTF-8"), &[]).expect("a scene");
    let Some(ShapeSpec::Surface(surface)) = &scene.bodies[0].shape else { panic!("a surface") };
    assert_eq!(surface.mesh().triangles().len(), 2);
    assert!(surface.mesh().vertices().any(|vertex| vertex == DVec3::new(6.0, 0.0, 6.0)));
    let text = scene.to_ron(Some(folder.path())).expect("a text");
    assert!(text.contains(r#"shape: Surface(file: "floor.obj", scale: 3.0)"#), "{text}");
}

#[test]
fn what_is_wrong_with_one_is_told_in_a_line_that_names_the_place() {
    let cases = [
        ("Compound(children: [])", "bodies[0].shape.children: a compound of nothing; give at least one child"),
        (
            "Compound(children: [(shape: Sphere(radius: 1)), (shape: HalfSpace)])",
            "bodies[0].shape.children[1].shape: no solid; give balls, boxes, capsules, cylinders, cones, hulls or meshes",
        ),
        (
            "Compound(children: [(shape: Compound(children: [(shape: Sphere(radius: 1))]))])",
            "bodies[0].shape.children[0].shape: a compound in a compound; give its children instead",
        ),
        (
            "Compound(children: [(shape: Hull(points: [(0, 0, 0)]))])",
            "bodies[0].shape.children[0].shape.points: 1 points have no volume; give at least 4 that are not in one plane",
        ),
        (
            "Heights(size: (1, 1), rows: [[0, 0], [0]])",
            "bodies[0].shape.rows: row 1 (counted from 0) has 1 heights and the first 2; give all as many",
        ),
        (
            "Heights(size: (1, 1), rows: [[0, 0]])",
            "bodies[0].shape.rows: 1 rows of 2 heights; give at least 2 rows of at least 2",
        ),
        (
            "Surface(vertices: [(0, 0, 0), (1, 0, 0), (0, 0, 1)], triangles: [(0, 1, 7)])",
            "bodies[0].shape.triangles: triangle 0 (counted from 0) names vertex 7, but there are 3",
        ),
        (
            "Surface(vertices: [(0, 0, 0), (1, 0, 0), (2, 0, 0)], triangles: [(0, 1, 2)])",
            "bodies[0].shape.triangles: it has no triangle with an area; give at least one",
        ),
        (
            r#"Surface(file: "a.obj", vertices: [(0, 0, 0)])"#,
            "bodies[0].shape.file: give either 'file' or 'vertices' and 'triangles', not both",
        ),
        ("Surface(scale: 2)", "bodies[0].shape.scale: a scale is for a 'file'; give vertices as large as they are"),
    ];
    for (shape, expected) in cases {
        let text = format!(r#"(bodies: [(name: "a", shape: {shape})])"#);
        let error = SceneSpec::from_ron(&text, "scene.ron").unwrap_err().to_string();
        assert_eq!(error, format!("scene.ron: {expected}"), "{shape}");
    }
    let dynamic = r#"(bodies: [(name: "a", kind: Dynamic, shape: Heights(size: (1, 1), rows: [[0, 0], [0, 0]]))])"#;
    let error = SceneSpec::from_ron(dynamic, "scene.ron").unwrap_err().to_string();
    assert!(error.contains("a surface has no mass: say kind: Static, or Kinematic"), "{error}");
}
