//! The linear systems (1 + ĴᵀD Ĵ) x = r, one 3×3 block D a point, on the graph of the bodies.
//!
//! With symmetric blocks the matrix is symmetric and positive definite: block LDLᵀ. Slipping points have D = Q (1 + μ n
//! tᵀ), which is not symmetric: block LU. D grows to ρ/ε, ε ≈ 10⁻⁸; iterative refinement with the defect taken
//! through the points brings back the digits that costs (without it the solution's part along the stiff rows is lost).

use nalgebra::{Matrix3, Vector3};

use super::constants::{MOST_REFINEMENTS, SOLVED};
use super::{BlockLdl, BlockLu, BodyBlock, BodyVector, ConePoint, Elimination, Inverse};
use crate::physics::Refill;

/// D and h of the points, the factor, and the two sides.
#[derive(Clone, Debug, Default)]
pub(super) struct LinearSystem {
    /// D of each point.
    pub stiffness: Vec<Matrix3<f64>>,
    /// h of each point: r = Ĵᵀh.
    pub offset: Vec<Vector3<f64>>,
    /// r, and then x, by place in the elimination.
    pub solution: Vec<BodyVector>,
    is_symmetric: bool,
    symmetric: BlockLdl<f64, Inverse>,
    general: BlockLu,
    wanted: Vec<BodyVector>,
    defect: Vec<BodyVector>,
}

impl LinearSystem {
    /// Empties it.
    pub fn clear(&mut self) {
        self.stiffness.clear();
        self.offset.clear();
    }

    /// Factors 1 + ĴᵀD Ĵ. False if it is singular to rounding.
    pub fn factor(&mut self, points: &[ConePoint], elimination: &Elimination, is_symmetric: bool) -> bool {
        self.is_symmetric = is_symmetric;
        if is_symmetric {
            self.symmetric.clear(elimination);
            (0..elimination.count()).for_each(|place| self.symmetric.diagonal_mut::<6>(place).fill_with_identity());
        } else {
            self.general.clear(elimination);
        }
        for (point, stiffness) in points.iter().zip(&self.stiffness).filter(|(_, it)| **it != Matrix3::zeros()) {
            let weighted = point.weighted(stiffness);
            for (index, side) in point.sides.iter().enumerate() {
                let (Some(side), Some(weighted)) = (side, &weighted[index]) else { continue };
                let block = if is_symmetric {
                    self.symmetric.diagonal_at(elimination, side.place as usize)
                } else {
                    self.general.diagonal_at(side.place as usize).as_mut_slice()
                };
                point.couple(block, index, weighted);
            }
            if let (Some(block), [Some(of_a), Some(of_b)]) = (point.block, &weighted) {
                if is_symmetric {
                    let mut across = BodyBlock::zeros();
                    point.couple(across.as_mut_slice(), 0, of_b);
                    self.symmetric.add(block, &across);
                } else {
                    let [ab, ba] = self.general.blocks_at(block);
                    point.couple(ab.as_mut_slice(), 0, of_b);
                    point.couple(ba.as_mut_slice(), 1, of_a);
                }
            }
        }
        if is_symmetric { self.symmetric.factor(elimination) } else { self.general.factor(elimination) }
    }

    /// The right-hand side Ĵᵀh of the present offsets.
    pub fn apply_offsets(&mut self, points: &[ConePoint], elimination: &Elimination) {
        self.solution.reset(elimination.count(), BodyVector::zeros());
        for (point, offset) in points.iter().zip(&self.offset) {
            point.apply(&mut self.solution, offset);
        }
    }

    /// Solves for the present right-hand side, refined until its defect is rounding.
    pub fn solve(&mut self, points: &[ConePoint], elimination: &Elimination) {
        let square = |vector: &[BodyVector]| vector.iter().map(BodyVector::norm_squared).sum::<f64>();
        self.wanted.clone_from(&self.solution);
        let small = SOLVED * SOLVED * square(&self.wanted);
        self.back_substitute(elimination, false);
        for _ in 0..MOST_REFINEMENTS {
            self.defect.refill(self.wanted.iter().zip(&self.solution).map(|(wanted, x)| wanted - x));
            for (point, stiffness) in points.iter().zip(&self.stiffness) {
                point.apply(&mut self.defect, &-(stiffness * point.relative(&self.solution)));
            }
            if square(&self.defect) <= small {
                break;
            }
            self.back_substitute(elimination, true);
            for (x, correction) in self.solution.iter_mut().zip(&self.defect) {
                *x += correction;
            }
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
