//! Work split over Bevy's compute pool, whose threads stay awake from phase to phase ([`crew`]).

mod blocks;
mod claims;
mod crew;
mod shared;
mod spin;
mod stages;
mod workers;

pub(crate) use blocks::{for_each_block, for_each_of};
pub(crate) use claims::{Claims, Division};
pub(crate) use shared::Shared;
pub(crate) use stages::Stages;
