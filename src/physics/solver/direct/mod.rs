//! Islands solved at once, all contacts and joints together, directly: at rest, for the whole step ([`rest`]); in
//! motion, where there are joints ([`motion`]) or loads that sweeps would not pass on in time ([`loaded`]), substep by
//! substep.
//!
//! Sweeps pass a load on from contact to contact, and springs that sweeps can follow give under it: a column of 30
//! cubes sinks by centimetres and leans, a light box under a heavy one is crushed. Where all is at rest and the body
//! graph is a tree or nearly one, the step
//!
//! (M + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b)
//!
//! is solved by block LDLᵀ in f64 ([`linear`](super::linear), on the graph of the bodies), in a time linear in its bodies;
//! [`rows`] tells what a constraint's rows are, [`contact`] and [`joint`] those there are, [`island`] the solve. Which
//! points have an impulse and which contacts slide is taken from the step before and corrected by active-set
//! iterations, of which a step at rest takes one. The same factor then corrects depths and gaps, in positions and not in
//! velocities.
//!
//! The factor is kept for as long as the same rows are active in the same place, so that a wall that stands costs two
//! substitutions a step; and where the step changes nothing any more, it need not be solved for until somebody else
//! changes something.
//!
//! Islands of joints alone are solved by the impulses of their rows ([`dual`]), or, where they are trees of points, hinges
//! and rigid joints, and as long as no limit is met, by [`articulated`] inertias.
//!
//! An island that turns out not to rest, or whose iterations do not end, is left as it was, for the sweeps.

mod any_joint;
mod articulated;
mod constants;
mod contact;
mod dual;
mod island;
mod joint;
mod loaded;
mod loads;
mod motion;
mod posture;
mod rest;
mod rows;
mod snapshot;
#[cfg(test)]
mod tests;
mod world;

pub(crate) use island::DirectIsland;
pub(crate) use loads::LoadAccount;
pub(crate) use motion::MotionTerms;
pub(crate) use rest::Outcome;
pub(crate) use world::World;
