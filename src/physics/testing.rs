//! What unit tests share: seeded random numbers, vectors and bodies.

use nalgebra::{Matrix3, UnitQuaternion, Vector3, Vector4};

use super::constraint::row::{BodyTerms, Twist};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub u64);

impl Random {
    /// In 0..1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Each coordinate in −1..1.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-1.0, 1.0))
    }

    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let vector = self.vector();
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let [axis, other] = [self.direction(), self.direction()];
        UnitQuaternion::new_normalize(Vector4::new(axis.x, axis.y, axis.z, other.x).into())
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
