//! Trails, tapes and the points that are watched, over the picture where the bodies are drawn.

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::picking::pointer::PointerInteraction;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::reader::{Reader, WatchedPoint};
use super::tape_start::TapeStart;
use super::tracks::{TRAIL, Track, Tracks};
use crate::physics::{RenderOrigin, RigidBody};
use crate::sandbox::axes::color32;
use crate::sandbox::panel::Quantity;
use crate::scene::{Probe, ProbeSubject};

/// Radius of a dot, of its distance from the camera.
const DOT: f32 = 0.005;
/// Of the tape that is being drawn.
const NEW_TAPE: Color = Color::srgb(1.0, 0.85, 0.1);

/// In front of all bodies, behind the marks of what is picked.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct ProbeLines;

/// Where points are drawn.
#[derive(SystemParam)]
pub struct Drawn<'w, 's> {
    bodies: Query<'w, 's, &'static Transform, With<RigidBody>>,
    origin: Res<'w, RenderOrigin>,
}

impl Drawn<'_, '_> {
    fn place(&self, point: &WatchedPoint) -> Option<Vec3> {
        let place = match point.body {
            Some(body) => {
                let pose = self.bodies.get(body).ok()?;
                pose.translation + pose.rotation * point.at.as_vec3()
            }
            None => (point.at - self.origin.0).as_vec3(),
        };
        place.is_finite().then_some(place)
    }
}

fn color([r, g, b]: [u8; 3]) -> Color {
    Color::srgb_u8(r, g, b)
}

/// All but the numbers.
pub fn draw(
    tracks: Res<Tracks>,
    tape: Res<TapeStart>,
    drawn: Drawn,
    pointers: Query<&PointerInteraction>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<ProbeLines>,
) {
    let eye = camera.translation();
    let dot = |gizmos: &mut Gizmos<ProbeLines>, at: Vec3, color: Color| {
        gizmos.sphere(at, DOT * at.distance(eye), color).resolution(12);
    };
    for track in tracks.tracks.iter().filter(|track| !track.is_gone) {
        let tint = color(track.color);
        match &track.probe {
            Probe::Plot(ProbeSubject::Point(point), _) if point.at != DVec3::ZERO => {
                drawn.place(point).into_iter().for_each(|at| dot(&mut gizmos, at, tint));
            }
            Probe::Plot(..) => {}
            Probe::Trail(point) => {
                let Some(at) = drawn.place(point) else { continue };
                gizmos.linestrip_gradient(faded(track, drawn.origin.0, at));
                dot(&mut gizmos, at, tint);
            }
            Probe::Tape(ends) => {
                let [Some(from), Some(to)] = [&ends[0], &ends[1]].map(|end| drawn.place(end)) else { continue };
                gizmos.line(from, to, tint);
                [from, to].into_iter().for_each(|at| dot(&mut gizmos, at, tint));
            }
        }
    }
    if let Some(from) = tape.from.and_then(|from| drawn.place(&from)) {
        dot(&mut gizmos, from, NEW_TAPE);
        let hits = pointers.iter().filter_map(|pointer| pointer.get_nearest_hit()?.1.position);
        hits.for_each(|to| gizmos.line(from, to, NEW_TAPE));
    }
}

/// A trail that fades with its age. The picture lags behind the last step: the trail ends where its point is drawn.
fn faded(track: &Track, origin: DVec3, end: Vec3) -> Vec<(Vec3, Color)> {
    let tint = color(track.color);
    let Some((_, now, _)) = track.trail.back() else { return Vec::new() };
    let alpha = |time: f64| (1.0 - (now - time) / TRAIL).clamp(0.0, 1.0) as f32;
    let before = track.trail.iter().take(track.trail.len() - 1);
    let points = before.map(|(_, time, place)| ((*place - origin).as_vec3(), tint.with_alpha(alpha(*time))));
    points.chain([(end, tint)]).filter(|(place, _)| place.is_finite()).collect()
}

/// The lengths of tapes, beside their middles and behind the panel.
pub fn draw_lengths(
    mut contexts: EguiContexts,
    tracks: Res<Tracks>,
    reader: Reader,
    drawn: Drawn,
    camera: Single<(&Camera, &GlobalTransform), With<Camera3d>>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let painter = context.layer_painter(egui::LayerId::new(egui::Order::Background, egui::Id::new("tapes")));
    for track in tracks.tracks.iter().filter(|track| !track.is_gone) {
        let Probe::Tape(ends) = &track.probe else { continue };
        let [Some(from), Some(to)] = [&ends[0], &ends[1]].map(|end| drawn.place(end)) else { continue };
        let Ok(middle) = camera.0.world_to_viewport(camera.1, from.midpoint(to)) else { continue };
        let at = (egui::pos2(middle.x, middle.y) / context.zoom_factor()) + egui::vec2(8.0, -8.0);
        let text = Quantity::text(reader.value(&track.probe), "m");
        let galley = painter.layout_no_wrap(text, egui::FontId::proportional(16.0), egui::Color32::WHITE);
        let place = egui::Align2::LEFT_BOTTOM.anchor_size(at, galley.size());
        let frame = egui::Stroke::new(2.0, color32(track.color));
        let fill = egui::Color32::from_black_alpha(215);
        painter.rect(place.expand2(egui::vec2(7.0, 4.0)), 4.0, fill, frame, egui::StrokeKind::Inside);
        painter.galley(place.min, galley, egui::Color32::WHITE);
    }
    Ok(())
}
