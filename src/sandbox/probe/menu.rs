//! A right click in the picture: what is there can be plotted, trailed and measured. A right button that moves turns the
//! camera and asks for nothing.

use bevy::picking::events::Drag;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::reader::{Reader, WatchedPoint, coordinates};
use super::rows;
use super::tape_start::TapeStart;
use crate::physics::RigidBody;
use crate::sandbox::aimed::{Picture, Targets};
use crate::sandbox::build::joint_at_pointer;
use crate::sandbox::{CurrentScene, Notice, Tool};
use crate::scene::{MAX_PROBES, Probe, ProbePoint, Probes};

/// How far the pointer may move in a click, logical pixels.
const SLACK: f32 = 4.0;

/// The menu.
#[derive(Resource, Default)]
pub struct Menu {
    /// Where the right button went down that is still down and has not moved, and on what.
    pressed: Option<(Vec2, Option<WatchedPoint>)>,
    open: Option<Open>,
}

/// Where it is, and of what.
struct Open {
    at: Vec2,
    /// Of a body or of the ground; none in the sky.
    point: Option<WatchedPoint>,
    joint: Option<Entity>,
    /// Passes since it opened.
    age: u32,
}

/// The point that was hit, if it is one of a body or of the ground.
fn point_at(targets: &Targets, press: &Pointer<Press>, entity: Entity) -> Option<WatchedPoint> {
    let aimed = targets.aimed(entity, &press.hit)?;
    Some(match aimed.is_ground {
        true => ProbePoint { body: None, at: aimed.place },
        false => ProbePoint { body: Some(aimed.picked.entity), at: aimed.picked.point },
    })
}

/// A right press begins a click; a left one ends a tape.
pub fn press(
    press: On<Pointer<Press>>,
    (mut picture, targets): (Picture, Targets),
    mut menu: ResMut<Menu>,
    mut tape: ResMut<TapeStart>,
    tool: Res<Tool>,
    mut notice: ResMut<Notice>,
) {
    let position = press.pointer_location.position;
    if !picture.is_pressed(&press) {
        return;
    }
    let point = point_at(&targets, &press, press.entity);
    match press.button {
        PointerButton::Secondary => menu.pressed = Some((position, point)),
        PointerButton::Primary if tape.is_waiting() => match point {
            Some(point) => tape.to = Some(point),
            None => *notice = Notice::Error("there is nothing to measure to: click a body or the ground".into()),
        },
        PointerButton::Primary if *tool == Tool::Measure => match point {
            Some(_) => begin_tape(&mut tape, &mut notice, point),
            None => *notice = Notice::Error("there is nothing to measure from: click a body or the ground".into()),
        },
        _ => {}
    }
}

/// What moves is no click.
pub fn moved(drag: On<Pointer<Drag>>, mut menu: ResMut<Menu>) {
    if drag.button == PointerButton::Secondary && drag.distance.length() > SLACK {
        menu.pressed = None;
    }
}

/// The end of a click opens the menu.
pub fn release(release: On<Pointer<Release>>, mut menu: ResMut<Menu>, mut commands: Commands) {
    if release.button != PointerButton::Secondary {
        return;
    }
    let position = release.pointer_location.position;
    let Some((from, point)) = menu.pressed.take().filter(|(from, _)| from.distance(position) <= SLACK) else { return };
    commands.queue(move |world: &mut World| {
        let joint = joint_at_pointer(world);
        world.resource_mut::<Menu>().open = Some(Open { at: from, point, joint, age: 0 });
    });
}

/// Draws it.
pub fn show(
    mut contexts: EguiContexts,
    scene: Option<Res<CurrentScene>>,
    bodies: Query<(), With<RigidBody>>,
    reader: Reader,
    mut menu: ResMut<Menu>,
    mut probes: ResMut<Probes>,
    mut tape: ResMut<TapeStart>,
    mut notice: ResMut<Notice>,
) -> Result {
    let Some(open) = &mut menu.open else { return Ok(()) };
    let is_there = open.point.and_then(|point| point.body).is_none_or(|body| bodies.contains(body));
    if !is_there || scene.is_none_or(|scene| scene.is_changed()) {
        menu.open = None;
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    let at = egui::pos2(open.at.x, open.at.y) / context.zoom_factor();
    let mut measures = false;
    let area = egui::Area::new(egui::Id::new("probe menu")).order(egui::Order::Foreground).fixed_pos(at);
    let shown = area.constrain(true).show(context, |ui| {
        egui::Frame::menu(ui.style()).show(ui, |ui| {
            let joint = open.joint.filter(|joint| !reader.name_of_joint(*joint).is_empty());
            let of_scene = open.point.map_or(joint.is_none(), |point| point.body.is_none());
            // First what one sees: a joint may be inside of it, or behind it.
            if let Some(point) = open.point {
                measures = show_point(ui, &reader, &mut probes, point);
                if of_scene || joint.is_some() {
                    ui.separator();
                }
            }
            if let Some(joint) = joint {
                ui.strong(reader.name_of_joint(joint));
                rows::joint(ui, &mut probes, &reader, joint);
                if of_scene {
                    ui.separator();
                }
            }
            if of_scene {
                ui.strong("the scene");
                rows::scene(ui, &mut probes);
            }
        });
    });
    let has_left = context.input(|input| {
        let elsewhere = input.pointer.interact_pos().is_some_and(|pointer| !shown.response.rect.contains(pointer));
        input.pointer.any_pressed() && elsewhere
    });
    open.age += 1;
    // The very click that opened it is not one beside it.
    let is_left = has_left && open.age > 1;
    if measures {
        begin_tape(&mut tape, &mut notice, open.point);
    }
    if is_left || measures {
        menu.open = None;
    }
    Ok(())
}

fn begin_tape(tape: &mut TapeStart, notice: &mut Notice, from: Option<WatchedPoint>) {
    *tape = TapeStart { from, to: None };
    *notice = Notice::Info("click the other end of the tape; Esc: no tape".into());
}

/// Whether a tape is to begin there.
fn show_point(ui: &mut egui::Ui, reader: &Reader, probes: &mut ResMut<Probes>, point: WatchedPoint) -> bool {
    let Some(body) = point.body else {
        ui.strong("a point of the world");
        return tape_button(ui);
    };
    ui.strong(reader.name_of_body(body));
    rows::body(ui, probes, body);
    ui.separator();
    ui.strong(format!("this point {}", coordinates(point.at)))
        .on_hover_text("from the center of mass, along its axes, m");
    rows::point(ui, probes, point);
    ui.horizontal(|ui| {
        rows::toggle(ui, probes, Probe::Trail(point), "trail", "the way of this point in the last five seconds");
        tape_button(ui)
    })
    .inner
}

fn tape_button(ui: &mut egui::Ui) -> bool {
    let about = "a line to the point that you click next, with its length beside it, which is plotted too";
    ui.button("tape from here").on_hover_text(about).clicked()
}

/// Makes the tape whose ends are chosen.
pub fn finish_tape(
    scene: Option<Res<CurrentScene>>,
    mut tape: ResMut<TapeStart>,
    mut probes: ResMut<Probes>,
    mut notice: ResMut<Notice>,
) {
    if scene.is_some_and(|scene| scene.is_changed()) {
        tape.set_if_neq(TapeStart::default()); // its bodies are gone
    }
    let TapeStart { from: Some(from), to: Some(to) } = *tape else { return };
    *tape = TapeStart::default();
    *notice = Notice::None;
    let probe = Probe::Tape([from, to]);
    if probes.0.len() < MAX_PROBES && !probes.0.contains(&probe) {
        probes.0.push(probe);
    }
}

/// Closes the menu; no tape is being drawn.
pub fn escape(world: &mut World) {
    *world.resource_mut::<Menu>() = Menu::default();
    *world.resource_mut::<TapeStart>() = TapeStart::default();
}
