//! A bar between two places, on hinges to what is there.

use bevy::math::{DMat3, DQuat, DVec3};
use bevy::prelude::*;

use super::blueprint::{Blueprint, Weight};
use super::join_kind::anchor_at;
use super::names::{name_of, unique_name};
use super::undo::{Deed, remember};
use crate::physics::HingeJoint;
use crate::sandbox::Selection;
use crate::scene::{BodySpec, SceneEntity, ShapeSpec};

/// Thickness of a bar over its length, and the least and the most, m.
const THICKNESS: f64 = 0.08;
const THICKNESSES: (f64, f64) = (0.04, 0.2);

/// Where a bar ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarEnd {
    /// What it hangs on there, if on anything.
    pub body: Option<Entity>,
    /// Where the hinge is, world, m.
    pub place: DVec3,
}

/// The body of a bar with its hinges at two places, which it outreaches by half its thickness; its length lies along its x,
/// their axis, as near to that unit vector as can be, along its z.
pub fn bar_between(places: [DVec3; 2], axis: DVec3) -> BodySpec {
    let [from, to] = places;
    let along = (to - from).normalize_or(DVec3::X);
    let across = (axis - along * axis.dot(along)).normalize_or(along.any_orthonormal_vector());
    let rotation = DQuat::from_mat3(&DMat3::from_cols(along, across.cross(along), across));
    let length = from.distance(to);
    let thickness = (THICKNESS * length).clamp(THICKNESSES.0, THICKNESSES.1);
    let shape = ShapeSpec::Cuboid { size: DVec3::new(length + thickness, thickness, thickness) };
    BodySpec { rotation, ..BodySpec::new("bar", shape, from.midpoint(to)) }
}

/// Makes that bar, of the blueprint's density, and picks it. What was done, or why nothing was.
pub fn add_bar(world: &mut World, ends: [BarEnd; 2], axis: DVec3) -> Result<String, String> {
    let name = unique_name(world, "bar");
    let mut body = BodySpec { name: name.clone(), ..bar_between(ends.map(|end| end.place), axis) };
    if let Weight::Density(density) = world.resource::<Blueprint>().weight {
        body.density = density;
    }
    let bar = body.spawn(world);
    let mut made = vec![bar];
    let mut held = Vec::new();
    for end in ends {
        let Some(partner) = end.body else { continue };
        let anchors = [partner, bar].map(|body| anchor_at(world, body, end.place));
        let [Some(on_partner), Some(on_bar)] = anchors else { continue };
        let what = name_of(world, partner);
        let hinge = HingeJoint::new(partner, bar).with_anchors(on_partner, on_bar).with_axis(axis);
        made.push(world.spawn((Name::new(format!("{what} to {name}")), SceneEntity, hinge)).id());
        held.push(what);
    }
    world.insert_resource(Selection::of(bar));
    remember(world, format!("adding {name}"), Deed::Added(made));
    Ok(match held.is_empty() {
        true => format!("added {name}, which hangs on nothing"),
        false => format!("added {name} on {}", held.join(" and ")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_lies_along_x_and_its_hinges_along_z() {
        let bar = bar_between([DVec3::ZERO, DVec3::Y * 2.0], DVec3::Z);
        assert_eq!(bar.position, DVec3::Y);
        assert_eq!(bar.shape, Some(ShapeSpec::Cuboid { size: DVec3::new(2.16, 0.16, 0.16) }));
        assert!((bar.rotation * DVec3::X).abs_diff_eq(DVec3::Y, 1e-12));
        assert!((bar.rotation * DVec3::Z).abs_diff_eq(DVec3::Z, 1e-12));
    }
}
