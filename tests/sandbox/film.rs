//! Films, drawn off screen by the program itself.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output};

use bevy::math::{UVec2, Vec2};
use plumb::sandbox::SandboxAction;

use crate::picture::{NO_DRIVER, Picture, skip, software_driver};
use crate::stage::Stage;
use crate::startup::assert_one_line;

/// A red ball that falls for half a second, before anything else.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", shape: HalfSpace),
        (name: "ball", shape: Sphere(radius: 0.3), position: (0, 2, 0), color: (1, 0, 0)),
    ],
    view: (eye: (0, 1.2, 5), target: (0, 1.2, 0)),
)"#;

const SIZE: UVec2 = UVec2::new(320, 180);

/// Runs `plumb film` in a folder, drawn in software where that can be had.
fn film(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plumb"));
    command.arg("film").args(arguments).args(["--size", "320x180"]).current_dir(folder);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    // Mesa's choice of a device asks for a display, and complains where there is none.
    command.env("NODEVICE_SELECT", "1");
    if let Some(driver) = software_driver() {
        command.env("VK_DRIVER_FILES", &driver).env("VK_ICD_FILENAMES", &driver);
    }
    command.output().unwrap()
}

/// The same, without a complaint.
fn films(folder: &Path, arguments: &[&str]) -> String {
    let output = film(folder, arguments);
    assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments:?}");
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

/// A folder with the scene in it; none where nothing can be drawn.
fn stage_set() -> Option<tempfile::TempDir> {
    if software_driver().is_none() {
        skip(NO_DRIVER);
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.ron"), SCENE).unwrap();
    Some(folder)
}

/// Where the ball is seen, pixels.
fn seen(path: &Path) -> Vec2 {
    let picture = Picture::read(path).unwrap_or_else(|| panic!("{} is a picture", path.display()));
    assert_eq!(picture.size(), SIZE);
    assert!(picture.distinct_colors() > 500, "sky, ground, light and shade");
    picture.red_spot(SIZE.x as f32).expect("the ball is in the picture")
}

#[test]
fn frames_show_the_scene_at_their_times() {
    let Some(folder) = stage_set() else { return };
    let folder = folder.path();
    let said = films(folder, &["scene.ron", "--seconds", "0.5", "--fps", "10", "--out", "frames"]);
    assert!(said.contains("5 pictures of 320 x 180 pixels"), "{said}");
    let names: Vec<_> = fs::read_dir(folder.join("frames")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 5);
    let frame = |n: usize| folder.join(format!("frames/frame-{n:05}.png"));
    // It is seen from 5 m, the picture is as wide as 45 degrees are high times 16/9: pixels a metre.
    let scale = f64::from(SIZE.y) / (2.0 * 22.5_f64.to_radians().tan() * 5.0);
    let start = seen(&frame(1));
    let falls = |t: f64, place: Vec2| {
        let fallen = f64::from(place.y - start.y) / scale;
        let expected = 0.5 * 9.81 * t * t;
        assert!((fallen - expected).abs() < 0.03, "at {t} s it has fallen {fallen} m, not {expected}");
    };
    for n in 1..=5 {
        falls((n - 1) as f64 / 10.0, seen(&frame(n)));
    }
    // Between two steps as well: four eleventh of a second are 21.8 steps.
    films(folder, &["scene.ron", "--from", "0.3636363636", "--seconds", "0.1", "--fps", "10", "--out", "between"]);
    falls(4.0 / 11.0, seen(&folder.join("between/frame-00001.png")));
    // The end alone, which is the start of what comes after.
    films(folder, &["scene.ron", "--seconds", "0.4", "--out", "end.png"]);
    assert_eq!(seen(&folder.join("end.png")), seen(&frame(5)));
    films(folder, &["scene.ron", "--from", "0.4", "--seconds", "0.1", "--fps", "10", "--out", "later"]);
    assert_eq!(seen(&folder.join("later/frame-00001.png")), seen(&frame(5)));
}

#[test]
fn a_gif_takes_as_long_as_what_it_shows() {
    let Some(folder) = stage_set() else { return };
    films(folder.path(), &["scene.ron", "--seconds", "0.5", "--fps", "30", "--out", "film.gif"]);
    let mut decoder = gif::DecodeOptions::new().read_info(File::open(folder.path().join("film.gif")).unwrap()).unwrap();
    assert_eq!([decoder.width(), decoder.height()], [320, 180]);
    let (mut frames, mut hundredths) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        frames += 1;
        hundredths += u32::from(frame.delay);
    }
    assert_eq!((frames, hundredths), (15, 50));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "the scene and the film, and nothing beside them");
}

#[test]
fn a_recording_is_filmed_with_all_that_was_done() {
    let Some(folder) = stage_set() else { return };
    let mut stage = Stage::open(SCENE);
    stage.act(SandboxAction::Reset);
    stage.frames(10);
    let untouched = stage.record();
    untouched.write(&folder.path().join("untouched.plumb")).unwrap();
    let ball = stage.body("ball");
    stage.world().get_mut::<plumb::physics::Velocity>(ball).unwrap().linear.x = 3.0;
    stage.frames(15);
    stage.record().write(&folder.path().join("pushed.plumb")).unwrap();
    let folder = folder.path();
    let end = |file: &str, seconds: &str| {
        films(folder, &[file, "--seconds", seconds, "--out", "end.png"]);
        fs::read(folder.join("end.png")).unwrap()
    };
    assert_eq!(end("untouched.plumb", "0.1"), end("scene.ron", "0.1"));
    let before = end("pushed.plumb", "0.1");
    assert_eq!(before, end("scene.ron", "0.1"), "it had not been pushed then");
    end("pushed.plumb", "0.4");
    let pushed = seen(&folder.join("end.png"));
    end("scene.ron", "0.4");
    let fallen = seen(&folder.join("end.png"));
    assert!(pushed.x - fallen.x > 20.0, "{pushed} {fallen}");
    assert!((pushed.y - fallen.y).abs() < 3.0, "{pushed} {fallen}");
}

#[test]
fn what_cannot_be_filmed_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.ron"), SCENE).unwrap();
    fs::write(folder.join("a.plumb"), "").unwrap();
    for (arguments, words) in [
        (&["no-such", "--out", "a.png"][..], &["no-such"][..]),
        (&["a.plumb", "--out", "a.png"], &["a.plumb", "no recording"]),
        (&["a.plumb", "--preset", "game", "--out", "a.png"], &["a.plumb", "its own"]),
        (&["scene.ron", "--out", "no/such/folder/a.png"], &["no/such/folder/a.png", "written"]),
        (&["scene.ron", "--out", "scene.ron/a"], &["scene.ron/a", "written"]),
        (&["scene.ron", "--fps", "0", "--out", "a.png"], &["--fps"]),
        (&["scene.ron", "--out", "a.mp4"], &["a.mp4", ".gif"]),
    ] {
        assert_one_line(&film(folder, arguments), words);
    }
    assert_one_line(
        &Command::new(env!("CARGO_BIN_EXE_plumb"))
            .args(["film", "limbs", "--out"])
            .arg(folder.join("a.png"))
            .env("NODEVICE_SELECT", "1")
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .output()
            .unwrap(),
        &["no graphics driver"],
    );
    assert_eq!(fs::read_dir(folder).unwrap().count(), 2, "nothing is left behind");
}
