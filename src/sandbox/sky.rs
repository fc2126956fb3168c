//! The sky: a dome around the camera, brightest at the horizon, where the ground fades into it.

use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::render::render_resource::Face;

/// At the horizon; what far ground fades to. Brighter than white paper, as skies are: tone
/// mapping brings it down.
pub(super) const HORIZON: Color = Color::linear_rgb(1.20, 1.36, 1.50);
const ZENITH: Color = Color::linear_rgb(0.14, 0.50, 1.45);
/// Radius, m: beyond everything, ground included.
const RADIUS: f32 = 9000.0;

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(ClearColor(HORIZON))
        .add_systems(Startup, spawn_dome)
        .add_systems(PostUpdate, follow_camera.before(TransformSystems::Propagate));
}

#[derive(Component)]
struct Dome;

fn spawn_dome(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Dome,
        Name::new("sky"),
        Pickable::IGNORE,
        NoFrustumCulling,
        NotShadowCaster,
        NotShadowReceiver,
        Mesh3d(meshes.add(dome())),
        MeshMaterial3d(materials.add(StandardMaterial {
            unlit: true,
            fog_enabled: false,
            cull_mode: Some(Face::Front),
            ..default()
        })),
    ));
}

/// Colored by height, fast near the horizon.
fn dome() -> Mesh {
    let mut mesh = Sphere::new(RADIUS).mesh().uv(48, 48);
    let heights = match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => positions.iter().map(|p| p[2] / RADIUS).collect(),
        _ => Vec::new(),
    };
    let (horizon, zenith) = (HORIZON.to_linear(), ZENITH.to_linear());
    let colors: Vec<[f32; 4]> =
        heights.iter().map(|height| horizon.mix(&zenith, height.max(0.0).powf(0.6)).to_f32_array()).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    // Bevy's spheres have their poles on z.
    mesh.rotated_by(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2))
}

fn follow_camera(
    camera: Single<&Transform, (With<Camera3d>, Without<Dome>)>,
    mut dome: Single<&mut Transform, With<Dome>>,
) {
    dome.translation = camera.translation;
}
