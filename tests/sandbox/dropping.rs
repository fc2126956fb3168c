//! Files that are dragged onto the window.

use std::fs;
use std::path::{Path, PathBuf};

use bevy::window::FileDragAndDrop;
use plumb::sandbox::{Blueprint, CurrentScene, Notice, Page, RecentFiles, Tool};
use plumb::scene::ShapeSpec;

use crate::eyes::{open_eyes, reads};
use crate::stage::Stage;

const SCENE: &str = r#"(bodies: [(name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10)])"#;
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

/// Lets all go over the window in one frame.
fn drop_files(stage: &mut Stage, files: &[PathBuf]) {
    let window = stage.window();
    for path_buf in files.iter().cloned() {
        stage.world().write_message(FileDragAndDrop::DroppedFile { window, path_buf });
    }
    stage.frames(2);
}

fn scene(stage: &mut Stage) -> PathBuf {
    stage.world().resource::<CurrentScene>().scene.clone().into()
}

fn error(stage: &mut Stage) -> Option<String> {
    match stage.world().resource::<Notice>() {
        Notice::Error(said) => Some(said.clone()),
        _ => None,
    }
}

#[test]
fn a_scene_and_a_recording_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::open(SCENE);
    stage.frames(5);
    let recording = folder.path().join("run.plumb");
    stage.record().write(&recording).unwrap();
    let other = file(folder.path(), "other.ron", SCENE);
    for path in [other, recording] {
        drop_files(&mut stage, std::slice::from_ref(&path));
        assert_eq!(error(&mut stage), None);
        assert_eq!(scene(&mut stage), path);
        assert_eq!(stage.world().resource::<RecentFiles>().0[0], path.to_str().unwrap());
    }
}

#[test]
fn a_mesh_is_in_hand() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::open(SCENE);
    let before = scene(&mut stage);
    let broken = file(folder.path(), "broken.obj", "v 0 0\n");
    drop_files(&mut stage, &[broken]);
    assert!(error(&mut stage).is_some_and(|said| said.contains("broken.obj")));
    assert_eq!(*stage.world().resource::<Tool>(), Tool::Drag, "nothing to add");

    let mesh = file(folder.path(), "corner.obj", MESH);
    drop_files(&mut stage, &[mesh]);
    assert_eq!(error(&mut stage), None);
    assert_eq!(*stage.world().resource::<Tool>(), Tool::Add);
    let shape = &stage.world().resource::<Blueprint>().shape;
    assert!(matches!(shape, ShapeSpec::Mesh(mesh) if mesh.file().ends_with("corner.obj")), "{shape:?}");
    assert_eq!(scene(&mut stage), before);
}

#[test]
fn what_cannot_be_opened_is_told_and_of_many_files_one_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::open(SCENE);
    let before = scene(&mut stage);
    let photo = file(folder.path(), "photo.jpg", "");
    drop_files(&mut stage, std::slice::from_ref(&photo));
    assert!(error(&mut stage).is_some_and(|said| said.contains("photo.jpg") && said.contains(".obj")));
    assert_eq!(scene(&mut stage), before);

    let [one, two] = ["one.ron", "two.ron"].map(|name| file(folder.path(), name, SCENE));
    drop_files(&mut stage, &[photo, one.clone(), two]);
    assert_eq!(scene(&mut stage), one);
}

#[test]
fn what_would_come_of_it_is_told_before() {
    let mut stage = Stage::open(SCENE);
    open_eyes(&mut stage, Page::Play);
    let window = stage.window();
    for (name, said) in [
        ("a.ron", "drop to open the scene a.ron"),
        ("a.plumb", "drop to play the recording a.plumb"),
        ("a.obj", "drop to build with the mesh a.obj"),
        ("a.zip", "a.zip: no scene"),
    ] {
        stage.world().write_message(FileDragAndDrop::HoveredFile { window, path_buf: name.into() });
        stage.frames(2);
        assert!(reads(&mut stage, said), "{said}");
        stage.world().write_message(FileDragAndDrop::HoveredFileCanceled { window });
        stage.frames(2);
        assert!(!reads(&mut stage, said), "{said}");
    }
}
