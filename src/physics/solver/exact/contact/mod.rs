//! Contact exactly: Signorini's condition and Coulomb's cone at the end of each step, in positions and in velocities,
//! with joints in the same system; impacts at their times.
//!
//! [`contact_group`] takes bodies in reach of each other through a step: joints that somebody left apart
//! ([`joint_gaps`]), contact points ([`gap_points`]), impacts ([`impacts`]) and steps between them ([`smooth_step`], which
//! follows points by [`held_points`] and mixes its forecasts by [`mixing`]), up to where something lands ([`landing`]), or is half
//! through something ([`crossings`]). All solve by the cone solver ([`group_solver`], set to [`posed_rows`]); what points carry is added up ([`point_loads`]). Where
//! nothing moves any more, a step is the last one again ([`rest`]). The hardest of these solves are kept for whoever wants
//! them ([`hardest_solve`]).

mod contact_group;
mod crossings;
mod gap_points;
mod group_solver;
mod hardest_solve;
mod held_points;
mod impacts;
mod joint_gaps;
mod landing;
mod limit_rows;
mod mixing;
mod point_loads;
mod posed_rows;
mod rest;
mod smooth_step;

pub(crate) use contact_group::PointForce;
pub(super) use contact_group::{ContactGroup, ContactTerms};
pub(super) use group_solver::GroupView;
pub(super) use joint_gaps::JointGaps;
