//! The links of a mechanism that have a part in the factor of J W Jᵀ.
//!
//! Rows whose λ is given leave nothing to solve for. Most are of limits that are open: of a figure's links two thirds. As
//! empty rows each would be coupled to all other links at its two bodies, and the factor would have several times the
//! blocks. So links of such rows alone are left out, with an order of elimination of its own for those that remain.

use std::ops::Range;

use super::mechanism::{Coupling, Couplings, Mechanism, MechanismLink, links_at};
use crate::physics::joint::JointRow;
use crate::physics::solver::linear::Elimination;

/// A link with what the choice depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct LinkPart {
    ends: [u32; 2],
    rows: u8,
    is_held: bool,
}

/// Which links hold, and their structure where these are not all.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldLinks {
    parts: Vec<LinkPart>,
    next: Vec<LinkPart>,
    moving: usize,
    are_all: bool,
    /// The link at each place.
    links: Vec<u32>,
    elimination: Elimination,
    couplings: Vec<Coupling>,
}

impl HeldLinks {
    /// Chooses those with a row whose λ is not given.
    pub fn find(&mut self, mechanism: &Mechanism, rows: &[JointRow<f64>]) {
        let part = |link: &MechanismLink| LinkPart {
            ends: link.ends(),
            rows: link.rows.len() as u8,
            is_held: rows[link.rows.clone()].iter().any(|row| row.given().is_none()),
        };
        self.next.clear();
        self.next.extend(mechanism.links.iter().map(part));
        if self.next == self.parts && self.moving == mechanism.moving {
            return;
        }
        std::mem::swap(&mut self.next, &mut self.parts);
        self.moving = mechanism.moving;
        self.plan();
    }

    fn plan(&mut self) {
        let held = (0..).zip(&self.parts).filter(|(_, part)| part.is_held);
        let links: Vec<u32> = held.clone().map(|(link, _)| link).collect();
        self.are_all = links.len() == self.parts.len();
        if self.are_all {
            return;
        }
        let ends: Vec<[u32; 2]> = held.clone().map(|(_, part)| part.ends).collect();
        let rows: Vec<u8> = held.map(|(_, part)| part.rows).collect();
        let Couplings { order, elimination, list } = Couplings::of(&links_at(self.moving, &ends), &rows);
        self.links.clear();
        self.links.extend(order.iter().map(|&index| links[index as usize]));
        (self.elimination, self.couplings) = (elimination, list);
    }

    /// Whether all links of the mechanism hold.
    pub fn are_all(&self) -> bool {
        self.are_all
    }

    /// The order of elimination of those that hold, and which of them share members.
    pub fn structure<'s>(&'s self, mechanism: &'s Mechanism) -> (&'s Elimination, &'s [Coupling]) {
        if self.are_all { (&mechanism.elimination, &mechanism.couplings) } else { (&self.elimination, &self.couplings) }
    }

    /// Those that hold, each with its place in that order and its index in the mechanism.
    pub fn links<'s>(&'s self, mechanism: &'s Mechanism) -> impl Iterator<Item = (usize, usize, &'s MechanismLink)> {
        let count = if self.are_all { mechanism.links.len() } else { self.links.len() };
        (0..count).map(|place| {
            let index = self.index(place);
            (place, index, &mechanism.links[index])
        })
    }

    /// The rows of the link at a place, among those of all links.
    pub fn rows(&self, mechanism: &Mechanism, place: u32) -> Range<usize> {
        mechanism.links[self.index(place as usize)].rows.clone()
    }

    fn index(&self, place: usize) -> usize {
        if self.are_all { place } else { self.links[place] as usize }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::physics::joint::{Bound, Frame, JointDefinition, Laws};
    use crate::physics::solver::exact::mechanism::MemberState;

    /// A chain of four bodies.
    fn chain() -> Mechanism {
        let states = [MemberState::REST; 4];
        let link = |ends: [u32; 2]| {
            let frames = [Frame::at(Vector3::zeros()); 2];
            let definition = JointDefinition { frames, translation: Laws::LOCKED, ..JointDefinition::default() };
            MechanismLink::new(&definition, ends, ends.map(|end| &states[end as usize]), 0.0)
        };
        let links: Vec<MechanismLink> = [[0, 1], [1, 2], [2, 3]].map(link).into();
        Mechanism::plan(4, false, &links).1
    }

    #[test]
    fn a_link_whose_forces_are_given_couples_nothing() {
        let mechanism = chain();
        let mut rows = vec![JointRow::EMPTY; mechanism.rows()];
        let mut held = HeldLinks::default();
        held.find(&mechanism, &rows);
        assert!(held.are_all() && held.structure(&mechanism).1.len() == 2);
        let middle = mechanism.links.iter().position(|link| link.ends() == [1, 2]).expect("three links");
        for given in [1, mechanism.links[middle].rows.len()] {
            let own = &mut rows[mechanism.links[middle].rows.clone()];
            own[..given].iter_mut().for_each(|row| row.bound = Bound::Within(0.0, 0.0));
            held.find(&mechanism, &rows);
            let is_left_out = given > 1;
            let known: Vec<_> = held.links(&mechanism).map(|(place, index, _)| (place, index)).collect();
            assert_eq!(known.iter().any(|(_, index)| *index == middle), !is_left_out);
            assert!(known.iter().enumerate().all(|(at, (place, _))| at == *place));
            assert_eq!(held.structure(&mechanism).1.len(), if is_left_out { 0 } else { 2 });
        }
        rows.iter_mut().for_each(|row| row.bound = Bound::None);
        held.find(&mechanism, &rows);
        assert!(held.are_all());
    }
}
