//! A point of two bodies in the scaled unknowns: its frame, its law, its effective mass and its 3×6 blocks of Ĵ = J L.

use nalgebra::{Matrix3, Vector3};

use super::{
    BodyBlock, BodyVector, ConeContact, ConeJoint, Elimination, Law, PointJacobian, Velocity, relative_velocity,
};

/// A contact or a joint.
#[derive(Clone, Debug)]
pub(super) struct ConePoint {
    pub law: Law,
    /// ρ, kg: of a contact, the effective mass along its normal, of a joint the mean over directions; infinite where
    /// nothing moves.
    pub mass: f64,
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
    /// Ĵ, in the frame of the point.
    jacobian: PointJacobian,
}

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
            Some(PointSide { body, place: 0, given, jacobian })
        };
        let sides = [side(0), side(1)];
        let square = |side: &PointSide| match law {
            Law::Joint => side.jacobian.norm_squared() / 3.0,
            Law::Frictionless | Law::Friction(_) | Law::Within(..) => side.jacobian.row(0).norm_squared(),
        };
        let mass = 1.0 / sides.iter().flatten().map(square).sum::<f64>();
        Self { law, mass, frame, sides, block: None }
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
                scaled[side.place as usize] += side.jacobian.row(0).transpose() * impulse.x;
            } else {
                scaled[side.place as usize] += side.jacobian.tr_mul(impulse);
            }
        }
    }

    /// Ĵ z.
    pub fn relative(&self, scaled: &[BodyVector]) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for side in self.sides.iter().flatten() {
            if self.law.is_single() {
                sum.x += (side.jacobian.row(0) * scaled[side.place as usize]).x;
            } else {
                sum += side.jacobian * scaled[side.place as usize];
            }
        }
        sum
    }

    /// Ĵ_iᵀ D Ĵ_k of two of its sides.
    pub fn coupling(&self, stiffness: &Matrix3<f64>, i: usize, k: usize) -> BodyBlock {
        match (&self.sides[i], &self.sides[k]) {
            (Some(i), Some(k)) if self.law.is_single() => {
                (stiffness.m11 * i.jacobian.row(0)).tr_mul(&k.jacobian.row(0))
            }
            (Some(i), Some(k)) => i.jacobian.tr_mul(&(stiffness * k.jacobian)),
            _ => BodyBlock::zeros(),
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
