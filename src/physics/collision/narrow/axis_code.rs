//! A direction in four bytes, for what a pair keeps from step to step.

use nalgebra::{Vector2, Vector3};

/// A direction to within 1e-4 rad: its place on the octahedron |x| + |y| + |z| = 1, whose lower half
/// is folded outward to make a square of it (Meyer et al. 2010).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AxisCode(pub u32);

/// Steps from the middle of the square to its sides.
const STEPS: f64 = 32767.0;

impl AxisCode {
    /// Of a unit vector.
    pub fn of(axis: &Vector3<f64>) -> Self {
        let place = axis / axis.lp_norm(1);
        let square = if place.z >= 0.0 { place.xy() } else { fold(place.xy()) };
        let [x, y] = [square.x, square.y].map(|along| (along * STEPS).round() as i16 as u16);
        Self(u32::from(x) << 16 | u32::from(y))
    }

    /// Unit.
    pub fn axis(self) -> Vector3<f64> {
        let [x, y] = [(self.0 >> 16) as u16, self.0 as u16].map(|along| f64::from(along as i16) / STEPS);
        let height = 1.0 - x.abs() - y.abs();
        let square = Vector2::new(x, y);
        let place = if height >= 0.0 { square } else { fold(square) };
        Vector3::new(place.x, place.y, height).normalize()
    }
}

fn fold(square: Vector2<f64>) -> Vector2<f64> {
    Vector2::new((1.0 - square.y.abs()).copysign(square.x), (1.0 - square.x.abs()).copysign(square.y))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::AxisCode;
    use crate::physics::testing::Random;

    #[test]
    fn directions_are_kept() {
        let mut random = Random::new(3);
        let axes = (0..1000).map(|_| random.direction());
        for axis in axes.chain([Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|axis| [axis, -axis])) {
            let kept = AxisCode::of(&axis).axis();
            assert!((kept - axis).norm() < 1e-4, "{kept} of {axis}");
            assert!((kept.norm() - 1.0).abs() < 1e-12);
        }
    }
}
