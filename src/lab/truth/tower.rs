//! A tower at rest: the joints of each rod carry a quarter of what is above them.

use crate::scene::SceneSpec;

use super::answer::Truth;
use super::bodies::dynamic;
use super::stays_put;
use crate::lab::joined::joined;
use crate::lab::simulation::Sample;

/// None where its rods snap.
pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let gravity = scene.gravity.length();
    let is_rod = |body: usize| scene.bodies[body].name.starts_with("rod");
    let standing = |body: &usize| scene.bodies[*body].name.starts_with("cube") || is_rod(*body);
    let bodies: Vec<usize> = dynamic(scene).into_iter().filter(standing).collect();
    let mut weights = Vec::new();
    for (place, (joint, [a, b])) in joined(scene).enumerate() {
        if !is_rod(a) && !is_rod(b) {
            continue;
        }
        // Above the lower joint of a rod are its own gap's rods, above the upper one what is above these.
        let level = scene.bodies[b].point(joint.anchor_b).y;
        let above = bodies.iter().filter(|body| scene.bodies[**body].position.y > level);
        let weight = 0.25 * gravity * above.map(|body| scene.bodies[*body].mass).sum::<Option<f64>>()?;
        if joint.breakable.is_some_and(|breakable| breakable.force <= weight) {
            return None;
        }
        weights.push((place, weight));
    }
    let distance = move |sample: &Sample| {
        let loads = weights.iter().filter(|_| sample.step > 0);
        let error =
            |(joint, weight): &(usize, f64)| Some((sample.loads.get(*joint)?.force.length() / weight - 1.0).abs());
        loads.filter_map(error).reduce(f64::max)
    };
    let loads = Truth::largest("loads of the rods' joints", "of their own", distance).of_loads();
    Some(stays_put::truth(scene)?.and(loads))
}
