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
        BallJoint, BodyQuarantined, Breakable, BrokenJoint, CastHit, Collider, Collision, CollisionLayers,
        ContactEnded, ContactModel, ContactStarted, ConvexHull, Damping, Density, DistanceJoint, DistanceLaw,
        ExactIntegrator, ExactSettings, ExternalForce, FixedJoint, FrictionModel, GenericJoint, Gravity, GravityScale,
        HingeJoint, ImpulseSettings, Inertia, Integrator, JointAxes, JointAxis, JointBroke, JointCoordinate,
        JointFriction, JointLimits, JointLoad, JointMotor, LimitRange, LimitReached, LockedAxes, Mass, Method,
        MotorTarget, ObserveContacts, PhysicsPlugin, PhysicsQuery, PlacedCollider, PointHit, Position, Precision,
        PrescribedMotion, Quarantined, QueryFilter, Ray, RayHit, RenderOrigin, ReportCollisions, RigidBody, Rotation,
        Sensor, SensorEnded, SensorStarted, Sleeping, SliderJoint, Softness, SolverSettings, StepStats,
        SurfaceMaterial, SweepSettings, Velocity, headless_app, step,
    };
    pub use crate::physics::{PhysicsSchedule, PhysicsSystems};
}
