//! Constraints as rows. A constraint knows geometry and makes [`row::Row`]s; a solver knows rows.
//!
//! One file a constraint: [`ball_joint`]; contacts have their own folder, [`super::contact`].

pub(crate) mod ball_joint;
pub(crate) mod row;

#[cfg(test)]
mod tests;
