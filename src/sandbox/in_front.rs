//! Lines that are drawn over all bodies.

use bevy::prelude::*;

/// Lines in front of all bodies, the nearer one in front where two are at one place.
pub(super) fn in_front<Group: GizmoConfigGroup>(app: &mut App, nearness: f32, width: f32) {
    let line = GizmoLineConfig { width, ..default() };
    app.insert_gizmo_config(Group::default(), GizmoConfig { depth_bias: -nearness, line, ..default() });
}
