//! What a body is made of: the components that users see, and the packed copy that a step works on.

mod components;
pub(crate) mod free_flight;
pub(crate) mod free_rotation;
mod packed;
mod pose_history;
mod rotation;
mod slot;

pub use components::{
    CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass, ObserveContacts,
    Position, QuarantineReason, Quarantined, ReportCollisions, RigidBody, Rotation, Sensor, Sleeping, SurfaceMaterial,
    Velocity,
};
pub(crate) use packed::{Bodies, Body};
pub use pose_history::RenderOrigin;
pub(crate) use pose_history::{PoseHistory, bits};
use rotation::is_isotropic;
pub(crate) use rotation::{rotation_by, world_inverse_inertia};
pub(crate) use slot::{BirthCounter, BodySlot, GatheredWith, Presence};
