//! The start scene, `limbs`: figures, a garland and loose things to pick and drag.

use bevy::math::{DQuat, DVec3};

use super::{EARTH, palette};
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, ViewSpec};

pub(super) const LIMBS: SceneInfo = SceneInfo {
    name: "limbs",
    about: "three figures of boxes, balls and cones on ball joints, a garland and loose things, to pick and drag",
    truth: "joints hold, bodies come to rest",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| BODIES as f64,
    build: |_| build(),
};

/// How many bodies [`build`] makes.
const BODIES: usize = 1 + 3 * FIGURE_PARTS + 3 + 2 + 1 + 2 + LINKS + 10 + 3 + 3;

/// Bodies of a figure.
const FIGURE_PARTS: usize = 16;

/// Links of the garland.
const LINKS: usize = 28;

fn build() -> SceneSpec {
    let mut scene = SceneSpec::new("limbs", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    add_bar_with_figures(&mut scene);
    add_sitting_child(&mut scene);
    add_garland(&mut scene);
    add_loose_things(&mut scene);
    scene.view = Some(ViewSpec { eye: DVec3::new(2.6, 2.5, 7.8), target: DVec3::new(0.8, 1.15, -0.3) });
    scene
}

/// Full size of a part along x, y, z, m, and its mass, kg, for a figure of scale 1. Joined
/// parts differ by less than 5 to 1 in mass.
const PELVIS: (DVec3, f64) = (DVec3::new(0.34, 0.16, 0.20), 9.0);
const CHEST: (DVec3, f64) = (DVec3::new(0.38, 0.36, 0.22), 14.0);
const UPPER_ARM: (DVec3, f64) = (DVec3::new(0.10, 0.27, 0.10), 3.0);
const FOREARM: (DVec3, f64) = (DVec3::new(0.085, 0.25, 0.085), 2.0);
const THIGH: (DVec3, f64) = (DVec3::new(0.13, 0.36, 0.14), 8.0);
const SHIN: (DVec3, f64) = (DVec3::new(0.11, 0.36, 0.12), 4.5);
/// Radius, height, mass.
const HAND: (f64, f64, f64) = (0.06, 0.13, 0.8);
const FOOT: (f64, f64, f64) = (0.10, 0.13, 1.5);
const HAT: (f64, f64, f64) = (0.12, 0.24, 1.2);
/// Radius, mass.
const HEAD: (f64, f64) = (0.13, 5.0);
/// Between a part's end and its joint, so that joined parts can bend without meeting.
const GAP: f64 = 0.025;

/// How the limbs of one side point, outward from the body, in the figure's axes: x to its left,
/// y up, z forward. The x of a right limb is mirrored.
#[derive(Clone, Copy)]
struct Side {
    upper_arm: DVec3,
    forearm: DVec3,
    thigh: DVec3,
    shin: DVec3,
}

/// Shirt, sleeves, trousers, hat.
struct Clothes([[f32; 3]; 4]);

/// Where a figure can be held: bodies of the scene.
struct Holds {
    chest: usize,
    hands: [usize; 2],
}

/// A figure under construction; points are in its own axes from the middle of its pelvis, before
/// scaling.
struct Figure<'a> {
    scene: &'a mut SceneSpec,
    name: &'static str,
    pelvis: DVec3,
    facing: DQuat,
    scale: f64,
}

impl Figure<'_> {
    /// Builds all 16 parts, the pelvis first.
    fn build(mut self, [left, right]: [Side; 2], Clothes([shirt, sleeves, trousers, hat]): Clothes) -> Holds {
        let up = DVec3::Y;
        let pelvis = self.box_part("pelvis", PELVIS, DVec3::ZERO, DQuat::IDENTITY, trousers);
        let waist = (PELVIS.0.y / 2.0 + GAP) * up;
        let chest_center = waist + (GAP + CHEST.0.y / 2.0) * up;
        let chest = self.box_part("chest", CHEST, chest_center, DQuat::IDENTITY, shirt);
        self.join(pelvis, chest, waist);
        let neck = chest_center + (CHEST.0.y / 2.0 + GAP) * up;
        let head_center = neck + (GAP + HEAD.0) * up;
        let head_shape = ShapeSpec::Sphere { radius: HEAD.0 * self.scale };
        let head = self.part("head", head_shape, HEAD.1, head_center, DQuat::IDENTITY, palette::SKIN);
        self.join(chest, head, neck);
        let crown = head_center + (HEAD.0 + 0.4 * GAP) * up;
        let hat_shape = ShapeSpec::Cone { radius: HAT.0 * self.scale, height: HAT.1 * self.scale };
        let hat_center = crown + (0.4 * GAP + HAT.1 / 4.0) * up;
        let hat = self.part("hat", hat_shape, HAT.2, hat_center, DQuat::IDENTITY, hat);
        self.join(head, hat, crown);

        let shoulder_height = chest_center.y + CHEST.0.y / 2.0 - UPPER_ARM.0.x / 2.0;
        let hip_height = -PELVIS.0.y / 2.0 - GAP;
        let mut hands = [0, 0];
        for (i, (side, mirror)) in [(left, 1.0), (right, -1.0)].into_iter().enumerate() {
            let mirror = DVec3::new(mirror, 1.0, 1.0);
            let name = |part: &str| format!("{} {part}", if i == 0 { "left" } else { "right" });
            let shoulder = mirror * DVec3::new((CHEST.0.x + UPPER_ARM.0.x) / 2.0 + GAP, shoulder_height, 0.0);
            let (upper_arm, elbow) =
                self.limb(&name("upper arm"), chest, shoulder, mirror * side.upper_arm, UPPER_ARM, sleeves);
            let forearm = mirror * side.forearm;
            let (lower, wrist) = self.limb(&name("forearm"), upper_arm, elbow, forearm, FOREARM, palette::SKIN);
            hands[i] = self.cone_end(&name("hand"), lower, wrist, forearm, HAND, palette::SKIN);
            let hip = mirror * DVec3::new(PELVIS.0.x / 4.0 + GAP, hip_height, 0.0);
            let (thigh, knee) = self.limb(&name("thigh"), pelvis, hip, mirror * side.thigh, THIGH, trousers);
            let (shin, ankle) = self.limb(&name("shin"), thigh, knee, mirror * side.shin, SHIN, trousers);
            self.cone_end(&name("foot"), shin, ankle, -up, FOOT, palette::SLATE);
        }
        Holds { chest, hands }
    }

    /// A box along `direction` from a joint of `parent`; returns it and the joint at its far end.
    fn limb(
        &mut self,
        name: &str,
        parent: usize,
        joint: DVec3,
        direction: DVec3,
        (size, mass): (DVec3, f64),
        color: [f32; 3],
    ) -> (usize, DVec3) {
        let direction = direction.normalize();
        let center = joint + (GAP + size.y / 2.0) * direction;
        let rotation = DQuat::from_rotation_arc(-DVec3::Y, direction);
        let limb = self.box_part(name, (size, mass), center, rotation, color);
        self.join(parent, limb, joint);
        (limb, joint + (2.0 * GAP + size.y) * direction)
    }

    /// A cone along `direction` whose apex is at a joint of `parent`.
    fn cone_end(
        &mut self,
        name: &str,
        parent: usize,
        joint: DVec3,
        direction: DVec3,
        (radius, height, mass): (f64, f64, f64),
        color: [f32; 3],
    ) -> usize {
        let direction = direction.normalize();
        let shape = ShapeSpec::Cone { radius: radius * self.scale, height: height * self.scale };
        let center = joint + (GAP + 0.75 * height) * direction;
        let cone = self.part(name, shape, mass, center, DQuat::from_rotation_arc(-DVec3::Y, direction), color);
        self.join(parent, cone, joint);
        cone
    }

    fn box_part(
        &mut self,
        name: &str,
        (size, mass): (DVec3, f64),
        center: DVec3,
        rotation: DQuat,
        color: [f32; 3],
    ) -> usize {
        self.part(name, ShapeSpec::Cuboid { size: size * self.scale }, mass, center, rotation, color)
    }

    fn part(
        &mut self,
        name: &str,
        shape: ShapeSpec,
        mass: f64,
        center: DVec3,
        rotation: DQuat,
        color: [f32; 3],
    ) -> usize {
        let body = BodySpec::new(format!("{} {name}", self.name), shape, self.world(center))
            .with_mass(mass * self.scale.powi(3))
            .with_rotation(self.facing * rotation)
            .with_color(color);
        self.scene.bodies.push(BodySpec { damping: DAMPING, ..body });
        self.scene.bodies.len() - 1
    }

    fn join(&mut self, a: usize, b: usize, at: DVec3) {
        let joint = JointSpec::at(&self.scene.bodies[a], &self.scene.bodies[b], self.world(at));
        self.scene.joints.push(joint);
    }

    fn world(&self, point: DVec3) -> DVec3 {
        self.pelvis + self.facing * (point * self.scale)
    }
}

/// Linear and angular, of whatever is joined, 1/s: a ball joint has no friction, and a swing would
/// not end.
const DAMPING: (f64, f64) = (0.2, 3.0);

/// A bar on two posts, and from it, in equilibrium but for an arm that waves: a puppet on two
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
    let soles_to_pelvis = PELVIS.0.y / 2.0 + THIGH.0.y + SHIN.0.y + FOOT.1 + 6.0 * GAP;
    let pelvis = DVec3::new(BAR.x - 0.7, soles_to_pelvis + 0.03, BAR.z);
    let figure = Figure { scene: &mut *scene, name: "ann", pelvis, facing: DQuat::IDENTITY, scale: 1.0 };
    let clothes = Clothes([palette::RED, palette::RED, palette::BLUE, palette::YELLOW]);
    let chest = figure.build([hanging, waving], clothes).chest;
    for (name, side) in [("left string", 1.0), ("right string", -1.0)] {
        // Between head and arm.
        let shoulder = scene.bodies[chest].point(DVec3::new(side * 0.165, CHEST.0.y / 2.0, 0.0));
        let top = DVec3::new(shoulder.x, BAR.y, BAR.z);
        let shape = ShapeSpec::Cuboid { size: DVec3::new(0.03, top.y - shoulder.y - 0.1, 0.03) };
        let string = BodySpec::new(name, shape, 0.5 * (shoulder + top)).with_mass(2.0).with_color(palette::STEEL);
        scene.joints.push(JointSpec::at(&scene.bodies[bar], &string, top));
        scene.joints.push(JointSpec::at(&string, &scene.bodies[chest], shoulder));
        scene.bodies.push(BodySpec { damping: DAMPING, ..string });
    }
}

fn add_gymnast(scene: &mut SceneSpec, bar: usize) {
    let stretched = Side { upper_arm: DVec3::Y, forearm: DVec3::Y, thigh: DVec3::NEG_Y, shin: DVec3::NEG_Y };
    let pelvis = DVec3::new(BAR.x + 0.75, 1.495, BAR.z);
    let figure = Figure { scene: &mut *scene, name: "bo", pelvis, facing: DQuat::IDENTITY, scale: 1.0 };
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
    let hip_above_seat = SCALE * (PELVIS.0.y / 2.0 + GAP + THIGH.0.z / 2.0) + 0.005;
    let pelvis = seat + hip_above_seat * DVec3::Y + facing * DVec3::new(0.0, 0.0, 0.08);
    let figure = Figure { scene, name: "cy", pelvis, facing, scale: SCALE };
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
