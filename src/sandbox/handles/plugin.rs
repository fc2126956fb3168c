//! The plugin of the handles.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;

use super::draw::{self, HandleLines, Shown};
use super::pull::{self, Pull};
use crate::sandbox::action::CarryOut;
use crate::sandbox::in_front::in_front;

pub fn plugin(app: &mut App) {
    in_front::<HandleLines>(app, 1.0, 3.5);
    app.init_resource::<Pull>()
        .init_resource::<Shown>()
        .add_systems(Update, pull::follow.before(CarryOut))
        .add_systems(Update, draw::find.after(CarryOut))
        .add_systems(PostUpdate, draw::draw.before(TransformSystems::Propagate))
        .add_systems(EguiPrimaryContextPass, draw::tell);
}
