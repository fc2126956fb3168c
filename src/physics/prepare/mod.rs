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

mod add_joint;
mod gather_bodies;
mod gather_body;
mod gather_joints;
mod table;
#[cfg(test)]
mod tests;

use add_joint::add_joint;
use bevy::prelude::*;
use gather_bodies::gather_bodies;
use gather_joints::{PackedFor, attachments_changed, gather_joints, joints_changed, keep_driven_awake, renew_laws};

use crate::physics::{
    BallJoint, BirthCounter, Bodies, DistanceJoint, FixedJoint, GenericJoint, HingeJoint, JoinedPairs, JointCoordinate,
    Joints, PhysicsSchedule, PhysicsSystems, SliderJoint,
};
pub use add_joint::AddConstraint;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Bodies>()
        .init_resource::<Joints>()
        .init_resource::<JoinedPairs>()
        .init_resource::<PackedFor>()
        .init_resource::<BirthCounter>()
        .add_systems(
            PhysicsSchedule,
            (
                gather_bodies,
                renew_laws.run_if(attachments_changed),
                gather_joints.run_if(joints_changed),
                keep_driven_awake,
            )
                .chain()
                .in_set(PhysicsSystems::Prepare),
        );
    add_joint::<BallJoint>(app);
    add_joint::<HingeJoint>(app);
    add_joint::<SliderJoint>(app);
    add_joint::<FixedJoint>(app);
    add_joint::<DistanceJoint>(app);
    add_joint::<GenericJoint>(app);
    app.register_required_components::<HingeJoint, JointCoordinate>();
    app.register_required_components::<GenericJoint, JointCoordinate>();
}
