//! What the parts of the sandbox share.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use crate::scene::{SceneSpec, SpawnedScene};

/// The scene that is loaded; written by [`super::SandboxAction::LoadScene`],
/// [`super::SandboxAction::ReloadScene`] and [`super::SandboxAction::Reset`] alone, and changed at each.
#[derive(Resource, Clone, Debug)]
pub struct CurrentScene {
    /// A built-in name, or the path of a RON file.
    pub scene: String,
    /// The parameters it was loaded with, those left at their default not among them.
    pub parameters: Vec<(String, f64)>,
    /// What was loaded.
    pub spec: SceneSpec,
    /// Its entities, in the order of the spec's lists; some may be despawned since.
    pub entities: SpawnedScene,
    /// What it began as where that is not the spec: it was left as it had been built by then, and came back.
    pub came_back_as: Option<Box<(SceneSpec, SpawnedScene)>>,
}

impl CurrentScene {
    /// What stood at its first step, and its entities in the order of those lists.
    pub fn beginning(&self) -> (&SceneSpec, &SpawnedScene) {
        match &self.came_back_as {
            Some(came_back) => (&came_back.0, &came_back.1),
            None => (&self.spec, &self.entities),
        }
    }
}

/// What is picked: bodies, or one joint.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// By a click.
    pub body: Option<Picked>,
    /// By the last click with Shift held: what [`Self::body`] is to be joined to.
    pub partner: Option<Picked>,
    /// Beside these: by a box that was drawn around them, or by earlier clicks with Shift held.
    pub others: Vec<Entity>,
    /// By a click on its glyph; no body is picked then.
    pub joint: Option<Entity>,
}

/// A body, and the place of it that was clicked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// The body.
    pub entity: Entity,
    /// From its centre of mass, body axes, m.
    pub point: DVec3,
    /// Of the face that was hit, outward, body axes; none where no face was.
    pub normal: Option<DVec3>,
}

impl Picked {
    /// A body, as if its centre of mass had been clicked.
    pub fn at_centre(entity: Entity) -> Self {
        Self { entity, point: DVec3::ZERO, normal: None }
    }
}

impl Selection {
    /// That body alone, picked at its centre of mass.
    pub fn of(entity: Entity) -> Self {
        Self { body: Some(Picked::at_centre(entity)), ..default() }
    }

    /// Those bodies, the first as if it had been clicked at its centre of mass.
    pub fn of_bodies(bodies: impl IntoIterator<Item = Entity>) -> Self {
        let mut bodies = bodies.into_iter();
        Self { body: bodies.next().map(Picked::at_centre), others: bodies.collect(), ..default() }
    }

    /// That joint alone.
    pub fn of_joint(joint: Entity) -> Self {
        Self { joint: Some(joint), ..default() }
    }

    /// A click on a body: it is picked alone, or beside what is picked already, of which the first stays what the last is to be
    /// joined to.
    pub fn pick(&mut self, picked: Picked, adds: bool) {
        match self.body {
            Some(first) if adds && first.entity == picked.entity => self.body = Some(picked),
            Some(_) if adds => {
                let before = self.partner.replace(picked).map(|before| before.entity);
                self.others.extend(before);
                self.others.retain(|other| *other != picked.entity);
            }
            _ => *self = Self { body: Some(picked), ..default() },
        }
    }

    /// Picks those bodies, too.
    pub fn add(&mut self, bodies: impl IntoIterator<Item = Entity>) {
        let mut all: Vec<Entity> = self.bodies().collect();
        let known = all.len();
        for body in bodies {
            if !all.contains(&body) {
                all.push(body);
            }
        }
        match self.body {
            Some(_) => self.others.extend(&all[known..]),
            None => *self = Self::of_bodies(all),
        }
    }

    /// The body picked by a click.
    pub fn entity(&self) -> Option<Entity> {
        self.body.map(|picked| picked.entity)
    }

    /// The bodies that were clicked.
    pub fn picks(&self) -> impl Iterator<Item = Picked> {
        self.body.into_iter().chain(self.partner)
    }

    /// All bodies that are picked.
    pub fn bodies(&self) -> impl Iterator<Item = Entity> {
        self.picks().map(|picked| picked.entity).chain(self.others.iter().copied())
    }
}

/// How simulation time runs against the clock.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Playback {
    /// Time stands still.
    pub paused: bool,
    /// Time runs at [`Playback::SLOW`] of the clock.
    pub slow: bool,
}

impl Playback {
    /// Speed of slow motion.
    pub const SLOW: f64 = 0.2;

    /// Simulated seconds per second while not paused.
    pub fn speed(&self) -> f64 {
        if self.slow { Self::SLOW } else { 1.0 }
    }
}

/// The last word to the user, in one line.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum Notice {
    /// Nothing to say.
    #[default]
    None,
    /// Something was done.
    Info(String),
    /// Something could not be done.
    Error(String),
}

/// Why the scene that was asked for last is not on view, if it is not.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct SceneProblem(pub Option<String>);

/// Says what was done, or why it was not.
pub(super) fn report(world: &mut World, outcome: Result<String, String>) {
    *world.resource_mut::<Notice>() = match outcome {
        Ok(done) => Notice::Info(done),
        Err(reason) => Notice::Error(reason),
    };
}

/// The keys that drive motors of the running scene: what else they would do, they do not.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(super) struct DrivingKeys(pub Vec<DrivenMotors>);

/// What two keys drive.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DrivenMotors {
    /// Forward and back.
    pub keys: [KeyCode; 2],
    /// The keys as they are labelled.
    pub label: String,
    /// Names of the motors' joints.
    pub joints: Vec<String>,
}

/// Ctrl and ⌘.
pub(super) const CONTROL_KEYS: [KeyCode; 4] =
    [KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::SuperLeft, KeyCode::SuperRight];

/// Both Shift keys.
pub(super) const SHIFT_KEYS: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];

/// Whether Ctrl or ⌘ is held.
pub(super) fn is_control_held(keys: &ButtonInput<KeyCode>) -> bool {
    keys.any_pressed(CONTROL_KEYS)
}

/// What is covered of the window, logical pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Covered {
    /// By the panel, of the width.
    pub right: f32,
    /// By the plots, of the height.
    pub bottom: f32,
}

impl Covered {
    /// The same in points of the interface: by the panel, of the width, and by the plots, of the height.
    pub fn in_points(&self, context: &egui::Context) -> [f32; 2] {
        [self.right, self.bottom].map(|pixels| pixels / context.zoom_factor())
    }
}

/// Whether the plots are on view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShowsPlots(pub bool);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Selection>()
        .init_resource::<Notice>()
        .init_resource::<SceneProblem>()
        .init_resource::<Covered>()
        .init_resource::<ShowsPlots>();
}
