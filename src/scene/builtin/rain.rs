//! Figures that rain on arches: `rain`, after Box3D's benchmark of that name.

use std::f64::consts::{FRAC_PI_2, TAU};

use bevy::math::{DQuat, DVec3};

use super::figure::{Clothes, Figure, RAGDOLL_PARTS, Side};
use super::gravity::TEN;
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, SurfaceSpec, ViewSpec};

/// Side of a tile of the ground, m, and squares along it.
const TILE: f64 = 15.0;
const SQUARES: usize = 8;
/// The ring that stands on it, half in the ground: its radius, that of its section, m, and corners of each.
const RING: f64 = 3.75;
const THICKNESS: f64 = 1.0;
const CORNERS: usize = 16;
/// Figures over a tile, and how far apart they are, m.
const GROUP: usize = 3;
const PITCH: f64 = 0.75;
/// Height of the pelvises over the first row of tiles, m, and by how much more each further row's are higher.
const DROP: f64 = 20.0;
const LATER: f64 = 3.0;

pub(super) const RAIN: SceneInfo = SceneInfo {
    name: "rain",
    title: "Rain of ragdolls",
    subject: Subject::Large,
    about: "3 figures of 11 bodies over each of n x n tiles of triangles with an arch, row after row (Box3D's 'rain': n 10)",
    truth: "limits and joints hold, nothing falls through the ground",
    parameters: &[Parameter::whole("n", "tiles along each side", 2.0, 1.0, 50.0)],
    seconds: 6.0,
    bodies: |values| values[0] * values[0] * (1 + GROUP * RAGDOLL_PARTS) as f64,
    build: |values| build(values[0] as usize),
};

fn build(n: usize) -> SceneSpec {
    let mut scene = SceneSpec::new("rain", TEN);
    let tile = ShapeSpec::Surface(tile());
    let at = |k: usize| TILE * (k as f64 - 0.5 * (n - 1) as f64);
    let places: Vec<(usize, DVec3)> = (0..n * n).map(|i| (i / n, DVec3::new(at(i / n), 0.0, at(i % n)))).collect();
    for (i, &(_, place)) in places.iter().enumerate() {
        let tile = BodySpec::new(format!("tile {i}"), tile.clone(), place);
        scene.bodies.push(tile.fixed().with_color(palette::GROUND));
    }
    for (i, &(row, place)) in places.iter().enumerate() {
        for k in 0..GROUP {
            let pelvis = place + DVec3::new(PITCH * k as f64, DROP + LATER * row as f64, 0.0);
            add_figure(&mut scene, GROUP * i + k, pelvis);
        }
    }
    let radius = 0.5 * TILE * n as f64 + 2.0;
    scene.view = Some(ViewSpec::framing(2.0 * DVec3::Y, radius, DVec3::new(0.5, 0.45, 1.0)));
    scene
}

/// A ragdoll with round limbs.
fn add_figure(scene: &mut SceneSpec, i: usize, pelvis: DVec3) {
    let first = scene.bodies.len();
    let limbs = Side {
        upper_arm: DVec3::new(0.6, -1.0, 0.1),
        forearm: DVec3::new(0.4, -1.0, 0.4),
        thigh: DVec3::new(0.15, -1.0, 0.2),
        shin: DVec3::new(0.05, -1.0, -0.1),
    };
    let clothes = [palette::bright(i), palette::bright(i + 1), palette::SLATE, palette::YELLOW];
    // Across the line of the group: arms need more room than chests.
    let facing = DQuat::from_rotation_y(FRAC_PI_2);
    let figure = Figure { scene, name: format!("doll {i}"), pelvis, facing, scale: 1.0 };
    figure.build_ragdoll([limbs; 2], Clothes(clothes));
    for body in &mut scene.bodies[first..] {
        if let Some(ShapeSpec::Cuboid { size }) = body.shape
            && size.y > size.x.max(size.z)
        {
            let radius = 0.5 * size.x.min(size.z);
            body.shape = Some(ShapeSpec::Capsule { radius, length: size.y - 2.0 * radius });
        }
    }
}

/// Level squares, and a ring across them that is an arch above.
fn tile() -> SurfaceSpec {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut add = |columns: usize, rows: usize, closed: bool, at: &dyn Fn(usize, usize) -> DVec3| {
        let first = vertices.len();
        let lines = |count: usize| if closed { count } else { count + 1 };
        for row in 0..lines(rows) {
            vertices.extend((0..lines(columns)).map(|column| at(column, row)));
        }
        let index =
            |column: usize, row: usize| (first + row % lines(rows) * lines(columns) + column % lines(columns)) as u32;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let [a, b, c, d] =
                [(column, row), (column, row + 1), (column + 1, row + 1), (column + 1, row)].map(|(i, k)| index(i, k));
            triangles.extend([[a, b, c], [c, d, a]]);
        }
    };
    let square = |k: usize| TILE * (k as f64 / SQUARES as f64 - 0.5);
    add(SQUARES, SQUARES, false, &|column, row| DVec3::new(square(column), 0.0, square(row)));
    let angle = |k: usize| (TAU * k as f64 / CORNERS as f64).sin_cos();
    add(CORNERS, CORNERS, true, &|column, row| {
        let ((sin, cos), (up, out)) = (angle(column), angle(row));
        let radius = RING + THICKNESS * out;
        DVec3::new(radius * cos, radius * sin, -THICKNESS * up)
    });
    SurfaceSpec::triangles(vertices, triangles, false).expect("a grid and a ring")
}
