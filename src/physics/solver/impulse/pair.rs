//! The velocities, or the displacements, of both bodies of each pair of a block, and the rows between them: a row is
//! linear along n, angular parts whitened (see [`super::bodies`]), and sees n·(v_B − v_A) + j_B·ψ_B − j_A·ψ_A; some have
//! linear parts of their own for A and for B.

use nalgebra::Vector3;

use super::bodies::PairRecords;
use crate::physics::lanes::{Lanes, add_scaled, dot, vector};

/// Motions of the bodies A and B of each pair.
#[derive(Clone)]
pub(super) struct Pair<L: Lanes> {
    linear: [Vector3<L>; 2],
    angular: [Vector3<L>; 2],
    unused: [[L; 2]; 2],
    inverse_mass: [Vector3<L>; 2],
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    pub fn new(records: PairRecords<L>, inverse_mass: &[Vector3<L>; 2]) -> Self {
        Self {
            linear: records.map(|record| vector(&record)),
            angular: records.map(|record| vector(&record[3..])),
            unused: records.map(|record| [record[6], record[7]]),
            inverse_mass: *inverse_mass,
        }
    }

    #[inline(always)]
    pub fn records(&self) -> PairRecords<L> {
        [0, 1].map(|end| {
            let ([x, y, z], [u, v, w]) = (self.linear[end].data.0[0], self.angular[end].data.0[0]);
            let [one, other] = self.unused[end];
            [x, y, z, u, v, w, one, other]
        })
    }

    /// v_B − v_A.
    #[inline(always)]
    pub fn linear(&self) -> Vector3<L> {
        self.linear[1] - self.linear[0]
    }

    /// What the linear parts of a row see, of A and of B.
    #[inline(always)]
    pub fn along(&self, [of_a, of_b]: &[Vector3<L>; 2]) -> L {
        dot(of_b, &self.linear[1]) - dot(of_a, &self.linear[0])
    }

    /// The linear parts of an impulse along a row that has them for A and for B.
    #[inline(always)]
    pub fn apply_along(&mut self, [of_a, of_b]: &[Vector3<L>; 2], impulse: L) {
        self.linear[0] = add_scaled(&self.linear[0], &self.inverse_mass[0].component_mul(of_a), -impulse);
        self.linear[1] = add_scaled(&self.linear[1], &self.inverse_mass[1].component_mul(of_b), impulse);
    }

    /// What a row sees, of which the linear part is given.
    #[inline(always)]
    pub fn row(&self, linear: L, angular: &[Vector3<L>; 2]) -> L {
        linear + dot(&angular[1], &self.angular[1]) - dot(&angular[0], &self.angular[0])
    }

    /// What a row without a linear part sees.
    #[inline(always)]
    pub fn spin(&self, angular: &[Vector3<L>; 2]) -> L {
        dot(&angular[1], &self.angular[1]) - dot(&angular[0], &self.angular[0])
    }

    /// n·v of B's less that of A's for a unit impulse along n through the centres.
    #[inline(always)]
    pub fn inverse_mass_along(&self, n: &Vector3<L>) -> L {
        dot(&(self.inverse_mass[0] + self.inverse_mass[1]).component_mul(n), n)
    }

    /// The linear part of an impulse on B, and its reaction on A.
    #[inline(always)]
    pub fn apply_linear(&mut self, impulse: &Vector3<L>) {
        self.linear[0] -= self.inverse_mass[0].component_mul(impulse);
        self.linear[1] += self.inverse_mass[1].component_mul(impulse);
    }

    /// The angular part of an impulse along a row.
    #[inline(always)]
    pub fn apply_angular(&mut self, angular: &[Vector3<L>; 2], impulse: L) {
        self.angular[0] = add_scaled(&self.angular[0], &angular[0], -impulse);
        self.angular[1] = add_scaled(&self.angular[1], &angular[1], impulse);
    }
}
