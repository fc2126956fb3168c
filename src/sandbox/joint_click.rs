//! A click on a joint as it is drawn picks it: its dots where one of its bodies is picked, its glyph where joints are shown.
//!
//! The button goes down on the body under it, too, which is dragged if the pointer moves: only a click that does not is one on
//! the joint.

use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use super::action::CarryOut;
use super::any_joint::IsJoint;
use super::gizmos::strokes_of_joints;
use super::pointer::{self, SLACK, is_down};
use super::{SandboxAction, Selection};

/// How near to its lines a joint is clicked, logical pixels.
const REACH: f32 = 8.0;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<JointClick>().add_systems(Update, (forget_gone, follow).chain().before(CarryOut));
}

/// The click that is going on.
#[derive(Resource, Default)]
pub(super) struct JointClick(Option<Click>);

#[derive(Clone, Copy)]
struct Click {
    joint: Entity,
    pointer: PointerId,
    from: Vec2,
}

/// The button went down; what was picked by then says which joints were drawn.
pub(super) fn press(world: &mut World, pointer: PointerId, from: Vec2, before: &Selection) {
    let joint = joint_at(world, from, before);
    world.resource_mut::<JointClick>().0 = joint.map(|joint| Click { joint, pointer, from });
}

/// The joint that is drawn at a place of the window, the nearest of several.
pub(super) fn joint_at(world: &mut World, place: Vec2, picked: &Selection) -> Option<Entity> {
    let bodies: Vec<Entity> = picked.bodies().collect();
    let drawn = world.run_system_cached_with(strokes_of_joints, bodies).ok()?;
    let mut cameras = world.query_filtered::<(&Camera, &GlobalTransform), With<Camera3d>>();
    let (camera, eye) = cameras.single(world).ok()?;
    let distance = |strokes: &[Vec<Vec3>]| {
        let seen = strokes.iter().map(|points| {
            points.iter().filter_map(|point| camera.world_to_viewport(eye, *point).ok()).collect::<Vec<Vec2>>()
        });
        seen.map(|points| distance_to(place, &points)).fold(f32::INFINITY, f32::min)
    };
    let distances = drawn.iter().map(|(joint, strokes)| (*joint, distance(strokes)));
    let nearest = distances.filter(|(_, distance)| *distance <= REACH).min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map(|(joint, _)| joint)
}

/// From a place to a line through points.
fn distance_to(place: Vec2, points: &[Vec2]) -> f32 {
    let to_piece = |piece: &[Vec2]| {
        let (from, along) = (piece[0], piece[1] - piece[0]);
        let share = ((place - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        place.distance(from + along * share)
    };
    match points {
        [] => f32::INFINITY,
        [only] => place.distance(*only),
        points => points.windows(2).map(to_piece).fold(f32::INFINITY, f32::min),
    }
}

/// Picks the joint once the button is up where it went down.
fn follow(world: &mut World) {
    let Some(click) = world.resource::<JointClick>().0 else { return };
    let stays = pointer::place(world).is_some_and(|at| at.distance(click.from) <= SLACK);
    let goes_on = is_down(world, click.pointer);
    if !stays || !goes_on {
        world.resource_mut::<JointClick>().0 = None;
    }
    if stays && !goes_on {
        world.write_message(SandboxAction::PickJoint(click.joint));
    }
}

/// A joint that is gone is picked no longer.
fn forget_gone(mut selection: ResMut<Selection>, joints: Query<(), IsJoint>) {
    if selection.joint.is_some_and(|joint| !joints.contains(joint)) {
        *selection = Selection::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_near_between_their_points_too() {
        let way = [Vec2::ZERO, Vec2::new(10.0, 0.0)];
        assert_eq!(distance_to(Vec2::new(5.0, 3.0), &way), 3.0);
        assert_eq!(distance_to(Vec2::new(13.0, 4.0), &way), 5.0);
        assert_eq!(distance_to(Vec2::new(3.0, 4.0), &way[..1]), 5.0);
    }
}
