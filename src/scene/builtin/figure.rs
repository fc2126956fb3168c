//! A human-like figure of 16 bodies: boxes, a ball for the head, cones for hands, feet and hat,
//! joined by ball joints with a gap between parts, so that they can bend without meeting.

use bevy::math::{DQuat, DVec3};

use super::palette;
use crate::scene::{BodySpec, JointSpec, SceneSpec, ShapeSpec};

/// Bodies of a figure.
pub(super) const FIGURE_PARTS: usize = 16;

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

/// Linear and angular, of whatever is joined, 1/s: a ball joint has no friction, and a swing would
/// not end.
pub(super) const DAMPING: (f64, f64) = (0.2, 3.0);

/// From the soles of a figure of scale 1, its legs straight down, to the middle of its pelvis, m.
pub(super) fn soles_to_pelvis() -> f64 {
    FOOT.height + SHIN.size.y + THIGH.size.y + 6.0 * GAP + PELVIS.size.y / 2.0
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

/// A figure under construction; points are in its own axes from the middle of its pelvis, before
/// scaling.
pub(super) struct Figure<'a> {
    pub scene: &'a mut SceneSpec,
    pub name: &'static str,
    pub pelvis: DVec3,
    pub facing: DQuat,
    pub scale: f64,
}

impl Figure<'_> {
    /// Builds all 16 parts, the pelvis first.
    pub fn build(mut self, sides: [Side; 2], Clothes([shirt, sleeves, trousers, hat_color]): Clothes) -> Holds {
        let pelvis = self.box_part("pelvis", PELVIS, DVec3::ZERO, DQuat::IDENTITY, trousers);
        let waist = (PELVIS.size.y / 2.0 + GAP) * DVec3::Y;
        let chest_center = waist + (GAP + CHEST.size.y / 2.0) * DVec3::Y;
        let chest = self.box_part("chest", CHEST, chest_center, DQuat::IDENTITY, shirt);
        self.join(pelvis, chest, waist);
        let hat = self.head(chest, chest_center + (CHEST.size.y / 2.0 + GAP) * DVec3::Y, hat_color);

        let shoulder = DVec3::new(
            (CHEST.size.x + UPPER_ARM.size.x) / 2.0 + GAP,
            chest_center.y + (CHEST.size.y - UPPER_ARM.size.x) / 2.0,
            0.0,
        );
        let hip = DVec3::new(PELVIS.size.x / 4.0 + GAP, -PELVIS.size.y / 2.0 - GAP, 0.0);
        let mut hands = [0, 0];
        for (i, (word, mirror)) in [("left", 1.0), ("right", -1.0)].into_iter().enumerate() {
            let mirror = DVec3::new(mirror, 1.0, 1.0);
            let Side { upper_arm, forearm, thigh, shin } = sides[i];
            hands[i] = self.arm(word, chest, mirror * shoulder, [mirror * upper_arm, mirror * forearm], sleeves);
            self.leg(word, pelvis, mirror * hip, [mirror * thigh, mirror * shin], trousers);
        }
        Holds { chest, hat, hands }
    }

    /// Head and hat on the neck's joint of `chest`; returns the hat.
    fn head(&mut self, chest: usize, neck: DVec3, hat_color: [f32; 3]) -> usize {
        let center = neck + (GAP + HEAD_RADIUS) * DVec3::Y;
        let ball = ShapeSpec::Sphere { radius: HEAD_RADIUS * self.scale };
        let head = self.part("head", ball, HEAD_MASS, center, DQuat::IDENTITY, palette::SKIN);
        self.join(chest, head, neck);
        // The hat sits closer than the other parts.
        let crown = center + (HEAD_RADIUS + 0.4 * GAP) * DVec3::Y;
        let cone = ShapeSpec::Cone { radius: HAT.radius * self.scale, height: HAT.height * self.scale };
        let hat_center = crown + (0.4 * GAP + HAT.height / 4.0) * DVec3::Y;
        let hat = self.part("hat", cone, HAT.mass, hat_center, DQuat::IDENTITY, hat_color);
        self.join(head, hat, crown);
        hat
    }

    /// Returns the hand.
    fn arm(&mut self, side: &str, chest: usize, shoulder: DVec3, along: [DVec3; 2], sleeve: [f32; 3]) -> usize {
        let (upper, elbow) = self.limb(&format!("{side} upper arm"), chest, shoulder, along[0], UPPER_ARM, sleeve);
        let (lower, wrist) = self.limb(&format!("{side} forearm"), upper, elbow, along[1], FOREARM, palette::SKIN);
        self.cone_end(&format!("{side} hand"), lower, wrist, along[1], HAND, palette::SKIN)
    }

    fn leg(&mut self, side: &str, pelvis: usize, hip: DVec3, along: [DVec3; 2], trouser: [f32; 3]) {
        let (thigh, knee) = self.limb(&format!("{side} thigh"), pelvis, hip, along[0], THIGH, trouser);
        let (shin, ankle) = self.limb(&format!("{side} shin"), thigh, knee, along[1], SHIN, trouser);
        self.cone_end(&format!("{side} foot"), shin, ankle, DVec3::NEG_Y, FOOT, palette::SLATE);
    }

    /// A box along `direction` from a joint of `parent`; returns it and the joint at its far end.
    fn limb(
        &mut self,
        name: &str,
        parent: usize,
        joint: DVec3,
        direction: DVec3,
        part: BoxPart,
        color: [f32; 3],
    ) -> (usize, DVec3) {
        let direction = direction.normalize();
        let center = joint + (GAP + part.size.y / 2.0) * direction;
        let rotation = DQuat::from_rotation_arc(-DVec3::Y, direction);
        let limb = self.box_part(name, part, center, rotation, color);
        self.join(parent, limb, joint);
        (limb, joint + (2.0 * GAP + part.size.y) * direction)
    }

    /// A cone along `direction` whose apex is at a joint of `parent`.
    fn cone_end(
        &mut self,
        name: &str,
        parent: usize,
        joint: DVec3,
        direction: DVec3,
        part: ConePart,
        color: [f32; 3],
    ) -> usize {
        let direction = direction.normalize();
        let shape = ShapeSpec::Cone { radius: part.radius * self.scale, height: part.height * self.scale };
        let center = joint + (GAP + 0.75 * part.height) * direction;
        let cone = self.part(name, shape, part.mass, center, DQuat::from_rotation_arc(-DVec3::Y, direction), color);
        self.join(parent, cone, joint);
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

    fn join(&mut self, a: usize, b: usize, at: DVec3) {
        let joint = JointSpec::at(&self.scene.bodies[a], &self.scene.bodies[b], self.world(at));
        self.scene.joints.push(joint);
    }

    fn world(&self, point: DVec3) -> DVec3 {
        self.pelvis + self.facing * (point * self.scale)
    }
}
