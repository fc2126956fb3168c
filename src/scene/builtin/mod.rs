//! The built-in scenes, one file a family. Bodies joined or stacked are made in the order in which
//! one holds the next.

mod bouncing;
mod dominoes;
mod far;
mod figure;
mod grid;
mod hanging;
mod limbs;
mod pile;
mod sliding;
mod stacking;
mod standing;
mod tops;

use bevy::math::DVec3;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::SceneInfo;

/// Every built-in scene, the start scene first.
pub(super) static ALL: [SceneInfo; 25] = [
    limbs::LIMBS,
    hanging::PENDULUM,
    hanging::RODS,
    hanging::CHAIN,
    hanging::HANGING,
    grid::JOINT_GRID,
    tops::TOP,
    tops::HEAVY_TOP,
    sliding::INCLINE,
    sliding::SLIDE_ROLL,
    sliding::ROLLING,
    sliding::PAINLEVE,
    bouncing::BOUNCE,
    bouncing::SPHERES,
    bouncing::CRADLE,
    bouncing::WALL,
    stacking::STACK,
    stacking::PYRAMID,
    stacking::PYRAMIDS,
    stacking::SANDWICH,
    standing::ARCH,
    standing::CARD_HOUSE,
    dominoes::DOMINOES,
    pile::PILE,
    far::FAR,
];

/// g = 10 m/s² downwards, for scenes that are compared with references and other engines.
const TEN: DVec3 = DVec3::new(0.0, -10.0, 0.0);

/// Standard gravity as Plumb rounds it, downwards, m/s².
const EARTH: DVec3 = DVec3::new(0.0, -EARTH_G, 0.0);
const EARTH_G: f64 = 9.81;

/// Random numbers that are the same on every machine and in every run.
fn seeded() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(2009)
}

/// Colours (sRGB) that go together and tell neighbours apart.
mod palette {
    pub const RED: [f32; 3] = [0.86, 0.29, 0.25];
    pub const ORANGE: [f32; 3] = [0.94, 0.58, 0.24];
    pub const YELLOW: [f32; 3] = [0.96, 0.80, 0.38];
    pub const GREEN: [f32; 3] = [0.42, 0.68, 0.42];
    pub const TEAL: [f32; 3] = [0.22, 0.60, 0.62];
    pub const BLUE: [f32; 3] = [0.27, 0.47, 0.73];
    pub const PURPLE: [f32; 3] = [0.54, 0.40, 0.66];
    pub const SKIN: [f32; 3] = [0.93, 0.76, 0.62];
    pub const WOOD: [f32; 3] = [0.72, 0.53, 0.36];
    pub const STEEL: [f32; 3] = [0.62, 0.66, 0.70];
    pub const SLATE: [f32; 3] = [0.33, 0.38, 0.44];
    pub const GROUND: [f32; 3] = [0.60, 0.63, 0.62];

    /// The bright ones, to count through.
    pub const BRIGHT: [[f32; 3]; 7] = [RED, ORANGE, YELLOW, GREEN, TEAL, BLUE, PURPLE];

    /// The bright colour of number `i`, round and round.
    pub fn bright(i: usize) -> [f32; 3] {
        BRIGHT[i % BRIGHT.len()]
    }
}
