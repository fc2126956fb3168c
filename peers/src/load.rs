//! Loads of joints from the motion of what they carry: the same for every engine.
//!
//! No two engines tell a joint's load alike: Rapier's impulses are of rows made orthogonal to each other, Box3D's of the
//! last substep. What a joint of a tree exerts over a step is known from momenta, of all bodies beyond it:
//! f = Σ m (Δv/h − g) and, about its anchor, τ = Σ ΔL/h + r × m (Δv/h − g), with r at the middle of the step.

use bevy::math::DVec3;
use plumb::lab::BodyState;
use plumb::physics::{JointLoad, MassProperties};

use crate::joint::Joint;
use crate::scene::Scene;

/// The bodies that each joint of a tree carries.
pub struct Tree {
    beyond: Vec<Vec<usize>>,
}

impl Tree {
    /// None where joints make loops, or where bodies touch or are pushed: nothing but joints and gravity may act.
    pub fn of(scene: &Scene) -> Option<Self> {
        let moves = |body: usize| scene.bodies[body].mass.is_some();
        let count = (0..scene.bodies.len()).filter(|&body| moves(body)).count();
        let acted_on = |body: &crate::scene::Body| body.mass.is_some() && (body.collider.is_some() || body.is_pushed());
        let mut ends: Vec<usize> = scene.joints.iter().map(|joint| joint.b).collect();
        ends.sort_unstable();
        ends.dedup();
        let is_tree = ends.len() == scene.joints.len() && ends.len() == count && ends.iter().all(|&body| moves(body));
        if !is_tree || scene.bodies.iter().any(acted_on) {
            return None;
        }
        let beyond = scene.joints.iter().map(|joint| beyond(joint, &scene.joints)).collect();
        Some(Self { beyond })
    }

    /// Means over the step of `step` seconds from one state to another, one for each joint.
    pub fn loads(&self, scene: &Scene, [before, after]: [&[BodyState]; 2], step: f64) -> Vec<JointLoad> {
        let middle = |body: usize, point: DVec3| {
            let at = |states: &[BodyState]| states[body].position + states[body].rotation * point;
            0.5 * (at(before) + at(after))
        };
        let load = |(joint, beyond): (&Joint, &Vec<usize>)| {
            let anchor = middle(joint.b, joint.anchor_b);
            let mut load = JointLoad::default();
            for &body in beyond {
                let Some(MassProperties { mass, inertia }) = scene.bodies[body].mass else { continue };
                let spin = |state: &BodyState| state.rotation * (inertia * (state.rotation.inverse() * state.angular));
                let gain = (after[body].linear - before[body].linear) / step;
                let force = mass * (gain - scene.bodies[body].gravity_scale * scene.spec.gravity);
                load.force += force;
                load.torque += (spin(&after[body]) - spin(&before[body])) / step;
                load.torque += (middle(body, DVec3::ZERO) - anchor).cross(force);
            }
            JointLoad { lambda: load.force.length().hypot(load.torque.length()), ..load }
        };
        scene.joints.iter().zip(&self.beyond).map(load).collect()
    }
}

fn beyond(joint: &Joint, joints: &[Joint]) -> Vec<usize> {
    let mut found = vec![joint.b];
    let mut next = 0;
    while let Some(&body) = found.get(next) {
        found.extend(joints.iter().filter(|joint| joint.a == body).map(|joint| joint.b));
        next += 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_held_level_weighs_on_its_hinges() {
        let arm = Scene::parse("arm").unwrap();
        let still = arm.at_rest();
        let loads = Tree::of(&arm).unwrap().loads(&arm, [&still, &still], 0.01);
        let gravity = -arm.spec.gravity.y;
        // Upper arm 2 kg at 0.3 m, forearm 1 kg at 0.85 m, hinges at 0 and 0.6 m.
        assert!((loads[1].torque.z - gravity * (2.0 * 0.3 + 0.85)).abs() < 1e-9, "{loads:?}");
        assert!((loads[2].torque.z - gravity * 0.25).abs() < 1e-9, "{loads:?}");
        assert!((loads[0].force.y - gravity * 8.0).abs() < 1e-9, "{loads:?}");
    }

    #[test]
    fn what_speeds_up_takes_a_torque() {
        let arm = Scene::parse("arm").unwrap();
        let still = arm.at_rest();
        let mut turning = still.clone();
        // The forearm about its hinge, 0.25 m from its centre.
        turning[3].angular = DVec3::Z;
        turning[3].linear = 0.25 * DVec3::Y;
        let tree = Tree::of(&arm).unwrap();
        let [at_rest, driven] = [&still, &turning].map(|after| tree.loads(&arm, [&still, after], 0.5)[2].torque.z);
        let inertia = (0.25 + 0.0064) / 12.0 + 0.0625;
        assert!((driven - at_rest - inertia / 0.5).abs() < 1e-9, "{driven} {at_rest}");
    }

    #[test]
    fn loops_and_contacts_are_no_trees() {
        for scene in ["four_bar 1", "bridge 3", "ragdolls 1", "stack 2"] {
            assert!(Tree::of(&Scene::parse(scene).unwrap()).is_none(), "{scene}");
        }
        assert!(Tree::of(&Scene::parse("hinge_chain 3").unwrap()).is_some());
    }
}
