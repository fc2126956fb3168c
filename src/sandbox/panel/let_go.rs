//! Values that are taken once they are let go: what hangs on them takes a while to make.

use bevy_egui::egui;
use bevy_egui::egui::emath::Numeric;

/// A number to be dragged or typed; `held` is what it is while it is dragged. Tells it once it is let go, if it is another.
pub(super) fn once_let_go<N: Numeric>(
    ui: &mut egui::Ui,
    value: N,
    held: &mut Option<N>,
    drag: impl FnOnce(&mut N) -> egui::DragValue<'_>,
) -> Option<N> {
    let mut edited = held.unwrap_or(value);
    let is_dragged = ui.add(drag(&mut edited).update_while_editing(false)).dragged();
    *held = is_dragged.then_some(edited);
    (!is_dragged && edited != value).then_some(edited)
}
