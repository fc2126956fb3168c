//! Some bodies of a scene, as a scene of their own.

use std::collections::{HashMap, HashSet};

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::physics::{JointAxes, RigidBody};
use crate::scene::{BodySpec, JointSpec, SceneSpec};

/// Those bodies of the scene as it stands, with the joints among them. What joins them to something that stands still and is
/// not among them joins them to the world, at the same place.
pub fn excerpt_of_world(world: &mut World, bodies: &[Entity]) -> SceneSpec {
    let (scene, entities) = SceneSpec::with_entities(world, "excerpt");
    let chosen: HashSet<Entity> = bodies.iter().copied().collect();
    let is_chosen: Vec<bool> = entities.iter().map(|entity| chosen.contains(entity)).collect();
    excerpt(scene, &is_chosen)
}

/// Those bodies of a scene for which that is true, in the order of its list.
pub fn excerpt(scene: SceneSpec, is_chosen: &[bool]) -> SceneSpec {
    let mut part = SceneSpec::new(scene.name.clone(), scene.gravity);
    let all: HashMap<&str, (&BodySpec, bool)> =
        scene.bodies.iter().zip(is_chosen).map(|(body, is_chosen)| (body.name.as_str(), (body, *is_chosen))).collect();
    part.bodies =
        scene.bodies.iter().zip(is_chosen).filter(|(_, is_chosen)| **is_chosen).map(|(body, _)| body.clone()).collect();
    let mut pins = Vec::new();
    for joint in &scene.joints {
        let (Some(&(a, has_a)), Some(&(b, has_b))) = (all.get(joint.body_a.as_str()), all.get(joint.body_b.as_str()))
        else {
            continue;
        };
        let mut joint = joint.clone();
        match (has_a, has_b) {
            (true, true) => {}
            (true, false) if b.kind == RigidBody::Static => pins.push(hold_to_world(&mut joint, 1, b, pins.len())),
            (false, true) if a.kind == RigidBody::Static => pins.push(hold_to_world(&mut joint, 0, a, pins.len())),
            _ => continue,
        }
        part.joints.push(joint);
    }
    part.bodies.extend(pins);
    part
}

/// Has one end of a joint, on something that stands still, be on the world: the point that it is held at then.
fn hold_to_world(joint: &mut JointSpec, end: usize, still: &BodySpec, number: usize) -> BodySpec {
    let (name, anchor) = match end {
        0 => (&mut joint.body_a, &mut joint.anchor_a),
        _ => (&mut joint.body_b, &mut joint.anchor_b),
    };
    let pin = BodySpec::pin(format!("world:{number}"), still.point(*anchor));
    (*name, *anchor) = (pin.name.clone(), DVec3::ZERO);
    match (&mut joint.axes, end) {
        (JointAxes::World(_), _) => {}
        (JointAxes::Bodies(own, _), 0) | (JointAxes::Bodies(_, own), _) => *own = still.rotation * *own,
        (JointAxes::Frames(own, _), 0) | (JointAxes::Frames(_, own), _) => *own = still.rotation * *own,
    }
    pin
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ShapeSpec;

    #[test]
    fn what_stands_still_becomes_the_world_and_what_moves_is_let_go() {
        let ball = |name: &str, x: f64| BodySpec::new(name, ShapeSpec::Sphere { radius: 0.1 }, DVec3::X * x);
        let turned = DVec3::Z * std::f64::consts::FRAC_PI_2;
        let post = ball("post", 1.0).fixed().with_rotation(bevy::math::DQuat::from_scaled_axis(turned));
        let mut scene = SceneSpec::new("all", DVec3::ZERO);
        let (a, b, c) = (ball("a", 2.0), ball("b", 3.0), ball("c", 4.0));
        let axes = JointAxes::Bodies(DVec3::X, DVec3::Y);
        let on_post = JointSpec { axes, ..JointSpec::hinge(&post, &a, DVec3::X * 1.5, DVec3::Z) };
        scene.joints = vec![on_post, JointSpec::at(&a, &b, DVec3::X * 2.5), JointSpec::at(&b, &c, DVec3::X * 3.5)];
        scene.bodies = vec![post, a, b, c];
        let part = excerpt(scene, &[false, true, true, false]);
        let names: Vec<&str> = part.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "world:0"]);
        assert!(part.bodies[2].position.abs_diff_eq(DVec3::X * 1.5, 1e-12), "{}", part.bodies[2].position);
        assert_eq!(part.joints.len(), 2, "what joins b to c is gone");
        let JointAxes::Bodies(of_world, of_a) = part.joints[0].axes else { panic!("axes of bodies") };
        assert!(of_world.abs_diff_eq(DVec3::Y, 1e-12) && of_a == DVec3::Y, "{of_world}");
        assert!(part.validate().is_ok());
    }
}
