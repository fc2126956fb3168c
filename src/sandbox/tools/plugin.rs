//! The plugin of the tools.

use bevy::prelude::*;

use super::bar::{self, BarDraft};
use super::press::press;
use super::preview::{self, Preview};
use crate::sandbox::Tool;
use crate::sandbox::action::CarryOut;

pub fn plugin(app: &mut App) {
    app.init_resource::<Tool>()
        .init_resource::<BarDraft>()
        .init_resource::<Preview>()
        .init_gizmo_group::<preview::PreviewLines>()
        .add_observer(press)
        .add_systems(Startup, preview::set_up)
        .add_systems(Update, (bar::follow, preview::find).chain().after(CarryOut))
        .add_systems(PostUpdate, preview::draw.before(TransformSystems::Propagate));
}
