//! What runs may differ in: one setting or one parameter of the scene at a time.
//!
//! There is one way to say it, on the command line, in the atlas of maps and in the panel: an [`Assignment`] is
//! `baumgarte=0.2`, a [`Variation`] `baumgarte=0.1:1:log:9` or `contacts=single_point,clipping`. What a setting may be
//! comes from the table of [`SETTINGS`](crate::physics::SETTINGS) alone, so that a new one needs no code here. A
//! [`Study`] puts variations on top of a scene and of the settings that are compared, and `curves` draws those of one
//! variation; those of two are a [`map`](super::map).

mod assignment;
mod curves;
mod measure;
mod study;
mod variation;

pub use assignment::{Assignment, Value, VaryError};
pub use curves::{Curve, Curves};
pub use measure::{MEASURES, Measure};
pub(in crate::lab) use study::write;
pub use study::{Candidate, Study};
pub use variation::{MOST_VALUES, Scale, Variation};
