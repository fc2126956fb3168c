//! What a user can ask for. Keys and buttons write the same messages.

use std::path::PathBuf;

use bevy::prelude::*;

use super::build::{Hills, JointChange, MeshForm, Placement};
use super::tool::Tool;
use crate::scene::BodySpec;

/// When actions are carried out: what draws new bodies comes after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct CarryOut;

/// Something a user asks for; carried out in `Update`, in the order of writing.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum SandboxAction {
    /// Replaces the scene: a built-in name or the path of a RON file, with parameters as on the
    /// command line, or the path of a recording, all of which is on the strip of time then. What is wrong with it goes to
    /// [`super::Notice`], and the old one stays.
    LoadScene {
        /// Name or path.
        scene: String,
        /// Parameters that differ from their defaults.
        parameters: Vec<(String, f64)>,
    },
    /// Opens a file as what it is: a scene or a recording is put on view, a mesh is what is built with.
    OpenFile {
        /// Its path.
        path: PathBuf,
    },
    /// Reads the scene's file again, seen from the same place; done by itself when the file
    /// changes. What is wrong with it is said, and the old one stays.
    ReloadScene,
    /// Puts the scene back to its start.
    Reset,
    /// Pauses or plays.
    TogglePause,
    /// Pauses and makes one step.
    StepOnce,
    /// Pauses and goes one step back.
    StepBack,
    /// Pauses and goes to where the scene was after that many steps of the world, back or on again.
    GoTo {
        /// As [`StepStats::steps`](crate::physics::StepStats::steps) counts them.
        step: u64,
    },
    /// Pauses and shows where bodies were after that many steps, for as long as it comes in each frame; then goes there. At
    /// once where that takes no time.
    LookAt {
        /// As [`StepStats::steps`](crate::physics::StepStats::steps) counts them.
        step: u64,
    },
    /// Pauses and goes back as far as is kept.
    GoToStart,
    /// Pauses and goes on to the last moment that there was.
    GoToNow,
    /// Plays backwards, or stops.
    TogglePlayBackwards,
    /// Marks the present moment, or takes its mark away.
    ToggleMark,
    /// Plays over and over what lies between the two marks around the present moment, or no longer.
    ToggleLoop,
    /// Slow motion on or off.
    ToggleSlowMotion,
    /// Throws a ball from the camera, at what the pointer is on.
    ThrowBall,
    /// Adds a body of the [`super::Blueprint`] on the surface that the pointer is on; with the
    /// pointer off the picture, on the one in its middle.
    SpawnBody,
    /// Makes the [`super::Blueprint`] a mesh.
    ChooseMesh {
        /// The path of an OBJ file, or the name of a mesh that comes with Plumb: `plumb:gem.obj`.
        file: String,
        /// Factor on its coordinates.
        scale: f64,
        /// What the body is of it.
        form: MeshForm,
    },
    /// Makes the [`super::Blueprint`] such a ground.
    ChooseHills(Hills),
    /// Makes the picked bodies one: a compound of their shapes, with their mass and momentum. Joints between them go, those to
    /// others hold it at the same places.
    MakeOneBody,
    /// Makes a body of each part of the picked compounds and meshes in pieces, which moves on as it did. Joints hold the part
    /// that is nearest to them.
    TakeApart,
    /// Joins the two picked bodies by the chosen [`super::JoinKind`].
    JoinPicked,
    /// Holds the picked body to the world where it was clicked.
    PinPicked,
    /// Cuts the joint nearest the pointer: of those between two picked bodies, of the picked body,
    /// or of all where none is picked; but where two are picked and the pointer is on a joint, that one. With the
    /// pointer off the picture, nearest the last click.
    CutPicked,
    /// Cuts that joint.
    Cut(Entity),
    /// Changes what stands beside a joint: limits, a motor, friction, strength.
    ChangeJoint {
        /// The joint.
        joint: Entity,
        /// What it is to be.
        change: JointChange,
        /// Whether it goes on with the last change, as a slider does that is dragged: both are undone together.
        continues: bool,
    },
    /// Changes a body, but for its pose.
    ChangeBody {
        /// The body.
        body: Entity,
        /// What it is to be.
        asked: Box<BodySpec>,
        /// Whether it goes on with the last change, as a value does that is dragged: both are undone together.
        continues: bool,
    },
    /// Deletes the picked bodies and their joints, or the picked joint.
    DeletePicked,
    /// Picks the bodies whose centres of mass are seen in a box.
    SelectBox {
        /// A corner of it, logical pixels.
        from: Vec2,
        /// The corner across.
        to: Vec2,
        /// Whether what is picked already stays so.
        adds: bool,
    },
    /// Picks all bodies but the ground.
    SelectAll,
    /// Picks that joint alone.
    PickJoint(Entity),
    /// Makes the picked bodies once more, beside them, with the joints among them and to the world.
    Duplicate,
    /// Copies them to the [`super::Clipboard`], as the text of a scene file.
    Copy,
    /// Copies them and deletes them.
    CutOut,
    /// Adds the scene that the clipboard has the text of: at the pointer; with the pointer off the picture, where its
    /// bodies were, or beside that.
    Paste,
    /// Puts bodies somewhere else, turned or of another size; while time runs they stand still there.
    PlaceBodies {
        /// Where each is to be.
        placements: Vec<Placement>,
        /// Whether it goes on with the last change, as a drag does: both are undone together.
        continues: bool,
    },
    /// Takes back what was added, joined, pinned, changed, cut or deleted last.
    Undo,
    /// Has what was undone last come again.
    Redo,
    /// Takes that tool in hand.
    ChooseTool(Tool),
    /// Unpicks, puts the tool down; closes the help.
    Escape,
    /// Puts the camera back to where the scene is best seen from.
    FrameScene,
    /// Lets the camera go along with the picked body, or stay again.
    Follow,
    /// Saves the scene as it stands now, with the camera's view.
    SaveScene {
        /// A RON file.
        path: PathBuf,
        /// Whether what is there may be replaced.
        overwrite: bool,
    },
    /// Saves the solver's settings.
    SaveSettings {
        /// A RON file.
        path: PathBuf,
        /// Whether what is there may be replaced.
        overwrite: bool,
    },
    /// Takes the solver's settings from a file.
    LoadSettings {
        /// A RON file.
        path: PathBuf,
    },
    /// Writes all that happened since the scene began to the next free `plumb-N.plumb` in the working directory.
    Record,
    /// Writes what probes read over the last minute to the next free `plumb-N.csv` in the working directory.
    SaveProbes,
    /// Writes the picture to the next free `plumb-N.png` in the working directory.
    Screenshot,
    /// Shows or hides the plots.
    TogglePlots,
    /// Makes all that lies over the picture larger or smaller.
    ScaleInterface(ScaleChange),
    /// Shows or hides the help.
    ToggleHelp,
    /// Measures the scene's chart of error against cost in a process of its own.
    MeasureChart,
}

/// How the interface is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScaleChange {
    /// A step larger.
    Larger,
    /// A step smaller.
    Smaller,
    /// At 100 %.
    Normal,
}
