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
//! 1. Semismooth Newton iterations ([`newton`]) with next to no compliance: from the last step's λ, two or three do.
//! 2. If they do not: proximal points ([`proximal`]). A compliance ε/ρ is given to each point about its present λ: the
//!    problem of the compliant points is well conditioned and unique, redundant points or not; the same iterations find its
//!    λ, from which the next starts, with less compliance.
//!
//! Both are bounded. What is best when the bounds are met is what is returned, with its residual; where time is over, after
//! sweeps of Gauss–Seidel over it.
//!
//! # What else was tried
//! On 180 saved problems of heaps, limbs and piles. An interior point (Nesterov & Todd's scaling, Mehrotra's correction, the
//! shift of the law taken from the step before) took thirty steps, and what followed converged no sooner than without it.
//! Proximal points of the projection on the cone took a fifth more time than those of Alart & Curnier's map: its derivative
//! by the shift jumps where points stick. With λ eliminated, λ = C(λ_k − (ρ/ε) u), they took twice the time. With the shift
//! held in each of them (a convex problem, a symmetric matrix) those of boxes at rest did not converge. A line search that
//! insists on less |F| took half as many iterations again. Gauss–Seidel sweeps between proximal points gained nothing, nor did
//! hundreds of them after the last: of 264 problems that stop just above 1e-8 m/s they bring two below. With the least
//! compliance at joints throughout, `limbs` took nine times as long.
//!
//! Parts of a problem that no point couples could be solved each by itself. In the 948 of two heaps of 140 boxes and hulls that
//! take 30 iterations or more, one such part has 0.95 of all points in the mean, and 0.81 of those that carry something.
//!
//! On some 1200 smooth steps of heaps: proximal points about λ extrapolated from the two before took 1.01 to 1.06 of the time; to
//! give up a point after two poor iterations instead of three 1.05. Of a factorisation 0.85 is left where the blocks of points
//! that did not change are kept.
//!
//! Where iterations fail late, one to twenty of some 600 points are far off and all others are not (two heaps' problems, looked
//! at closely). Nothing was gained by it: of 103 hard problems 80 are solved to 1e-8 m/s within 0.12 or 0.15 s. With more
//! compliance at such points alone, instead of at all points, 70 are, since others are far off in the next iterations. With
//! sweeps of Gauss–Seidel over such points after a poor iteration 65 to 70 are: these halve the time of small heaps' problems,
//! but `wrecking_ball` has six to eight times as many parts of steps that are not settled.

mod constants;
mod deadline;
mod iterate;
mod law;
mod linear;
mod newton;
mod point;
mod problem;
mod proximal;
mod solver;

#[cfg(test)]
pub(crate) mod problems;
#[cfg(test)]
mod tests;

use iterate::Iterate;
use law::Law;
use point::{ConePoint, root};
use problem::{Velocity, relative_velocity};

use super::linear::{BlockLdl, BlockLu, BodyBlock, BodyVector, Elimination, Inverse};
pub(crate) use deadline::Deadline;
pub(crate) use problem::{ConeBody, ConeContact, ConeEnd, ConeJoint, ConeOutcome, PerPoint, PointJacobian};
pub(crate) use solver::ConeSolver;
