//! Bodies that move farther in a step than they are thick: where they first touch, and what holds them back.

pub(super) mod fast_pair;
pub(super) mod hold_back;
pub(super) mod mechanisms;
pub(super) mod thrown;
pub(super) mod time_of_impact;
