//! Where something lies, and how far it has moved at most since it lay elsewhere.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::body::Body;

/// A place and a rotation, in some axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub offset: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

impl Pose {
    /// Of a body, in the world's axes.
    pub fn of(body: &Body) -> Self {
        Self { offset: body.position, rotation: body.rotation }
    }

    /// How B lies to A, in A's axes.
    pub fn relative(a: &Body, b: &Body) -> Self {
        Self {
            offset: a.rotation.inverse_transform_vector(&(b.position - a.position)),
            rotation: a.rotation.inverse() * b.rotation,
        }
    }

    /// Likewise of a place in B's axes.
    pub fn relative_at(a: &Body, b: &Body, place: &Vector3<f64>) -> Self {
        let of_b = Self::relative(a, b);
        Self { offset: of_b.offset + of_b.rotation * place, ..of_b }
    }

    /// An upper bound of how far apart a point within `reach` of the centre lies by this pose and by another.
    pub fn moved(&self, other: &Self, reach: f64) -> f64 {
        // The chord between unit quaternions is half the angle, to third order.
        let (one, two) = (self.rotation.coords, other.rotation.coords);
        let chord = (one - two).norm_squared().min((one + two).norm_squared()).sqrt();
        (self.offset - other.offset).norm() + 2.0 * chord * reach
    }
}
