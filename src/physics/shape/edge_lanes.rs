//! Edges of a polyhedron, eight at a time in `f32`: which of them the separating axis test need look at.
//!
//! Answers err on one side alone. An edge is left out only where it would be by more than rounding can have made of it;
//! of those that stay, the test measures all in `f64`. So the outcome of the test is the same to the bit as if every
//! edge had been measured.

use nalgebra::{SimdPartialOrd, SimdValue, Vector3};
use simba::simd::{SimdComplexField, WideBoolF32x8, WideF32x8};

use crate::physics::lanes::{Lanes, WIDTH, dot};

/// Rounding of a length, as a share of the sizes and distances that it was computed from; several times what `f32`
/// makes of a dozen operations.
const ROUNDING: f64 = 4e-6;
/// Products of cosines nearer to zero than this may have either sign.
const COSINE_ROUNDING: f64 = 2e-6;
/// Cosine between a normal and its arc below which its sign is not trusted.
const FLAT: f64 = 1e-4;

type V = Vector3<WideF32x8>;

/// Eight edges, each with the normals of the faces beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EdgeLanes {
    start: V,
    direction: V,
    normals: [V; 2],
    /// Of the angle between the normals.
    cosine: WideF32x8,
}

/// One edge: its start, its unit direction, and the normals beside it.
pub(crate) type EdgeParts = (Vector3<f64>, Vector3<f64>, [Vector3<f64>; 2]);

fn each(value: impl Fn(usize) -> f64) -> WideF32x8 {
    WideF32x8::each(|lane| value(lane) as f32)
}

fn vectors(vector: impl Fn(usize) -> Vector3<f64>) -> V {
    V::from_fn(|axis, _| each(|lane| vector(lane)[axis]))
}

fn all(value: f64) -> WideF32x8 {
    WideF32x8::of(value)
}

fn all_of(vector: &Vector3<f64>) -> V {
    vector.map(all)
}

fn bits(mask: WideBoolF32x8) -> u32 {
    mask.0.to_bitmask()
}

impl EdgeLanes {
    /// Of any number of edges; the last lanes repeat the last edge.
    pub fn of(count: usize, edge: impl Fn(usize) -> EdgeParts) -> impl Iterator<Item = Self> {
        let eights = (0..count).step_by(WIDTH);
        eights.map(move |first| Self::eight(|lane| edge((first + lane).min(count - 1))))
    }

    fn eight(edge: impl Fn(usize) -> EdgeParts) -> Self {
        let edges: [EdgeParts; WIDTH] = std::array::from_fn(edge);
        Self {
            start: vectors(|lane| edges[lane].0),
            direction: vectors(|lane| edges[lane].1),
            normals: [0, 1].map(|side| vectors(|lane| edges[lane].2[side])),
            cosine: each(|lane| edges[lane].2[0].dot(&edges[lane].2[1])),
        }
    }

    /// The lanes, as bits, of edges beyond which a point may lie by `least` or more along some direction of their arcs.
    /// `size` is the largest length involved, m.
    #[inline]
    pub fn below(&self, point: &Vector3<f64>, least: f64, size: f64) -> u32 {
        let arm = all_of(point) - self.start;
        let [one, other] = self.normals.each_ref().map(|normal| dot(normal, &arm));
        let is_between = one.simd_gt(self.cosine * other) & other.simd_gt(self.cosine * one);
        // Not by squares and a difference: what is left of that is noise where the arm lies along the edge.
        let across = arm - self.direction * dot(&self.direction, &arm);
        let height = dot(&across, &across).simd_sqrt().select(is_between, one.simd_max(other));
        bits(height.simd_ge(all(least - ROUNDING * size)))
    }

    /// The lanes, as bits, of edges, given mirrored, whose arcs may cross that of another, where the depth across the
    /// two may be `limit` or less.
    #[inline]
    pub fn crossing(&self, (start, direction, normals): &EdgeParts, limit: f64, size: f64) -> u32 {
        let (direction, normals) = (all_of(direction), normals.each_ref().map(all_of));
        let rounding = all(COSINE_ROUNDING);
        let [a, b] = normals.each_ref().map(|normal| dot(normal, &self.direction));
        let [c, d] = self.normals.each_ref().map(|normal| dot(normal, &direction));
        let point = normals[0] * b.simd_abs() + normals[1] * a.simd_abs();
        let other_point = self.normals[0] * d.simd_abs() + self.normals[1] * c.simd_abs();
        let crosses =
            (a * b).simd_lt(rounding) & (c * d).simd_lt(rounding) & dot(&point, &other_point).simd_gt(-rounding);
        if !crosses.0.any() {
            return 0;
        }
        // The depth times the sine of the angle between the edges, which may be small.
        let across = direction.cross(&self.direction);
        let sine = dot(&across, &across).simd_sqrt();
        let out = dot(&across, &(normals[0] + normals[1]));
        let between = all_of(start) - self.start;
        let depth = dot(&across, &between) * all(1.0).select(out.simd_gt(all(0.0)), all(-1.0));
        let is_near = depth.simd_le(sine * all(limit) + all(ROUNDING * size));
        bits(crosses & (is_near | out.simd_abs().simd_lt(sine * all(FLAT) + rounding)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing::Random;

    fn unit(random: &mut Random) -> Vector3<f64> {
        loop {
            let vector = Vector3::from_fn(|_, _| random.within(-1.0, 1.0));
            if (0.01..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    /// Two faces that meet in an edge under some angle, often a flat one.
    fn edge(random: &mut Random) -> EdgeParts {
        let direction = unit(random);
        let normal = direction.cross(&unit(random)).normalize();
        let angle = random.within(-14.0, 0.0).exp2() * 3.0;
        let other = normal * angle.cos() + direction.cross(&normal) * angle.sin();
        (unit(random) * random.within(0.1, 1.0), direction, [normal, other])
    }

    fn height_of((start, direction, [one, other]): &EdgeParts, point: &Vector3<f64>) -> f64 {
        // The greatest along many directions of the arc.
        let _ = direction;
        let arm = point - start;
        (0..=4000)
            .map(|step| f64::from(step) / 4000.0)
            .fold(f64::NEG_INFINITY, |most, share| most.max(one.lerp(other, share).normalize().dot(&arm)))
    }

    #[test]
    fn no_edge_below_a_point_is_left_out_and_most_others_are() {
        let mut random = Random::new(3);
        let (mut kept, mut needed) = (0, 0);
        for _ in 0..100 {
            let edges: Vec<EdgeParts> = (0..11).map(|_| edge(&mut random)).collect();
            let lanes: Vec<_> = EdgeLanes::of(edges.len(), |index| edges[index]).collect();
            let point = unit(&mut random) * 2.0;
            let least = random.within(0.5, 2.0);
            for (index, edge) in edges.iter().enumerate() {
                let is_kept = lanes[index / WIDTH].below(&point, least, 3.0) >> (index % WIDTH) & 1 == 1;
                let is_needed = height_of(edge, &point) >= least;
                assert!(is_kept || !is_needed, "{edge:?}, {point}");
                kept += u32::from(is_kept);
                needed += u32::from(is_needed);
            }
        }
        assert!(needed > 200 && kept <= needed + 5, "{needed} of 1100 are needed and {kept} kept");
    }

    #[test]
    fn no_crossing_of_arcs_is_left_out_and_most_others_are() {
        let mut random = Random::new(4);
        let (mut kept, mut needed) = (0, 0);
        for _ in 0..16_000 {
            let (a, others) = (edge(&mut random), [0; WIDTH].map(|_| edge(&mut random)));
            let limit = random.within(-0.5, 0.5);
            let mask = EdgeLanes::of(WIDTH, |index| others[index]).next().unwrap().crossing(&a, limit, 2.0);
            for (lane, b) in others.iter().enumerate() {
                // In f64, as the test of two polyhedra has it.
                let [one, two] = a.2.map(|normal| normal.dot(&b.1));
                let [three, four] = b.2.map(|normal| normal.dot(&a.1));
                let point = a.2[0] * two.abs() + a.2[1] * one.abs();
                let other_point = b.2[0] * four.abs() + b.2[1] * three.abs();
                let crosses = one * two < 0.0 && three * four < 0.0 && point.dot(&other_point) > 0.0;
                let across = a.1.cross(&b.1);
                let normal = across / across.norm().copysign(across.dot(&(a.2[0] + a.2[1])));
                let is_needed = crosses && normal.dot(&(a.0 - b.0)) <= limit;
                let is_kept = mask >> lane & 1 == 1;
                assert!(is_kept || !is_needed, "{a:?}, {b:?}");
                kept += u32::from(is_kept);
                needed += u32::from(is_needed);
            }
        }
        assert!(needed > 200 && kept < 2 * needed, "{needed} of 128 000 are needed and {kept} kept");
    }
}
