//! What is picked: each body wears an outline (its picture, a little larger, seen from the inside),
//! the place that was clicked a dot, and its joints are drawn.

use std::collections::{HashMap, HashSet};

use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::math::DVec3;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::render::render_resource::Face;
use bevy_panorbit_camera::PanOrbitCamera;

use super::Selection;
use super::any_joint::{AnyJoint, IsJoint};
use super::in_front::in_front;
use super::meshes::{mesh_of, picture_of, picture_size};
use crate::physics::{Collider, RigidBody, Shape};
use crate::scene::{PictureMesh, SceneEntity};

/// Of bodies that are picked, and of the one that the first may be joined to.
const COLORS: [Color; 2] = [Color::srgb(1.0, 0.85, 0.1), Color::srgb(0.34, 0.71, 0.91)];
/// Radius of a dot, of the camera's distance.
const DOT: f32 = 0.006;
/// Of the camera's distance, so that it looks the same at any.
const THICKNESS: f32 = 0.004;

pub(super) fn plugin(app: &mut App) {
    in_front::<Marks>(app, 1.0, 2.0);
    app.add_systems(Update, outline_selection.after(super::carry_out::carry_out_actions))
        .add_systems(PostUpdate, draw_marks.before(TransformSystems::Propagate));
}

#[derive(Component)]
struct Outline;

fn outline_selection(
    mut commands: Commands,
    mut selection: ResMut<Selection>,
    camera: Single<&PanOrbitCamera>,
    bodies: Query<(Ref<Collider>, Option<&PictureMesh>)>,
    outlines: Query<Entity, With<Outline>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // Despawned by somebody else.
    if selection.partner.is_some_and(|picked| !bodies.contains(picked.entity)) {
        selection.partner = None;
    }
    if selection.others.iter().any(|other| !bodies.contains(*other)) {
        selection.others.retain(|other| bodies.contains(*other));
    }
    if selection.body.is_some_and(|picked| !bodies.contains(picked.entity)) {
        let left: Vec<Entity> = selection.bodies().skip(1).collect();
        *selection = Selection::of_bodies(left);
    }
    let is_new = |body| bodies.get(body).is_ok_and(|(collider, _)| collider.is_changed());
    if !selection.is_changed() && !selection.bodies().any(is_new) {
        return;
    }
    for outline in &outlines {
        commands.entity(outline).try_despawn();
    }
    let thickness = THICKNESS * camera.radius.unwrap_or(10.0);
    let partner = selection.partner.map(|picked| picked.entity);
    let materials = COLORS.map(|base_color| {
        let cull_mode = Some(Face::Front);
        materials.add(StandardMaterial { base_color, unlit: true, fog_enabled: false, cull_mode, ..default() })
    });
    // Bodies of one shape, one after the other, share their outline.
    let mut last: Option<(Shape, Handle<Mesh>)> = None;
    for entity in selection.bodies() {
        let Ok((collider, picture)) = bodies.get(entity) else { continue };
        let shape = collider.shape();
        let mesh = match last.as_ref().filter(|(other, _)| other == shape && picture.is_none()) {
            Some((_, mesh)) => mesh.clone(),
            None => {
                let mesh = match shape {
                    Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_) => {
                        picture_of(shape, picture).map(|mesh| inflated(mesh, thickness))
                    }
                    shape => mesh_of(&grown(shape, f64::from(thickness))),
                };
                let Some(mesh) = mesh else { continue };
                meshes.add(mesh)
            }
        };
        last = Some((shape.clone(), mesh.clone()));
        commands.spawn((
            Outline,
            ChildOf(entity),
            Pickable::IGNORE,
            NotShadowCaster,
            NotShadowReceiver,
            Mesh3d(mesh),
            // It is as large as it is, however its body's picture is scaled.
            Transform::from_scale(picture_size(shape).recip()),
            MeshMaterial3d(materials[usize::from(partner == Some(entity))].clone()),
        ));
    }
}

/// Drawn over everything: a joint lies inside its bodies.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Marks;

/// A dot where each body was clicked; of each joint that the scene or the user gave it a dot, with
/// lines to the centers of mass that it holds.
fn draw_marks(
    selection: Res<Selection>,
    poses: Query<(&RigidBody, &Transform)>,
    joints: Query<(Entity, AnyJoint), (IsJoint, With<SceneEntity>)>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<Marks>,
) {
    let eye = camera.translation();
    let place = |pose: &Transform, point: DVec3| pose.translation + pose.rotation * point.as_vec3();
    for (picked, color) in selection.picks().zip(COLORS) {
        let Ok((_, pose)) = poses.get(picked.entity) else { continue };
        let clicked = place(pose, picked.point);
        gizmos.sphere(clicked, DOT * clicked.distance(eye), color).resolution(16);
    }
    let bodies: HashSet<Entity> = selection.bodies().collect();
    if bodies.is_empty() && selection.joint.is_none() {
        return;
    }
    for (entity, joint) in &joints {
        let Some(joint) = joint.component() else { continue };
        let is_picked = selection.joint == Some(entity);
        if !is_picked && !joint.bodies().iter().any(|body| bodies.contains(body)) {
            continue;
        }
        let (color, size) = if is_picked { (COLORS[0], 1.4) } else { (Color::WHITE, 0.7) };
        for (body, anchor) in joint.ends() {
            let Ok((kind, pose)) = poses.get(body) else { continue };
            let end = place(pose, anchor);
            gizmos.sphere(end, size * DOT * end.distance(eye), color).resolution(12);
            if *kind == RigidBody::Dynamic {
                gizmos.line(pose.translation, end, color);
            }
        }
    }
}

/// The shape with every face moved out by `thickness`. A cone's centre of mass moves against its
/// body's by less than the thickness, which does not show.
fn grown(shape: &Shape, thickness: f64) -> Shape {
    match shape {
        Shape::HalfSpace | Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_) => shape.clone(),
        Shape::Sphere { radius } => Shape::Sphere { radius: radius + thickness },
        Shape::Cuboid { size } => Shape::Cuboid { size: *size + DVec3::splat(2.0 * thickness) },
        Shape::Capsule { radius, length } => Shape::Capsule { radius: radius + thickness, length: *length },
        Shape::Cylinder { radius, height } => {
            Shape::Cylinder { radius: radius + thickness, height: height + 2.0 * thickness }
        }
        Shape::Cone { radius, height } => {
            let scale = 1.0 + thickness * (1.0 + radius.hypot(*height) / radius) / height;
            Shape::Cone { radius: radius * scale, height: height * scale }
        }
    }
}

/// A list of triangles with every corner moved out by about `thickness`: along the mean of the
/// normals that meet there, so that no gap opens at an edge.
fn inflated(mut mesh: Mesh, thickness: f32) -> Mesh {
    let floats = |name| mesh.attribute(name).and_then(VertexAttributeValues::as_float3).unwrap_or_default().to_vec();
    let (corners, normals) = (floats(Mesh::ATTRIBUTE_POSITION), floats(Mesh::ATTRIBUTE_NORMAL));
    let place = |corner: &[f32; 3]| corner.map(f32::to_bits);
    let mut outward: HashMap<[u32; 3], Vec3> = HashMap::new();
    for (corner, &normal) in corners.iter().zip(&normals) {
        *outward.entry(place(corner)).or_default() += Vec3::from(normal);
    }
    let moved: Vec<Vec3> = corners
        .iter()
        .map(|corner| Vec3::from(*corner) + outward[&place(corner)].normalize_or_zero() * thickness)
        .collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, moved);
    mesh
}
