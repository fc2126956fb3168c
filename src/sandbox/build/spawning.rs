//! A new body where the user looks: on the surface there, clear of everything else.

use bevy::math::{DQuat, DVec3};
use bevy::picking::mesh_picking::ray_cast::{MeshRayCast, MeshRayCastSettings, RayCastVisibility};
use bevy::prelude::*;

use super::blueprint::{Blueprint, noun_of};
use super::names::{name_of, unique_name};
use super::room::reach;
use super::undo::{Deed, remember};
use crate::physics::{
    Collider, CollisionLayers, Gravity, PlacedCollider, Position, RenderOrigin, RigidBody, Rotation, Velocity,
};
use crate::sandbox::CurrentScene;
use crate::sandbox::camera::{self, Aim};
use crate::sandbox::ground::GroundOf;
use crate::sandbox::snap::snap_of;
use crate::sandbox::state::report;
use crate::scene::{BodyColor, BodySpec, SceneEntity, SceneSpec};

/// A surface farther away than this many times the distance to what the camera orbits is scenery:
/// what is put there would hardly be seen.
const FARTHEST: f64 = 3.0;
/// Gap to the surface, in bounding radii: clear of it by any rounding, and too little to be seen
/// falling.
const GAP: f64 = 1e-3;
/// Least step up out of an overlap, in bounding radii, and how many are made at most.
const LIFT: f64 = 0.05;
const MOST_LIFTS: usize = 400;

/// Spawns what the [`Blueprint`] says.
pub fn spawn_body(world: &mut World) {
    let outcome = try_spawn(world).map(|name| format!("added {name}"));
    report(world, outcome);
}

fn try_spawn(world: &mut World) -> Result<String, String> {
    let body = next_body(world)?;
    let name = unique_name(world, &body.name);
    let body = BodySpec { name: name.clone(), ..body };
    let entity = body.spawn(world);
    remember(world, format!("adding {name}"), Deed::Added(vec![entity]));
    Ok(name)
}

/// What [`spawn_body`] would spawn where the user looks.
///
/// # Errors
/// It makes no sense, or there is no room for it.
pub fn next_body(world: &mut World) -> Result<BodySpec, String> {
    let blueprint = world.resource::<Blueprint>().clone();
    let body = blueprint.body(noun_of(&blueprint.shape).to_owned());
    let alone = SceneSpec { bodies: vec![body.clone()], ..SceneSpec::new("new body", DVec3::ZERO) };
    alone.validate().map_err(|error| error.to_string())?;
    let aim = world.run_system_cached(camera::aim).ok().flatten().ok_or("there is no picture to put a body into")?;
    let collider = blueprint.shape.collider();
    let surface = world.run_system_cached_with(surface, aim).ok().flatten();
    let surface = surface.map(|(point, normal)| (on_grid(world, point, normal), normal));
    let position = world
        .run_system_cached_with(find_room, (aim, surface, collider.clone(), body.principal_rotation()))
        .map_err(|error| error.to_string())?
        .ok_or("there is no room for a body")?;
    let body = BodySpec { position, ..body };
    if collider.shape().is_ground()
        && let Some(other) = in_the_way(world, &collider, &body)
    {
        return Err(format!("{other} is where {} would be: move it away, or point elsewhere", body.name));
    }
    Ok(body)
}

/// Throws a ball at what is aimed at.
pub fn throw_ball(world: &mut World) {
    let Some(aim) = world.run_system_cached(camera::aim).ok().flatten() else { return };
    let (start, velocity) = throw(world, &aim);
    let name = unique_name(world, "thrown ball");
    let ball = world.spawn((
        Name::new(name.clone()),
        SceneEntity,
        BodyColor([0.95, 0.76, 0.2]),
        RigidBody::Dynamic,
        Collider::sphere(radius_of_ball(world)),
        Position(start),
        Velocity { linear: velocity, ..default() },
    ));
    let ball = ball.id();
    remember(world, format!("throwing {name}"), Deed::Added(vec![ball]));
}

/// Where a thrown ball begins and how fast, m and m/s: no faster than a hard throw.
pub fn throw(world: &World, aim: &Aim) -> (DVec3, DVec3) {
    let start = aim.origin + aim.direction * (4.0 * radius_of_ball(world));
    (start, aim.direction * (2.0 * aim.distance).clamp(5.0, 20.0))
}

/// Of the size of the scene's bodies, from wherever one looks, m.
fn radius_of_ball(world: &World) -> f64 {
    size_of_bodies(world).clamp(0.1, 0.5)
}

/// Mean bounding radius of the bodies that the scene itself moves, m.
fn size_of_bodies(world: &World) -> f64 {
    let Some(scene) = world.get_resource::<CurrentScene>() else { return 0.0 };
    let moving = scene.spec.bodies.iter().filter(|body| body.kind == RigidBody::Dynamic);
    let radii: Vec<f64> = moving.filter_map(|body| Some(body.shape.as_ref()?.bounding_radius())).collect();
    radii.iter().sum::<f64>() / radii.len().max(1) as f64
}

/// The point of a surface nearest to which its coordinates are on the grid, where that is snapped to: along the axes across the
/// surface.
fn on_grid(world: &World, point: DVec3, normal: DVec3) -> DVec3 {
    let Some(grid) = snap_of(world) else { return point };
    let up = normal.abs().max_position();
    let mut snapped = grid.place(point);
    snapped[up] = point[up] - ((snapped - point) * (DVec3::ONE - DVec3::AXES[up])).dot(normal) / normal[up];
    snapped
}

/// The surface that is aimed at: a point, and the unit normal there, towards the camera.
pub fn surface(
    In(aim): In<Aim>,
    mut rays: MeshRayCast,
    grounds: Query<(), With<GroundOf>>,
    bodies: Query<(), (With<Collider>, With<RigidBody>)>,
    origin: Res<RenderOrigin>,
) -> Option<(DVec3, DVec3)> {
    let solid = |entity| bodies.contains(entity) || grounds.contains(entity);
    // What was spawned in this frame has not been found visible yet.
    let settings = MeshRayCastSettings::default().with_filter(&solid).with_visibility(RayCastVisibility::Any);
    let from = (aim.origin - origin.0).as_vec3();
    let direction = Dir3::new(aim.direction.as_vec3()).ok()?;
    let (_, hit) = rays.cast_ray(Ray3d::new(from, direction), &settings).first()?;
    if f64::from(hit.distance) >= FARTHEST * aim.distance {
        return None;
    }
    let normal = hit.normal.as_dvec3().normalize_or(DVec3::Y);
    let normal = if normal.dot(aim.direction) > 0.0 { -normal } else { normal }; // an open mesh's inside
    Some((origin.0 + hit.point.as_dvec3(), normal))
}

/// Where a body of that shape and orientation rests just above the surface that is aimed at, clear of all that
/// it would touch. None: everything for a long way up is full.
fn find_room(
    In((aim, surface, collider, rotation)): In<(Aim, Option<(DVec3, DVec3)>, Collider, DQuat)>,
    bodies: Query<(&Collider, &Position, &Rotation, Option<&CollisionLayers>), With<RigidBody>>,
    gravity: Res<Gravity>,
) -> Option<DVec3> {
    let size = collider.bounding_radius();
    let at = |position: DVec3| PlacedCollider {
        collider: &collider,
        position: Position(position),
        rotation: Rotation(rotation),
    };
    let mut position = match surface {
        Some((point, normal)) => point + normal * (reach(&collider, rotation, -normal) + GAP * size),
        None => aim.origin + aim.direction * aim.distance,
    };

    let up = (-gravity.0).normalize_or(DVec3::Y);
    if collider.shape().is_ground() {
        return Some(position); // nobody wants it over what stands there
    }
    // What lies on the way up, of thousands of bodies.
    let may_touch = |collider: &Collider, center: &Position| {
        let beside = (center.0 - position).reject_from(up).length();
        let reach = size + collider.bounding_radius();
        // The ground reaches everywhere.
        beside <= reach || !reach.is_finite()
    };
    let others: Vec<_> = bodies
        .iter()
        .filter(|(.., layers)| layers.is_none_or(|layers| layers.interact(CollisionLayers::ALL)))
        .filter(|(collider, center, ..)| may_touch(collider, center))
        .map(|(collider, position, rotation, _)| PlacedCollider { collider, position: *position, rotation: *rotation })
        .collect();
    for _ in 0..MOST_LIFTS {
        let deepest = others.iter().filter_map(|other| at(position).overlap(other)).reduce(f64::max);
        let Some(depth) = deepest else { return Some(position) };
        position += up * (depth + GAP * size).max(LIFT * size);
    }
    None
}

/// The name of a body that stands where a ground would be: in the box that it fills. Other grounds do not touch it.
fn in_the_way(world: &mut World, collider: &Collider, ground: &BodySpec) -> Option<String> {
    let extent = |collider: &Collider, position: DVec3, rotation: DQuat| {
        let ends = |sign: f64| {
            position + DVec3::from_array(DVec3::AXES.map(|axis| sign * reach(collider, rotation, sign * axis)))
        };
        [ends(-1.0), ends(1.0)]
    };
    let [low, high] = extent(collider, ground.position, ground.rotation);
    let mut bodies = world.query::<(Entity, &Collider, &Position, &Rotation)>();
    let is_in = |other: &Collider, position: DVec3, rotation: DQuat| {
        let distance = position.distance(ground.position);
        if other.shape().is_ground() || distance > collider.bounding_radius() + other.bounding_radius() {
            return false;
        }
        let [other_low, other_high] = extent(other, position, rotation);
        low.cmplt(other_high).all() && other_low.cmplt(high).all()
    };
    let found = bodies.iter(world).find(|(_, other, position, rotation)| is_in(other, position.0, rotation.0));
    let body = found.map(|(body, ..)| body)?;
    Some(name_of(world, body))
}
