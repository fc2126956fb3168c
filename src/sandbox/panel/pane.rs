//! A pane over the picture with an edge that can be dragged.
//!
//! It lies in an `Area`, because egui counts a panel of the background layer as part of the picture: the pointer over it would
//! pick the bodies behind it. And the area is no larger than what is seen of it: else it would take the clicks of all it covers
//! once it is in front.

use bevy_egui::egui;

/// How wide the edge is, points.
const EDGE: f32 = 6.0;

/// Which edge can be dragged.
#[derive(Clone, Copy)]
pub(super) enum Edge {
    Left,
    Top,
}

/// Draws a pane at that place; what is too large for it is cut off. How far its edge is dragged, and whether it is let go.
pub(super) fn show(
    context: &egui::Context,
    (id, edge): (egui::Id, Edge),
    place: egui::Rect,
    frame: egui::Frame,
    contents: impl FnOnce(&mut egui::Ui),
) -> (f32, bool) {
    let area = egui::Area::new(id.with("area")).fixed_pos(place.min).movable(false).constrain(false).fade_in(false);
    let shown = area.show(context, |ui| {
        let within = frame.total_margin().sum();
        frame.show(ui, |ui| {
            let inside = egui::Rect::from_min_size(ui.cursor().min, place.size() - within);
            let mut child = ui.new_child(egui::UiBuilder::new().max_rect(inside));
            child.shrink_clip_rect(inside);
            contents(&mut child);
            ui.advance_cursor_after_rect(inside);
        });
        let (size, cursor) = match edge {
            Edge::Left => (egui::vec2(EDGE, place.height()), egui::CursorIcon::ResizeHorizontal),
            Edge::Top => (egui::vec2(place.width(), EDGE), egui::CursorIcon::ResizeVertical),
        };
        let dragged = ui.interact(egui::Rect::from_min_size(place.min, size), id.with("edge"), egui::Sense::drag());
        if dragged.hovered() || dragged.dragged() {
            ui.ctx().set_cursor_icon(cursor);
        }
        let by = match edge {
            Edge::Left => -dragged.drag_delta().x,
            Edge::Top => -dragged.drag_delta().y,
        };
        (by, dragged.drag_stopped())
    });
    shown.inner
}
