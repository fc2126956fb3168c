//! What the colors mean.

use super::scale::{Rgb, Scale};

/// What the colors mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// The quantity.
    pub title: &'static str,
    /// Color by color.
    pub key: Key,
    /// What else is to be known, a line each.
    pub notes: Vec<String>,
}

/// Which color is what.
#[derive(Clone, Debug, PartialEq)]
pub enum Key {
    /// Numbers.
    Scale(Scale),
    /// Kinds.
    Chips(Vec<Chip>),
}

impl Default for Key {
    fn default() -> Self {
        Self::Chips(Vec::new())
    }
}

/// A color with what has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Chip {
    /// The color.
    pub color: Rgb,
    /// What has it.
    pub text: String,
}
