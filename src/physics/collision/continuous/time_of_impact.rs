//! Where two bodies first touch that move fast: by *conservative advancement* (Mirtich 1996, 2.3.2).
//!
//! A contact found ahead, at the poses of the start of the step, has the normal of those poses. For a body that moves
//! by less than its own size that is good enough. One that moves farther would be stopped by planes that it passes
//! beside, and a turn by a large angle would miss what it sweeps over. So both bodies of such a pair are taken along
//! their present velocities v, ω to where they first touch.
//!
//! Shapes that are apart by s along a unit n (from A to B) come together along it no faster than
//!
//!   μ = n·(v_A − v_B) + |ω_A × n| R_A + |ω_B × n| R_B,
//!
//! R the bounding radii. So nothing touches for a time s/μ, for ever if μ ≤ 0: the bodies are moved on by
//! that time and looked at again, until they are apart by no more than a tolerance, or the step is
//! over. The separating axis test gives s and n, and s need only be a lower bound of the distance.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::collision::constants::{IMPACT_TOLERANCE, MOST_ADVANCES};
use crate::physics::collision::gap::{Near, turning_speed};
use crate::physics::collision::manifold::{Overlap, PartPair};
use crate::physics::collision::narrow::contact_pair::{self, PairSearch};
use crate::physics::collision::parts::{PartShape, Placed, has_parts, is_mesh};
use crate::physics::{Body, ContactPoint, Geometry, RigidBody, rotation_by};

/// Where a pair is when it first touches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Impact {
    /// Since the start of the step, s.
    pub time: f64,
    /// Where both bodies are then.
    pub at: [Vector3<f64>; 2],
    pub overlap: Overlap,
}

/// Whether and where a pair touches within a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Course {
    /// It touches where it is.
    Touching,
    /// It touches nowhere.
    Apart,
    Impact(Impact),
}

/// The radius of a ball that the shape holds, about its centre of mass, m.
pub(crate) fn inner_radius(body: &Body) -> f64 {
    body.geometry.as_ref().map_or(f64::INFINITY, Geometry::inner_radius)
}

/// Whether a point of each of two bodies, or those parts of them, moves farther against the other within a time h, s, than
/// that is thick: then contacts sought ahead are not enough.
pub(crate) fn move_far([a, b]: [&Body; 2], parts: PartPair, h: f64) -> [bool; 2] {
    if !has_parts(a) && !has_parts(b) {
        let speed = |body: &Body| (a.linear - b.linear).norm() + turning_speed(body);
        return [a, b].map(|body| body.kind != RigidBody::Static && speed(body) * h > inner_radius(body));
    }
    let way = Near::of([a, b], parts).fastest_approach([a, b], h) * h;
    let shapes = [(a, parts.a), (b, parts.b)].map(|(body, part)| Placed::of(body, part).map(|placed| placed.shape));
    // What meets clusters was slow when parts were looked for, and has become faster by no more than their margin.
    if shapes.iter().flatten().any(PartShape::is_cluster) {
        return [false; 2];
    }
    let is_fast = |body: &Body, shape| match shape {
        Some(PartShape::Solid(shape)) => body.kind != RigidBody::Static && way > shape.inner_radius(),
        Some(PartShape::Facet(..)) | None => false,
    };
    [is_fast(a, shapes[0]), is_fast(b, shapes[1])]
}

/// How far two bodies, or those parts of them, may go against each other at least until what overlapped first does no more, m:
/// through a solid by as much as it is thick; what of a mesh a solid's middle has passed does not overlap it.
pub(crate) fn overlapping_way([a, b]: [&Body; 2], parts: PartPair) -> f64 {
    let shapes = [(a, parts.a), (b, parts.b)].map(|(body, part)| Placed::of(body, part).map(|placed| placed.shape));
    let solid = |shape: &PartShape| match shape {
        PartShape::Solid(shape) => shape.inner_radius(),
        PartShape::Facet(..) => 0.0,
    };
    shapes.iter().flatten().map(solid).sum()
}

/// Where a body's velocity takes it.
pub(crate) fn advanced(body: &Body, time: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    (body.position + body.linear * time, rotation_by(&(body.angular * time)) * body.rotation)
}

/// Whether bounding spheres whose centres are apart by `from` and then go by `way` against each other pass by each other
/// for certain, where their radii add up to `reach`, m. Most fast pairs of a heap do.
pub(crate) fn pass_by(from: &Vector3<f64>, way: &Vector3<f64>, reach: f64) -> bool {
    // Not a number where they keep their distance.
    let share = -from.dot(way) / way.norm_squared();
    let nearest = if share.is_finite() { from + way * share.clamp(0.0, 1.0) } else { *from };
    nearest.norm_squared() > reach * reach
}

/// Follows a pair through a time h, s. On impact the contact points, up to the gap that may yet close, are those of
/// the poses at the impact, world axes; otherwise there are none.
pub(crate) fn course(
    [a, b]: [&Body; 2],
    parts: PartPair,
    h: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Course {
    let tolerance = IMPACT_TOLERANCE * inner_radius(a).min(inner_radius(b));
    points.clear();
    if pass_by(&(b.position - a.position), &((b.linear - a.linear) * h), a.radius + b.radius + tolerance) {
        return Course::Apart;
    }
    let is_with_mesh = is_mesh(a) || is_mesh(b);
    let near = Near::of([a, b], parts);
    let fastest = near.fastest_approach([a, b], h);
    let (mut at_a, mut at_b, mut time) = (a.clone(), b.clone(), 0.0);
    for look in 0.. {
        points.clear();
        let reach = fastest * (h - time) + tolerance;
        // On the way to a mesh any normal tells how far it is.
        search.any_normal = true;
        let found = contact_pair::touch([&at_a, &at_b], parts, reach, search, points);
        search.any_normal = false;
        let Some(mut overlap) = found else { break };
        let separation = -overlap.depth;
        if separation <= tolerance || look == MOST_ADVANCES {
            if time == 0.0 {
                points.clear();
                return Course::Touching;
            }
            if is_with_mesh {
                points.clear();
                let Some(found) = contact_pair::touch([&at_a, &at_b], parts, reach, search, points) else { break };
                overlap = found;
            }
            return Course::Impact(Impact { time, at: [at_a.position, at_b.position], overlap });
        }
        let n = overlap.normal;
        let approach = near.approach_along([a, b], &n, h);
        // Half the tolerance is left, so that the end is reached.
        time += (separation - 0.5 * tolerance) / approach;
        if approach <= 0.0 || time >= h {
            break;
        }
        (at_a.position, at_a.rotation) = advanced(a, time);
        (at_b.position, at_b.rotation) = advanced(b, time);
    }
    points.clear();
    Course::Apart
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing::Random;

    #[test]
    fn spheres_pass_by_where_no_moment_of_many_has_them_within_reach() {
        let mut random = Random::new(40);
        let mut passed = 0;
        for _ in 0..1000 {
            let (from, way, reach) = (random.vector() * 2.0, random.vector() * 3.0, random.within(0.1, 2.0));
            let moments = (0..=1000).map(|moment| (from + way * (f64::from(moment) / 1000.0)).norm());
            let nearest = moments.fold(f64::INFINITY, f64::min);
            if (nearest - reach).abs() > 0.01 {
                assert_eq!(pass_by(&from, &way, reach), nearest > reach, "{from:?} {way:?} {reach}");
                passed += u32::from(nearest > reach);
            }
        }
        assert!((100..900).contains(&passed), "{passed}");
        assert!(pass_by(&Vector3::x(), &Vector3::zeros(), 0.5) && !pass_by(&Vector3::x(), &Vector3::zeros(), 1.5));
    }
}
