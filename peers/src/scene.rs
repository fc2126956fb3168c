//! What is measured: scenes of Plumb, built-in ones by name and parameters or files by path, with the numbers that every
//! engine is to take from the same place.

use std::collections::HashMap;
use std::fmt::{self, Display};

use bevy::ecs::world::EntityRef;
use bevy::math::{DQuat, DVec3};
use plumb::physics::{
    Collider, CollisionLayers, Damping, ExternalForce, GravityScale, Inertia, Mass, MassProperties, Position,
    RigidBody, Rotation, SolverSettings, SurfaceMaterial, Velocity, headless_app, step,
};
use plumb::scene::{self, JointSpec, SceneError, SceneSpec};

use crate::joint::Joint;

/// A built-in scene with its parameters, or one from a file.
pub struct Scene {
    /// As Plumb builds it.
    pub spec: SceneSpec,
    /// Every parameter with its value.
    pub parameters: Vec<(&'static str, f64)>,
    /// Its bodies, in its order.
    pub bodies: Vec<Body>,
    /// Its joints, bodies by index.
    pub joints: Vec<Joint>,
    /// Whether what is built falls, hits and settles, for all that is known.
    pub is_moving: bool,
}

/// The built-in scenes in which it does.
const MOVING: [&str; 4] = ["heap", "limbs", "pile", "ragdolls"];

/// A body as Plumb makes it of the scene: about its centre of mass, in principal axes. Every engine
/// is handed these numbers, so that none differs by how it weighs a shape.
#[derive(Clone, Debug)]
pub struct Body {
    /// Dynamic, kinematic or static.
    pub kind: RigidBody,
    /// What it touches with; none for one that touches nothing.
    pub collider: Option<Collider>,
    /// None for what nothing moves.
    pub mass: Option<MassProperties>,
    /// At the start.
    pub position: DVec3,
    /// At the start.
    pub rotation: DQuat,
    /// At the start, velocities in world axes.
    pub velocity: Velocity,
    /// Lasts.
    pub force: ExternalForce,
    pub material: SurfaceMaterial,
    pub layers: CollisionLayers,
    pub damping: Damping,
    pub gravity_scale: f64,
}

/// Why a scene cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum ParseError {
    #[error("scene '{0}': '{1}' is not a number")]
    NotANumber(String, String),
    #[error("scene '{0}' has fewer parameters than that")]
    TooManyValues(String),
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl Scene {
    /// The bodies where they start, at rest.
    #[cfg(test)]
    pub fn at_rest(&self) -> Vec<plumb::lab::BodyState> {
        let state = |body: &Body| plumb::lab::BodyState {
            position: body.position,
            rotation: body.rotation,
            ..Default::default()
        };
        self.bodies.iter().map(state).collect()
    }

    /// From `pyramid 40` or `joint_grid n=100 tilt=30`: a name, then parameters in order or by name; or from the path of
    /// a RON file.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        if scene::is_path(text.trim()) {
            return Ok(Self { is_moving: true, ..Self::of(scene::load(text.trim(), &[])?) });
        }
        let (name, parameters) = parse(text)?;
        let spec = scene::load(&name, &parameters)?;
        let known = scene::find(&name).map_or(&[][..], |info| info.parameters);
        let value = |known: &scene::Parameter| {
            parameters.iter().find(|(name, _)| name == known.name).map_or(known.default, |(_, value)| *value)
        };
        let parameters = known.iter().map(|known| (known.name, value(known))).collect();
        Ok(Self { parameters, ..Self::of(spec) })
    }

    /// Without parameters.
    pub fn of(spec: SceneSpec) -> Self {
        let (bodies, joints) = resolve(&spec);
        let is_moving = MOVING.contains(&spec.name.as_str());
        Self { spec, parameters: Vec::new(), bodies, joints, is_moving }
    }

    /// Its built-in name, or that of its file.
    pub fn name(&self) -> &str {
        &self.spec.name
    }

    /// How long `plumb run` simulates it where nothing is asked for, s.
    pub fn seconds(&self) -> f64 {
        scene::find(self.name()).map_or(10.0, |info| info.seconds)
    }

    /// `n=40 jitter=0`.
    pub fn parameters(&self) -> String {
        let pairs: Vec<String> = self.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        pairs.join(" ")
    }
}

impl Display for Scene {
    /// The name, the first parameter, and the others up to the last that is not at its default: `pyramid 40`,
    /// `hinge_chain 100 1`.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let known = scene::find(self.name()).map_or(&[][..], |info| info.parameters);
        let is_default = |index: usize| known.get(index).is_some_and(|known| known.default == self.parameters[index].1);
        let last = (1..self.parameters.len()).rfind(|&index| !is_default(index)).unwrap_or(0);
        write!(formatter, "{}", self.name())?;
        self.parameters.iter().take(last + 1).try_for_each(|(_, value)| write!(formatter, " {value}"))
    }
}

fn parse(text: &str) -> Result<(String, Vec<(String, f64)>), ParseError> {
    let mut words = text.split_whitespace();
    let name = words.next().unwrap_or_default().to_owned();
    let Some(info) = scene::find(&name) else {
        // Says that there is none, and which is near.
        scene::load(&name, &[])?;
        return Ok((name, Vec::new()));
    };
    let known = info.parameters;
    let mut parameters = Vec::new();
    for (index, word) in words.enumerate() {
        let (parameter, value) = match word.split_once('=') {
            Some((parameter, value)) => (parameter, value),
            None => (known.get(index).ok_or_else(|| ParseError::TooManyValues(name.clone()))?.name, word),
        };
        let number = value.parse().map_err(|_| ParseError::NotANumber(name.clone(), value.to_owned()))?;
        parameters.push((parameter.to_owned(), number));
    }
    Ok((name, parameters))
}

/// Spawns a scene into Plumb and reads what became of it. Mass and inertia are there after a step.
fn resolve(spec: &SceneSpec) -> (Vec<Body>, Vec<Joint>) {
    let mut app = headless_app();
    let world = app.world_mut();
    world.insert_resource(SolverSettings { substeps: 1, iterations: 1, ..SolverSettings::default() });
    let spawned = spec.spawn(world);
    let mut bodies: Vec<Body> = spawned.bodies.iter().map(|&body| Body::of(world.entity(body))).collect();
    step(world);
    for (body, &entity) in bodies.iter_mut().zip(&spawned.bodies) {
        body.mass = mass(world.entity(entity)).filter(|_| body.kind == RigidBody::Dynamic);
    }
    let index: HashMap<&str, usize> = spec.bodies.iter().map(|body| body.name.as_str()).zip(0..).collect();
    let joint = |joint: &JointSpec| {
        let ends = [index[joint.body_a.as_str()], index[joint.body_b.as_str()]];
        Joint::of_spec(joint, ends, ends.map(|body| spec.bodies[body].rotation), &bodies)
    };
    let joints = spec.joints.iter().map(joint).collect();
    (bodies, joints)
}

impl Body {
    /// Before the first step: its mass is not known yet.
    fn of(body: EntityRef) -> Self {
        let layers = body.get::<CollisionLayers>().copied().unwrap_or_default();
        let touches = layers.memberships != 0 && layers.filters != 0;
        let &kind = body.components::<&RigidBody>();
        let (&Position(position), &Rotation(rotation), &velocity) =
            body.components::<(&Position, &Rotation, &Velocity)>();
        Self {
            kind,
            collider: body.get::<Collider>().filter(|_| touches).cloned(),
            mass: None,
            position,
            rotation,
            velocity,
            force: body.get::<ExternalForce>().copied().unwrap_or_default(),
            material: body.get::<SurfaceMaterial>().copied().unwrap_or_default(),
            layers,
            damping: body.get::<Damping>().copied().unwrap_or_default(),
            gravity_scale: body.get::<GravityScale>().copied().unwrap_or_default().0,
        }
    }

    /// Whether a force or torque acts on it besides gravity.
    pub fn is_pushed(&self) -> bool {
        self.mass.is_some() && self.force != ExternalForce::default()
    }
}

fn mass(body: EntityRef) -> Option<MassProperties> {
    Some(MassProperties { mass: body.get::<Mass>()?.0, inertia: body.get::<Inertia>()?.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_taken_in_order_or_by_name() {
        assert_eq!(parse("pyramid 40").unwrap(), ("pyramid".into(), vec![("n".into(), 40.0)]));
        let grid = vec![("n".into(), 100.0), ("tilt".into(), 30.0)];
        assert_eq!(parse(" joint_grid n=100  tilt=30 ").unwrap(), ("joint_grid".into(), grid.clone()));
        assert_eq!(parse("joint_grid 100 30").unwrap(), ("joint_grid".into(), grid));
        assert!(matches!(parse("arm 1"), Err(ParseError::TooManyValues(_))));
        assert!(matches!(parse("stack ten"), Err(ParseError::NotANumber(..))));
        assert!(matches!(parse("stak 10"), Err(ParseError::Scene(SceneError::UnknownScene { .. }))));
    }

    #[test]
    fn a_file_is_a_scene_of_which_nothing_is_known() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/scenes/example.ron");
        let scene = Scene::parse(&format!(" {file} ")).unwrap();
        assert!(scene.is_moving && scene.parameters.is_empty() && scene.bodies.len() > 1);
        assert_eq!(scene.to_string(), "example");
        assert!(matches!(Scene::parse("nowhere.ron"), Err(ParseError::Scene(_))));
    }

    #[test]
    fn a_scene_shows_its_first_parameter_and_those_that_are_set() {
        assert_eq!(Scene::parse("hinge_chain 100 1").unwrap().to_string(), "hinge_chain 100 1");
        assert_eq!(Scene::parse("hinge_chain n=5 limit=45").unwrap().to_string(), "hinge_chain 5 1000 45");
        assert_eq!(Scene::parse("stack").unwrap().to_string(), "stack 10");
        assert_eq!(Scene::parse("stack n=3").unwrap().parameters(), "n=3 jitter=0");
        assert_eq!(Scene::parse("arm").unwrap().to_string(), "arm");
    }

    #[test]
    fn bodies_are_what_plumb_makes_of_the_scene() {
        let rods = Scene::parse("rods 1").unwrap();
        let (pivot, rod) = (&rods.bodies[0], &rods.bodies[1]);
        assert!(pivot.mass.is_none() && pivot.collider.is_none() && rod.collider.is_none());
        // A rod 1 × 0.1 × 0.1 m of 1 kg.
        let MassProperties { mass, inertia } = rod.mass.unwrap();
        assert!((mass - 1.0).abs() < 1e-12);
        assert!((inertia - DVec3::new(0.02, 1.01, 1.01) / 12.0).length() < 1e-12, "{inertia}");
        // Where it is at the start, not after a step.
        assert_eq!((rod.position, rod.velocity), (DVec3::new(0.5, 0.0, 0.0), Velocity::default()));
        let Joint { a, b, anchor_a, anchor_b, collide, .. } = rods.joints[0];
        assert_eq!((a, b, anchor_a, anchor_b, collide), (0, 1, DVec3::ZERO, DVec3::new(-0.5, 0.0, 0.0), false));
        assert!(Scene::parse("stack 1").unwrap().bodies.iter().all(|body| body.collider.is_some()));
    }
}
