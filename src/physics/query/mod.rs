//! Questions about where bodies are: what a ray or a shape on its way meets, what is nearest to a point, what a shape
//! overlaps.
//!
//! [`PhysicsQuery`] is a system parameter; any number of systems can ask at once. What it knows is where the last step left
//! the bodies: what was spawned or moved since then counts from the next step on. The first question after a step makes a
//! tree of boxes of all bodies, whatever method moved them; where nobody asks nothing is made.
//!
//! | | |
//! | --- | --- |
//! | [`asker`] | the shape that is asked with |
//! | [`ray`] | closed forms of a ray and each shape |
//! | [`cast`] | a shape on its way |
//! | [`first_touch`] | where it first touches a solid: two bounds that meet |
//! | [`solid`] | convex solids where they are |
//! | [`clear_way`] | how far it certainly touches nothing |
//! | [`meeting`] | whether two solids meet |
//! | [`box_tree`](super::box_tree) | which bodies are looked at |
//! | [`sensor`] | colliders that only report, which ask after each step |

mod answers;
mod asker;
mod cast;
mod clear_way;
mod filter;
mod first_touch;
mod index;
mod meeting;
mod physics_query;
mod ray;
mod sensor;
mod solid;

pub use answers::{CastHit, PointHit, Ray, RayHit};
pub use filter::QueryFilter;
pub use physics_query::PhysicsQuery;

use bevy::prelude::*;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<index::QueryIndex>().add_plugins(sensor::plugin);
}
