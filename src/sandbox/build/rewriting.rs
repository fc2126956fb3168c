//! Writing what a body is to one that is there.

use bevy::prelude::*;

use crate::physics::{Inertia, Mass, Sensor, SurfaceMaterial, Velocity};
use crate::scene::{BodyColor, BodySpec};

/// Writes what of it differs, but for the pose. What it was; none where it is gone.
pub fn write_body(world: &mut World, body: Entity, asked: &BodySpec) -> Option<BodySpec> {
    let was = BodySpec::of_entity(world, body)?;
    let mut entity = world.entity_mut(body);
    if asked.name != was.name {
        entity.insert(Name::new(asked.name.clone()));
    }
    if asked.kind != was.kind {
        entity.insert(asked.kind);
    }
    let has_other_shape = asked.shape != was.shape;
    if let (Some(shape), true) = (&asked.shape, has_other_shape) {
        entity.insert(shape.collider());
    }
    match asked.mass {
        Some(mass) if asked.mass != was.mass => _ = entity.insert(Mass(mass)),
        // Found anew from shape and density.
        None if was.mass.is_some() || has_other_shape => _ = entity.remove::<Mass>(),
        _ => {}
    }
    if has_other_shape || asked.mass != was.mass {
        entity.remove::<Inertia>();
    }
    if asked.material != was.material {
        let material = asked.material;
        entity.insert(SurfaceMaterial { friction: material.friction, restitution: material.restitution });
    }
    if asked.layers != was.layers {
        entity.insert(asked.layers);
    }
    if asked.sensor && !was.sensor {
        entity.insert(Sensor);
    } else if was.sensor && !asked.sensor {
        entity.remove::<Sensor>();
    }
    let velocity = Velocity { linear: asked.linear_velocity, angular: asked.angular_velocity };
    if velocity != (Velocity { linear: was.linear_velocity, angular: was.angular_velocity }) {
        entity.insert(velocity);
    }
    if asked.color != was.color {
        match asked.color {
            Some(color) => _ = entity.insert(BodyColor(color)),
            None => _ = entity.remove::<BodyColor>(),
        }
    }
    Some(was)
}
