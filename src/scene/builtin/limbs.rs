//! The start scene, `limbs`: figures, a garland and loose things to pick and drag.

use bevy::math::{DQuat, DVec3};

use super::figure::{CHEST, Clothes, DAMPING, FIGURE_PARTS, Figure, HAT, Holds, Side, hip_above_seat, soles_to_pelvis};
use super::gravity::EARTH;
use super::palette;
use crate::scene::{BodySpec, JointSpec, MeshSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const LIMBS: SceneInfo = SceneInfo {
    name: "limbs",
    title: "Figures and a garland",
    subject: Subject::Joints,
    about: "three figures of boxes, balls and cones with hinged elbows and knees and limits at all joints, a garland and loose things, meshes among them, to pick and drag",
    truth: "joints hold, bodies come to rest",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| BODIES as f64,
    build: |_| build(),
};

/// How many bodies [`build`] makes.
const BODIES: usize = 1 + 3 * FIGURE_PARTS + 3 + 3 + 1 + 2 + LINKS + 10 + 3 + 3 + 5;

/// At most; fewer would fill it more.
const BOWL_PIECES: u32 = 16;

/// Links of the garland.
const LINKS: usize = 28;

fn build() -> SceneSpec {
    let mut scene = SceneSpec::new("limbs", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    add_bar_with_figures(&mut scene);
    add_sitting_child(&mut scene);
    add_garland(&mut scene);
    add_loose_things(&mut scene);
    add_loose_meshes(&mut scene);
    scene.view = Some(ViewSpec { eye: DVec3::new(2.6, 2.5, 7.8), target: DVec3::new(0.8, 1.15, -0.3) });
    scene
}

/// A bar on two posts, and from it, in equilibrium but for an arm that waves: a puppet on three
/// strings, its soles just off the ground, and a gymnast by both hands.
fn add_bar_with_figures(scene: &mut SceneSpec) {
    let thickness = 0.06;
    let bar_shape = ShapeSpec::Cuboid { size: DVec3::new(3.1, thickness, thickness) };
    scene.bodies.push(BodySpec::new("bar", bar_shape, BAR).fixed().with_color(palette::STEEL));
    let bar = scene.bodies.len() - 1;
    for (name, side) in [("left bar post", -1.0), ("right bar post", 1.0)] {
        let height = BAR.y + thickness / 2.0;
        let post = ShapeSpec::Cuboid { size: DVec3::new(0.08, height, 0.08) };
        let position = DVec3::new(BAR.x + side * 1.59, height / 2.0, BAR.z);
        scene.bodies.push(BodySpec::new(name, post, position).fixed().with_color(palette::SLATE));
    }
    add_puppet(scene, bar);
    add_gymnast(scene, bar);
}

/// The middle of the bar.
const BAR: DVec3 = DVec3::new(0.5, 2.75, -0.3);

fn add_puppet(scene: &mut SceneSpec, bar: usize) {
    let hanging =
        Side { upper_arm: DVec3::new(0.05, -1.0, 0.0), forearm: DVec3::NEG_Y, thigh: DVec3::NEG_Y, shin: DVec3::NEG_Y };
    let waving = Side { upper_arm: DVec3::new(1.0, 0.45, 0.0), forearm: DVec3::new(0.2, 1.0, 0.15), ..hanging };
    let pelvis = DVec3::new(BAR.x - 0.7, soles_to_pelvis(true) + 0.03, BAR.z);
    let figure = Figure { scene: &mut *scene, name: "ann".to_owned(), pelvis, facing: DQuat::IDENTITY, scale: 1.0 };
    let clothes = Clothes([palette::RED, palette::RED, palette::BLUE, palette::YELLOW]);
    let Holds { chest, hat, .. } = figure.build([hanging, waving], clothes);
    // Two between head and arms carry the body, the third holds the head up.
    let shoulder = DVec3::new(0.165, CHEST.size.y / 2.0, 0.0);
    let strings = [
        ("left string", chest, shoulder, 2.0),
        ("right string", chest, shoulder * DVec3::new(-1.0, 1.0, 1.0), 2.0),
        ("hat string", hat, 0.75 * HAT.height * DVec3::Y, 1.0),
    ];
    for (name, body, anchor, mass) in strings {
        let bottom = scene.bodies[body].point(anchor);
        let top = DVec3::new(bottom.x, BAR.y, BAR.z);
        let shape = ShapeSpec::Cuboid { size: DVec3::new(0.03, top.y - bottom.y - 0.1, 0.03) };
        let string = BodySpec::new(name, shape, 0.5 * (bottom + top)).with_mass(mass).with_color(palette::STEEL);
        scene.joints.push(JointSpec::at(&scene.bodies[bar], &string, top));
        scene.joints.push(JointSpec::at(&string, &scene.bodies[body], bottom));
        scene.bodies.push(BodySpec { damping: DAMPING, ..string });
    }
}

fn add_gymnast(scene: &mut SceneSpec, bar: usize) {
    let stretched = Side { upper_arm: DVec3::Y, forearm: DVec3::Y, thigh: DVec3::NEG_Y, shin: DVec3::NEG_Y };
    let pelvis = DVec3::new(BAR.x + 0.75, 1.495, BAR.z);
    let figure = Figure { scene: &mut *scene, name: "bo".to_owned(), pelvis, facing: DQuat::IDENTITY, scale: 1.0 };
    let clothes = Clothes([palette::TEAL, palette::TEAL, palette::SLATE, palette::ORANGE]);
    for hand in figure.build([stretched, stretched], clothes).hands {
        let (bar, hand) = (&scene.bodies[bar], &scene.bodies[hand]);
        let grip = DVec3::new(hand.position.x, BAR.y, BAR.z);
        scene.joints.push(JointSpec::at(bar, hand, grip));
    }
}

/// A smaller figure on a crate.
fn add_sitting_child(scene: &mut SceneSpec) {
    const SCALE: f64 = 0.72;
    const CRATE: f64 = 0.5;
    let facing = DQuat::from_rotation_y(0.6);
    let seat = DVec3::new(-2.1, CRATE, 0.4);
    let crate_shape = ShapeSpec::Cuboid { size: DVec3::splat(CRATE) };
    let crate_center = seat - CRATE / 2.0 * DVec3::Y;
    scene.bodies.push(
        BodySpec::new("seat", crate_shape, crate_center)
            .with_mass(40.0)
            .with_rotation(facing)
            .with_color(palette::WOOD),
    );
    let side = Side {
        upper_arm: DVec3::new(0.3, -1.0, 0.1),
        forearm: DVec3::new(0.05, -0.25, 0.9),
        thigh: DVec3::new(0.1, 0.0, 1.0),
        shin: DVec3::new(0.0, -1.0, 0.12),
    };
    let pelvis = seat + (SCALE * hip_above_seat() + 0.005) * DVec3::Y + facing * DVec3::new(0.0, 0.0, 0.08);
    let figure = Figure { scene, name: "cy".to_owned(), pelvis, facing, scale: SCALE };
    figure.build([side, side], Clothes([palette::YELLOW, palette::GREEN, palette::PURPLE, palette::RED]));
}

/// A chain of equal links between two posts, in equilibrium: link k of n slopes by
/// tan θ = (k − (n−1)/2)·w/H for a link's weight w and the horizontal pull H.
fn add_garland(scene: &mut SceneSpec) {
    const LINK: f64 = 0.25;
    const MASS: f64 = 1.0;
    const WEIGHT_OVER_PULL: f64 = 0.09;
    const HEIGHT: f64 = 3.0;
    const Z: f64 = -1.7;
    let directions: Vec<DVec3> = (0..LINKS)
        .map(|k| {
            let slope = WEIGHT_OVER_PULL * (k as f64 - (LINKS - 1) as f64 / 2.0);
            DVec3::new(1.0, slope, 0.0).normalize()
        })
        .collect();
    let span: f64 = LINK * directions.iter().map(|direction| direction.x).sum::<f64>();
    let size = DVec3::new(0.14, HEIGHT + 0.1, 0.14);
    for (name, side) in [("left post", -1.0), ("right post", 1.0)] {
        let position = DVec3::new(side * (span / 2.0 + size.x / 2.0 + 0.05), size.y / 2.0, Z);
        let post = BodySpec::new(name, ShapeSpec::Cuboid { size }, position);
        scene.bodies.push(post.fixed().with_color(palette::SLATE));
    }
    let (left_post, right_post) = (scene.bodies.len() - 2, scene.bodies.len() - 1);
    let mut previous = left_post;
    let mut joint = DVec3::new(-span / 2.0, HEIGHT, Z);
    for (k, direction) in directions.into_iter().enumerate() {
        let shape = ShapeSpec::Cuboid { size: DVec3::new(LINK - 0.05, 0.09, 0.09) };
        let link = BodySpec::new(format!("link {k}"), shape, joint + 0.5 * LINK * direction)
            .with_mass(MASS)
            .with_rotation(DQuat::from_rotation_z(direction.y.atan2(direction.x)))
            .with_color(palette::bright(k));
        scene.joints.push(JointSpec::at(&scene.bodies[previous], &link, joint));
        scene.bodies.push(BodySpec { damping: DAMPING, ..link });
        previous = scene.bodies.len() - 1;
        joint += LINK * direction;
    }
    scene.joints.push(JointSpec::at(&scene.bodies[previous], &scene.bodies[right_post], joint));
}

fn add_loose_things(scene: &mut SceneSpec) {
    const CRATE: f64 = 0.36;
    let mut crates = 0;
    for (row, count) in [4, 3, 2, 1].into_iter().enumerate() {
        for i in 0..count {
            let x = 3.3 + (CRATE + 0.01) * (f64::from(i) - f64::from(count - 1) / 2.0);
            let position = DVec3::new(x, CRATE * (row as f64 + 0.5), 0.1);
            let color = palette::bright(row + i as usize);
            let shape = ShapeSpec::Cuboid { size: DVec3::splat(CRATE) };
            scene
                .bodies
                .push(BodySpec::new(format!("crate {crates}"), shape, position).with_mass(8.0).with_color(color));
            crates += 1;
        }
    }
    let balls = [(0.3, 20.0, DVec3::new(0.9, 0.0, 1.5)), (0.2, 8.0, DVec3::new(-0.2, 0.0, 1.9))];
    for (i, (radius, mass, at)) in balls.into_iter().chain([(0.15, 4.0, DVec3::new(1.7, 0.0, 2.0))]).enumerate() {
        let ball = BodySpec::new(format!("ball {i}"), ShapeSpec::Sphere { radius }, at + radius * DVec3::Y);
        let rolling_drag = (0.1, 0.4);
        scene.bodies.push(BodySpec {
            damping: rolling_drag,
            ..ball.with_mass(mass).with_material(0.6, 0.4).with_color(palette::bright(2 * i))
        });
    }
    let cones = [DVec3::new(-1.4, 0.0, 1.6), DVec3::new(-2.2, 0.0, 1.9), DVec3::new(2.6, 0.0, 1.5)];
    for (i, at) in cones.into_iter().enumerate() {
        let (radius, height) = (0.18, 0.45);
        let shape = ShapeSpec::Cone { radius, height };
        let cone = BodySpec::new(format!("cone {i}"), shape, at + height / 4.0 * DVec3::Y);
        scene.bodies.push(cone.with_mass(5.0).with_color(palette::ORANGE));
    }
}

/// Each lies on a face of its hull, or nearly. The bowl is of pieces, so that it holds what is put in it.
fn add_loose_meshes(scene: &mut SceneSpec) {
    let on_a_facet = DQuat::from_rotation_y(0.5) * DQuat::from_rotation_x(0.777);
    let things = [
        ("rock", 0.3, 12.0, DVec3::new(3.4, 0.0, 1.6), DQuat::from_rotation_y(0.4), palette::STEEL),
        ("bone", 0.3, 3.0, DVec3::new(0.3, 0.0, 2.6), DQuat::from_rotation_y(0.35), palette::SKIN),
        ("gem", 0.2, 4.0, DVec3::new(-0.9, 0.0, 2.4), on_a_facet, palette::TEAL),
        ("dodecahedron", 0.2, 6.0, DVec3::new(1.25, 0.0, 2.6), DQuat::from_rotation_y(0.8), palette::RED),
        ("bowl", 0.28, 4.0, DVec3::new(2.1, 0.0, 2.6), DQuat::IDENTITY, palette::YELLOW),
    ];
    for (name, scale, mass, at, rotation, color) in things {
        let mesh = MeshSpec::builtin(&format!("{name}.obj"), scale);
        let mesh = if name == "bowl" { mesh.with_pieces(BOWL_PIECES).expect("it is a solid") } else { mesh };
        let up = rotation.inverse() * DVec3::Y;
        let (center, corners) = (mesh.center(), mesh.hull().vertices());
        let corners = corners.map(|vertex| mesh.hull().center() + mesh.hull().axes() * vertex - center);
        let reach = corners.map(|corner| -up.dot(corner)).fold(0.0, f64::max);
        let thing = BodySpec::new(name, ShapeSpec::Mesh(mesh), at + reach * DVec3::Y);
        scene.bodies.push(thing.with_mass(mass).with_rotation(rotation).with_color(color));
    }
}
