//! Sun, light of the sky, and air. How far shadows and air reach goes with the distance of the camera.

use bevy::light::{CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap};
use bevy::pbr::{DistanceFog, FogFalloff};
use bevy::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;

use super::quality::Quality;
use super::sky::HORIZON;

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(GlobalAmbientLight { color: Color::srgb(0.80, 0.88, 1.0), brightness: 700.0, ..default() })
        .add_systems(Startup, spawn_lights)
        .add_systems(Update, fit_to_view);
}

#[derive(Component)]
struct Sun;

fn spawn_lights(mut commands: Commands, quality: Res<Quality>) {
    commands.insert_resource(DirectionalLightShadowMap { size: quality.shadow_map });
    commands.spawn((
        Sun,
        DirectionalLight {
            color: Color::srgb(1.0, 0.96, 0.88),
            illuminance: 9000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows(10.0),
        Transform::from_xyz(-0.55, 1.0, 0.45).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // Sky light from the other side, so that faces in the shade keep their shape.
    commands.spawn((
        DirectionalLight { color: Color::srgb(0.75, 0.85, 1.0), illuminance: 1500.0, ..default() },
        Transform::from_xyz(0.8, 0.5, -0.3).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Cascades for a camera that orbits at `distance`, m.
fn shadows(distance: f32) -> CascadeShadowConfig {
    CascadeShadowConfigBuilder {
        num_cascades: 3,
        minimum_distance: 0.1,
        first_cascade_far_bound: 1.2 * distance,
        maximum_distance: 8.0 * distance,
        ..default()
    }
    .build()
}

/// The camera's part of the air.
pub(super) fn air() -> DistanceFog {
    DistanceFog { color: HORIZON, falloff: fading(10.0), ..default() }
}

fn fading(distance: f32) -> FogFalloff {
    FogFalloff::from_visibility_squared((20.0 * distance).max(60.0))
}

/// Rebuilt when the distance has changed by a fifth: often enough to look right, seldom enough
/// for shadows not to swim.
fn fit_to_view(
    camera: Single<(&PanOrbitCamera, &mut DistanceFog)>,
    mut sun: Single<&mut CascadeShadowConfig, With<Sun>>,
    mut fitted: Local<f32>,
) {
    let (camera, mut fog) = camera.into_inner();
    let distance = camera.radius.unwrap_or(10.0);
    if (0.8..1.25).contains(&(distance / *fitted)) {
        return;
    }
    *fitted = distance;
    **sun = shadows(distance);
    fog.falloff = fading(distance);
}
