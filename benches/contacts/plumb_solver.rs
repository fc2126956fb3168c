//! Plumb's own solver, as a step of the exact method calls it: to one residual.

use bevy::math::DVec3;
use nalgebra::{Matrix3, Vector3};
use plumb::physics::{ContactProblem, ProblemContact, ProblemJoint};

use crate::natural_map::Impulses;
use crate::physics::cone::{ConeBody, ConeContact, ConeJoint, ConeSolver, PerPoint, PointJacobian};
use crate::watch::Watch;

/// A problem in the solver's own terms.
pub struct Given {
    bodies: Vec<ConeBody>,
    free: Vec<[Vector3<f64>; 2]>,
    contacts: Vec<ConeContact>,
    joints: Vec<ConeJoint>,
    bias: PerPoint,
}

impl Given {
    pub fn new(problem: &ContactProblem) -> Self {
        let bodies = problem.bodies.iter();
        let contact = |contact: &ProblemContact| ConeContact {
            bodies: contact.bodies,
            arms: contact.arms.map(DVec3::into),
            normal: contact.normal.into(),
            friction: contact.friction,
        };
        let jacobian = |parts: [Matrix3<f64>; 2]| {
            let mut jacobian = PointJacobian::zeros();
            jacobian.fixed_columns_mut::<3>(0).copy_from(&parts[0]);
            jacobian.fixed_columns_mut::<3>(3).copy_from(&parts[1]);
            jacobian
        };
        let joint = |joint: &ProblemJoint| ConeJoint {
            bodies: joint.bodies,
            jacobians: joint.jacobians.map(|parts| jacobian(parts.map(Into::into))),
            bounds: joint.bounds,
        };
        Self {
            bodies: bodies
                .clone()
                .map(|body| ConeBody {
                    inverse_mass: body.inverse_mass.into(),
                    inverse_inertia: body.inverse_inertia.into(),
                })
                .collect(),
            free: bodies.map(|body| [body.velocity, body.angular_velocity].map(DVec3::into)).collect(),
            contacts: problem.contacts.iter().map(contact).collect(),
            joints: problem.joints.iter().map(joint).collect(),
            bias: PerPoint {
                contacts: problem.contacts.iter().map(|contact| contact.bias.into()).collect(),
                joints: problem.joints.iter().map(|joint| joint.bias.into()).collect(),
            },
        }
    }

    /// Solves to a residual of `tolerance`, m/s, and has the watch look at what came of it.
    pub fn solve(&self, start: &Impulses, tolerance: f64, watch: &mut Watch) {
        let vectors = |list: &[DVec3]| list.iter().map(|vector| (*vector).into()).collect();
        let mut impulses = PerPoint { contacts: vectors(&start.contacts), joints: vectors(&start.joints) };
        let mut velocities = self.free.clone();
        let mut solver = ConeSolver::default();
        solver.set(&self.bodies, &self.contacts, &self.joints);
        solver.solve(&mut velocities, &self.bias, &mut impulses, tolerance, 0.0);
        let vectors = |list: &[Vector3<f64>]| list.iter().map(|vector| DVec3::from(*vector)).collect();
        watch.look(&Impulses { contacts: vectors(&impulses.contacts), joints: vectors(&impulses.joints) });
    }
}
