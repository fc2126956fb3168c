//! Where a shape that moves straight on, without turning, first touches another: by conservative advancement, as of
//! bodies that move fast ([`time_of_impact`](crate::physics::collision)).
//!
//! Shapes that are apart by s along a unit n from the one that moves to the other come together along n by n·d for each
//! metre, and by no more along any way. So it is moved on by s/(n·d) and looked at again; where n·d ≤ 0 they are apart
//! along n for ever. Where one is curved that is Newton's method for the distance.

use nalgebra::Vector3;

use crate::physics::collision::{PartPair, parts_within, touch};
use crate::physics::{Body, ContactPoint, PairSearch};

/// Looks at most; what grazes takes many.
const LOOKS: usize = 64;

/// Where a shape first touches another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Impact {
    /// How far it moved, m; 0 where they overlap from the start.
    pub distance: f64,
    /// A point of the other that is touched, world axes.
    pub point: Vector3<f64>,
    /// Unit, out of the other.
    pub normal: Vector3<f64>,
}

/// Buffers of a cast.
#[derive(Default)]
pub(super) struct Buffers {
    search: PairSearch,
    points: Vec<ContactPoint>,
    parts: Vec<PartPair>,
}

/// Where `mover` first touches the other on its way along a unit `direction`, within `most`, m.
pub(super) fn cast(
    mover: &Body,
    other: &Body,
    direction: &Vector3<f64>,
    most: f64,
    buffers: &mut Buffers,
) -> Option<Impact> {
    let mut list = std::mem::take(&mut buffers.parts);
    parts_within(mover, other, most, &mut list);
    let first = list.iter().fold(None, |first: Option<Impact>, &parts| {
        let most = first.map_or(most, |impact| impact.distance);
        let nearer = cast_parts([mover, other], parts, direction, most, buffers);
        nearer.filter(|impact| first.is_none_or(|first| impact.distance < first.distance)).or(first)
    });
    buffers.parts = list;
    first
}

/// Likewise, of those parts.
fn cast_parts(
    [mover, other]: [&Body; 2],
    parts: PartPair,
    direction: &Vector3<f64>,
    most: f64,
    Buffers { search, points, .. }: &mut Buffers,
) -> Option<Impact> {
    let (mut at, mut distance) = (mover.clone(), 0.0);
    for look in 1..=LOOKS {
        points.clear();
        // What another shape was tested by is no help here.
        search.last = None;
        search.any_normal = true;
        let overlap = touch([&at, other], parts, most - distance, search, points);
        search.any_normal = false;
        let overlap = overlap?;
        let (separation, approach) = (-overlap.depth, overlap.normal.dot(direction));
        let is_last = look == LOOKS;
        if separation <= 0.0 || is_last {
            let deepest = points.iter().max_by(|one, other| one.depth.total_cmp(&other.depth))?;
            let impact = Impact { distance, point: deepest.point, normal: -overlap.normal };
            // A face was preferred to edges that are apart by little more than it.
            let Some(left) = left_apart([&at, other], parts, search, points).filter(|_| !is_last) else {
                return Some(impact);
            };
            distance += left;
        } else if approach <= 0.0 {
            return None;
        } else {
            distance += separation / approach;
        }
        if distance > most {
            return None;
        }
        at.position = mover.position + direction * distance;
    }
    unreachable!("the last look returns")
}

/// How far parts are apart at least, m, along any of the axes there are for them; none if they are not.
fn left_apart(
    bodies: [&Body; 2],
    parts: PartPair,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<f64> {
    (search.last, search.apart) = (None, 0.0);
    points.clear();
    let is_apart = touch(bodies, parts, 0.0, search, points).is_none();
    (is_apart && search.apart > 0.0).then_some(search.apart)
}
