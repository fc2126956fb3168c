//! Tables of numbers: references of this crate.

/// The rows under the header of a table with commas.
pub(super) fn rows(table: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    let number = |field: &str| field.parse().expect("a table of this crate");
    table.lines().skip(1).map(move |line| line.split(',').map(number).collect())
}
