//! What the window remembers from one time to the next.

use std::fs;
use std::path::Path;

use bevy::prelude::*;
use bevy::window::WindowResized;
use bevy_panorbit_camera::PanOrbitCamera;
use plumb::sandbox::{
    InterfaceScale, MemoryFile, Notice, Page, PanelOpen, PanelWidth, RecentFiles, SandboxAction, ScaleChange,
    ShowsPlots,
};

use crate::stage::Stage;

const SCENE: &str = r#"(bodies: [(name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10)])"#;

/// The sandbox as `launch` opens it, but for its window.
fn open(file: &Path) -> Stage {
    let mut stage = Stage::open(SCENE);
    MemoryFile::read(file).put_in(&mut stage.app);
    stage
}

fn load(stage: &mut Stage, scene: &str) {
    stage.act(SandboxAction::LoadScene { scene: scene.into(), parameters: Vec::new() });
    stage.frames(5);
}

fn close(stage: &mut Stage) {
    stage.world().write_message(AppExit::Success);
    stage.frames(1);
}

#[test]
fn what_was_chosen_is_there_the_next_time() {
    let folder = tempfile::tempdir().unwrap();
    // Neither the file nor its folder is there yet.
    let file = folder.path().join("plumb/window.ron");
    let mine = folder.path().join("mine.ron");
    fs::write(&mine, SCENE).unwrap();
    let mut stage = open(&file);
    assert!(!file.exists());
    let window = stage.window();
    stage.world().entity_mut(window).get_mut::<Window>().unwrap().resolution.set(1600.0, 900.0);
    stage.world().write_message(WindowResized { window, width: 1600.0, height: 900.0 });
    load(&mut stage, mine.to_str().unwrap());
    stage.world().insert_resource(Page::Solver);
    stage.world().insert_resource(PanelWidth(400.0));
    stage.act(SandboxAction::TogglePlots);
    stage.act(SandboxAction::ScaleInterface(ScaleChange::Larger));
    close(&mut stage);

    let file = MemoryFile::read(&file);
    assert_eq!(file.memory().size, [1600.0, 900.0]);
    let mut stage = Stage::open(SCENE);
    file.put_in(&mut stage.app);
    stage.frames(3);
    let world = stage.world();
    assert_eq!(*world.resource::<Page>(), Page::Solver);
    assert_eq!(*world.resource::<PanelWidth>(), PanelWidth(400.0));
    assert_eq!(*world.resource::<PanelOpen>(), PanelOpen(true));
    assert_eq!(*world.resource::<ShowsPlots>(), ShowsPlots(true));
    assert_eq!(*world.resource::<InterfaceScale>(), InterfaceScale(110));
    assert_eq!(world.resource::<RecentFiles>().0[0], mine.to_str().unwrap());
}

#[test]
fn it_is_written_soon_after_a_change_and_at_no_other_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.ron");
    let mut stage = open(&file);
    stage.frames(150);
    assert!(!fs::read_to_string(&file).is_ok_and(|text| text.contains("Analyse")));
    stage.world().insert_resource(Page::Analyse);
    stage.frames(70);
    assert!(fs::read_to_string(&file).unwrap().contains("Analyse"), "nobody has closed the window");
    fs::remove_file(&file).unwrap();
    stage.frames(150);
    assert!(!file.exists(), "nothing has changed");
}

#[test]
fn the_camera_is_where_it_was_left_before_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.ron");
    let mut stage = open(&file);
    load(&mut stage, "pendulum");
    let framed = stage.camera().translation;
    let world = stage.world();
    let mut camera = world.query::<&mut PanOrbitCamera>().single_mut(world).unwrap();
    camera.target_radius *= 2.0;
    stage.frames(120);
    let left = stage.camera().translation;
    assert!(left.distance(framed) > 0.5);
    close(&mut stage);

    // As at the start: the scene comes with the first frame.
    for (scene, is_back) in [("pendulum", true), ("arch", false)] {
        let mut hands = plumb::sandbox::Hands::open(UVec2::new(1280, 720));
        MemoryFile::read(&file).put_in(&mut hands.app);
        hands.act(SandboxAction::LoadScene { scene: scene.into(), parameters: Vec::new() });
        hands.frames(30);
        let world = hands.world();
        let camera = world.query_filtered::<&Transform, With<Camera3d>>().single(world).unwrap().translation;
        assert_eq!(camera.distance(left) < 1e-3, is_back, "{scene}: {camera}, was {left}");
        assert!(world.resource::<RecentFiles>().0.is_empty(), "built-in scenes are no files");
    }
}

#[test]
fn a_broken_file_and_one_that_cannot_be_written_are_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.ron");
    fs::write(&file, "(page: Sol").unwrap();
    let mut stage = open(&file);
    stage.frames(3);
    let said = |stage: &mut Stage| match stage.world().resource::<Notice>() {
        Notice::Error(said) => said.clone(),
        other => panic!("{other:?}"),
    };
    let broken = said(&mut stage);
    assert!(broken.contains("window.ron") && !broken.contains('\n'), "{broken}");
    assert_eq!(*stage.world().resource::<Page>(), Page::Play);

    // A file stands where the folder would be.
    let mut stage = open(&file.join("window.ron"));
    stage.world().insert_resource(Page::Build);
    stage.frames(70);
    assert!(said(&mut stage).contains("cannot be"), "told");
    stage.world().insert_resource(Notice::None);
    stage.world().insert_resource(Page::Solver);
    stage.frames(70);
    assert_eq!(*stage.world().resource::<Notice>(), Notice::None, "once");
}
