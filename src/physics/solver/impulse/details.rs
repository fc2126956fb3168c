//! What was made of each body and constraint of a group, for whoever wants to see it.

use super::coloring::Coloring;
use super::group::{Group, Place};
use super::method;
use super::tree::TreeStep;
use crate::physics::island::Islands;
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;

/// Constraints with the place of their colour among those that are solved one after the other.
fn colored(coloring: &Coloring) -> impl Iterator<Item = (u32, u32)> {
    (0..).zip(&coloring.stages).flat_map(move |(color, &(first, last))| {
        (first..last).flat_map(move |block| coloring.lanes(block as usize).iter().map(move |item| (*item, color)))
    })
}

/// What the last step made of bodies and constraints.
#[derive(Default)]
pub(crate) struct ImpulseDetails {
    /// The contacts that were swept, by slot, each with the place of its colour among those that are solved one after the
    /// other.
    pub contacts: Vec<(u32, u32)>,
    /// The same of joints, by index; some twice, by halves.
    pub joints: Vec<(u32, u32)>,
    /// Bodies with how often their rows were solved: 0 where nothing had changed since they were.
    pub solves: Vec<(u32, u32)>,
}

impl ImpulseDetails {
    pub(super) fn add<L: Lanes>(&mut self, group: &Group<L>, islands: &Islands, settings: &SolverSettings) {
        let sweeps = settings.substeps * method::sweeps(settings);
        let contacts = colored(&group.contact_colors);
        self.contacts.extend(contacts.map(|(contact, color)| (group.contacts[contact as usize].slot, color)));
        let joints = colored(&group.joint_colors);
        self.joints.extend(joints.map(|(joint, color)| (group.joints[joint as usize].global, color)));
        let own = islands.bodies(group.index).iter().zip(&group.place);
        let swept = own.filter(|(_, place)| matches!(place, Place::Swept(_)));
        self.solves.extend(swept.map(|(body, _)| (*body, sweeps)));
        let of_trees = group.trees.iter().flat_map(TreeStep::moving);
        self.solves.extend(of_trees.map(|body| (*body, settings.substeps)));
        for island in group.islands.iter().filter(|island| island.is_solved) {
            self.solves.extend(island.members().iter().map(|body| (*body, island.solves)));
        }
    }
}
