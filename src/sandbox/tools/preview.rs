//! What a press would do, drawn where it would be done.

use std::f32::consts::PI;

use bevy::math::{DQuat, DVec3};
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use super::bar::{self, BarDraft};
use crate::physics::{Gravity, RenderOrigin, Rotation};
use crate::sandbox::aimed::Aimed;
use crate::sandbox::build::{self, BarEnd, JoinKind};
use crate::sandbox::camera;
use crate::sandbox::gizmos::ShownGizmos;
use crate::sandbox::held::Drag;
use crate::sandbox::timeline::ShownStep;
use crate::sandbox::{Selection, Tool, joint_click};
use crate::scene::{BodySpec, ShapeSpec, SurfaceForm, SurfaceSpec};

const WILL_BE: Color = Color::srgb(1.0, 0.85, 0.1);
const WILL_GO: Color = Color::srgb(1.0, 0.35, 0.25);
/// Radius of a dot, of its distance from the camera.
const DOT: f32 = 0.006;
/// Length of an axis on each side, of its distance from the camera.
const AXIS: f32 = 0.05;
/// How long a thrown ball's way is drawn, s, and in how many pieces.
const FLIGHT: f64 = 1.0;
const PIECES: usize = 24;
/// Lines over hills along each side.
const NET: usize = 20;

/// In front of all bodies.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct PreviewLines;

/// What is drawn; places of the world, m.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Preview {
    body: Option<BodySpec>,
    /// A way from place to place, and whether what is there would go.
    ways: Vec<(Vec<DVec3>, bool)>,
    dots: Vec<DVec3>,
    /// A place and a direction through it.
    axis: Option<(DVec3, DVec3)>,
    /// From a place, a unit direction.
    arrow: Option<(DVec3, DVec3)>,
}

/// Finds what the tool in hand would do.
pub fn find(world: &mut World) {
    let preview = of_tool(world).unwrap_or_default();
    world.resource_mut::<Preview>().set_if_neq(preview);
}

fn of_tool(world: &mut World) -> Option<Preview> {
    let tool = *world.resource::<Tool>();
    if tool == Tool::Measure || world.resource::<ShownStep>().step.is_some() {
        return None;
    }
    if tool == Tool::Drag || tool.has_handles() {
        return joint_to_pick(world);
    }
    if let Some(draft) = world.resource::<BarDraft>().0 {
        return Some(of_bar([draft.from, draft.to], draft.normal));
    }
    let aim = world.run_system_cached(camera::aim).ok().flatten().filter(|aim| aim.by_pointer)?;
    let aimed = world.run_system_cached_with(bar::under_pointer, PointerId::Mouse).ok().flatten();
    let dot = |aimed: &Aimed| vec![aimed.place];
    let preview = match tool {
        Tool::Drag | Tool::Move | Tool::Turn | Tool::Scale | Tool::Measure => return None,
        Tool::Push => Preview {
            arrow: aimed.filter(|aimed| !aimed.is_ground).map(|aimed| (aimed.place, aim.direction)),
            ..default()
        },
        Tool::Throw => {
            let (start, velocity) = build::throw(world, &aim);
            let gravity = world.get_resource::<Gravity>().map_or(DVec3::ZERO, |gravity| gravity.0);
            let at = |piece: usize| {
                let t = FLIGHT * piece as f64 / PIECES as f64;
                start + velocity * t + gravity * (0.5 * t * t)
            };
            Preview { ways: vec![((0..=PIECES).map(at).collect(), false)], ..default() }
        }
        Tool::Add => Preview { body: build::next_body(world).ok(), ..default() },
        Tool::Bar => {
            Preview { dots: bar::snapped(world, &aim).map(|end| end.place).into_iter().collect(), ..default() }
        }
        Tool::Join => of_join(world, aimed),
        Tool::Pin => {
            Preview { dots: aimed.filter(|aimed| !aimed.is_ground).as_ref().map(dot).unwrap_or_default(), ..default() }
        }
        Tool::Cut => {
            let ends = build::joint_at_pointer(world).and_then(|joint| build::ends_of(world, joint))?;
            Preview { ways: vec![(ends.to_vec(), true)], dots: ends.to_vec(), ..default() }
        }
    };
    Some(preview)
}

/// The joint that a click would pick.
fn joint_to_pick(world: &mut World) -> Option<Preview> {
    let selection = world.resource::<Selection>().clone();
    let are_drawn = world.resource::<ShownGizmos>().joints || selection.body.is_some();
    if !are_drawn || world.resource::<Drag>().is_active() {
        return None;
    }
    let aim = world.run_system_cached(camera::aim).ok().flatten().filter(|aim| aim.by_pointer)?;
    let place = world.run_system_cached_with(camera::seen_at, aim.origin + aim.direction * aim.distance).ok()??;
    let joint = joint_click::joint_at(world, place, &selection)?;
    let ends = build::ends_of(world, joint)?;
    Some(Preview { ways: vec![(ends.to_vec(), false)], dots: ends.to_vec(), ..default() })
}

fn of_join(world: &World, aimed: Option<Aimed>) -> Preview {
    let picked = world.resource::<Selection>().body;
    let first = picked.and_then(|first| build::place_of(world, first.entity, first.point));
    let Some(aimed) = aimed else { return Preview::default() };
    // The second click decides where the axis is, and must not be on the same body.
    let is_other = picked.is_some_and(|first| first.entity != aimed.picked.entity);
    let turned = world.get::<Rotation>(aimed.picked.entity).map_or(DQuat::IDENTITY, |rotation| rotation.0);
    let normal = aimed.picked.normal.map(|normal| turned * normal);
    let has_axis = world.resource::<JoinKind>().has_axis();
    Preview {
        ways: first.map(|first| (vec![first, aimed.place], false)).into_iter().collect(),
        dots: vec![aimed.place],
        axis: normal.filter(|_| has_axis && is_other).map(|normal| (aimed.place, normal)),
        ..default()
    }
}

fn of_bar(ends: [BarEnd; 2], axis: DVec3) -> Preview {
    let held = ends.iter().filter(|end| end.body.is_some()).map(|end| end.place);
    Preview { body: Some(build::bar_between(ends.map(|end| end.place), axis)), dots: held.collect(), ..default() }
}

/// Draws it.
pub fn draw(
    preview: Res<Preview>,
    origin: Res<RenderOrigin>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<PreviewLines>,
) {
    let eye = camera.translation();
    let drawn = |place: DVec3| (place - origin.0).as_vec3();
    for (way, goes) in &preview.ways {
        gizmos.linestrip(way.iter().map(|place| drawn(*place)), if *goes { WILL_GO } else { WILL_BE });
    }
    let goes = preview.ways.iter().any(|(_, goes)| *goes);
    for at in preview.dots.iter().map(|place| drawn(*place)) {
        gizmos.sphere(at, DOT * at.distance(eye), if goes { WILL_GO } else { WILL_BE }).resolution(16);
    }
    if let Some((place, direction)) = preview.axis {
        let (at, direction) = (drawn(place), direction.as_vec3());
        let reach = direction * (AXIS * at.distance(eye));
        gizmos.line(at - reach, at + reach, WILL_BE);
    }
    if let Some((place, direction)) = preview.arrow {
        let (at, direction) = (drawn(place), direction.as_vec3());
        // It ends where it hits, and begins aside, where it is seen.
        let side = direction.any_orthonormal_vector();
        let from = at - (direction + 0.6 * side).normalize() * (1.5 * AXIS * at.distance(eye));
        gizmos.arrow(from, at, WILL_BE);
    }
    if let Some(body) = &preview.body {
        draw_body(&mut gizmos, body, drawn(body.position));
    }
}

fn draw_body(gizmos: &mut Gizmos<PreviewLines>, body: &BodySpec, at: Vec3) {
    let turned = body.rotation.as_quat();
    let pose = Isometry3d::new(at, turned);
    match &body.shape {
        Some(ShapeSpec::Sphere { radius }) => _ = gizmos.sphere(pose, *radius as f32, WILL_BE).resolution(32),
        Some(ShapeSpec::Cuboid { size }) => {
            gizmos.cube(Transform { translation: at, rotation: turned, scale: size.as_vec3() }, WILL_BE);
        }
        Some(ShapeSpec::Capsule { radius, length }) => {
            let capsule = Capsule3d { radius: *radius as f32, half_length: 0.5 * *length as f32 };
            gizmos.primitive_3d(&capsule, pose, WILL_BE);
        }
        Some(ShapeSpec::Cylinder { radius, height }) => {
            gizmos.primitive_3d(&Cylinder::new(*radius as f32, *height as f32), pose, WILL_BE);
        }
        Some(ShapeSpec::Cone { radius, height }) => {
            let (radius, height) = (*radius as f32, *height as f32);
            // The centre of mass is a quarter up.
            let base = at - turned * Vec3::Y * (0.25 * height);
            let flat = Isometry3d::new(base, turned * Quat::from_rotation_x(0.5 * PI));
            gizmos.circle(flat, radius, WILL_BE);
            for quarter in 0..4 {
                let out = Quat::from_rotation_y(0.5 * PI * quarter as f32) * Vec3::X * radius;
                gizmos.line(base + turned * out, base + turned * Vec3::Y * height, WILL_BE);
            }
        }
        Some(ShapeSpec::Surface(surface)) => draw_surface(gizmos, surface, pose),
        Some(ShapeSpec::Hull(_) | ShapeSpec::Mesh(_) | ShapeSpec::Compound(_)) => {
            let radius = body.shape.as_ref().map_or(0.0, ShapeSpec::bounding_radius);
            gizmos.sphere(pose, radius as f32, WILL_BE).resolution(32);
        }
        Some(ShapeSpec::HalfSpace) | None => {}
    }
}

/// Lines over hills; the box that other triangles fill.
fn draw_surface(gizmos: &mut Gizmos<PreviewLines>, surface: &SurfaceSpec, pose: Isometry3d) {
    let vertices: Vec<Vec3> = surface.mesh().vertices().map(|vertex| vertex.as_vec3()).collect();
    if let SurfaceForm::Heights { rows, .. } = surface.form() {
        let columns = rows.first().map_or(0, Vec::len);
        let line = |places: &mut dyn Iterator<Item = usize>| {
            gizmos.linestrip(places.map(|place| pose * vertices[place]), WILL_BE);
        };
        return draw_net([columns, rows.len()], line);
    }
    let [low, high] = [Vec3::min, Vec3::max].map(|of| vertices.iter().copied().reduce(of).unwrap_or_default());
    let middle = pose * low.midpoint(high);
    let rotation = pose.rotation;
    gizmos.cube(Transform { translation: middle, rotation, scale: high - low }, WILL_BE);
}

/// Calls `line` with the numbers of the vertices along some rows and columns of a grid, the outer ones among them.
fn draw_net([columns, rows]: [usize; 2], mut line: impl FnMut(&mut dyn Iterator<Item = usize>)) {
    let some = |count: usize| (0..=NET).map(move |place| place * (count - 1) / NET);
    some(rows).for_each(|row| line(&mut (0..columns).map(|column| row * columns + column)));
    some(columns).for_each(|column| line(&mut (0..rows).map(|row| row * columns + column)));
}
