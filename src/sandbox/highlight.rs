//! The picked body wears an outline: its shape, a little larger, seen from the inside.

use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::render::render_resource::Face;
use bevy_panorbit_camera::PanOrbitCamera;

use super::Selection;
use super::meshes::mesh_of;
use crate::physics::{Collider, Shape};

const OUTLINE_COLOR: Color = Color::srgb(1.0, 0.85, 0.1);
/// Of the camera's distance, so that it looks the same at any.
const THICKNESS: f32 = 0.004;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Update, outline_selection.after(super::actions::carry_out_actions));
}

#[derive(Component)]
struct Outline;

fn outline_selection(
    mut commands: Commands,
    mut selection: ResMut<Selection>,
    camera: Single<&PanOrbitCamera>,
    bodies: Query<&Collider>,
    outlines: Query<Entity, With<Outline>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if let Some(body) = selection.0
        && !bodies.contains(body)
    {
        selection.0 = None; // despawned by somebody else
    }
    if !selection.is_changed() {
        return;
    }
    for outline in &outlines {
        commands.entity(outline).try_despawn();
    }
    let thickness = f64::from(THICKNESS * camera.radius.unwrap_or(10.0));
    let Some(body) = selection.0 else { return };
    let Some(mesh) = bodies.get(body).ok().and_then(|collider| mesh_of(grown(collider.shape(), thickness))) else {
        return;
    };
    commands.spawn((
        Outline,
        ChildOf(body),
        Pickable::IGNORE,
        NotShadowCaster,
        NotShadowReceiver,
        Mesh3d(meshes.add(mesh)),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: OUTLINE_COLOR,
            unlit: true,
            fog_enabled: false,
            cull_mode: Some(Face::Front),
            ..default()
        })),
    ));
}

/// The shape with every face moved out by `thickness`. A cone's centre of mass moves against its
/// body's by less than the thickness, which does not show.
fn grown(shape: Shape, thickness: f64) -> Shape {
    match shape {
        Shape::HalfSpace => Shape::HalfSpace,
        Shape::Sphere { radius } => Shape::Sphere { radius: radius + thickness },
        Shape::Cuboid { size } => Shape::Cuboid { size: size + DVec3::splat(2.0 * thickness) },
        Shape::Cone { radius, height } => {
            let scale = 1.0 + thickness * (1.0 + radius.hypot(height) / radius) / height;
            Shape::Cone { radius: radius * scale, height: height * scale }
        }
    }
}
