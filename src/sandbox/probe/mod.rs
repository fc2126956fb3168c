//! Probes: what is right clicked is plotted, trailed or measured by a tape, as long as its [`Probes`] say so.
//!
//! What probes read is sampled in the step itself, by nobody where there are none. They are the scene's
//! ([`crate::scene::Probe`]) and stay with its file; what they read is not.

mod csv;
mod draw;
mod menu;
mod needs;
mod reader;
mod rows;
mod section;
mod tape_start;
mod tracks;

pub(super) use csv::save;
pub(super) use menu::escape;
pub(super) use needs::{read_loads, reads_contact_forces, reads_diagnostics};
pub(super) use reader::Reader;
pub(super) use rows::{body as offer_body, joint as offer_joint, offer};
pub(super) use section::show;
pub(super) use tape_start::TapeStart;
pub use tracks::{Row, Track, Tracks};

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;

use super::action::CarryOut;
use super::in_front::in_front;
use super::timeline::is_another_future;
use crate::physics::{PhysicsSchedule, PhysicsSystems};
use crate::scene::Probes;

pub(super) fn plugin(app: &mut App) {
    in_front::<draw::ProbeLines>(app, 0.97, 3.5);
    app.init_resource::<Probes>()
        .init_resource::<Tracks>()
        .init_resource::<TapeStart>()
        .init_resource::<menu::Menu>()
        .add_observer(menu::press)
        .add_observer(menu::moved)
        .add_observer(menu::release)
        .add_systems(
            PhysicsSchedule,
            tracks::sample.after(PhysicsSystems::Diagnose).run_if(|probes: Res<Probes>| !probes.0.is_empty()),
        )
        .add_systems(
            Update,
            (menu::finish_tape, tracks::forget_ahead.run_if(is_another_future), tracks::keep_up)
                .chain()
                .after(CarryOut),
        )
        .add_systems(EguiPrimaryContextPass, (menu::show, draw::draw_lengths))
        .add_systems(PostUpdate, draw::draw.before(TransformSystems::Propagate));
}
