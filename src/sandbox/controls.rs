//! Which key does what.

use std::collections::HashSet;

use bevy::input::keyboard::{KeyboardFocusLost, KeyboardInput};
use bevy::input::{ButtonState, InputSystems};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;

use super::state::{CONTROL_KEYS, DrivingKeys, SHIFT_KEYS};
use super::{SandboxAction, ScaleChange, Tool};

/// Keys and what they do.
pub struct Binding {
    /// Any of these keys.
    pub keys: &'static [KeyCode],
    /// Whether Ctrl (or ⌘) is held with it; without, it must not be.
    pub with_control: bool,
    /// Whether Shift is held with it; without, it may be.
    pub with_shift: bool,
    /// The keys as the help names them.
    pub label: &'static str,
    /// What they do, as the help says it.
    pub about: &'static str,
    /// The action.
    pub action: SandboxAction,
}

const fn binding(keys: &'static [KeyCode], label: &'static str, about: &'static str, action: SandboxAction) -> Binding {
    Binding { keys, with_control: false, with_shift: false, label, about, action }
}

impl Binding {
    const fn with_control(mut self) -> Self {
        self.with_control = true;
        self
    }

    const fn with_shift(mut self) -> Self {
        self.with_shift = true;
        self
    }
}

const LARGER: SandboxAction = SandboxAction::ScaleInterface(ScaleChange::Larger);
const SMALLER: SandboxAction = SandboxAction::ScaleInterface(ScaleChange::Smaller);
const NORMAL: SandboxAction = SandboxAction::ScaleInterface(ScaleChange::Normal);

/// The keys, in the order of the help.
pub const BINDINGS: &[Binding] = &[
    binding(&[KeyCode::Space], "Space", "play or pause", SandboxAction::TogglePause),
    binding(&[KeyCode::Period, KeyCode::KeyN], ". or N", "one step", SandboxAction::StepOnce),
    binding(&[KeyCode::Comma], ",", "one step back", SandboxAction::StepBack),
    binding(&[KeyCode::KeyU], "U", "play backwards", SandboxAction::TogglePlayBackwards),
    binding(&[KeyCode::Home], "Home", "back to the first moment that is kept", SandboxAction::GoToStart),
    binding(&[KeyCode::End], "End", "on to the last moment that there was", SandboxAction::GoToNow),
    binding(&[KeyCode::KeyK], "K", "mark this moment, or take its mark away", SandboxAction::ToggleMark),
    binding(&[KeyCode::KeyL], "L", "loop between the two marks around this moment", SandboxAction::ToggleLoop),
    binding(&[KeyCode::KeyM], "M", "slow motion", SandboxAction::ToggleSlowMotion),
    binding(&[KeyCode::KeyR], "R", "reset the scene", SandboxAction::Reset),
    binding(&[KeyCode::KeyR], "Ctrl+R", "record what happened to plumb-N.plumb", SandboxAction::Record).with_control(),
    binding(&[KeyCode::Digit1], "1", "drag: pick and drag bodies", SandboxAction::ChooseTool(Tool::Drag)),
    binding(&[KeyCode::Digit2], "2", "push: kick what is clicked", SandboxAction::ChooseTool(Tool::Push)),
    binding(&[KeyCode::Digit3], "3", "throw: a ball at each click", SandboxAction::ChooseTool(Tool::Throw)),
    binding(&[KeyCode::Digit4], "4", "add: a body at each click", SandboxAction::ChooseTool(Tool::Add)),
    binding(&[KeyCode::Digit5], "5", "bar: drawn from end to end, on hinges", SandboxAction::ChooseTool(Tool::Bar)),
    binding(&[KeyCode::Digit6], "6", "join: two clicks", SandboxAction::ChooseTool(Tool::Join)),
    binding(&[KeyCode::Digit7], "7", "pin: what is clicked, to the world", SandboxAction::ChooseTool(Tool::Pin)),
    binding(&[KeyCode::Digit8], "8", "cut: the joint that is clicked", SandboxAction::ChooseTool(Tool::Cut)),
    binding(&[KeyCode::Digit9], "9", "measure: two clicks", SandboxAction::ChooseTool(Tool::Measure)),
    binding(&[KeyCode::KeyT], "T", "move what is picked, by handles", SandboxAction::ChooseTool(Tool::Move)),
    binding(&[KeyCode::KeyE], "E", "turn it, by rings", SandboxAction::ChooseTool(Tool::Turn)),
    binding(&[KeyCode::KeyS], "S", "scale it, by boxes", SandboxAction::ChooseTool(Tool::Scale)),
    binding(&[KeyCode::KeyB], "B", "throw a ball at the pointer", SandboxAction::ThrowBall),
    binding(&[KeyCode::KeyA], "A", "add a body at the pointer", SandboxAction::SpawnBody),
    binding(&[KeyCode::KeyJ], "J", "join the two picked bodies", SandboxAction::JoinPicked),
    binding(&[KeyCode::KeyW], "W", "pin the picked body to the world", SandboxAction::PinPicked),
    binding(&[KeyCode::KeyC], "C", "cut the joint at the pointer", SandboxAction::CutPicked),
    binding(&[KeyCode::Delete, KeyCode::KeyX], "Del or X", "delete what is picked", SandboxAction::DeletePicked),
    binding(&[KeyCode::KeyD], "Ctrl+D", "duplicate what is picked", SandboxAction::Duplicate).with_control(),
    binding(&[KeyCode::KeyC], "Ctrl+C", "copy it, as text of a scene file", SandboxAction::Copy).with_control(),
    binding(&[KeyCode::KeyX], "Ctrl+X", "copy it and delete it", SandboxAction::CutOut).with_control(),
    binding(&[KeyCode::KeyV], "Ctrl+V", "paste at the pointer", SandboxAction::Paste).with_control(),
    binding(&[KeyCode::KeyG], "Ctrl+G", "make one body of what is picked", SandboxAction::MakeOneBody).with_control(),
    binding(&[KeyCode::KeyG], "Ctrl+Shift+G", "take it apart", SandboxAction::TakeApart).with_control().with_shift(),
    binding(&[KeyCode::KeyA], "Ctrl+A", "pick all bodies", SandboxAction::SelectAll).with_control(),
    binding(&[KeyCode::KeyZ], "Ctrl+Z", "undo what was built, changed or cut", SandboxAction::Undo).with_control(),
    binding(&[KeyCode::KeyY], "Ctrl+Y", "redo what was undone", SandboxAction::Redo).with_control(),
    binding(&[KeyCode::KeyZ], "Ctrl+Shift+Z", "the same", SandboxAction::Redo).with_control().with_shift(),
    binding(&[KeyCode::KeyG], "G", "show or hide the plots", SandboxAction::TogglePlots),
    binding(&[KeyCode::KeyF], "F", "frame the scene", SandboxAction::FrameScene),
    binding(&[KeyCode::KeyV], "V", "follow the picked body, or stay", SandboxAction::Follow),
    binding(&[KeyCode::F12, KeyCode::KeyP], "F12 or P", "screenshot to plumb-N.png", SandboxAction::Screenshot),
    binding(&[KeyCode::Equal, KeyCode::NumpadAdd], "Ctrl++", "a larger interface", LARGER).with_control(),
    binding(&[KeyCode::Minus, KeyCode::NumpadSubtract], "Ctrl+-", "a smaller interface", SMALLER).with_control(),
    binding(&[KeyCode::Digit0, KeyCode::Numpad0], "Ctrl+0", "the interface at 100 %", NORMAL).with_control(),
    binding(&[KeyCode::KeyH, KeyCode::F1], "H or F1", "this help", SandboxAction::ToggleHelp),
    binding(&[KeyCode::Escape], "Esc", "unpick, put the tool down, close the help", SandboxAction::Escape),
];

/// What the mouse does, as the help says it.
pub const MOUSE: &[(&str, &str)] = &[
    ("left button", "pick a body and drag it"),
    ("left button beside all", "draw a box around bodies to pick them"),
    ("left click on a joint", "pick it, where its body is picked or joints are shown"),
    ("Shift + left button", "pick more"),
    ("wheel while dragging", "farther or nearer"),
    ("Ctrl with a handle", "to the grid, or not where that is switched on"),
    ("right button", "orbit"),
    ("right click", "plot, trail or measure what is there"),
    ("middle button", "pan"),
    ("wheel", "zoom"),
];

pub(super) fn plugin(app: &mut App) {
    app.add_systems(PreUpdate, read_keys.after(InputSystems));
}

/// Presses in their order: in a slow frame, Ctrl and a key may both be up again. A key that drives a motor does nothing
/// else; with Ctrl it drives none.
fn read_keys(
    mut inputs: MessageReader<KeyboardInput>,
    mut lost: MessageReader<KeyboardFocusLost>,
    mut held: Local<HashSet<KeyCode>>,
    egui: Res<EguiWantsInput>,
    driving: Res<DrivingKeys>,
    mut actions: MessageWriter<SandboxAction>,
) {
    for &KeyboardInput { key_code: key, state, repeat, .. } in inputs.read() {
        match state {
            ButtonState::Released => _ = held.remove(&key),
            ButtonState::Pressed if is_modifier(&key) => _ = held.insert(key),
            ButtonState::Pressed if repeat || egui.wants_any_keyboard_input() => {}
            ButtonState::Pressed => {
                let [control, shift] =
                    [&CONTROL_KEYS[..], &SHIFT_KEYS].map(|keys| keys.iter().any(|key| held.contains(key)));
                let drives = !control && driving.0.iter().any(|motors| motors.keys.contains(&key));
                if let Some(binding) = bound(key, control, shift).filter(|_| !drives) {
                    actions.write(binding.action.clone());
                }
            }
        }
    }
    if lost.read().count() > 0 {
        held.clear();
    }
}

fn is_modifier(key: &KeyCode) -> bool {
    CONTROL_KEYS.contains(key) || SHIFT_KEYS.contains(key)
}

/// What a key does while Ctrl and Shift are held or not. With Shift it does what it does without, unless Shift makes it do
/// something else.
fn bound(key: KeyCode, control: bool, shift: bool) -> Option<&'static Binding> {
    let fits = |binding: &&Binding| {
        binding.with_control == control && binding.keys.contains(&key) && (shift || !binding.with_shift)
    };
    BINDINGS.iter().filter(fits).max_by_key(|binding| binding.with_shift)
}
