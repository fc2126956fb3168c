//! The plugin of the tools.

use bevy::prelude::*;

use super::bar::{self, BarDraft};
use super::press::press;
use super::preview::{self, Preview};
use crate::sandbox::Tool;
use crate::sandbox::action::CarryOut;
use crate::sandbox::in_front::in_front;

pub fn plugin(app: &mut App) {
    in_front::<preview::PreviewLines>(app, 0.99, 2.5);
    app.init_resource::<Tool>()
        .init_resource::<BarDraft>()
        .init_resource::<Preview>()
        .add_observer(press)
        .add_systems(Update, (bar::follow, preview::find).chain().after(CarryOut))
        .add_systems(PostUpdate, preview::draw.before(TransformSystems::Propagate));
}
