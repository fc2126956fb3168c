//! Two cones: the least overlap over all axes that two smooth cones have.
//!
//! In A's axes, with B's centre d and axis b, the overlap along a unit direction n out of A is
//! depth(n) = h_A(n) + h_B(−n) − n·d, both support functions exact (see [`cone`](super::cone)). It
//! is least, and if it is ever negative it is negative, along one of these:
//!
//! - the normal of either base;
//! - a normal of A's flank, a circle of them: depth along it is smooth but where B's foremost point
//!   changes between apex and rim, which is where flank touches flank. These two normals, and that
//!   on which the flank is nearest to B's apex, have closed forms; minima against B's rim are
//!   bracketed by [`CIRCLE_SAMPLES`] and narrowed by golden section to 1e-9 rad, so that the depth
//!   is off by less than 1e-16 of the sizes. Likewise for B's flank;
//! - **rim against rim**: with ρ_A = √(1 − n_y²), ρ_B = √(1 − (n·b)²) and w from B's rim's centre
//!   to A's, depth(n) = r_A ρ_A + r_B ρ_B + n·w. Its gradient is x, the vector between the two
//!   foremost points, and on the sphere its Hessian r_A/ρ_A t_A t_Aᵀ + r_B/ρ_B t_B t_Bᵀ − depth·1,
//!   t the rims' tangents there: Newton's method takes a few steps from each of [`STARTS`].
//!
//! At other normals a rim and an apex, or two apices, touch alone, which bound the overlap only
//! together with their neighbours. Any direction's depth bounds the least from above and a
//! negative one proves them apart, so nothing here can lose an overlap; were a narrow minimum of
//! the last two kinds missed, a gap could count as touching. Random pairs against a brute-force
//! search are tested.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{
    ClipBuffers, Cone, Feature, Found, Least, Overlap, PairSearch, Segment, ShapePair, edge_contact, unit_across,
};
use crate::physics::collision::constants::{CIRCLE_SAMPLES, GOLDEN_STEPS, LONGEST_TURN, NEWTON_STEPS, ON_FLANK};
use crate::physics::{ContactPoint, FeatureId, contact};

/// The twelve corners of an icosahedron and the twenty of a dodecahedron, not normalised: no
/// direction is farther than 38° from all.
const STARTS: usize = 32;

/// Kinds of normals that [`Feature::Smooth`] tells apart.
const FLANK_OF_A: u32 = 0;
const FLANK_OF_B: u32 = 1;
const RIMS: u32 = 2;
/// The direction from centre to centre: never the least, but the cheapest that may separate.
const CENTERS: u32 = 3;

/// Tests two cones, B in A's axes; what was the last step's axis is tried first and replaced.
/// Contact points are left in the clip buffers, in A's axes.
pub(crate) fn touch(pair: &ShapePair<Cone, Cone>, search: &mut PairSearch) -> Option<Overlap> {
    let axes = &mut search.axes;
    let first = search.last.and_then(|last| pair.least_of(last, axes)).filter(|least| pair.separates(least));
    let found = first.map_or_else(|| pair.search(axes), |least| Err(least.feature));
    search.near(found)?.take(pair, search, |least, clip| pair.smooth_point(least, clip))
}

impl ShapePair<'_, Cone, Cone> {
    fn separates(&self, least: &Least) -> bool {
        self.scale.separates(least.depth)
    }

    /// The overlap or separation, or the feature along which that is beyond the gap.
    fn search(&self, axes: &mut u32) -> Result<Found, Feature> {
        let between = Feature::Smooth(CENTERS);
        if self.least_of(between, axes).is_some_and(|least| self.separates(&least)) {
            return Err(between);
        }
        let mut found: Option<Found> = None;
        for kinds in [
            &[Feature::FaceOfA(0)][..],
            &[Feature::FaceOfB(0)],
            &[Feature::Smooth(FLANK_OF_A), Feature::Smooth(FLANK_OF_B), Feature::Smooth(RIMS)],
        ] {
            let mut rival: Option<Least> = None;
            for &kind in kinds {
                let Some(of_kind) = self.least_of(kind, axes) else { continue };
                if self.separates(&of_kind) {
                    return Err(kind);
                }
                if rival.is_none_or(|rival| of_kind.depth < rival.depth) {
                    rival = Some(of_kind.rounded(self.scale));
                }
            }
            let Some(rival) = rival else { continue };
            found = Some(found.map_or(Found { least: rival, preferred: rival }, |Found { least, preferred }| Found {
                least: if rival.depth < least.depth { rival } else { least },
                preferred: if rival.depth < self.scale.limit(preferred.depth) { rival } else { preferred },
            }));
        }
        Ok(found.expect("a base is the best at first"))
    }

    /// The least overlap along axes of one kind.
    fn least_of(&self, kind: Feature, axes: &mut u32) -> Option<Least> {
        let mut best: Option<Least> = None;
        let mut take = |normal: Vector3<f64>| {
            *axes += 1;
            let depth = self.depth_along(&normal);
            if best.is_none_or(|best| depth < best.depth) {
                best = Some(Least { normal, depth, feature: kind });
            }
        };
        match kind {
            Feature::FaceOfA(_) => take(Cone::base_normal()),
            Feature::FaceOfB(_) => take(self.out_of_a(Cone::base_normal())),
            Feature::Smooth(FLANK_OF_A) => {
                self.flank_normals(|normal| self.depth_along(&normal), &mut take);
            }
            Feature::Smooth(FLANK_OF_B) => {
                let depth = |normal| self.depth_along(&self.out_of_a(normal));
                let a_in_b = self.b_in_a.inverse();
                self.swapped(&a_in_b).flank_normals(depth, &mut |normal| take(self.out_of_a(normal)));
            }
            Feature::Smooth(CENTERS) => _ = self.b_in_a.center.try_normalize(0.0).map(take),
            Feature::Smooth(RIMS) => starts().for_each(|start| take(self.descend(start))),
            Feature::Smooth(_) | Feature::Edges(..) => {}
        }
        best
    }

    /// Gives the normals of A's flank along which its overlap with B may be least. `depth` is that along a normal.
    fn flank_normals(&self, depth: impl Fn(Vector3<f64>) -> f64, take: &mut impl FnMut(Vector3<f64>)) {
        let &Self { a: cone, b: other, b_in_a: other_in_cone, .. } = self;
        // Nearest to the other's apex.
        take(cone.flank_normal(unit_across(&other_in_cone.place(&other.apex_point()))));
        // Where both flanks share a normal: n_y = sin γ and −n·b = sin γ'.
        let axis = other_in_cone.rotation.column(1);
        let across = axis.x.hypot(axis.z);
        if across > 0.0 {
            let along = -(other.sine + cone.sine * axis.y) / (cone.cosine * across);
            let beside = 1.0 - along * along;
            if beside >= 0.0 {
                let [x, z] = [axis.x / across, axis.z / across];
                for beside in [beside.sqrt(), -beside.sqrt()] {
                    take(cone.flank_normal([along * x - beside * z, along * z + beside * x]));
                }
            }
        }
        // Against the other's rim.
        let normal = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            cone.flank_normal([cos, sin])
        };
        let step = TAU / CIRCLE_SAMPLES as f64;
        let samples: [f64; CIRCLE_SAMPLES] = std::array::from_fn(|sample| depth(normal(step * sample as f64)));
        for sample in 0..CIRCLE_SAMPLES {
            let (before, after) = ((sample + CIRCLE_SAMPLES - 1) % CIRCLE_SAMPLES, (sample + 1) % CIRCLE_SAMPLES);
            if samples[sample] <= samples[before] && samples[sample] < samples[after] {
                let middle = step * sample as f64;
                take(normal(golden_section([middle - step, middle + step], |angle| depth(normal(angle)))));
            }
        }
    }

    /// Down to a minimum of the depth between the rims, alone, from a direction.
    fn descend(&self, start: Vector3<f64>) -> Vector3<f64> {
        let axis = self.b_in_a.rotation.column(1).into_owned();
        let between = Vector3::y() * self.a.base - (self.b_in_a.center + axis * self.b.base);
        // The depth, and the two rims' foremost directions with their radii over ρ.
        let measure = |n: &Vector3<f64>| {
            let (level, other_level) = (n - Vector3::y() * n.y, n - axis * n.dot(&axis));
            let [rho, other_rho] = [level.norm(), other_level.norm()].map(|rho| rho.max(1e-9));
            let gradient = level * (self.a.radius / rho) + other_level * (self.b.radius / other_rho) + between;
            let tangents = [Vector3::y().cross(&level) / rho, axis.cross(&other_level) / other_rho];
            (gradient.dot(n), gradient, tangents, [self.a.radius / rho, self.b.radius / other_rho])
        };
        let mut n = start;
        let (mut depth, mut gradient, mut tangents, mut bends) = measure(&n);
        for _ in 0..NEWTON_STEPS {
            let frame = contact::tangents(&n);
            let flat = |vector: &Vector3<f64>| Vector2::new(vector.dot(&frame[0]), vector.dot(&frame[1]));
            let slope = flat(&gradient);
            let [one, other] = [flat(&tangents[0]), flat(&tangents[1])];
            let hessian =
                one * one.transpose() * bends[0] + other * other.transpose() * bends[1] - Matrix2::identity() * depth;
            let mut step = newton_step(&hessian, &slope);
            let length = step.norm();
            if length < 1e-12 {
                break;
            }
            if length > LONGEST_TURN {
                step *= LONGEST_TURN / length;
            }
            let Some((next, measured)) = (0..8).find_map(|_| {
                let next = (n + frame[0] * step.x + frame[1] * step.y).normalize();
                let measured = measure(&next);
                step /= 2.0;
                (measured.0 < depth).then_some((next, measured))
            }) else {
                break;
            };
            n = next;
            (depth, gradient, tangents, bends) = measured;
        }
        n
    }

    /// Leaves the points where the smooth surfaces touch in the buffers: along two lines, or where one of them has one
    /// foremost point.
    fn smooth_point(&self, least: &Least, buffers: &mut ClipBuffers) {
        let Least { normal, depth, .. } = *least;
        let toward_a = -self.b_in_a.enter(&normal);
        let has_line = |cone: &Cone, normal: &Vector3<f64>| (normal.y - cone.sine).abs() < ON_FLANK;
        let (line_a, line_b) = (has_line(self.a, &normal), has_line(self.b, &toward_a));
        let feature = FeatureId::of_vertex(false, u32::from(line_a) << 1 | u32::from(line_b));
        buffers.found.clear();
        if line_a && line_b {
            let on_a = Segment([self.a.apex_point(), self.a.rim_point(unit_across(&normal))]);
            let on_b = [self.b.apex_point(), self.b.rim_point(unit_across(&toward_a))];
            let on_b = Segment(on_b.map(|end| self.b_in_a.place(&end)));
            edge_contact::touch(&on_a, &on_b, &Overlap { normal, depth }, feature, self.scale, &mut buffers.found);
            return;
        }
        let point = if line_a {
            self.b_in_a.place(&self.b.foremost(&toward_a)) + normal * (depth / 2.0)
        } else {
            self.a.foremost(&normal) - normal * (depth / 2.0)
        };
        buffers.found.push(ContactPoint { point, depth, feature });
    }
}

/// The least of a function that has one minimum between the ends.
fn golden_section([mut low, mut high]: [f64; 2], function: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (5_f64.sqrt() - 1.0);
    let mut inner = [high - share * (high - low), low + share * (high - low)];
    let mut values = inner.map(&function);
    for _ in 0..GOLDEN_STEPS {
        if values[0] <= values[1] {
            high = inner[1];
            inner = [high - share * (high - low), inner[0]];
            values = [function(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + share * (high - low)];
            values = [values[1], function(inner[1])];
        }
    }
    if values[0] <= values[1] { inner[0] } else { inner[1] }
}

/// Newton's step to a minimum, or down the slope where the function bends the other way.
fn newton_step(hessian: &Matrix2<f64>, slope: &Vector2<f64>) -> Vector2<f64> {
    let determinant = hessian.determinant();
    if determinant > 0.0 && hessian.trace() > 0.0 {
        let [[xx, xy], [_, yy]] = [[hessian[(0, 0)], hessian[(0, 1)]], [hessian[(1, 0)], hessian[(1, 1)]]];
        return -Vector2::new(yy * slope.x - xy * slope.y, xx * slope.y - xy * slope.x) / determinant;
    }
    -slope / slope.norm().max(f64::MIN_POSITIVE) * LONGEST_TURN
}

fn starts() -> impl Iterator<Item = Vector3<f64>> {
    let golden = 0.5 * (1.0 + 5_f64.sqrt());
    (0..STARTS).map(move |index| {
        let sign = |bit: usize| if index >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let turned = |turns: usize, vector: Vector3<f64>| (0..turns).fold(vector, |vector, _| vector.yzx());
        let start = match index {
            0..12 => turned(index / 4, Vector3::new(0.0, sign(0), sign(1) * golden)),
            12..24 => turned(index / 4 - 3, Vector3::new(0.0, sign(0) * golden, sign(1) / golden)),
            _ => Vector3::new(sign(0), sign(1), sign(2)),
        };
        start.normalize()
    })
}
