//! What is under the pointer.

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::picking::backend::HitData;
use bevy::prelude::*;

use crate::physics::{Collider, RenderOrigin, RigidBody, Shape};
use crate::sandbox::Picked;
use crate::sandbox::ground::GroundOf;

/// A body, where it was hit, and where that is in the world, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aimed {
    pub picked: Picked,
    pub place: DVec3,
    /// Of the surface there, outward.
    pub normal: Option<DVec3>,
    /// Whether it is the ground.
    pub is_ground: bool,
}

/// What can be aimed at.
#[derive(SystemParam)]
pub struct Targets<'w, 's> {
    bodies: Query<'w, 's, (&'static Collider, &'static Transform), With<RigidBody>>,
    grounds: Query<'w, 's, &'static GroundOf>,
    origin: Res<'w, RenderOrigin>,
}

impl Targets<'_, '_> {
    /// What was hit, if it is a body or the ground. The picture was hit, which lags behind the last step.
    pub fn aimed(&self, entity: Entity, hit: &HitData) -> Option<Aimed> {
        let at = hit.position?;
        let entity = self.grounds.get(entity).map_or(entity, |ground| ground.body());
        let (collider, pose) = self.bodies.get(entity).ok()?;
        let to_body = pose.rotation.inverse();
        let normal = hit.normal.and_then(|normal| normal.as_dvec3().try_normalize());
        Some(Aimed {
            picked: Picked {
                entity,
                point: (to_body * (at - pose.translation)).as_dvec3(),
                normal: normal.map(|normal| to_body.as_dquat() * normal),
            },
            place: self.origin.0 + at.as_dvec3(),
            normal,
            is_ground: *collider.shape() == Shape::HalfSpace,
        })
    }
}
