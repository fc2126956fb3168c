//! A hilly ground to build with.

use std::f64::consts::TAU;

use crate::scene::{ShapeSpec, SurfaceForm, SurfaceSpec};

/// A ground of waves along x and z, which ends level with its valleys: what rolls off it rolls on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hills {
    /// Along x and z, m.
    pub size: [f64; 2],
    /// Of the tops over the valleys, m.
    pub height: f64,
    /// From top to top along x and along z, m.
    pub wavelength: f64,
    /// Along each side, of two triangles each.
    pub squares: u32,
}

impl Default for Hills {
    fn default() -> Self {
        Self { size: [8.0; 2], height: 0.4, wavelength: 3.0, squares: 40 }
    }
}

impl Hills {
    /// Sizes and wavelengths, m.
    pub const SIZES: std::ops::RangeInclusive<f64> = 0.1..=1000.0;
    /// Heights, m.
    pub const HEIGHTS: std::ops::RangeInclusive<f64> = 0.01..=100.0;
    /// Squares along a side.
    pub const SQUARES: std::ops::RangeInclusive<u32> = 2..=200;

    /// Whether a shape is one.
    pub fn are(shape: &ShapeSpec) -> bool {
        matches!(shape, ShapeSpec::Surface(surface) if matches!(surface.form(), SurfaceForm::Heights { .. }))
    }

    /// Height over the valleys, m.
    fn height(&self, x: f64, z: f64) -> f64 {
        let wave = |along: f64| (TAU * along / self.wavelength).cos();
        // Falls to the rim within half a wavelength.
        let rim = |along: f64, size: f64| {
            let share = ((0.5 * size - along.abs()) / (0.5 * self.wavelength)).clamp(0.0, 1.0);
            share * share * (3.0 - 2.0 * share)
        };
        0.5 * self.height * (1.0 + wave(x) * wave(z)) * rim(x, self.size[0]) * rim(z, self.size[1])
    }

    /// The surface. The error is one line that names what is out of range.
    pub(super) fn surface(&self) -> Result<SurfaceSpec, String> {
        let lengths = [("x", self.size[0]), ("z", self.size[1]), ("wavelength", self.wavelength)];
        let lengths = lengths.map(|(name, value)| (name, value, Self::SIZES));
        for (name, value, range) in lengths.into_iter().chain([("height", self.height, Self::HEIGHTS)]) {
            if !range.contains(&value) {
                return Err(format!("hills: {name} must be from {} to {} m, is {value}", range.start(), range.end()));
            }
        }
        if !Self::SQUARES.contains(&self.squares) {
            let (least, most) = Self::SQUARES.into_inner();
            return Err(format!("hills: squares must be from {least} to {most} along a side, are {}", self.squares));
        }
        let at = |place: u32, size: f64| size * (f64::from(place) / f64::from(self.squares) - 0.5);
        let row = |k: u32| {
            (0..=self.squares).map(|i| self.height(at(i, self.size[0]), at(k, self.size[1]))).collect::<Vec<f64>>()
        };
        SurfaceSpec::heights(self.size, (0..=self.squares).map(row).collect())
            .map_err(|error| format!("hills: {error}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hills_end_level_with_their_valleys() {
        let hills = Hills { size: [6.0, 8.0], height: 0.5, wavelength: 2.0, squares: 40 };
        let surface = hills.surface().expect("a surface");
        let heights: Vec<[f64; 3]> = surface.mesh().vertices().map(|vertex| vertex.to_array()).collect();
        let [lowest, highest] =
            [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| heights.iter().map(|at| at[1]).reduce(of).unwrap());
        assert!(lowest.abs() < 1e-12 && (highest - 0.5).abs() < 1e-12, "{lowest} to {highest}");
        let is_rim = |at: &&[f64; 3]| at[0].abs() == 3.0 || at[2].abs() == 4.0;
        assert!(heights.iter().filter(is_rim).count() == 160 && heights.iter().filter(is_rim).all(|at| at[1] == 0.0));
    }

    #[test]
    fn hills_out_of_range_are_told_by_name() {
        let usual = Hills::default();
        for (hills, name) in [
            (Hills { size: [0.0, 8.0], ..usual }, "x"),
            (Hills { size: [8.0, f64::NAN], ..usual }, "z"),
            (Hills { height: -1.0, ..usual }, "height"),
            (Hills { wavelength: f64::INFINITY, ..usual }, "wavelength"),
            (Hills { squares: 1, ..usual }, "squares"),
            (Hills { squares: 1000, ..usual }, "squares"),
        ] {
            let problem = hills.surface().unwrap_err();
            assert!(problem.starts_with(&format!("hills: {name} must be from")), "{problem}");
        }
    }
}
