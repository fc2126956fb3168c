//! Meshes in convex pieces: what is hollow holds something.

use std::fs;
use std::path::Path;

use bevy::math::DVec3;
use plumb::physics::{Compound, Position, Shape, headless_app, step};
use plumb::physics::{SolverSettings, Velocity};
use plumb::scene::{BodySpec, MeshSpec, SceneSpec, ShapeSpec, builtin_meshes, load};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const PIECES: u32 = 16;

/// Of random triangles, which take half a second each; a thousand have been run.
const CASES: usize = 16;

fn in_pieces(file: &str, scale: f64) -> MeshSpec {
    let mesh = MeshSpec::load(file, Path::new(""), scale).expect("it comes with Plumb");
    mesh.with_pieces(PIECES).expect("it can be cut")
}

/// How far a point is in front of the piece that it is least in front of; negative inside, m.
fn outside(compound: &Compound, point: DVec3) -> f64 {
    let depths = compound.children().iter().map(|child| {
        let Shape::Hull(hull) = child.collider.shape() else { panic!("a hull") };
        let place = child.rotation.inverse() * (point - child.position);
        let vertices: Vec<DVec3> = hull.vertices().collect();
        let in_front = |corners: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|corner| vertices[corners[corner] as usize]);
            (b - a).cross(c - a).normalize().dot(place - a)
        };
        hull.faces().map(in_front).fold(f64::NEG_INFINITY, f64::max)
    });
    depths.fold(f64::INFINITY, f64::min)
}

/// Volume and centre of the closed surface of a mesh file, by tetrahedra from the origin.
fn integral(mesh: &MeshSpec) -> (f64, DVec3) {
    let (mut volume, mut first) = (0.0, DVec3::ZERO);
    for corners in &mesh.mesh().triangles {
        let [a, b, c] = corners.map(|corner| mesh.mesh().positions[corner as usize] * mesh.scale());
        let tetrahedron = a.dot(b.cross(c)) / 6.0;
        volume += tetrahedron;
        first += (a + b + c) / 4.0 * tetrahedron;
    }
    (volume, first / volume)
}

#[test]
fn a_ball_stays_in_a_bowl_of_pieces() {
    let presets = [
        ("game", SolverSettings::game()),
        ("accurate", SolverSettings::accurate()),
        ("classic", SolverSettings::classic()),
    ];
    for (name, settings) in presets {
        let mut scene = SceneSpec::new("bowl", DVec3::new(0.0, -9.81, 0.0));
        let mesh = in_pieces("plumb:bowl.obj", 0.5);
        let foot = mesh.mesh().positions.iter().map(|place| 0.5 * place.y).fold(f64::INFINITY, f64::min);
        let top = mesh.mesh().positions.iter().map(|place| 0.5 * place.y).fold(f64::NEG_INFINITY, f64::max) - foot;
        let at = DVec3::Y * (mesh.center().y - foot);
        let bowl = BodySpec::new("bowl", ShapeSpec::Mesh(mesh), at).with_mass(8.0);
        let start = DVec3::new(0.08, top + 0.2, 0.03);
        let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.1 }, start).with_mass(1.0);
        scene.bodies = vec![BodySpec::ground(), bowl, ball];
        let mut world = std::mem::take(headless_app().world_mut());
        world.insert_resource(settings);
        let spawned = scene.spawn(&mut world);
        for _ in 0..240 {
            step(&mut world);
        }
        let place = |body: usize| world.get::<Position>(spawned.bodies[body]).expect("a body").0;
        let speed = world.get::<Velocity>(spawned.bodies[2]).expect("a body").linear.length();
        let ball = place(2) - (place(1) - at);
        assert!(ball.y - 0.1 < 0.6 * top && ball.y > 0.0, "{name}: at {ball} of {top}");
        assert!(ball.with_y(0.0).length() < 0.25, "{name}: at {ball}");
        assert!(speed < 1.0, "{name}: {speed} m/s");
    }
}

#[test]
fn pieces_cover_the_mesh_and_keep_near_it() {
    for file in builtin_meshes() {
        let mesh = in_pieces(&file, 1.0);
        let compound = mesh.pieces().expect("it is of some");
        assert!(compound.children().len() <= PIECES as usize, "{file}: {}", compound.children().len());
        let to_body = |place: DVec3| mesh.axes().inverse() * (place - mesh.center());
        let reach = mesh.hull().bounding_radius();
        for &place in &mesh.mesh().positions {
            let gap = outside(compound, to_body(place));
            assert!(gap < 0.02 * reach, "{file}: {place} is {gap} m outside");
        }
        // What is hollow is filled by the pieces' chords only.
        for child in compound.children() {
            let Shape::Hull(hull) = child.collider.shape() else { panic!("a hull") };
            for vertex in hull.vertices() {
                let place = mesh.center() + mesh.axes() * (child.position + child.rotation * vertex);
                let beyond = outside_hull(&mesh, place);
                assert!(beyond < 0.02 * reach, "{file}: {place} is {beyond} m beyond the whole");
            }
        }
        let (volume, center) = integral(&mesh);
        let pieces = ShapeSpec::Mesh(mesh.clone()).volume();
        assert!((0.97..1.6).contains(&(pieces / volume)), "{file}: {pieces} m³ for {volume}");
        assert!(mesh.center().distance(center) < 0.06 * reach, "{file}: {} for {center}", mesh.center());
    }
}

fn outside_hull(mesh: &MeshSpec, place: DVec3) -> f64 {
    let hull = mesh.hull();
    let local = hull.axes().inverse() * (place - hull.center());
    let vertices: Vec<DVec3> = hull.vertices().collect();
    let in_front = |corners: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|corner| vertices[corners[corner] as usize]);
        (b - a).cross(c - a).normalize().dot(local - a)
    };
    hull.faces().map(in_front).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_box_cut_in_two_weighs_what_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    // An L: two boxes of 2 and 1 m³, their common centre by hand.
    let corners = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let mut text = String::new();
    for z in 0..2 {
        corners.iter().for_each(|(x, y)| text += &format!("v {x} {y} {z}\n"));
    }
    text += "f 4 2 1\nf 4 3 2\nf 6 4 1\nf 6 5 4\nf 7 8 10\nf 8 9 10\nf 7 10 12\nf 10 11 12\n";
    for side in 1..=6 {
        let next = side % 6 + 1;
        text += &format!("f {side} {next} {} {}\n", next + 6, side + 6);
    }
    fs::write(folder.path().join("l.obj"), text).expect("a file");
    let mesh = MeshSpec::load("l.obj", folder.path(), 1.0).and_then(|mesh| Ok(mesh.with_pieces(4)?)).expect("an L");
    let (volume, center) = integral(&mesh);
    assert!((volume - 3.0).abs() < 1e-12 && center.distance(DVec3::new(2.5 / 3.0, 2.5 / 3.0, 0.5)) < 1e-12);
    // A voxel, a 32nd of the side, more or less at the cut.
    assert!((ShapeSpec::Mesh(mesh.clone()).volume() - volume).abs() < 0.1 * volume);
    assert!(mesh.center().distance(center) < 0.07, "{}", mesh.center());
}

#[test]
fn a_body_of_pieces_comes_back_from_a_world_and_a_file() {
    let text =
        r#"(bodies: [(name: "a", shape: Mesh(file: "plumb:bowl.obj", scale: 0.5, pieces: 16), position: (0, 2, 0))])"#;
    let scene = SceneSpec::from_ron(text, "scene.ron").expect("a scene");
    let mut world = std::mem::take(headless_app().world_mut());
    scene.spawn(&mut world);
    step(&mut world);
    let again = SceneSpec::of_world(&mut world, "scene");
    assert_eq!(again.bodies[0].shape, scene.bodies[0].shape);
    let written = again.to_ron(None).expect("a valid scene");
    assert!(written.contains(r#"Mesh(file: "plumb:bowl.obj", scale: 0.5, pieces: 16)"#), "{written}");
    assert_eq!(SceneSpec::from_ron(&written, "scene.ron").expect("a scene").bodies[0].shape, scene.bodies[0].shape);
}

#[test]
fn bad_pieces_are_named_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = |shape: &str, text: &str| {
        fs::write(folder.path().join("m.obj"), text).expect("a file");
        let path = folder.path().join("scene.ron");
        fs::write(&path, format!(r#"(bodies: [(name: "a", shape: {shape})])"#)).expect("a file");
        let message = load(path.to_str().expect("UTF-8"), &[]).err().map(|error| error.to_string());
        assert!(message.as_ref().is_none_or(|message| !message.contains('\n')), "{message:?}");
        message.unwrap_or_default().replace(&format!("{}: ", path.display()), "")
    };
    let four = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for count in [0, 1, 65, u32::MAX] {
        assert_eq!(
            problem(&format!(r#"Mesh(file: "m.obj", pieces: {count})"#), four),
            format!(
                "bodies[0].shape.pieces: must be from 2 to 64, is {count}; without it, the body is the hull of the whole mesh"
            )
        );
    }
    let mesh = r#"Mesh(file: "m.obj", pieces: 4)"#;
    assert!(problem(mesh, "v 0 0 0\nv 1 0 0\nv 0 NaN 0\nv 0 0 1\nf 1 2 3 4").contains("not finite"));
    assert!(problem(mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3").contains("lie in one plane"));
    let many = format!("{four}{}", "f 1 2 3\n".repeat(1 << 18));
    assert_eq!(
        problem(mesh, &many),
        "bodies[0].shape.pieces: a mesh of 262148 triangles is not cut in pieces; export it with at most 262144"
    );
    let child = format!("Compound(children: [(shape: {mesh})])");
    assert!(problem(&child, four).starts_with("bodies[0].shape.children[0].shape.pieces: a compound in a compound"));
    // What is open, has triangles without an area, or is very large or small, is cut all the same.
    let open = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\nf 1 5 6 2\nf 1 1 2\n";
    for text in [open.to_owned(), open.replace('1', "1e20").replace("f 1e20", "f 1")] {
        let _ = problem(mesh, &text);
    }
    assert_eq!(problem(mesh, open), "");
}

/// Any triangles at all: closed or open, in one plane, doubled, needles, large or small.
#[test]
fn whatever_the_triangles_are_they_are_cut_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut dice = Pcg64Mcg::seed_from_u64(47);
    let mut cut = 0;
    for case in 0..CASES {
        let corners = dice.random_range(4..60);
        let size = 10_f64.powi(dice.random_range(-6..7));
        let flat = if dice.random_range(0..4) == 0 { 1e-3 } else { 1.0 };
        let coarse = dice.random_range(0..2) == 0;
        let mut text = String::new();
        for _ in 0..corners {
            let place = DVec3::from_array(std::array::from_fn(|_| dice.random_range(-1.0..1.0)));
            let place = if coarse { (2.0 * place).round() / 2.0 } else { place } * DVec3::new(1.0, flat, 1.0) * size;
            text += &format!("v {} {} {}\n", place.x, place.y, place.z);
        }
        for _ in 0..dice.random_range(1..120) {
            let [a, b, c] = std::array::from_fn(|_| dice.random_range(1..=corners));
            text += &format!("f {a} {b} {c}\n");
        }
        let file = format!("{case}.obj");
        fs::write(folder.path().join(&file), text).expect("a file");
        let Ok(mesh) = MeshSpec::load(&file, folder.path(), 1.0) else { continue };
        let Ok(mesh) = mesh.with_pieces(dice.random_range(2..20)) else { continue };
        let volume = ShapeSpec::Mesh(mesh).volume();
        assert!(volume > 0.0 && volume.is_finite(), "case {case}: {volume} m³");
        cut += 1;
    }
    assert!(cut > CASES / 2, "{cut} cut");
}
