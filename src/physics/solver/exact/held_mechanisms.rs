//! Mechanisms that were held back on their way are put together again.
//!
//! On the straight ways of their bodies from pose to pose joints part, by r θ²/8 for a turn θ at a distance r. So the bodies go
//! from there to where their joints hold, the nearest by masses.

use bevy::prelude::*;

use super::bodies::{links_of, member, place_in, state_of};
use super::contact::{GroupView, JointGaps};
use super::mechanism::{Member, MemberState, number_rows};
use crate::physics::body::Bodies;
use crate::physics::collision::Mechanisms;
use crate::physics::joint::Joints;
use crate::physics::settings::SolverSettings;
use crate::physics::stats::StepStats;

/// Puts those of this step together, in the order of their lowest bodies; velocities stay.
pub(super) fn put_together(
    mechanisms: Res<Mechanisms>,
    joints: Res<Joints>,
    settings: Res<SolverSettings>,
    stats: Res<StepStats>,
    mut bodies: ResMut<Bodies>,
    mut gaps: Local<JointGaps>,
) {
    let time = stats.time + settings.step();
    for (members, own_joints) in mechanisms.held() {
        let (mut places, moving) = (members.to_vec(), members.len());
        let place = |body| place_in(&mut places, moving, body);
        let (_, mut links) = links_of(own_joints, &joints, &bodies, time, place);
        number_rows(&mut links);
        let list = || places.iter().map(|&body| &bodies.list[body as usize]);
        let members: Vec<Member> = list().map(member).collect();
        let mut states: Vec<MemberState> = list().map(state_of).collect();
        gaps.close(GroupView { members: &members, moving, links: &links }, &mut states, time);
        for (&body, state) in places[..moving].iter().zip(&states) {
            let body = &mut bodies.list[body as usize];
            (body.position, body.rotation) = (state.position, state.rotation);
        }
    }
}
