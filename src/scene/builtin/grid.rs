//! A sheet of spheres on ball joints: `joint_grid`.

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const JOINT_GRID: SceneInfo = SceneInfo {
    name: "joint_grid",
    title: "Net of balls",
    subject: Subject::Joints,
    about: "n x n spheres of radius 0.4 m, 1 m apart in a plane, the top row static, each joined to its right and \
            lower neighbour, no collision",
    truth: "tilt 0: exact equilibrium, any motion is error; else all columns swing as one; energy",
    parameters: &[
        Parameter::whole("n", "spheres in a row, and rows", 10.0, 2.0, 1000.0),
        Parameter::real("tilt", "angle of gravity out of the plane toward +z, degrees", 0.0, 0.0, 90.0),
    ],
    seconds: 5.0,
    bodies: |values| values[0] * values[0],
    build: |values| build(values[0] as usize, values[1]),
};

fn build(n: usize, tilt: f64) -> SceneSpec {
    let (sin, cos) = tilt.to_radians().sin_cos();
    let mut scene = SceneSpec::new("joint_grid", DVec3::new(0.0, TEN.y * cos, -TEN.y * sin));
    for i in 0..n {
        for j in 0..n {
            let position = DVec3::new(j as f64, -(i as f64), 0.0);
            let sphere = BodySpec::new(format!("sphere {i} {j}"), ShapeSpec::Sphere { radius: 0.4 }, position)
                .without_collision();
            scene.bodies.push(if i == 0 {
                sphere.fixed().with_color(palette::SLATE)
            } else {
                sphere.with_color(palette::bright(i + j))
            });
        }
    }
    let half_way = |a: usize, b: usize| {
        let (a, b) = (&scene.bodies[a], &scene.bodies[b]);
        JointSpec::at(a, b, 0.5 * (a.position + b.position))
    };
    let mut joints = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let here = i * n + j;
            if i > 0 && j + 1 < n {
                joints.push(half_way(here, here + 1));
            }
            if i + 1 < n {
                joints.push(half_way(here, here + n));
            }
        }
    }
    scene.joints = joints;
    let middle = (n - 1) as f64 / 2.0;
    scene.view =
        Some(ViewSpec::framing(DVec3::new(middle, -middle, 0.0), 0.75 * n as f64, DVec3::new(0.45, 0.15, 1.0)));
    scene
}
