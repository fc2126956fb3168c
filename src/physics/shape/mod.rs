//! Shapes: their volume, inertia, bounding sphere and geometry. One file a shape.
//!
//! A collider is centred on its body's centre of mass, in principal axes. Each shape file gives
//! closed forms of its volume (m³), its principal moments per kilogram (m²), its bounding radius
//! about the centre of mass (m) and its geometry for collision. What touches what is not here: see
//! `collision`.

mod capsule;
mod cone;
mod convex_hull;
mod cuboid;
mod displacement;
mod edge_lanes;
mod hull;
mod measures;
mod merge_facets;
mod quick_hull;
mod reach;
mod sphere;
mod volume_integrals;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use bevy::math::DVec3;
use bevy::prelude::*;
use nalgebra::Vector3;

pub use convex_hull::{ConvexHull, HullError};
pub(crate) use edge_lanes::{EdgeLanes, EdgeParts};
pub(crate) use hull::Hull;
use measures::Measures;

/// The shape of a body, one per body, centred on its centre of mass. Sizes are full and in m.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Collider {
    shape: Shape,
}

/// What a [`Collider`] is.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points on and below the plane through the body's position, normal +y in body axes.
    /// Static bodies only.
    HalfSpace,
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A box.
    Cuboid {
        /// Full extents along x, y, z, m.
        size: DVec3,
    },
    /// All points within a radius of a segment along y: a cylinder with half a ball on each end.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Length of the segment, that of the cylinder, m.
        length: f64,
    },
    /// A circular cone, apex up +y; the centre of mass is a quarter of the height above the base.
    Cone {
        /// Radius of the base, m.
        radius: f64,
        /// Height, m.
        height: f64,
    },
    /// Any convex polyhedron.
    Hull(ConvexHull),
}

/// What a shape weighs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass: f64,
    /// Principal moments about the centre of mass, kg·m².
    pub inertia: DVec3,
}

impl Collider {
    /// All points on and below a plane, normal +y.
    pub fn half_space() -> Self {
        Self { shape: Shape::HalfSpace }
    }

    /// A ball of that radius, m.
    pub fn sphere(radius: f64) -> Self {
        Self { shape: Shape::Sphere { radius } }
    }

    /// A box of those full sizes, m.
    pub fn cuboid(x: f64, y: f64, z: f64) -> Self {
        Self { shape: Shape::Cuboid { size: DVec3::new(x, y, z) } }
    }

    /// A capsule of that radius about a segment of that length along y, m.
    pub fn capsule(radius: f64, length: f64) -> Self {
        Self { shape: Shape::Capsule { radius, length } }
    }

    /// A cone of that base radius and height, m, apex up +y.
    pub fn cone(radius: f64, height: f64) -> Self {
        Self { shape: Shape::Cone { radius, height } }
    }

    /// The convex hull of points, m. The body's position is its centre of mass and its axes are
    /// principal, wherever the points lie: see [`ConvexHull::center`] and [`ConvexHull::axes`].
    ///
    /// # Errors
    /// The points are not finite, too large or too small, or have no volume.
    pub fn convex_hull(points: &[DVec3]) -> Result<Self, HullError> {
        ConvexHull::new(points).map(Self::hull)
    }

    /// A convex polyhedron.
    pub fn hull(hull: ConvexHull) -> Self {
        Self { shape: Shape::Hull(hull) }
    }

    /// What it is.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Whether every size is finite and greater than zero.
    pub fn is_valid(&self) -> bool {
        let valid = |size: f64| size.is_finite() && size > 0.0;
        match &self.shape {
            Shape::HalfSpace | Shape::Hull(_) => true,
            Shape::Sphere { radius } => valid(*radius),
            Shape::Cuboid { size } => size.to_array().into_iter().all(valid),
            Shape::Capsule { radius, length } => valid(*radius) && valid(*length),
            Shape::Cone { radius, height } => valid(*radius) && valid(*height),
        }
    }

    fn measures(&self) -> Measures {
        match &self.shape {
            Shape::HalfSpace => Measures { volume: f64::INFINITY, moments: DVec3::INFINITY, radius: f64::INFINITY },
            Shape::Sphere { radius } => sphere::measures(*radius),
            Shape::Cuboid { size } => cuboid::measures(*size),
            Shape::Capsule { radius, length } => capsule::measures(*radius, *length),
            Shape::Cone { radius, height } => cone::measures(*radius, *height),
            Shape::Hull(hull) => hull.measures(),
        }
    }

    /// Volume, m³; infinite for a half-space.
    pub fn volume(&self) -> f64 {
        self.measures().volume
    }

    /// Mass and inertia at a density in kg/m³, the mass spread evenly; infinite for a half-space.
    pub fn mass_properties(&self, density: f64) -> MassProperties {
        self.mass_properties_of_mass(density * self.volume())
    }

    /// Inertia of that mass in kg, spread evenly; infinite for a half-space.
    pub fn mass_properties_of_mass(&self, mass: f64) -> MassProperties {
        MassProperties { mass, inertia: mass * self.measures().moments }
    }

    /// Radius of the smallest sphere about the centre of mass that holds the shape, m; infinite
    /// for a half-space.
    pub fn bounding_radius(&self) -> f64 {
        self.measures().radius
    }

    /// The shape ready for collision. Of a valid collider only.
    pub(crate) fn geometry(&self) -> Geometry {
        match &self.shape {
            Shape::HalfSpace => Geometry::HalfSpace,
            Shape::Sphere { radius } => Geometry::Sphere { radius: *radius },
            Shape::Cuboid { size } => Geometry::Cuboid { half: Vector3::from(size.to_array()) / 2.0 },
            &Shape::Capsule { radius, length } => {
                Geometry::Capsule { radius, half: 0.5 * length, hull: Arc::new(capsule::hull(radius, length)) }
            }
            &Shape::Cone { radius, height } => {
                Geometry::Cone { radius, height, hull: Arc::new(cone::hull(radius, height)) }
            }
            Shape::Hull(hull) => Geometry::Hull(hull.hull()),
        }
    }
}

/// A shape ready for collision, in body axes about the centre of mass. Cheap to clone.
#[derive(Clone, Debug)]
pub(crate) enum Geometry {
    /// y ≤ 0.
    HalfSpace,
    Sphere {
        radius: f64,
    },
    Cuboid {
        /// Half extents.
        half: Vector3<f64>,
    },
    /// About a segment along y.
    Capsule {
        radius: f64,
        /// Half the segment's length.
        half: f64,
        /// What stands for it in the 2009 engine's contacts.
        hull: Arc<Hull>,
    },
    /// Apex up +y, the base a quarter of the height below the centre of mass.
    Cone {
        radius: f64,
        height: f64,
        /// The polygonal cone of the 2009 engine's contacts.
        hull: Arc<Hull>,
    },
    /// A convex polyhedron.
    Hull(Arc<Hull>),
}

impl Geometry {
    /// Whether its surface is curved, so that where it touches does not turn with it.
    pub fn is_round(&self) -> bool {
        matches!(self, Self::Sphere { .. } | Self::Capsule { .. } | Self::Cone { .. })
    }
}
