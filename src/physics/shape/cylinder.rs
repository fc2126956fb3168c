//! The circular cylinder, its axis along y, about its centre of mass.

use std::f64::consts::{PI, TAU};

use bevy::math::DVec3;
use nalgebra::Vector3;

use super::{Hull, Measures};

/// Sides of the polygon that stands for it in the 2009 engine's contacts: flats lie 0.9 % of the radius inside it.
const SIDES: u32 = 24;

/// Moments r²/2 about the axis, (3r² + h²)/12 across it.
pub(super) fn measures(radius: f64, height: f64) -> Measures {
    let square = radius * radius;
    let across = (3.0 * square + height * height) / 12.0;
    Measures {
        volume: PI * square * height,
        moments: DVec3::new(across, 0.5 * square, across),
        radius: radius.hypot(0.5 * height),
    }
}

/// The bottom's vertices counted from +z towards +x, then those of the top.
pub(super) fn hull(radius: f64, height: f64) -> Hull {
    let ring = |level: f64| {
        (0..SIDES).map(move |side| {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            Vector3::new(radius * sin, level, radius * cos)
        })
    };
    let vertices = ring(-0.5 * height).chain(ring(0.5 * height)).collect();
    let sides = (0..SIDES).map(|side| {
        let next = (side + 1) % SIDES;
        vec![side, next, next + SIDES, side + SIDES]
    });
    let ends = [(0..SIDES).rev().collect(), (SIDES..2 * SIDES).collect()];
    Hull::new(vertices, ends.into_iter().chain(sides).collect())
}
