//! Two cones, rim against rim.
//!
//! With P on one rim, Q on the other and x = P − Q, the rims alone have a normal n = x/|x| (apart: −x/|x|)
//! where x is across both tangents t and u: at the minima of |x|² over both circles. In lengths s, s'
//! along the rims, e and f the directions of P and Q from their centres, the gradient and Hessian of ½|x|² are
//!
//!   (x·t, −x·u),   [1 − x·e/r, −t·u; −t·u, 1 + x·f/r'],
//!
//! and Newton's method takes a few steps ([`settle`]). A minimum of the overlap over all normals is one of
//! |x|² too: both Hessians have the same determinant, up to a positive factor.
//!
//! **Overlaps.** Of rims that overlap by less than a limit δ, P lies at most δ over or under the plane
//! of the other's base: two short arcs of the rim, or none. With h(φ) the height of P over that plane and R(φ) its
//! distance from the other's axis, the square of its distance from the other rim is
//! F² = h² + (R − r')². An arc of half angle w about φ is done where F(φ) > δ + r w; or where F² has no minimum,
//! or one, by bounds of its derivatives over the arc:
//!
//!   ½ (F²)' = h h' + (R − r') R',  ½ (F²)'' = h'² + R'² + h h'' + (R − r') R'',
//!   |h'|, |R'| ≤ r,  |h''| ≤ r s,  |R''| ≤ r + r²/R,
//!
//! s the sine of the angle between the axes. Else it is halved.

use nalgebra::Vector3;

use super::Rim;
use super::placed_cone::PlacedCone;
use crate::physics::collision::constants::{
    ARC_OVERLAP, LONGEST_TURN, RIM_ARCS, RIM_HALVINGS, RIM_MEETS, RIM_STEPS, SETTLED_TURN,
};

/// Points of two rims at which the distance between these has a minimum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RimsMeet {
    pub on_one: Vector3<f64>,
    pub on_other: Vector3<f64>,
    /// Directions of these from the centres of their rims.
    directions: [Vector3<f64>; 2],
    tangents: [Vector3<f64>; 2],
    /// Of the smaller rim.
    radius: f64,
}

impl RimsMeet {
    fn new(one: &Rim, other: &Rim, directions: [Vector3<f64>; 2]) -> Self {
        Self {
            on_one: one.point(&directions[0]),
            on_other: other.point(&directions[1]),
            directions,
            tangents: [one.axis.cross(&directions[0]), other.axis.cross(&directions[1])],
            radius: one.radius.min(other.radius),
        }
    }

    /// Unit, out of the first cone, if this is where the rims touch.
    pub fn normal(&self, small: f64) -> Option<Vector3<f64>> {
        let between = self.on_one - self.on_other;
        let distance = between.norm();
        let across = self.tangents[0].cross(&self.tangents[1]);
        let sine = across.norm();
        // Of both the one that rounding turns less.
        let normal = if distance > sine * self.radius { between / distance } else { across / sine };
        if distance.max(sine * self.radius) < small {
            return None;
        }
        let out = normal.dot(&(self.directions[0] - self.directions[1]));
        Some(normal * 1_f64.copysign(out))
    }

    /// A point of the first rim that lies in the other cone, if it dips into that.
    pub fn dip(&self, one: &Rim, other: &PlacedCone) -> Option<Vector3<f64>> {
        let below = |direction: &Vector3<f64>| one.point(direction);
        // Depths behind base and flank where the rim is nearest, and their growth along it.
        let depths = |point: &Vector3<f64>| {
            let base = (point - other.rim.center).dot(&other.rim.axis);
            [base, other.flank_depth(point)]
        };
        let flank = other.flank_normal(&self.directions[1]);
        let growth = [self.tangents[0].dot(&other.rim.axis), -self.tangents[0].dot(&flank)];
        let now = depths(&self.on_one);
        let slope = growth[0] - growth[1];
        let along = (now[1] - now[0]) / slope;
        let direction = (self.directions[0] + self.tangents[0] * (along / one.radius)).normalize();
        let point = below(&direction);
        other.holds(&point).then_some(point)
    }
}

/// From a direction of a point of the first rim to a minimum near it.
pub(crate) fn settle(one: &Rim, other: &Rim, start: Vector3<f64>, axes: &mut u32) -> Option<RimsMeet> {
    let mut e = start;
    let mut f = other.direction(&(one.point(&e) - other.center));
    for _ in 0..RIM_STEPS {
        *axes += 1;
        let (on_one, on_other) = (one.point(&e), other.point(&f));
        let x = on_one - on_other;
        let [t, u] = [one.axis.cross(&e), other.axis.cross(&f)];
        let slope = [x.dot(&t), -x.dot(&u)];
        let (ss, mixed, oo) = (1.0 - x.dot(&e) / one.radius, -t.dot(&u), 1.0 + x.dot(&f) / other.radius);
        let determinant = ss * oo - mixed * mixed;
        let is_bowl = determinant > 0.0 && ss + oo > 0.0;
        let turns = if is_bowl {
            [
                (mixed * slope[1] - oo * slope[0]) / (determinant * one.radius),
                (mixed * slope[0] - ss * slope[1]) / (determinant * other.radius),
            ]
        } else {
            [f64::INFINITY; 2]
        };
        let longest = turns[0].abs().max(turns[1].abs());
        if longest < LONGEST_TURN {
            e = (e + t * turns[0]).normalize();
            f = (f + u * turns[1]).normalize();
            if longest < SETTLED_TURN {
                return Some(RimsMeet::new(one, other, [e, f]));
            }
        } else {
            // The nearest points of either circle to the other's.
            e = one.direction(&(on_other - one.center));
            f = other.direction(&(one.point(&e) - other.center));
        }
    }
    None
}

/// Places where the rims overlap by less than a limit: minima of the distance.
pub(crate) type Overlaps = [Option<RimsMeet>; RIM_MEETS];

/// An arc of a rim: its middle, and how far its ends lie from that at most, as a share of the radius.
#[derive(Clone, Copy)]
struct Arc {
    middle: Vector3<f64>,
    chord: f64,
}

/// What of an arc is proved.
enum OfArc {
    /// No minimum below the limit.
    Above,
    /// At most one minimum.
    OneBowl,
    Unknown,
}

/// All places where the rims overlap by less than a limit, and maybe more; none where that cannot be proved.
pub(crate) fn overlaps(one: &Rim, other: &Rim, limit: f64, axes: &mut u32) -> Option<Overlaps> {
    let mut found = [None; RIM_MEETS];
    // The other rim, too, comes within the limit of this one's base.
    if arcs_near(other, one, limit).is_none() {
        return Some(found);
    }
    let Some([first, second]) = arcs_near(one, other, limit) else { return Some(found) };
    let mut arcs = [first; RIM_ARCS];
    arcs[1] = second;
    let (mut waiting, mut met) = (2, 0);
    for _ in 0..RIM_HALVINGS {
        if waiting == 0 {
            return Some(found);
        }
        waiting -= 1;
        let arc = arcs[waiting];
        *axes += 1;
        match arc.minima(one, other, limit) {
            OfArc::Above => continue,
            OfArc::OneBowl => {
                if let Some(meet) = settle(one, other, arc.middle, axes)
                    && (meet.directions[0] - arc.middle).norm() <= arc.chord
                {
                    *found.get_mut(met)? = Some(meet);
                    met += 1;
                    continue;
                }
            }
            OfArc::Unknown => {}
        }
        for half in arc.halves(one) {
            *arcs.get_mut(waiting)? = half;
            waiting += 1;
        }
    }
    None
}

impl Arc {
    fn minima(&self, one: &Rim, other: &Rim, limit: f64) -> OfArc {
        let (r, b) = (one.radius, &other.axis);
        let arm = one.point(&self.middle) - other.center;
        let height = arm.dot(b);
        let level = arm - b * height;
        let far = level.norm();
        let beyond = far - other.radius;
        let square = height * height + beyond * beyond;
        if square.sqrt() - r * self.chord > limit {
            return OfArc::Above;
        }
        let way = 1.05 * self.chord; // the half angle, of its chord
        let nearest = far - r * way;
        if self.chord > 1.0 || nearest <= 0.0 {
            return OfArc::Unknown;
        }
        let tangent = one.axis.cross(&self.middle) * r;
        let climb = tangent.dot(b);
        let away = level.dot(&tangent) / far;
        let slope = height * climb + beyond * away;
        let span = r * one.axis.cross(b).norm();
        let bends = [span, r + r * r / nearest];
        let drop = (height.abs() + r * way) * bends[0] + (beyond.abs() + r * way) * bends[1];
        if slope.abs() > way * (r * r + drop) {
            return OfArc::Above;
        }
        let steep = (climb * climb + away * away).sqrt() - way * (bends[0] + bends[1]);
        if steep > 0.0 && steep * steep > drop { OfArc::OneBowl } else { OfArc::Unknown }
    }

    fn halves(&self, rim: &Rim) -> [Self; 2] {
        let side = rim.axis.cross(&self.middle);
        let sine = 0.5 * self.chord;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let chord = (2.0 * (1.0 - cosine)).max(0.0).sqrt() + ARC_OVERLAP;
        [sine, -sine].map(|sine| Self { middle: self.middle * cosine + side * sine, chord })
    }
}

/// The arcs of a rim within a limit of the plane of the other's base: two, which may overlap, or none.
fn arcs_near(one: &Rim, other: &Rim, limit: f64) -> Option<[Arc; 2]> {
    let height = (one.center - other.center).dot(&other.axis);
    let level = other.axis - one.axis * one.axis.dot(&other.axis);
    let slant = level.norm();
    let span = one.radius * slant;
    if height.abs() > span + limit {
        return None;
    }
    let ahead = if slant > 0.0 { level / slant } else { one.direction(&level) };
    let side = one.axis.cross(&ahead);
    let at = |height_there: f64| {
        let cosine = ((height_there - height) / span).clamp(-1.0, 1.0);
        let cosine = if cosine.is_nan() { 1_f64.copysign(height_there) } else { cosine };
        [cosine, (1.0 - cosine * cosine).max(0.0).sqrt()]
    };
    let ([c, s], [d, t]) = (at(limit), at(-limit));
    let (x, y) = (c + d, s + t);
    let length = (x * x + y * y).sqrt();
    let [x, y] = if length > 0.0 { [x / length, y / length] } else { [0.0, 1.0] };
    let chord = (x - c).hypot(y - s).max((x - d).hypot(y - t)) + ARC_OVERLAP;
    Some([1.0, -1.0].map(|sign| Arc { middle: ahead * x + side * (sign * y), chord }))
}
