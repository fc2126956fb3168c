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
        let mut records = [Record::<f32>::default(); GEOMETRY];
        let mut put = |index: usize, values: &Vector3<f64>| {
            for (axis, value) in values.iter().enumerate() {
                let place = index + axis;
                records[place / WIDTH].0[place % WIDTH] = *value as f32;
            }
        };
        put(0, normal);
        put(3, tangent);
        for (index, (a, b)) in points.take(POINTS).enumerate() {
            put(8 + 6 * index, &a);
            put(11 + 6 * index, &b);
        }
        records[0].0[6] = friction as f32;
        records[0].0[7] = count as f32;
        Self { records }
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
