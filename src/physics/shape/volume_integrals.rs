//! Volume, centre of mass and inertia of a polyhedron: sums over the tetrahedra from the origin
//! to the triangles of its faces.

use nalgebra::{Matrix3, Vector3};

/// Integrals over a polyhedron of unit density.
pub(super) struct VolumeIntegrals {
    /// ∫ dV.
    pub volume: f64,
    /// ∫ x dV / volume.
    pub center: Vector3<f64>,
    /// ∫ x xᵀ dV.
    second: Matrix3<f64>,
}

impl VolumeIntegrals {
    /// Of the closed surface of faces whose loops are counter-clockwise seen from outside. Most
    /// exact where the origin is inside.
    pub fn of(vertices: &[Vector3<f64>], loops: &[Vec<u32>]) -> Self {
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for corners in loops {
            let at = |index: usize| vertices[corners[index] as usize];
            let a = at(0);
            for index in 2..corners.len() {
                let (b, c) = (at(index - 1), at(index));
                // Six times the tetrahedron's volume, from the sides of its triangle: exact for
                // needles too. Over it the mean of x is sum/4, that of x xᵀ is
                // (Σ vᵢvᵢᵀ + sum sumᵀ)/20.
                let six = a.dot(&(b - a).cross(&(c - a)));
                let sum = a + b + c;
                volume += six / 6.0;
                first += sum * (six / 24.0);
                let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
                second += (squares + sum * sum.transpose()) * (six / 120.0);
            }
        }
        Self { volume, center: first / volume, second }
    }

    /// About the origin: ∫ (x² 1 − x xᵀ) dV.
    pub fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(self.second.trace()) - self.second
    }
}
