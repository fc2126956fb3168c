//! Rods on hinges in loops, which move in one way only: `four_bar`, `bricard`. Nothing collides.

use bevy::math::DVec3;

use super::gravity::EARTH;
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const FOUR_BAR: SceneInfo = SceneInfo {
    name: "four_bar",
    title: "Four-bar linkages",
    subject: Subject::Machines,
    about: "n + 1 upright rods hinged to the ground 1 m apart, their tops joined by n level rods and started at 1 m/s, \
            no collision",
    truth: "closed form of its one angle, J (w^2 - 1)/2 = G (1 - cos angle); stays a parallelogram; energy",
    parameters: &[Parameter::whole("n", "level rods", 40.0, 1.0, 1000.0)],
    seconds: 5.0,
    bodies: |values| 2.0 * values[0] + 2.0,
    build: |values| build_four_bar(values[0] as usize),
};

pub(super) const BRICARD: SceneInfo = SceneInfo {
    name: "bricard",
    title: "Bricard's linkage",
    subject: Subject::Machines,
    about: "five rods along sides of a cube and the ground as the sixth, hinged across both sides at each corner, \
            no collision",
    truth: "reference trajectories of the rods' centres; energy",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| 6.0,
    build: |_| build_bricard(),
};

/// Of 1 kg and 1 m, along an axis of the world.
fn rod(name: String, centre: DVec3, along: DVec3) -> BodySpec {
    let size = DVec3::splat(0.1) + 0.9 * along.abs();
    BodySpec::new(name, ShapeSpec::Cuboid { size }, centre).with_mass(1.0).without_collision()
}

fn build_four_bar(n: usize) -> SceneSpec {
    const SPEED: f64 = 1.0;
    let mut scene = SceneSpec::new("four_bar", EARTH);
    let ground = BodySpec::pin("ground", DVec3::ZERO);
    let foot = |i: usize| i as f64 * DVec3::X;
    let top = |i: usize| foot(i) + DVec3::Y;
    let posts: Vec<BodySpec> = (0..=n)
        .map(|i| {
            rod(format!("post {i}"), foot(i) + 0.5 * DVec3::Y, DVec3::Y)
                .with_velocity(0.5 * SPEED * DVec3::X, -SPEED * DVec3::Z)
                .with_color(palette::bright(i))
        })
        .collect();
    let beams: Vec<BodySpec> = (0..n)
        .map(|i| {
            rod(format!("beam {i}"), top(i) + 0.5 * DVec3::X, DVec3::X)
                .with_velocity(SPEED * DVec3::X, DVec3::ZERO)
                .with_color(palette::STEEL)
        })
        .collect();
    for (i, post) in posts.iter().enumerate() {
        scene.joints.push(JointSpec::hinge(&ground, post, foot(i), DVec3::Z));
    }
    for (i, beam) in beams.iter().enumerate() {
        scene.joints.push(JointSpec::hinge(&posts[i], beam, top(i), DVec3::Z));
        scene.joints.push(JointSpec::hinge(beam, &posts[i + 1], top(i + 1), DVec3::Z));
    }
    scene.bodies.push(ground);
    scene.bodies.extend(posts.into_iter().chain(beams));
    let middle = 0.5 * n as f64;
    scene.view = Some(ViewSpec::framing(middle * DVec3::X, 0.6 * (n as f64 + 3.0), DVec3::new(0.0, 0.2, 1.0)));
    scene
}

/// Corners of the loop; its last side, from the last to the first, is the ground.
const CORNERS: [DVec3; 6] = [
    DVec3::ZERO,
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(0.0, -1.0, 1.0),
    DVec3::new(0.0, 0.0, 1.0),
];

fn build_bricard() -> SceneSpec {
    let mut scene = SceneSpec::new("bricard", EARTH);
    let side = |i: usize| CORNERS[(i + 1) % 6] - CORNERS[i % 6];
    let rods: Vec<BodySpec> = (0..5)
        .map(|i| {
            let centre = 0.5 * (CORNERS[i] + CORNERS[i + 1]);
            rod(format!("rod {i}"), centre, side(i)).with_color(palette::bright(i))
        })
        .collect();
    let ground = BodySpec::pin("ground", DVec3::ZERO);
    let around: Vec<&BodySpec> = std::iter::once(&ground).chain(&rods).chain([&ground]).collect();
    for (i, corner) in CORNERS.into_iter().enumerate() {
        let axis = side(i + 5).cross(side(i));
        scene.joints.push(JointSpec::hinge(around[i], around[i + 1], corner, axis));
    }
    scene.bodies.push(ground);
    scene.bodies.extend(rods);
    scene.view = Some(ViewSpec::framing(DVec3::new(0.5, -0.6, 0.5), 1.6, DVec3::new(0.9, 0.4, 1.0)));
    scene
}
