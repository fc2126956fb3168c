//! One slot for each pair of bodies that are near each other, kept for as long as they are.
//!
//! Where manifolds are found anew in each step, by force-level sweeps and the exact method, a slot keeps which features
//! touch and what they [`Carried`](graph::Carried). All others have contacts that last: a slot's manifold is found
//! again only when the two bodies have moved against each other by more than
//! [`FLAT_RECYCLING`](super::constants::FLAT_RECYCLING) of the smaller one's size since it was found, or
//! [`ROUND_RECYCLING`](super::constants::ROUND_RECYCLING) where one is curved and may roll; until then its
//! points, fixed to either body, move along with them, which is exact to first order. Impulses stay with the slot and
//! are matched by feature when the manifold is found again.

mod balls;
mod behind_impacts;
pub(super) mod export;
pub(super) mod graph;
pub(super) mod record;
pub(super) mod slot;
mod watch;
