//! Shapes ready for collision: solids, and what is made of parts, solids of a compound or facets of a mesh, with a tree of
//! their boxes.
//!
//! Pairs of bodies of which one has parts are looked at part by part, each with a slot, a normal and contact points of its
//! own. The parts of one shape do not touch each other.

use std::sync::{Arc, OnceLock};

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::Hull;
use super::triangles::Triangles;
use crate::physics::BoundingBox;
use crate::physics::box_tree::BoxTree;

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
        hull: StandIn,
    },
    /// About y.
    Cylinder {
        radius: f64,
        /// Half the height.
        half: f64,
        /// The prism of the 2009 engine's contacts.
        hull: StandIn,
    },
    /// Apex up +y, the base a quarter of the height below the centre of mass.
    Cone {
        radius: f64,
        height: f64,
        /// The polygonal cone of the 2009 engine's contacts.
        hull: StandIn,
    },
    /// A convex polyhedron.
    Hull(Arc<Hull>),
    /// A compound or a mesh.
    Parts(Arc<Parts>),
}

impl Geometry {
    /// Whether its surface is curved, so that where it touches does not turn with it.
    pub fn is_round(&self) -> bool {
        match self {
            Self::Sphere { .. } | Self::Capsule { .. } | Self::Cylinder { .. } | Self::Cone { .. } => true,
            Self::HalfSpace | Self::Cuboid { .. } | Self::Hull(_) => false,
            Self::Parts(parts) => parts.solids().iter().any(|solid| solid.geometry.is_round()),
        }
    }

    /// Its parts, if it is made of some.
    pub fn parts(&self) -> Option<&Parts> {
        match self {
            Self::Parts(parts) => Some(parts),
            _ => None,
        }
    }

    /// A polyhedron, or what stands for a curved shape.
    pub fn polyhedron(&self) -> Option<&Hull> {
        match self {
            Self::Hull(hull) => Some(hull),
            Self::Capsule { hull, .. } | Self::Cylinder { hull, .. } | Self::Cone { hull, .. } => Some(hull.get()),
            Self::HalfSpace | Self::Sphere { .. } | Self::Cuboid { .. } | Self::Parts(_) => None,
        }
    }

    /// Whether it is a surface of triangles.
    pub fn is_mesh(&self) -> bool {
        self.parts().is_some_and(Parts::is_mesh)
    }

    /// The radius of a ball about the centre of mass that it holds, of a compound of one that each part holds, m; of what
    /// has no thickness infinite.
    pub fn inner_radius(&self) -> f64 {
        match self {
            Self::HalfSpace => f64::INFINITY,
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cuboid { half } => half.min(),
            Self::Cylinder { radius, half, .. } => radius.min(*half),
            Self::Cone { hull, .. } => hull.get().inner_radius,
            Self::Hull(hull) => hull.inner_radius,
            Self::Parts(parts) => parts.inner_radius,
        }
    }
}

/// The polyhedron that stands for a curved shape, made when somebody first asks: most never do.
#[derive(Clone, Debug)]
pub(crate) struct StandIn(Arc<Made>);

#[derive(Debug)]
struct Made {
    make: fn(f64, f64) -> Hull,
    sizes: [f64; 2],
    hull: OnceLock<Hull>,
}

impl StandIn {
    /// Of a function of two sizes.
    pub fn new(make: fn(f64, f64) -> Hull, sizes: [f64; 2]) -> Self {
        Self(Arc::new(Made { make, sizes, hull: OnceLock::new() }))
    }

    /// The polyhedron.
    pub fn get(&self) -> &Hull {
        let Made { make, sizes: [radius, length], hull } = &*self.0;
        hull.get_or_init(|| make(*radius, *length))
    }
}

/// The parts, in body axes.
#[derive(Debug)]
pub(crate) struct Parts {
    pub list: PartList,
    tree: BoxTree,
    /// Of a mesh that has clusters, of these and of what is in none.
    clustered: Option<BoxTree>,
    /// What holds all of them.
    bounds: BoundingBox,
    /// The least thickness of a part: radius of a ball that it holds, m; infinite for a mesh, which is a surface.
    pub inner_radius: f64,
}

/// What the parts are.
#[derive(Debug)]
pub(crate) enum PartList {
    Solids(Vec<Solid>),
    /// By facets.
    Triangles(Box<Triangles>),
}

/// A convex part of a compound.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub geometry: Geometry,
    /// Bounding radius about its own centre of mass, m.
    pub radius: f64,
    /// Of its centre of mass in the body's axes.
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

impl Parts {
    /// Of solids.
    pub fn of_solids(solids: Vec<Solid>) -> Self {
        let inner_radius = solids.iter().map(|solid| solid.geometry.inner_radius()).fold(f64::INFINITY, f64::min);
        let boxes: Vec<_> = solids.iter().map(Solid::bounds).collect();
        Self::new(PartList::Solids(solids), boxes, inner_radius)
    }

    /// Of the triangles of a mesh.
    pub fn of_triangles(triangles: Triangles) -> Self {
        let boxes = (0..triangles.facet_count()).map(|facet| triangles.facet_bounds(facet)).collect();
        let has_clusters = triangles.clustered().last().is_some_and(|&last| triangles.is_cluster(last));
        let bounds = |&part: &u32| (part, triangles.facet_bounds(part));
        let clustered = has_clusters.then(|| BoxTree::new(triangles.clustered().iter().map(bounds).collect()));
        Self { clustered, ..Self::new(PartList::Triangles(Box::new(triangles)), boxes, f64::INFINITY) }
    }

    fn new(list: PartList, boxes: Vec<BoundingBox>, inner_radius: f64) -> Self {
        let bounds = boxes.iter().fold(BoundingBox::EMPTY, |all, one| all.union(one));
        let tree = BoxTree::new((0..).zip(boxes).collect());
        Self { list, tree, clustered: None, bounds, inner_radius }
    }

    /// The tree of the parts' boxes.
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    /// Likewise, of a mesh by clusters instead of the facets in them.
    pub fn clustered(&self) -> &BoxTree {
        self.clustered.as_ref().unwrap_or(&self.tree)
    }

    /// Whether they are the triangles of a mesh.
    pub fn is_mesh(&self) -> bool {
        matches!(self.list, PartList::Triangles(_))
    }

    /// The solids of a compound; a mesh has none.
    pub fn solids(&self) -> &[Solid] {
        match &self.list {
            PartList::Solids(solids) => solids,
            PartList::Triangles(_) => &[],
        }
    }

    /// The least and the greatest coordinates by the axes of the body as columns.
    pub fn reach(&self, axes: &Matrix3<f64>) -> [Vector3<f64>; 2] {
        let BoundingBox { low, high } = placed_box(&self.bounds, axes, &Vector3::zeros());
        [low, high]
    }
}

impl Solid {
    /// Its box in the body's axes.
    pub fn bounds(&self) -> BoundingBox {
        let axes = self.rotation.to_rotation_matrix().into_inner();
        self.geometry.bounds_at(&self.position, &axes).expect("a half-space is no part")
    }
}

/// A box that holds a box of other axes, whose columns and origin are given.
pub(crate) fn placed_box(
    BoundingBox { low, high }: &BoundingBox,
    axes: &Matrix3<f64>,
    origin: &Vector3<f64>,
) -> BoundingBox {
    let middle = origin + axes * ((low + high) / 2.0);
    let half = axes.abs() * ((high - low) / 2.0);
    BoundingBox { low: middle - half, high: middle + half }
}
