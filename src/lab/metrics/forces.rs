//! Contact and joint forces against statics.

use bevy::ecs::entity::EntityHashMap;

use crate::lab::joined::joined;
use crate::lab::simulation::Simulation;
use crate::lab::truth::Statics;
use crate::physics::{ContactForces, JointForces};

/// Watches the forces of a scene that should rest.
pub(super) struct ForceMeter {
    statics: Statics,
    /// Bodies A and B of each joint.
    joints: EntityHashMap<[usize; 2]>,
    /// Largest share of the weight carried that the forces across a level were off by.
    pub error: f64,
}

impl ForceMeter {
    pub fn new(simulation: &Simulation, statics: Statics) -> Self {
        let joints = simulation.entities().joints.iter().zip(joined(simulation.scene()));
        let joints = joints.map(|(&joint, (_, bodies))| (joint, bodies)).collect();
        Self { statics, joints, error: 0.0 }
    }

    pub fn observe(&mut self, indices: &EntityHashMap<usize>, contacts: &ContactForces, joints: &JointForces) {
        let contacts = contacts
            .0
            .iter()
            .filter_map(|contact| Some((*indices.get(&contact.a)?, *indices.get(&contact.b)?, contact.force)));
        let joints = joints.0.iter().filter_map(|joint| {
            let &[a, b] = self.joints.get(&joint.joint)?;
            Some((a, b, joint.force))
        });
        self.error = self.error.max(self.statics.error(contacts.chain(joints)));
    }
}
