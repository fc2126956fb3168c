//! Figures that fall down stairs: `ragdolls`.

use std::f64::consts::FRAC_PI_2;

use bevy::math::{DQuat, DVec3};

use super::figure::{Clothes, Figure, RAGDOLL_PARTS, Side, soles_to_pelvis};
use super::gravity::EARTH;
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

const STEPS: usize = 8;

/// Depth and height of a step, m.
const TREAD: f64 = 0.35;
const RISE: f64 = 0.2;

/// Between figures, m.
const ASIDE: f64 = 1.4;

/// From which they are dropped, m.
const DROP: f64 = 1.0;

pub(super) const RAGDOLLS: SceneInfo = SceneInfo {
    name: "ragdolls",
    title: "Ragdolls on stairs",
    subject: Subject::Joints,
    about: "n figures of 70 kg, 1.7 m and 11 bodies with hinged elbows and knees and limits at all joints, dropped from \
            1 m on stairs",
    truth: "limits and joints hold",
    parameters: &[Parameter::whole("n", "figures", 1.0, 1.0, 1000.0)],
    seconds: 10.0,
    bodies: |values| RAGDOLL_PARTS as f64 * values[0] + STEPS as f64 + 1.0,
    build: |values| build(values[0] as usize),
};

fn build(n: usize) -> SceneSpec {
    let mut scene = SceneSpec::new("ragdolls", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let width = ASIDE * n as f64 + 1.0;
    for i in 0..STEPS {
        let height = RISE * (STEPS - i) as f64;
        let shape = ShapeSpec::Cuboid { size: DVec3::new(TREAD, height, width) };
        let centre = DVec3::new((i as f64 + 0.5) * TREAD, 0.5 * height, 0.0);
        scene.bodies.push(BodySpec::new(format!("step {i}"), shape, centre).fixed().with_color(palette::STEEL));
    }
    let out = Side {
        upper_arm: DVec3::new(0.5, -0.8, 0.3),
        forearm: DVec3::new(0.3, -0.6, 0.8),
        thigh: DVec3::new(0.1, -1.0, 0.3),
        shin: DVec3::new(0.05, -1.0, -0.2),
    };
    let straight = Side { upper_arm: DVec3::new(0.3, -1.0, 0.0), thigh: DVec3::new(0.1, -1.0, 0.0), ..out };
    for i in 0..n {
        // Each leans a little more than the one before, round and round.
        let lean = 0.1 + 0.05 * (i % 5) as f64;
        let z = ASIDE * (i as f64 - 0.5 * (n - 1) as f64);
        let height = RISE * STEPS as f64 + DROP + soles_to_pelvis(false);
        let figure = Figure {
            scene: &mut scene,
            name: format!("doll {i}"),
            pelvis: DVec3::new(TREAD, height, z),
            facing: DQuat::from_rotation_y(FRAC_PI_2) * DQuat::from_rotation_x(lean),
            scale: 1.0,
        };
        let clothes = [palette::bright(i), palette::bright(i + 1), palette::SLATE, palette::YELLOW];
        figure.build_ragdoll([out, straight], Clothes(clothes));
    }
    let middle = DVec3::new(0.5 * TREAD * STEPS as f64, 1.2, 0.0);
    scene.view = Some(ViewSpec::framing(middle, 1.8 + 0.5 * width, DVec3::new(1.0, 0.35, 0.8)));
    scene
}
