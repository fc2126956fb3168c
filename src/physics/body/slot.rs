//! Where a body stands in the packed arrays, and what it was gathered with.

use bevy::prelude::*;

/// Where the body stands in the solver's packed arrays.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct BodySlot {
    /// Index; `u32::MAX` until the body's first step.
    pub index: u32,
    /// Bodies are packed in this order, which no change of components disturbs.
    pub born: u64,
}

impl Default for BodySlot {
    fn default() -> Self {
        Self { index: u32::MAX, born: 0 }
    }
}

/// The optional components that a body was last gathered with, as [`Presence`] has them. Apart from the slot: it is read of
/// every body in every step.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GatheredWith(pub u32);

impl GatheredWith {
    /// Of a body without a place, and of one that must be gathered whatever was or was not written to it.
    pub const NOTHING: Self = Self(u32::MAX);
}

impl Default for GatheredWith {
    fn default() -> Self {
        Self::NOTHING
    }
}

/// Numbers bodies and joints in the order in which they are made.
#[derive(Resource, Default, Clone)]
pub(crate) struct BirthCounter(u64);

impl BirthCounter {
    pub fn next(&mut self) -> u64 {
        self.0 += 1;
        self.0
    }

    /// The last number that was given.
    #[cfg(feature = "lab")]
    pub fn last(&self) -> u64 {
        self.0
    }

    /// That number counts as given.
    #[cfg(feature = "lab")]
    pub fn give(&mut self, number: u64) {
        self.0 = self.0.max(number);
    }
}

/// The optional components of a body, one bit each.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Presence(pub u32);

impl Presence {
    const DENSITY: u32 = 1 << 1;
    const SLEEPING: u32 = 1 << 13;

    /// The same body asleep or awake.
    pub fn with_sleeping(self, sleeping: bool) -> Self {
        Self(if sleeping { self.0 | Self::SLEEPING } else { self.0 & !Self::SLEEPING })
    }

    /// Whether the body lost its density.
    pub fn lost_density(self, before: GatheredWith) -> bool {
        before != GatheredWith::NOTHING && before.0 & !self.0 & Self::DENSITY != 0
    }
}
