//! The solve of a step that took the most iterations, as data, while somebody wants it.

use bevy::math::DMat3;
use nalgebra::{Matrix3, Vector3};

use crate::physics::solver::cone::{ConeBody, ConeContact, ConeJoint, PerPoint, PointJacobian};
use crate::physics::{ContactProblem, HardProblem, ProblemBody, ProblemContact, ProblemJoint};

/// Keeps the hardest.
#[derive(Clone, Default)]
pub(super) struct HardestSolve {
    /// Of the step, if any solve took an iteration.
    pub problem: Option<HardProblem>,
    /// v_free and the impulses to start from of the solve at hand, which puts its results in their place.
    velocities: Vec<[Vector3<f64>; 2]>,
    guess: PerPoint,
}

impl HardestSolve {
    /// A solve begins.
    pub fn begin(&mut self, velocities: &[[Vector3<f64>; 2]], guess: &PerPoint) {
        self.velocities.clear();
        self.velocities.extend_from_slice(velocities);
        self.guess.clone_from(guess);
    }

    /// The solve of these has ended; `told` is of what came of it.
    pub fn end(
        &mut self,
        bodies: &[ConeBody],
        contacts: &[ConeContact],
        joints: &[ConeJoint],
        bias: &PerPoint,
        told: HardProblem,
    ) {
        if told.iterations <= self.problem.as_ref().map_or(0, |hardest| hardest.iterations) {
            return;
        }
        let Self { velocities, guess, .. } = self;
        let problem = ContactProblem {
            bodies: bodies.iter().zip(velocities).map(|(body, velocity)| problem_body(body, velocity)).collect(),
            contacts: contacts
                .iter()
                .zip(bias.contacts.iter().zip(&guess.contacts))
                .map(|(contact, (bias, guess))| problem_contact(contact, bias, guess))
                .collect(),
            joints: joints
                .iter()
                .zip(bias.joints.iter().zip(&guess.joints))
                .map(|(joint, (bias, guess))| problem_joint(joint, bias, guess))
                .collect(),
        };
        self.problem = Some(HardProblem { problem, ..told });
    }
}

fn problem_body(body: &ConeBody, [linear, angular]: &[Vector3<f64>; 2]) -> ProblemBody {
    ProblemBody {
        inverse_mass: body.inverse_mass.into(),
        inverse_inertia: body.inverse_inertia.into(),
        velocity: (*linear).into(),
        angular_velocity: (*angular).into(),
    }
}

fn problem_contact(contact: &ConeContact, bias: &Vector3<f64>, guess: &Vector3<f64>) -> ProblemContact {
    let ConeContact { bodies, arms, normal, friction } = *contact;
    ProblemContact {
        bodies,
        arms: arms.map(Into::into),
        normal: normal.into(),
        friction,
        bias: (*bias).into(),
        guess: (*guess).into(),
    }
}

fn problem_joint(joint: &ConeJoint, bias: &Vector3<f64>, guess: &Vector3<f64>) -> ProblemJoint {
    let parts =
        |jacobian: PointJacobian| [0, 3].map(|column| DMat3::from(Matrix3::from(jacobian.fixed_columns::<3>(column))));
    ProblemJoint {
        bodies: joint.bodies,
        jacobians: joint.jacobians.map(parts),
        bounds: joint.bounds,
        bias: (*bias).into(),
        guess: (*guess).into(),
    }
}
