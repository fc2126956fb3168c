//! What a user can ask for. Keys and buttons write the same messages.

use bevy::prelude::*;

/// Something a user asks for; carried out in `Update`, within the frame.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum SandboxAction {
    /// Replaces the scene: a built-in name or the path of a RON file, with parameters as on the
    /// command line. What is wrong with it goes to [`super::Notice`], and the old one stays.
    LoadScene {
        /// Name or path.
        scene: String,
        /// Parameters that differ from their defaults.
        parameters: Vec<(String, f64)>,
    },
    /// Puts the scene back to its start.
    Reset,
    /// Pauses or plays.
    TogglePause,
    /// Pauses and makes one step.
    StepOnce,
    /// Slow motion on or off.
    ToggleSlowMotion,
    /// Throws a ball from the camera along its view.
    ThrowBall,
    /// Deletes the picked body and its joints.
    DeletePicked,
    /// Unpicks; closes the help.
    Escape,
    /// Puts the camera back to where the scene is best seen from.
    FrameScene,
    /// Writes the picture to the next free `plumb-N.png` in the working directory.
    Screenshot,
    /// Shows or hides the help.
    ToggleHelp,
}

pub(super) fn plugin(app: &mut App) {
    app.add_message::<SandboxAction>();
}
