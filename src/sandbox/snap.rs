//! The grid to which places and angles go while things are put by hand.

use std::f64::consts::PI;

use bevy::math::DVec3;
use bevy::prelude::*;

use super::state::is_control_held;

/// Whether what is put by hand goes to a grid, and to which; Ctrl turns it round for as long as it is held.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Snap {
    /// Whether it does without Ctrl.
    pub is_on: bool,
    /// Multiples of what coordinates and sizes are, m.
    pub grid: f64,
    /// Multiples of what turns are, degrees.
    pub degrees: f64,
}

impl Default for Snap {
    fn default() -> Self {
        Self { is_on: false, grid: 0.1, degrees: 15.0 }
    }
}

impl Snap {
    /// Grids that can be set, m and degrees.
    pub const GRIDS: std::ops::RangeInclusive<f64> = 0.001..=10.0;
    /// As [`Self::GRIDS`].
    pub const TURNS: std::ops::RangeInclusive<f64> = 1.0..=90.0;

    /// The multiple of the grid that is nearest to a length, m.
    pub fn length(&self, length: f64) -> f64 {
        (length / self.grid).round() * self.grid
    }

    /// The corner of the grid that is nearest to a place, m.
    pub fn place(&self, place: DVec3) -> DVec3 {
        DVec3::from_array(place.to_array().map(|coordinate| self.length(coordinate)))
    }

    /// The multiple of the angle that is nearest to an angle, rad.
    pub fn angle(&self, angle: f64) -> f64 {
        let step = self.degrees * PI / 180.0;
        (angle / step).round() * step
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Snap>();
}

/// The grid, if it is snapped to now.
pub(super) fn snap_of(world: &World) -> Option<Snap> {
    let snap = world.get_resource::<Snap>()?;
    let turned = world.get_resource::<ButtonInput<KeyCode>>().is_some_and(is_control_held);
    (snap.is_on != turned).then_some(*snap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_snapped_is_a_multiple() {
        let snap = Snap { grid: 0.25, degrees: 30.0, ..default() };
        assert_eq!(snap.place(DVec3::new(0.3, -0.4, 1.12)), DVec3::new(0.25, -0.5, 1.0));
        assert!((snap.angle(0.8) - PI / 3.0).abs() < 1e-12 || (snap.angle(0.8) - PI / 6.0).abs() < 1e-12);
        assert!((snap.angle(0.8) - 2.0 * PI / 6.0 * 0.5 * 2.0).abs() < 1e-12, "46 degrees are nearer to 60 than to 30");
    }
}
