//! A box that is drawn around bodies to pick them: a press beside all bodies begins it, and what has its centre of mass in it
//! when the button goes up is picked. With Shift held it is picked beside what is picked already.

use bevy::picking::pointer::PointerId;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::action::CarryOut;
use super::pointer::{self, SLACK, is_down};
use super::state::report;
use super::{SandboxAction, Selection};
use crate::physics::{Collider, Position, RenderOrigin};
use crate::scene::SceneEntity;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<BoxDraft>()
        .add_systems(Update, follow.before(CarryOut))
        .add_systems(EguiPrimaryContextPass, draw);
}

/// The box that is being drawn.
#[derive(Resource, Default)]
pub(super) struct BoxDraft(Option<Draft>);

#[derive(Clone, Copy)]
struct Draft {
    pointer: PointerId,
    /// Where the button went down, and where the pointer is, logical pixels.
    from: Vec2,
    to: Vec2,
    adds: bool,
}

impl Draft {
    fn is_click(&self) -> bool {
        self.from.distance(self.to) <= SLACK
    }
}

/// The button went down beside all bodies.
pub(super) fn begin(world: &mut World, pointer: PointerId, from: Vec2, adds: bool) {
    world.resource_mut::<BoxDraft>().0 = Some(Draft { pointer, from, to: from, adds });
}

/// No box is drawn any more.
pub(super) fn give_up(world: &mut World) {
    world.insert_resource(BoxDraft::default());
}

/// Has the box reach to the pointer, and picks once the button is up.
fn follow(world: &mut World) {
    let Some(mut draft) = world.resource::<BoxDraft>().0 else { return };
    if let Some(at) = pointer::place(world) {
        draft.to = at;
    }
    let goes_on = is_down(world, draft.pointer);
    world.resource_mut::<BoxDraft>().0 = Some(draft).filter(|_| goes_on);
    if !goes_on && !draft.is_click() {
        let Draft { from, to, adds, .. } = draft;
        world.write_message(SandboxAction::SelectBox { from, to, adds });
    }
}

/// The box, over the picture.
fn draw(mut contexts: EguiContexts, draft: Res<BoxDraft>) -> Result {
    let Some(draft) = draft.0.filter(|draft| !draft.is_click()) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let [from, to] = [draft.from, draft.to].map(|at| egui::pos2(at.x, at.y) / context.zoom_factor());
    let painter = context.layer_painter(egui::LayerId::new(egui::Order::Background, egui::Id::new("box of bodies")));
    let (fill, line) = (egui::Color32::from_rgba_unmultiplied(255, 217, 26, 24), egui::Color32::from_rgb(255, 217, 26));
    let stroke = egui::Stroke::new(1.5, line);
    painter.rect(egui::Rect::from_two_pos(from, to), 0.0, fill, stroke, egui::StrokeKind::Middle);
    Ok(())
}

/// Picks the bodies whose centres of mass are seen in the box between two places of the window.
pub(super) fn select_box(world: &mut World, from: Vec2, to: Vec2, adds: bool) {
    let found = world.run_system_cached_with(seen_in, Rect::from_corners(from, to)).unwrap_or_default();
    pick_all(world, found, adds);
}

/// Picks all bodies.
pub(super) fn select_all(world: &mut World) {
    let mut bodies = world.query_filtered::<(Entity, &Collider), With<SceneEntity>>();
    let mut all: Vec<Entity> =
        bodies.iter(world).filter(|(_, collider)| is_thing(collider)).map(|body| body.0).collect();
    all.sort_unstable();
    pick_all(world, all, false);
}

fn pick_all(world: &mut World, bodies: Vec<Entity>, adds: bool) {
    let mut selection = world.resource_mut::<Selection>();
    if !adds {
        *selection = Selection::default();
    }
    selection.add(bodies);
    match selection.bodies().count() {
        0 => report(world, Err("no body's centre is in that box".into())),
        1 => {}
        count => report(world, Ok(format!("{count} bodies picked"))),
    }
}

/// What the picture shows and is no ground.
fn is_thing(collider: &Collider) -> bool {
    !collider.shape().is_ground()
}

fn seen_in(
    In(place): In<Rect>,
    camera: Single<(&Camera, &GlobalTransform), With<Camera3d>>,
    bodies: Query<(Entity, &Collider, &Position), With<SceneEntity>>,
    origin: Res<RenderOrigin>,
) -> Vec<Entity> {
    let (camera, eye) = *camera;
    let is_in = |centre: &Position| {
        let seen = camera.world_to_viewport(eye, (centre.0 - origin.0).as_vec3());
        seen.is_ok_and(|seen| place.contains(seen))
    };
    let found = bodies.iter().filter(|(_, collider, centre)| is_thing(collider) && is_in(centre));
    let mut found: Vec<Entity> = found.map(|(entity, ..)| entity).collect();
    found.sort_unstable();
    found
}
