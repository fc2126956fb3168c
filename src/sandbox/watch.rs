//! The files of the scene on view, and whether they say something new.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bevy::prelude::*;

use crate::scene::{self, SceneSpec, ShapeSpec};

/// The files of the scene on view: its own, and those of its meshes and pictures.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct Watch {
    /// The scene's own first. None: a built-in scene.
    files: Vec<PathBuf>,
    /// As they were when they were last read.
    read: Vec<Option<Stamp>>,
    /// As they were at the last look.
    seen: Vec<Option<Stamp>>,
    /// When that was, s of the real clock.
    pub last_look: f64,
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

    /// Watches the files of the scene's shapes too.
    pub fn with_meshes(mut self, spec: &SceneSpec) -> Self {
        if self.files.is_empty() {
            return self;
        }
        for body in &spec.bodies {
            if let Some(path) = body.shape.as_ref().and_then(ShapeSpec::path)
                && !self.files.iter().any(|file| file == path)
            {
                self.add(path.to_owned());
            }
        }
        self
    }

    /// Whether there is nothing to watch.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
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
    pub fn has_news(&mut self) -> bool {
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
