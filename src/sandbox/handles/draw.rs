//! How handles look, and what is told of a drag.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::change::Change;
use super::handle::{Frame, Handle, MIDDLE};
use super::pull::{Pull, hovered, shown};
use crate::physics::RenderOrigin;

/// Of the axes x, y and z, and of what is for all of them.
const COLORS: [Color; 3] =
    [Color::srgb(0.93, 0.27, 0.25), Color::srgb(0.42, 0.80, 0.25), Color::srgb(0.26, 0.56, 0.96)];
const ALL: Color = Color::srgb(0.92, 0.92, 0.92);
const IN_HAND: Color = Color::srgb(1.0, 0.85, 0.1);
/// How strong what is on the far side of a ring is drawn.
const FAR: f32 = 0.25;
/// Sides of boxes and radius of the middle, of an arrow.
const BOX: f64 = 0.1;

/// In front of all bodies.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct HandleLines;

/// What is drawn.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Shown(Option<(Vec<Handle>, Frame, Option<Handle>)>);

/// Finds what is to be drawn: while a handle is dragged, that one.
pub fn find(world: &mut World) {
    let in_hand = world.resource::<Pull>().0.as_ref().map(|pulling| pulling.grip.handle);
    let found = shown(world).map(|(handles, frame)| match in_hand {
        Some(handle) => (vec![handle], frame, in_hand),
        None => {
            let hovered = hovered(world, &handles, &frame);
            (handles, frame, hovered)
        }
    });
    world.resource_mut::<Shown>().set_if_neq(Shown(found));
}

/// Draws handles.
pub fn draw(
    shown: Res<Shown>,
    origin: Res<RenderOrigin>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<HandleLines>,
) {
    let Some((handles, frame, in_hand)) = &shown.0 else { return };
    let drawn = |place: DVec3| (place - origin.0).as_vec3();
    let eye = camera.translation();
    for handle in handles {
        let own = handle.axis().map_or(ALL, |axis| COLORS[axis]);
        let color = if *in_hand == Some(*handle) { IN_HAND } else { own };
        let way: Vec<Vec3> = handle.way(frame).into_iter().map(drawn).collect();
        let size = frame.size as f32;
        match handle {
            Handle::Axis(_) => _ = gizmos.arrow(way[0], way[1], color).with_tip_length(0.16 * size),
            Handle::Plane(_) => {
                gizmos.linestrip(way.iter().copied(), color);
                gizmos.line(way[0], way[2], color);
            }
            Handle::Ring(_) => {
                let centre = drawn(frame.centre);
                let is_far = |point: Vec3| (point - centre).dot(eye - centre) < -1e-3 * size * eye.distance(centre);
                for piece in way.windows(2) {
                    let color = if is_far(piece[0].midpoint(piece[1])) { color.with_alpha(FAR) } else { color };
                    gizmos.line(piece[0], piece[1], color);
                }
            }
            Handle::Stretch(_) => {
                gizmos.line(way[0], way[1], color);
                gizmos.cube(square(frame, way[1], BOX), color);
            }
            Handle::Grow => gizmos.cube(square(frame, way[0], 1.6 * BOX), color),
            Handle::Free => _ = gizmos.sphere(way[0], (MIDDLE * frame.size) as f32, color).resolution(24),
        }
    }
}

fn square(frame: &Frame, at: Vec3, side: f64) -> Transform {
    let [x, y, z] = frame.axes.map(|axis| axis.as_vec3());
    let rotation = Quat::from_mat3(&Mat3::from_cols(x, y, z)).normalize();
    Transform { translation: at, rotation, scale: Vec3::splat((side * frame.size) as f32) }
}

/// Tells how far a handle has been dragged, beside the pointer.
pub fn tell(mut contexts: EguiContexts, pull: Res<Pull>) -> Result {
    let Some(change) = pull.0.as_ref().and_then(|pulling| pulling.change) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let Some(at) = context.pointer_latest_pos() else { return Ok(()) };
    let painter = context.layer_painter(egui::LayerId::new(egui::Order::Tooltip, egui::Id::new("handle")));
    let font = egui::FontId::monospace(14.0);
    let text = painter.layout_no_wrap(text_of(change), font, egui::Color32::WHITE);
    let place = egui::Rect::from_min_size(at + egui::vec2(18.0, 14.0), text.size());
    painter.rect_filled(place.expand(4.0), 3.0, egui::Color32::from_black_alpha(190));
    painter.galley(place.min, text, egui::Color32::WHITE);
    Ok(())
}

fn text_of(change: Change) -> String {
    match change {
        Change::Move(way) => {
            let parts = ["x", "y", "z"].into_iter().zip(way.to_array()).filter(|(_, part)| part.abs() > 5e-4);
            let parts: Vec<String> = parts.map(|(axis, part)| format!("{axis} {part:+.3} m")).collect();
            if parts.is_empty() { "0 m".to_owned() } else { parts.join("  ") }
        }
        Change::Turn(_, angle) => format!("{:+.1}°", angle.to_degrees()),
        Change::Scale(factors) => {
            let factor = factors.to_array().into_iter().find(|factor| *factor != 1.0).unwrap_or(1.0);
            format!("× {factor:.3}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_what_was_done() {
        assert_eq!(text_of(Change::Move(DVec3::new(0.3, 0.0, -1.25))), "x +0.300 m  z -1.250 m");
        assert_eq!(text_of(Change::Move(DVec3::ZERO)), "0 m");
        assert_eq!(text_of(Change::Turn(DVec3::X, std::f64::consts::FRAC_PI_6)), "+30.0°");
        assert_eq!(text_of(Change::Scale(DVec3::new(1.0, 1.5, 1.0))), "× 1.500");
    }
}
