//! What a user is told where no window can be opened.

use std::process::{Command, Output};

/// The sandbox without the display servers of whoever runs the tests.
fn plumb() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plumb"));
    command
        .env("XDG_CONFIG_HOME", "/nonexistent")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET");
    command
}

/// Exit status 2, and one line on standard error with these words in it.
pub fn assert_one_line(output: &Output, words: &[&str]) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "one line:\n{said}");
    for word in words {
        assert!(said.contains(word), "'{word}' in: {said}");
    }
    assert!(output.stdout.is_empty());
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_one_line_says_so() {
    assert_one_line(&plumb().output().unwrap(), &["no display", "plumb run"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_display_that_is_not_there_is_none() {
    let output = plumb().env("DISPLAY", ":9876").output().unwrap();
    assert_one_line(&output, &["no display", "plumb run"]);
}

#[test]
fn an_unknown_scene_is_said_before_any_window_opens() {
    assert_one_line(&plumb().arg("no-such-scene").output().unwrap(), &["no-such-scene"]);
}
