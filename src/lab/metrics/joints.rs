//! How far rigid joints part.

use std::collections::HashMap;

use bevy::math::{DQuat, DVec3};

use crate::physics::{BodyState, DistanceLaw, RigidBody};
use crate::scene::{JointKindSpec, JointSpec, SceneSpec};

/// A rigid joint.
struct Limb {
    bodies: [usize; 2],
    /// In the axes of the simulated bodies.
    anchors: [DVec3; 2],
    holds: Hold,
    /// Smaller bounding diameter of the bodies that have a shape, m.
    diameter: f64,
}

/// Where the anchors may be.
#[derive(Clone, Copy)]
enum Hold {
    /// At one place, but for those axes of A's frame, given in A's axes, that are not held.
    Axes { frame: DQuat, held: DVec3 },
    /// That far from each other.
    Distance { min: f64, max: f64 },
}

impl Hold {
    /// Of a joint between bodies in those rotations; none where it is a spring.
    fn of(joint: &JointSpec, rotations: [DQuat; 2]) -> Option<Self> {
        let held = match joint.kind {
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) => return Some(Self::Distance { min, max }),
            JointKindSpec::Distance(DistanceLaw::Spring { .. }) => return None,
            JointKindSpec::Generic { translations, .. } => translations.map(|held| f64::from(u8::from(held))).into(),
            JointKindSpec::Slider => DVec3::new(0.0, 1.0, 1.0),
            JointKindSpec::Ball | JointKindSpec::Hinge | JointKindSpec::Fixed => DVec3::ONE,
        };
        Some(Self::Axes { frame: joint.axes.frames(rotations)[0], held })
    }

    /// How far anchors are from where they may be, m, for the way from A's to B's in the world and A's rotation.
    fn gap(&self, apart: DVec3, rotation: DQuat) -> f64 {
        match *self {
            Self::Axes { held: DVec3::ONE, .. } => apart.length(),
            Self::Axes { frame, held } => (held * ((rotation * frame).inverse() * apart)).length(),
            Self::Distance { min, max } => (min - apart.length()).max(apart.length() - max).max(0.0),
        }
    }
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
            let gap = limb.holds.gap(other - one, states[limb.bodies[0]].rotation);
            self.of_limb = self.of_limb.max(gap / limb.diameter);
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
            let holds = Hold::of(joint, bodies.map(|body| scene.bodies[body].rotation))?;
            Some(Limb { bodies, anchors, holds, diameter })
        })
        .collect()
}
