//! The inspector: what the picked body is and what holds it, or what the picked joint is, over the picture; of several bodies,
//! what can be done with all of them.
//!
//! It opens where a click picks a body or a joint, in the other half of the picture, so that what is near stays in reach, and
//! stays until another is picked or none; while Shift is held, which picks a second, it gives way. A body that is dragged is played with, and
//! not inspected.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::egui;

use super::body::{self, Described};
use super::run::run;
use super::strip::STRIP_HEIGHT;
use super::{many, selection};
use crate::sandbox::Selection;
use crate::sandbox::held::Drag;
use crate::sandbox::joint_readings::ReadJoints;
use crate::sandbox::pointer::SLACK;
use crate::sandbox::state::{Covered, SHIFT_KEYS};

/// How wide it is, and what is left free at the edges and of the tools, points.
const WIDTH: f32 = 304.0;
const MARGIN: f32 = 8.0;
const TOOLS: f32 = 80.0;

/// Whether the inspector is open, and of what.
#[derive(Resource, Default)]
pub(super) struct Inspector {
    of: Option<Entity>,
    /// How many bodies are picked.
    count: usize,
    /// Where the pointer was when it opened; until it is drawn.
    opened_at: Option<Vec2>,
    is_hidden: bool,
    /// Where the pointer was when the drag that is going on began, and whether it has moved since.
    drag: Option<(Vec2, bool)>,
}

/// Opens it where another body is picked, or the same is clicked again.
pub(super) fn follow(
    selection: Res<Selection>,
    drag: Res<Drag>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut inspector: ResMut<Inspector>,
) {
    let pointer = window.cursor_position().unwrap_or(Vec2::new(0.5 * window.width(), 0.3 * window.height()));
    let inspector = inspector.bypass_change_detection();
    let (of, count) = (selection.entity().or(selection.joint), selection.bodies().count());
    if (of, count) != (inspector.of, inspector.count) {
        *inspector = Inspector { of, count, opened_at: Some(pointer), ..default() };
    }
    match (&mut inspector.drag, drag.is_active()) {
        (None, true) => inspector.drag = Some((pointer, false)),
        (Some((from, has_moved)), true) => *has_moved |= from.distance(pointer) > SLACK,
        (Some((_, has_moved)), false) => {
            inspector.is_hidden = *has_moved;
            inspector.opened_at = Some(pointer);
            inspector.drag = None;
        }
        (None, false) => {}
    }
}

/// Draws it over the picture.
pub(super) fn show(context: &egui::Context, world: &mut World) -> Result {
    let Covered { right, bottom } = *world.resource::<Covered>();
    let gives_way = world.resource::<ButtonInput<KeyCode>>().any_pressed(SHIFT_KEYS);
    let is_pressed =
        world.get_resource::<ButtonInput<MouseButton>>().is_some_and(|mouse| mouse.pressed(MouseButton::Left));
    let mut inspector = world.resource_mut::<Inspector>();
    // It comes once the button is up that picked.
    let waits = inspector.drag.is_some() || is_pressed && inspector.opened_at.is_some();
    let is_open = inspector.of.is_some() && !inspector.is_hidden && !waits && !gives_way;
    if !is_open {
        if !world.resource::<ReadJoints>().open.is_empty() {
            world.resource_mut::<ReadJoints>().open.clear();
        }
        return Ok(());
    }
    let zoom = context.zoom_factor();
    let screen = context.content_rect();
    let free = egui::Rect::from_min_max(
        screen.min + egui::Vec2::splat(MARGIN),
        egui::pos2(screen.right() - right / zoom - MARGIN, screen.bottom() - bottom / zoom - STRIP_HEIGHT - MARGIN),
    );
    let opened_at = inspector.opened_at.take();
    let mut stays = true;
    let mut window = egui::Window::new("Inspector")
        .open(&mut stays)
        .resizable(false)
        .collapsible(true)
        .constrain_to(free)
        .default_size([WIDTH, free.height()]);
    if let Some(at) = opened_at {
        let is_right = at.x / zoom > free.center().x;
        let x = if is_right { free.left() + TOOLS } else { free.right() - WIDTH - 14.0 };
        window = window.current_pos([x.max(free.left()), free.top()]);
    }
    let mut drawn = Ok(());
    window.show(context, |ui| {
        ui.set_width(WIDTH);
        egui::ScrollArea::vertical().max_height((free.height() - 60.0).max(80.0)).show(ui, |ui| {
            ui.set_width(WIDTH - 10.0);
            // What lies where another body's lay is another thing.
            let body = world.resource::<Selection>().entity();
            drawn = ui.push_id(body, |ui| contents(ui, world)).inner;
        });
    });
    if !stays {
        world.resource_mut::<Inspector>().is_hidden = true;
    }
    drawn
}

/// Its name, what holds it, and what it is; or the joint, or all bodies.
fn contents(ui: &mut egui::Ui, world: &mut World) -> Result {
    let selected = world.resource::<Selection>();
    if selected.joint.is_some() {
        return run(ui, world, selection::show_picked_joint);
    }
    if !selected.others.is_empty() {
        return run(ui, world, many::show);
    }
    let Some(described) = Described::picked(world) else { return Ok(()) };
    world.run_system_cached_with(body::show_name, (&mut *ui, &described))?;
    run(ui, world, selection::show)?;
    // What is joined is looked at for its joints.
    let is_open = world.resource::<ReadJoints>().open.is_empty();
    let section = egui::CollapsingHeader::new("body").default_open(is_open);
    let shown = section.show_unindented(ui, |ui| world.run_system_cached_with(body::show, (&mut *ui, &described)));
    Ok(shown.body_returned.transpose().map(drop)?)
}
