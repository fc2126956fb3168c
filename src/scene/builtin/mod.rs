//! The built-in scenes, one file a family. Bodies joined or stacked are made in the order in which
//! one holds the next.

mod bouncing;
mod dominoes;
mod far;
mod figure;
mod gravity;
mod grid;
mod hanging;
mod limbs;
mod palette;
mod pile;
mod random;
mod sliding;
mod stacking;
mod standing;
mod tops;

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
