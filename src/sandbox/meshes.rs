//! What bodies look like. A mesh sits on the body's own entity, so that picking finds the body.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::physics::{Collider, RigidBody, Shape};
use crate::scene::BodySpec;

/// The color of a body; without it, one is chosen from its shape.
#[derive(Component, Clone, Copy, Debug)]
pub(super) struct BodyColor(pub Color);

/// Gives a body the color that its description has.
pub(super) fn color(world: &mut World, body: Entity, described: &BodySpec) {
    if let Some([red, green, blue]) = described.color {
        world.entity_mut(body).insert(BodyColor(Color::srgb(red, green, blue)));
    }
}

/// Shades of dynamic bodies, sRGB, one row a shape: spheres, cuboids, cones. Neighbors in a
/// row differ enough to tell stacked boxes apart.
const PALETTE: [[[f32; 3]; 4]; 3] = [
    [[0.16, 0.62, 0.56], [0.25, 0.71, 0.60], [0.12, 0.52, 0.53], [0.42, 0.76, 0.66]],
    [[0.90, 0.44, 0.32], [0.94, 0.58, 0.36], [0.82, 0.34, 0.32], [0.96, 0.69, 0.45]],
    [[0.35, 0.40, 0.73], [0.47, 0.51, 0.82], [0.28, 0.32, 0.62], [0.58, 0.56, 0.85]],
];
const STATIC_COLOR: Color = Color::srgb(0.48, 0.50, 0.53);
const KINEMATIC_COLOR: Color = Color::srgb(0.55, 0.48, 0.62);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<SharedAssets>().add_systems(Update, dress_bodies);
}

/// Bodies alike share mesh and material, and are drawn in one batch.
#[derive(Resource, Default)]
struct SharedAssets {
    meshes: HashMap<[u64; 4], Handle<Mesh>>,
    materials: HashMap<[u32; 4], Handle<StandardMaterial>>,
    dressed: usize,
}

fn dress_bodies(
    mut commands: Commands,
    bodies: Query<(Entity, &RigidBody, &Collider, Option<&BodyColor>), Or<(Changed<Collider>, Changed<BodyColor>)>>,
    mut shared: ResMut<SharedAssets>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (entity, kind, collider, color) in &bodies {
        let Some(mesh) = mesh_of(collider.shape()) else { continue };
        let color = color.map_or_else(|| shared.choose_color(*kind, collider.shape()), |color| color.0);
        let mesh = shared.meshes.entry(shape_key(collider.shape())).or_insert_with(|| meshes.add(mesh)).clone();
        let material = shared
            .materials
            .entry(color.to_linear().to_f32_array().map(f32::to_bits))
            .or_insert_with(|| {
                materials.add(StandardMaterial {
                    base_color: color,
                    perceptual_roughness: 0.55,
                    reflectance: 0.35,
                    ..default()
                })
            })
            .clone();
        commands.entity(entity).insert((Mesh3d(mesh), MeshMaterial3d(material)));
    }
}

impl SharedAssets {
    fn choose_color(&mut self, kind: RigidBody, shape: Shape) -> Color {
        let row = match shape {
            Shape::Sphere { .. } => 0,
            Shape::Cuboid { .. } | Shape::HalfSpace => 1,
            Shape::Cone { .. } => 2,
        };
        match kind {
            RigidBody::Static => STATIC_COLOR,
            RigidBody::Kinematic => KINEMATIC_COLOR,
            RigidBody::Dynamic => {
                self.dressed += 1;
                let [red, green, blue] = PALETTE[row][self.dressed % 4];
                Color::srgb(red, green, blue)
            }
        }
    }
}

fn shape_key(shape: Shape) -> [u64; 4] {
    let (kind, x, y, z) = match shape {
        Shape::HalfSpace => (0, 0.0, 0.0, 0.0),
        Shape::Sphere { radius } => (1, radius, 0.0, 0.0),
        Shape::Cuboid { size } => (2, size.x, size.y, size.z),
        Shape::Cone { radius, height } => (3, radius, height, 0.0),
    };
    [kind, f64::to_bits(x), f64::to_bits(y), f64::to_bits(z)]
}

/// A shape about its centre of mass; none for the ground, which is drawn elsewhere.
pub(super) fn mesh_of(shape: Shape) -> Option<Mesh> {
    match shape {
        Shape::HalfSpace => None,
        Shape::Sphere { radius } => Sphere::new(radius as f32).mesh().ico(5).ok(),
        Shape::Cuboid { size } => Some(Cuboid::from_size(size.as_vec3()).into()),
        // Bevy's cone is centred half-way up; the centre of mass is a quarter up.
        Shape::Cone { radius, height } => Some(
            Cone { radius: radius as f32, height: height as f32 }
                .mesh()
                .resolution(64)
                .build()
                .translated_by(Vec3::Y * (height as f32 / 4.0)),
        ),
    }
}
