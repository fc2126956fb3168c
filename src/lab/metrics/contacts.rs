//! What the contacts of each step say: the residual of the natural map, and whether anything that
//! does not move took part.
//!
//! The residual is that of the step's last solve. Its poses are those at the end, taken back by the
//! last substep where the integrator moves bodies after the solve; arms and gaps are brought to
//! them as the solver's are. Laws that the natural map does not know are made part of u: a contact
//! found before it touches may close its gap within the substep, u_n + gap/h ≥ 0, and one that
//! bounces leaves with e times its approach at the start of the step, u_n + e u_n⁻ ≥ 0.
//!
//! The exact method's last solve is of what touches at the end of the step, where that is then: neither is needed.

use bevy::ecs::entity::EntityHashMap;
use bevy::math::{DQuat, DVec3};
use serde::Serialize;

use super::moving::Moving;
use super::natural_map::SolvedContact;
use crate::lab::simulation::Simulation;
use crate::physics::{BodyState, ContactForce, Integrator, Method, RigidBody, SolverSettings, SurfaceMaterial};

/// Largest residual of the natural map over a step's contacts, relative to the larger of g h and
/// the fastest contact of the step: 0 is a contact solve without error, 1 one that did nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactResidual {
    /// The worst of any step.
    pub worst: f64,
    /// That of the last step with a contact.
    pub last: f64,
}

/// Watches the contacts of a run.
pub(super) struct ContactMeter {
    bodies: Vec<Body>,
    /// States at the start of the step.
    before: Vec<BodyState>,
    substep: Substep,
    gravity: f64,
    residual: Option<ContactResidual>,
    /// Whether a body that does not move carried a force in the last step.
    pub touched_outside: bool,
}

/// What the contacts need of a body.
#[derive(Clone, Copy)]
struct Body {
    moves: bool,
    material: SurfaceMaterial,
    /// Per world axis; zero where it does not move.
    inverse_mass: DVec3,
    /// Principal.
    inverse_inertia: DVec3,
    /// 1 about the world axes that it may turn about.
    turns: DVec3,
}

/// The last solve of a step.
#[derive(Clone, Copy)]
struct Substep {
    /// h, s.
    length: f64,
    /// How long the solve's forces act, s.
    acts: f64,
    /// How long the poses move after it, s.
    moves: f64,
    /// Whether the solve's contacts are those of its step.
    is_present: bool,
    /// Whether they were found at its end.
    is_at_end: bool,
}

impl Substep {
    fn of(settings: &SolverSettings) -> Self {
        let length = settings.step() / f64::from(settings.substeps);
        let is_at_end = settings.method == Method::Exact;
        let (acts, moves) = match settings.sweeps.integrator {
            _ if is_at_end => (0.5 * length, 0.0),
            Integrator::VelocityVerlet => (0.5 * length, 0.0),
            Integrator::Euler => (length, length),
        };
        Self {
            length,
            acts,
            moves,
            is_present: settings.method == Method::Exact || settings.sweeps.contact_lag == 0,
            is_at_end,
        }
    }
}

impl ContactMeter {
    pub fn new(simulation: &Simulation, moving: &[Moving], settings: &SolverSettings, start: &[BodyState]) -> Self {
        let scene = simulation.scene();
        let freedom = |locked: [bool; 3]| DVec3::from_array(locked.map(|locked| f64::from(u8::from(!locked))));
        let mut bodies: Vec<Body> = scene
            .bodies
            .iter()
            .map(|body| Body {
                moves: body.kind == RigidBody::Dynamic,
                material: SurfaceMaterial { friction: body.material.friction, restitution: body.material.restitution },
                inverse_mass: DVec3::ZERO,
                inverse_inertia: DVec3::ZERO,
                turns: freedom(body.locked.rotation),
            })
            .collect();
        for body in moving {
            let free = freedom(scene.bodies[body.index].locked.translation);
            bodies[body.index].inverse_mass = free / body.mass;
            bodies[body.index].inverse_inertia = body.inertia.recip();
        }
        Self {
            bodies,
            before: start.to_vec(),
            substep: Substep::of(settings),
            gravity: scene.gravity.length(),
            residual: None,
            touched_outside: false,
        }
    }

    pub fn observe(&mut self, indices: &EntityHashMap<usize>, contacts: &[ContactForce], after: &[BodyState]) {
        self.touched_outside = false;
        let (mut largest, mut fastest) = (0.0_f64, self.gravity * self.substep.length);
        for contact in contacts {
            let (Some(&a), Some(&b)) = (indices.get(&contact.a), indices.get(&contact.b)) else { continue };
            let moves = self.bodies[a].moves && self.bodies[b].moves;
            self.touched_outside |= !moves && contact.force != DVec3::ZERO;
            let Some((solved, speed)) = self.solved(contact, [a, b], after) else { continue };
            largest = largest.max(solved.residual());
            fastest = fastest.max(speed);
        }
        if self.substep.is_present && !contacts.is_empty() && fastest > 0.0 {
            let last = largest / fastest;
            let worst = self.residual.map_or(last, |residual| residual.worst.max(last));
            self.residual = Some(ContactResidual { worst, last });
        }
        self.before.clear();
        self.before.extend_from_slice(after);
    }

    /// A contact as the last solve left it, and the larger of its speeds at both ends of the step;
    /// none where nothing can move, or it took no part.
    fn solved(&self, contact: &ContactForce, pair: [usize; 2], after: &[BodyState]) -> Option<(SolvedContact, f64)> {
        let last_force = contact.last_force?;
        let normal = contact.normal;
        let mut inverse_mass = 0.0;
        let [side_a, side_b] = pair.map(|index| {
            let (body, before, after) = (&self.bodies[index], &self.before[index], &after[index]);
            let (position, rotation) = pose_before(after, self.substep.moves);
            let (found_arm, arm) = if self.substep.is_at_end {
                let arm = contact.point - position;
                (before.rotation * (rotation.inverse() * arm), arm)
            } else {
                let found_arm = contact.point - before.position;
                (found_arm, rotation * (before.rotation.inverse() * found_arm))
            };
            let lever = rotation.inverse() * (body.turns * arm.cross(normal));
            inverse_mass += (normal * body.inverse_mass).dot(normal) + (lever * body.inverse_inertia).dot(lever);
            Side {
                // From the point where the contact was found.
                moved: position - before.position + arm - found_arm,
                approach: before.linear + before.angular.cross(found_arm),
                velocity: after.linear + after.angular.cross(arm),
            }
        });
        if inverse_mass == 0.0 {
            return None;
        }
        let SurfaceMaterial { friction, restitution } =
            self.bodies[pair[0]].material.pair(self.bodies[pair[1]].material);
        let impulse = last_force * self.substep.acts;
        let gap = normal.dot(side_b.moved - side_a.moved) - contact.depth;
        let before = side_b.approach - side_a.approach;
        let after = side_b.velocity - side_a.velocity;
        let bounce = if normal.dot(impulse) > 0.0 { restitution * (-normal.dot(before)).max(0.0) } else { 0.0 };
        let allowed = if self.substep.is_at_end { 0.0 } else { gap.max(0.0) / self.substep.length - bounce };
        let velocity = after + allowed * normal;
        let solved = SolvedContact { normal, friction, effective_mass: inverse_mass.recip(), impulse, velocity };
        Some((solved, before.length().max(after.length())))
    }

    /// None where no step had a contact that it solved at its poses.
    pub fn residual(&self) -> Option<ContactResidual> {
        self.residual
    }
}

/// One body at a contact.
struct Side {
    moved: DVec3,
    approach: DVec3,
    velocity: DVec3,
}

/// Where a body was before its last drift: the step x += h v, q ← normalize((1 + ½ h ω) q) undone.
fn pose_before(after: &BodyState, h: f64) -> (DVec3, DQuat) {
    if h == 0.0 {
        return (after.position, after.rotation);
    }
    let half_turn = -0.5 * h * after.angular;
    let back = DQuat::from_xyzw(half_turn.x, half_turn.y, half_turn.z, 1.0);
    (after.position - h * after.linear, (back * after.rotation).normalize())
}
