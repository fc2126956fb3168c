//! What a question is about: whom it may find.

use bevy::prelude::*;

use crate::physics::body::CollisionLayers;
use crate::physics::{Body, RigidBody};

/// Which bodies a question may find: all that have a shape and are no [`Sensor`](crate::physics::Sensor), unless it is
/// narrowed.
///
/// ```
/// use bevy::prelude::*;
/// use plumb::prelude::*;
///
/// let player = Entity::PLACEHOLDER;
/// let filter = QueryFilter { without: &[player], ..default() };
/// ```
#[derive(Clone, Copy, Default)]
pub struct QueryFilter<'f> {
    /// Only bodies whose layers go with these, as if a body with them asked; none: of all layers.
    pub layers: Option<CollisionLayers>,
    /// Only bodies of this kind; none: of all kinds.
    pub kind: Option<RigidBody>,
    /// Not these.
    pub without: &'f [Entity],
    /// Only those that it says yes to; none: all.
    pub accepts: Option<&'f (dyn Fn(Entity) -> bool + Sync)>,
}

impl QueryFilter<'_> {
    pub(super) fn admits(&self, body: &Body) -> bool {
        !body.is_sensor
            && self.layers.is_none_or(|layers| layers.interact(body.layers))
            && self.kind.is_none_or(|kind| kind == body.kind)
            && !self.without.contains(&body.entity)
            && self.accepts.is_none_or(|accepts| accepts(body.entity))
    }
}
