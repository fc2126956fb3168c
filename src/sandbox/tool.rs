//! What the left button does in the picture.

use bevy::prelude::*;

/// What a press of the left button does. Escape goes back to the first.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Picks a body and drags it.
    #[default]
    Drag,
    /// Moves what is picked, by arrows and squares.
    Move,
    /// Turns it, by rings.
    Turn,
    /// Makes it larger or smaller, by boxes.
    Scale,
    /// Gives a body a kick, away from the eye.
    Push,
    /// Throws a ball.
    Throw,
    /// Adds what the [`Blueprint`](super::Blueprint) says.
    Add,
    /// Draws a bar from where the button goes down to where it goes up, on hinges to what it meets there.
    Bar,
    /// Joins two bodies, one click each, by the [`JoinKind`](super::JoinKind) that is chosen.
    Join,
    /// Pins a body to the world.
    Pin,
    /// Cuts a joint.
    Cut,
    /// Draws a tape between two points, one click each.
    Measure,
}

impl Tool {
    /// All of them, with what each is called and what it does.
    pub const ALL: [(Self, &str, &str); 12] = [
        (Self::Drag, "drag", "pick a body and drag it; with Shift held pick more; draw a box around bodies"),
        (Self::Move, "move", "drag an arrow, a square or the middle; click a body to pick it"),
        (Self::Turn, "turn", "drag a ring; click a body to pick it"),
        (Self::Scale, "scale", "drag a box: along an axis, or the middle one for all; meshes keep their size"),
        (Self::Push, "push", "kick a body where you click it"),
        (Self::Throw, "throw", "throw a ball at what you click"),
        (Self::Add, "add", "put a body where you click"),
        (
            Self::Bar,
            "bar",
            "draw a bar: press where it begins, let go where it ends; it hangs on hinges on what it meets",
        ),
        (Self::Join, "join", "click two bodies: the joint is where you click the second"),
        (Self::Pin, "pin", "hold a body to the world where you click it"),
        (Self::Cut, "cut", "cut the joint that you click"),
        (Self::Measure, "measure", "click two points: a tape tells how far they are apart"),
    ];

    /// Whether it puts what is picked by handles.
    pub fn has_handles(self) -> bool {
        matches!(self, Self::Move | Self::Turn | Self::Scale)
    }

    /// What it does.
    pub fn about(self) -> &'static str {
        Self::ALL.iter().find(|(tool, ..)| *tool == self).map_or("", |(.., about)| about)
    }
}
