//! How far impulses are from the laws of a contact problem: what all solvers are measured by, and shares nothing with any.
//!
//! v = v_free + M⁻¹Jᵀλ is summed body by body. A contact is off by its natural map r = λ/ρ − P_K(λ/ρ − û), û = u + μ|u_t| n,
//! ρ its effective mass along n (De Saxcé & Feng 1998; Acary, Brémond & Huber 2018); a joint by |u|; a row whose impulse is
//! bounded by r = λ/ρ − P(λ/ρ − u), P the nearest of the impulses that it may have. All are velocities.

use bevy::math::DVec3;
use plumb::physics::{ContactProblem, ProblemBody, ProblemContact, ProblemJoint};

/// λ of each contact and each joint, as [`ProblemContact::guess`] and [`ProblemJoint::guess`] are.
#[derive(Clone, Debug, PartialEq)]
pub struct Impulses {
    pub contacts: Vec<DVec3>,
    pub joints: Vec<DVec3>,
}

impl Impulses {
    /// Those that a problem's solve may start from.
    pub fn guess(problem: &ContactProblem) -> Self {
        Self {
            contacts: problem.contacts.iter().map(|contact| contact.guess).collect(),
            joints: problem.joints.iter().map(|joint| joint.guess).collect(),
        }
    }

    /// None.
    pub fn zero(problem: &ContactProblem) -> Self {
        let (contacts, joints) = (problem.contacts.len(), problem.joints.len());
        Self { contacts: vec![DVec3::ZERO; contacts], joints: vec![DVec3::ZERO; joints] }
    }
}

/// A velocity, or with the response of a body to it, linear and angular.
type Twist = [DVec3; 2];

/// The largest |r| of a problem's contacts and joints, m/s, over the speed of the fastest point of v_free where that is more
/// than 1 m/s. Not finite where an impulse is not.
pub fn residual(problem: &ContactProblem, impulses: &Impulses) -> f64 {
    let free: Vec<Twist> = problem.bodies.iter().map(|body| [body.velocity, body.angular_velocity]).collect();
    let mut velocities = free.clone();
    let mut push = |bodies: [Option<u32>; 2], wrenches: [Twist; 2]| {
        for (body, wrench) in bodies.into_iter().zip(wrenches) {
            if let Some(body) = body.map(|body| body as usize) {
                let [linear, angular] = response(&problem.bodies[body], wrench);
                velocities[body][0] += linear;
                velocities[body][1] += angular;
            }
        }
    };
    for (contact, &impulse) in problem.contacts.iter().zip(&impulses.contacts) {
        push(contact.bodies, contact_wrenches(contact, impulse));
    }
    for (joint, &impulse) in problem.joints.iter().zip(&impulses.joints) {
        push(joint.bodies, joint_wrenches(joint, impulse));
    }
    let (mut worst, mut fastest): (f64, f64) = (0.0, 1.0);
    let mut note = |off: f64, speed: f64| {
        // `max` would pass over what is no number.
        worst = if off.is_nan() { f64::NAN } else { worst.max(off) };
        fastest = fastest.max(speed);
    };
    for (contact, &impulse) in problem.contacts.iter().zip(&impulses.contacts) {
        let mobility = mobility(problem, contact.bodies, contact_wrenches(contact, contact.normal));
        if mobility > 0.0 {
            let velocity = contact_velocity(contact, &velocities) + contact.bias;
            let off = off_contact(contact, impulse * mobility, velocity);
            note(off, contact_velocity(contact, &free).length());
        }
    }
    for (joint, &impulse) in problem.joints.iter().zip(&impulses.joints) {
        let velocity = joint_velocity(joint, &velocities) + joint.bias;
        let off = if joint.bounds == (f64::NEG_INFINITY, f64::INFINITY) {
            let moves =
                [DVec3::X, DVec3::Y, DVec3::Z].map(|row| mobility(problem, joint.bodies, joint_wrenches(joint, row)));
            if moves.into_iter().sum::<f64>() > 0.0 { velocity.length() } else { 0.0 }
        } else {
            let mobility = mobility(problem, joint.bodies, joint_wrenches(joint, DVec3::X));
            let pushed = (impulse.x - velocity.x / mobility).max(joint.bounds.0).min(joint.bounds.1);
            if mobility > 0.0 { (impulse.x - pushed).abs() * mobility } else { 0.0 }
        };
        note(off, joint_velocity(joint, &free).length());
    }
    worst / fastest
}

/// |r| of a contact for λ/ρ and u.
fn off_contact(contact: &ProblemContact, impulse: DVec3, velocity: DVec3) -> f64 {
    let ProblemContact { normal, friction, .. } = *contact;
    if friction == 0.0 {
        // The cone is a line.
        return impulse.distance(normal * normal.dot(impulse - velocity).max(0.0));
    }
    let slip = velocity - normal * normal.dot(velocity);
    let wanted = impulse - velocity - normal * (friction * slip.length());
    let (along, across) = (normal.dot(wanted), wanted - normal * normal.dot(wanted));
    let nearest = if across.length() <= friction * along {
        wanted
    } else if friction * across.length() <= -along {
        DVec3::ZERO
    } else {
        // On the cone's mantle: along the unit vector of it that is nearest.
        let mantle = (normal + across.normalize() * friction).normalize();
        mantle * mantle.dot(wanted)
    };
    impulse.distance(nearest)
}

/// M⁻¹ w.
fn response(body: &ProblemBody, [force, torque]: Twist) -> Twist {
    [body.inverse_mass * force, body.inverse_inertia * torque]
}

/// w·M⁻¹w over both bodies.
fn mobility(problem: &ContactProblem, bodies: [Option<u32>; 2], wrenches: [Twist; 2]) -> f64 {
    let own = bodies.into_iter().zip(wrenches).filter_map(|(body, wrench)| {
        let [linear, angular] = response(&problem.bodies[body? as usize], wrench);
        Some(linear.dot(wrench[0]) + angular.dot(wrench[1]))
    });
    own.sum()
}

/// Impulse and moment on A and on B.
fn contact_wrenches(contact: &ProblemContact, impulse: DVec3) -> [Twist; 2] {
    [[-impulse, -contact.arms[0].cross(impulse)], [impulse, contact.arms[1].cross(impulse)]]
}

fn contact_velocity(contact: &ProblemContact, velocities: &[Twist]) -> DVec3 {
    let of = |side: usize| {
        contact.bodies[side].map_or(DVec3::ZERO, |body| {
            let [linear, angular] = velocities[body as usize];
            linear + angular.cross(contact.arms[side])
        })
    };
    of(1) - of(0)
}

fn joint_wrenches(joint: &ProblemJoint, impulse: DVec3) -> [Twist; 2] {
    joint.jacobians.map(|parts| parts.map(|part| part.transpose() * impulse))
}

fn joint_velocity(joint: &ProblemJoint, velocities: &[Twist]) -> DVec3 {
    let own = joint.bodies.into_iter().zip(&joint.jacobians).filter_map(|(body, [linear, angular])| {
        let [v, w] = velocities[body? as usize];
        Some(*linear * v + *angular * w)
    });
    own.sum()
}
