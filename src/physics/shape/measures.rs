//! What a shape measures.

use bevy::math::DVec3;

/// Of a shape, by closed forms or integrals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measures {
    /// m³.
    pub volume: f64,
    /// Principal, of 1 kg spread evenly, m².
    pub moments: DVec3,
    /// Of the smallest sphere about the centre of mass that holds it, m.
    pub radius: f64,
}
