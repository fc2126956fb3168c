//! The 2009 engine's way to contacts: bounding spheres swept and sorted, one separating axis test over a set of axes,
//! and extreme vertices for points.

pub(super) mod extreme_vertices;
mod placed;
pub(super) mod sat;
pub(super) mod sweep_and_sort;
pub(super) mod vector_set;
