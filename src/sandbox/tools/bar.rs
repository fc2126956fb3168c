//! Bars, drawn from where the button goes down to where it goes up: limbs and linkages are made of them.
//!
//! A bar lies in the plane through where it begins whose normal is that axis of the world along which one looks most. Its ends
//! hang on hinges about that normal: on the body or the ground that they meet, and on the ends of other bars, which draw the
//! pointer to them.

use bevy::math::DVec3;
use bevy::picking::hover::HoverMap;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use crate::physics::{Collider, Position, RigidBody, Rotation, Shape};
use crate::sandbox::aimed::{Aimed, Targets};
use crate::sandbox::build::{self, BarEnd};
use crate::sandbox::camera::{self, Aim};
use crate::sandbox::pointer::is_down;
use crate::sandbox::snap::snap_of;
use crate::sandbox::state::report;

/// A bar's end draws the pointer from within this angle, rad.
const SNAP: f64 = 0.02;
/// How many times as long as thick a box is that has ends.
const SLENDER: f64 = 3.0;
/// A surface is met by an end that is as near to it as this share of the bar's length, or seems as near as an end that draws
/// the pointer.
const MEETS: f64 = 0.12;
/// A shorter bar is none: a click, m.
const SHORTEST: f64 = 0.05;

/// The bar that is being drawn.
#[derive(Resource, Default)]
pub struct BarDraft(pub(super) Option<Draft>);

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Draft {
    pub from: BarEnd,
    pub to: BarEnd,
    /// Of the plane that it is drawn in: an axis of the world.
    pub normal: DVec3,
    pointer: PointerId,
}

/// The button goes down.
pub fn begin(world: &mut World, aimed: Option<Aimed>, pointer: PointerId) {
    let Some(aim) = world.run_system_cached(camera::aim).ok().flatten() else { return };
    let normal = nearest_axis(aim.direction);
    let free = aim.origin + aim.direction * aim.distance;
    let from = match snapped(world, &aim) {
        Some(end) => end,
        None => match aimed {
            Some(aimed) if aimed.is_ground => BarEnd { body: Some(aimed.picked.entity), place: aimed.place },
            // In the plane of the body's centre of mass: bars on each other lie in one.
            Some(aimed) => {
                let body = aimed.picked.entity;
                let centre = world.get::<Position>(body).map_or(aimed.place, |centre| centre.0);
                BarEnd { body: Some(body), place: aimed.place + normal * normal.dot(centre - aimed.place) }
            }
            None => BarEnd { body: None, place: free },
        },
    };
    world.resource_mut::<BarDraft>().0 = Some(Draft { from, to: from, normal, pointer });
}

/// The axis of the world that is nearest to a direction, against it.
fn nearest_axis(direction: DVec3) -> DVec3 {
    let place = direction.abs().max_position();
    DVec3::AXES[place] * -direction[place].signum()
}

/// The end of a bar that the pointer is at, if it is at one.
pub(super) fn snapped(world: &mut World, aim: &Aim) -> Option<BarEnd> {
    let mut bodies = world.query::<(Entity, &RigidBody, &Collider, &Position, &Rotation)>();
    let ends = bodies.iter(world).filter(|(_, kind, ..)| **kind == RigidBody::Dynamic).flat_map(
        |(entity, _, collider, position, rotation)| {
            let arm = ends_of(collider.shape()).map(|arm| rotation.0 * arm);
            let both = arm.map_or([None; 2], |arm| [Some(arm), Some(-arm)]);
            both.into_iter().flatten().map(move |arm| BarEnd { body: Some(entity), place: position.0 + arm })
        },
    );
    let angles = ends.map(|end| (aim.direction.angle_between(end.place - aim.origin), end));
    angles.filter(|(angle, _)| *angle < SNAP).min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, end)| end)
}

/// From the centre of a slender box to the middle of one end, less half its thickness, where the hinge of a bar is.
fn ends_of(shape: &Shape) -> Option<DVec3> {
    let Shape::Cuboid { size } = *shape else { return None };
    let long = size.max_position();
    let thick = (0..3).filter(|axis| *axis != long).map(|axis| size[axis]).fold(0.0, f64::max);
    (size[long] >= SLENDER * thick).then(|| DVec3::AXES[long] * (0.5 * (size[long] - thick)))
}

/// Has the bar's end follow the pointer, and makes the bar once the button is up.
pub fn follow(world: &mut World) {
    let Some(mut draft) = world.resource::<BarDraft>().0 else { return };
    if let Some(aim) = world.run_system_cached(camera::aim).ok().flatten() {
        if let Some(end) = end_at(world, &draft, &aim) {
            draft.to = end;
        }
        world.resource_mut::<BarDraft>().0 = Some(draft);
    }
    if is_down(world, draft.pointer) {
        return;
    }
    world.resource_mut::<BarDraft>().0 = None;
    let Draft { from, to, normal, .. } = draft;
    let made = match from.place.distance(to.place) {
        length if length < SHORTEST => Err("hold the button, and let go where the bar is to end".into()),
        _ => build::add_bar(world, [from, to], normal),
    };
    report(world, made);
}

/// The end of a bar where the pointer is.
fn end_at(world: &mut World, draft: &Draft, aim: &Aim) -> Option<BarEnd> {
    if let Some(end) = snapped(world, aim).filter(|end| end.place.distance(draft.from.place) > SHORTEST) {
        return Some(end);
    }
    let along = aim.direction.dot(draft.normal);
    let way = draft.normal.dot(draft.from.place - aim.origin) / along;
    if !(way.is_finite() && way > 0.0) {
        return None;
    }
    let place = aim.origin + aim.direction * way;
    // In its plane.
    let place = snap_of(world).map_or(place, |snap| {
        let snapped = snap.place(place);
        snapped + draft.normal * draft.normal.dot(place - snapped)
    });
    let met = world.run_system_cached_with(under_pointer, draft.pointer).ok().flatten();
    let near = (MEETS * place.distance(draft.from.place)).max(SNAP * way);
    let met = met.filter(|met| Some(met.picked.entity) != draft.from.body);
    Some(match met {
        Some(met) if met.is_ground && met.place.distance(place) < near => {
            BarEnd { body: Some(met.picked.entity), place: met.place }
        }
        Some(met) if !met.is_ground && draft.normal.dot(met.place - place).abs() < near => {
            BarEnd { body: Some(met.picked.entity), place }
        }
        _ => BarEnd { body: None, place },
    })
}

/// What a pointer is on.
pub(super) fn under_pointer(In(pointer): In<PointerId>, hover: Res<HoverMap>, targets: Targets) -> Option<Aimed> {
    let hits = hover.get(&pointer)?;
    let seen = hits.iter().filter_map(|(entity, hit)| Some((hit.depth, targets.aimed(*entity, hit)?)));
    seen.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, aimed)| aimed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_draws_across_the_view() {
        assert_eq!(nearest_axis(DVec3::new(0.2, -0.4, -0.9)), DVec3::Z);
        assert_eq!(nearest_axis(DVec3::new(0.9, -0.4, 0.1)), -DVec3::X);
        assert_eq!(nearest_axis(DVec3::new(0.1, -0.9, 0.3)), DVec3::Y);
    }

    #[test]
    fn long_boxes_have_ends() {
        let long = Shape::Cuboid { size: DVec3::new(0.1, 1.1, 0.1) };
        assert!(ends_of(&long).unwrap().abs_diff_eq(DVec3::Y * 0.5, 1e-12));
        assert_eq!(ends_of(&Shape::Cuboid { size: DVec3::ONE }), None);
        assert_eq!(ends_of(&Shape::Sphere { radius: 1.0 }), None);
    }
}
