//! The collider of a body, what shapes there are, and what they weigh. A compound, whose children are colliders, is here, too.

use std::sync::Arc;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::geometry::{Geometry, Parts, Solid, StandIn};
use super::measures::Measures;
use super::principal_axes::principal_axes;
use super::{ConvexHull, HullError, TriangleMesh, capsule, cone, cuboid, cylinder, sphere};

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
    /// A circular cylinder about y.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Height, m.
        height: f64,
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
    /// Solids that are one body.
    Compound(Compound),
    /// A surface of triangles. Static and kinematic bodies only.
    Mesh(TriangleMesh),
}

impl Shape {
    /// Whether it is what others stand on: a half-space or a surface.
    pub fn is_ground(&self) -> bool {
        matches!(self, Self::HalfSpace | Self::Mesh(_))
    }
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

    /// A cylinder of that radius and height along y, m.
    pub fn cylinder(radius: f64, height: f64) -> Self {
        Self { shape: Shape::Cylinder { radius, height } }
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

    /// Solids that are one body. The body's position is their common centre of mass and its axes are principal, wherever
    /// the children are: see [`Compound::center`] and [`Compound::axes`].
    ///
    /// # Errors
    /// There is no child, or one cannot be part of a body that moves.
    pub fn compound(children: &[CompoundChild]) -> Result<Self, CompoundError> {
        Compound::new(children).map(Self::of_compound)
    }

    /// Likewise, of what is made already.
    pub fn of_compound(compound: Compound) -> Self {
        Self { shape: Shape::Compound(compound) }
    }

    /// A surface of triangles about the body's position.
    pub fn mesh(mesh: TriangleMesh) -> Self {
        Self { shape: Shape::Mesh(mesh) }
    }

    /// What it is.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Whether every size is finite and greater than zero.
    pub fn is_valid(&self) -> bool {
        let valid = |size: f64| size.is_finite() && size > 0.0;
        match &self.shape {
            Shape::HalfSpace | Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_) => true,
            Shape::Sphere { radius } => valid(*radius),
            Shape::Cuboid { size } => size.to_array().into_iter().all(valid),
            Shape::Capsule { radius, length } => valid(*radius) && valid(*length),
            Shape::Cylinder { radius, height } | Shape::Cone { radius, height } => valid(*radius) && valid(*height),
        }
    }

    pub(super) fn measures(&self) -> Measures {
        match &self.shape {
            Shape::HalfSpace => Measures { volume: f64::INFINITY, moments: DVec3::INFINITY, radius: f64::INFINITY },
            Shape::Sphere { radius } => sphere::measures(*radius),
            Shape::Cuboid { size } => cuboid::measures(*size),
            Shape::Capsule { radius, length } => capsule::measures(*radius, *length),
            Shape::Cylinder { radius, height } => cylinder::measures(*radius, *height),
            Shape::Cone { radius, height } => cone::measures(*radius, *height),
            Shape::Hull(hull) => hull.measures(),
            Shape::Compound(compound) => compound.measures(),
            Shape::Mesh(mesh) => Measures { volume: f64::INFINITY, moments: DVec3::INFINITY, radius: mesh.radius() },
        }
    }

    /// Volume, m³; infinite for a half-space and a mesh.
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
                Geometry::Capsule { radius, half: 0.5 * length, hull: StandIn::new(capsule::hull, [radius, length]) }
            }
            &Shape::Cylinder { radius, height } => {
                Geometry::Cylinder { radius, half: 0.5 * height, hull: StandIn::new(cylinder::hull, [radius, height]) }
            }
            &Shape::Cone { radius, height } => {
                Geometry::Cone { radius, height, hull: StandIn::new(cone::hull, [radius, height]) }
            }
            Shape::Hull(hull) => Geometry::Hull(hull.hull()),
            Shape::Compound(compound) => Geometry::Parts(compound.parts()),
            Shape::Mesh(mesh) => Geometry::Parts(mesh.parts()),
        }
    }
}

/// One solid of a compound, in axes of the compound's choice.
#[derive(Clone, Debug, PartialEq)]
pub struct CompoundChild {
    /// Its shape.
    pub collider: Collider,
    /// Of its centre of mass, m.
    pub position: DVec3,
    /// Of its axes.
    pub rotation: DQuat,
}

/// Why some solids make no body.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CompoundError {
    /// There is none.
    #[error("a compound of nothing; give at least one child")]
    Empty,
    /// A half-space or a mesh.
    #[error("child {index} (counted from 0) is no solid; give balls, boxes, capsules, cylinders, cones or hulls")]
    NoSolid {
        /// Which.
        index: usize,
    },
    /// A compound.
    #[error("child {index} (counted from 0) is a compound; give its children instead")]
    Nested {
        /// Which.
        index: usize,
    },
    /// A size that is not finite and greater than zero, or a pose that is none.
    #[error("child {index} (counted from 0) has a size or a pose that is not finite; sizes are greater than 0")]
    NotFinite {
        /// Which.
        index: usize,
    },
}

/// Solids that are one body, about their common centre of mass, in principal axes. Cheap to clone.
///
/// Where children overlap, what they share weighs twice.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque, Clone, Debug, PartialEq)]
pub struct Compound(Arc<Measured>);

#[derive(Debug)]
struct Measured {
    parts: Arc<Parts>,
    /// In principal axes.
    children: Vec<CompoundChild>,
    center: DVec3,
    axes: DQuat,
    measures: Measures,
}

impl PartialEq for Measured {
    fn eq(&self, other: &Self) -> bool {
        (&self.children, self.center, self.axes) == (&other.children, other.center, other.axes)
    }
}

impl Compound {
    /// Of solids of one density.
    ///
    /// # Errors
    /// There is none, or one cannot be part of a body that moves.
    pub fn new(children: &[CompoundChild]) -> Result<Self, CompoundError> {
        for (index, CompoundChild { collider, position, rotation }) in children.iter().enumerate() {
            match collider.shape() {
                Shape::HalfSpace | Shape::Mesh(_) => return Err(CompoundError::NoSolid { index }),
                Shape::Compound(_) => return Err(CompoundError::Nested { index }),
                _ if !collider.is_valid() || !position.is_finite() || !rotation.normalize().is_finite() => {
                    return Err(CompoundError::NotFinite { index });
                }
                _ => {}
            }
        }
        if children.is_empty() {
            return Err(CompoundError::Empty);
        }
        Ok(Self(Arc::new(Measured::new(children))))
    }

    /// Centre of mass in the frame that the children were given in.
    pub fn center(&self) -> DVec3 {
        self.0.center
    }

    /// Turns principal axes into those that the children were given in. The identity where theirs are principal.
    pub fn axes(&self) -> DQuat {
        self.0.axes
    }

    /// The children, from the centre of mass, in principal axes.
    pub fn children(&self) -> &[CompoundChild] {
        &self.0.children
    }

    pub(super) fn measures(&self) -> Measures {
        self.0.measures
    }

    pub(super) fn parts(&self) -> Arc<Parts> {
        self.0.parts.clone()
    }
}

impl Measured {
    /// Each child weighs as its volume; its inertia about the common centre is its own, turned, and that of its mass at
    /// its centre (Steiner).
    fn new(children: &[CompoundChild]) -> Self {
        let volume: f64 = children.iter().map(|child| child.collider.volume()).sum();
        let share = |child: &CompoundChild| child.collider.volume() / volume;
        let center: DVec3 = children.iter().map(|child| child.position * share(child)).sum();
        let mut inertia = Matrix3::zeros();
        for child in children {
            let turn = UnitQuaternion::new_normalize(child.rotation.into()).to_rotation_matrix().into_inner();
            let own = Matrix3::from_diagonal(&Vector3::from(child.collider.measures().moments));
            let arm = Vector3::from(child.position - center);
            let at_center = Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
            inertia += (turn * own * turn.transpose() + at_center) * share(child);
        }
        let (axes, moments) = principal_axes(&inertia);
        let inverse = axes.inverse();
        let children: Vec<_> = children
            .iter()
            .map(|CompoundChild { collider, position, rotation }| CompoundChild {
                collider: collider.clone(),
                position: inverse * (*position - center),
                rotation: (inverse * rotation.normalize()).normalize(),
            })
            .collect();
        let radius = children.iter().map(|child| child.position.length() + child.collider.bounding_radius());
        let measures = Measures { volume, moments, radius: radius.fold(0.0, f64::max) };
        let solids = children.iter().map(|CompoundChild { collider, position, rotation }| Solid {
            geometry: collider.geometry(),
            radius: collider.bounding_radius(),
            position: (*position).into(),
            rotation: UnitQuaternion::new_normalize((*rotation).into()),
        });
        let parts = Arc::new(Parts::of_solids(solids.collect()));
        Self { parts, children, center, axes, measures }
    }
}
