//! Ghosts start, follow the scene, and are drawn.

use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::picking::Pickable;
use bevy::prelude::*;

use super::choice::{GhostChoice, Ghosts, MOST_GHOSTS};
use super::lane::{Apart, Lane, Pair, Reading};
use crate::lab::race::Limits;
use crate::physics::{
    Collider, Diagnostics, PhysicsSchedule, PhysicsSystems, Position, RenderOrigin, RigidBody, Rotation,
    SolverSettings, StepStats,
};
use crate::sandbox::CurrentScene;
use crate::sandbox::meshes::size_pictures;
use crate::sandbox::panel::palette;
use crate::scene::SceneSpec;

/// Units in the last place of the depth by which a ghost is drawn nearer than it is. The depth buffer holds
/// near/distance in 32-bit floats, so that these are 2.4 to 4.9 ten-thousandths of the distance at any distance: less
/// than a pixel's width on most screens, and far above what rounding makes of two poses alike. A larger mesh would
/// not do: it would part from the body where the two are one, and hollows would shrink into it.
const DEPTH_BIAS: f32 = 4096.0;
/// How much of what is behind it a ghost covers.
const COVERS: f32 = 0.4;

/// What is known of the ghosts after the last step.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct GhostReadings {
    /// Of the scene itself, since the ghosts started.
    pub scene: Reading,
    /// In the order of [`Ghosts`], those left out that have no answer to show.
    pub ghosts: Vec<GhostReading>,
    /// The distance from which on a ghost counts as parted from the scene, m.
    pub limit: f64,
    /// When the ghosts started, s.
    pub start: f64,
}

impl Default for GhostReadings {
    fn default() -> Self {
        Self { scene: Reading::default(), ghosts: Vec::new(), limit: 0.01, start: 0.0 }
    }
}

/// What is known of a ghost.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostReading {
    /// What it is called.
    pub name: String,
    /// Its color, sRGB.
    pub color: [u8; 3],
    /// How far it is from the scene.
    pub apart: Apart,
    /// What is measured of it; none of the answer.
    pub reading: Option<Reading>,
    /// The step of the scene after which it first was farther from it than the limit.
    pub parted: Option<u64>,
}

impl GhostReading {
    /// Enough of its name to tell it apart where it has its color besides.
    pub fn short_name(&self) -> &str {
        self.name.split([' ', ',']).next().unwrap_or_default()
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Ghosts>()
        .init_resource::<GhostReadings>()
        .insert_non_send(Running::default())
        .add_systems(PhysicsSchedule, follow.after(PhysicsSystems::Diagnose))
        // With the bodies that are new: no ghost outlives its scene, not by a frame.
        .add_systems(Update, (restart, dress).chain().after(size_pictures))
        .add_systems(PostUpdate, place.before(TransformSystems::Propagate));
}

/// The ghosts at work.
#[derive(Default)]
pub struct Running {
    /// What was chosen when they started.
    chosen: Ghosts,
    lanes: Vec<Lane>,
    limits: Option<Limits>,
}

/// Colors of ghosts in their order.
const COLORS: [[u8; 3]; MOST_GHOSTS] = [palette::SKY, palette::ORANGE, palette::GREEN];

/// Starts the ghosts: with a new scene or a reset, or where the scene is when others are chosen.
fn restart(world: &mut World, mut seen: Local<Option<bevy::ecs::change_detection::Tick>>) {
    let Some(current) = world.get_resource_ref::<CurrentScene>() else { return };
    let changed = current.last_changed();
    let is_new = seen.replace(changed) != Some(changed);
    let chosen = world.resource::<Ghosts>().clone();
    if !is_new && world.non_send::<Running>().chosen == chosen {
        return;
    }
    let (scene, bodies) = match is_new {
        true => {
            let (scene, entities) = world.resource::<CurrentScene>().beginning();
            (scene.clone(), entities.bodies.clone())
        }
        false => SceneSpec::with_entities(world, "now"),
    };
    let time = world.resource::<StepStats>().time;
    let old = std::mem::take(&mut world.non_send_mut::<Running>().lanes);
    for pair in old.into_iter().flat_map(|lane| lane.pairs) {
        world.despawn(pair.ghost);
    }
    let limits = Limits::of(&scene);
    let mut readings = GhostReadings { start: time, limit: world.resource::<GhostReadings>().limit, ..default() };
    let mut lanes = Vec::new();
    for (choice, color) in chosen.0.iter().zip(COLORS) {
        let settings = choice.settings(world.resource::<SolverSettings>());
        let lane = match settings {
            Some(settings) => Some(Lane::by(settings, &scene, time)),
            None => Lane::answer(&world.resource::<CurrentScene>().spec),
        };
        let Some(mut lane) = lane else { continue };
        let at_start = lane.advance(time, |_, _| ());
        // The answer knows the bodies in the order of the scene's file.
        let entities = match choice {
            GhostChoice::Reference => &world.resource::<CurrentScene>().entities.bodies.clone(),
            _ => &bodies,
        };
        lane.pairs = at_start
            .into_iter()
            .filter_map(|(index, position, rotation)| {
                let body = *entities.get(index)?;
                let is_seen =
                    world.get::<RigidBody>(body) == Some(&RigidBody::Dynamic) && world.get::<Collider>(body).is_some();
                let look = (Name::new("ghost"), Transform::default(), Pickable::IGNORE);
                is_seen.then(|| Pair { index, body, ghost: world.spawn(look).id(), poses: [(position, rotation); 2] })
            })
            .collect();
        readings.ghosts.push(GhostReading {
            name: choice.name(),
            color,
            apart: Apart::default(),
            reading: settings.map(|_| Reading::default()),
            parted: None,
        });
        lanes.push(lane);
    }
    *world.non_send_mut::<Running>() = Running { chosen, lanes, limits: Some(limits) };
    world.insert_resource(readings);
}

/// After the step of the first world: the same time in the others.
pub fn follow(
    stats: Res<StepStats>,
    measured: Option<Res<Diagnostics>>,
    bodies: Query<(&Position, &Rotation, &Collider)>,
    mut running: NonSendMut<Running>,
    mut readings: ResMut<GhostReadings>,
) {
    let Running { lanes, limits: Some(limits), .. } = &mut *running else { return };
    if lanes.is_empty() {
        return;
    }
    let GhostReadings { scene, ghosts, limit, start } = &mut *readings;
    // Before their start there are none: they wait there.
    let is_before = stats.time < *start;
    if let Some(measured) = measured {
        scene.note(&measured, &stats, limits);
    }
    for (lane, ghost) in lanes.iter_mut().zip(ghosts) {
        let place = |body| bodies.get(body).ok().map(|(at, turned, collider)| (at.0, turned.0, collider));
        let note = |measured: &Diagnostics, stats: &StepStats| {
            if let Some(reading) = &mut ghost.reading {
                reading.note(measured, stats, limits);
            }
        };
        let apart = lane.follow(stats.time, note, place);
        ghost.apart = if is_before { Apart::default() } else { apart };
        let has_parted = ghost.apart.distance > *limit;
        // What is gone back behind has not happened, or happens otherwise.
        ghost.parted.take_if(|step| *step > stats.steps || *step == stats.steps && !has_parted);
        if has_parted {
            ghost.parted.get_or_insert(stats.steps);
        }
    }
}

/// Gives ghosts the meshes of their bodies, in glass.
fn dress(
    mut commands: Commands,
    running: NonSend<Running>,
    readings: Res<GhostReadings>,
    meshes: Query<(&Mesh3d, &Transform)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut glass: Local<[Option<Handle<StandardMaterial>>; MOST_GHOSTS]>,
) {
    for (lane, reading) in running.lanes.iter().zip(&readings.ghosts) {
        let Some(kind) = COLORS.iter().position(|color| *color == reading.color) else { continue };
        for pair in &lane.pairs {
            if meshes.contains(pair.ghost) {
                continue;
            }
            let Ok((mesh, pose)) = meshes.get(pair.body) else { continue };
            let material = glass[kind].get_or_insert_with(|| {
                let [red, green, blue] = reading.color;
                materials.add(StandardMaterial {
                    base_color: Color::srgb_u8(red, green, blue).with_alpha(COVERS),
                    alpha_mode: AlphaMode::Blend,
                    perceptual_roughness: 0.4,
                    depth_bias: DEPTH_BIAS,
                    ..default()
                })
            });
            // Body and ghost in nearly one place would mottle each other with their shadows.
            let size = Transform::from_scale(pose.scale);
            let look = (mesh.clone(), size, MeshMaterial3d(material.clone()), NotShadowCaster, NotShadowReceiver);
            commands.entity(pair.ghost).insert(look);
        }
    }
}

/// Between the last two poses, as bodies are.
fn place(
    fixed: Res<Time<Fixed>>,
    origin: Res<RenderOrigin>,
    running: NonSend<Running>,
    mut transforms: Query<&mut Transform>,
) {
    let alpha = fixed.overstep_fraction_f64();
    for pair in running.lanes.iter().flat_map(|lane| &lane.pairs) {
        let [(from_position, from_rotation), (position, rotation)] = pair.poses;
        if let Ok(mut transform) = transforms.get_mut(pair.ghost) {
            transform.translation = (from_position.lerp(position, alpha) - origin.0).as_vec3();
            transform.rotation = from_rotation.slerp(rotation, alpha).as_quat();
        }
    }
}
