//! From the world's bodies and joints to a mechanism's, and back.

use nalgebra::Vector3;

use super::mechanism::{MechanismLink, Member, MemberState};
use crate::physics::body::{Bodies, Body};
use crate::physics::joint::Joints;

/// The place of a body in a list whose first `moving` are in order; one that is not there yet is added at the end.
pub(super) fn place_in(bodies: &mut Vec<u32>, moving: usize, body: u32) -> u32 {
    let known = bodies[..moving].binary_search(&body).ok();
    // Bodies that do not move are few.
    let known = known.or_else(|| bodies[moving..].iter().position(|&other| other == body).map(|at| at + moving));
    known.unwrap_or_else(|| {
        bodies.push(body);
        bodies.len() - 1
    }) as u32
}

/// The joints of those that have rows, each between members at the places that `place` tells of its bodies.
pub(super) fn links_of(
    joints: &[u32],
    all_joints: &Joints,
    bodies: &Bodies,
    time: f64,
    mut place: impl FnMut(u32) -> u32,
) -> (Vec<u32>, Vec<MechanismLink>) {
    let link = |&index: &u32| {
        let joint = &all_joints.list[index as usize];
        let ends = [joint.a, joint.b];
        let states = ends.map(|body| state_of(&bodies.list[body as usize]));
        let link = MechanismLink::new(&joint.definition, ends.map(&mut place), states.each_ref(), time);
        (!link.rows.is_empty()).then_some((index, link))
    };
    joints.iter().filter_map(link).unzip()
}

pub(super) fn state_of(body: &Body) -> MemberState {
    MemberState { position: body.position, rotation: body.rotation, linear: body.linear, angular: body.angular }
}

pub(super) fn put(state: &MemberState, body: &mut Body) {
    body.position = state.position;
    body.rotation = state.rotation;
    body.linear = state.linear;
    body.angular = state.angular;
}

/// How far a body goes, m, and by which vector it turns, the shorter way, rad, from one state to another.
pub(super) fn displacement([start, end]: [&MemberState; 2]) -> [Vector3<f64>; 2] {
    [end.position - start.position, (end.rotation * start.rotation.inverse()).scaled_axis()]
}

/// A body at the first of two states with the constant velocities that take it to the other in a time h, s.
pub(super) fn on_its_way(body: &Body, states: [&MemberState; 2], h: f64) -> Body {
    let [linear, angular] = displacement(states).map(|way| way / h);
    let MemberState { position, rotation, .. } = *states[0];
    Body { position, rotation, linear, angular, ..body.clone() }
}

pub(super) fn member(body: &Body) -> Member {
    if !body.is_dynamic() {
        return Member::FIXED;
    }
    Member {
        mass: body.mass,
        inverse_mass: body.inverse_mass,
        inertia: body.inverse_inertia_body.map(f64::recip),
        freedom: body.rotation_freedom,
        drag: body.drag,
        force: body.force,
        torque: body.torque,
    }
}

impl Member {
    /// A body that constraints do not move.
    pub const FIXED: Self = Self {
        mass: 0.0,
        inverse_mass: Vector3::new(0.0, 0.0, 0.0),
        inertia: Vector3::new(0.0, 0.0, 0.0),
        freedom: Vector3::new(1.0, 1.0, 1.0),
        drag: (0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
        torque: Vector3::new(0.0, 0.0, 0.0),
    };
}
