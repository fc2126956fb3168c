//! The built-in scenes, one file a family. Bodies joined or stacked are made in the order in which
//! one holds the next.

mod andrews;
mod bouncing;
mod car;
mod convex_pile;
mod dominoes;
mod driven;
mod empty;
mod far;
mod figure;
mod gravity;
mod grid;
mod hanging;
mod heap;
mod heavy;
mod hinged;
mod junkyard;
mod large_world;
mod limbs;
mod linkages;
mod palette;
mod pile;
mod ragdolls;
mod rain;
mod random;
mod sliding;
mod solids;
mod stacking;
mod standing;
mod terrain;
mod tops;
mod tower;
mod trees;
mod washer;

use super::SceneInfo;

/// Every built-in scene, the start scene first.
pub(super) static ALL: [SceneInfo; 49] = [
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
    heavy::SLAB,
    heavy::COLUMN,
    heavy::BOULDER,
    heavy::WRECKING_BALL,
    standing::ARCH,
    standing::CARD_HOUSE,
    dominoes::DOMINOES,
    pile::PILE,
    heap::HEAP,
    terrain::TERRAIN,
    rain::RAIN,
    washer::WASHER,
    trees::TREES,
    junkyard::JUNKYARD,
    convex_pile::CONVEX_PILE,
    large_world::LARGE_WORLD,
    far::FAR,
    linkages::FOUR_BAR,
    linkages::BRICARD,
    andrews::ANDREWS,
    driven::ARM,
    driven::SERVO,
    driven::STOP,
    hinged::HINGE_CHAIN,
    hinged::BRIDGE,
    tower::TOWER,
    car::CAR,
    ragdolls::RAGDOLLS,
    empty::EMPTY,
];
