//! Building in the running scene: new bodies, joints between picked ones, and taking it back.
//!
//! Each thing built is one [`SandboxAction`](super::SandboxAction), so that keys, buttons and tests
//! do the same. What was asked for and makes no sense is said in a [`Notice`](super::Notice), and nothing happens.

mod bar;
mod blueprint;
mod body_change;
mod changing;
mod copying;
mod deleting;
mod excerpt;
mod hills;
mod join_kind;
mod joining;
mod joint_change;
mod joints;
mod kept;
mod making_one;
mod mesh_form;
mod moving_joints;
mod names;
mod place;
mod placement;
mod placing;
mod rewriting;
mod room;
mod spawning;
mod taking_apart;
mod undo;

pub(super) use bar::{BarEnd, add_bar, bar_between};
pub use blueprint::{Blueprint, Weight};
pub(super) use blueprint::{choose_hills, choose_mesh, stem};
pub(super) use body_change::change_body;
pub(super) use changing::change_joint;
pub(super) use copying::{copy, cut_out, duplicate, paste};
pub(super) use deleting::delete_picked;
pub use hills::Hills;
pub use join_kind::JoinKind;
pub(super) use join_kind::place_of;
pub(super) use joining::{cut, cut_picked, ends_of, join_picked, joint_at_pointer, pin_picked};
pub use joint_change::JointChange;
pub(super) use joints::Pin;
pub(super) use kept::KeptScene;
pub(super) use making_one::make_one_body;
pub use mesh_form::MeshForm;
pub(super) use names::name_of;
pub use placement::Placement;
pub(super) use placing::place_bodies;
pub(super) use spawning::{next_body, spawn_body, throw, throw_ball};
pub(super) use taking_apart::take_apart;
pub(super) use undo::{UndoStack, follow_time, keep_what_was_built, redo, undo};

use bevy::prelude::*;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Blueprint>().init_resource::<JoinKind>().init_resource::<UndoStack>();
}
