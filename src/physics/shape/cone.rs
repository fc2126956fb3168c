//! The circular cone, apex up +y, its centre of mass a quarter of the height above the base.

use std::f64::consts::{PI, TAU};

use bevy::math::DVec3;
use nalgebra::Vector3;

use super::hull::VERTEX_EPSILON;
use super::{Hull, Measures};
use crate::physics::VectorSet;

/// Sides of the polygon inscribed in the base circle: flats lie 0.9 % of the radius inside it.
const SIDES: u32 = 24;

/// Moments 3/10 r² about the axis, 3/80 (4r² + h²) across it.
pub(super) fn measures(radius: f64, height: f64) -> Measures {
    let square = radius * radius;
    let across = 3.0 / 80.0 * (4.0 * square + height * height);
    Measures {
        volume: PI / 3.0 * radius * radius * height,
        moments: DVec3::new(across, 0.3 * square, across),
        radius: f64::max(0.75 * height, radius.hypot(0.25 * height)),
    }
}

/// Base vertices counted from +z towards +x, then the apex.
pub(super) fn hull(radius: f64, height: f64) -> Hull {
    // The vertex reduction would leave a needle no base: 35 times as high as wide it begins to
    // drop base vertices, and half the base radius is where it stops.
    let epsilon = f64::min(VERTEX_EPSILON * measures(radius, height).radius, radius / 2.0);
    let mut base = VectorSet::default();
    base.reset(epsilon, false, radius);
    for side in 0..SIDES {
        let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
        base.insert(Vector3::new(radius * sin, -0.25 * height, radius * cos));
    }
    let mut vertices = base.vectors().to_vec();
    let sides = vertices.len() as u32;
    vertices.push(Vector3::new(0.0, 0.75 * height, 0.0));
    let bottom = (0..sides).rev().collect();
    let flanks = (0..sides).map(|side| vec![side, (side + 1) % sides, sides]);
    Hull::new(vertices, std::iter::once(bottom).chain(flanks).collect())
}
