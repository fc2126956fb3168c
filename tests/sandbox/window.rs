//! One real window: under Xvfb, drawn by a software Vulkan driver, used with xdotool, looked at
//! through the sandbox's own screenshots.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use bevy::math::Vec2;

use crate::picture::{NO_DRIVER, Picture, skip, software_driver};

/// A red limb on a grey trunk; nothing else in the picture is red.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", shape: HalfSpace),
        (name: "trunk", shape: Cuboid(size: (0.8, 0.5, 0.5)), mass: 10, position: (0, 0.25, 0), color: (0.5, 0.5, 0.5)),
        (name: "limb", shape: Sphere(radius: 0.3), mass: 3, position: (0.8, 0.3, 0), color: (1, 0, 0)),
    ],
    joints: [(body_a: "trunk", body_b: "limb", at: (0.45, 0.3, 0))],
    view: (eye: (0, 1.2, 5), target: (0, 0.7, 0)),
)"#;

/// Of the window.
const SIZE: [&str; 2] = ["800", "450"];

/// Where the panel may begin: at 334 of 800 pixels from the right.
const PANEL: f32 = 400.0;

/// Software rendering makes a few frames a second, and fewer while other tests run.
const PATIENCE: Duration = Duration::from_secs(180);
const MOMENT: Duration = Duration::from_millis(700);

#[test]
fn a_limb_is_dragged_in_a_real_window() {
    if let Some(reason) = missing() {
        return skip(&reason);
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.ron"), SCENE).unwrap();
    let display = Display::open();
    let mut sandbox = Sandbox::open(&display, folder.path());

    // The first frames are blank: shaders are still being compiled; in those after them the panel takes its place.
    let start = sandbox.wait_for_still_spot().expect("the limb is in the picture");
    let colors = sandbox.screenshot().distinct_colors();
    assert!(colors > 1000, "sky, ground, bodies in light and shade, and the panel have only {colors} colors");

    // Up and to the left, held there: by the point that was gripped, about which the limb turns as the trunk swings
    // below it. That point may come to lie on its rim.
    let goal = start + Vec2::new(-40.0, -110.0);
    let radius = sandbox.screenshot().red_radius(PANEL);
    sandbox.drag(start, goal);
    let held = sandbox.wait_for_spot(|spot| spot.distance(goal) < 1.25 * radius);
    assert!(held.is_some(), "the limb followed the pointer from {start} to {goal}; last seen at {:?}", sandbox.last);

    sandbox.xdotool(&["mouseup", "1"]);
    let fallen = sandbox.wait_for_spot(|spot| spot.y > goal.y + 50.0);
    assert!(fallen.is_some(), "let go, it falls; last seen at {:?}", sandbox.last);
}

#[test]
fn without_a_graphics_driver_one_line_says_so() {
    if let Some(reason) = missing() {
        return skip(&reason);
    }
    let display = Display::open();
    let output = Command::new(env!("CARGO_BIN_EXE_plumb"))
        .env("DISPLAY", &display.name)
        .env("XDG_CONFIG_HOME", "/nonexistent")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    crate::startup::assert_one_line(&output, &["no graphics driver", "plumb run"]);
}

/// What this machine lacks for a window, if anything.
fn missing() -> Option<String> {
    for program in ["Xvfb", "xdotool"] {
        if Command::new(program).arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err() {
            return Some(format!("{program} is not installed"));
        }
    }
    let driver = software_driver();
    driver.is_none().then(|| NO_DRIVER.into())
}

/// A screen nobody sees, closed when dropped.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// On a free number, which Xvfb finds and tells.
    fn open() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Self { server, name: format!(":{}", number.trim()) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The running program, ended when dropped.
struct Sandbox<'a> {
    program: Child,
    display: &'a Display,
    folder: &'a Path,
    shots: usize,
    /// Where the limb was last seen.
    last: Option<Vec2>,
}

impl<'a> Sandbox<'a> {
    fn open(display: &'a Display, folder: &'a Path) -> Self {
        let program = Command::new(env!("CARGO_BIN_EXE_plumb"))
            .arg("scene.ron")
            .current_dir(folder)
            .env("DISPLAY", &display.name)
            // What the user's own window is like is nobody's business here.
            .env("XDG_CONFIG_HOME", folder)
            .env("VK_DRIVER_FILES", software_driver().unwrap())
            .env("VK_ICD_FILENAMES", software_driver().unwrap())
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env_remove("WAYLAND_DISPLAY")
            .spawn()
            .unwrap();
        let mut sandbox = Self { program, display, folder, shots: 0, last: None };
        sandbox.wait_for_window();
        sandbox
    }

    fn wait_for_window(&mut self) {
        let begin = Instant::now();
        while !self.xdotool(&["search", "--onlyvisible", "--name", "^Plumb$"]) {
            assert!(begin.elapsed() < PATIENCE, "no window");
            assert!(self.program.try_wait().unwrap().is_none(), "the sandbox ended");
            sleep(MOMENT);
        }
        // A quarter of the pixels, for the software renderer's sake.
        let [width, height] = SIZE;
        self.xdotool(&["search", "--onlyvisible", "--name", "^Plumb$", "windowfocus", "windowsize", width, height]);
        // What it is on in the panel would be told over the picture.
        self.xdotool(&["mousemove", "300", "100"]);
    }

    /// Runs xdotool on the display; tells whether it succeeded.
    fn xdotool(&self, arguments: &[&str]) -> bool {
        let mut command = Command::new("xdotool");
        command.args(arguments).env("DISPLAY", &self.display.name).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().unwrap().success()
    }

    /// Presses the button at one place and moves to another, slowly enough for every stage of it
    /// to be seen by a frame.
    fn drag(&self, from: Vec2, to: Vec2) {
        let go = |place: Vec2| {
            self.xdotool(&["mousemove", &place.x.round().to_string(), &place.y.round().to_string()]);
            sleep(MOMENT);
        };
        go(from - Vec2::splat(3.0));
        go(from);
        sleep(MOMENT);
        self.xdotool(&["mousedown", "1"]);
        sleep(2 * MOMENT);
        for i in 1..=4 {
            go(from.lerp(to, i as f32 / 4.0));
        }
    }

    /// Takes screenshots until one shows the limb as it should be.
    fn wait_for_spot(&mut self, is_there: impl Fn(Vec2) -> bool) -> Option<Vec2> {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            self.last = self.screenshot().red_spot(PANEL);
            if let Some(spot) = self.last.filter(|&spot| is_there(spot)) {
                return Some(spot);
            }
        }
        None
    }

    /// Takes screenshots until two after each other show the limb at one place.
    fn wait_for_still_spot(&mut self) -> Option<Vec2> {
        let mut before = self.wait_for_spot(|_| true)?;
        loop {
            let spot = self.wait_for_spot(|_| true)?;
            if spot.distance(before) < 1.0 {
                return Some(spot);
            }
            before = spot;
        }
    }

    /// Presses the key for a screenshot until there is one more. A key that comes before the
    /// first frame is lost.
    fn screenshot(&mut self) -> Picture {
        self.shots += 1;
        let path = self.folder.join(format!("plumb-{}.png", self.shots));
        let begin = Instant::now();
        loop {
            if !path.exists() {
                self.xdotool(&["key", "p"]);
            }
            for _ in 0..10 {
                sleep(MOMENT / 2);
                if let Some(picture) = Picture::read(&path) {
                    // The key may have been pressed once too often.
                    while self.folder.join(format!("plumb-{}.png", self.shots + 1)).exists() {
                        self.shots += 1;
                    }
                    return picture;
                }
            }
            assert!(self.program.try_wait().unwrap().is_none(), "the sandbox ended");
            assert!(begin.elapsed() < PATIENCE, "no screenshot");
        }
    }
}

impl Drop for Sandbox<'_> {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
