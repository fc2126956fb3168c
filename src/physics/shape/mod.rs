//! Shapes: their volume, inertia, bounding sphere and geometry. One file a shape.
//!
//! A collider is centred on its body's centre of mass, in principal axes. Each shape file gives
//! closed forms of its volume (m³), its principal moments per kilogram (m²), its bounding radius
//! about the centre of mass (m) and its geometry for collision. What touches what is not here: see
//! `collision`.

mod capsule;
mod collider;
mod cone;
mod convex_hull;
mod cuboid;
mod cylinder;
mod displacement;
mod edge_lanes;
mod farthest;
mod geometry;
mod hull;
mod measures;
mod merge_facets;
mod principal_axes;
mod quick_hull;
mod reach;
mod sphere;
mod triangle_mesh;
mod triangles;
mod volume_integrals;

#[cfg(test)]
mod tests;

pub use collider::{Collider, Compound, CompoundChild, CompoundError, MassProperties, Shape};
pub use convex_hull::{ConvexHull, HullError};
pub(crate) use edge_lanes::{EdgeLanes, EdgeParts};
pub(crate) use geometry::{Geometry, PartList, Parts, Solid, placed_box};
pub(crate) use hull::{Face, Hull};
use measures::Measures;
pub use triangle_mesh::{MeshError, TriangleMesh};
pub(crate) use triangles::{SAME, Triangle, Triangles};
