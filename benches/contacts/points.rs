//! Contacts and joints as the solvers written here take them: u = Ĵ z + c, z = Ĵᵀλ, Ĵ = J L, L Lᵀ = M⁻¹ by body.

use bevy::math::{DMat3, DVec3};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use plumb::physics::{ContactProblem, ProblemBody};

use crate::natural_map::Impulses;

/// What an impulse may be, in the axes of its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// In the cone of this μ about the first axis.
    Contact(f64),
    /// Any.
    Joint,
    /// Along the first axis, within these.
    Bounded(f64, f64),
}

/// A contact or a joint.
#[derive(Clone, Debug)]
pub struct Point {
    pub law: Law,
    /// Its axes in the world, as columns; of a joint, none of its own.
    frame: Matrix3<f64>,
    /// The bodies that move, with Ĵ.
    pub sides: Vec<(usize, SMatrix<f64, 3, 6>)>,
    /// c.
    pub free: Vector3<f64>,
    /// Ĵ Ĵᵀ; 1 on the diagonal of rows that there are not.
    pub mobility: Matrix3<f64>,
}

/// Contacts, then joints.
pub fn points(problem: &ContactProblem) -> Vec<Point> {
    let roots: Vec<Matrix6<f64>> = problem.bodies.iter().map(root).collect();
    let contacts = problem.contacts.iter().map(|contact| {
        let jacobians = [-1.0, 1.0].map(|sign| DMat3::IDENTITY * sign).into_iter().zip(contact.arms);
        // v + ω × r, times the sign.
        let jacobians = jacobians.map(|(linear, arm)| [linear, linear * cross(arm).transpose()]);
        let law = Law::Contact(contact.friction);
        (law, frame(contact.normal), contact.bodies, jacobians.collect::<Vec<_>>(), contact.bias)
    });
    let joints = problem.joints.iter().map(|joint| {
        let (lower, upper) = joint.bounds;
        let is_free = lower == f64::NEG_INFINITY && upper == f64::INFINITY;
        let law = if is_free { Law::Joint } else { Law::Bounded(lower, upper) };
        (law, Matrix3::identity(), joint.bodies, joint.jacobians.to_vec(), joint.bias)
    });
    let point =
        |(law, frame, bodies, jacobians, bias): (Law, Matrix3<f64>, [Option<u32>; 2], Vec<[DMat3; 2]>, DVec3)| {
            let mut free = vector(bias);
            let mut sides = Vec::new();
            for (body, [linear, angular]) in bodies.into_iter().zip(jacobians) {
                let Some(body) = body.map(|body| body as usize) else { continue };
                let own = &problem.bodies[body];
                free += vector(linear * own.velocity + angular * own.angular_velocity);
                let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
                jacobian.fixed_columns_mut::<3>(0).copy_from(&matrix(linear));
                jacobian.fixed_columns_mut::<3>(3).copy_from(&matrix(angular));
                sides.push((body, frame.tr_mul(&(jacobian * roots[body]))));
            }
            let rows = if matches!(law, Law::Joint) || matches!(law, Law::Contact(friction) if friction > 0.0) {
                3
            } else {
                1
            };
            for (_, jacobian) in &mut sides {
                (rows..3).for_each(|row| jacobian.row_mut(row).fill(0.0));
            }
            let mut mobility: Matrix3<f64> = sides.iter().map(|(_, jacobian)| jacobian * jacobian.transpose()).sum();
            let most = mobility.diagonal().max();
            for row in 0..3 {
                if mobility[(row, row)] <= 1e-14 * most {
                    mobility[(row, row)] = 1.0;
                }
            }
            Point { law, frame, sides, free: frame.tr_mul(&free), mobility }
        };
    contacts.chain(joints).map(point).collect()
}

/// λ in the axes of the points.
pub fn local(points: &[Point], impulses: &Impulses) -> Vec<Vector3<f64>> {
    let all = impulses.contacts.iter().chain(&impulses.joints);
    points.iter().zip(all).map(|(point, impulse)| point.project(&point.frame.tr_mul(&vector(*impulse)))).collect()
}

/// λ in the axes of the problem.
pub fn given(points: &[Point], impulses: &[Vector3<f64>]) -> Impulses {
    let mut all = points.iter().zip(impulses).map(|(point, impulse)| DVec3::from(point.frame * impulse));
    let is_contact = |point: &&Point| matches!(point.law, Law::Contact(_));
    let contacts = all.by_ref().take(points.iter().filter(is_contact).count()).collect();
    Impulses { contacts, joints: all.collect() }
}

impl Point {
    /// P_K.
    pub fn project(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        let friction = match self.law {
            Law::Joint => return *vector,
            Law::Bounded(lower, upper) => return Vector3::new(vector.x.max(lower).min(upper), 0.0, 0.0),
            Law::Contact(0.0) => return Vector3::new(vector.x.max(0.0), 0.0, 0.0),
            Law::Contact(friction) => friction,
        };
        let (along, across) = (vector.x, Vector3::new(0.0, vector.y, vector.z));
        let width = across.norm();
        if width <= friction * along {
            *vector
        } else if friction * width <= -along {
            Vector3::zeros()
        } else {
            let height = (along + friction * width) / (1.0 + friction * friction);
            Vector3::new(height, 0.0, 0.0) + across * (friction * height / width)
        }
    }

    /// u.
    pub fn velocity(&self, z: &[Vector6<f64>]) -> Vector3<f64> {
        self.sides.iter().fold(self.free, |sum, (body, jacobian)| sum + jacobian * z[*body])
    }

    /// z += Ĵᵀλ.
    pub fn apply(&self, z: &mut [Vector6<f64>], impulse: &Vector3<f64>) {
        self.sides.iter().for_each(|(body, jacobian)| z[*body] += jacobian.tr_mul(impulse));
    }

    /// Whether something moves along its first axis.
    pub fn is_movable(&self) -> bool {
        self.sides.iter().any(|(_, jacobian)| jacobian.norm_squared() > 0.0)
    }
}

/// L, by the eigenvectors of the inverse inertia.
fn root(body: &ProblemBody) -> Matrix6<f64> {
    let mut root = Matrix6::zeros();
    root.fixed_view_mut::<3, 3>(0, 0).set_diagonal(&vector(body.inverse_mass).map(f64::sqrt));
    let eigen = matrix(body.inverse_inertia).symmetric_eigen();
    let scales = Matrix3::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    root.fixed_view_mut::<3, 3>(3, 3).copy_from(&(eigen.eigenvectors * scales));
    root
}

/// n and two tangents.
fn frame(normal: DVec3) -> Matrix3<f64> {
    let (tangent, other) = normal.normalize().any_orthonormal_pair();
    Matrix3::from_columns(&[normal, tangent, other].map(vector))
}

/// The matrix of r × .
fn cross(arm: DVec3) -> DMat3 {
    DMat3::from_cols(arm.cross(DVec3::X), arm.cross(DVec3::Y), arm.cross(DVec3::Z))
}

fn vector(vector: DVec3) -> Vector3<f64> {
    vector.into()
}

fn matrix(matrix: DMat3) -> Matrix3<f64> {
    matrix.into()
}
