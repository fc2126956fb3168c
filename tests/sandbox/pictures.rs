//! What hulls and meshes look like, and that they can be picked.

use bevy::math::{DQuat, DVec3};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use plumb::physics::RigidBody;
use plumb::sandbox::{SandboxAction, Selection};
use plumb::scene::MeshSpec;

use crate::stage::Stage;

const SCENE: &str = r#"(gravity: (0, 0, 0), bodies: [
    (name: "wedge", shape: Mesh(file: "plumb:wedge.obj", scale: 2), position: (-2, 1, 0), rotation_degrees: (20, 40, 60)),
    (name: "block", shape: Hull(points: [(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1.5)]), position: (2, 1, 0)),
], view: (eye: (0, 1, 8), target: (0, 1, 0)))"#;

/// The corners of a body's picture in the world.
fn picture(stage: &mut Stage, name: &str) -> Vec<DVec3> {
    let body = stage.body(name);
    let world = stage.world();
    let entity = world.entity(body);
    let (pose, mesh) = (*entity.get::<Transform>().expect("placed"), entity.get::<Mesh3d>().expect("a picture"));
    let mesh = world.resource::<Assets<Mesh>>().get(&mesh.0).expect("its mesh");
    let corners = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(VertexAttributeValues::as_float3);
    corners.expect("positions").iter().map(|&corner| (pose * Vec3::from(corner)).as_dvec3()).collect()
}

/// Whether two sets of points are the same.
fn assert_same_places(seen: &[DVec3], expected: &[DVec3]) {
    for (these, those) in [(seen, expected), (expected, seen)] {
        for place in these {
            let nearest = those.iter().map(|other| other.distance(*place)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-5, "nothing within {nearest} of {place}");
        }
    }
}

#[test]
fn a_mesh_is_seen_where_its_file_has_it() {
    let mut stage = Stage::open(SCENE);
    let wedge = MeshSpec::load("plumb:wedge.obj", std::path::Path::new(""), 2.0).expect("it comes with Plumb");
    // First about x, then y, then z.
    let degrees = |angle: f64| angle.to_radians();
    let turn = DQuat::from_rotation_z(degrees(60.0))
        * DQuat::from_rotation_y(degrees(40.0))
        * DQuat::from_rotation_x(degrees(20.0));
    let expected: Vec<DVec3> = wedge
        .mesh()
        .positions
        .iter()
        .map(|corner| DVec3::new(-2.0, 1.0, 0.0) + turn * (2.0 * *corner - wedge.hull().center()))
        .collect();
    assert!(wedge.hull().axes() != DQuat::IDENTITY, "a wedge lies askew in its file");
    assert_same_places(&picture(&mut stage, "wedge"), &expected);
}

#[test]
fn a_hull_is_seen_as_its_polyhedron() {
    let mut stage = Stage::open(SCENE);
    let corners = [DVec3::ZERO, 2.0 * DVec3::X, DVec3::Y, 1.5 * DVec3::Z];
    let middle = corners.iter().sum::<DVec3>() / 4.0;
    let expected = corners.map(|corner| DVec3::new(2.0, 1.0, 0.0) + corner - middle);
    let seen = picture(&mut stage, "block");
    assert_eq!(seen.len(), 12, "four triangles");
    assert_same_places(&seen, &expected);
}

#[test]
fn hulls_and_meshes_are_picked_and_outlined() {
    let mut stage = Stage::open(SCENE);
    for name in ["wedge", "block"] {
        let (body, center) = (stage.body(name), stage.position(name));
        let pixel = stage.seen_at(center);
        stage.move_to(pixel);
        stage.press();
        stage.release();
        stage.frames(2);
        assert_eq!(stage.world().resource::<Selection>().entity(), Some(body), "{name}");
        let outline = stage.world().get::<Children>(body).map_or(0, |children| children.len());
        assert_eq!(outline, 1, "{name} wears an outline");
    }
}

#[test]
fn a_ball_is_round_closed_and_of_two_shades_by_which_it_is_seen_to_turn() {
    const RADIUS: f32 = 0.4;
    let mut stage = Stage::open("(gravity: (0, 0, 0), bodies: [(name: \"ball\", shape: Sphere(radius: 0.4))])");
    let ball = stage.body("ball");
    let handle = stage.world().get::<Mesh3d>(ball).expect("a picture").0.clone();
    let mesh = stage.world().resource::<Assets<Mesh>>().get(&handle).expect("its mesh").clone();
    let scale = stage.world().get::<Transform>(ball).expect("placed").scale;
    let corners = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(VertexAttributeValues::as_float3).unwrap();
    let corners: Vec<Vec3> = corners.iter().map(|corner| scale * Vec3::from(*corner)).collect();
    assert!(corners.iter().all(|corner| (corner.length() - RADIUS).abs() < 1e-6));

    let indices: Vec<usize> = mesh.indices().expect("faces").iter().collect();
    let mut volume = 0.0;
    for face in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| corners[face[corner]]);
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "{a}, {b}, {c} is seen from within");
        volume += a.cross(b).dot(c) / 6.0;
    }
    let round = 4.0 / 3.0 * std::f32::consts::PI * RADIUS.powi(3);
    assert!(volume < round && volume > 0.97 * round, "{volume} of {round} m³");

    let Some(VertexAttributeValues::Float32x4(shades)) = mesh.attribute(Mesh::ATTRIBUTE_COLOR) else {
        panic!("no shades")
    };
    let bright = shades.iter().filter(|shade| shade[0] == 1.0).count();
    assert_eq!(2 * bright, shades.len(), "half of it is bright");
}

#[test]
fn a_new_scene_is_in_the_picture_at_once() {
    let mut stage = Stage::open(SCENE);
    for action in [SandboxAction::LoadScene { scene: "stack".into(), parameters: Vec::new() }, SandboxAction::Reset] {
        stage.act(action);
        let world = stage.world();
        let bodies = world.query_filtered::<(), (With<RigidBody>, With<Mesh3d>)>().iter(world).count();
        let mut grounds = world.query_filtered::<&Name, (Without<RigidBody>, With<Mesh3d>)>();
        let grounds = grounds.iter(world).filter(|name| name.as_str() == "ground").count();
        assert_eq!((bodies, grounds), (10, 1));
    }
}
