//! A human-like figure of 16 bodies: boxes, a ball for the head, cones for hands, feet and hat, with a gap between parts,
//! so that they can bend without meeting. Elbows and knees are hinges; the other joints are ball joints whose swing and
//! twist are limited. Without hands, feet and hat it is a figure of 11 bodies, 1.7 m and, as a ragdoll, 70 kg.

use std::f64::consts::PI;

use bevy::math::{DMat3, DQuat, DVec3};

use super::palette;
use crate::physics::JointAxes;
use crate::scene::{BodySpec, JointKindSpec, JointSpec, LimitSpec, SceneSpec, ShapeSpec};

/// Bodies of a figure.
pub(super) const FIGURE_PARTS: usize = 16;

/// Bodies of a figure without hands, feet and hat.
pub(super) const RAGDOLL_PARTS: usize = 11;

/// Mass of a ragdoll over that of the same parts of a figure: 70 kg over 63 kg.
const RAGDOLL_MASS: f64 = 70.0 / 63.0;

/// A box part of a figure of scale 1.
#[derive(Clone, Copy)]
pub(super) struct BoxPart {
    /// Full size, m; limbs lie along y.
    pub size: DVec3,
    /// kg.
    mass: f64,
}

/// A cone part of a figure of scale 1.
#[derive(Clone, Copy)]
pub(super) struct ConePart {
    radius: f64,
    /// m.
    pub height: f64,
    mass: f64,
}

// Joined parts differ by less than 5 to 1 in mass.
const PELVIS: BoxPart = BoxPart { size: DVec3::new(0.34, 0.16, 0.20), mass: 9.0 };
pub(super) const CHEST: BoxPart = BoxPart { size: DVec3::new(0.38, 0.36, 0.22), mass: 14.0 };
const UPPER_ARM: BoxPart = BoxPart { size: DVec3::new(0.10, 0.27, 0.10), mass: 3.0 };
const FOREARM: BoxPart = BoxPart { size: DVec3::new(0.085, 0.25, 0.085), mass: 2.0 };
const THIGH: BoxPart = BoxPart { size: DVec3::new(0.13, 0.36, 0.14), mass: 8.0 };
const SHIN: BoxPart = BoxPart { size: DVec3::new(0.11, 0.36, 0.12), mass: 4.5 };
const HAND: ConePart = ConePart { radius: 0.06, height: 0.13, mass: 0.8 };
const FOOT: ConePart = ConePart { radius: 0.10, height: 0.13, mass: 1.5 };
pub(super) const HAT: ConePart = ConePart { radius: 0.12, height: 0.24, mass: 1.2 };
const HEAD_RADIUS: f64 = 0.13;
const HEAD_MASS: f64 = 5.0;

/// Between a part's end and its joint, m.
const GAP: f64 = 0.025;

/// How far a joint may go: largest swing and twist either way, rad.
#[derive(Clone, Copy)]
struct Reach(f64, f64);

const WAIST: Reach = Reach(0.5, 0.5);
const NECK: Reach = Reach(0.7, 1.0);
const HAT_BAND: Reach = Reach(0.5, 0.5);
const SHOULDER: Reach = Reach(1.9, 1.2);
const HIP: Reach = Reach(1.2, 0.6);
const WRIST: Reach = Reach(0.9, 0.8);
const ANKLE: Reach = Reach(0.7, 0.4);

/// Where an arm points in the middle of what its shoulder reaches, outwards, and a leg of what its hip does.
const MIDDLE_OF_SHOULDER: DVec3 = DVec3::new(1.0, 0.0, 0.3);
const MIDDLE_OF_HIP: DVec3 = DVec3::new(0.15, -0.8, 0.6);

/// Angles of an elbow or a knee, rad: a little more than straight, and bent until the limbs nearly meet.
const BEND: [f64; 2] = [-0.05, 0.8 * PI];

/// What an elbow and a knee bend about where they are straight and the limb hangs: forwards and backwards.
const ELBOW_AXIS: DVec3 = DVec3::NEG_X;
const KNEE_AXIS: DVec3 = DVec3::X;

/// Linear and angular, of whatever is joined, 1/s: a ball joint has no friction, and a swing would
/// not end.
pub(super) const DAMPING: (f64, f64) = (0.2, 3.0);

/// From the soles of a figure of scale 1, or from its shins' ends where it has no feet, its legs straight down, to the
/// middle of its pelvis, m.
pub(super) fn soles_to_pelvis(with_feet: bool) -> f64 {
    let foot = if with_feet { FOOT.height + 2.0 * GAP } else { 0.0 };
    foot + SHIN.size.y + THIGH.size.y + 4.0 * GAP + PELVIS.size.y / 2.0
}

/// From under the thighs of a sitting figure of scale 1 to the middle of its pelvis, m.
pub(super) fn hip_above_seat() -> f64 {
    THIGH.size.z / 2.0 + GAP + PELVIS.size.y / 2.0
}

/// How the limbs of one side point, outward from the body, in the figure's axes: x to its left,
/// y up, z forward. The x of a right limb is mirrored.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub upper_arm: DVec3,
    pub forearm: DVec3,
    pub thigh: DVec3,
    pub shin: DVec3,
}

/// Shirt, sleeves, trousers, hat.
pub(super) struct Clothes(pub [[f32; 3]; 4]);

/// Where a figure can be held: bodies of the scene.
pub(super) struct Holds {
    pub chest: usize,
    pub hat: usize,
    pub hands: [usize; 2],
}

/// Where the parts that a ragdoll lacks are joined.
struct Trunk {
    chest: usize,
    head: usize,
    crown: DVec3,
    wrists: [LimbEnd; 2],
    ankles: [LimbEnd; 2],
}

/// The far end of an arm or a leg.
#[derive(Clone, Copy)]
struct LimbEnd {
    part: usize,
    joint: DVec3,
    /// Of the last limb.
    along: DVec3,
}

/// A figure under construction; points are in its own axes from the middle of its pelvis, before
/// scaling.
pub(super) struct Figure<'a> {
    pub scene: &'a mut SceneSpec,
    pub name: String,
    pub pelvis: DVec3,
    pub facing: DQuat,
    pub scale: f64,
}

impl Figure<'_> {
    /// Builds all 16 parts, the pelvis first.
    pub fn build(mut self, sides: [Side; 2], clothes: Clothes) -> Holds {
        let Clothes([_, _, _, hat_color]) = clothes;
        let Trunk { chest, head, crown, wrists, ankles } = self.trunk_and_limbs(sides, &clothes);
        let hat = self.hat(head, crown, hat_color);
        let mut hands = [0, 0];
        for (i, word) in ["left", "right"].into_iter().enumerate() {
            let LimbEnd { part, joint, along } = wrists[i];
            hands[i] = self.cone_end(&format!("{word} hand"), part, joint, [along; 2], (HAND, WRIST), palette::SKIN);
            let LimbEnd { part, joint, along } = ankles[i];
            let down = [along, DVec3::NEG_Y];
            self.cone_end(&format!("{word} foot"), part, joint, down, (FOOT, ANKLE), palette::SLATE);
        }
        Holds { chest, hat, hands }
    }

    /// Builds the 11 parts but hands, feet and hat, with a mass of 70 kg at scale 1.
    pub fn build_ragdoll(mut self, sides: [Side; 2], clothes: Clothes) {
        let first = self.scene.bodies.len();
        self.trunk_and_limbs(sides, &clothes);
        for body in &mut self.scene.bodies[first..] {
            body.mass = body.mass.map(|mass| RAGDOLL_MASS * mass);
        }
    }

    fn trunk_and_limbs(&mut self, sides: [Side; 2], clothes: &Clothes) -> Trunk {
        let &Clothes([shirt, sleeves, trousers, _]) = clothes;
        let pelvis = self.box_part("pelvis", PELVIS, DVec3::ZERO, DQuat::IDENTITY, trousers);
        let waist = (PELVIS.size.y / 2.0 + GAP) * DVec3::Y;
        let chest_center = waist + (GAP + CHEST.size.y / 2.0) * DVec3::Y;
        let chest = self.box_part("chest", CHEST, chest_center, DQuat::IDENTITY, shirt);
        self.swing([pelvis, chest], waist, [DVec3::Y; 2], WAIST);

        let neck = chest_center + (CHEST.size.y / 2.0 + GAP) * DVec3::Y;
        let head_center = neck + (GAP + HEAD_RADIUS) * DVec3::Y;
        let ball = ShapeSpec::Sphere { radius: HEAD_RADIUS * self.scale };
        let head = self.part("head", ball, HEAD_MASS, head_center, DQuat::IDENTITY, palette::SKIN);
        self.swing([chest, head], neck, [DVec3::Y; 2], NECK);
        // The hat sits closer than the other parts.
        let crown = head_center + (HEAD_RADIUS + 0.4 * GAP) * DVec3::Y;

        let shoulder = DVec3::new(
            (CHEST.size.x + UPPER_ARM.size.x) / 2.0 + GAP,
            chest_center.y + (CHEST.size.y - UPPER_ARM.size.x) / 2.0,
            0.0,
        );
        let hip = DVec3::new(PELVIS.size.x / 4.0 + GAP, -PELVIS.size.y / 2.0 - GAP, 0.0);
        let mirrors = [("left", DVec3::ONE), ("right", DVec3::new(-1.0, 1.0, 1.0))];
        let limbs = mirrors.map(|(word, mirror)| {
            let Side { upper_arm, forearm, thigh, shin } = sides[usize::from(mirror.x < 0.0)];
            let arm = [mirror * upper_arm, mirror * forearm];
            let leg = [mirror * thigh, mirror * shin];
            let middles = [MIDDLE_OF_SHOULDER, MIDDLE_OF_HIP].map(|middle| mirror * middle);
            (
                self.arm(word, chest, mirror * shoulder, middles[0], arm, sleeves),
                self.leg(word, pelvis, mirror * hip, middles[1], leg, trousers),
            )
        });
        let [left, right] = limbs;
        Trunk { chest, head, crown, wrists: [left.0, right.0], ankles: [left.1, right.1] }
    }

    /// Returns the hat.
    fn hat(&mut self, head: usize, crown: DVec3, color: [f32; 3]) -> usize {
        let cone = ShapeSpec::Cone { radius: HAT.radius * self.scale, height: HAT.height * self.scale };
        let center = crown + (0.4 * GAP + HAT.height / 4.0) * DVec3::Y;
        let hat = self.part("hat", cone, HAT.mass, center, DQuat::IDENTITY, color);
        self.swing([head, hat], crown, [DVec3::Y; 2], HAT_BAND);
        hat
    }

    fn arm(
        &mut self,
        side: &str,
        chest: usize,
        shoulder: DVec3,
        middle: DVec3,
        [above, below]: [DVec3; 2],
        sleeve: [f32; 3],
    ) -> LimbEnd {
        let (upper, elbow) = self.limb(&format!("{side} upper arm"), shoulder, above, UPPER_ARM, sleeve);
        self.swing([chest, upper], shoulder, [middle, above], SHOULDER);
        let (lower, wrist) = self.limb(&format!("{side} forearm"), elbow, below, FOREARM, palette::SKIN);
        self.bend([upper, lower], elbow, [above, below], ELBOW_AXIS);
        LimbEnd { part: lower, joint: wrist, along: below }
    }

    fn leg(
        &mut self,
        side: &str,
        pelvis: usize,
        hip: DVec3,
        middle: DVec3,
        [above, below]: [DVec3; 2],
        trouser: [f32; 3],
    ) -> LimbEnd {
        let (thigh, knee) = self.limb(&format!("{side} thigh"), hip, above, THIGH, trouser);
        self.swing([pelvis, thigh], hip, [middle, above], HIP);
        let (shin, ankle) = self.limb(&format!("{side} shin"), knee, below, SHIN, trouser);
        self.bend([thigh, shin], knee, [above, below], KNEE_AXIS);
        LimbEnd { part: shin, joint: ankle, along: below }
    }

    /// A box along `direction` from a joint; returns it and the joint at its far end.
    fn limb(&mut self, name: &str, joint: DVec3, direction: DVec3, part: BoxPart, color: [f32; 3]) -> (usize, DVec3) {
        let direction = direction.normalize();
        let center = joint + (GAP + part.size.y / 2.0) * direction;
        let rotation = DQuat::from_rotation_arc(-DVec3::Y, direction);
        let limb = self.box_part(name, part, center, rotation, color);
        (limb, joint + (2.0 * GAP + part.size.y) * direction)
    }

    /// A cone along the second direction whose apex is at a joint of `parent`, in the middle of whose reach it would lie
    /// along the first.
    fn cone_end(
        &mut self,
        name: &str,
        parent: usize,
        joint: DVec3,
        [middle, direction]: [DVec3; 2],
        (part, reach): (ConePart, Reach),
        color: [f32; 3],
    ) -> usize {
        let direction = direction.normalize();
        let shape = ShapeSpec::Cone { radius: part.radius * self.scale, height: part.height * self.scale };
        let center = joint + (GAP + 0.75 * part.height) * direction;
        let cone = self.part(name, shape, part.mass, center, DQuat::from_rotation_arc(-DVec3::Y, direction), color);
        self.swing([parent, cone], joint, [middle, direction], reach);
        cone
    }

    fn box_part(&mut self, name: &str, part: BoxPart, center: DVec3, rotation: DQuat, color: [f32; 3]) -> usize {
        self.part(name, ShapeSpec::Cuboid { size: part.size * self.scale }, part.mass, center, rotation, color)
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

    /// A ball joint about which B may swing from the first direction, in the middle of its reach, while it lies along the
    /// second, and twist from where it is.
    fn swing(&mut self, [a, b]: [usize; 2], at: DVec3, directions: [DVec3; 2], Reach(swing, twist): Reach) {
        let [middle, along] = directions.map(|direction| self.facing * direction);
        let (a, b) = (&self.scene.bodies[a], &self.scene.bodies[b]);
        let axes = JointAxes::Bodies(a.rotation.inverse() * middle, b.rotation.inverse() * along);
        let limits = LimitSpec { swing: Some(swing), min: -twist, max: twist, restitution: 0.0 };
        let joint = JointSpec { axes, limits: Some(limits), ..JointSpec::at(a, b, self.world(at)) };
        self.scene.joints.push(joint);
    }

    /// A hinge between limbs along those directions, whose angle is zero where they are straight. It bends about what is
    /// across both, or, where they are straight, about that axis of a limb that hangs.
    fn bend(&mut self, [a, b]: [usize; 2], at: DVec3, directions: [DVec3; 2], axis: DVec3) {
        let (a, b) = (&self.scene.bodies[a], &self.scene.bodies[b]);
        let [upper, lower] = directions.map(|direction| self.facing * direction.normalize());
        let across = upper.cross(lower).try_normalize().filter(|_| upper.cross(lower).length() > 1e-3);
        let axis = across.unwrap_or_else(|| a.rotation * axis);
        let frame = |along: DVec3| DQuat::from_mat3(&DMat3::from_cols(axis, along, axis.cross(along)));
        let axes = JointAxes::Frames(a.rotation.inverse() * frame(upper), b.rotation.inverse() * frame(lower));
        let joint = JointSpec { axes, ..JointSpec::of_kind(JointKindSpec::Hinge, a, b, self.world(at)) };
        let [min, max] = BEND;
        self.scene.joints.push(joint.with_range(min, max));
    }

    fn world(&self, point: DVec3) -> DVec3 {
        self.pelvis + self.facing * (point * self.scale)
    }
}
