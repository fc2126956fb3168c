//! The solver's packed copy of the bodies, gathered from the ECS at the start of each step and
//! written back at its end. A private cache: never the only copy of anything. A body that nobody
//! else writes to is gathered once and stays as the steps leave it.

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::bit_set::BitSet;
use super::body::{CollisionLayers, RigidBody, SurfaceMaterial};
use super::collider::Geometry;

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
    /// Wants [`super::Collision`] messages.
    pub reports: bool,
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
            has_stepped: false,
            computed_mass: None,
            computed_inertia: None,
            mass_is_stale: false,
        }
    }

    /// Whether contacts and joints can move it.
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
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

/// The rotation by a vector, rad. Small ones by the series of sine and cosine to the sixth order, which is exact to
/// rounding.
pub(crate) fn rotation_by(turned: &Vector3<f64>) -> UnitQuaternion<f64> {
    let squared = turned.norm_squared();
    if squared > 1e-4 {
        return UnitQuaternion::new(*turned);
    }
    let half = squared * 0.25;
    let vector = turned * (0.5 * (1.0 - half / 6.0 * (1.0 - half / 20.0)));
    let scalar = 1.0 - half * 0.5 * (1.0 - half / 12.0 * (1.0 - half / 30.0));
    UnitQuaternion::new_unchecked(Quaternion::from_parts(scalar, vector))
}

/// R I⁻¹ Rᵀ with the locked world axes zeroed; isotropic bodies skip the rotation.
pub(crate) fn world_inverse_inertia(
    principal: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
    freedom: &Vector3<f64>,
) -> Matrix3<f64> {
    let isotropic = principal.x == principal.y && principal.y == principal.z;
    let world = if isotropic {
        Matrix3::from_diagonal(principal)
    } else {
        let r = rotation.to_rotation_matrix().into_inner();
        let scaled =
            Matrix3::from_columns(&[r.column(0) * principal.x, r.column(1) * principal.y, r.column(2) * principal.z]);
        scaled * r.transpose()
    };
    if *freedom == Vector3::repeat(1.0) {
        world
    } else {
        let free = Matrix3::from_diagonal(freedom);
        free * world * free
    }
}

/// All bodies, in the order in which they became bodies.
#[derive(Resource, Default)]
pub(crate) struct Bodies {
    pub list: Vec<Body>,
    /// Counts every time a body came, went or changed its kind.
    pub version: u64,
    /// Those that in this step are new, jumped, or changed their shape, layers or kind.
    pub renewed: Vec<u32>,
    /// Those that sleep: dynamic ones that the step leaves as they are.
    pub asleep: BitSet,
    /// Counts every time one fell asleep or woke.
    pub sleep_version: u64,
    /// When the last step wrote bodies back: what was written then is known here already.
    pub written_back: Option<Tick>,
}

impl Bodies {
    /// Those that do not sleep, of all kinds, in their order.
    pub fn awake(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.asleep.absent(self.list.len() as u32)
    }

    /// Whether contacts and joints can move a body now.
    pub fn is_awake_dynamic(&self, body: u32) -> bool {
        self.list[body as usize].is_dynamic() && !self.asleep.contains(body)
    }
}

/// One joint as the step sees it.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub entity: Entity,
    /// Indices into [`Bodies`].
    pub a: u32,
    pub b: u32,
    /// From the centres of mass, body axes.
    pub anchor_a: Vector3<f64>,
    pub anchor_b: Vector3<f64>,
    pub softness: Option<super::joint::Softness>,
    /// Force on B in the last step, world axes, mean over its substeps, N.
    pub force: Vector3<f64>,
}

/// All joints, in the order in which they were made.
#[derive(Resource, Default)]
pub(crate) struct Joints {
    pub list: Vec<Joint>,
    /// The bodies that they hold.
    pub joined: BitSet,
    /// Counts every time they were packed anew, which is also when a body came, went or changed its kind.
    pub version: u64,
}

impl Joint {
    /// Stands for a body that is gone, until the joints are packed anew.
    pub const GONE: u32 = u32::MAX;
}

impl Joints {
    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        let of = |body: u32| new_index.get(body as usize).copied().flatten().unwrap_or(Joint::GONE);
        for joint in &mut self.list {
            (joint.a, joint.b) = (of(joint.a), of(joint.b));
        }
    }
}
