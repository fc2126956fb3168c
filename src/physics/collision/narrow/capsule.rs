//! A capsule against any other shape but a ball: one point, or two where its side lies along a flat or straight part of the
//! other.
//!
//! The signed distance d of a convex shape, negative inside, is a convex function of a point, and so of the place t along
//! the capsule's segment c + t u. Its derivative is n·u, n the normal out of the shape there, and grows with t: d is least
//! where it changes its sign, which is found by chords and halving, and there is the contact, with the normal n and the depth
//! r − d. That is the true distance of the two wherever the segment is outside the shape; within, the least way out of its
//! deepest point.
//!
//! About that place d is nowhere less than the plane there, d* + (t − t*) n·u, and as much where that plane touches the
//! shape still: above a face, along a generator line of a cone or beside a parallel capsule. As what is between is convex,
//! too, the ends of that interval are found by halving; they are the two points.

use nalgebra::Vector3;

use super::ball::place;
use super::{Frame, Overlap, Scale};
use crate::physics::{ContactPoint, FeatureId, Geometry};

/// Looks for the nearest point of the segment at most: a third of them halve.
const LOOKS: u32 = 120;

/// Slope, and share of the segment, that counts as none.
const LEVEL: f64 = 1e-13;

/// Halvings of what may lie along a face: to 1e-7 of the segment.
const HALVINGS: u32 = 24;

/// How far d may be above the plane that counts as on it, as a share of the size; and how far apart two points are at
/// least, as a share of the radius.
const FLAT: f64 = 1e-9;
const APART: f64 = 1e-2;

/// Where the segment is nearest, and the plane there.
struct Nearest {
    t: f64,
    normal: Vector3<f64>,
    distance: f64,
    /// n·u: how the plane rises along the segment.
    slope: f64,
}

/// Tests a shape and a capsule of that radius and half its segment's length, given in the shape's axes, and adds the points
/// where they touch or are nearest, as far as they are apart by no more than the gap. Of two that are farther apart, leaves
/// in `apart` by how much.
pub(crate) fn touch(
    shape: &Geometry,
    shape_radius: f64,
    [radius, half]: [f64; 2],
    capsule_in_shape: &Frame,
    scale: &Scale,
    apart: &mut f64,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let size = if shape_radius.is_finite() { shape_radius } else { radius };
    touch_placed(|point| place(shape, point, size), size, [radius, half], capsule_in_shape, scale, apart, points)
}

/// Likewise, of any convex shape about that size, m, of which `place` tells the unit normal out of it along the shortest way
/// between its surface and a point, and how far the point is out.
pub(crate) fn touch_placed(
    place: impl Fn(&Vector3<f64>) -> (Vector3<f64>, f64),
    size: f64,
    [radius, half]: [f64; 2],
    capsule_in_shape: &Frame,
    scale: &Scale,
    apart: &mut f64,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let along = capsule_in_shape.rotation.column(1).into_owned();
    let at = |t: f64| capsule_in_shape.center + along * t;
    let Nearest { t, normal, distance, slope } = nearest(&place, half, &along, at);
    if scale.separates(radius - distance) {
        *apart = distance - radius;
        return None;
    }
    let depth = |place: f64| scale.rounded(radius - (distance + (place - t) * slope));
    let is_flat = |place_at: f64| {
        let (_, height) = place(&at(place_at));
        height - (distance + (place_at - t) * slope) <= FLAT * (size + radius + half)
    };
    // As far as points may yet touch.
    let within =
        if slope.abs() > f64::MIN_POSITIVE { (radius + scale.gap - distance) / slope.abs() } else { f64::INFINITY };
    let ends = [(t - within).max(-half), (t + within).min(half)].map(|end| reach(t, end, is_flat));
    let mut add = |place: f64, feature: u32| {
        let depth = depth(place);
        let point = at(place) - normal * (radius - depth / 2.0);
        points.push(ContactPoint { point, depth, feature: FeatureId::of_vertex(true, feature) });
    };
    if ends[1] - ends[0] > APART * radius {
        add(ends[0], 0);
        add(ends[1], 1);
    } else {
        add(
            t,
            if t <= -half {
                0
            } else if t >= half {
                1
            } else {
                2
            },
        );
    }
    Some(Overlap { normal, depth: depth(t) })
}

fn nearest(
    place: impl Fn(&Vector3<f64>) -> (Vector3<f64>, f64),
    half: f64,
    along: &Vector3<f64>,
    at: impl Fn(f64) -> Vector3<f64>,
) -> Nearest {
    let look = |t: f64| {
        let (normal, distance) = place(&at(t));
        Nearest { t, normal, distance, slope: normal.dot(along) }
    };
    let (low, high) = (look(-half), look(half));
    if low.slope >= 0.0 {
        return low;
    }
    if high.slope <= 0.0 {
        return high;
    }
    let (mut low, mut high) = (low, high);
    // The slopes that the chord is drawn through: that of an end which stays twice counts half (Illinois), so that both
    // come in.
    let (mut at_low, mut at_high, mut low_moved) = (low.slope, high.slope, None);
    for look_at in 0..LOOKS {
        let chord = low.t - at_low * (high.t - low.t) / (at_high - at_low);
        // Where the slope jumps, at an edge, only halving comes in.
        let middle = look(if look_at % 3 == 2 { 0.5 * (low.t + high.t) } else { chord });
        if middle.slope.abs() <= LEVEL || high.t - low.t <= LEVEL * half {
            return middle;
        }
        if middle.slope < 0.0 {
            at_high *= if low_moved == Some(true) { 0.5 } else { 1.0 };
            (at_low, low_moved, low) = (middle.slope, Some(true), middle);
        } else {
            at_low *= if low_moved == Some(false) { 0.5 } else { 1.0 };
            (at_high, low_moved, high) = (middle.slope, Some(false), middle);
        }
    }
    if low.distance < high.distance { low } else { high }
}

/// How far towards the end it is flat.
fn reach(from: f64, end: f64, is_flat: impl Fn(f64) -> bool) -> f64 {
    if from == end || is_flat(end) {
        return end;
    }
    let (mut flat, mut curved) = (from, end);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (flat + curved);
        if is_flat(middle) { flat = middle } else { curved = middle }
    }
    flat
}
