//! The circle of normals of a cone's flank, against another cone: where on it the overlap is least.
//!
//! With n(ρ) = cos γ ρ + sin γ a, ρ a unit vector across the axis a, and c the apex, every point z of
//! the other cone bounds the overlap along n(ρ) from below:
//!
//!   depth(ρ) = max over z of g_z(ρ),  g_z(ρ) = n(ρ)·(c − z) ≥ v(z) = −sin γ z_a − cos γ |z_ρ|,
//!
//! z_a and z_ρ what of z − c lies along and across the axis, since g_z is least where ρ points
//! along z_ρ. v(z) is the depth of z behind the flank. So a ρ with depth(ρ) = v(z) for some z is the
//! least of the *whole* circle, and any z with v(z) ≥ limit proves that no normal of the flank has a
//! depth below the limit. The point z is the other's apex (a closed form), a point of its rim (Newton's
//! method on ρ: with y the rim's foremost point, depth' = −cos γ τ·y and depth'' = cos γ ρ·y
//! + r/σ (t·τ cos γ)², τ along the circle, t the rim's tangent, σ the sine of n to the other's axis),
//! or one between both, where flank touches flank (a closed form).
//!
//! There is no such z where the other cone lies about the axis: the function of ρ is then least at
//! no saddle. That no normal is below the limit is proved by going around the circle: where a
//! depth g_z(ρ) exceeds the limit, it does so on an arc that has a closed form ([`is_above`]).

use nalgebra::Vector3;

use super::placed_cone::PlacedCone;
use crate::physics::collision::constants::{
    CIRCLE_SLACK, CIRCLE_STEPS, FLANK_STEPS, LEAST_ARC, LONGEST_TURN, SADDLE_GAP, SETTLED_TURN,
};

/// What of a flank's normals is known.
#[derive(Clone, Copy, Debug)]
pub(crate) enum OfFlank {
    /// The least depth of all, its normal out of the cone of the flank, and the other's point that proves it.
    Least { normal: Vector3<f64>, depth: f64, deepest: Vector3<f64> },
    /// No depth is below the limit; a point of the other that proves it, if one does.
    Above(Option<Vector3<f64>>),
    /// Neither could be proved.
    Unknown,
}

/// The least overlap along normals of the flank of `one`, if it is below `limit`. Lengths below `small` do not count.
pub(crate) fn least_of_flank(one: &PlacedCone, other: &PlacedCone, limit: f64, small: f64, axes: &mut u32) -> OfFlank {
    let apex = one.below(&other.apex);
    let depth = one.flank_depth(&apex);
    *axes += 1;
    if depth >= limit {
        return OfFlank::Above(Some(other.apex));
    }
    // The other's apex deepest of all.
    let toward_apex = one.rim_direction(&apex.across);
    let normal = one.flank_normal(&toward_apex);
    let on_rim = other.rim_point(&other.rim_direction(&-normal));
    if normal.dot(&(one.apex - on_rim)) <= depth {
        return OfFlank::Least { normal, depth, deepest: other.apex };
    }
    if one.flank_depth(&one.below(&on_rim)) >= limit {
        return OfFlank::Above(Some(on_rim));
    }
    match rim_saddle(one, other, limit, small, axes) {
        RimSaddle::At(toward, on_rim) => {
            let normal = one.flank_normal(&toward);
            let depth = normal.dot(&(one.apex - on_rim));
            if normal.dot(&(one.apex - other.apex)) <= depth {
                return OfFlank::Least { normal, depth, deepest: on_rim };
            }
        }
        RimSaddle::Above(point) => return OfFlank::Above(Some(point)),
        RimSaddle::None => {}
    }
    *axes += 1;
    let mut least = None;
    let mut lowest = limit;
    for on_flanks in flank_to_flank(one, other).into_iter().flatten() {
        let OnFlanks { normal, depth, deepest } = on_flanks;
        if depth - one.flank_depth(&one.below(&deepest)) <= SADDLE_GAP * small {
            return OfFlank::Least { normal, depth, deepest };
        }
        if depth < lowest {
            lowest = depth;
            least = Some(OfFlank::Least { normal, depth, deepest: other.apex });
        }
    }
    if is_above(one, other, lowest - CIRCLE_SLACK * small, axes) {
        least.unwrap_or(OfFlank::Above(None))
    } else {
        OfFlank::Unknown
    }
}

enum RimSaddle {
    /// The direction of the normal, and the other's rim's point.
    At(Vector3<f64>, Vector3<f64>),
    /// That point of the rim is deeper than the limit.
    Above(Vector3<f64>),
    None,
}

/// The least depth against the other's rim alone.
fn rim_saddle(one: &PlacedCone, other: &PlacedCone, limit: f64, small: f64, axes: &mut u32) -> RimSaddle {
    let mut toward = one.rim_direction(&(other.base - one.apex));
    let (mut last, mut longest) = (0.0, LONGEST_TURN);
    for _ in 0..FLANK_STEPS {
        *axes += 1;
        let normal = one.flank_normal(&toward);
        let out = -(normal - other.axis * other.axis.dot(&normal));
        let sigma = out.norm();
        let rim_direction = if sigma > 0.0 { out / sigma } else { other.rim_direction(&out) };
        let on_rim = other.rim_point(&rim_direction);
        let point = one.below(&on_rim);
        if one.flank_depth(&point) >= limit {
            return RimSaddle::Above(on_rim);
        }
        let front = toward.dot(&point.across);
        let along_circle = one.axis.cross(&toward);
        let aside = along_circle.dot(&point.across);
        let slip = other.axis.cross(&rim_direction).dot(&along_circle);
        let bend = front + other.radius * one.cosine * slip * slip / sigma;
        let turn = if bend > small { aside / bend } else { f64::INFINITY.copysign(aside) };
        if turn * last < 0.0 {
            longest *= 0.5;
        }
        last = turn;
        if turn.abs() < SETTLED_TURN {
            let is_saddle = point.distance - front <= SADDLE_GAP * small;
            return if is_saddle { RimSaddle::At(toward, on_rim) } else { RimSaddle::None };
        }
        toward = (toward + along_circle * turn.clamp(-longest, longest)).normalize();
    }
    RimSaddle::None
}

/// A normal that both flanks have.
struct OnFlanks {
    normal: Vector3<f64>,
    depth: f64,
    /// The point of the other's generator in the half-plane of the normal.
    deepest: Vector3<f64>,
}

/// The normals that both flanks have, n·a = sin γ and −n·b = sin γ', where the depth has a minimum.
fn flank_to_flank(one: &PlacedCone, other: &PlacedCone) -> [Option<OnFlanks>; 2] {
    let cosine = one.axis.dot(&other.axis);
    let level = other.axis - one.axis * cosine;
    let across = level.norm();
    let along = -(other.sine + one.sine * cosine) / (one.cosine * across);
    let beside = 1.0 - along * along;
    if !(across > 0.0 && beside >= 0.0) {
        return [None, None];
    }
    let ahead = one.rim_direction(&level);
    let side = one.axis.cross(&ahead);
    [beside.sqrt(), -beside.sqrt()].map(|beside| {
        let toward = ahead * along + side * beside;
        let normal = one.flank_normal(&toward);
        let on_rim = other.rim_point(&other.rim_direction(&-normal));
        let along_circle = one.axis.cross(&toward);
        let [from, to] = [other.apex, on_rim].map(|point| along_circle.dot(&(point - one.apex)));
        let share = if from == to { 0.5 } else { from / (from - to) };
        let deepest = other.apex + (on_rim - other.apex) * share;
        let depth = normal.dot(&(one.apex - other.apex)).max(normal.dot(&(one.apex - on_rim)));
        (0.0..=1.0).contains(&share).then_some(OnFlanks { normal, depth, deepest })
    })
}

/// Whether every normal of the flank has at least a depth of `limit`: proved arc by arc, once around the circle.
fn is_above(one: &PlacedCone, other: &PlacedCone, limit: f64, axes: &mut u32) -> bool {
    let first = -one.rim_direction(&(other.base - one.apex));
    let side = one.axis.cross(&first);
    // Grows with the angle from the first, from 0 to 4.
    let turned = |toward: &Vector3<f64>| {
        let (x, y) = (toward.dot(&first), toward.dot(&side));
        if y >= 0.0 { 1.0 - x } else { 3.0 + x }
    };
    let (mut toward, mut so_far) = (first, 0.0);
    for _ in 0..CIRCLE_STEPS {
        *axes += 1;
        let normal = one.flank_normal(&toward);
        let deepest = other.foremost(&-normal);
        if normal.dot(&(one.apex - deepest)) < limit {
            return false;
        }
        let point = one.below(&deepest);
        let cosine = (-limit - one.sine * point.along) / (one.cosine * point.distance);
        if !(cosine < 1.0) {
            return true;
        }
        let ahead = one.rim_direction(&point.across);
        let sine = (1.0 - cosine.max(-1.0).powi(2)).sqrt();
        toward = ahead * cosine.max(-1.0) - one.axis.cross(&ahead) * sine;
        let now = turned(&toward);
        if (now - so_far).abs() < LEAST_ARC {
            return false;
        }
        if now < so_far {
            return true;
        }
        so_far = now;
    }
    false
}
