//! The ground: half-spaces drawn as a large tiled plane that follows the camera.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::NotShadowCaster;
use bevy::math::{Affine2, DVec3};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_panorbit_camera::PanOrbitCamera;

use super::action::CarryOut;
use super::quality::Quality;
use crate::physics::{Collider, Position, RenderOrigin, RigidBody, Rotation, Shape};

/// Side of the drawn plane, m; the air hides its edge.
const SIDE: f32 = 8000.0;
/// Side of one tile, m: ten squares of a metre.
const TILE: f64 = 10.0;
/// Pixels along a tile.
const PIXELS: u32 = 1024;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Startup, make_assets).add_systems(Update, (spawn_grounds, follow_camera).chain().after(CarryOut));
}

#[derive(Resource)]
struct GroundAssets {
    mesh: Handle<Mesh>,
    material: Handle<StandardMaterial>,
}

/// The picture of a half-space. An entity of its own, because it moves with the camera.
#[derive(Component)]
pub(super) struct GroundOf(Entity);

impl GroundOf {
    /// The half-space.
    pub fn body(&self) -> Entity {
        self.0
    }
}

fn make_assets(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    quality: Res<Quality>,
) {
    commands.insert_resource(GroundAssets {
        mesh: meshes.add(Plane3d::new(Vec3::Y, Vec2::splat(SIDE / 2.0))),
        material: materials.add(StandardMaterial {
            base_color_texture: Some(images.add(tile_image(quality.anisotropy))),
            uv_transform: Affine2::from_scale(Vec2::splat(SIDE / TILE as f32)),
            perceptual_roughness: 0.95,
            reflectance: 0.15,
            ..default()
        }),
    });
}

fn spawn_grounds(
    mut commands: Commands,
    assets: Res<GroundAssets>,
    bodies: Query<(Entity, &Collider), (With<RigidBody>, Changed<Collider>)>,
) {
    for (body, collider) in &bodies {
        if *collider.shape() == Shape::HalfSpace {
            let (mesh, material) = (Mesh3d(assets.mesh.clone()), MeshMaterial3d(assets.material.clone()));
            commands.spawn((Name::new("ground"), GroundOf(body), NotShadowCaster, mesh, material));
        }
    }
}

/// Keeps each plane under the camera's focus, moved by whole tiles so that the pattern stays put;
/// removes it with its body.
fn follow_camera(
    mut commands: Commands,
    camera: Single<&PanOrbitCamera>,
    origin: Res<RenderOrigin>,
    bodies: Query<(&Position, &Rotation)>,
    mut grounds: Query<(Entity, &GroundOf, &mut Transform)>,
) {
    let focus = origin.0 + camera.focus.as_dvec3();
    for (entity, ground, mut transform) in &mut grounds {
        let Ok((position, rotation)) = bodies.get(ground.0) else {
            commands.entity(entity).despawn();
            continue;
        };
        let local = rotation.0.inverse() * (focus - position.0);
        let tile = DVec3::new((local.x / TILE).round() * TILE, 0.0, (local.z / TILE).round() * TILE);
        let centre = position.0 + rotation.0 * tile - origin.0;
        transform.set_if_neq(Transform::from_translation(centre.as_vec3()).with_rotation(rotation.0.as_quat()));
    }
}

/// One tile: squares of a metre in two close shades, thin lines between them, a stronger one
/// around the tile. With all its mip levels, since the plane reaches to the horizon.
fn tile_image(anisotropy: u16) -> Image {
    let mut level: Vec<[f32; 3]> = (0..PIXELS * PIXELS).map(|i| tile_color(i % PIXELS, i / PIXELS)).collect();
    let mut bytes = Vec::new();
    let mut side = PIXELS;
    let mut levels = 0;
    loop {
        bytes.extend(level.iter().flat_map(|&[r, g, b]| Color::linear_rgb(r, g, b).to_srgba().to_u8_array()));
        levels += 1;
        if side == 1 {
            break;
        }
        side /= 2;
        level = halved(&level, side);
    }
    let mut image = Image::new_uninit(
        Extent3d { width: PIXELS, height: PIXELS, depth_or_array_layers: 1 },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(bytes);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: anisotropy,
        ..default()
    });
    image
}

/// Linear color of a pixel of the tile.
fn tile_color(x: u32, y: u32) -> [f32; 3] {
    let metres = |pixel: u32| (pixel as f32 + 0.5) / PIXELS as f32 * TILE as f32;
    let (x, y) = (metres(x), metres(y));
    let to_line = |period: f32| {
        let to_nearest = |v: f32| (v - (v / period).round() * period).abs();
        to_nearest(x).min(to_nearest(y))
    };
    let light_square = (x.floor() + y.floor()) % 2.0 == 0.0;
    let shade = if to_line(TILE as f32) < 0.03 {
        0.55
    } else if to_line(1.0) < 0.012 {
        0.78
    } else if light_square {
        1.0
    } else {
        0.9
    };
    [0.36, 0.38, 0.40].map(|channel| channel * shade)
}

/// The mean of each 2×2 pixels.
fn halved(level: &[[f32; 3]], side: u32) -> Vec<[f32; 3]> {
    let pixel = |x: u32, y: u32| level[(y * side * 2 + x) as usize];
    let mean = |x: u32, y: u32| {
        let four = [pixel(2 * x, 2 * y), pixel(2 * x + 1, 2 * y), pixel(2 * x, 2 * y + 1), pixel(2 * x + 1, 2 * y + 1)];
        [0, 1, 2].map(|channel| four.iter().map(|color| color[channel]).sum::<f32>() / 4.0)
    };
    (0..side * side).map(|i| mean(i % side, i / side)).collect()
}
