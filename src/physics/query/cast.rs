//! Where a shape that moves straight on, without turning, first touches another.
//!
//! Two shapes of which none is round about a point or a segment: by two bounds that meet ([`first_touch`](super::first_touch)).
//! The contact points of such a pair would not do: between faces and edges that are nearly as good they prefer the faces,
//! so that neither their normal nor their place is that of the first touch, and where edges cross at a small angle no sequence
//! of projections leads there. Between two rims each look for them takes as long as some thirty steps of the bounds.
//!
//! A ball and what is round about a point or a segment: in closed form, as a ray that enters what is larger by the ball
//! ([`ray`](super::ray)).
//!
//! All others: by conservative advancement, as of bodies that move fast ([`time_of_impact`](crate::physics::collision)).
//! Shapes that are apart by s along a unit n from the one that moves to the other come together along n by n·d for each
//! metre, and by no more along any way. So it is moved on by s/(n·d) and looked at again; where n·d ≤ 0 they are apart
//! along n for ever. Where one is curved that is Newton's method for the distance.

use nalgebra::{Matrix3, Vector3};

use super::asker::Asker;
use super::clear_way::{Clear, clear_way};
use super::first_touch::{Touch, first_touch};
use super::meeting::meet;
use super::ray::{Entry, enter_ball, enter_capsule};
use super::solid::{At, Outline, Solid, solid_of};
use crate::physics::box_tree::Way;
use crate::physics::collision::{Overlap, PartPair, place_at_part, touch};
use crate::physics::shape::Parts;
use crate::physics::{Body, ContactPoint, Geometry, PairSearch};

/// Cheap steps before an exact look at most, which takes as long as some ten of them: more tell little that it does not,
const STEPS_TO_ADVANCE: u32 = 12;

/// and before two bounds are sought that meet, whose own steps are as cheap.
const STEPS_TO_TOUCH: u32 = 4;

/// Looks at most; what grazes takes many.
const LOOKS: usize = 64;

/// Times that a contact point is moved into both shapes, twice each: mostly one or two.
const PROJECTIONS: usize = 32;

/// Part of its radius by which shapes may be farther apart than is known, where something is sought between them.
const MARGIN: f64 = 1e-6;

/// Part of its radius by which a box of what moves is larger than that, as rounding might else leave something out.
const SLACK: f64 = 1e-9;

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

/// A shape on its way along a unit direction.
pub(super) struct Caster<'a> {
    mover: &'a Asker,
    direction: Vector3<f64>,
    /// Made for the first exact look.
    advanced: Option<Advanced>,
}

/// The shape where it is looked at, with buffers.
struct Advanced {
    at: Body,
    search: PairSearch,
    points: Vec<ContactPoint>,
}

impl<'a> Caster<'a> {
    pub fn new(mover: &'a Asker, direction: Vector3<f64>) -> Self {
        Self { mover, direction, advanced: None }
    }

    /// Where it first touches the other, within `most`, m.
    pub fn cast(&mut self, other: &Body, most: f64) -> Option<Impact> {
        let (mover, direction) = (self.mover, self.direction);
        let mut first: Option<Impact> = None;
        parts_on_the_way(mover, other, &direction, most, &mut |parts, most| {
            let nearer = self.cast_part(other, parts, most);
            if let Some(nearer) = nearer.filter(|it| first.is_none_or(|first| it.distance < first.distance)) {
                first = Some(nearer);
            }
            first.map_or(most, |first| first.distance)
        });
        first
    }

    /// Where those parts of the two first touch.
    fn cast_part(&mut self, other: &Body, parts: PartPair, most: f64) -> Option<Impact> {
        let Self { mover, direction, advanced } = self;
        let solids = [mover.solid(parts.a, &other.position), solid_of(other, parts.b, &other.position)];
        let [Some(of_mover), Some(of_other)] = solids else {
            let clear = Clear { distance: 0.0, within: f64::INFINITY };
            return Advanced::of(advanced, mover).advance(mover, other, parts, direction, clear, most);
        };
        match round_way(&of_mover, &of_other, direction) {
            RoundWay::Past => return None,
            RoundWay::Touch(impact) => {
                let at = Impact { point: impact.point + other.position, ..impact };
                return (at.distance <= most).then_some(at);
            }
            RoundWay::Unknown | RoundWay::Overlapping => {}
        }
        let is_advanced = of_mover.is_round() || of_other.is_round();
        let steps = if is_advanced { STEPS_TO_ADVANCE } else { STEPS_TO_TOUCH };
        let clear = clear_way(&of_mover, &of_other, direction, most, steps)?;
        if is_advanced {
            return Advanced::of(advanced, mover).advance(mover, other, parts, direction, clear, most);
        }
        if clear.distance == 0.0
            && meet(&of_mover, &of_other) != Some(false)
            && let Some(impact) = Advanced::of(advanced, mover).at_start(other, parts)
        {
            return Some(impact);
        }
        let mut impact = on_the_way(of_mover, of_other, direction, clear.distance, most)?;
        impact.point += other.position;
        Some(impact)
    }
}

/// Hands on the pairs of parts whose boxes meet on the way, the nearer first as far as one tree tells, and how far matters;
/// what is handed on to tells how far matters from then on.
fn parts_on_the_way(
    mover: &Asker,
    other: &Body,
    direction: &Vector3<f64>,
    most: f64,
    look: &mut dyn FnMut(PartPair, f64) -> f64,
) {
    let Some(of_other) = &other.geometry else { return };
    let (of_mover, at_mover) = (&mover.geometry, (mover.position, mover.axes));
    let at_other = (other.position, other.rotation.to_rotation_matrix().into_inner());
    match (of_mover.parts(), of_other.parts()) {
        (None, None) => {
            look(PartPair::default(), most);
        }
        (None, Some(parts)) => {
            let thing = Thing { geometry: of_mover, place: at_mover, radius: mover.radius };
            thing.meets((parts, at_other), *direction, most, |b, most| look(PartPair { a: 0, b }, most));
        }
        (Some(parts), None) => {
            let thing = Thing { geometry: of_other, place: at_other, radius: other.radius };
            thing.meets((parts, at_mover), -direction, most, |a, most| look(PartPair { a, b: 0 }, most));
        }
        // Of two meshes there are no solids: they never touch.
        (Some(parts), Some(of_other)) if parts.is_mesh() => {
            each_solid((of_other, at_other), most, |b, solid, most| {
                solid.meets((parts, at_mover), -direction, most, |a, most| look(PartPair { a, b }, most))
            });
        }
        (Some(of_mover), Some(parts)) => {
            each_solid((of_mover, at_mover), most, |a, solid, most| {
                solid.meets((parts, at_other), *direction, most, |b, most| look(PartPair { a, b }, most))
            });
        }
    }
}

/// A convex solid where it is.
struct Thing<'g> {
    geometry: &'g Geometry,
    place: At,
    radius: f64,
}

impl Thing<'_> {
    /// Hands on the parts of another body whose boxes its own box meets on its way, as [`parts_on_the_way`] does, and tells
    /// how far matters then.
    fn meets(
        &self,
        (parts, (position, axes)): (&Parts, At),
        direction: Vector3<f64>,
        most: f64,
        mut look: impl FnMut(u32, f64) -> f64,
    ) -> f64 {
        let (place, own) = self.place;
        let mut so_far = most;
        let mut look = |part: u32, most: f64| {
            so_far = look(part, most);
            so_far
        };
        let Some([low, high]) = self.geometry.reach(&axes.tr_mul(&own)) else {
            // A half-space is everywhere.
            (0..parts.solids().len() as u32).fold(most, |most, part| look(part, most));
            return so_far;
        };
        let slack = SLACK * self.radius;
        let (low, high) = (low.add_scalar(-slack), high.add_scalar(slack));
        let way = Way::new(&axes.tr_mul(&(place - position)), &axes.tr_mul(&direction));
        parts.tree().search(most, |bounds| way.enters(&(bounds.low - high), &(bounds.high - low)), look);
        so_far
    }
}

/// Hands on each solid where it is, by its number, and how far matters, which each tells anew.
fn each_solid((parts, (position, axes)): (&Parts, At), most: f64, mut look: impl FnMut(u32, &Thing, f64) -> f64) {
    (0..).zip(parts.solids()).fold(most, |most, (index, solid)| {
        let place = (position + axes * solid.position, axes * solid.rotation.to_rotation_matrix().into_inner());
        look(index, &Thing { geometry: &solid.geometry, place, radius: solid.radius }, most)
    });
}

impl Advanced {
    /// The shape at the start, made where there is none yet.
    fn of<'a>(advanced: &'a mut Option<Self>, mover: &Asker) -> &'a mut Self {
        let new = || Self { at: mover.body().clone(), search: PairSearch::default(), points: Vec::new() };
        let advanced = advanced.get_or_insert_with(new);
        advanced.at.position = mover.position;
        advanced
    }

    /// Where those parts of the two first touch, by conservative advancement from where the way is clear to.
    fn advance(
        &mut self,
        mover: &Asker,
        other: &Body,
        parts: PartPair,
        direction: &Vector3<f64>,
        clear: Clear,
        most: f64,
    ) -> Option<Impact> {
        let Self { at, search, points } = self;
        let Clear { mut distance, mut within } = clear;
        let margin = MARGIN * mover.radius;
        at.position = mover.position + direction * distance;
        for look in 1..=LOOKS {
            let gap = (most - distance).min(within + margin);
            let overlap = touch_along_any([at, other], parts, gap, search, points);
            if overlap.is_none() && gap < most - distance {
                within = f64::INFINITY;
                continue;
            }
            let overlap = overlap?;
            let (separation, approach) = (-overlap.depth, overlap.normal.dot(direction));
            let is_last = look == LOOKS;
            if separation <= 0.0 || is_last {
                let deepest = deepest(points)?;
                // A face was preferred to edges that are apart by little more than it.
                let Some(left) = left_apart([at, other], parts, search, points).filter(|_| !is_last) else {
                    let point = common_point([at, other], parts, deepest);
                    return Some(Impact { distance, point, normal: -overlap.normal });
                };
                distance += left;
                within += left;
            } else if approach <= 0.0 {
                return None;
            } else {
                distance += separation / approach;
                within += separation / approach;
            }
            if distance > most {
                return None;
            }
            at.position = mover.position + direction * distance;
        }
        unreachable!("the last look returns")
    }

    /// Where those parts of the two touch from the start.
    fn at_start(&mut self, other: &Body, parts: PartPair) -> Option<Impact> {
        let Self { at, search, points } = self;
        let overlap = touch_along_any([at, other], parts, 0.0, search, points)?;
        let point = common_point([at, other], parts, deepest(points)?);
        Some(Impact { distance: 0.0, point, normal: -overlap.normal })
    }
}

/// How a ball and a ball or a capsule come together.
enum RoundWay {
    /// Other shapes: nothing is told.
    Unknown,
    Past,
    /// From where they are: along which they move apart first is not told.
    Overlapping,
    Touch(Impact),
}

/// Where a ball and a ball or a capsule first touch, in closed form: the ball's middle enters what is larger by its radius.
fn round_way(mover: &Solid, other: &Solid, direction: &Vector3<f64>) -> RoundWay {
    let (Outline::Solid(of_mover), Outline::Solid(of_other)) = (&mover.shape, &other.shape) else {
        return RoundWay::Unknown;
    };
    let between = mover.position - other.position;
    let into = |radius: f64, half: f64, axes: &Matrix3<f64>, from: Vector3<f64>, along: Vector3<f64>| {
        let entry = enter_capsule(radius, half, &axes.tr_mul(&from), &axes.tr_mul(&along))?;
        Some(Entry { normal: axes * entry.normal, ..entry })
    };
    // Out of the other, and whether the other is the ball.
    let (entry, ball) = match (of_mover, of_other) {
        (Geometry::Sphere { radius: own }, Geometry::Sphere { radius }) => {
            (enter_ball(own + radius, &between, direction), Some(radius))
        }
        (Geometry::Capsule { radius: own, half, .. }, Geometry::Sphere { radius }) => {
            let entry = into(own + radius, *half, &mover.axes, -between, -direction);
            (entry.map(|entry| Entry { normal: -entry.normal, ..entry }), Some(radius))
        }
        (Geometry::Sphere { radius: own }, Geometry::Capsule { radius, half, .. }) => {
            (into(own + radius, *half, &other.axes, between, *direction), None)
        }
        _ => return RoundWay::Unknown,
    };
    let Some(Entry { distance, normal }) = entry else { return RoundWay::Past };
    if distance == 0.0 {
        return RoundWay::Overlapping;
    }
    let point = match ball {
        Some(radius) => other.position + normal * *radius,
        None => mover.position + direction * distance - normal * mover.radius,
    };
    RoundWay::Touch(Impact { distance, point, normal })
}

/// Where a solid first touches another that it does not touch from the start, nor before it has come that far, m; the point
/// from where their positions are measured.
fn on_the_way(mut mover: Solid, other: Solid, direction: &Vector3<f64>, clear: f64, most: f64) -> Option<Impact> {
    mover.position += direction * clear;
    let Touch { distance, point, normal } = first_touch(&mover, &other, direction, most - clear)?;
    mover.position += direction * distance;
    let is_ahead = clear + distance > 0.0 && other.faces(&mover.position) && mover.faces(&other.position);
    is_ahead.then_some(Impact { distance: clear + distance, point, normal })
}

/// The place of the deepest of some contact points.
fn deepest(points: &[ContactPoint]) -> Option<Vector3<f64>> {
    points.iter().max_by(|one, other| one.depth.total_cmp(&other.depth)).map(|point| point.point)
}

/// The contact points of parts that are apart by no more than a gap, m, along any normal, whether or not a mesh has it.
fn touch_along_any(
    bodies: [&Body; 2],
    parts: PartPair,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    points.clear();
    // What another shape was tested by is no help here.
    search.last = None;
    (search.any_normal, search.is_sheet) = (true, true);
    let overlap = touch(bodies, parts, gap, search, points);
    (search.any_normal, search.is_sheet) = (false, false);
    overlap
}

/// A point of both bodies' parts, which touch, near one where a contact point is, which may be beside a side of a face by a
/// little: the nearest point of each, of one after the other (von Neumann's alternating projections). Where edges cross at a
/// small angle that comes nearer by as small a share each time, so that the limit of such a sequence is tried (Aitken's Δ²).
fn common_point(bodies: [&Body; 2], parts: PartPair, start: Vector3<f64>) -> Vector3<f64> {
    let enough = SLACK * bodies[0].radius;
    let (mut point, mut best) = (start, (start, f64::INFINITY));
    for _ in 0..PROJECTIONS {
        let first = projected(bodies, parts, point).0;
        let (second, off) = projected(bodies, parts, first);
        if off < best.1 {
            best = (second, off);
        }
        if off <= enough {
            break;
        }
        let [before, after] = [first - point, second - first];
        let share = after.dot(&before) / before.norm_squared();
        point = if share > 0.0 && share < 1.0 { second + after * (share / (1.0 - share)) } else { second };
    }
    best.0
}

/// The nearest point of the first's part, then of the second's to that, and by how much the farther of both was off.
fn projected([mover, other]: [&Body; 2], parts: PartPair, mut point: Vector3<f64>) -> (Vector3<f64>, f64) {
    let mut off = 0.0_f64;
    for (body, part) in [(mover, parts.a), (other, parts.b)] {
        let Some(geometry) = &body.geometry else { continue };
        let local = body.rotation.inverse_transform_vector(&(point - body.position));
        let (normal, height) = place_at_part(geometry, part, &local, body.radius);
        if height > 0.0 {
            point -= body.rotation * (normal * height);
            off = off.max(height);
        }
    }
    (point, off)
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
