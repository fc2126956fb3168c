//! The headless physics plugin: components, the step and its solver, on Bevy's ECS alone.
//!
//! A step runs [`PhysicsSchedule`], whose sets ([`PhysicsSystems`]) are, in order:
//! 1. `Prepare`: gather what changed into packed arrays, sum forces;
//! 2. `BroadPhase`: which bodies may touch;
//! 3. `NarrowPhase`: where they touch;
//! 4. `Islands`: which bodies can influence each other in this step;
//! 5. `Solve`: rows, substeps, the chosen method, integration;
//! 6. `WriteBack`: poses, velocities, joint loads;
//! 7. `Events`: messages and entity events;
//! 8. `Diagnose`: energy, momentum, errors, only where somebody reads them.
//!
//! The schedule runs on the single-threaded executor, because starting systems on several
//! threads costs more than most scenes take; threads are used inside the heavy phases.

mod bit_set;
mod body;
mod box_tree;
mod breaking;
mod collision;
mod columns;
mod constraint;
mod contact;
mod contact_problem;
mod diagnostics;
mod disjoint_sets;
mod events;
mod grouped;
mod hard_problems;
mod island;
pub mod joint;
mod lanes;
mod left_over;
mod messages;
mod phase_times;
mod plugin;
mod prepare;
mod query;
mod readings;
mod refill;
mod rewind;
mod scalar;
mod schedule;
mod settings;
pub mod shape;
mod sleep;
mod solve_trace;
mod solver;
mod state_hash;
mod stats;
mod step_details;
#[cfg(test)]
mod testing;
mod threads;
mod told_pairs;
mod transform;
mod write_back;

pub(crate) use bit_set::BitSet;
pub(crate) use body::{
    BirthCounter, Bodies, Body, BodySlot, GatheredWith, PoseHistory, Presence, bits, rotation_by, world_inverse_inertia,
};
pub use body::{
    CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass, ObserveContacts,
    Position, QuarantineReason, Quarantined, RenderOrigin, ReportCollisions, RigidBody, Rotation, Sensor, Sleeping,
    SurfaceMaterial, Velocity,
};
pub use collision::PlacedCollider;
pub(crate) use collision::{
    BoundingBox, ContactGraph, ContactPoint, Contacts, FeatureId, GONE, LaggedContacts, Manifold, NearPairs, Pair,
    PairSearch, VectorSet,
};
pub use contact_problem::{ContactProblem, ProblemBody, ProblemContact, ProblemJoint};
pub use hard_problems::{HardProblem, HardProblems};
pub(crate) use island::Islands;
pub use joint::{
    BallJoint, BodyState, Breakable, BrokenJoint, Constraint, ConstraintRow, ConstraintRows, DistanceJoint,
    DistanceLaw, FixedJoint, GenericJoint, HingeJoint, JointAxes, JointAxis, JointCoordinate, JointFriction,
    JointLimits, JointLoad, JointMotor, LimitRange, MotorTarget, PrescribedMotion, SliderJoint, Softness,
};
pub(crate) use joint::{JoinedPairs, Joint, JointDefinition, JointSlot, Joints};
pub use left_over::left_over;
pub(crate) use messages::set_aside;
pub use messages::{
    BodyQuarantined, Collision, ContactEnded, ContactStarted, JointBroke, LimitReached, SensorEnded, SensorStarted,
};
pub use phase_times::PhaseTimes;
pub use plugin::{PhysicsPlugin, headless_app, step};
pub use prepare::AddConstraint;
pub use query::{CastHit, PhysicsQuery, PointHit, QueryFilter, Ray, RayHit};
pub use readings::{ContactForce, ContactForces, Diagnostics, JointForce, JointForces};
pub(crate) use refill::Refill;
pub use rewind::{
    Deeds, GoError, History, Keep, Mark, Told, begin_anew, bury, go_to, is_empty, retell, swap_cut, take_back_since,
    uncut,
};
pub(crate) use scalar::Scalar;
pub use schedule::{PhysicsSchedule, PhysicsSystems};
pub(crate) use settings::contacts_last;
pub use settings::{
    Choice, Choices, ContactModel, ExactIntegrator, ExactSettings, FrictionModel, Gravity, ImpulseSettings, Integrator,
    Method, Precision, SETTINGS, Setting, SettingsError, SolverSettings, SweepSettings, WrittenSettings,
};
pub use shape::{
    Collider, Compound, CompoundChild, CompoundError, ConvexHull, HullError, MassProperties, MeshError, Shape,
    TriangleMesh,
};
pub(crate) use shape::{EdgeLanes, EdgeParts, Geometry, Hull};
pub(crate) use sleep::Sleep;
pub use solve_trace::{Residuals, SolveTrace};
pub(crate) use solver::{ExactGroups, ImpulseGroups, IslandSolvers};
pub use state_hash::hash_state;
pub use stats::StepStats;
pub use step_details::{BodyDetails, ContactDetails, JointDetails, body_details, contact_details, joint_details};
pub(crate) use threads::{Shared, for_each_of};
pub(crate) use told_pairs::ToldPairs;
pub use transform::{place, stand_still, write_now};
