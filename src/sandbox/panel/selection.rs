//! The picked bodies, and the joints of the first.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::any_joint::{IsJoint, WholeJoint, WholeJointItem, noun};
use super::super::joint_readings::ReadJoints;
use super::super::probe::{Reader, offer_body, offer_joint};
use super::super::{JointChange, Placement, SandboxAction, Selection, ShowsPlots};
use super::buttons::tooltip;
use super::joint;
use super::theme::name_of;
use super::vector::VectorFields;
use crate::physics::{Position, RigidBody, Rotation, StepStats};
use crate::scene::{JointComponent, Probes, SceneEntity};

/// How many joints are listed.
const LISTED: usize = 12;
/// So few are told in full.
const OPEN: usize = 2;

/// Where bodies can be put, m.
const PLACE: VectorFields = VectorFields { range: -1e6..=1e6, speed: 0.01, decimals: 3, width: 62.0 };

/// What the section shows of bodies.
type Bodies<'w, 's> = Query<'w, 's, (Option<&'static Name>, &'static RigidBody, &'static Position, &'static Rotation)>;

type Joints<'w, 's> = Query<'w, 's, (Entity, WholeJoint), (IsJoint, With<SceneEntity>)>;

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    selection: Res<Selection>,
    bodies: Bodies,
    joints: Joints,
    stats: Res<StepStats>,
    mut read: ResMut<ReadJoints>,
    (mut probes, reader): (ResMut<Probes>, Reader),
    mut shows_plots: ResMut<ShowsPlots>,
    mut changing: Local<bool>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let mut now = ReadJoints { open: Vec::new(), ..read.clone() };
    *changing &= ui.input(|input| input.pointer.any_down());
    match selection.entity().filter(|entity| bodies.contains(*entity)) {
        None => _ = ui.weak("none: click a body in the picture"),
        Some(body) => {
            show_body(ui, &selection, body, &bodies, &mut probes, &mut changing, &mut actions);
            let own = joints_of(body, &joints);
            for (entity, joint) in own.iter().take(LISTED) {
                let of_whom = (*entity, own.len() <= OPEN);
                let shown = ui.push_id(entity, |ui| {
                    show_joint(ui, body, of_whom, joint, (&bodies, &stats, &reader), &mut now, &mut probes)
                });
                let (change, cut) = shown.inner;
                if cut {
                    actions.write(SandboxAction::Cut(*entity));
                }
                if let Some(change) = change {
                    ask(ui, *entity, change, &mut changing, &mut actions);
                }
            }
            let more = own.len().saturating_sub(LISTED);
            if more > 0 {
                ui.weak(format!("and {more} more joints"));
            }
        }
    }
    note_readings(now, &mut read, &mut shows_plots);
}

/// The joint that is picked: all that can be changed of it.
pub(super) fn show_picked_joint(
    InMut(ui): InMut<egui::Ui>,
    selection: Res<Selection>,
    bodies: Bodies,
    joints: Joints,
    stats: Res<StepStats>,
    mut read: ResMut<ReadJoints>,
    (mut probes, reader): (ResMut<Probes>, Reader),
    mut shows_plots: ResMut<ShowsPlots>,
    mut changing: Local<bool>,
    mut actions: MessageWriter<SandboxAction>,
) {
    *changing &= ui.input(|input| input.pointer.any_down());
    let Some((entity, joint)) = selection.joint.and_then(|joint| joints.get(joint).ok()) else { return };
    let Some(component) = joint.joint.component() else { return };
    let mut now = ReadJoints { open: vec![entity], ..read.clone() };
    let [a, b] = component.bodies().map(|body| name_in(&bodies, body));
    let broken = if joint.broken.is_some() { ", broken" } else { "" };
    let title = ui.add(egui::Label::new(egui::RichText::new(format!("{}{broken}", noun(&component))).strong()));
    title.on_hover_text("the joint that was clicked");
    ui.add(egui::Label::new(format!("{a} to {b}")).truncate());
    ui.horizontal(|ui| {
        let mut plotted = read.plotted == Some(entity);
        if ui.checkbox(&mut plotted, "plot").on_hover_text("plot its load and where it stands").changed() {
            now.plotted = plotted.then_some(entity);
        }
        ui.menu_button("probe", |ui| offer_joint(ui, &mut probes, &reader, entity));
        if ui.small_button("✂ cut").on_hover_text("cut this joint").clicked() {
            actions.write(SandboxAction::Cut(entity));
        }
    });
    let value = value_of(&joint, &component, &bodies);
    if let Some(change) = joint::show(ui, &joint, value, &stats) {
        ask(ui, entity, change, &mut changing, &mut actions);
    }
    note_readings(now, &mut read, &mut shows_plots);
}

/// Asks for a change of a joint, which goes on with the last one while the button stays down.
fn ask(
    ui: &egui::Ui,
    joint: Entity,
    change: JointChange,
    changing: &mut bool,
    actions: &mut MessageWriter<SandboxAction>,
) {
    actions.write(SandboxAction::ChangeJoint { joint, change, continues: *changing });
    *changing = ui.input(|input| input.pointer.any_down());
}

/// Takes in which joints are looked at; the plots come with the first one that is plotted.
fn note_readings(now: ReadJoints, read: &mut ResMut<ReadJoints>, shows_plots: &mut ResMut<ShowsPlots>) {
    if now.plotted.is_some() && now.plotted != read.plotted {
        shows_plots.set_if_neq(ShowsPlots(true));
    }
    read.set_if_neq(now);
}

/// A body's joints, in an order that no change to one of them moves.
fn joints_of<'a>(body: Entity, joints: &'a Joints) -> Vec<(Entity, WholeJointItem<'a, 'a>)> {
    let is_own = |joint: &WholeJointItem| joint.joint.component().is_some_and(|joint| joint.bodies().contains(&body));
    let mut own: Vec<_> = joints.iter().filter(|(_, joint)| is_own(joint)).collect();
    own.sort_by_key(|(entity, _)| entity.index_u32());
    own
}

fn name_in(bodies: &Bodies, body: Entity) -> String {
    name_of(bodies.get(body).ok().and_then(|(name, ..)| name), body)
}

fn show_body(
    ui: &mut egui::Ui,
    selection: &Selection,
    body: Entity,
    bodies: &Bodies,
    probes: &mut ResMut<Probes>,
    changing: &mut bool,
    actions: &mut MessageWriter<SandboxAction>,
) {
    let Ok((_, _, position, rotation)) = bodies.get(body) else { return };
    ui.horizontal(|ui| {
        let label = egui::Label::new("at").selectable(false).sense(egui::Sense::click());
        let about = "its centre of mass; right click: plot it";
        ui.add(label).on_hover_text(about).context_menu(|ui| offer_body(ui, probes, body));
        let mut now = position.0;
        let is_moved = PLACE.show(ui, &mut now);
        ui.label("m");
        if is_moved {
            let placements = vec![Placement { body, position: now, rotation: rotation.0, shape: None }];
            actions.write(SandboxAction::PlaceBodies { placements, continues: *changing });
            *changing = ui.input(|input| input.pointer.any_down());
        }
    });
    ui.horizontal(|ui| {
        if ui.small_button("follow").on_hover_text(tooltip(&SandboxAction::Follow)).clicked() {
            actions.write(SandboxAction::Follow);
        }
        ui.menu_button("plot", |ui| offer_body(ui, probes, body));
        if ui.small_button("duplicate").on_hover_text(tooltip(&SandboxAction::Duplicate)).clicked() {
            actions.write(SandboxAction::Duplicate);
        }
        if ui.small_button("🗑 delete").on_hover_text(tooltip(&SandboxAction::DeletePicked)).clicked() {
            actions.write(SandboxAction::DeletePicked);
        }
    });
    if let Some(partner) = selection.partner {
        let partner = name_in(bodies, partner.entity);
        ui.label(format!("and {partner}")).on_hover_text("picked with Shift held, to be joined");
    }
}

/// A line of the list, which opens. Tells what is to be changed, and whether the joint is to be cut.
fn show_joint(
    ui: &mut egui::Ui,
    body: Entity,
    (entity, is_open): (Entity, bool),
    joint: &WholeJointItem,
    (bodies, stats, reader): (&Bodies, &StepStats, &Reader),
    read: &mut ReadJoints,
    probes: &mut ResMut<Probes>,
) -> (Option<JointChange>, bool) {
    let Some(component) = joint.joint.component() else { return (None, false) };
    let [a, b] = component.bodies();
    let other = name_in(bodies, if a == body { b } else { a });
    let broken = if joint.broken.is_some() { ", broken" } else { "" };
    let id = ui.make_persistent_id(entity);
    let mut state = egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, is_open);
    let mut cut = false;
    let header = ui.horizontal(|ui| {
        state.show_toggle_button(ui, egui::collapsing_header::paint_default_icon);
        cut = ui.small_button("✂ cut").on_hover_text("cut this joint").clicked();
        let label = egui::Label::new(format!("{} to {other}{broken}", noun(&component))).truncate().selectable(false);
        let shown = ui.add(label.sense(egui::Sense::click())).on_hover_text("click to open, right click to plot");
        if shown.clicked() {
            state.toggle(ui);
        }
        shown.context_menu(|ui| offer_joint(ui, probes, reader, entity));
    });
    let opened = state.show_body_indented(&header.response, ui, |ui| {
        let value = value_of(joint, &component, bodies);
        let mut plotted = read.plotted == Some(entity);
        if ui.checkbox(&mut plotted, "plot").on_hover_text("plot its load and where it stands").changed() {
            read.plotted = plotted.then_some(entity);
        }
        joint::show(ui, joint, value, stats)
    });
    if opened.is_some() {
        read.open.push(entity);
    }
    (opened.and_then(|opened| opened.inner), cut)
}

/// Where a joint stands along its axis.
fn value_of(joint: &WholeJointItem, component: &JointComponent, bodies: &Bodies) -> Option<f64> {
    let [Ok(a), Ok(b)] = component.bodies().map(|body| bodies.get(body)) else { return None };
    joint.value([a, b].map(|(_, _, position, rotation)| (position.0, rotation.0)))
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::SystemState;

    use super::*;
    use crate::physics::{HingeJoint, JointLimits};

    #[test]
    fn a_change_moves_no_joint_in_the_list() {
        let mut world = World::new();
        let [body, other] = [world.spawn_empty().id(), world.spawn_empty().id()];
        let joints = [0; 3].map(|_| world.spawn((HingeJoint::new(body, other), SceneEntity)).id());
        world.spawn((HingeJoint::new(other, other), SceneEntity));
        world.entity_mut(joints[0]).insert(JointLimits::range(-1.0, 1.0));
        let mut state = SystemState::<Joints>::new(&mut world);
        let query = state.get(&world).expect("no parameter that can be missing");
        let listed: Vec<_> = joints_of(body, &query).into_iter().map(|(entity, _)| entity).collect();
        assert_eq!(listed, joints);
    }
}
