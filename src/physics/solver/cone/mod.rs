//! Contact exactly: impulses λ that obey Signorini's condition, Coulomb's cone, the joints and bounded rows of one island to
//! rounding, not to a number of iterations. No components here: bodies, points and numbers.
//!
//! # The problem
//! v = v_free + M⁻¹Jᵀλ, u = J v + b at each point; joints: u = 0; contacts: K* ∋ u + μ|u_t| n ⊥ λ ∈ K ([`law`]). This
//! is Coulomb's law itself, not the associated one that a quadratic program gives, whose sliding bodies take off at the
//! angle atan μ.
//!
//! # Unknowns
//! With L Lᵀ = M⁻¹ by body, Ĵ = J L and z = Ĵᵀλ: v = v_free + L z, u = Ĵ z + c, c = J v_free + b. Locked axes are zero
//! columns of L, mass ratios stay out of the scale, and every linear system is (1 + ĴᵀD Ĵ) x = r with one 3×3 block D a
//! point: sparse as the graph of the bodies, however many points two of them share ([`linear`]). z is summed anew from
//! λ at each step, so that the residual reported is that of λ alone.
//!
//! # The way to λ
//! 1. Semismooth Newton iterations on the natural map ([`newton`]): from the last step's λ, two or three do (Alart &
//!    Curnier 1991; the map as in Acary, Brémond & Huber 2018).
//! 2. If they do not: proximal points ([`proximal`]). A compliance ε/ρ is given to each point about its present λ: the
//!    problem of the compliant points is well conditioned and unique, redundant points or not; Newton's method finds
//!    its λ, from which the next starts, with less compliance (Le Lidec, Montaut & Carpentier 2024 take the same way
//!    with ADMM).
//! 3. From no guess, or if that stalls: an interior point ([`interior`]), which tells touching from parting points in
//!    twenty or so steps whatever the size (as Acary, Armand, Nguyen & Shpakovych 2023), then 1 and 2.
//!
//! All are bounded. What is best when the bounds are met is what is returned, with its residual.

mod constants;
mod interior;
mod iterate;
mod law;
mod linear;
mod newton;
mod point;
mod problem;
mod proximal;
mod second_order_cone;
mod solver;

#[cfg(test)]
pub(crate) mod problems;
#[cfg(test)]
mod tests;

use iterate::Iterate;
use law::{Law, Mode};
use point::{ConePoint, root};
use problem::{ConeOutcome, Velocity, relative_velocity};

use super::linear::{BlockLdl, BlockLu, BodyBlock, BodyVector, Elimination, Inverse};
pub(crate) use problem::{ConeBody, ConeContact, ConeEnd, ConeJoint, PerPoint, PointJacobian};
pub(crate) use solver::ConeSolver;
