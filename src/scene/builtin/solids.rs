//! Hulls of corners, and parts of compounds made of them.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};

use crate::scene::{BodySpec, ChildSpec, CompoundSpec, ShapeSpec};

/// Corners of an upright prism whose base is at that height, all m.
pub fn prism(radius: f64, base: f64, height: f64, sides: usize) -> Vec<DVec3> {
    let corner = |side: usize| {
        let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
        [base, base + height].map(|y| DVec3::new(radius * cos, y, radius * sin))
    };
    (0..sides).flat_map(corner).collect()
}

/// The hull of corners as a part of a compound, in whose axes they are given.
pub fn part(corners: Vec<DVec3>) -> ChildSpec {
    let shape = ShapeSpec::hull(corners);
    let position = center(&shape);
    ChildSpec { shape, position, rotation: DQuat::IDENTITY }
}

/// A body whose shape is given in axes with that origin.
pub fn body_at(name: impl Into<String>, shape: ShapeSpec, origin: DVec3) -> BodySpec {
    let center = center(&shape);
    BodySpec::new(name, shape, origin + center)
}

/// Of solids, one at least.
pub fn compound(parts: Vec<ChildSpec>) -> ShapeSpec {
    ShapeSpec::Compound(CompoundSpec::new(parts).expect("solids"))
}

fn center(shape: &ShapeSpec) -> DVec3 {
    match shape {
        ShapeSpec::Compound(compound) => compound.compound().center(),
        _ => shape.convex_hull().map_or(DVec3::ZERO, |hull| hull.center()),
    }
}
