//! The linear systems (1 + ĴᵀD Ĵ) x = r, one 3×3 block D a point, on the graph of the bodies.
//!
//! With symmetric blocks the matrix is symmetric and positive definite: block LDLᵀ. Slipping points have D = Q (1 + μ n
//! tᵀ), which is not symmetric: block LU. D grows to ρ/ε, ε ≈ 10⁻⁸; one step of iterative refinement with the residual
//! taken through the points brings back the digits that costs (without it the solution's part along the stiff rows is
//! lost).

use nalgebra::{Matrix3, Vector3};

use super::super::linear::{BlockLdl, BlockLu, BodyVector as Part, Elimination, Inverse};
use super::point::Point;

/// Blocks, factor and right-hand side.
#[derive(Clone, Debug, Default)]
pub(super) struct LinearSystem {
    /// D of each point.
    pub stiffness: Vec<Matrix3<f64>>,
    /// h of each point: r = Ĵᵀh.
    pub push: Vec<Vector3<f64>>,
    /// r, and then x, by place in the elimination.
    pub solution: Vec<Part>,
    is_symmetric: bool,
    symmetric: BlockLdl<f64, Inverse>,
    general: BlockLu,
    wanted: Vec<Part>,
    defect: Vec<Part>,
}

impl LinearSystem {
    /// Empties it.
    pub fn clear(&mut self) {
        self.stiffness.clear();
        self.push.clear();
    }

    /// Factors 1 + ĴᵀD Ĵ. False if it is singular to rounding.
    pub fn factor(&mut self, points: &[Point], elimination: &Elimination, is_symmetric: bool) -> bool {
        self.is_symmetric = is_symmetric;
        let stiff = || points.iter().zip(&self.stiffness).filter(|(_, stiffness)| **stiffness != Matrix3::zeros());
        if is_symmetric {
            let matrix = &mut self.symmetric;
            matrix.clear(elimination);
            (0..elimination.count()).for_each(|place| matrix.diagonal_mut::<6>(place).fill_with_identity());
            for (point, stiffness) in stiff() {
                for (index, side) in point.sides.iter().enumerate() {
                    if let Some(side) = side {
                        let mut own = matrix.diagonal_mut::<6>(side.place as usize);
                        own += point.between(stiffness, index, index);
                    }
                }
                if let Some(block) = point.block {
                    matrix.add(block, &point.between(stiffness, 0, 1));
                }
            }
            matrix.factor(elimination)
        } else {
            let matrix = &mut self.general;
            matrix.clear(elimination);
            for (point, stiffness) in stiff() {
                for (index, side) in point.sides.iter().enumerate() {
                    if let Some(side) = side {
                        *matrix.diagonal_at(side.place as usize) += point.between(stiffness, index, index);
                    }
                }
                if let Some(block) = point.block {
                    matrix.add_at(block, &point.between(stiffness, 0, 1), &point.between(stiffness, 1, 0));
                }
            }
            matrix.factor(elimination)
        }
    }

    /// The right-hand side Ĵᵀh of the present pushes.
    pub fn push_all(&mut self, points: &[Point], elimination: &Elimination) {
        self.solution.clear();
        self.solution.resize(elimination.count(), Part::zeros());
        for (point, push) in points.iter().zip(&self.push) {
            point.push(&mut self.solution, push);
        }
    }

    /// Solves for the present right-hand side, with one refinement.
    pub fn solve(&mut self, points: &[Point], elimination: &Elimination) {
        self.wanted.clone_from(&self.solution);
        self.back_substitute(elimination, false);
        self.defect.clear();
        self.defect.extend(self.wanted.iter().zip(&self.solution).map(|(wanted, x)| wanted - x));
        for (point, stiffness) in points.iter().zip(&self.stiffness) {
            point.push(&mut self.defect, &-(stiffness * point.across(&self.solution)));
        }
        self.back_substitute(elimination, true);
        for (x, correction) in self.solution.iter_mut().zip(&self.defect) {
            *x += correction;
        }
    }

    fn back_substitute(&mut self, elimination: &Elimination, is_correction: bool) {
        let side = if is_correction { &mut self.defect } else { &mut self.solution };
        if self.is_symmetric {
            self.symmetric.solve(elimination, &mut side[..]);
        } else {
            self.general.solve(elimination, side);
        }
    }
}
