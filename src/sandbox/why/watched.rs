//! Whether the section is on view: what its plots show is measured only then.

use bevy::prelude::*;

use crate::physics::{PhaseTimes, SolveTrace};

/// Whether the section was drawn since the last frame began.
#[derive(Resource, Default)]
pub struct Drawn(pub bool);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Drawn>().add_systems(PreUpdate, switch);
}

fn switch(mut commands: Commands, mut drawn: ResMut<Drawn>, trace: Option<Res<SolveTrace>>) {
    match (std::mem::take(&mut drawn.0), trace.is_some()) {
        (true, false) => {
            commands.init_resource::<SolveTrace>();
            commands.init_resource::<PhaseTimes>();
        }
        (false, true) => {
            commands.remove_resource::<SolveTrace>();
            commands.remove_resource::<PhaseTimes>();
        }
        _ => {}
    }
}
