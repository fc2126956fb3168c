//! The least overlap of two cones by search over all normals, for tests: what the closed forms replaced.
//!
//! Minima of the overlap around each flank's circle of normals are bracketed by [`CIRCLE_SAMPLES`]
//! and narrowed by golden section to 1e-9 rad, so that the depth is off by less than 1e-16 of the
//! sizes. **Rim against rim**: with ρ_A = √(1 − n_y²), ρ_B = √(1 − (n·b)²) and w from B's rim's
//! centre to A's, depth(n) = r_A ρ_A + r_B ρ_B + n·w. Its gradient is x, the vector between the two
//! foremost points, and on the sphere its Hessian r_A/ρ_A t_A t_Aᵀ + r_B/ρ_B t_B t_Bᵀ − depth·1, t the
//! rims' tangents there: Newton's method takes a few steps from each of [`STARTS`].

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::cone_search::golden_section;
use super::{Cone, ShapePair, unit_across};
use crate::physics::contact;

/// The twelve corners of an icosahedron and the twenty of a dodecahedron, not normalised: no
/// direction is farther than 38° from all.
const STARTS: usize = 32;
/// Samples of the depth around a flank's circle of normals, one beside each minimum.
const CIRCLE_SAMPLES: usize = 24;
/// Steps of Newton's method from each start; most need five.
const NEWTON_STEPS: u32 = 12;
/// Longest step of Newton's method, rad.
const LONGEST_TURN: f64 = 0.4;

impl ShapePair<'_, Cone, Cone> {
    /// The normal across smooth surfaces, out of A, along which two cones overlap least, and the depth.
    pub fn least_by_search(&self) -> (Vector3<f64>, f64) {
        let depth_along = |normal: Vector3<f64>| self.depth_along(&normal);
        let mut best = (Vector3::y(), f64::INFINITY);
        let mut take = |normal: Vector3<f64>| {
            let depth = depth_along(normal);
            if depth < best.1 {
                best = (normal, depth);
            }
        };
        self.flank_normals(depth_along, &mut take);
        let a_in_b = self.b_in_a.inverse();
        let depth = |normal| depth_along(self.out_of_a(normal));
        self.swapped(&a_in_b).flank_normals(depth, &mut |normal| take(self.out_of_a(normal)));
        starts().for_each(|start| take(self.descend(start)));
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
