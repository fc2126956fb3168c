//! `Prepare`: from the ECS to packed arrays.
//!
//! 1. Bodies ([`gather_bodies`](mod@gather_bodies)): new ones enter, gone ones leave. Of the others, those that nobody
//!    wrote to since the last step are right already in the packed array, as the last step left
//!    them: they cost a few tick comparisons ([`table`]) and nothing is copied. The rest is gathered
//!    whole ([`gather_body`]): poses and velocities are copied, transforms that the user moved
//!    teleport, mass and geometry are computed where they changed, forces summed, what makes no
//!    sense is quarantined.
//! 2. Joints ([`gather_joints`](mod@gather_joints)): packed again only when a joint or the set of bodies changed; a
//!    joint of a body that is gone is despawned. New numbers of limits, motors and friction are taken in where they
//!    stand.
//! 3. Pulls ([`feel_pulls`](mod@feel_pulls)): bodies that a spring holds at a point are told what it may do to them.

mod add_joint;
mod feel_pulls;
mod gather_bodies;
mod gather_body;
mod gather_joints;
mod table;
#[cfg(test)]
mod tests;

use add_joint::add_joint;
use bevy::prelude::*;
use feel_pulls::{Pulled, feel_pulls};
use gather_bodies::{Summed, gather_bodies};
use gather_joints::{PackedFor, attachments_changed, gather_joints, joints_changed, keep_driven_awake, renew_laws};

use crate::physics::{
    BallJoint, BirthCounter, Bodies, BodySlot, Collider, CollisionLayers, Damping, Density, DistanceJoint,
    ExternalForce, FixedJoint, GatheredWith, GenericJoint, GravityScale, HingeJoint, Inertia, JoinedPairs,
    JointCoordinate, JointDefinition, JointFriction, JointLimits, JointLoad, JointMotor, JointSlot, Joints, Keep,
    LockedAxes, Mass, ObserveContacts, PhysicsSchedule, PhysicsSystems, PoseHistory, Position, Quarantined,
    ReportCollisions, RigidBody, Rotation, Sleeping, SliderJoint, SurfaceMaterial, Velocity,
};
pub use add_joint::AddConstraint;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Bodies>()
        .init_resource::<Joints>()
        .init_resource::<JoinedPairs>()
        .init_resource::<PackedFor>()
        .init_resource::<BirthCounter>()
        .init_resource::<Summed>()
        .init_resource::<Pulled>()
        .add_systems(
            PhysicsSchedule,
            (
                gather_bodies,
                renew_laws.run_if(attachments_changed),
                gather_joints.run_if(joints_changed),
                keep_driven_awake,
                feel_pulls,
            )
                .chain()
                .in_set(PhysicsSystems::Prepare),
        );
    keep(app);
    add_joint::<BallJoint>(app);
    add_joint::<HingeJoint>(app);
    add_joint::<SliderJoint>(app);
    add_joint::<FixedJoint>(app);
    add_joint::<DistanceJoint>(app);
    add_joint::<GenericJoint>(app);
    app.register_required_components::<HingeJoint, JointCoordinate>();
    app.register_required_components::<GenericJoint, JointCoordinate>();
}

/// What a body is, and what joins them.
fn keep(app: &mut App) {
    app.keep_resource::<Bodies>()
        .keep_resource::<Joints>()
        .keep_resource::<JoinedPairs>()
        .keep_resource::<PackedFor>()
        .keep_resource::<Summed>()
        .keep_resource::<Pulled>()
        .keep_setting::<BirthCounter>();
    app.keep_component::<RigidBody>()
        .keep_component::<Position>()
        .keep_component::<Rotation>()
        .keep_component::<Velocity>()
        .keep_component::<Collider>()
        .keep_component::<Mass>()
        .keep_component::<Density>()
        .keep_component::<Inertia>()
        .keep_component::<ExternalForce>()
        .keep_component::<Damping>()
        .keep_component::<SurfaceMaterial>()
        .keep_component::<CollisionLayers>()
        .keep_component::<LockedAxes>()
        .keep_component::<GravityScale>()
        .keep_component::<ReportCollisions>()
        .keep_component::<ObserveContacts>()
        .keep_component::<Quarantined>()
        .keep_result::<Sleeping>()
        .keep_result::<BodySlot>()
        .keep_result::<GatheredWith>()
        .keep_transforms()
        .keep_result::<PoseHistory>();
    app.keep_component::<JointDefinition>()
        .keep_component::<JointLimits>()
        .keep_component::<JointMotor>()
        .keep_component::<JointFriction>()
        .keep_result::<JointCoordinate>()
        .keep_reading::<JointLoad>()
        .keep_result::<JointSlot>();
}
