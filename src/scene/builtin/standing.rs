//! Structures that stand by friction alone: `arch`, `card_house`. Gaps are 0.

use std::f64::consts::PI;

use bevy::math::{DQuat, DVec3};

use super::gravity::EARTH;
use super::palette;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

const VOUSSOIRS: usize = 15;
const INNER_RADIUS: f64 = 4.0;
const OUTER_RADIUS: f64 = 5.0;
const ARCH_DEPTH: f64 = 1.0;

pub(super) const ARCH: SceneInfo = SceneInfo {
    name: "arch",
    title: "Arch",
    subject: Subject::Friction,
    about: "a semicircular arch of 15 voussoirs of 12 degrees, radii 4 and 5 m, 1 m deep, on the ground",
    truth: "stands: a line of thrust fits in, and friction of 0.31 would do; there is 0.6",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| VOUSSOIRS as f64 + 1.0,
    build: |_| build_arch(),
};

pub(super) const CARD_HOUSE: SceneInfo = SceneInfo {
    name: "card_house",
    title: "House of cards",
    subject: Subject::Friction,
    about: "a house of 15 cards 1 x 0.04 x 0.7 m in 3 storeys, leaning 20 degrees from the vertical, with level decks",
    truth: "stands: 20 degrees from the vertical is well within the friction angle of 31 degrees",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| 16.0,
    build: |_| build_card_house(),
};

/// Voussoirs from the left springing to the right, each the hull of the same 8 corners, turned: its
/// sides are its neighbours', and the springings lie flat on the ground.
///
/// *It stands* (Heyman 1966): a line of thrust fits into its thickness with a horizontal thrust of
/// 0.293 (through the crown's upper edge and the haunches' lower) to 0.532 (through the crown's
/// lower edge) of the weight of half an arch, which each springing carries. Its thickness is 0.22
/// of its mean radius; 0.107 is the least for a semicircle. Friction must keep the springings from
/// sliding apart, by the share that the thrust is of the weight, and joints between voussoirs too:
/// 0.309 is the least that some line of thrust needs, the ground and the joints give 0.6.
fn build_arch() -> SceneSpec {
    let angle = PI / VOUSSOIRS as f64;
    let (sin, cos) = (0.5 * angle).sin_cos();
    let mut corners = Vec::with_capacity(8);
    for radius in [INNER_RADIUS, OUTER_RADIUS] {
        for (x, z) in [(-1.0, -0.5), (-1.0, 0.5), (1.0, -0.5), (1.0, 0.5)] {
            corners.push(DVec3::new(x * radius * sin, radius * cos, z * ARCH_DEPTH));
        }
    }
    // About the arch's centre, pointing up.
    let voussoir = ShapeSpec::hull(corners);
    let center = voussoir.convex_hull().map_or(DVec3::ZERO, |hull| hull.center());
    let mut scene = SceneSpec::new("arch", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    for i in 0..VOUSSOIRS {
        let rotation = DQuat::from_rotation_z(angle * ((VOUSSOIRS - 1) as f64 / 2.0 - i as f64));
        let color = if i == VOUSSOIRS / 2 { palette::ORANGE } else { [palette::SKIN, palette::WOOD][i % 2] };
        scene.bodies.push(
            BodySpec::new(format!("voussoir {i}"), voussoir.clone(), rotation * center)
                .with_rotation(rotation)
                .with_color(color),
        );
    }
    scene.view = Some(ViewSpec::framing(2.3 * DVec3::Y, 5.2, DVec3::new(0.35, 0.2, 1.0)));
    scene
}

/// Long, thick, deep, m.
const CARD: DVec3 = DVec3::new(1.0, 0.04, 0.7);
const LEAN_DEGREES: f64 = 20.0;
const STOREYS: usize = 3;

/// Storeys of 3, 2 and 1 pairs of leaning cards, a card's length apart, and decks from each pair
/// to the next.
///
/// Seen along z, a card of length L and thickness t that leans by α is a rectangle on its corner.
/// From the apex line of its pair at x = 0:
/// - it stands on an edge at x = ∓L sin α, and is L cos α + t sin α high;
/// - the two meet edge on edge, L cos α above the feet, t sin α below their tops;
/// - a deck lies on their top edges at x = ∓t cos α. It ends above the apex line, so each card
///   carries the deck on its own side, and the outermost cards none.
///
/// *Forces.* A card of weight m g with a load P on its top edge is held up at the apex by a
/// horizontal force (½ m g + P)(tan α − t/L), and where P comes to one of the two cards only, by
/// the deck that it carries, in tension. Its foot passes on m g + P downwards: no contact but the
/// apex needs more than tan α − t/L = 0.32 of friction.
///
/// *The apex's normal.* Where two edges meet, every direction between the normals of the two
/// inner faces, α below and α above the horizontal, separates the cards. Plumb's contacts take one
/// of those two normals, and friction makes up for the angle to the horizontal force: tan α =
/// 0.36 of the 0.6 there is, where a horizontal normal would let 0.32 do.
fn build_card_house() -> SceneSpec {
    let DVec3 { x: length, y: thickness, .. } = CARD;
    let (sin, cos) = LEAN_DEGREES.to_radians().sin_cos();
    let height = length * cos + thickness * sin;
    let mut scene = SceneSpec::new("card_house", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    for storey in 0..STOREYS {
        let pairs = STOREYS - storey;
        let floor = storey as f64 * (height + thickness);
        let apex = |pair: usize| length * (pair as f64 - 0.5 * (pairs - 1) as f64);
        for pair in 0..pairs {
            for (word, side, color) in [("left", -1.0, palette::RED), ("right", 1.0, palette::BLUE)] {
                let out = 0.5 * (length * sin + thickness * cos);
                let position = DVec3::new(apex(pair) + side * out, floor + 0.5 * height, 0.0);
                let name = format!("{word} card {storey}.{pair}");
                // The card's x axis points from its foot to its top.
                let rotation = DQuat::from_rotation_z((90.0 + side * LEAN_DEGREES).to_radians());
                scene.bodies.push(card(name, position, color).with_rotation(rotation));
            }
        }
        for deck in 1..pairs {
            let middle = 0.5 * (apex(deck - 1) + apex(deck));
            let position = DVec3::new(middle, floor + height + 0.5 * thickness, 0.0);
            scene.bodies.push(card(format!("deck {storey}.{}", deck - 1), position, palette::YELLOW));
        }
    }
    scene.view = Some(ViewSpec::framing(1.4 * DVec3::Y, 1.9, DVec3::new(0.35, 0.25, 1.0)));
    scene
}

fn card(name: String, position: DVec3, color: [f32; 3]) -> BodySpec {
    BodySpec::new(name, ShapeSpec::Cuboid { size: CARD }, position).with_color(color)
}
