//! Ball joints that form trees, solved exactly in linear time, in velocity and in position.
//!
//! A joint between a and b asks C = x_b + r_b − x_a − r_a = 0 and J V = 0 with
//! J = [−1, [r_a]×, 1, −[r_b]×]. All joints of a tree at once:
//!
//! J M⁻¹ Jᵀ λ = b − J V,  V⁺ = V + M⁻¹ Jᵀ λ.
//!
//! J M⁻¹ Jᵀ has one 3×3 block per joint and one per pair of joints that share a moving body. Joints
//! are eliminated from the leaves to the root, as in Baraff (1996, "Linear-time dynamics using
//! Lagrange multipliers"), but in the smaller system of the joints alone (block L D Lᵀ):
//! - a body with two joints i, j (a *link*) fills nothing in: with E = J_j M⁻¹ J_iᵀ over that body,
//!   L = E D_i⁻¹ and D_j ← D_j − L Eᵀ. A chain is thus block tridiagonal;
//! - a body with more (a *hub*) would fill in a block per pair of them. Instead the hub carries N,
//!   its 6×6 inverse mass under the joints eliminated so far, and each joint takes its share away
//!   (the covariance update of the Kalman filter; the inverse of Featherstone's articulated inertia):
//!   D_i = … + J_i N J_iᵀ,  K = N J_iᵀ,  N ← N − K D_i⁻¹ Kᵀ. A joint costs the same on a hub of
//!   three as on one of a thousand.
//!
//! Only M⁻¹ appears, so locked axes (zero inverse mass) need no special case. A pivot that
//! cancellation has left without a significant digit belongs to a redundant row: its multiplier
//! stays zero, the rows before it having fixed that motion already.
//!
//! The root is the middle of the tree, and joints are eliminated level by level: the two halves of
//! a chain are then independent sequences that a processor overlaps.
//!
//! **A substep** that neither gains nor loses energy where it resolves the motion, with one
//! factorisation (that of the pose at the end of the substep before):
//! 1. [`JointTree::aim`] at the end of the drift, [`JointTree::damp`], v ← v + h g, free rotation;
//! 2. [`JointTree::clear_impulses`], then [`JointTree::solve_velocities`], in turn with contacts;
//! 3. drift;
//! 4. arms and inertias of the new pose, [`JointTree::stiffen`], [`JointTree::factor`];
//! 5. [`JointTree::project_positions`], once is enough; V ← V + ΔX/h. If `stiffen` returned more than
//!    [`UNRESOLVED`], step 4 again; or its arms alone and step 2 twice, the second time for what the factor misses.
//!
//! This is SHAKE (Ryckaert, Ciccotti and Berendsen 1977) as a velocity solver sees it: leapfrog, with
//! velocities half a substep behind the poses.
//!
//! **Which joints qualify.** The moving bodies of a component must form a tree. Bodies that do not
//! move do not connect: each joint to one is a leaf of its own (a *pin*), so that a component may
//! be pinned any number of times and J M⁻¹ Jᵀ keeps its structure. With one pin or none all rows are
//! independent; with more they may be redundant ([`JointTree::may_be_redundant`]): always when one
//! body has two pins, else where the bodies between two pins are stretched straight. Components
//! with a loop of moving bodies are left to the caller.

mod constants;
mod factor;
mod position;
mod stiffness;
mod structure;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use constants::UNRESOLVED;
pub(crate) use factor::{cross_columns, cross_rows};
pub(crate) use position::PoseChange;
pub(crate) use stiffness::{StiffnessShares, add_stiffness};
pub(crate) use structure::{Partition, partition};
pub(crate) use tree::JointTree;
