//! What a joint holds, whatever its kind.
//!
//! A joint has a frame in each of its bodies. Six coordinates tell where frame B is, seen from frame A: the three
//! translations of its origin along A's axes, and its rotation, which is a swing (about an axis across A's x) after a
//! twist (about x). All are zero where the frames agree. Laws say what becomes of them: of each coordinate, or of the
//! norm of a group, the translations or the rotations. A part that a law lacks costs nothing. What is held stands in
//! [`Laws`]; limits, motors, springs and friction are [laws of single coordinates](super::law), as many as one likes.
//!
//! Solvers take a joint in [pieces](JointDefinition::pieces): what it holds, then its laws, two at a time.
//!
//! [`rows`](super::rows) makes rows of it, which is all that a solver knows of a joint.

use std::sync::Arc;

use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::constraint::RowFunction;
use super::law::{CoordinateLaw, JointAxis, LawPart};
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
    /// Laws of single coordinates.
    pub laws: Option<Arc<[CoordinateLaw]>>,
    /// The coordinate that limits, a motor and friction beside it act on.
    pub axis: Option<JointAxis>,
    /// The twist is the value nearest to this one, rad.
    pub turned: f64,
    /// Whether the joined bodies collide with each other.
    pub collide: bool,
}

/// How many laws a piece has: each is a half of it.
const LAWS: usize = 2;

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

/// What a joint holds that holds a point at a point rigidly, has no law of a single coordinate, and no spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointHolds {
    /// The point alone.
    Point,
    /// And the frames' x axes parallel: a hinge.
    Axis,
    /// And all rotations.
    All,
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
            laws: None,
            axis: None,
            turned: 0.0,
            collide: false,
        }
    }
}

impl JointDefinition {
    /// Whether it holds all translations and nothing else.
    pub fn is_ball(&self) -> bool {
        self.function.is_none()
            && self.laws.is_none()
            && [self.translation.hold, self.rotation.hold] == [Laws::LOCKED.hold, Laws::FREE.hold]
    }

    /// What it holds beside a point, if it does nothing else.
    pub fn holds(&self) -> Option<JointHolds> {
        let is_rigid = self.translation == Laws::LOCKED && self.rotation.spring.is_none();
        if !is_rigid || self.function.is_some() || self.laws.is_some() {
            return None;
        }
        match self.rotation.hold {
            [Hold::Free, Hold::Free, Hold::Free] => Some(JointHolds::Point),
            [Hold::Free, Hold::Locked, Hold::Locked] => Some(JointHolds::Axis),
            [Hold::Locked, Hold::Locked, Hold::Locked] => Some(JointHolds::All),
            _ => None,
        }
    }

    /// Whether it holds nothing and does nothing but keep coordinates within limits.
    pub fn only_limits(&self) -> bool {
        let is_limit = |law: &CoordinateLaw| matches!(law.part, LawPart::Limit { .. });
        self.function.is_none()
            && self.translation.locked() + self.rotation.locked() == 0
            && self.laws.as_ref().is_some_and(|laws| laws.iter().all(is_limit))
    }

    /// What solvers take as joints of their own: what it holds, if that is something, then its laws, two at a time.
    pub fn pieces(self) -> impl Iterator<Item = Self> {
        let laws = self.laws.clone();
        let frames_only = Self { function: None, translation: Laws::FREE, rotation: Laws::FREE, ..self.clone() };
        let holds = self.function.is_some() || self.translation.locked() + self.rotation.locked() > 0;
        let count = laws.as_ref().map_or(0, |laws| laws.len().div_ceil(LAWS));
        let of_laws = move |index: usize| {
            let all = laws.as_deref().unwrap_or_default();
            let own = &all[LAWS * index..all.len().min(LAWS * (index + 1))];
            Self { laws: Some(own.into()), ..frames_only.clone() }
        };
        holds.then_some(Self { laws: None, ..self }).into_iter().chain((0..count).map(of_laws))
    }

    /// How many rows engines solve at once, at most three, and how many after them: translations, then rotations; or
    /// one law, and the other. A user's own rows are not counted before they are told: three, and up to three.
    pub fn halves(&self) -> [usize; 2] {
        if let Some(laws) = &self.laws {
            return [1, laws.len() - 1];
        }
        match (&self.function, self.translation.locked(), self.rotation.locked()) {
            (Some(_), ..) => [3, 3],
            (None, 0, rotations) => [rotations, 0],
            (None, translations, rotations) => [translations, rotations],
        }
    }

    /// Whether one of the [`halves`](Self::halves) is a spring.
    pub fn is_soft_half(&self, half: usize) -> bool {
        if let Some(laws) = &self.laws {
            return laws[half].is_spring();
        }
        let laws = if half == 0 && self.translation.locked() > 0 { &self.translation } else { &self.rotation };
        laws.spring.is_some() && self.function.is_none()
    }

    /// Whether some of it is a spring.
    pub fn is_soft(&self) -> bool {
        [&self.translation, &self.rotation].iter().any(|laws| laws.spring.is_some() && laws.locked() > 0)
            || self.laws.iter().flat_map(|laws| laws.iter()).any(CoordinateLaw::is_spring)
    }

    /// Whether its rows may change with time alone.
    pub fn is_driven(&self) -> bool {
        self.function.is_some() || self.laws.iter().flat_map(|laws| laws.iter()).any(CoordinateLaw::is_driven)
    }

    /// Whether it may do work on its bodies: limits, friction and what is held rigidly take energy alone.
    pub fn may_do_work(&self) -> bool {
        let mut laws = self.laws.iter().flat_map(|laws| laws.iter());
        self.is_driven() || self.is_soft() || laws.any(CoordinateLaw::may_lag)
    }

    /// Whether pieces have the same rows but for the numbers of their laws.
    pub fn is_alike(&self, other: &Self) -> bool {
        let holds = |joint: &Self| (joint.translation, joint.rotation, joint.function.is_some());
        let [own, others] = [self, other].map(|joint| joint.laws.as_deref().unwrap_or_default());
        holds(self) == holds(other)
            && own.len() == others.len()
            && own.iter().zip(others).all(|(one, other)| one.is_alike(other))
    }

    /// Whether all its numbers make sense.
    pub fn is_valid(&self) -> bool {
        let springs = [self.translation.spring, self.rotation.spring];
        self.frames.iter().all(Frame::is_finite) && springs.iter().flatten().all(Softness::is_valid)
    }
}
