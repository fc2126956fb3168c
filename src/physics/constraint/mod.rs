//! Constraints as rows. A constraint knows geometry and makes [`row::Row`]s; a solver knows rows.
//!
//! One file a constraint: [`contact`] (non-penetration and friction), [`ball_joint`].

pub(crate) mod ball_joint;
pub(crate) mod contact;
pub(crate) mod row;

#[cfg(test)]
mod tests;
