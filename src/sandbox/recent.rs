//! The files that were opened or saved last.

use std::path::{Path, absolute};

use bevy::prelude::*;

use super::CurrentScene;
use super::action::CarryOut;
use crate::lab::recording::is_recording;
use crate::scene::is_path;

/// How many are kept.
const MOST: usize = 12;

/// Paths of scenes and recordings that were opened or saved, the newest first.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct RecentFiles(pub Vec<String>);

impl RecentFiles {
    /// That one is the newest now.
    pub(super) fn add(&mut self, file: &Path) {
        // What has no name in Unicode cannot be asked for as a scene.
        let Some(file) = absolute(file).ok().and_then(|path| path.into_os_string().into_string().ok()) else { return };
        self.0.retain(|other| *other != file);
        self.0.insert(0, file);
        self.0.truncate(MOST);
    }

    /// Files that are not there any more go.
    pub(super) fn forget_missing(&mut self) {
        self.0.retain(|file| Path::new(file).exists());
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<RecentFiles>().add_systems(Update, follow_scene.after(CarryOut));
}

fn follow_scene(scene: Option<Res<CurrentScene>>, mut recent: ResMut<RecentFiles>) {
    if let Some(scene) = scene.filter(|scene| scene.is_changed())
        && (is_path(&scene.scene) || is_recording(&scene.scene))
    {
        recent.add(Path::new(&scene.scene));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_there_once_the_newest_first_and_old_ones_go() {
        let mut recent = RecentFiles::default();
        for file in ["/a.ron", "/b.ron", "/c.plumb", "/a.ron"] {
            recent.add(Path::new(file));
        }
        let ends: Vec<_> = recent.0.iter().map(|file| file.rsplit(['/', '\\']).next().unwrap()).collect();
        assert_eq!(ends, ["a.ron", "c.plumb", "b.ron"]);
        (0..2 * MOST).for_each(|n| recent.add(Path::new(&format!("/{n}.ron"))));
        assert_eq!(recent.0.len(), MOST);
        recent.forget_missing();
        assert!(recent.0.is_empty());
    }
}
