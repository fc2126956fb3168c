//! What a pointer is on in the picture.

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::picking::backend::HitData;
use bevy::prelude::*;
use bevy_egui::{EguiContext, PrimaryEguiContext, egui};

use super::Picked;
use super::ground::GroundOf;
use crate::physics::{Collider, RenderOrigin, RigidBody, Shape};

/// A body, where it was hit, and where that is in the world, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aimed {
    pub picked: Picked,
    pub place: DVec3,
    /// Whether it is the ground.
    pub is_ground: bool,
}

/// What can be aimed at.
#[derive(SystemParam)]
pub(super) struct Targets<'w, 's> {
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
        Some(Aimed {
            picked: Picked {
                entity,
                point: (to_body * (at - pose.translation)).as_dvec3(),
                normal: hit.normal.and_then(|normal| (to_body * normal).as_dvec3().try_normalize()),
            },
            place: self.origin.0 + at.as_dvec3(),
            is_ground: *collider.shape() == Shape::HalfSpace,
        })
    }
}

/// Whether a press is on what the picture shows.
#[derive(SystemParam)]
pub(super) struct Picture<'w, 's> {
    egui: Query<'w, 's, &'static mut EguiContext, With<PrimaryEguiContext>>,
}

impl Picture<'_, '_> {
    /// The event bubbles up to the window: it is one at what was hit, and there only; and not where something of egui's lies.
    pub fn is_pressed(&mut self, press: &On<Pointer<Press>>) -> bool {
        let position = press.pointer_location.position;
        press.entity == press.original_event_target()
            && !self.egui.iter_mut().any(|mut context| claims(context.get_mut(), position))
    }
}

/// Whether something of egui's that takes clicks lies at that place of the window.
fn claims(context: &mut egui::Context, position: Vec2) -> bool {
    let position = egui::pos2(position.x, position.y) / context.zoom_factor();
    context.layer_id_at(position).is_some_and(|layer| layer.order != egui::Order::Background)
}
