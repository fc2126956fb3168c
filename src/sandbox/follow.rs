//! The camera goes along with a body, so that what drives off stays in the picture.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraSystemSet};

use super::Selection;
use super::held::Drag;
use super::state::report;
use crate::physics::RenderOrigin;
use crate::scene::SpawnedScene;

/// The body that the camera goes along with, if it does with one.
#[derive(Resource, Default)]
pub(super) struct Followed(Option<Along>);

struct Along {
    body: Entity,
    /// Where it was drawn in the last frame, world, m; none before the first.
    last: Option<DVec3>,
}

impl Followed {
    /// The scene was spawned anew: its bodies are other entities now.
    pub fn follow(&mut self, before: &SpawnedScene, now: &SpawnedScene) {
        let Some(along) = &mut self.0 else { return };
        let place = before.bodies.iter().position(|body| *body == along.body);
        match place.and_then(|place| now.bodies.get(place)) {
            Some(body) => along.body = *body,
            None => self.0 = None,
        }
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Followed>().add_systems(PostUpdate, go_along.before(PanOrbitCameraSystemSet));
}

/// Follows the picked body, with the view on it; the camera stays again where that one is followed, or none is picked.
pub(super) fn toggle(world: &mut World) {
    let followed = world.resource::<Followed>().0.as_ref().map(|along| along.body);
    let picked = world.resource::<Selection>().entity().filter(|body| Some(*body) != followed);
    let said = match (picked, followed) {
        (Some(body), _) => follow(world, body),
        (None, Some(_)) => {
            *world.resource_mut::<Followed>() = Followed::default();
            Ok("the camera stays where it is".into())
        }
        (None, None) => Err("pick a body to follow: click it".into()),
    };
    report(world, said);
}

fn follow(world: &mut World, body: Entity) -> Result<String, String> {
    let Some(pose) = world.get::<Transform>(body).copied() else { return Err("that body is gone".into()) };
    for mut camera in world.query::<&mut PanOrbitCamera>().iter_mut(world) {
        camera.target_focus = pose.translation;
    }
    *world.resource_mut::<Followed>() = Followed(Some(Along { body, last: None }));
    let name = world.get::<Name>(body).map_or_else(|| body.to_string(), ToString::to_string);
    Ok(format!("the camera follows {name}; V lets it stay again"))
}

/// Shifts the view by what the body has moved. Not while one is dragged: the pointer would drag the camera along.
fn go_along(
    mut followed: ResMut<Followed>,
    drag: Res<Drag>,
    origin: Res<RenderOrigin>,
    bodies: Query<&Transform, Without<PanOrbitCamera>>,
    mut cameras: Query<(&mut PanOrbitCamera, &mut Transform)>,
) {
    let Some(along) = &mut followed.0 else { return };
    let Ok(pose) = bodies.get(along.body) else {
        followed.0 = None;
        return;
    };
    let now = origin.0 + pose.translation.as_dvec3();
    let Some(last) = along.last.replace(now) else { return };
    let shift = (now - last).as_vec3();
    if drag.is_active() || shift == Vec3::ZERO {
        return;
    }
    for (mut camera, mut transform) in &mut cameras {
        camera.focus += shift;
        camera.target_focus += shift;
        transform.translation += shift;
    }
}
