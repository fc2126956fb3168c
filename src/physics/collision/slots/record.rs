//! What the impulse engine reads and writes of one pair's contact, in `f32` records.

use nalgebra::Vector3;

use crate::physics::lanes::{Record, WIDTH};

/// Most points of a manifold.
pub(crate) const POINTS: usize = 4;

/// Place, among the impulses of a contact, of the normal impulse of its impacts in the step.
pub(crate) const IMPACT: usize = POINTS + 3;

/// Records that hold the geometry of one pair's contact.
pub(crate) const GEOMETRY: usize = 4;

/// What the rows of one pair's contact are made from, in the body axes of A (normal, tangent,
/// points on A) and B (points on B): normal, tangent, μ, number of points, then each point on A and
/// on B.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactGeometry {
    pub records: [Record<f32>; GEOMETRY],
}

impl ContactGeometry {
    /// Of points given as (on A, on B).
    pub fn new(
        normal: &Vector3<f64>,
        tangent: &Vector3<f64>,
        friction: f64,
        count: usize,
        points: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>,
    ) -> Self {
        let mut numbers = [0.0_f32; GEOMETRY * WIDTH];
        let head = normal.iter().chain(tangent.iter()).copied().chain([friction, count as f64]);
        let tail = points.flat_map(|(a, b)| [a.x, a.y, a.z, b.x, b.y, b.z]);
        for (number, value) in numbers.iter_mut().zip(head.chain(tail)) {
            *number = value as f32;
        }
        let (records, _) = numbers.as_chunks::<WIDTH>();
        Self { records: std::array::from_fn(|index| Record(records[index])) }
    }

    /// Points of the patch.
    pub fn point_count(&self) -> usize {
        self.records[0].0[7] as usize
    }

    /// μ of the pair.
    pub fn friction(&self) -> f32 {
        self.records[0].0[6]
    }

    fn vector(&self, first: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from(self.records[(first + axis) / WIDTH].0[(first + axis) % WIDTH]))
    }

    /// Unit, from A to B, body axes of A.
    pub fn normal(&self) -> Vector3<f64> {
        self.vector(0)
    }

    /// Across the normal, body axes of A.
    pub fn tangent(&self) -> Vector3<f64> {
        self.vector(3)
    }

    /// A point on A and on B, each in that body's axes.
    pub fn point(&self, index: usize) -> (Vector3<f64>, Vector3<f64>) {
        (self.vector(8 + 6 * index), self.vector(11 + 6 * index))
    }
}

/// What the solver reads and writes of one pair's contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactState {
    pub geometry: ContactGeometry,
    /// Four points, two tangents, twist, N·s of a substep; at [`IMPACT`] the normal impulse of the step's impacts.
    pub impulses: Record<f32>,
}

impl ContactState {
    /// Whether the bodies pushed each other in the last step.
    pub fn pushes(&self) -> bool {
        self.impulses.0[..POINTS].iter().chain(&self.impulses.0[IMPACT..]).any(|&impulse| impulse > 0.0)
    }
}
