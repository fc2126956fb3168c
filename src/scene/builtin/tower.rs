//! Blocks on rods that snap: `tower`.

use bevy::math::DVec3;

use super::gravity::EARTH;
use super::palette;
use crate::physics::Breakable;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointKindSpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Bodies of a storey: four rods and a cube.
const STOREY: f64 = 5.0;

/// Height of a storey, m.
const PITCH: f64 = 1.5;

/// From the axis to a rod, in x and in z, m.
const ASIDE: f64 = 0.4;

pub(super) const TOWER: SceneInfo = SceneInfo {
    name: "tower",
    title: "Tower that snaps",
    subject: Subject::Joints,
    about: "n cubes of 100 kg, each on four rods fixed at both ends by joints that break at f newtons, and a ball of \
            300 kg that hangs beside",
    truth: "at rest the lower joint of each rod carries a quarter of all that is above it; stands or snaps as f is \
            above or below that",
    parameters: &[
        Parameter::whole("n", "cubes", 5.0, 1.0, 1000.0),
        Parameter::real("f", "force at which a joint of a rod breaks, N", 5000.0, 1.0, 1e12),
    ],
    seconds: 5.0,
    bodies: |values| 3.0 + STOREY * values[0],
    build: |values| build(values[0] as usize, values[1]),
};

fn build(n: usize, strength: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("tower", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let mut below = 0;
    for i in 0..n {
        let floor = i as f64 * PITCH * DVec3::Y;
        let cube_shape = ShapeSpec::Cuboid { size: DVec3::ONE };
        let cube = BodySpec::new(format!("cube {i}"), cube_shape, floor + DVec3::Y)
            .with_mass(100.0)
            .with_color(palette::bright(i));
        for (word, x, z) in [("a", -1.0, -1.0), ("b", 1.0, -1.0), ("c", -1.0, 1.0), ("d", 1.0, 1.0)] {
            let foot = floor + ASIDE * DVec3::new(x, 0.0, z);
            let shape = ShapeSpec::Cuboid { size: DVec3::new(0.1, 0.5, 0.1) };
            let rod = BodySpec::new(format!("rod {i}{word}"), shape, foot + 0.25 * DVec3::Y)
                .with_mass(1.0)
                .with_color(palette::STEEL);
            let fixed = |a: &BodySpec, b: &BodySpec, at: DVec3| {
                JointSpec::of_kind(JointKindSpec::Fixed, a, b, at).with_strength(Breakable::at_force(strength))
            };
            scene.joints.push(fixed(&scene.bodies[below], &rod, foot));
            scene.joints.push(fixed(&rod, &cube, foot + 0.5 * DVec3::Y));
            scene.bodies.push(rod);
        }
        below = scene.bodies.len();
        scene.bodies.push(cube);
    }
    hang_ball(&mut scene, PITCH * n as f64);
    let height = PITCH * n as f64;
    scene.view = Some(ViewSpec::framing(0.6 * height * DVec3::Y, 0.8 * height + 1.5, DVec3::new(0.6, 0.25, 1.0)));
    scene
}

/// Level with the middle of a tower of that height, ready to be swung.
fn hang_ball(scene: &mut SceneSpec, height: f64) {
    let top = DVec3::new(-1.5, height + 1.0, 0.0);
    let pivot = BodySpec::pin("pivot", top);
    let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.5 }, DVec3 { y: 0.5 * height, ..top });
    let ball = ball.with_mass(300.0).with_color(palette::SLATE);
    scene.joints.push(JointSpec::at(&pivot, &ball, top));
    scene.bodies.extend([pivot, ball]);
}
