//! Whether rows of a mechanism may depend on each other, from its structure alone.
//!
//! A tree of joints has independent rows: each joint adds its own to those of the bodies on this side of it. What closes a
//! loop may add rows that say what others say already. Joints come in pieces, what they hold and their laws two at a time
//! ([`JointDefinition::pieces`]), each a link of its own; pieces of one joint close no loop where each is of other
//! coordinates than the rest. The two limits of a range are of the same one, and never hold together.

use super::constants::NARROW_RANGE;
use crate::physics::joint::{CoordinateLaw, Hold, JointAxis, JointDefinition, LawAxis, LawPart};

/// A link between two members.
pub(super) type Piece<'j> = ([u32; 2], &'j JointDefinition);

/// Whether the rows of links may be redundant, where the first `moving` members move and make up one piece. All rows are
/// taken to hold but opposite limits.
pub(super) fn may_be_redundant<'j>(moving: usize, links: impl Iterator<Item = Piece<'j>>) -> bool {
    let mut order: Vec<Piece> = links.collect();
    order.sort_by_key(|(ends, _)| *ends);
    let mut edges = 0;
    for joined in order.chunk_by(|(one, _), (other, _)| one == other) {
        if !are_of_one_joint(joined) {
            return true;
        }
        edges += 1;
    }
    // A tree with one fixed point has as many edges as bodies, one without has one less; any more close a loop.
    let is_held = order.iter().flat_map(|(ends, _)| ends).any(|&member| member as usize >= moving);
    edges + usize::from(!is_held) > moving
}

/// Whether links between two members are pieces of one joint with independent rows.
fn are_of_one_joint(links: &[Piece]) -> bool {
    let [(_, first), others @ ..] = links else { return true };
    if others.iter().any(|(_, definition)| definition.frames != first.frames) {
        return false;
    }
    let mut taken = 0;
    let mut limits: Vec<&CoordinateLaw> = Vec::new();
    for (_, definition) in links {
        let Some(laws) = &definition.laws else {
            let held = held_by(definition);
            if taken & held != 0 {
                return false;
            }
            taken |= held;
            continue;
        };
        for law in laws.iter() {
            let own = coordinates_of(law);
            let is_other_end = limits.iter().any(|other| are_opposite(other, law));
            if taken & own != 0 && !is_other_end {
                return false;
            }
            taken |= own;
            limits.push(law);
        }
    }
    true
}

/// Coordinates as bits: the translations along A's axes, then the rotations.
fn held_by(definition: &JointDefinition) -> u8 {
    if definition.function.is_some() {
        return u8::MAX;
    }
    let holds = definition.translation.hold.iter().chain(&definition.rotation.hold);
    holds.enumerate().map(|(bit, hold)| u8::from(*hold == Hold::Locked) << bit).sum()
}

fn coordinates_of(law: &CoordinateLaw) -> u8 {
    match law.axis {
        LawAxis::Coordinate(JointAxis::X) => 0b00_0001,
        LawAxis::Coordinate(JointAxis::Y) => 0b00_0010,
        LawAxis::Coordinate(JointAxis::Z) => 0b00_0100,
        LawAxis::Coordinate(JointAxis::Twist) => 0b00_1000,
        LawAxis::Coordinate(JointAxis::Swing) => 0b11_0000,
        LawAxis::Coordinate(JointAxis::Distance) => 0b00_0111,
        LawAxis::Turning(_) => 0b11_1000,
    }
}

/// Whether these are both ends of a range that is wide enough for one to be left before the other is reached.
fn are_opposite(one: &CoordinateLaw, other: &CoordinateLaw) -> bool {
    let (LawPart::Limit { bound, is_upper, .. }, LawPart::Limit { bound: end, is_upper: is_other_upper, .. }) =
        (one.part, other.part)
    else {
        return false;
    };
    one.axis == other.axis && is_upper != is_other_upper && (bound - end).abs() > NARROW_RANGE
}
