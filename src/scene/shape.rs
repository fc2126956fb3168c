//! The shapes of a scene's bodies.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use bevy::math::{DQuat, DVec3};

use super::{HullSpec, MeshSpec, SurfaceForm, SurfaceSpec};
use crate::physics::{Collider, Compound, CompoundChild, CompoundError, ConvexHull, Shape};

/// A body's shape; full sizes, m. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSpec {
    /// The ground: all below the plane through the body's position, normal +y in body axes.
    HalfSpace,
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A box.
    Cuboid {
        /// Full extents.
        size: DVec3,
    },
    /// A cylinder with half a ball on each end, along y.
    Capsule {
        /// Radius.
        radius: f64,
        /// Length of the cylinder.
        length: f64,
    },
    /// A cylinder about y.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Height.
        height: f64,
    },
    /// A cone, apex up.
    Cone {
        /// Base radius.
        radius: f64,
        /// Height.
        height: f64,
    },
    /// The convex hull of points, wherever they lie: the body's position is its centre of mass.
    Hull(HullSpec),
    /// The convex hull of a mesh or of each of its pieces; it looks like the mesh.
    Mesh(MeshSpec),
    /// Solids that are one body, wherever they lie: the body's position is their centre of mass.
    Compound(CompoundSpec),
    /// A surface of triangles. Static and kinematic bodies only.
    Surface(SurfaceSpec),
}

/// Solids, and the compound that they are. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct CompoundSpec(Arc<Inner>);

#[derive(Debug, PartialEq)]
struct Inner {
    children: Vec<ChildSpec>,
    compound: Compound,
}

/// One of the solids, wherever they lie: the body's position is their common centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub struct ChildSpec {
    /// Its shape.
    pub shape: ShapeSpec,
    /// Of its centre of mass, m.
    pub position: DVec3,
    /// Of the shape as it is given.
    pub rotation: DQuat,
}

impl CompoundSpec {
    /// The children of a compound where its axes are those that they were given in.
    fn of_compound(compound: &Compound) -> Self {
        let children = compound.children().iter().map(|CompoundChild { collider, position, rotation }| {
            let shape = ShapeSpec::of_collider(collider);
            ChildSpec {
                position: compound.center() + compound.axes() * *position,
                rotation: compound.axes() * *rotation * shape.axes().inverse(),
                shape,
            }
        });
        Self::new(children.collect()).expect("it is a compound")
    }

    /// Of valid shapes.
    ///
    /// # Errors
    /// There is none, or one cannot be part of a body.
    pub fn new(children: Vec<ChildSpec>) -> Result<Self, CompoundError> {
        let solids: Vec<CompoundChild> = children
            .iter()
            .map(|ChildSpec { shape, position, rotation }| CompoundChild {
                collider: shape.collider(),
                position: *position,
                rotation: *rotation * shape.axes(),
            })
            .collect();
        let compound = Compound::new(&solids)?;
        Ok(Self(Arc::new(Inner { children, compound })))
    }

    /// As given.
    pub fn children(&self) -> &[ChildSpec] {
        &self.0.children
    }

    /// What they are.
    pub fn compound(&self) -> &Compound {
        &self.0.compound
    }
}

impl ShapeSpec {
    /// As a component. The shape must be valid.
    ///
    /// # Panics
    /// A hull has no volume.
    pub fn collider(&self) -> Collider {
        match self {
            Self::HalfSpace => Collider::half_space(),
            Self::Sphere { radius } => Collider::sphere(*radius),
            Self::Cuboid { size } => Collider::cuboid(size.x, size.y, size.z),
            Self::Capsule { radius, length } => Collider::capsule(*radius, *length),
            Self::Cylinder { radius, height } => Collider::cylinder(*radius, *height),
            Self::Cone { radius, height } => Collider::cone(*radius, *height),
            Self::Hull(hull) => Collider::hull(hull.hull().clone().expect("a valid scene's hulls have a volume")),
            Self::Mesh(mesh) => mesh.collider(),
            Self::Compound(compound) => Collider::of_compound(compound.compound().clone()),
            Self::Surface(surface) => Collider::mesh(surface.mesh().clone()),
        }
    }

    /// The convex hull of points, m.
    pub fn hull(points: impl Into<Box<[DVec3]>>) -> Self {
        Self::Hull(HullSpec::new(points))
    }

    /// Where the file is that it comes from, if it does.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Mesh(mesh) => mesh.path(),
            Self::Surface(surface) => match surface.form() {
                SurfaceForm::File { path, .. } | SurfaceForm::Picture { path, .. } => path.as_deref(),
                _ => None,
            },
            _ => None,
        }
    }

    /// What it is of several solids, if it is: a compound, or a mesh in pieces.
    pub fn compound(&self) -> Option<&Compound> {
        match self {
            Self::Compound(compound) => Some(compound.compound()),
            Self::Mesh(mesh) => mesh.pieces(),
            _ => None,
        }
    }

    /// What a collider is without whatever it was made from.
    pub(super) fn of_collider(collider: &Collider) -> Self {
        match collider.shape() {
            Shape::HalfSpace => Self::HalfSpace,
            Shape::Sphere { radius } => Self::Sphere { radius: *radius },
            Shape::Cuboid { size } => Self::Cuboid { size: *size },
            Shape::Capsule { radius, length } => Self::Capsule { radius: *radius, length: *length },
            Shape::Cylinder { radius, height } => Self::Cylinder { radius: *radius, height: *height },
            Shape::Cone { radius, height } => Self::Cone { radius: *radius, height: *height },
            Shape::Hull(hull) => Self::Hull(hull.clone().into()),
            Shape::Compound(compound) => Self::Compound(CompoundSpec::of_compound(compound)),
            Shape::Mesh(mesh) => Self::Surface(mesh.into()),
        }
    }

    /// The solids that it is of, if it is of several, in the axes that the shape is given in.
    pub fn children(&self) -> Option<Vec<ChildSpec>> {
        match self {
            Self::Compound(compound) => Some(compound.children().to_vec()),
            Self::Mesh(mesh) => mesh.pieces().map(|pieces| CompoundSpec::of_compound(pieces).children().to_vec()),
            _ => None,
        }
    }

    /// The hull, of a hull or mesh that is one.
    pub fn convex_hull(&self) -> Option<&ConvexHull> {
        match self {
            Self::Hull(hull) => hull.hull().as_ref().ok(),
            Self::Mesh(mesh) if mesh.pieces().is_none() => Some(mesh.hull()),
            _ => None,
        }
    }

    /// Turns principal axes into those which the shape is given in: see [`ConvexHull::axes`].
    pub fn axes(&self) -> DQuat {
        self.own_axes().unwrap_or_default()
    }

    /// Likewise; none of shapes whose axes are always principal.
    pub(super) fn own_axes(&self) -> Option<DQuat> {
        self.compound().map(Compound::axes).or_else(|| self.convex_hull().map(ConvexHull::axes))
    }

    /// m³; a half-space's and a surface's are infinite.
    pub fn volume(&self) -> f64 {
        match self {
            Self::HalfSpace | Self::Surface(_) => f64::INFINITY,
            Self::Compound(compound) => compound.children().iter().map(|child| child.shape.volume()).sum(),
            Self::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Self::Cuboid { size } => size.x * size.y * size.z,
            Self::Capsule { radius, length } => PI * radius * radius * (length + 4.0 / 3.0 * radius),
            Self::Cylinder { radius, height } => PI * radius * radius * height,
            Self::Cone { radius, height } => PI / 3.0 * radius * radius * height,
            Self::Mesh(mesh) => mesh.collider().volume(),
            Self::Hull(_) => self.convex_hull().map_or(0.0, ConvexHull::volume),
        }
    }

    /// Smallest full extent, m: the size that errors are measured by, of a compound that of its smallest child; a half-space's and a surface's are infinite.
    pub fn smallest_extent(&self) -> f64 {
        match self {
            Self::HalfSpace | Self::Surface(_) => f64::INFINITY,
            Self::Compound(compound) => {
                let extents = compound.children().iter().map(|child| child.shape.smallest_extent());
                extents.fold(f64::INFINITY, f64::min)
            }
            Self::Mesh(mesh) => mesh.hull().thickness(),
            Self::Hull(_) => self.convex_hull().map_or(0.0, ConvexHull::thickness),
            Self::Sphere { radius } | Self::Capsule { radius, .. } => 2.0 * radius,
            Self::Cuboid { size } => size.min_element(),
            Self::Cylinder { radius, height } | Self::Cone { radius, height } => height.min(2.0 * *radius),
        }
    }

    /// Radius of the smallest ball about the centre of mass that holds the shape, m; a
    /// half-space's is infinite.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::HalfSpace => f64::INFINITY,
            Self::Compound(_) | Self::Surface(_) | Self::Mesh(_) => self.collider().bounding_radius(),
            Self::Sphere { radius } => *radius,
            Self::Cuboid { size } => size.length() / 2.0,
            Self::Capsule { radius, length } => 0.5 * length + radius,
            Self::Cylinder { radius, height } => radius.hypot(0.5 * height),
            Self::Cone { radius, height } => radius.hypot(height / 4.0).max(0.75 * height),
            Self::Hull(_) => self.convex_hull().map_or(0.0, ConvexHull::bounding_radius),
        }
    }
}
