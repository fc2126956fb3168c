//! Things of all kinds, compounds among them, that roll down hills into a valley: `terrain`.

use bevy::math::{DQuat, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::gravity::TEN;
use super::palette;
use super::random::{any_hull, any_rotation, seeded};
use crate::scene::info::Parameter;
use crate::scene::{
    BodySpec, ChildSpec, CompoundSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, SurfaceSpec, ViewSpec,
};

/// Side of the ground, m.
const SIDE: f64 = 24.0;
/// Height of its rim over the middle, m; at the corners twice that.
const RIM: f64 = 2.0;
/// Of the grid that things are dropped from, and of its lowest layer above the hills, m.
const PITCH: f64 = 1.3;
const DROP: f64 = 1.0;
/// Things of a layer, along x and z each.
const ROW: usize = 8;
/// Points of a hull.
const CORNERS: usize = 12;

const KINDS: [(&str, fn(&mut Pcg64Mcg) -> ShapeSpec); 8] = [
    ("box", |random| ShapeSpec::Cuboid {
        size: DVec3::from_array(std::array::from_fn(|_| random.random_range(0.3..0.7))),
    }),
    ("ball", |random| ShapeSpec::Sphere { radius: random.random_range(0.2..0.35) }),
    ("hull", |random| {
        let radius = random.random_range(0.32..0.4);
        any_hull(random, radius, CORNERS)
    }),
    ("cone", |_| ShapeSpec::Cone { radius: 0.25, height: 0.6 }),
    ("capsule", |random| ShapeSpec::Capsule { radius: 0.15, length: random.random_range(0.3..0.6) }),
    ("cylinder", |random| ShapeSpec::Cylinder {
        radius: random.random_range(0.15..0.3),
        height: random.random_range(0.3..0.6),
    }),
    ("dumb-bell", |_| {
        let ball = |side: f64| child(ShapeSpec::Sphere { radius: 0.2 }, DVec3::X * (0.35 * side));
        let bar = child(ShapeSpec::Cuboid { size: DVec3::new(0.5, 0.08, 0.08) }, DVec3::ZERO);
        compound(vec![ball(-1.0), bar, ball(1.0)])
    }),
    ("stool", |_| {
        let leg = |x: f64, z: f64| {
            child(ShapeSpec::Cuboid { size: DVec3::new(0.08, 0.4, 0.08) }, DVec3::new(0.2 * x, -0.24, 0.2 * z))
        };
        let seat = child(ShapeSpec::Cuboid { size: DVec3::new(0.5, 0.08, 0.5) }, DVec3::ZERO);
        compound(vec![seat, leg(-1.0, -1.0), leg(-1.0, 1.0), leg(1.0, -1.0), leg(1.0, 1.0)])
    }),
];

pub(super) const TERRAIN: SceneInfo = SceneInfo {
    name: "terrain",
    title: "Hills and a valley",
    subject: Subject::Large,
    about: "n things of all kinds, compounds among them, that roll down hills made of triangles",
    truth: "comes to rest without an overlap",
    parameters: &[
        Parameter::whole("n", "things dropped", 60.0, 1.0, 5000.0),
        Parameter::whole("squares", "squares along a side of the ground, of two triangles each", 64.0, 1.0, 500.0),
        Parameter::real("hills", "height of the hills, m", 0.6, 0.0, 2.0),
    ],
    seconds: 5.0,
    bodies: |values| values[0] + 1.0,
    build: |values| build_terrain(values[0] as usize, values[1] as usize, values[2]),
};

fn child(shape: ShapeSpec, position: DVec3) -> ChildSpec {
    ChildSpec { shape, position, rotation: DQuat::IDENTITY }
}

fn compound(children: Vec<ChildSpec>) -> ShapeSpec {
    ShapeSpec::Compound(CompoundSpec::new(children).expect("solids"))
}

fn height(x: f64, z: f64, hills: f64) -> f64 {
    let waves = (0.9 * x).sin() * (0.7 * z).cos() + 0.5 * (1.7 * x + 1.3 * z).sin();
    let rise = |out: f64| (out / (0.5 * SIDE)).powi(4);
    0.5 * hills * waves + RIM * (rise(x) + rise(z))
}

fn build_terrain(n: usize, squares: usize, hills: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("terrain", TEN);
    let at = |place: usize| SIDE * (place as f64 / squares as f64 - 0.5);
    let rows = (0..=squares).map(|k| (0..=squares).map(|i| height(at(i), at(k), hills)).collect());
    let ground = SurfaceSpec::heights([SIDE; 2], rows.collect()).expect("heights of a grid");
    let ground = BodySpec::new("ground", ShapeSpec::Surface(ground), DVec3::ZERO).fixed();
    scene.bodies.push(ground.with_color(palette::GROUND));
    let mut random = seeded();
    let first = -0.5 * PITCH * (ROW - 1) as f64;
    for i in 0..n {
        let [layer, row, column] = [i / (ROW * ROW), i / ROW % ROW, i % ROW].map(|k| PITCH * k as f64);
        let (x, z) = (first + column, first + row);
        let place = DVec3::new(x, height(x, z, hills).max(0.75 * hills) + DROP + layer, z);
        let (noun, shape) = KINDS[i % KINDS.len()];
        let shape = shape(&mut random);
        let rotation = any_rotation(&mut random);
        let center = shape.convex_hull().map_or(DVec3::ZERO, |hull| hull.center());
        let body = BodySpec::new(format!("{noun} {i}"), shape, place + rotation * center);
        let body = body.with_rotation(rotation).with_color(palette::bright(i + i / KINDS.len()));
        // What is round would roll for ever.
        scene.bodies.push(BodySpec { damping: (0.05, 0.5), ..body });
    }
    scene.view = Some(ViewSpec::framing(DVec3::Y, 7.5, DVec3::new(0.45, 0.8, 1.0)));
    scene
}
