//! The solver's packed copy of the joints.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::definition::JointDefinition;
use super::softness::Softness;
use crate::physics::bit_set::BitSet;
use crate::physics::constraint::row::Wrench;

/// One joint as the step sees it, or one piece of it: a joint with limits, motors or friction is several, one after the
/// other, the first of which is what it holds.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub entity: Entity,
    /// Indices into [`Bodies`].
    pub a: u32,
    pub b: u32,
    pub definition: JointDefinition,
    /// Force on B in the last step, world axes, mean over its substeps, N.
    pub force: Vector3<f64>,
    /// Its torque on B about B's anchor, N·m.
    pub torque: Vector3<f64>,
    /// What each row carried, where it is not a ball joint's along a world axis, N or N·m.
    pub multipliers: [f64; 6],
    /// Whether that was found in a step in which some iterations did not end: sweeps do not start from it.
    pub is_doubtful: bool,
    /// Force and torque at the step's end, where the exact method was asked for them: they are told then, while steps start
    /// from the mean, so that no step depends on who reads what.
    pub load_at_end: Option<Wrench<f64>>,
}

/// All joints, in the order in which they were made.
#[derive(Resource, Default, Clone)]
pub(crate) struct Joints {
    pub list: Vec<Joint>,
    /// The bodies that they hold.
    pub joined: BitSet,
    /// Those that something holds which may change with time.
    pub driven: Vec<u32>,
    /// The bodies that springs hold.
    pub sprung: BitSet,
    /// How many entities they are.
    pub entities: u32,
    /// Counts every time they were packed anew, which is also when a body came, went or changed its kind.
    pub version: u64,
}

impl Joint {
    /// Stands for a body that is gone, until the joints are packed anew.
    pub const GONE: u32 = u32::MAX;

    /// A joint that has carried nothing yet.
    pub fn new(entity: Entity, [a, b]: [u32; 2], definition: JointDefinition) -> Self {
        let zero = Vector3::zeros();
        Self {
            entity,
            a,
            b,
            definition,
            force: zero,
            torque: zero,
            multipliers: [0.0; 6],
            is_doubtful: false,
            load_at_end: None,
        }
    }

    /// Force on B and torque about B's anchor, N and N·m, as they are told.
    pub fn load(&self) -> Wrench<f64> {
        self.load_at_end.unwrap_or(Wrench { linear: self.force, angular: self.torque })
    }

    /// Takes in what one of its [halves](JointDefinition::halves) carried in `h`, s: impulse on B and moment about B's
    /// anchor, and each row's. The first half comes first.
    pub fn store(&mut self, half: usize, wrench: &Wrench<f64>, impulses: &Vector3<f64>, h: f64) {
        let first = if half == 0 { 0 } else { self.definition.halves()[0] };
        self.is_doubtful = false;
        if half == 0 {
            (self.force, self.torque) = (Vector3::zeros(), Vector3::zeros());
        }
        self.force += wrench.linear / h;
        self.torque += wrench.angular / h;
        for (multiplier, impulse) in self.multipliers[first..].iter_mut().zip(impulses.iter()) {
            *multiplier = impulse / h;
        }
    }

    /// For how much of `h`, s, sweeps start from what it carried: none where that is doubtful.
    pub fn trusted_time(&self, h: f64) -> f64 {
        if self.is_doubtful { 0.0 } else { h }
    }

    /// Takes in its force on B, N, where it holds a point alone.
    pub fn set_force(&mut self, force: Vector3<f64>) {
        (self.force, self.is_doubtful) = (force, false);
    }

    /// Whether what it carried are numbers.
    pub fn is_finite(&self) -> bool {
        let Self { force, torque, multipliers, .. } = self;
        force.iter().chain(torque.iter()).chain(multipliers).all(|number| number.is_finite())
    }

    /// Takes in its force on B and torque about B's anchor, means over a step, and what each row carried, where that is
    /// known.
    pub fn set_load(&mut self, load: &Wrench<f64>, multipliers: [f64; 6]) {
        (self.force, self.torque, self.multipliers) = (load.linear, load.angular, multipliers);
        (self.is_doubtful, self.load_at_end) = (false, None);
    }

    /// Its points on A and B, from the centres of mass, body axes.
    pub fn anchors(&self) -> [Vector3<f64>; 2] {
        self.definition.frames.map(|frame| frame.anchor)
    }

    /// How its anchors give, if they do.
    pub fn softness(&self) -> Option<Softness> {
        self.definition.translation.spring
    }
}

impl Joints {
    /// The pieces of an entity, the first of which is at that index, if it is there.
    pub fn pieces(&self, entity: Entity, first: u32) -> &[Joint] {
        let from = self.list.get(first as usize..).unwrap_or_default();
        &from[..from.iter().take_while(|joint| joint.entity == entity).count()]
    }

    /// The same, to be changed.
    pub fn pieces_mut(&mut self, entity: Entity, first: u32) -> &mut [Joint] {
        let count = self.pieces(entity, first).len();
        let first = (first as usize).min(self.list.len());
        &mut self.list[first..first + count]
    }

    /// Finds out which bodies they hold, what holds them that may change with time, and how many entities they are.
    pub fn take_stock(&mut self) {
        let Self { list, joined, driven, sprung, entities, .. } = self;
        *joined = BitSet::default();
        list.iter().flat_map(|joint| [joint.a, joint.b]).for_each(|body| joined.set(body, true));
        *sprung = BitSet::default();
        let of_sprung = list.iter().filter(|joint| joint.definition.is_soft());
        of_sprung.flat_map(|joint| [joint.a, joint.b]).for_each(|body| sprung.set(body, true));
        driven.clear();
        let of_driven = list.iter().filter(|joint| joint.definition.is_driven());
        driven.extend(of_driven.flat_map(|joint| [joint.a, joint.b]));
        *entities = list.chunk_by(|one, next| one.entity == next.entity).count() as u32;
    }

    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        let of = |body: u32| new_index.get(body as usize).copied().flatten().unwrap_or(Joint::GONE);
        for joint in &mut self.list {
            (joint.a, joint.b) = (of(joint.a), of(joint.b));
        }
    }
}
