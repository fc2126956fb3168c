//! Which key does what.

use bevy::prelude::*;

use super::SandboxAction;

/// A key and what it does.
pub struct Binding {
    /// Any of these keys.
    pub keys: &'static [KeyCode],
    /// The keys as the help names them.
    pub label: &'static str,
    /// What it does, as the help says it.
    pub about: &'static str,
    /// The action.
    pub action: SandboxAction,
}

/// The keys, in the order of the help.
pub const BINDINGS: &[Binding] = &[
    Binding { keys: &[KeyCode::Space], label: "Space", about: "play or pause", action: SandboxAction::TogglePause },
    Binding {
        keys: &[KeyCode::Period, KeyCode::KeyN],
        label: ". or N",
        about: "one step",
        action: SandboxAction::StepOnce,
    },
    Binding { keys: &[KeyCode::KeyM], label: "M", about: "slow motion", action: SandboxAction::ToggleSlowMotion },
    Binding { keys: &[KeyCode::KeyR], label: "R", about: "reset the scene", action: SandboxAction::Reset },
    Binding { keys: &[KeyCode::KeyB], label: "B", about: "throw a ball", action: SandboxAction::ThrowBall },
    Binding {
        keys: &[KeyCode::Delete, KeyCode::KeyX],
        label: "Delete or X",
        about: "delete the picked body",
        action: SandboxAction::DeletePicked,
    },
    Binding { keys: &[KeyCode::KeyF], label: "F", about: "frame the scene", action: SandboxAction::FrameScene },
    Binding {
        keys: &[KeyCode::F12, KeyCode::KeyP],
        label: "F12 or P",
        about: "screenshot to plumb-N.png",
        action: SandboxAction::Screenshot,
    },
    Binding {
        keys: &[KeyCode::KeyH, KeyCode::F1],
        label: "H or F1",
        about: "this help",
        action: SandboxAction::ToggleHelp,
    },
    Binding { keys: &[KeyCode::Escape], label: "Esc", about: "unpick, close the help", action: SandboxAction::Escape },
];

/// What the mouse does, as the help says it.
pub const MOUSE: &[(&str, &str)] = &[
    ("left button", "pick a body and drag it"),
    ("wheel while dragging", "nearer or farther"),
    ("right button", "orbit"),
    ("middle button", "pan"),
    ("wheel", "zoom"),
];

pub(super) fn plugin(_app: &mut App) {}
