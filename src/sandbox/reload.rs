//! The scene's file and its meshes are watched: when one changes, the scene starts anew, seen from the
//! same place. A file that no longer makes sense is said to be so, and the running scene goes on.

use bevy::prelude::*;

use super::carry_out::carry_out_actions;
use super::watch::Watch;
use super::{CurrentScene, SandboxAction};

/// Seconds between two looks at a file. It is read once two looks in a row have found the same: it
/// may be half written, or gone for a moment while an editor replaces it.
const INTERVAL: f64 = 0.25;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Watch>().add_systems(Update, look.before(carry_out_actions));
}

fn look(
    clock: Res<Time<Real>>,
    mut watch: ResMut<Watch>,
    scene: Option<Res<CurrentScene>>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let now = clock.elapsed_secs_f64();
    if scene.is_none() || watch.is_empty() || now - watch.last_look < INTERVAL {
        return;
    }
    let watch = watch.bypass_change_detection();
    watch.last_look = now;
    if watch.has_news() {
        actions.write(SandboxAction::ReloadScene);
    }
}
