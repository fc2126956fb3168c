//! Scenes as pictures, and files that were opened or saved.

use std::fs;

use bevy::math::Vec2;
use plumb::sandbox::{CurrentScene, Notice, Page, RecentFiles, SandboxAction};

use crate::eyes::{click_on, open_eyes, reads, rewrite, texts};
use crate::stage::Stage;

const SCENE: &str = r#"(bodies: [(name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10)])"#;
const SEARCH: &str = "🔍 find a scene";

fn scene(stage: &mut Stage) -> String {
    stage.world().resource::<CurrentScene>().scene.clone()
}

fn gallery() -> Stage {
    let mut stage = Stage::open(SCENE);
    open_eyes(&mut stage, Page::Play);
    stage
}

/// Whether there is a tile of that title.
fn shows(stage: &mut Stage, title: &str) -> bool {
    texts(stage).iter().any(|(text, _)| text == title)
}

#[test]
fn a_click_on_a_picture_opens_its_scene() {
    let mut stage = gallery();
    assert!(shows(&mut stage, "Pendulum") && !shows(&mut stage, "Arch"), "one subject at a time");
    click_on(&mut stage, "Pendulum", "Gallery");
    assert_eq!(scene(&mut stage), "pendulum");
    click_on(&mut stage, "Friction", "Gallery");
    assert!(!shows(&mut stage, "Heavy ball on a chain"));
    click_on(&mut stage, "Arch", "Gallery");
    assert_eq!(scene(&mut stage), "arch");
    click_on(&mut stage, "All", "Gallery");
    assert!(shows(&mut stage, "Heavy ball on a chain") && shows(&mut stage, "Spinning top"));
}

#[test]
fn a_picture_lies_above_its_title() {
    let mut stage = gallery();
    let title = crate::eyes::seen(&mut stage, "Pendulum", "Gallery");
    crate::eyes::click(&mut stage, title - Vec2::new(0.0, 40.0));
    assert_eq!(scene(&mut stage), "pendulum");
}

#[test]
fn the_subject_of_a_scene_that_is_asked_for_elsewhere_is_on_view() {
    let mut stage = gallery();
    stage.act(SandboxAction::LoadScene { scene: "car".into(), parameters: Vec::new() });
    stage.frames(3);
    assert!(shows(&mut stage, "Robot arm") && !shows(&mut stage, "Pendulum"));
}

#[test]
fn typing_finds_scenes_of_all_subjects_and_enter_opens_the_first() {
    let mut stage = gallery();
    // Others have balls as well, but are not called so.
    rewrite(&mut stage, SEARCH, "Gallery", "ball");
    assert_eq!(scene(&mut stage), "chain", "a heavy ball on a chain");
    rewrite(&mut stage, "ball", "Gallery", "newton");
    assert_eq!(scene(&mut stage), "cradle");
    assert!(shows(&mut stage, "Newton's cradle") && !shows(&mut stage, "Bouncing balls"));
    rewrite(&mut stage, "newton", "Gallery", "no such thing");
    assert_eq!(scene(&mut stage), "cradle", "nothing is opened where nothing is found");
    assert!(reads(&mut stage, "no scene has this"));
    click_on(&mut stage, "✖", "Gallery");
    assert!(shows(&mut stage, "Bouncing balls"), "the scene's subject again");
}

#[test]
fn files_that_were_opened_or_saved_are_yours_until_they_are_gone() {
    let folder = tempfile::tempdir().unwrap();
    let [mine, saved] = ["mine.ron", "saved.ron"].map(|name| folder.path().join(name));
    fs::write(&mine, SCENE).unwrap();
    let mut stage = gallery();
    let file = mine.to_str().unwrap().to_owned();
    stage.act(SandboxAction::LoadScene { scene: file.clone(), parameters: Vec::new() });
    stage.act(SandboxAction::LoadScene { scene: "pendulum".into(), parameters: Vec::new() });
    stage.act(SandboxAction::SaveScene { path: saved.clone(), overwrite: false });
    let newest: Vec<String> = stage.world().resource::<RecentFiles>().0.iter().take(2).cloned().collect();
    assert_eq!(newest, [saved.to_str().unwrap(), &file]);

    click_on(&mut stage, "Yours", "Gallery");
    assert!(shows(&mut stage, "saved") && !shows(&mut stage, "Chain of rods"));
    click_on(&mut stage, "mine", "Gallery");
    assert_eq!(scene(&mut stage), file);
    fs::remove_file(&saved).unwrap();
    click_on(&mut stage, "saved", "Gallery");
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Error(said) if said.contains("saved.ron")));
    assert_eq!(scene(&mut stage), file);
    assert!(!shows(&mut stage, "saved") && shows(&mut stage, "mine"));
}
