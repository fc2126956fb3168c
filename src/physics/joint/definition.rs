//! What a joint holds, whatever its kind.
//!
//! A joint has a frame in each of its bodies. Six coordinates tell where frame B is, seen from frame A: the three
//! translations of its origin along A's axes, and its rotation, which is a swing (about an axis across A's x) after a
//! twist (about x). All are zero where the frames agree. Laws say what becomes of them: of each coordinate, or of the
//! norm of a group, the translations or the rotations. A part that a law lacks costs nothing.
//!
//! [`rows`](super::rows) makes rows of it, which is all that a solver knows of a joint.

use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::constraint::RowFunction;
use super::slot::{JointSlot, number_joint};
use super::softness::Softness;

/// A joint's bodies, frames and laws. The component that a joint kind's is the builder of, beside it on its entity.
#[derive(Component, Clone, Debug)]
#[component(on_add = number_joint)]
#[require(JointSlot)]
pub(crate) struct JointDefinition {
    pub bodies: [Entity; 2],
    pub frames: [Frame; 2],
    /// Of x, y and z.
    pub translation: Laws,
    /// Of the twist and of the swings about y and z.
    pub rotation: Laws,
    /// Rows of a user's own instead of laws.
    pub function: Option<RowFunction>,
    /// Whether the joined bodies collide with each other.
    pub collide: bool,
}

/// A frame fixed to a body, in the body's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// From the centre of mass, m.
    pub anchor: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

/// What becomes of a group of three coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Laws {
    pub hold: [Hold; 3],
    /// Holds what is locked by a spring instead, whose largest force bounds the norm over the group.
    pub spring: Option<Softness>,
}

/// What becomes of one coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Hold {
    #[default]
    Free,
    /// Kept at zero.
    Locked,
}

impl Frame {
    /// A frame with the axes of its body.
    pub fn at(anchor: impl Into<Vector3<f64>>) -> Self {
        Self { anchor: anchor.into(), rotation: UnitQuaternion::identity() }
    }

    fn is_finite(&self) -> bool {
        self.anchor.iter().chain(self.rotation.coords.iter()).all(|number| number.is_finite())
    }
}

impl Laws {
    pub const FREE: Self = Self { hold: [Hold::Free; 3], spring: None };
    pub const LOCKED: Self = Self { hold: [Hold::Locked; 3], spring: None };

    /// How many coordinates are locked.
    pub fn locked(&self) -> usize {
        self.hold.iter().filter(|&&hold| hold == Hold::Locked).count()
    }
}

impl Default for JointDefinition {
    /// Holds nothing.
    fn default() -> Self {
        Self {
            bodies: [Entity::PLACEHOLDER; 2],
            frames: [Frame::at(Vector3::zeros()); 2],
            translation: Laws::FREE,
            rotation: Laws::FREE,
            function: None,
            collide: false,
        }
    }
}

impl JointDefinition {
    /// Whether it holds all translations and nothing else.
    pub fn is_ball(&self) -> bool {
        self.function.is_none() && [self.translation.hold, self.rotation.hold] == [Laws::LOCKED.hold, Laws::FREE.hold]
    }

    /// How many rows engines solve at once, at most three, and how many after them: translations, then rotations.
    /// A user's own rows are not counted before they are told: three, and up to three.
    pub fn halves(&self) -> [usize; 2] {
        match (&self.function, self.translation.locked(), self.rotation.locked()) {
            (Some(_), ..) => [3, 3],
            (None, 0, rotations) => [rotations, 0],
            (None, translations, rotations) => [translations, rotations],
        }
    }

    /// The spring that one of the [`halves`](Self::halves) is.
    pub fn spring_of(&self, half: usize) -> Option<Softness> {
        let laws = if half == 0 && self.translation.locked() > 0 { &self.translation } else { &self.rotation };
        laws.spring.filter(|_| self.function.is_none())
    }

    /// Whether some of it is a spring.
    pub fn is_soft(&self) -> bool {
        [&self.translation, &self.rotation].iter().any(|laws| laws.spring.is_some() && laws.locked() > 0)
    }

    /// Whether all its numbers make sense.
    pub fn is_valid(&self) -> bool {
        let springs = [self.translation.spring, self.rotation.spring];
        self.frames.iter().all(Frame::is_finite) && springs.iter().flatten().all(Softness::is_valid)
    }
}
