//! Things of one kind, or of all, that fall on each other: `heap`.

use bevy::math::{DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::gravity::TEN;
use super::palette;
use super::random::{any_hull, any_rotation, seeded};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Of the grid that things are dropped from, m.
const PITCH: f64 = 1.0;
/// Of the lowest layer above the ground, m.
const DROP: f64 = 0.8;
/// Layers over rows.
const SLENDERNESS: usize = 3;
/// Points of a hull.
const CORNERS: usize = 12;

const THINGS: [(&str, fn(&mut Pcg64Mcg) -> ShapeSpec); 6] = [
    ("box", |random| ShapeSpec::Cuboid {
        size: DVec3::from_array(std::array::from_fn(|_| random.random_range(0.3..0.8))),
    }),
    ("ball", |random| ShapeSpec::Sphere { radius: random.random_range(0.2..0.4) }),
    ("hull", |random| {
        let radius = random.random_range(0.32..0.4);
        any_hull(random, radius, CORNERS)
    }),
    ("cone", |_| ShapeSpec::Cone { radius: 0.25, height: 0.6 }),
    ("cylinder", |random| ShapeSpec::Cylinder {
        radius: random.random_range(0.15..0.3),
        height: random.random_range(0.3..0.7),
    }),
    ("capsule", |random| ShapeSpec::Capsule { radius: 0.15, length: random.random_range(0.3..0.6) }),
];

/// What `kind` counts: which things, in turns. Measurements name the mixtures by their numbers.
const KINDS: [&[usize]; 8] = [&[0], &[1], &[2], &[3], &[0, 1, 2, 3], &[4], &[5], &[0, 1, 2, 3, 4, 5]];

pub(super) const HEAP: SceneInfo = SceneInfo {
    name: "heap",
    title: "Heap of all shapes",
    subject: Subject::Large,
    about: "n things dropped in a block three times as high as wide: boxes, balls, hulls, cones, cylinders, capsules or \
            a mixture",
    truth: "comes to rest without an overlap",
    parameters: &[
        Parameter::whole(
            "kind",
            "0 boxes, 1 balls, 2 hulls, 3 cones, 4 of each of these, 5 cylinders, 6 capsules, 7 of each of all",
            4.0,
            0.0,
            (KINDS.len() - 1) as f64,
        ),
        Parameter::whole("n", "things dropped", 200.0, 1.0, 20_000.0),
    ],
    seconds: 5.0,
    bodies: |values| values[1] + 1.0,
    build: |values| build_heap(KINDS[values[0] as usize], values[1] as usize),
};

fn build_heap(kind: &[usize], n: usize) -> SceneSpec {
    let mut side = 1;
    while SLENDERNESS * side * side * side < n {
        side += 1;
    }
    let mut scene = SceneSpec::new("heap", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let mut random = seeded();
    let first = -0.5 * PITCH * (side - 1) as f64;
    for i in 0..n {
        let [layer, row, column] = [i / (side * side), i / side % side, i % side].map(|k| PITCH * k as f64);
        let place = DVec3::new(first + column, DROP + layer, first + row);
        scene.bodies.push(thing(kind, i, place, &mut random));
    }
    let height = 0.5 * PITCH * (SLENDERNESS * side) as f64;
    let view = ViewSpec::framing(DVec3::new(0.0, 0.5 * height, 0.0), height + 1.0, DVec3::new(0.45, 0.4, 1.0));
    scene.view = Some(view);
    scene
}

/// Number `i` at its place in the grid.
fn thing(kind: &[usize], i: usize, place: DVec3, random: &mut Pcg64Mcg) -> BodySpec {
    let (noun, shape) = THINGS[kind[i % kind.len()]];
    let shape = shape(random);
    let mut rotation = any_rotation(random);
    // The largest box is wider across its corners than the grid: turned another way it is clear of its neighbours.
    while let ShapeSpec::Cuboid { size } = shape
        && reach(rotation, size) > 0.5 * PITCH
    {
        rotation = any_rotation(random);
    }
    let center = shape.convex_hull().map_or(DVec3::ZERO, |hull| hull.center());
    let body = BodySpec::new(format!("{noun} {i}"), shape, place + rotation * center);
    let body = body.with_rotation(rotation).with_color(palette::bright(i + i / kind.len()));
    if ["ball", "cylinder", "capsule"].contains(&noun) {
        // It would roll for ever.
        return BodySpec { damping: (0.05, 0.5), ..body };
    }
    body
}

/// Of a box from its centre, along whichever axis of the world it is farthest.
fn reach(rotation: DQuat, size: DVec3) -> f64 {
    let axes = DMat3::from_quat(rotation);
    let absolute = DMat3::from_cols(axes.x_axis.abs(), axes.y_axis.abs(), axes.z_axis.abs());
    (absolute * (0.5 * size)).max_element()
}
