//! Plumb is a rigid-body sandbox on Bevy that says how true it is and what that cost.
//!
//! Arrows point one way: the binary → [`sandbox`] → [`lab`] → [`scene`] → [`physics`].

#[cfg(feature = "lab")]
pub mod lab;
pub mod physics;
#[cfg(feature = "sandbox")]
pub mod sandbox;
#[cfg(feature = "lab")]
pub mod scene;

/// What a game that uses Plumb needs, without a clash with `bevy::prelude`.
pub mod prelude {
    pub use crate::physics::{
        BallJoint, BodyQuarantined, Collider, Collision, CollisionLayers, ContactEnded, ContactModel, ContactStarted,
        ConvexHull, Damping, Density, ExactIntegrator, ExactSettings, ExternalForce, FrictionModel, Gravity,
        GravityScale, ImpulseSettings, Inertia, Integrator, JointLoad, LockedAxes, Mass, Method, ObserveContacts,
        PhysicsPlugin, Position, Precision, Quarantined, RenderOrigin, ReportCollisions, RigidBody, Rotation, Sleeping,
        Softness, SolverSettings, StepStats, SurfaceMaterial, SweepSettings, Velocity, headless_app, step,
    };
    pub use crate::physics::{PhysicsSchedule, PhysicsSystems};
}
