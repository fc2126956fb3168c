//! Changes of what stands beside a joint: limits, a motor, friction, strength.

use bevy::ecs::component::Mutable;
use bevy::prelude::*;

use crate::physics::{
    Breakable, BrokenJoint, DistanceJoint, DistanceLaw, JointFriction, JointLimits, JointMotor, Softness,
};
use crate::scene::{JointComponent, JointParts, MotorKeys};

/// What [`SandboxAction::ChangeJoint`](crate::sandbox::SandboxAction::ChangeJoint) writes to a joint; what is none is
/// taken off.
#[derive(Clone, Debug, PartialEq)]
pub enum JointChange {
    /// How far it may go.
    Limits(Option<JointLimits>),
    /// What drives it.
    Motor(Option<JointMotor>),
    /// The keys that drive the motor.
    Keys(Option<MotorKeys>),
    /// Dry friction.
    Friction(Option<JointFriction>),
    /// What it bears.
    Strength(Option<Breakable>),
    /// Whether it broke.
    Broken(Option<BrokenJoint>),
    /// Of a distance joint, its length.
    Length(DistanceLaw),
    /// Of a ball joint, its spring.
    Softness(Option<Softness>),
}

impl JointChange {
    /// Writes it, and becomes the change back.
    pub(super) fn swap(&mut self, parts: &mut JointParts) {
        match self {
            Self::Limits(limits) => std::mem::swap(limits, &mut parts.limits),
            Self::Motor(motor) => std::mem::swap(motor, &mut parts.motor),
            Self::Keys(keys) => std::mem::swap(keys, &mut parts.keys),
            Self::Friction(friction) => std::mem::swap(friction, &mut parts.friction),
            Self::Strength(breakable) => std::mem::swap(breakable, &mut parts.breakable),
            Self::Broken(broken) => std::mem::swap(broken, &mut parts.broken),
            Self::Length(length) => {
                if let JointComponent::Distance(DistanceJoint { length: own, .. }) = &mut parts.joint {
                    std::mem::swap(length, own);
                }
            }
            Self::Softness(softness) => {
                if let JointComponent::Ball(joint) = &mut parts.joint {
                    std::mem::swap(softness, &mut joint.softness);
                }
            }
        }
    }

    /// What it is a change of.
    pub(super) fn noun(&self) -> &'static str {
        match self {
            Self::Limits(_) => "limits",
            Self::Motor(_) => "motor",
            Self::Keys(_) => "keys",
            Self::Friction(_) => "friction",
            Self::Strength(_) => "strength",
            Self::Broken(_) => "state",
            Self::Length(_) => "length",
            Self::Softness(_) => "softness",
        }
    }

    /// Whether both are changes of the same thing.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// Writes it to a joint, and becomes the change back. Tells whether the joint is there.
    pub(super) fn write(&mut self, world: &mut World, joint: Entity) -> bool {
        let Some(was) = JointParts::of_entity(world, joint) else { return false };
        let mut parts = was.clone();
        self.swap(&mut parts);
        let mut entity = world.entity_mut(joint);
        put(&mut entity, parts.limits);
        put(&mut entity, parts.motor);
        put(&mut entity, parts.keys);
        put(&mut entity, parts.friction);
        put(&mut entity, parts.breakable);
        put(&mut entity, parts.broken);
        if parts.joint != was.joint {
            parts.joint.insert(&mut entity);
        }
        true
    }
}

/// Gives an entity that component, or none; what is the same already does not count as changed.
fn put<C: Component<Mutability = Mutable> + PartialEq>(entity: &mut EntityWorldMut, part: Option<C>) {
    if entity.get() == part.as_ref() {
        return;
    }
    match part {
        Some(part) => _ = entity.insert(part),
        None => _ = entity.remove::<C>(),
    }
}
