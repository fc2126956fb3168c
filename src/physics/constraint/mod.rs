//! Constraints as rows. A constraint knows geometry and makes [`row::Row`]s; a solver knows rows.
//!
//! Rows of contacts are in [`super::contact`], of joints in [`super::joint`].

pub(crate) mod row;

#[cfg(test)]
mod tests;
