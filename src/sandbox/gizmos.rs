//! Contacts, joints, bounds and velocities, drawn over the picture.

pub(super) fn plugin(_app: &mut bevy::prelude::App) {}
