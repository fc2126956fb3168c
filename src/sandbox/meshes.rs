//! What bodies look like. A mesh sits on the body's own entity, so that picking finds the body.
//!
//! Balls, boxes and cones of one proportion share a mesh, and the scale of the body's transform, which physics neither reads
//! nor writes, makes it as large as the body: ten thousand boxes of as many sizes have one mesh.

use std::collections::HashMap;
use std::f32::consts::FRAC_PI_2;
use std::hash::{DefaultHasher, Hash, Hasher};

use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::NoCpuCulling;
use bevy::ecs::entity::EntityHashMap;
use bevy::math::DVec3;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::picking::mesh_picking::ray_cast::RayCastBackfaces;
use bevy::prelude::*;
use bevy::render::render_resource::Face;

use super::action::CarryOut;
use super::quality::Quality;
use super::state::CurrentScene;
use crate::physics::{Collider, Compound, CompoundChild, ConvexHull, Keep, RigidBody, Shape};
use crate::scene::{BodyColor, MeshSpec, PictureMesh};

/// Shades of dynamic bodies without a color, sRGB, one row a shape: spheres, cuboids, cones, hulls. Neighbors in a
/// row differ enough to tell stacked boxes apart.
const PALETTE: [[[f32; 3]; 4]; 4] = [
    [[0.16, 0.62, 0.56], [0.25, 0.71, 0.60], [0.12, 0.52, 0.53], [0.42, 0.76, 0.66]],
    [[0.90, 0.44, 0.32], [0.94, 0.58, 0.36], [0.82, 0.34, 0.32], [0.96, 0.69, 0.45]],
    [[0.35, 0.40, 0.73], [0.47, 0.51, 0.82], [0.28, 0.32, 0.62], [0.58, 0.56, 0.85]],
    [[0.62, 0.55, 0.47], [0.72, 0.64, 0.54], [0.53, 0.48, 0.43], [0.78, 0.72, 0.62]],
];
const STATIC_COLOR: Color = Color::srgb(0.48, 0.50, 0.53);
const KINEMATIC_COLOR: Color = Color::srgb(0.55, 0.48, 0.62);

pub(super) fn plugin(app: &mut App) {
    app.keep_look::<PictureSize>()
        .init_resource::<SharedAssets>()
        .add_systems(Update, (dress_bodies, size_pictures).chain().after(CarryOut));
}

/// What a body's mesh is scaled with.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(super) struct PictureSize(Vec3);

/// Gives transforms their scale, and again where a scene has gone back to where they had none.
pub(super) fn size_pictures(
    mut bodies: Query<(&mut Transform, &PictureSize), Or<(Changed<Transform>, Changed<PictureSize>)>>,
) {
    for (mut transform, size) in &mut bodies {
        if transform.scale != size.0 {
            transform.scale = size.0;
        }
    }
}

/// Bodies alike share mesh and material, and are drawn in one batch.
#[derive(Resource, Default)]
pub(super) struct SharedAssets {
    meshes: HashMap<Vec<u64>, Handle<Mesh>>,
    materials: HashMap<([u32; 4], bool), Handle<StandardMaterial>>,
    /// Which shade each body without a color of its own has: one that is deleted and comes back has it again.
    shades: EntityHashMap<usize>,
}

pub(super) fn dress_bodies(
    mut commands: Commands,
    scene: Option<Res<CurrentScene>>,
    bodies: Query<
        (Entity, &RigidBody, &Collider, Option<&PictureMesh>, Option<&BodyColor>),
        Or<(Changed<Collider>, Changed<PictureMesh>, Changed<BodyColor>)>,
    >,
    quality: Res<Quality>,
    mut shared: ResMut<SharedAssets>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if scene.is_some_and(|scene| scene.is_changed()) {
        shared.shades.clear();
    }
    for (entity, kind, collider, picture, color) in &bodies {
        let color = match color {
            Some(BodyColor([red, green, blue])) => Color::srgb(*red, *green, *blue),
            None => shared.choose_color(entity, *kind, collider.shape()),
        };
        let key = picture_key(collider.shape(), picture);
        let mesh = match shared.meshes.get(&key) {
            Some(mesh) => mesh.clone(),
            None => {
                let Some(mesh) = picture_of(collider.shape(), picture) else { continue };
                let mesh = meshes.add(mesh);
                shared.meshes.insert(key, mesh.clone());
                mesh
            }
        };
        // A mesh file may be open, or its triangles turned either way.
        let has_insides = picture.is_some() || matches!(collider.shape(), Shape::Mesh(_));
        let material = shared
            .materials
            .entry((color.to_linear().to_f32_array().map(f32::to_bits), has_insides))
            .or_insert_with(|| {
                materials.add(StandardMaterial {
                    base_color: color,
                    perceptual_roughness: 0.55,
                    reflectance: 0.35,
                    double_sided: has_insides,
                    cull_mode: (!has_insides).then_some(Face::Back),
                    ..default()
                })
            })
            .clone();
        let size = PictureSize(picture_size(collider.shape()));
        commands.entity(entity).insert((Mesh3d(mesh), MeshMaterial3d(material), size));
        if has_insides {
            commands.entity(entity).insert(RayCastBackfaces);
        }
        if quality.draws_what_it_sees {
            commands.entity(entity).insert(NoCpuCulling);
        }
    }
}

impl SharedAssets {
    fn choose_color(&mut self, body: Entity, kind: RigidBody, shape: &Shape) -> Color {
        let row = match shape {
            Shape::Sphere { .. } => 0,
            Shape::Cuboid { .. } | Shape::HalfSpace => 1,
            Shape::Cylinder { .. } | Shape::Cone { .. } => 2,
            Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_) => 3,
            Shape::Capsule { .. } => 0,
        };
        match kind {
            RigidBody::Static => STATIC_COLOR,
            RigidBody::Kinematic => KINEMATIC_COLOR,
            RigidBody::Dynamic => {
                let next = self.shades.len() % 4;
                let [red, green, blue] = PALETTE[row][*self.shades.entry(body).or_insert(next)];
                Color::srgb(red, green, blue)
            }
        }
    }
}

/// What the picture of a shape is scaled with: what [`picture_of`] makes is of size 1 where shapes of other sizes are as it is.
pub(super) fn picture_size(shape: &Shape) -> Vec3 {
    match shape {
        Shape::HalfSpace | Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_) => Vec3::ONE,
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => Vec3::splat(*radius as f32),
        Shape::Cuboid { size } => size.as_vec3(),
        // By one factor, so that its normals stay normals for whoever casts a ray at it.
        Shape::Cylinder { height, .. } | Shape::Cone { height, .. } => Vec3::splat(*height as f32),
    }
}

/// The same for bodies whose pictures differ in no more than their size.
fn picture_key(shape: &Shape, picture: Option<&PictureMesh>) -> Vec<u64> {
    if let Some(PictureMesh(mesh)) = picture {
        return vec![5, mesh.mesh().fingerprint, mesh.scale().to_bits(), mesh.most_pieces().map_or(0, u64::from)];
    }
    let (kind, sizes) = match shape {
        Shape::HalfSpace => (0, vec![]),
        Shape::Sphere { .. } => (1, vec![]),
        Shape::Cuboid { .. } => (2, vec![]),
        Shape::Cone { radius, height } => (3, vec![radius / height]),
        Shape::Cylinder { radius, height } => (9, vec![radius / height]),
        Shape::Capsule { radius, length } => (6, vec![length / radius]),
        Shape::Hull(hull) => (4, hull.vertices().flat_map(|vertex| vertex.to_array()).collect()),
        Shape::Compound(compound) => {
            let child = |child: &CompoundChild| {
                let pose = child.position.to_array().into_iter().chain(child.rotation.to_array()).map(f64::to_bits);
                let size = picture_size(child.collider.shape()).to_array().map(|size| u64::from(size.to_bits()));
                picture_key(child.collider.shape(), None).into_iter().chain(pose).chain(size).collect::<Vec<_>>()
            };
            return std::iter::once(7).chain(compound.children().iter().flat_map(child)).collect();
        }
        Shape::Mesh(mesh) => {
            let mut hasher = DefaultHasher::new();
            mesh.vertices().for_each(|vertex| vertex.to_array().map(f64::to_bits).hash(&mut hasher));
            mesh.triangles().hash(&mut hasher);
            return vec![8, hasher.finish()];
        }
    };
    std::iter::once(kind).chain(sizes.into_iter().map(f64::to_bits)).collect()
}

/// What a body looks like, about its centre of mass in its own axes, before it is scaled by its [`picture_size`]; none for the
/// ground, which is drawn elsewhere.
pub(super) fn picture_of(shape: &Shape, picture: Option<&PictureMesh>) -> Option<Mesh> {
    match (shape, picture) {
        (Shape::Hull(_) | Shape::Compound(_), Some(PictureMesh(mesh))) => Some(mesh_of_file(mesh)),
        (Shape::Sphere { .. }, _) => Some(ball(1.0).with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, ball_shades())),
        (Shape::Cuboid { .. }, _) => mesh_of(&Shape::Cuboid { size: DVec3::ONE }),
        (Shape::Capsule { radius, length }, _) => mesh_of(&Shape::Capsule { radius: 1.0, length: length / radius }),
        (Shape::Cylinder { radius, height }, _) => mesh_of(&Shape::Cylinder { radius: radius / height, height: 1.0 }),
        (Shape::Cone { radius, height }, _) => mesh_of(&Shape::Cone { radius: radius / height, height: 1.0 }),
        _ => mesh_of(shape),
    }
}

/// A shape about its centre of mass; none for the ground.
pub(super) fn mesh_of(shape: &Shape) -> Option<Mesh> {
    match shape {
        Shape::HalfSpace => None,
        Shape::Hull(hull) => Some(mesh_of_hull(hull)),
        Shape::Compound(compound) => Some(mesh_of_compound(compound)),
        Shape::Mesh(mesh) => {
            let vertices: Vec<Vec3> = mesh.vertices().map(|vertex| vertex.as_vec3()).collect();
            let corners = mesh.triangles().iter().flatten().map(|&corner| vertices[corner as usize]);
            Some(triangle_list(corners.collect()).with_computed_flat_normals())
        }
        Shape::Sphere { radius } => Some(ball(*radius as f32)),
        Shape::Cuboid { size } => Some(Cuboid::from_size(size.as_vec3()).into()),
        Shape::Capsule { radius, length } => {
            let capsule = Capsule3d { radius: *radius as f32, half_length: 0.5 * *length as f32 };
            Some(capsule.mesh().longitudes(64).latitudes(32).build())
        }
        Shape::Cylinder { radius, height } => {
            Some(Cylinder::new(*radius as f32, *height as f32).mesh().resolution(64).build())
        }
        // Bevy's cone is centred half-way up; the centre of mass is a quarter up.
        Shape::Cone { radius, height } => Some(
            Cone { radius: *radius as f32, height: *height as f32 }
                .mesh()
                .resolution(64)
                .build()
                .translated_by(Vec3::Y * (*height as f32 / 4.0)),
        ),
    }
}

/// Lines along a side of a ball's patch: as round as it must be to fill the window.
const PATCH: usize = 10;
/// Corners of a patch.
const PATCH_CORNERS: usize = (PATCH + 1) * (PATCH + 2) / 2;

/// Where the patches of a ball lie: one to each octant.
fn octants() -> impl Iterator<Item = Vec3> {
    let sign = |octant: usize, bit: usize| if octant >> bit & 1 == 0 { 1.0 } else { -1.0 };
    (0..8).map(move |octant| Vec3::new(sign(octant, 0), sign(octant, 1), sign(octant, 2)))
}

/// Eight patches that share no corner, so that each can have a shade of its own.
fn ball(radius: f32) -> Mesh {
    let mut normals = Vec::with_capacity(8 * PATCH_CORNERS);
    let mut indices: Vec<u32> = Vec::new();
    for (octant, signs) in octants().enumerate() {
        // Even along the sides, where the outline of a ball would show corners first.
        let share = |n: usize| (FRAC_PI_2 * n as f32 / PATCH as f32).sin();
        for i in 0..=PATCH {
            let row = (0..=PATCH - i).map(|j| signs * Vec3::new(share(i), share(j), share(PATCH - i - j)));
            normals.extend(row.map(Vec3::normalize));
        }
        // A row is one shorter than the one before.
        let corner = |i: usize, j: usize| (octant * PATCH_CORNERS + i * (2 * PATCH + 3 - i) / 2 + j) as u32;
        let mut face =
            |a: u32, b: u32, c: u32| indices.extend(if signs.element_product() > 0.0 { [a, b, c] } else { [a, c, b] });
        for (i, j) in (0..PATCH).flat_map(|i| (0..PATCH - i).map(move |j| (i, j))) {
            face(corner(i, j), corner(i + 1, j), corner(i, j + 1));
            if i + j + 1 < PATCH {
                face(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            }
        }
    }
    let corners: Vec<Vec3> = normals.iter().map(|normal| *normal * radius).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}

/// Two shades by turns: a ball of one would not be seen to roll.
fn ball_shades() -> Vec<[f32; 4]> {
    const DARK: f32 = 0.55;
    let shade = |octant: Vec3| if octant.element_product() > 0.0 { 1.0 } else { DARK };
    octants().flat_map(|octant| [[shade(octant), shade(octant), shade(octant), 1.0]; PATCH_CORNERS]).collect()
}

/// Flat faces.
fn mesh_of_hull(hull: &ConvexHull) -> Mesh {
    let vertices: Vec<Vec3> = hull.vertices().map(|vertex| vertex.as_vec3()).collect();
    let triangles = hull.faces().flat_map(|corners| {
        let fan = corners[1..].windows(2).map(|side| [corners[0], side[0], side[1]]);
        fan.flatten().map(|corner| vertices[corner as usize]).collect::<Vec<_>>()
    });
    triangle_list(triangles.collect()).with_computed_flat_normals()
}

/// The children where they are, as one list of triangles.
fn mesh_of_compound(compound: &Compound) -> Mesh {
    let (mut corners, mut normals) = (Vec::new(), Vec::new());
    for child in compound.children() {
        let Some(mut mesh) = mesh_of(child.collider.shape()) else { continue };
        mesh.duplicate_vertices();
        let (at, turn) = (child.position.as_vec3(), child.rotation.as_quat());
        let floats = |name| mesh.attribute(name).and_then(VertexAttributeValues::as_float3).unwrap_or_default();
        corners.extend(floats(Mesh::ATTRIBUTE_POSITION).iter().map(|&place| at + turn * Vec3::from(place)));
        normals.extend(floats(Mesh::ATTRIBUTE_NORMAL).iter().map(|&normal| turn * Vec3::from(normal)));
    }
    triangle_list(corners).with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
}

/// The triangles of a mesh file, from the body's centre of mass, in its principal axes.
fn mesh_of_file(spec: &MeshSpec) -> Mesh {
    let (mesh, center) = (spec.mesh(), spec.center());
    let to_body = spec.axes().inverse();
    let place = |corner: u32| (to_body * (mesh.positions[corner as usize] * spec.scale() - center)).as_vec3();
    let triangles = triangle_list(mesh.triangles.iter().flatten().map(|&corner| place(corner)).collect());
    if mesh.normals.is_empty() {
        return triangles.with_computed_flat_normals();
    }
    let to_body = to_body.as_quat();
    let normals: Vec<Vec3> = mesh.normals.iter().flatten().map(|&normal| to_body * normal).collect();
    triangles.with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
}

/// Three corners a triangle.
fn triangle_list(corners: Vec<Vec3>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
}
