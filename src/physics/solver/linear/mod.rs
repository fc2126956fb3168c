//! Sparse block factorisation, which [`direct`](super::direct), [`exact`](super::exact) and [`cone`](super::cone) share.
//!
//! It comes in two halves. [`Elimination`] is the symbolic one: the order of elimination and the blocks of the factor
//! that are not zero, found once for a graph. [`BlockLdl`] (symmetric matrices) and [`BlockLu`] (matrices whose pattern
//! alone is symmetric) are the numeric ones: they factor as often as the values change, on the structure found, without
//! allocation. Blocks have 1 to 6 rows; where all have 3 or all have 6, the loops are compiled for that size.
//!
//! # Semidefinite matrices
//! Redundant constraints make singular matrices. What happens then is up to the user of the factorisation:
//! - [`Inverse`] pivots refuse a block on the diagonal that is not positive definite: `direct` then leaves its island to
//!   the sweeps, and `cone` takes another kind of step. Both add a mass or an identity to the diagonal beforehand, so
//!   that redundant rows are no trouble.
//! - [`Triangular`] pivots drop a row whose pivot is not positive: its unknown becomes zero. `exact` adds a share of
//!   the trace to each block on the diagonal first where rows may be redundant (of their rows of one unit; where all
//!   have one, [`BlockLdl::shift`] does), and takes the error of that back by the method of multipliers: λ ← λ + (A + E)⁻¹(b − A λ) (Hestenes 1969; Powell 1969; as
//!   proximal point iteration Rockafellar 1976; Carpentier, Budhiraja and Mansard 2021, "Proximal and sparse
//!   resolution of constrained dynamics"). Each iteration divides the error along an eigenvector of eigenvalue σ by
//!   1 + σ/E, and where σ = 0 the error stays zero, so that λ is the least one that gives the same motion.
//!
//! `joint_tree` keeps a recursion of its own: it factors without forming the couplings of all joints of one body.

mod elimination;
mod layout;
mod ldl;
mod lu;
mod ordering;
mod pivot;
#[cfg(test)]
mod tests;

pub(crate) use elimination::Elimination;
pub(crate) use layout::{BodyBlock, BodyVector, Number};
pub(crate) use ldl::BlockLdl;
pub(crate) use lu::BlockLu;
pub(crate) use pivot::{Inverse, Triangular};
