//! Joints of a group that are apart as a step begins: somebody else left them so, or a step that did not converge.
//!
//! A smooth step closes the errors of joints along with the motion, by impulses. Of those that rounding and order leave
//! nothing is seen, but impulses that close centimetres within a substep throw what they close: J turns on the way, and
//! what they gave along the rows of the start the rows of the end do not take out again. So gaps that count are closed
//! before, in the poses alone ([`JointProjection`]); what cannot be closed, as of joints that contradict each other, the
//! smooth step leaves as it is ([`is_apart`]).

use super::super::bounded_rows::BoundedRows;
use super::super::constants::PARTED;
use super::super::mechanism::{Mechanism, MemberState, place_rows};
use super::super::projection::JointProjection;
use super::super::row_mode::RowLaw;
use super::group_solver::GroupView;
use crate::physics::joint::JointRow;

/// How far a row is from where it holds, m or rad; negative of an open limit; zero of what holds no place.
pub(super) fn overlap(law: RowLaw, row: &JointRow<f64>) -> f64 {
    match law {
        _ if row.spring.is_some() => 0.0,
        RowLaw::Unbounded => row.error.abs(),
        RowLaw::Limit(side) => -row.error * side,
        RowLaw::Boxed(..) => 0.0,
    }
}

/// Whether a row is so far from where it holds that no impulse is to close it within a substep.
pub(super) fn is_apart(law: RowLaw, row: &JointRow<f64>) -> bool {
    overlap(law, row) > PARTED
}

/// Closes gaps; with its buffers.
#[derive(Clone, Default)]
pub(in super::super) struct JointGaps {
    projection: JointProjection,
    bounded: BoundedRows,
    rows: Vec<JointRow<f64>>,
}

impl JointGaps {
    /// Moves members to where their joints hold at that time, s, the nearest by masses; velocities stay.
    pub fn close(&mut self, view: GroupView, states: &mut Vec<MemberState>, time: f64) {
        let GroupView { members, moving, links } = view;
        place_rows(links, states, time, &mut self.rows);
        if !self.rows.iter().any(|row| is_apart(RowLaw::of(row), row)) {
            return;
        }
        // Whoever left joints apart may have made rows of them that contradict each other, too.
        let (_, mut mechanism) = Mechanism::plan(moving, true, links);
        mechanism.members.extend_from_slice(members);
        std::mem::swap(&mut mechanism.states, states);
        self.bounded.put_back(&mut mechanism, &mut self.projection, time);
        self.projection.assemble(&mechanism, time);
        self.projection.project_positions(&mut mechanism, time);
        std::mem::swap(&mut mechanism.states, states);
    }
}
