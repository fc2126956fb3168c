//! Fingerprints: whether two worlds are the same to the last bit, and if not, which body differs.

use std::fmt::Write;
use std::hash::Hasher;

use bevy::prelude::*;
use xxhash_rust::xxh3::Xxh3;

use super::numbers::Numbers;
use crate::lab::simulation::state_hash;
use crate::physics::{Position, Rotation, Velocity};

/// Bodies up to which each has a fingerprint of its own.
pub const MOST_BODIES: usize = 1000;

/// Of a world between two steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Print {
    /// Of all that the next step depends on.
    pub world: u64,
    /// Of the poses and velocities of the bodies, with 16 bits each, in the order of their numbers; none where they are
    /// more than [`MOST_BODIES`].
    pub bodies: Vec<u16>,
}

impl Print {
    /// As it is now.
    pub fn of(world: &World, numbers: &Numbers) -> Self {
        // One more than are told apart says that they are too many.
        let bodies: Vec<u16> = Self::bodies(world, numbers).map(|(_, print)| print).take(MOST_BODIES + 1).collect();
        Self { world: state_hash(world), bodies: if bodies.len() > MOST_BODIES { Vec::new() } else { bodies } }
    }

    /// Each body with its own.
    fn bodies<'a>(world: &'a World, numbers: &'a Numbers) -> impl Iterator<Item = (Entity, u16)> + 'a {
        numbers.entities().iter().filter_map(|&entity| {
            let (position, rotation) = (world.get::<Position>(entity)?.0, world.get::<Rotation>(entity)?.0);
            let velocity = world.get::<Velocity>(entity)?;
            let mut hasher = Xxh3::new();
            let vectors = [position, velocity.linear, velocity.angular].into_iter().flat_map(|v| v.to_array());
            vectors.chain(rotation.to_array()).for_each(|value| hasher.write_u64(value.to_bits()));
            Some((entity, hasher.finish() as u16))
        })
    }

    /// The first body that is another than when this was taken, if its own fingerprint tells.
    pub fn first_other(&self, world: &World, numbers: &Numbers) -> Option<Entity> {
        let now = Self::bodies(world, numbers);
        now.zip(&self.bodies).find(|((_, now), then)| now != *then).map(|((body, _), _)| body)
    }

    /// As text: of the world with 16 digits, then of each body with 4.
    pub(super) fn text(&self) -> String {
        let mut text = format!("{:016x} ", self.world);
        self.bodies.iter().for_each(|body| write!(text, "{body:04x}").expect("a string takes all"));
        text
    }

    /// From its text.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (world, bodies) = text.split_once(' ')?;
        let digits = bodies.as_bytes();
        let body = |digits: &[u8]| u16::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok();
        let bodies: Option<Vec<u16>> = digits.chunks(4).map(body).collect();
        let world = u64::from_str_radix(world, 16).ok()?;
        (digits.len().is_multiple_of(4)).then_some(Self { world, bodies: bodies? })
    }
}
