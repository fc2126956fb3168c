//! A shape placed in the world, relative to body A of a pair, and the questions that the 2009
//! engine's narrow phase asks of it: how far it reaches along an axis, which of its vertices are
//! foremost, which of its points is nearest. Boxes and balls answer in closed form; a cone or a
//! capsule is the polygonal hull that stands for it, and parts come one by one.

use nalgebra::{Matrix3, Vector3};

use crate::physics::collision::narrow::polyhedron::nearest_on_hull;
use crate::physics::collision::parts;
use crate::physics::{Geometry, Hull};

/// A body's shape, its centre relative to body A of the pair, in world axes.
pub(crate) struct Placed<'a> {
    pub geometry: &'a Geometry,
    pub center: Vector3<f64>,
    /// Columns are the body's axes.
    pub rotation: Matrix3<f64>,
    /// Bounding sphere about the centre.
    pub radius: f64,
}

impl<'a> Placed<'a> {
    /// A shape of those axes relative to `origin`.
    pub fn new(placed: &parts::Placed, geometry: &'a Geometry, origin: &Vector3<f64>) -> Self {
        Self {
            geometry,
            center: placed.position - origin,
            rotation: placed.rotation.to_rotation_matrix().into_inner(),
            radius: placed.radius,
        }
    }

    fn axis(&self, index: usize) -> Vector3<f64> {
        self.rotation.column(index).into_owned()
    }

    fn to_body(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(direction)
    }

    fn to_world(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.center + self.rotation * point
    }

    /// The outward normal of a half-space's plane, which its centre lies on.
    pub fn plane_normal(&self) -> Vector3<f64> {
        self.axis(1)
    }

    /// The interval that the shape covers along a unit axis.
    #[inline]
    pub fn project(&self, axis: &Vector3<f64>) -> [f64; 2] {
        let middle = self.center.dot(axis);
        match self.geometry {
            Geometry::HalfSpace => [f64::NEG_INFINITY, middle],
            Geometry::Parts(_) => unreachable!("parts come one by one"),
            Geometry::Sphere { radius } => [middle - radius, middle + radius],
            Geometry::Cuboid { half } => {
                let reach = self.to_body(axis).abs().dot(half);
                [middle - reach, middle + reach]
            }
            Geometry::Hull(_) | Geometry::Cylinder { .. } | Geometry::Cone { .. } | Geometry::Capsule { .. } => {
                let direction = self.to_body(axis);
                let [low, high] =
                    self.hull().vertices.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], vertex| {
                        let along = vertex.dot(&direction);
                        [low.min(along), high.max(along)]
                    });
                [middle + low, middle + high]
            }
        }
    }

    fn hull(&self) -> &Hull {
        self.geometry.polyhedron().expect("it is one, or something stands for it")
    }

    /// Whether faces come in opposite pairs at the same distance from the centre.
    pub fn is_symmetric(&self) -> bool {
        matches!(self.geometry, Geometry::Cuboid { .. })
    }

    /// The outward normals of the faces, of a symmetric shape one of each pair; or the unit directions of the edges, each
    /// once up to sign. Not of a half-space.
    pub fn axes(&self, of_edges: bool, axes: &mut Vec<Vector3<f64>>) {
        axes.clear();
        match self.geometry {
            Geometry::HalfSpace | Geometry::Sphere { .. } => {}
            Geometry::Parts(_) => unreachable!("parts come one by one"),
            Geometry::Cuboid { .. } => axes.extend((0..3).map(|axis| self.axis(axis))),
            Geometry::Hull(_) | Geometry::Cylinder { .. } | Geometry::Cone { .. } | Geometry::Capsule { .. }
                if of_edges =>
            {
                axes.extend(self.hull().edge_directions.iter().map(|direction| self.rotation * direction));
            }
            Geometry::Hull(_) | Geometry::Cylinder { .. } | Geometry::Cone { .. } | Geometry::Capsule { .. } => {
                axes.extend(self.hull().faces.iter().map(|face| self.rotation * face.normal));
            }
        }
    }

    /// The point of the shape that is nearest to `point`, which is itself if it lies inside. Of a ball, any point on
    /// the way to its centre shows the way; its centre always does.
    pub fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let local = self.to_body(&(point - self.center));
        match self.geometry {
            Geometry::HalfSpace | Geometry::Sphere { .. } => self.center,
            Geometry::Parts(_) => unreachable!("parts come one by one"),
            Geometry::Cuboid { half } => self.to_world(&local.zip_map(half, |along, half| along.clamp(-half, half))),
            Geometry::Hull(_) | Geometry::Cylinder { .. } | Geometry::Cone { .. } | Geometry::Capsule { .. } => {
                self.to_world(&nearest_on_hull(self.hull(), &local))
            }
        }
    }

    /// Whether a point lies in the shape, or no farther outside than the tolerance.
    pub fn holds(&self, point: &Vector3<f64>, tolerance: f64) -> bool {
        match self.geometry {
            Geometry::Parts(_) => unreachable!("parts come one by one"),
            Geometry::HalfSpace => (point - self.center).dot(&self.plane_normal()) <= tolerance,
            Geometry::Sphere { radius } => (point - self.center).norm() <= radius + tolerance,
            Geometry::Cuboid { .. }
            | Geometry::Hull(_)
            | Geometry::Cylinder { .. }
            | Geometry::Cone { .. }
            | Geometry::Capsule { .. } => (point - self.nearest(point)).norm() <= tolerance,
        }
    }

    /// Calls `visit` with the index and place of every vertex that lies within `tolerance` of the
    /// farthest along a unit direction. A ball's one extreme point counts as a vertex; a
    /// half-space has none.
    pub fn for_each_extreme(&self, direction: &Vector3<f64>, tolerance: f64, mut visit: impl FnMut(u32, Vector3<f64>)) {
        let least = self.project(direction)[1] - tolerance;
        let mut look_at = |index: u32, vertex: Vector3<f64>| {
            if vertex.dot(direction) >= least {
                visit(index, vertex);
            }
        };
        match self.geometry {
            Geometry::HalfSpace => {}
            Geometry::Parts(_) => unreachable!("parts come one by one"),
            Geometry::Sphere { radius } => visit(0, self.center + direction * *radius),
            Geometry::Cuboid { half } => {
                let arms: [_; 3] = std::array::from_fn(|axis| self.axis(axis) * half[axis]);
                for index in 0..8_u32 {
                    let sign = |bit: u32| if index & bit == 0 { 1.0 } else { -1.0 };
                    look_at(index, self.center + arms[0] * sign(1) + arms[1] * sign(2) + arms[2] * sign(4));
                }
            }
            Geometry::Hull(_) | Geometry::Cylinder { .. } | Geometry::Cone { .. } | Geometry::Capsule { .. } => {
                (0..).zip(&self.hull().vertices).for_each(|(index, vertex)| look_at(index, self.to_world(vertex)));
            }
        }
    }
}
