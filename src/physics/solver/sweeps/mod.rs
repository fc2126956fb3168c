//! Sweeps over force-level rows, as the 2009 engine solves them.
//!
//! A substep, whatever the method: rows from the present poses ([`rows`]) → the method's solve
//! (one file each: [`pgs`], [`cg_pgs`], [`nncg`], [`joint_space`]) → integration ([`integrator`]), at whose end poses may
//! be moved out of their errors ([`projection`]).

mod cg_pgs;
mod conjugate_residuals;
mod integrator;
mod island_solver;
mod joint_space;
mod local;
mod nncg;
mod pgs;
mod projection;
mod rows;
mod solve;
mod step_terms;
mod sweep_trace;
#[cfg(test)]
mod tests;

pub(crate) use solve::IslandSolvers;
pub(super) use solve::plugin;
