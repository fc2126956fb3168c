//! The scene's file and its meshes are watched: when one changes, the scene starts anew, seen from the
//! same place. A file that no longer makes sense is said to be so, and the running scene goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bevy::prelude::*;

use super::{CurrentScene, SandboxAction};
use crate::scene::{self, SceneSpec, ShapeSpec};

/// Seconds between two looks at a file. It is read once two looks in a row have found the same: it
/// may be half written, or gone for a moment while an editor replaces it.
const INTERVAL: f64 = 0.25;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Watch>().add_systems(Update, look.before(super::actions::carry_out_actions));
}

/// The files of the scene on view: its own, and those of its meshes.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct Watch {
    /// The scene's own first. None: a built-in scene.
    files: Vec<PathBuf>,
    /// As they were when they were last read.
    read: Vec<Option<Stamp>>,
    /// As they were at the last look.
    seen: Vec<Option<Stamp>>,
    last_look: f64,
    /// What was wrong with them when they were last read.
    pub problem: Option<String>,
}

/// Tells one state of a file from another: when it was written, and its length.
type Stamp = (SystemTime, u64);

impl Watch {
    /// Watches the file of a scene that is about to be read: what is written to it from now on is
    /// news.
    pub fn on(scene: &str) -> Self {
        let mut watch = Self::default();
        if scene::is_path(scene) {
            watch.add(scene.into());
        }
        watch
    }

    /// Watches the scene's meshes too.
    pub fn with_meshes(mut self, spec: &SceneSpec) -> Self {
        if self.files.is_empty() {
            return self;
        }
        for body in &spec.bodies {
            if let Some(ShapeSpec::Mesh(mesh)) = &body.shape
                && let Some(path) = mesh.path()
                && !self.files.iter().any(|file| file == path)
            {
                self.add(path.to_owned());
            }
        }
        self
    }

    fn add(&mut self, file: PathBuf) {
        let stamp = stamp(&file);
        self.files.push(file);
        self.read.push(stamp);
        self.seen.push(stamp);
    }

    /// Takes the files as they are now for what is on view.
    pub fn accept(&mut self) {
        self.read = self.files.iter().map(|file| stamp(file)).collect();
        self.problem = None;
    }

    /// Whether the files now say something else than when they were last read, and have stopped
    /// changing. Without its own file there is no scene to read.
    fn has_news(&mut self) -> bool {
        let now: Vec<_> = self.files.iter().map(|file| stamp(file)).collect();
        let is_there = now.first().is_some_and(Option::is_some);
        let differs = now != self.read;
        let settled = now == self.seen;
        self.seen = now;
        is_there && differs && settled
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
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
    if scene.is_none() || watch.files.is_empty() || now - watch.last_look < INTERVAL {
        return;
    }
    let watch = watch.bypass_change_detection();
    watch.last_look = now;
    if watch.has_news() {
        actions.write(SandboxAction::ReloadScene);
    }
}
