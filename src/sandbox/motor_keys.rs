//! Motors that keys drive: while a key is held, its motor has the target that goes with it.

use bevy::input::InputSystems;
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error;

use super::state::{DrivenMotors, DrivingKeys, is_control_held};
use crate::physics::{History, JointMotor, StepStats};
use crate::scene::{MotorKeys, SceneSpec};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<DrivingKeys>().add_systems(PreUpdate, (list_keys, drive).chain().after(InputSystems));
}

/// The key of that name in Bevy's `KeyCode`.
fn key_named(name: &str) -> Option<KeyCode> {
    let name = IntoDeserializer::<Error>::into_deserializer(name);
    KeyCode::deserialize(name).ok()
}

/// Whether all keys that a scene names are keys.
///
/// # Errors
/// The first that is none, in one line.
pub(super) fn check_keys(scene: &str, spec: &SceneSpec) -> Result<(), String> {
    for (index, joint) in spec.joints.iter().enumerate() {
        let unknown = joint.keys.iter().flat_map(|keys| &keys.keys).find(|name| key_named(name).is_none());
        if let Some(name) = unknown {
            // As the file has it: each joint of the world gets a body of its own to hold on to.
            let as_written = |name: &String| if name.starts_with("world:") { "world".to_owned() } else { name.clone() };
            let (a, b) = (as_written(&joint.body_a), as_written(&joint.body_b));
            return Err(format!(
                "{scene}: joints[{index}].motor.keys ('{a}' to '{b}'): no key '{name}'; name one as Bevy's KeyCode \
                 does, such as ArrowUp, KeyW, Digit1 or Space"
            ));
        }
    }
    Ok(())
}

/// Which keys drive what, anew when some motor gets or loses its keys.
fn list_keys(
    motors: Query<(&MotorKeys, Option<&Name>), With<JointMotor>>,
    changed: Query<(), Or<(Changed<MotorKeys>, Added<JointMotor>)>>,
    mut removed: RemovedComponents<MotorKeys>,
    mut driving: ResMut<DrivingKeys>,
) {
    if removed.read().count() == 0 && changed.is_empty() {
        return;
    }
    driving.0.clear();
    for (MotorKeys { keys: [forward, back], .. }, joint) in &motors {
        let (Some(ahead), Some(behind)) = (key_named(forward), key_named(back)) else { continue };
        let joint = joint.map_or_else(|| "a motor".to_owned(), ToString::to_string);
        match driving.0.iter_mut().find(|known| known.keys == [ahead, behind]) {
            Some(known) => known.joints.push(joint),
            None => {
                let label = [forward, back].map(|name| short_name(name)).join(" and ");
                driving.0.push(DrivenMotors { keys: [ahead, behind], label, joints: vec![joint] });
            }
        }
    }
}

/// A key's name as it stands on the key: `Up`, `W`.
pub(super) fn short_name(name: &str) -> &str {
    ["Arrow", "Key", "Digit"].into_iter().find_map(|prefix| name.strip_prefix(prefix)).unwrap_or(name)
}

/// Gives motors the target of the key that is held. Held together, the two keys cancel. In the past motors do what they
/// did, unless a key is held.
fn drive(
    keys: Res<ButtonInput<KeyCode>>,
    egui: Res<EguiWantsInput>,
    stats: Res<StepStats>,
    history: Option<Res<History>>,
    mut motors: Query<(&MotorKeys, &mut JointMotor)>,
) {
    let is_past = history.is_some_and(|history| history.is_past(stats.steps));
    let is_free = !egui.wants_any_keyboard_input() && !is_control_held(&keys);
    // One that was pressed and let go within a frame drives for that frame.
    let is_held = |key: KeyCode| keys.pressed(key) || keys.just_pressed(key);
    for (MotorKeys { keys: names, values, rest }, mut motor) in &mut motors {
        let held = [0, 1].map(|which| is_free && key_named(&names[which]).is_some_and(is_held));
        let value = match held {
            [true, false] => values[0],
            [false, true] => values[1],
            _ if is_past => continue,
            _ => *rest,
        };
        let target = motor.target.with_value(value);
        if motor.target != target {
            motor.target = target;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_by_their_names_in_bevy() {
        for (name, key) in [("ArrowUp", KeyCode::ArrowUp), ("KeyW", KeyCode::KeyW), ("Digit1", KeyCode::Digit1)] {
            assert_eq!(key_named(name), Some(key));
        }
        for name in ["", "Up", "arrowup", "W", "Unidentified"] {
            assert_eq!(key_named(name), None, "{name}");
        }
    }
}
