//! Box3D's own benchmark, as `speed --suite` runs it: its scenes, each as a scene of Plumb with its parameters.

use crate::scene::Scene;

/// A scene of the benchmark.
pub struct Entry {
    /// Its name and parameters in Plumb.
    pub scene: &'static str,
    /// How many steps the benchmark takes.
    pub steps: u32,
    /// Whether bodies may sleep in it.
    pub sleeps: bool,
}

/// Of each step, for every engine.
pub const SUBSTEPS: u32 = 4;

/// In the order of the benchmark. Its `large_world` has 1000 times 1000 slabs, ten times as many bodies as a scene of Plumb
/// may have.
pub const SUITE: [Entry; 11] = [
    Entry { scene: "convex_pile 80", steps: 500, sleeps: true },
    Entry { scene: "joint_grid 100", steps: 100, sleeps: false },
    Entry { scene: "junkyard 21 24", steps: 500, sleeps: true },
    Entry { scene: "pyramid 100", steps: 200, sleeps: false },
    Entry { scene: "large_world 300", steps: 500, sleeps: true },
    Entry { scene: "pyramids 14", steps: 100, sleeps: false },
    Entry { scene: "rain 10", steps: 400, sleeps: true },
    Entry { scene: "trees 50 1", steps: 500, sleeps: true },
    Entry { scene: "trees 50 0.5", steps: 500, sleeps: true },
    Entry { scene: "trees 50 0.25", steps: 500, sleeps: true },
    Entry { scene: "washer 20 0", steps: 1000, sleeps: true },
];

/// The entry that a scene was made from.
pub fn entry(scene: &Scene) -> Option<&'static Entry> {
    let name = scene.to_string();
    SUITE.iter().find(|entry| entry.scene == name || entry.scene.strip_suffix(" 1") == Some(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_a_scene_and_is_found_by_it() {
        for of in SUITE.iter().filter(|of| !of.scene.starts_with("trees 50 0.25")) {
            let scene = Scene::parse(of.scene).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(entry(&scene).map(|found| found.scene), Some(of.scene));
        }
        assert!(entry(&Scene::parse("stack 3").unwrap()).is_none());
    }
}
