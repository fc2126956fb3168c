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
//! method), or one between both, where flank touches flank (a closed form).
//!
//! Lengths and directions are taken in the axes ([`View`]) in which the other's axis is b = (b₁, 0, b_a) and ρ = (cos φ,
//! sin φ, 0). With q the centre of its base, m = n·b and σ = √(1 − m²), the depth to its rim is, primes d/dφ,
//!
//!   f = −n·q + r σ,  f' = −n'·q − r m m'/σ,  f'' = cos γ ρ·q − r (m'² + m m'')/σ − r (m m')²/σ³,
//!   m' = −cos γ b₁ sin φ,  m'' = −cos γ b₁ cos φ.
//!
//! There is no such z where the other cone lies about the axis: the function of ρ is then least at
//! no saddle. That no normal is below the limit is proved by going around the circle: where a
//! depth g_z(ρ) exceeds the limit, it does so on an arc that has a closed form ([`View::is_above`]).

use nalgebra::{Vector2, Vector3};

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
    let view = View::new(one, other);
    let found = view.least(limit, small, axes);
    let place = |point: &Place| one.apex + view.turned_back(one, &point.across) + one.rim.axis * point.along;
    match found {
        Known::Least { toward, depth, deepest } => OfFlank::Least {
            normal: one.flank_normal(&view.turned_back(one, &toward)),
            depth,
            deepest: place(&deepest),
        },
        Known::Above(point) => OfFlank::Above(point.map(|point| place(&point))),
        Known::Unknown => OfFlank::Unknown,
    }
}

/// A point, from the apex of the flank.
#[derive(Clone, Copy)]
struct Place {
    across: Vector2<f64>,
    along: f64,
}

/// Likewise, in the axes of the view.
enum Known {
    Least { toward: Vector2<f64>, depth: f64, deepest: Place },
    Above(Option<Place>),
    Unknown,
}

/// The other cone, as the flank sees it.
struct View {
    /// Of the flank's normals.
    sine: f64,
    cosine: f64,
    /// The first of the axes across the flank's axis.
    ahead: Vector3<f64>,
    /// What of the other's axis lies along that, b₁, and along the flank's axis, b_a.
    tilt: [f64; 2],
    apex: Place,
    base: Place,
    radius: f64,
    other_sine: f64,
}

impl View {
    fn new(one: &PlacedCone, other: &PlacedCone) -> Self {
        let along = one.rim.axis.dot(&other.rim.axis);
        let ahead = one.rim.direction(&other.rim.axis);
        let side = one.rim.axis.cross(&ahead);
        let place = |point: &Vector3<f64>| {
            let arm = point - one.apex;
            Place { across: Vector2::new(arm.dot(&ahead), arm.dot(&side)), along: arm.dot(&one.rim.axis) }
        };
        Self {
            sine: one.sine,
            cosine: one.cosine,
            ahead,
            tilt: [ahead.dot(&other.rim.axis), along],
            apex: place(&other.apex),
            base: place(&other.rim.center),
            radius: other.rim.radius,
            other_sine: other.sine,
        }
    }

    fn turned_back(&self, one: &PlacedCone, across: &Vector2<f64>) -> Vector3<f64> {
        self.ahead * across.x + one.rim.axis.cross(&self.ahead) * across.y
    }

    /// v(z).
    fn height(&self, point: &Place) -> f64 {
        -(self.sine * point.along + self.cosine * point.across.norm())
    }

    /// g_z(ρ).
    fn depth(&self, toward: &Vector2<f64>, point: &Place) -> f64 {
        -(self.sine * point.along + self.cosine * point.across.dot(toward))
    }

    /// The point of the other's rim that is deepest behind a normal.
    fn on_rim(&self, toward: &Vector2<f64>) -> Place {
        let [tilt, along] = self.tilt;
        let m = self.cosine * tilt * toward.x + self.sine * along;
        let out = Vector3::new(m * tilt - self.cosine * toward.x, -self.cosine * toward.y, m * along - self.sine);
        let sigma = out.norm();
        let out = if sigma > 0.0 { out / sigma } else { Vector3::new(-along, 0.0, tilt) };
        Place { across: self.base.across + out.xy() * self.radius, along: self.base.along + out.z * self.radius }
    }

    fn least(&self, limit: f64, small: f64, axes: &mut u32) -> Known {
        let depth = self.height(&self.apex);
        *axes += 1;
        if depth >= limit {
            return Known::Above(Some(self.apex));
        }
        // The other's apex deepest of all.
        let toward = unit(&self.apex.across);
        let on_rim = self.on_rim(&toward);
        if self.depth(&toward, &on_rim) <= depth {
            return Known::Least { toward, depth, deepest: self.apex };
        }
        if self.height(&on_rim) >= limit {
            return Known::Above(Some(on_rim));
        }
        if let Some(Saddle { toward, on_rim }) = self.rim_saddle(limit, small, axes) {
            let depth = self.depth(&toward, &on_rim);
            if depth >= limit {
                return Known::Above(Some(on_rim));
            }
            if self.depth(&toward, &self.apex) <= depth {
                return Known::Least { toward, depth, deepest: on_rim };
            }
        }
        *axes += 1;
        let (mut least, mut lowest) = (None, limit);
        for OnFlanks { toward, depth, deepest } in self.on_flanks().into_iter().flatten() {
            if depth - self.height(&deepest) <= SADDLE_GAP * small {
                return Known::Least { toward, depth, deepest };
            }
            if depth < lowest {
                lowest = depth;
                least = Some(Known::Least { toward, depth, deepest: self.apex });
            }
        }
        if self.is_above(lowest - CIRCLE_SLACK * small, axes) {
            least.unwrap_or(Known::Above(None))
        } else {
            Known::Unknown
        }
    }

    /// The least depth against the other's rim alone, if it is at a point of that; or any point of the rim that is
    /// deeper than the limit.
    fn rim_saddle(&self, limit: f64, small: f64, axes: &mut u32) -> Option<Saddle> {
        let ([tilt, along], r, q) = (self.tilt, self.radius, &self.base.across);
        let mut toward = unit(q);
        let (mut last, mut longest) = (0.0, LONGEST_TURN);
        for _ in 0..FLANK_STEPS {
            *axes += 1;
            let [c, s] = [toward.x, toward.y];
            let lean = self.cosine * tilt;
            let (m, m1, m2) = (lean * c + self.sine * along, -lean * s, -lean * c);
            // 1 − m² is off by rounding near the other's axis, where the rim has no foremost point anyway.
            let inverse = 1.0 / (1.0 - m * m).max(f64::EPSILON).sqrt();
            let slide = m * m1 * inverse;
            let slope = self.cosine * (s * q.x - c * q.y) - r * slide;
            let bend = self.cosine * (c * q.x + s * q.y) - r * inverse * (m1 * m1 + m * m2 + slide * slide);
            let turn = if bend > small { -slope / bend } else { f64::INFINITY.copysign(-slope) };
            if turn * last < 0.0 {
                longest *= 0.5;
            }
            last = turn;
            let turn = turn.clamp(-longest, longest);
            // By the half angle's tangent, to third order.
            let half = 0.5 * turn;
            let scale = 1.0 / (1.0 + half * half);
            let [cosine, sine] = [(1.0 - half * half) * scale, 2.0 * half * scale];
            toward = Vector2::new(c * cosine - s * sine, s * cosine + c * sine);
            if turn.abs() < SETTLED_TURN.sqrt() {
                toward /= toward.norm();
                let on_rim = self.on_rim(&toward);
                let gap = self.depth(&toward, &on_rim) - self.height(&on_rim);
                if gap <= SADDLE_GAP * small || self.height(&on_rim) >= limit {
                    return Some(Saddle { toward, on_rim });
                }
                if turn.abs() < SETTLED_TURN {
                    return None;
                }
            }
        }
        None
    }

    /// The normals that both flanks have, n·a = sin γ and −n·b = sin γ', where the depth has a minimum.
    fn on_flanks(&self) -> [Option<OnFlanks>; 2] {
        let [tilt, along] = self.tilt;
        let ahead = -(self.other_sine + self.sine * along) / (self.cosine * tilt);
        let beside = 1.0 - ahead * ahead;
        if tilt <= 0.0 || beside < 0.0 {
            return [None, None];
        }
        [beside.sqrt(), -beside.sqrt()].map(|beside| {
            let toward = Vector2::new(ahead, beside);
            let on_rim = self.on_rim(&toward);
            let [from, to] = [&self.apex, &on_rim].map(|point| toward.perp(&point.across));
            let share = if from == to { 0.5 } else { from / (from - to) };
            let deepest = Place {
                across: self.apex.across.lerp(&on_rim.across, share),
                along: self.apex.along + (on_rim.along - self.apex.along) * share,
            };
            let depth = self.depth(&toward, &self.apex).max(self.depth(&toward, &on_rim));
            (0.0..=1.0).contains(&share).then_some(OnFlanks { toward, depth, deepest })
        })
    }

    /// Whether every normal of the flank has at least a depth of `limit`: proved arc by arc, once around the circle.
    fn is_above(&self, limit: f64, axes: &mut u32) -> bool {
        let first = -unit(&self.base.across);
        // Grows with the angle from the first, from 0 to 4.
        let turned = |toward: &Vector2<f64>| {
            let (x, y) = (first.dot(toward), first.perp(toward));
            if y >= 0.0 { 1.0 - x } else { 3.0 + x }
        };
        let (mut toward, mut so_far) = (first, 0.0);
        for _ in 0..CIRCLE_STEPS {
            *axes += 1;
            let on_rim = self.on_rim(&toward);
            let [of_apex, of_rim] = [&self.apex, &on_rim].map(|point| self.depth(&toward, point));
            let deepest = if of_apex > of_rim { &self.apex } else { &on_rim };
            if of_apex.max(of_rim) < limit {
                return false;
            }
            let distance = deepest.across.norm();
            let cosine = (-limit - self.sine * deepest.along) / (self.cosine * distance);
            if cosine >= 1.0 || cosine.is_nan() {
                return true;
            }
            let cosine = cosine.max(-1.0);
            let sine = (1.0 - cosine * cosine).sqrt();
            let ahead = deepest.across / distance;
            toward = Vector2::new(ahead.x * cosine + ahead.y * sine, ahead.y * cosine - ahead.x * sine);
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
}

/// Any for none.
fn unit(vector: &Vector2<f64>) -> Vector2<f64> {
    let length = vector.norm();
    if length > 0.0 { vector / length } else { Vector2::x() }
}

struct Saddle {
    toward: Vector2<f64>,
    on_rim: Place,
}

/// A normal that both flanks have.
struct OnFlanks {
    toward: Vector2<f64>,
    depth: f64,
    /// The point of the other's generator in the half-plane of the normal.
    deepest: Place,
}
