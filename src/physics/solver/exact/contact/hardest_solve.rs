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

#[cfg(test)]
mod tests {
    use bevy::math::{DQuat, DVec3};
    use bevy::prelude::*;

    use super::*;
    use crate::physics::solver::cone::ConeSolver;
    use crate::physics::{BallJoint, Collider, HardProblems, Position, RigidBody, Rotation, SolverSettings};
    use crate::physics::{headless_app, step};

    /// Cubes thrown together on the ground, with two pairs of them joined.
    fn world() -> App {
        let mut app = headless_app();
        app.insert_resource(SolverSettings::accurate()).insert_resource(HardProblems::new(5));
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(), Transform::default()));
        let cubes: Vec<Entity> = (0..8)
            .map(|index| {
                let place = DVec3::new(f64::from(index % 2), 0.9 + 1.1 * f64::from(index / 2), 0.1 * f64::from(index));
                let turn = DQuat::from_rotation_x(0.3 * f64::from(index)) * DQuat::from_rotation_z(0.2);
                let cube = Collider::cuboid(0.9, 0.8, 0.7);
                world.spawn((RigidBody::Dynamic, cube, Position(place), Rotation(turn))).id()
            })
            .collect();
        for pair in [[0, 1], [6, 7]] {
            let [a, b] = pair.map(|cube| cubes[cube]);
            let pose = |cube| (world.get::<Position>(cube).unwrap().0, world.get::<Rotation>(cube).unwrap().0);
            let [(at_a, turn_a), (at_b, turn_b)] = [pose(a), pose(b)];
            let between = 0.5 * (at_a + at_b);
            let [anchor_a, anchor_b] = [turn_a.inverse() * (between - at_a), turn_b.inverse() * (between - at_b)];
            world.spawn(BallJoint::new(a, b).with_anchors(anchor_a, anchor_b));
        }
        app
    }

    fn joint(problem: &ProblemJoint) -> ConeJoint {
        let jacobians = problem.jacobians.map(|parts| {
            let mut jacobian = PointJacobian::zeros();
            for (column, part) in [0, 3].into_iter().zip(parts) {
                jacobian.fixed_columns_mut::<3>(column).copy_from(&Matrix3::from(part));
            }
            jacobian
        });
        ConeJoint { bodies: problem.bodies, jacobians, bounds: problem.bounds }
    }

    fn contact(problem: &ProblemContact) -> ConeContact {
        let ProblemContact { bodies, arms, normal, friction, .. } = *problem;
        ConeContact { bodies, arms: arms.map(Into::into), normal: normal.into(), friction }
    }

    /// Iterations and residual of a solve from what was kept.
    fn solved_again(kept: &HardProblem) -> (u32, f64) {
        let ContactProblem { bodies, contacts, joints } = &kept.problem;
        let of = |body: &ProblemBody| ConeBody {
            inverse_mass: body.inverse_mass.into(),
            inverse_inertia: body.inverse_inertia.into(),
        };
        let mut velocities: Vec<[Vector3<f64>; 2]> =
            bodies.iter().map(|body| [body.velocity.into(), body.angular_velocity.into()]).collect();
        let bodies: Vec<_> = bodies.iter().map(of).collect();
        let vectors = |contact: fn(&ProblemContact) -> DVec3, joint: fn(&ProblemJoint) -> DVec3| PerPoint {
            contacts: contacts.iter().map(|it| contact(it).into()).collect(),
            joints: joints.iter().map(|it| joint(it).into()).collect(),
        };
        let bias = vectors(|contact| contact.bias, |joint| joint.bias);
        let mut impulses = vectors(|contact| contact.guess, |joint| joint.guess);
        let mut solver = ConeSolver::default();
        let contacts: Vec<_> = contacts.iter().map(contact).collect();
        let joints: Vec<_> = joints.iter().map(joint).collect();
        solver.set(&bodies, &contacts, &joints);
        let outcome = solver.solve(&mut velocities, &bias, &mut impulses, 0.0, kept.tolerance);
        (outcome.steps, outcome.residual)
    }

    /// To the bit, which no other problem would give.
    #[test]
    fn what_is_kept_is_solved_as_in_the_step() {
        let mut app = world();
        (0..60).for_each(|_| step(app.world_mut()));
        let kept = app.world().resource::<HardProblems>().list();
        assert_eq!(kept.len(), 5);
        assert!(kept.iter().any(|kept| !kept.problem.joints.is_empty() && kept.problem.contacts.len() > 3));
        for kept in kept {
            assert!(kept.iterations > 3, "step {}: {} iterations are none", kept.step, kept.iterations);
            assert_eq!(solved_again(kept), (kept.iterations, kept.residual), "step {}", kept.step);
        }
    }
}
