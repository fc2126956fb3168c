//! Changing what stands beside a joint, as the panel does.

use bevy::prelude::*;

use super::joint_change::JointChange;
use super::names::name_of;
use super::undo::{Deed, remember_change};
use crate::sandbox::state::report;
use crate::scene::{JointParts, check_parts};

/// Changes a joint. What goes on with the last change, as a slider does that is dragged, is undone with it.
pub fn change_joint(world: &mut World, joint: Entity, change: JointChange, continues: bool) {
    if let Err(reason) = try_change(world, joint, change, continues) {
        report(world, Err(reason));
    }
}

fn try_change(world: &mut World, joint: Entity, mut change: JointChange, continues: bool) -> Result<(), String> {
    let mut changed = JointParts::of_entity(world, joint).ok_or("that joint is gone")?;
    change.clone().swap(&mut changed);
    check_parts(&changed)?;
    change.write(world, joint);
    let what = format!("changing the {} of {}", change.noun(), name_of(world, joint));
    remember_change(world, what, Deed::Changed { joint, back: change }, continues);
    Ok(())
}
