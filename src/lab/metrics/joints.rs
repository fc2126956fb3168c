//! How far rigid joints part.

use std::collections::HashMap;

use bevy::math::DVec3;

use crate::physics::{BodyState, RigidBody};
use crate::scene::SceneSpec;

/// A rigid joint.
struct Limb {
    bodies: [usize; 2],
    /// In the axes of the simulated bodies.
    anchors: [DVec3; 2],
    /// Smaller bounding diameter of the bodies that have a shape, m.
    diameter: f64,
}

/// Watches the joints of a run.
pub(super) struct JointMeter {
    limbs: Vec<Limb>,
    /// Largest separation over the limb's diameter.
    pub of_limb: f64,
}

impl JointMeter {
    pub fn new(scene: &SceneSpec) -> Self {
        Self { limbs: limbs(scene), of_limb: 0.0 }
    }

    pub fn observe(&mut self, states: &[BodyState]) {
        for limb in &self.limbs {
            let [one, other] = [0, 1].map(|side| {
                let BodyState { position, rotation, .. } = states[limb.bodies[side]];
                position + rotation * limb.anchors[side]
            });
            self.of_limb = self.of_limb.max(one.distance(other) / limb.diameter);
        }
    }
}

/// Bodies A and B of each joint, by their places in the scene; none where there is no such body.
pub(super) fn joined(scene: &SceneSpec) -> Vec<Option<[usize; 2]>> {
    let places: HashMap<&str, usize> =
        (0..).zip(&scene.bodies).map(|(index, body)| (body.name.as_str(), index)).collect();
    let place = |name: &str| places.get(name).copied();
    scene.joints.iter().map(|joint| Some([place(&joint.body_a)?, place(&joint.body_b)?])).collect()
}

fn limbs(scene: &SceneSpec) -> Vec<Limb> {
    let diameter = |body: usize| {
        let body = &scene.bodies[body];
        let shape = body.shape.as_ref().filter(|_| body.kind == RigidBody::Dynamic);
        shape.map_or(f64::INFINITY, |shape| 2.0 * shape.bounding_radius())
    };
    let anchor = |body: usize, anchor: DVec3| {
        scene.bodies[body].shape.as_ref().map_or(anchor, |shape| shape.axes().inverse() * anchor)
    };
    let rigid = scene.joints.iter().zip(joined(scene)).filter(|(joint, _)| joint.softness.is_none());
    rigid
        .filter_map(|(joint, bodies)| {
            let bodies = bodies?;
            let diameter = diameter(bodies[0]).min(diameter(bodies[1]));
            let anchors = [anchor(bodies[0], joint.anchor_a), anchor(bodies[1], joint.anchor_b)];
            Some(Limb { bodies, anchors, diameter })
        })
        .collect()
}
