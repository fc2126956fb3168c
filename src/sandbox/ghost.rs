//! Ghosts: the scene once more by a second method, or its reference answer, translucent over the
//! first, and how far apart the two are.
//!
//! The second method runs in a headless world of its own, made by the same plugin from the same
//! scene, and is stepped after the first up to the same simulation time; only its poses are drawn.
//! Hands and what they build reach the first world alone.

use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::math::{DQuat, DVec3};
use bevy::picking::Pickable;
use bevy::prelude::*;
use bevy_egui::egui;

use super::meshes::dress_bodies;
use super::panel::vary;
use super::{CurrentScene, SandboxAction};
use crate::lab::chart::SERIES;
use crate::lab::truth;
use crate::lab::vary::Assignment;
use crate::lab::{Simulation, turn_between};
use crate::physics::{Collider, History, Position, RenderOrigin, RigidBody, Rotation, SolverSettings, StepStats};
use crate::physics::{PhysicsSchedule, PhysicsSystems};
use crate::scene::SceneSpec;

/// Units in the last place of the depth by which a ghost is drawn nearer than it is. The depth buffer holds
/// near/distance in 32-bit floats, so that these are 2.4 to 4.9 ten-thousandths of the distance at any distance: less
/// than a pixel's width on most screens, and far above what rounding makes of two poses alike. A larger mesh would
/// not do: it would part from the body where the two are one, and hollows would shrink into it.
const DEPTH_BIAS: f32 = 4096.0;

/// What a ghost's history may take, bytes.
const HISTORY: usize = 128 << 20;

/// What is drawn as a ghost.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub enum GhostChoice {
    /// Nothing.
    #[default]
    Off,
    /// The method of that index in [`SERIES`].
    Method(usize),
    /// The settings that the scene starts with, but for one thing.
    Changed(Assignment),
    /// The reference answer, for scenes whose answer gives the whole motion.
    Reference,
}

/// How far bodies and their ghosts are apart after the last step; none without a ghost.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct GhostDistance(pub Option<Apart>);

/// How far apart two worlds are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// Largest distance between two places of a material point of a body, m.
    pub distance: f64,
    /// Largest angle between two orientations of a body, rad.
    pub angle: f64,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<GhostChoice>()
        .init_resource::<GhostDistance>()
        .insert_non_send(Ghost::default())
        .add_systems(PhysicsSchedule, follow.after(PhysicsSystems::Diagnose))
        // With the bodies that are new: no ghost outlives its scene, not by a frame.
        .add_systems(Update, (restart, dress).chain().after(dress_bodies))
        .add_systems(PostUpdate, place.before(TransformSystems::Propagate));
}

/// A body and its ghost.
struct Pair {
    /// In the scene's list.
    index: usize,
    /// In the first world.
    body: Entity,
    /// What is drawn.
    ghost: Entity,
    /// Before and after the ghost's last step.
    poses: [(DVec3, DQuat); 2],
}

/// Where ghosts are, by index in the scene's list.
enum Source {
    Method(Box<Simulation>),
    Reference(truth::Poses),
}

impl Source {
    fn of(choice: GhostChoice, scene: &SceneSpec, present: &SolverSettings) -> Option<Self> {
        let method = |settings| {
            let mut simulation = Simulation::new(scene.clone(), settings);
            simulation.keep_history(HISTORY);
            Self::Method(Box::new(simulation))
        };
        match choice {
            GhostChoice::Off => None,
            GhostChoice::Method(index) => {
                Some(method(SolverSettings { threads: present.threads, ..(SERIES.get(index)?.base)() }))
            }
            GhostChoice::Changed(assignment) => {
                let mut settings = *present;
                assignment.put_in(&mut settings);
                Some(method(settings))
            }
            GhostChoice::Reference => truth::poses(scene).map(Self::Reference),
        }
    }

    /// Goes on to a time, s, and tells where the bodies are then.
    fn advance(&mut self, time: f64) -> Vec<(usize, DVec3, DQuat)> {
        match self {
            Self::Method(simulation) => {
                // Half a step short of it is as near as whole steps come.
                let step = simulation.settings().step();
                let half = 0.5 * step;
                if simulation.sample().time > time + half {
                    // As far back as is kept; it waits there.
                    let first = simulation.world().resource::<History>().reach()[0];
                    let _ = simulation.go_to(((time / step).round() as u64).max(first));
                }
                while simulation.sample().time < time - half {
                    simulation.step();
                }
                let bodies = simulation.sample().bodies.iter().enumerate();
                bodies.map(|(index, body)| (index, body.position, body.rotation)).collect()
            }
            Self::Reference(poses) => poses(time),
        }
    }
}

/// The ghost at work.
#[derive(Default)]
pub(super) struct Ghost {
    source: Option<Source>,
    pairs: Vec<Pair>,
    /// Simulation time at its start, s: the world's clock runs on when a scene is replaced.
    start: f64,
}

/// Starts ghost and scene together: at a new scene, a reset, or another choice.
fn restart(
    mut commands: Commands,
    choice: Res<GhostChoice>,
    scene: Option<Res<CurrentScene>>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
    mut ghost: NonSendMut<Ghost>,
    mut distance: ResMut<GhostDistance>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let Some(scene) = scene else { return };
    if !scene.is_changed() {
        if choice.is_changed() && !choice.is_added() {
            // The reset changes the scene, and that starts the ghost.
            actions.write(SandboxAction::Reset);
        }
        return;
    }
    for pair in ghost.pairs.drain(..) {
        commands.entity(pair.ghost).despawn();
    }
    distance.0 = None;
    ghost.start = stats.time;
    ghost.source = Source::of(*choice, &scene.spec, &settings);
    let Some(source) = &mut ghost.source else { return };
    let moving = |&(index, ..): &(usize, DVec3, DQuat)| {
        let body = &scene.spec.bodies[index];
        body.kind == RigidBody::Dynamic && body.shape.is_some()
    };
    let starts: Vec<_> = source.advance(0.0).into_iter().filter(moving).collect();
    ghost.pairs = starts
        .into_iter()
        .map(|(index, position, rotation)| Pair {
            index,
            body: scene.entities.bodies[index],
            ghost: commands.spawn((Name::new("ghost"), Transform::default(), Pickable::IGNORE)).id(),
            poses: [(position, rotation); 2],
        })
        .collect();
}

/// After the step of the first world: the same time in the second.
pub(super) fn follow(
    stats: Res<StepStats>,
    bodies: Query<(&Position, &Rotation, &Collider)>,
    mut ghost: NonSendMut<Ghost>,
    mut distance: ResMut<GhostDistance>,
) {
    let Ghost { source: Some(source), pairs, start } = &mut *ghost else { return };
    let poses = source.advance(stats.time - *start);
    let mut apart = Apart::default();
    // Both go up by index.
    let mut poses = poses.into_iter();
    for pair in pairs {
        let Some((_, position, rotation)) = poses.by_ref().find(|(index, ..)| *index == pair.index) else { break };
        pair.poses = [pair.poses[1], (position, rotation)];
        if let Ok((at, turned, collider)) = bodies.get(pair.body) {
            let distance = collider.largest_displacement(position - at.0, [turned.0, rotation]);
            apart.distance = apart.distance.max(distance);
            apart.angle = apart.angle.max(turn_between(turned.0, rotation));
        }
    }
    distance.0 = Some(apart);
}

/// Gives ghosts the meshes of their bodies, in glass.
fn dress(
    mut commands: Commands,
    ghost: NonSend<Ghost>,
    meshes: Query<&Mesh3d>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut glass: Local<Option<Handle<StandardMaterial>>>,
) {
    for pair in &ghost.pairs {
        if meshes.contains(pair.ghost) {
            continue;
        }
        let Ok(mesh) = meshes.get(pair.body) else { continue };
        let material = glass.get_or_insert_with(|| {
            materials.add(StandardMaterial {
                base_color: Color::srgba(0.75, 0.9, 1.0, 0.35),
                alpha_mode: AlphaMode::Blend,
                perceptual_roughness: 0.4,
                depth_bias: DEPTH_BIAS,
                ..default()
            })
        });
        // Body and ghost in nearly one place would mottle each other with their shadows.
        let look = (mesh.clone(), MeshMaterial3d(material.clone()), NotShadowCaster, NotShadowReceiver);
        commands.entity(pair.ghost).insert(look);
    }
}

/// Between the last two poses, as bodies are.
fn place(
    fixed: Res<Time<Fixed>>,
    origin: Res<RenderOrigin>,
    ghost: NonSend<Ghost>,
    mut transforms: Query<&mut Transform>,
) {
    let alpha = fixed.overstep_fraction_f64();
    for pair in &ghost.pairs {
        let [(from_position, from_rotation), (position, rotation)] = pair.poses;
        if let Ok(mut transform) = transforms.get_mut(pair.ghost) {
            transform.translation = (from_position.lerp(position, alpha) - origin.0).as_vec3();
            transform.rotation = from_rotation.slerp(rotation, alpha).as_quat();
        }
    }
}

/// What the list calls the present settings with something changed.
const CHANGED: &str = "these settings, but for";

/// The section of the panel.
pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    scene: Option<Res<CurrentScene>>,
    settings: Res<SolverSettings>,
    mut choice: ResMut<GhostChoice>,
    mut typed: Local<Option<vary::Typed>>,
) {
    let name = |choice: GhostChoice| match choice {
        GhostChoice::Off => "none",
        GhostChoice::Method(index) => SERIES[index].name,
        GhostChoice::Changed(_) => CHANGED,
        GhostChoice::Reference => "reference answer",
    };
    let known = scene.is_some_and(|scene| truth::poses(&scene.spec).is_some());
    let mut picked = *choice;
    ui.horizontal(|ui| {
        let about = "the scene once more, translucent, from the start; your hand does not reach it";
        ui.label("ghost").on_hover_text(about);
        let shown = if typed.is_some() { CHANGED } else { name(picked) };
        egui::ComboBox::from_id_salt("ghost").selected_text(shown).show_ui(ui, |ui| {
            let mut pick = |ui: &mut egui::Ui, choice: GhostChoice| {
                let response = ui.selectable_label(typed.is_none() && picked == choice, name(choice));
                if response.clicked() {
                    *typed = None;
                    picked = choice;
                }
                response
            };
            pick(ui, GhostChoice::Off);
            for index in 0..SERIES.len() {
                pick(ui, GhostChoice::Method(index));
            }
            ui.add_enabled_ui(known, |ui| {
                pick(ui, GhostChoice::Reference)
                    .on_disabled_hover_text("the answer of this scene does not give the whole motion");
            });
            let about = "the present settings with one thing changed, from the start of the scene";
            if ui.selectable_label(typed.is_some(), CHANGED).on_hover_text(about).clicked() {
                typed.get_or_insert_default();
            }
        });
    });
    if let Some(typed) = typed.as_mut()
        && let Some(changed) = choose_change(ui, &settings, typed)
    {
        picked = GhostChoice::Changed(changed);
    }
    choice.set_if_neq(picked);
}

/// A setting and its value in the ghost, once they make sense.
fn choose_change(ui: &mut egui::Ui, settings: &SolverSettings, typed: &mut vary::Typed) -> Option<Assignment> {
    let names = vary::settings_names(settings);
    let suggest = |name: &str| vary::suggested_value(name, settings);
    let about = "the ghost's value; Enter starts the scene again";
    if !vary::show(ui, "changed setting", &names, typed, suggest, about) {
        return None;
    }
    let changed = Assignment::parse(&typed.text(), None);
    typed.problem = changed.as_ref().err().map(ToString::to_string);
    changed.ok()
}
