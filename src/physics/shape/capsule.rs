//! The capsule: all points within a radius of a segment along y, about its centre of mass.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use bevy::math::DVec3;
use nalgebra::Vector3;

use super::{Hull, Measures};

/// Sides of the polygon that stands for it in the 2009 engine's contacts: flats lie 3.4 % of the radius inside it.
const SIDES: u32 = 12;

/// A cylinder of mass m and the two halves of a ball of mass n: about the axis m r²/2 + 2n r²/5, across it
/// m (l²/12 + r²/4) + n (2r²/5 + l²/4 + 3lr/8), as the centre of half a ball is 3r/8 from its face.
pub(super) fn measures(radius: f64, length: f64) -> Measures {
    let (r, l) = (radius, length);
    let (cylinder, ball) = (PI * r * r * l, 4.0 / 3.0 * PI * r.powi(3));
    let volume = cylinder + ball;
    let [m, n] = [cylinder, ball].map(|part| part / volume);
    let about = 0.5 * m * r * r + 0.4 * n * r * r;
    let across = m * (l * l / 12.0 + r * r / 4.0) + n * (0.4 * r * r + l * l / 4.0 + 0.375 * l * r);
    Measures { volume, moments: DVec3::new(across, about, across), radius: 0.5 * length + radius }
}

/// Rings at the ends of the cylinder and half-way up to the poles, from the bottom up.
pub(super) fn hull(radius: f64, length: f64) -> Hull {
    let half = 0.5 * length;
    let rings = [(-half, -FRAC_PI_4), (-half, 0.0), (half, 0.0), (half, FRAC_PI_4)];
    let mut vertices = vec![Vector3::new(0.0, -half - radius, 0.0), Vector3::new(0.0, half + radius, 0.0)];
    for (middle, latitude) in rings {
        let (sin, cos) = latitude.sin_cos();
        vertices.extend((0..SIDES).map(|side| {
            let (z, x) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            Vector3::new(radius * cos * x, middle + radius * sin, radius * cos * z)
        }));
    }
    let at = |ring: u32, side: u32| 2 + ring * SIDES + side % SIDES;
    let mut loops = Vec::new();
    for side in 0..SIDES {
        loops.push(vec![0, at(0, side), at(0, side + 1)]);
        loops.extend(
            (0..3).map(|ring| vec![at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)]),
        );
        loops.push(vec![1, at(3, side + 1), at(3, side)]);
    }
    Hull::new(vertices, loops)
}
