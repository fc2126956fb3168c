//! The solver's packed copy of the bodies, gathered from the ECS at the start of each step and
//! written back at its end. A private cache: never the only copy of anything. A body that nobody
//! else writes to is gathered once and stays as the steps leave it.

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::{CollisionLayers, RigidBody, SurfaceMaterial, rotation_by};
use crate::physics::{BitSet, Geometry};

/// One body as the step sees it. World axes and SI unless stated.
///
/// In the order in which a step needs it: the first two cache lines are what every step reads and
/// writes of a body, the next two what the solver reads, the rest is looked at when something
/// changes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Body {
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    /// The rotation that rows of contacts are made for: this one, or one a little before.
    pub frame: UnitQuaternion<f64>,
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
    pub entity: Entity,
    /// Bounding sphere about the centre of mass, m; infinite for a half-space, 0 without geometry.
    pub radius: f64,
    /// A quarantined body counts as static.
    pub kind: RigidBody,
    /// The greatest acceleration that springs at points of it may give a point of it in this step, m/s².
    pub pulled: f64,
    /// Wants [`crate::physics::Collision`] messages.
    pub reports: bool,
    /// Only reports what is in it.
    pub is_sensor: bool,
    /// Collider, density or mass changed since they were computed.
    pub mass_is_stale: bool,
    /// 0 for what the solver does not move.
    pub mass: f64,
    /// Force and torque of this step, gravity included.
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
    /// Per world axis; zero for static and kinematic bodies and along locked axes.
    pub inverse_mass: Vector3<f64>,
    /// Principal, body axes; zero like `inverse_mass`.
    pub inverse_inertia_body: Vector3<f64>,
    /// 0 about a locked world axis, 1 else.
    pub rotation_freedom: Vector3<f64>,
    /// Drag, 1/s, linear and angular, the settings' included.
    pub drag: (f64, f64),
    /// Counts new shapes: whatever was known of its contacts is void.
    pub changes: u32,
    pub material: SurfaceMaterial,
    pub layers: CollisionLayers,
    /// None: the body touches nothing.
    pub geometry: Option<Geometry>,
    /// Whether a step has moved it since it became a body.
    pub has_stepped: bool,
    /// Mass and inertia that Plumb computed itself, to be computed again when the shape changes.
    pub computed_mass: Option<f64>,
    pub computed_inertia: Option<Vector3<f64>>,
}

impl Body {
    /// A body of that entity, at rest at the origin, touching nothing.
    pub fn new(entity: Entity) -> Self {
        Self {
            entity,
            kind: RigidBody::Static,
            position: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            frame: UnitQuaternion::identity(),
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
            force: Vector3::zeros(),
            torque: Vector3::zeros(),
            mass: 0.0,
            inverse_mass: Vector3::zeros(),
            inverse_inertia_body: Vector3::zeros(),
            rotation_freedom: Vector3::repeat(1.0),
            drag: (0.0, 0.0),
            geometry: None,
            radius: 0.0,
            changes: 0,
            material: SurfaceMaterial::default(),
            layers: CollisionLayers::ALL,
            reports: false,
            is_sensor: false,
            has_stepped: false,
            computed_mass: None,
            computed_inertia: None,
            mass_is_stale: false,
            pulled: 0.0,
        }
    }

    /// Whether contacts and joints can move it.
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }

    /// Whether it has no contacts, whatever comes near.
    pub fn touches_nothing(&self) -> bool {
        self.is_sensor || self.layers.touch_nothing()
    }

    /// Moves and turns it, by a rotation vector.
    pub fn advance(&mut self, moved: &Vector3<f64>, turned: &Vector3<f64>) {
        self.position += moved;
        if *turned != Vector3::zeros() {
            self.rotation = rotation_by(turned) * self.rotation;
            self.rotation.renormalize_fast();
        }
    }

    /// Goes on with its present velocities for a time, s.
    pub fn coast(&mut self, time: f64) {
        self.advance(&(self.linear * time), &(self.angular * time));
    }

    /// Velocity of the material point at `arm` from the centre of mass.
    pub fn point_velocity(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(arm)
    }
}

/// All bodies, in the order in which they became bodies.
#[derive(Resource, Default, Clone)]
pub(crate) struct Bodies {
    pub list: Vec<Body>,
    /// Counts every time a body came, went or changed its kind.
    pub version: u64,
    /// Those that in this step are new, jumped, or changed their shape, layers or kind.
    pub renewed: Vec<u32>,
    /// Those that sleep: dynamic ones that the step leaves as they are.
    pub asleep: BitSet,
    /// Those that are static: a step leaves them where they are, and looks at none of them for itself.
    pub fixed: BitSet,
    /// Counts every time one fell asleep or woke.
    pub sleep_version: u64,
    /// When the last step wrote bodies back: what was written then is known here already.
    pub written_back: Option<Tick>,
    /// When the last step ended: its commands were applied with that tick.
    pub ended: Option<Tick>,
}

impl Bodies {
    /// As a step gathers them.
    #[cfg(test)]
    pub fn of(list: Vec<Body>) -> Self {
        let mut fixed = BitSet::default();
        (0..).zip(&list).for_each(|(index, body)| fixed.set(index, body.kind == RigidBody::Static));
        Self { list, fixed, ..Self::default() }
    }

    /// Those that may move in a step: neither asleep nor static, in their order.
    pub fn awake(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.asleep.in_neither(&self.fixed, 0..self.list.len() as u32)
    }

    /// Whether contacts and joints can move a body now.
    pub fn is_awake_dynamic(&self, body: u32) -> bool {
        self.list[body as usize].is_dynamic() && !self.asleep.contains(body)
    }
}
