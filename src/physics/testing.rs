//! What unit tests share: seeded random numbers, vectors and bodies.

mod runge_kutta;

use bevy::prelude::{Deref, DerefMut};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector4};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::constraint::row::{BodyTerms, Twist};

pub(crate) use runge_kutta::runge_kutta;

/// The generator of the scenes, from a seed.
#[derive(Deref, DerefMut)]
pub(crate) struct Random(Pcg64Mcg);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// In 0..1.
    pub fn unit(&mut self) -> f64 {
        self.0.random()
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// Of that many.
    pub fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Each coordinate in −1..1.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-1.0, 1.0))
    }

    /// Uniform on the sphere, by rejection.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let vector = self.vector();
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    /// Uniform, by rejection.
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        loop {
            let quaternion = Quaternion::from(Vector4::from_fn(|_, _| self.within(-1.0, 1.0)));
            if (0.01..=1.0).contains(&quaternion.norm_squared()) {
                return UnitQuaternion::from_quaternion(quaternion);
            }
        }
    }

    /// What rows know of a body of 0.2 to 5 kg that is neither round nor aligned.
    pub fn body(&mut self) -> BodyTerms<f64> {
        let rotation = self.rotation().to_rotation_matrix().into_inner();
        let principal = Vector3::from_fn(|_, _| self.within(0.5, 10.0));
        BodyTerms {
            inverse_mass: Vector3::repeat(self.within(0.2, 5.0)),
            inverse_inertia: rotation * Matrix3::from_diagonal(&principal) * rotation.transpose(),
            free: Twist { linear: self.vector() * 20.0, angular: self.vector() * 20.0 },
        }
    }
}

/// What rows know of a body that nothing moves.
pub(crate) fn immovable() -> BodyTerms<f64> {
    BodyTerms { inverse_mass: Vector3::zeros(), inverse_inertia: Matrix3::zeros(), free: Twist::zero() }
}
