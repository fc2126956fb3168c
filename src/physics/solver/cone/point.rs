//! A point of two bodies in the scaled unknowns: its frame, its law, its effective mass and its 3×6 blocks of Ĵ = J L.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::constants::LEVER;
use super::{BodyVector, ConeContact, ConeJoint, Elimination, Law, PointJacobian, Velocity, relative_velocity};

/// A contact or a joint.
#[derive(Clone, Debug)]
pub(super) struct ConePoint {
    pub law: Law,
    /// ρ, kg: of a contact, the effective mass along its normal, of a joint the mean over directions; infinite where
    /// nothing moves.
    pub mass: f64,
    /// How much of its compliance a joint has, up to 1: see [`LEVER`].
    pub slack: f64,
    /// Its axes in the world, as columns: of a contact, the normal and two tangents.
    pub frame: Matrix3<f64>,
    /// A and B, where they move.
    pub sides: [Option<PointSide>; 2],
    /// Where its block of A and B is, as [`Elimination::block`] says it.
    pub block: Option<(u32, bool)>,
}

/// One body of a point.
#[derive(Clone, Debug)]
pub(super) struct PointSide {
    pub body: u32,
    /// In the order of elimination.
    pub place: u32,
    /// J, in the axes that the point was given in.
    given: PointJacobian,
    /// Ĵᵀ, in the frame of the point: its columns are long enough for registers of four.
    columns: PointColumns,
}

/// Ĵᵀ or ĴᵀD of one body.
pub(super) type PointColumns = SMatrix<f64, 6, 3>;

impl ConePoint {
    /// Of a contact.
    pub fn of_contact(contact: &ConeContact, roots: &[[Matrix3<f64>; 2]]) -> Self {
        let law = if contact.friction > 0.0 { Law::Friction(contact.friction) } else { Law::Frictionless };
        Self::new(law, frame(&contact.normal), &contact.bodies, &relative_velocity(&contact.arms), roots)
    }

    /// Of a joint.
    pub fn of_joint(joint: &ConeJoint, roots: &[[Matrix3<f64>; 2]]) -> Self {
        let law = match joint.bounds {
            (f64::NEG_INFINITY, f64::INFINITY) => Law::Joint,
            (0.0, f64::INFINITY) => Law::Frictionless,
            (lower, upper) => Law::Within(lower, upper),
        };
        Self::new(law, Matrix3::identity(), &joint.bodies, &joint.jacobians, roots)
    }

    fn new(
        law: Law,
        frame: Matrix3<f64>,
        bodies: &[Option<u32>; 2],
        jacobians: &[PointJacobian; 2],
        roots: &[[Matrix3<f64>; 2]],
    ) -> Self {
        let side = |which: usize| {
            let (body, given) = (bodies[which]?, jacobians[which]);
            let [linear, angular] = &roots[body as usize];
            let mut jacobian = frame.tr_mul(&given);
            for (column, root) in [(0, linear), (3, angular)] {
                let scaled = jacobian.fixed_columns::<3>(column) * root;
                jacobian.fixed_columns_mut::<3>(column).copy_from(&scaled);
            }
            Some(PointSide { body, place: 0, given, columns: jacobian.transpose() })
        };
        let sides = [side(0), side(1)];
        let square = |side: &PointSide| match law {
            Law::Joint => side.columns.norm_squared() / 3.0,
            Law::Frictionless | Law::Friction(_) | Law::Within(..) => side.columns.column(0).norm_squared(),
        };
        let mobility = sides.iter().flatten().map(square).sum::<f64>();
        let shifted = |side: &PointSide| side.columns.fixed_rows::<3>(0).norm_squared() / 3.0;
        let slack = match sides.iter().flatten().map(shifted).sum::<f64>() {
            shift if law == Law::Joint && shift > 0.0 => (LEVER * shift / mobility).min(1.0),
            _ => 1.0,
        };
        Self { law, mass: 1.0 / mobility, slack, frame, sides, block: None }
    }

    /// Masses along its axes, kg, none too large for a step of Gauss–Seidel: those across the normal, or of a joint, share the
    /// trace of their part of the mobility.
    pub fn masses(&self) -> Vector3<f64> {
        let mobility = |column: usize| {
            self.sides.iter().flatten().map(|side| side.columns.column(column).norm_squared()).sum::<f64>()
        };
        let over = |mobility: f64| if mobility > 0.0 { 1.0 / mobility } else { 0.0 };
        match self.law {
            Law::Joint => Vector3::from_element(self.mass / 3.0),
            Law::Frictionless | Law::Within(..) => Vector3::new(self.mass, 0.0, 0.0),
            Law::Friction(_) => {
                let across = over(mobility(1) + mobility(2));
                Vector3::new(self.mass, across, across)
            }
        }
    }

    /// Something can move along it.
    pub fn is_movable(&self) -> bool {
        self.mass.is_finite()
    }

    /// Its two bodies, if both move.
    pub fn edge(&self) -> Option<[u32; 2]> {
        match &self.sides {
            [Some(a), Some(b)] if a.body != b.body => Some([a.body, b.body]),
            _ => None,
        }
    }

    /// Finds its places in the order of elimination.
    pub fn locate(&mut self, elimination: &Elimination) {
        self.block = self.edge().map(|[a, b]| elimination.block(a, b));
        for side in self.sides.iter_mut().flatten() {
            side.place = elimination.place(side.body);
        }
    }

    /// J v, in the axes that the point was given in.
    pub fn velocity(&self, velocities: &[Velocity]) -> Vector3<f64> {
        self.sides.iter().flatten().fold(Vector3::zeros(), |sum, side| {
            let [linear, angular] = &velocities[side.body as usize];
            sum + (side.given.fixed_columns::<3>(0) * linear + side.given.fixed_columns::<3>(3) * angular)
        })
    }

    /// z += Ĵᵀλ.
    pub fn apply(&self, scaled: &mut [BodyVector], impulse: &Vector3<f64>) {
        for side in self.sides.iter().flatten() {
            if self.law.is_single() {
                scaled[side.place as usize] += side.columns.column(0) * impulse.x;
            } else {
                scaled[side.place as usize] += side.columns * impulse;
            }
        }
    }

    /// Ĵ z.
    pub fn relative(&self, scaled: &[BodyVector]) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for side in self.sides.iter().flatten() {
            if self.law.is_single() {
                sum.x += side.columns.column(0).dot(&scaled[side.place as usize]);
            } else {
                let z = &scaled[side.place as usize];
                // By a tree of sums: a dot product in order waits for each of them.
                sum += Vector3::from(side.columns.data.0.each_ref().map(|column| {
                    let [a, b, c, d, e, f]: [f64; 6] = std::array::from_fn(|row| column[row] * z[row]);
                    (a + c) + (b + d) + (e + f)
                }));
            }
        }
        sum
    }

    /// Ĵᵀ Dᵀ of each side.
    pub fn weighted(&self, stiffness: &Matrix3<f64>) -> [Option<PointColumns>; 2] {
        self.sides.each_ref().map(|side| Some(side.as_ref()?.columns * stiffness.transpose()))
    }

    /// Adds Ĵ_iᵀ D Ĵ_k to a block, columns one after the other, for the Ĵ_kᵀ Dᵀ of that side.
    #[inline]
    pub fn couple(&self, block: &mut [f64], i: usize, weighted: &PointColumns) {
        let Some(side) = &self.sides[i] else { return };
        let ([a, b, c], [of_a, of_b, of_c]) = (side.columns.data.0, weighted.data.0);
        for (column, sums) in block.as_chunks_mut::<6>().0.iter_mut().enumerate() {
            let mut now = *sums;
            for (row, sum) in now.iter_mut().enumerate() {
                *sum = a[row].mul_add(of_a[column], *sum);
            }
            if !self.law.is_single() {
                for (row, sum) in now.iter_mut().enumerate() {
                    *sum = c[row].mul_add(of_c[column], b[row].mul_add(of_b[column], *sum));
                }
            }
            *sums = now;
        }
    }
}

/// L of a positive semi-definite L Lᵀ; pivots that are zero to rounding leave a column of zeros.
pub(super) fn root(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let least = 1e-14 * matrix.diagonal().max();
    let (mut left, mut root) = (*matrix, Matrix3::zeros());
    for pivot in 0..3 {
        let square = left[(pivot, pivot)];
        if square > least {
            let column = left.column(pivot) / square.sqrt();
            left -= column * column.transpose();
            root.set_column(pivot, &column);
        }
    }
    root
}

/// The normal and two tangents, as columns.
fn frame(normal: &Vector3<f64>) -> Matrix3<f64> {
    let mut axis = Vector3::zeros();
    axis[normal.map(f64::abs).imin()] = 1.0;
    let tangent = normal.cross(&axis).normalize();
    Matrix3::from_columns(&[*normal, tangent, normal.cross(&tangent)])
}
