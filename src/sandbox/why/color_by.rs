//! Which quantity bodies, joints and contact points have the color of.

use bevy::prelude::*;

/// The quantity by which things are colored.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub enum ColorBy {
    /// None: all have their own colors.
    #[default]
    Nothing,
    /// Depth of contacts.
    Overlap,
    /// How far joints are torn apart.
    JointGap,
    /// What joints carry.
    Load,
    /// The island.
    Island,
    /// The color of the constraint graph.
    GraphColor,
    /// Who sleeps.
    Asleep,
    /// How often rows were solved.
    Effort,
}

impl ColorBy {
    /// All.
    pub const EVERY: [Self; 8] = [
        Self::Nothing,
        Self::Overlap,
        Self::JointGap,
        Self::Load,
        Self::Island,
        Self::GraphColor,
        Self::Asleep,
        Self::Effort,
    ];

    /// The word on its button, and what it shows.
    pub(super) fn label(self) -> (&'static str, &'static str) {
        match self {
            Self::Nothing => ("–", "everything in its own color"),
            Self::Overlap => ("overlap", "contact points by their depth, each body by its deepest one"),
            Self::JointGap => (
                "joint gap",
                "joints by how far what they hold is apart (m; of one that holds no point at a point the worst row, m or \
                 rad), each body by the worst of its joints",
            ),
            Self::Load => (
                "load",
                "joints by force and torque over what they bear; one that cannot break by its force, over the largest in \
                 the scene; each body by the most loaded of its joints",
            ),
            Self::Island => (
                "island",
                "bodies that contacts and joints connect have one color, that of the oldest of them, which they keep from \
                 step to step",
            ),
            Self::GraphColor => (
                "graph color",
                "contact points and joints by the color of the constraint graph: those of one color share no body that \
                 moves and are solved side by side, color after color",
            ),
            Self::Asleep => ("asleep", "who sleeps, and how much of the time until then is over"),
            Self::Effort => (
                "effort",
                "how often the rows of each body were solved in the last step: sweeps over all substeps, factorisations \
                 where its island was solved directly, iterations and evaluations by accurate",
            ),
        }
    }

    /// Whether it shows in joints.
    pub fn is_of_joints(self) -> bool {
        matches!(self, Self::JointGap | Self::Load | Self::GraphColor)
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ColorBy>().register_type::<ColorBy>();
}
