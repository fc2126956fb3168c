//! Which bodies are near each other: a tree of boxes a little larger than their bodies, and the pairs that last as long
//! as these overlap.

pub(super) mod bounding_tree;
pub(super) mod fat_box;
pub(super) mod in_step;
pub(super) mod near_pairs;
pub(super) mod pair_slots;
mod part_pairs;
pub(super) mod persistent_pairs;
#[cfg(test)]
mod tests;
