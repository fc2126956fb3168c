//! A scene in which something was built, kept when another takes its place.

use bevy::prelude::*;

use super::joints::Pin;
use crate::sandbox::CurrentScene;
use crate::sandbox::camera;
use crate::scene::{BodySpec, JointSpec, SceneSpec, SpawnedScene, ViewSpec};

/// The scene, as it stood.
#[derive(Clone)]
pub struct KeptScene {
    /// What it was loaded as; its entities are gone.
    loaded: CurrentScene,
    stood: SceneSpec,
    view: Option<ViewSpec>,
}

impl KeptScene {
    /// The running scene; none where none is loaded.
    pub fn of(world: &mut World) -> Option<Self> {
        let loaded = world.get_resource::<CurrentScene>()?.clone();
        let stood = SceneSpec::of_world(world, loaded.spec.name.clone()).in_order_of_a_file();
        Some(Self { stood, view: camera::view(world), loaded })
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.stood.name
    }

    /// Spawns it, as it stood, in place of what is there no longer; where it was seen from.
    pub fn bring_back(self, world: &mut World) -> (CurrentScene, Option<ViewSpec>) {
        let Self { mut loaded, stood, view } = self;
        let spawned = stood.spawn(world);
        for (body, entity) in stood.bodies.iter().zip(&spawned.bodies) {
            if body.shape.is_none() && !loaded.spec.bodies.iter().any(|own| own.name == body.name) {
                world.entity_mut(*entity).insert(Pin);
            }
        }
        loaded.entities = SpawnedScene {
            bodies: matched(&loaded.spec.bodies, &stood.bodies, &spawned.bodies, |body: &BodySpec| body.name.clone()),
            joints: matched(&loaded.spec.joints, &stood.joints, &spawned.joints, |joint: &JointSpec| {
                [joint.body_a.clone(), joint.body_b.clone()]
            }),
        };
        loaded.came_back_as = Some(Box::new((stood, spawned)));
        (loaded, view)
    }
}

/// The entities of what was loaded, among those of what stood in the end: of several with one key the first that is not
/// taken yet. What is gone has none.
fn matched<T, Key: PartialEq>(loaded: &[T], stood: &[T], entities: &[Entity], key: impl Fn(&T) -> Key) -> Vec<Entity> {
    let mut left: Vec<_> = stood.iter().map(&key).zip(entities.iter().copied()).collect();
    let take = |own: &T| {
        let own = key(own);
        let place = left.iter().position(|(key, _)| *key == own);
        place.map_or(Entity::PLACEHOLDER, |place| left.remove(place).1)
    };
    loaded.iter().map(take).collect()
}
