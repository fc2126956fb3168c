//! Where a ray through the pointer meets axes and planes, and how near it passes to lines.

use bevy::math::DVec3;

/// Squared sine of the least angle between a ray and an axis at which they have one nearest point.
const LEAST_ANGLE: f64 = 1e-4;
/// Sine of the least angle between a ray and a plane at which they meet.
const LEAST_SLOPE: f64 = 0.02;

/// From the eye through the pointer; world, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
}

impl Ray {
    /// How far along an axis through a point that point of it is which the ray passes nearest, m. None: one looks along it.
    pub fn along_axis(&self, point: DVec3, axis: DVec3) -> Option<f64> {
        let (apart, cosine) = (point - self.origin, axis.dot(self.direction));
        let sine = 1.0 - cosine * cosine;
        (sine > LEAST_ANGLE).then(|| (cosine * apart.dot(self.direction) - apart.dot(axis)) / sine)
    }

    /// Where it meets the plane through a point. None: it runs along it, or away from it.
    pub fn on_plane(&self, point: DVec3, normal: DVec3) -> Option<DVec3> {
        let slope = normal.dot(self.direction);
        let way = normal.dot(point - self.origin) / slope;
        (slope.abs() > LEAST_SLOPE && way > 0.0).then(|| self.origin + self.direction * way)
    }

    /// How far a line through points is from it at most as it is seen: the tangent of the angle. What is behind is infinitely
    /// far.
    pub fn distance_to(&self, points: &[DVec3]) -> f64 {
        let seen = points.iter().map(|point| {
            let apart = *point - self.origin;
            let depth = apart.dot(self.direction);
            (depth > 0.0).then(|| apart / depth - self.direction)
        });
        let seen: Vec<Option<DVec3>> = seen.collect();
        let to_piece = |piece: &[Option<DVec3>]| {
            let [Some(from), Some(to)] = *piece else { return f64::INFINITY };
            let along = to - from;
            let share = (-from.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (from + along * share).length()
        };
        match &seen[..] {
            [only] => only.map_or(f64::INFINITY, DVec3::length),
            seen => seen.windows(2).map(to_piece).fold(f64::INFINITY, f64::min),
        }
    }
}

/// The angle from one direction to another about an axis across both, rad, −π to π.
pub fn angle_about(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    axis.dot(from.cross(to)).atan2(from.dot(to))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn ray(origin: DVec3, to: DVec3) -> Ray {
        Ray { origin, direction: (to - origin).normalize() }
    }

    #[test]
    fn an_axis_is_met_where_the_ray_passes_nearest() {
        let eye = DVec3::new(0.3, 2.0, 9.0);
        let through = ray(eye, DVec3::new(1.7, 0.0, 0.0));
        assert!((through.along_axis(DVec3::X * 0.5, DVec3::X).unwrap() - 1.2).abs() < 1e-12);
        // Past it: the nearest point of the axis is the foot of the common perpendicular.
        let past = ray(DVec3::new(1.0, 0.4, 5.0), DVec3::new(1.0, 0.4, 0.0));
        assert!((past.along_axis(DVec3::ZERO, DVec3::X).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(ray(DVec3::X * 5.0, DVec3::ZERO).along_axis(DVec3::ZERO, DVec3::X), None);
    }

    #[test]
    fn a_plane_is_met_in_front_and_not_from_its_side() {
        let down = ray(DVec3::new(1.0, 4.0, 2.0), DVec3::new(1.0, 0.0, 0.0));
        assert!(down.on_plane(DVec3::Y, DVec3::Y).unwrap().abs_diff_eq(DVec3::new(1.0, 1.0, 0.5), 1e-12));
        assert_eq!(down.on_plane(DVec3::Y * 9.0, DVec3::Y), None, "behind");
        assert_eq!(ray(DVec3::Y, DVec3::new(9.0, 1.0, 0.0)).on_plane(DVec3::ZERO, DVec3::Y), None, "along");
    }

    #[test]
    fn lines_are_as_far_as_they_look() {
        let eye = ray(DVec3::Z * 10.0, DVec3::ZERO);
        let line = [DVec3::new(-1.0, 0.5, 0.0), DVec3::new(1.0, 0.5, 0.0)];
        assert!((eye.distance_to(&line) - 0.05).abs() < 1e-12);
        assert!((eye.distance_to(&line[..1]) - (1.25_f64).sqrt() / 10.0).abs() < 1e-12);
        assert_eq!(eye.distance_to(&[DVec3::Z * 11.0, DVec3::Z * 12.0]), f64::INFINITY);
    }

    #[test]
    fn angles_have_the_sign_of_their_axis() {
        assert!((angle_about(DVec3::Z, DVec3::X, DVec3::Y) - FRAC_PI_2).abs() < 1e-12);
        assert!((angle_about(DVec3::Z, DVec3::Y, DVec3::X * 3.0) + FRAC_PI_2).abs() < 1e-12);
    }
}
