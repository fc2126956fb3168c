//! Scenes and settings in files: saved, loaded, and read again when they change.

use std::fs;
use std::path::{Path, PathBuf};

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::lab::{read_settings, settings_text};
use plumb::physics::{BallJoint, Position, RigidBody, SolverSettings, Velocity};
use plumb::sandbox::{CurrentScene, MeshForm, Notice, Picked, SandboxAction, Selection};
use plumb::scene::BodyColor;

use crate::stage::Stage;

/// A folder of its own with a scene in it, and the sandbox on that scene.
struct Desk {
    stage: Stage,
    folder: tempfile::TempDir,
}

/// A row of balls.
fn balls(count: usize) -> String {
    let ball = |i| format!("(name: \"ball {i}\", shape: Sphere(radius: 0.3), position: ({i}, 3, 0)),\n");
    let balls: String = (0..count).map(ball).collect();
    format!("(bodies: [\n{balls}], view: (eye: (0, 2, 12), target: (0, 2, 0)))")
}

impl Desk {
    fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut desk = Self { stage: Stage::open("()"), folder };
        desk.write(scene);
        let scene = desk.path("scene.ron").to_str().unwrap().to_owned();
        desk.stage.act(SandboxAction::LoadScene { scene, parameters: Vec::new() });
        desk.stage.frames(2);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, scene: &str) {
        fs::write(self.path("scene.ron"), scene).unwrap();
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn notice(&mut self) -> Notice {
        self.stage.world().resource::<Notice>().clone()
    }

    #[track_caller]
    fn refusal(&mut self) -> String {
        let Notice::Error(reason) = self.notice() else { panic!("no refusal but {:?}", self.notice()) };
        assert_eq!(reason.lines().count(), 1, "{reason}");
        reason
    }

    fn bodies(&mut self) -> usize {
        let world = self.stage.world();
        world.query::<&RigidBody>().iter(world).count()
    }

    /// A second passes.
    fn wait(&mut self) {
        self.stage.frames(60);
    }
}

#[test]
fn a_scene_whose_file_changes_starts_anew_seen_from_the_same_place() {
    let mut desk = Desk::with(&balls(2));
    desk.stage.move_to(Vec2::new(300.0, 300.0));
    desk.stage.wheel(-1.0);
    desk.stage.wheel(-3.0);
    desk.stage.frames(90);
    let (camera, height) = (desk.stage.camera(), desk.stage.position("ball 0").y);
    assert_eq!(desk.notice(), Notice::None, "nothing to read again as long as nothing changes");

    desk.write(&balls(3));
    desk.wait();
    assert_eq!(desk.bodies(), 3);
    assert!(matches!(desk.notice(), Notice::Info(text) if text.contains("reloaded")));
    assert!(desk.stage.position("ball 0").y > height, "from its start");
    assert_eq!(desk.stage.camera(), camera);
    assert_eq!(desk.stage.world().resource::<CurrentScene>().spec.bodies.len(), 3, "a reset leads there too");
}

#[test]
fn a_file_that_is_broken_is_named_and_read_once_it_is_mended() {
    let mut desk = Desk::with(&balls(2));
    desk.write("(bodies: [(name: 7)])");
    desk.wait();
    let reason = desk.refusal();
    assert!(reason.contains("scene.ron:1:"), "{reason}");
    let height = desk.stage.position("ball 0").y;
    desk.stage.frames(10);
    assert_eq!(desk.bodies(), 2);
    assert!(desk.stage.position("ball 0").y < height, "the old scene goes on");

    // Said once: what the user is told meanwhile is not overwritten.
    desk.stage.act(SandboxAction::Undo);
    let said = desk.notice();
    desk.wait();
    assert_eq!(desk.notice(), said);

    desk.write(&balls(4));
    desk.wait();
    assert_eq!(desk.bodies(), 4);
}

#[test]
fn an_editor_that_replaces_the_file_is_waited_for() {
    let mut desk = Desk::with(&balls(2));
    fs::remove_file(desk.path("scene.ron")).unwrap();
    desk.wait();
    assert_eq!((desk.bodies(), desk.notice()), (2, Notice::None), "gone is not broken");
    let new = desk.path("new");
    fs::write(&new, balls(5)).unwrap();
    fs::rename(new, desk.path("scene.ron")).unwrap();
    desk.wait();
    assert_eq!(desk.bodies(), 5);
}

#[test]
fn a_half_written_file_is_not_read() {
    let mut desk = Desk::with(&balls(2));
    let whole = balls(6);
    for end in (10..whole.len()).step_by(20) {
        desk.write(&whole[..end]);
        desk.stage.frames(9);
        assert_eq!((desk.bodies(), desk.notice()), (2, Notice::None), "at {end} of {} bytes", whole.len());
    }
    desk.write(&whole);
    desk.wait();
    assert_eq!(desk.bodies(), 6);
}

#[test]
fn only_the_file_of_the_scene_on_view_is_watched() {
    let mut desk = Desk::with(&balls(2));
    desk.stage.act(SandboxAction::LoadScene { scene: "stack".into(), parameters: vec![("n".into(), 3.0)] });
    let bodies = desk.bodies();
    desk.write(&balls(7));
    desk.wait();
    assert_eq!((desk.bodies(), desk.notice()), (bodies, Notice::None));
}

#[test]
fn settings_come_back_from_their_file() {
    let mut desk = Desk::with(&balls(1));
    let path = desk.path("settings.ron");
    let mine = SolverSettings { hz: 123.456, correction_speed: None, substeps: 7, ..SolverSettings::classic() };
    desk.stage.world().insert_resource(mine);
    desk.stage.act(SandboxAction::SaveSettings { path: path.clone(), overwrite: false });
    assert!(matches!(desk.notice(), Notice::Info(text) if text.contains("settings.ron")));
    let text = settings_text(&mine);
    assert_eq!(settings_text(&read_settings(&path).unwrap()), text, "as 'plumb run --settings' reads them");

    desk.stage.world().insert_resource(SolverSettings::default());
    desk.stage.act(SandboxAction::LoadSettings { path });
    assert_eq!(settings_text(desk.stage.world().resource::<SolverSettings>()), text);
}

#[test]
fn a_file_is_overwritten_only_when_told_so() {
    let mut desk = Desk::with(&balls(1));
    let path = desk.path("precious.ron");
    fs::write(&path, "precious").unwrap();
    desk.stage.act(SandboxAction::SaveSettings { path: path.clone(), overwrite: false });
    assert!(desk.refusal().contains("exists already"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    desk.stage.act(SandboxAction::SaveSettings { path: path.clone(), overwrite: true });
    assert!(read_settings(&path).is_ok());
    assert_eq!(desk.names(), ["precious.ron", "scene.ron"], "no draft is left");
}

#[test]
fn a_file_that_cannot_be_is_refused_in_one_line() {
    let mut desk = Desk::with(&balls(1));
    for path in [desk.path("no/such/folder/settings.ron"), desk.path(""), PathBuf::new()] {
        desk.stage.act(SandboxAction::SaveSettings { path: path.clone(), overwrite: true });
        let reason = desk.refusal();
        assert!(path == Path::new("") || reason.contains(path.to_str().unwrap()), "{reason}");
    }
    let before = *desk.stage.world().resource::<SolverSettings>();
    let missing = desk.path("missing.ron");
    desk.stage.act(SandboxAction::LoadSettings { path: missing });
    assert!(desk.refusal().contains("missing.ron"));
    let wrong = desk.path("wrong.ron");
    fs::write(&wrong, "(substeps: 0)").unwrap();
    desk.stage.act(SandboxAction::LoadSettings { path: wrong });
    assert!(desk.refusal().contains("wrong.ron:1:"));
    assert_eq!(*desk.stage.world().resource::<SolverSettings>(), before);
}

#[test]
fn a_mesh_that_changes_is_read_again() {
    let block = |height: f64| {
        let vertices = |y: f64| format!("v 0 {y} 0\nv 1 {y} 0\nv 1 {y} 1\nv 0 {y} 1\n");
        let faces = "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
        format!("{}{}{faces}", vertices(0.0), vertices(height))
    };
    let mut desk = Desk::with("()");
    fs::write(desk.path("block.obj"), block(1.0)).unwrap();
    desk.write(r#"(bodies: [(name: "block", shape: Mesh(file: "block.obj"))])"#);
    desk.wait();
    let volume = |desk: &mut Desk| {
        let block = desk.stage.body("block");
        desk.stage.world().get::<plumb::physics::Collider>(block).unwrap().volume()
    };
    assert!((volume(&mut desk) - 1.0).abs() < 1e-6);
    fs::write(desk.path("block.obj"), block(2.25)).unwrap();
    desk.wait();
    assert!((volume(&mut desk) - 2.25).abs() < 1e-6);
    fs::write(desk.path("block.obj"), "v 0 0 0\n").unwrap();
    desk.wait();
    assert!(desk.refusal().contains("block.obj"));
    assert!((volume(&mut desk) - 2.25).abs() < 1e-6);
    fs::write(desk.path("block.obj"), block(3.0)).unwrap();
    desk.wait();
    assert!((volume(&mut desk) - 3.0).abs() < 1e-6);
}

/// Every body's name, place and velocity, by name.
fn states(stage: &mut Stage) -> Vec<(String, DVec3, Velocity)> {
    let world = stage.world();
    let mut bodies = world.query_filtered::<(&Name, &Position, &Velocity), With<RigidBody>>();
    let mut states: Vec<_> = bodies.iter(world).map(|(name, x, v)| (name.to_string(), x.0, *v)).collect();
    states.sort_by(|a, b| a.0.cmp(&b.0));
    states
}

#[test]
fn a_scene_is_saved_as_it_stands_and_goes_on_from_there() {
    let mut desk = Desk::with(
        r#"(
            bodies: [
                (name: "ground", shape: HalfSpace),
                (name: "red", shape: Cuboid(size: (1, 1, 1)), color: (1, 0, 0), position: (0, 0.5, 0)),
                (name: "ball", shape: Sphere(radius: 0.4), position: (3, 2, 0), velocity: (0, 3, 0), restitution: 0.5),
            ],
            view: (eye: (0, 3, 12), target: (0, 2, 0)),
        )"#,
    );
    let stage = &mut desk.stage;
    let [red, ball] = ["red", "ball"].map(|name| stage.body(name));
    let hand = |entity, point| Some(Picked { entity, point, normal: None });
    *stage.world().resource_mut::<Selection>() =
        Selection { body: hand(ball, DVec3::ZERO), partner: hand(red, DVec3::new(0.5, 0.5, 0.0)), ..default() };
    stage.act(SandboxAction::JoinPicked);
    stage.act(SandboxAction::PinPicked);
    stage.act(SandboxAction::ChooseMesh { file: "plumb:gem.obj".into(), scale: 0.5, form: MeshForm::Hull });
    stage.act(SandboxAction::SpawnBody);
    stage.act(SandboxAction::ThrowBall);
    stage.frames(20);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    let (camera, before) = (stage.camera(), states(stage));

    let path = desk.path("saved.ron");
    desk.stage.act(SandboxAction::SaveScene { path: path.clone(), overwrite: false });
    assert!(matches!(desk.notice(), Notice::Info(text) if text.contains("saved.ron")), "{:?}", desk.notice());
    assert_eq!(desk.names(), ["saved.ron", "scene.ron"]);
    desk.stage.act(SandboxAction::TogglePause);
    desk.stage.frames(30);
    let later = states(&mut desk.stage);

    let scene = path.to_str().unwrap().to_owned();
    desk.stage.act(SandboxAction::TogglePause);
    desk.stage.act(SandboxAction::LoadScene { scene, parameters: Vec::new() });
    assert!(!matches!(desk.notice(), Notice::Error(_)), "{:?}", desk.notice());
    desk.stage.frames(2);
    let again = states(&mut desk.stage);
    assert_eq!(again.len(), before.len());
    for (now, then) in again.iter().zip(&before) {
        assert!(now.1.distance(then.1) < 1e-9 && now.2 == then.2, "{now:?} instead of {then:?}");
    }
    let world = desk.stage.world();
    assert_eq!(world.query::<&BallJoint>().iter(world).count(), 2);
    let red = desk.stage.body("red");
    assert_eq!(desk.stage.world().get::<BodyColor>(red), Some(&BodyColor([1.0, 0.0, 0.0])));
    let seen = desk.stage.camera();
    assert!(
        seen.translation.distance(camera.translation) < 1e-3 && seen.rotation.angle_between(camera.rotation) < 1e-3
    );

    desk.stage.act(SandboxAction::TogglePause);
    desk.stage.frames(30);
    // The forces that the solver starts from are not saved: impacts come out a little otherwise.
    for (now, then) in states(&mut desk.stage).iter().zip(&later) {
        assert!(now.1.distance(then.1) < 0.2, "{} goes to {} instead of {}", now.0, now.1, then.1);
    }
}

#[test]
fn a_scene_is_not_saved_over_another_unless_told_so() {
    let mut desk = Desk::with(&balls(2));
    let path = desk.path("precious.ron");
    fs::write(&path, "precious").unwrap();
    desk.stage.act(SandboxAction::SaveScene { path: path.clone(), overwrite: false });
    assert!(desk.refusal().contains("exists already"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    desk.stage.act(SandboxAction::SaveScene { path: path.clone(), overwrite: true });
    assert!(fs::read_to_string(&path).unwrap().contains("ball 1"));
    let nowhere = desk.path("no/such/folder/scene.ron");
    desk.stage.act(SandboxAction::SaveScene { path: nowhere, overwrite: false });
    assert!(desk.refusal().contains("no/such/folder"));
}

#[test]
fn a_scene_saved_over_its_own_file_is_not_read_again() {
    let mut desk = Desk::with(&balls(2));
    desk.stage.act(SandboxAction::SpawnBody);
    desk.stage.frames(20);
    let path = desk.path("scene.ron");
    desk.stage.act(SandboxAction::SaveScene { path, overwrite: true });
    let said = desk.notice();
    let height = desk.stage.position("ball 0").y;
    desk.wait();
    assert_eq!(desk.notice(), said, "it was not reloaded");
    assert!(desk.stage.position("ball 0").y < height - 1.0, "it goes on");
    desk.write(&balls(4));
    desk.wait();
    assert_eq!(desk.bodies(), 4, "but what somebody else writes is");
}
