//! The scene's file is watched: when it changes, the scene starts anew from it, seen from the same
//! place. A file that no longer makes sense is said to be so, and the running scene goes on.

use std::fs;
use std::time::SystemTime;

use bevy::prelude::*;

use super::{CurrentScene, SandboxAction};
use crate::scene;

/// Seconds between two looks at the file. It is read once two looks in a row have found the same:
/// it may be half written, or gone for a moment while an editor replaces it.
const INTERVAL: f64 = 0.25;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Watch>().add_systems(Update, look.before(super::actions::carry_out_actions));
}

/// The file of the scene on view, if it has one.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct Watch {
    /// None: a built-in scene.
    path: Option<String>,
    /// As it was when it was last read.
    read: Option<Stamp>,
    /// As it was at the last look.
    seen: Option<Stamp>,
    last_look: f64,
    /// What was wrong with it when it was last read.
    pub problem: Option<String>,
}

/// Tells one state of a file from another: when it was written, and its length.
type Stamp = (SystemTime, u64);

impl Watch {
    /// Watches the file of a scene that is about to be read: what is written to it from now on is
    /// news.
    pub fn on(scene: &str) -> Self {
        let path = scene::is_path(scene).then(|| scene.to_owned());
        let read = path.as_deref().and_then(stamp);
        Self { path, read, seen: read, ..default() }
    }

    /// Whether the file now says something else than when it was last read, and has stopped changing.
    fn has_news(&mut self) -> bool {
        let now = self.path.as_deref().and_then(stamp);
        let settled = now == std::mem::replace(&mut self.seen, now);
        settled && now.is_some() && now != self.read
    }
}

fn stamp(path: &str) -> Option<Stamp> {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

fn look(
    clock: Res<Time<Real>>,
    mut watch: ResMut<Watch>,
    scene: Option<Res<CurrentScene>>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let now = clock.elapsed_secs_f64();
    if scene.is_none() || watch.path.is_none() || now - watch.last_look < INTERVAL {
        return;
    }
    let watch = watch.bypass_change_detection();
    watch.last_look = now;
    if watch.has_news() {
        actions.write(SandboxAction::ReloadScene);
    }
}
