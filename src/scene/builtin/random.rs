//! Where built-in scenes have their random numbers from.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use crate::scene::ShapeSpec;

/// Random numbers that are the same on every machine and in every run.
pub fn seeded() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(2009)
}

/// Evenly spread over the sphere (Archimedes: heights on it are).
pub fn any_direction(random: &mut Pcg64Mcg) -> DVec3 {
    let (height, around) = (random.random_range(-1.0_f64..1.0), random.random_range(0.0..TAU));
    let (sin, cos) = around.sin_cos();
    let across = (1.0 - height * height).sqrt();
    DVec3::new(across * cos, height, across * sin)
}

/// Evenly spread over the rotations (Shoemake 1992).
pub fn any_rotation(random: &mut Pcg64Mcg) -> DQuat {
    let share = random.random_range(0.0_f64..1.0);
    let [one, other] = std::array::from_fn(|_| random.random_range(0.0..TAU).sin_cos());
    let (rest, share) = ((1.0 - share).sqrt(), share.sqrt());
    DQuat::from_xyzw(rest * one.0, rest * one.1, share * other.0, share * other.1).normalize()
}

/// The hull of so many points on a ball of that radius, m.
pub fn any_hull(random: &mut Pcg64Mcg, radius: f64, corners: usize) -> ShapeSpec {
    ShapeSpec::hull((0..corners).map(|_| radius * any_direction(random)).collect::<Vec<_>>())
}
