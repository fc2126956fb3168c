//! Limits among the rows of links: how far each is from its stop, and how fast it comes.

use super::super::constants::TOUCHING;
use super::super::mechanism::{MechanismLink, MemberState, place_rows};
use super::super::row_mode::RowLaw;
use crate::physics::joint::JointRow;

/// One limit at some states.
#[derive(Clone, Copy, Debug)]
pub(super) struct LimitRow {
    /// Among the rows of all links.
    pub row: usize,
    /// 1 or −1: the sign of C where it is open.
    pub side: f64,
    /// m or rad; negative: it is overshot.
    pub gap: f64,
    /// How fast that opens, m/s or rad/s.
    pub opening: f64,
    pub restitution: f64,
}

/// All limits at some states.
#[derive(Clone, Default)]
pub(super) struct LimitRows {
    pub list: Vec<LimitRow>,
    rows: Vec<JointRow<f64>>,
}

impl LimitRow {
    /// How fast it closes, m/s or rad/s, if it touches; negative if it parts.
    pub fn approach(&self) -> f64 {
        if self.gap <= TOUCHING { -self.opening } else { f64::NEG_INFINITY }
    }
}

impl LimitRows {
    /// Finds them at those states and that time, s.
    pub fn find(&mut self, links: &[MechanismLink], states: &[MemberState], time: f64) {
        let Self { list, rows } = self;
        list.clear();
        if !links.iter().any(|link| link.may_be_bounded) {
            return;
        }
        place_rows(links, states, time, rows);
        for link in links {
            for (row, rate) in link.rows.clone().zip(link.rates(rows, states)) {
                if let RowLaw::Limit(side) = RowLaw::of(&rows[row]) {
                    let JointRow { error, restitution, .. } = rows[row];
                    list.push(LimitRow { row, side, gap: error * side, opening: rate * side, restitution });
                }
            }
        }
    }
}
