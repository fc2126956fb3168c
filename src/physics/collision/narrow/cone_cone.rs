//! Two cones: the least overlap over all axes that two smooth cones have.
//!
//! In A's axes, with B's centre d and axis b, the overlap along a unit direction n out of A is
//! depth(n) = h_A(n) + h_B(−n) − n·d, both support functions exact (see [`cone`](super::cone)). Of cones
//! that overlap it is least along one of these:
//!
//! - the normal of either base;
//! - a normal of either flank, a circle of them ([`cone_flank`](super::cone_flank));
//! - the line between the nearest points of **rim and rim** ([`cone_rims`](super::cone_rims)).
//!
//! At other normals a rim and an apex, or two apices, touch alone, along which the overlap has no
//! minimum; but cones apart may be nearest there. Apart, −depth is the distance where a normal has it
//! greatest, and that is proved by two points as far apart as that. The nearest point of a cone to
//! the other's apex has a closed form ([`ball`](super::ball)).
//!
//! **Proof.** The bases and flanks are measured in full, so the least is found once the rims are: where
//! a point of one cone lies in the other they overlap, and rims count only where they are nearer
//! to each other than the least so far. What is not proved is searched for
//! ([`cone_search`](super::cone_search)): some cones that overlap by about their size, or are parallel.
//!
//! **Apart.** Most pairs that are near are apart by more than the gap, which takes a few steps to find
//! ([`approach`](super::approach)). Of what is near, nothing depends on them.

use nalgebra::Vector3;

use super::approach::are_apart;
use super::axis_code::AxisCode;
use super::cone_flank::{OfFlank, least_of_flank};
use super::cone_rims::{self, RimsMeet};
use super::cone_search;
use super::placed_cone::PlacedCone;
use super::revolved::Revolved;
use super::{Cone, Feature, Found, Least, Overlap, PairSearch, ShapePair};
use crate::physics::collision::constants::SADDLE_GAP;

/// Tests two cones, B in A's axes; what was the last step's axis is tried first and replaced.
/// Contact points are left in the clip buffers, in A's axes.
pub(crate) fn touch(pair: &ShapePair<Cone, Cone>, search: &mut PairSearch) -> Option<Overlap> {
    let cones = [PlacedCone::upright(pair.a), PlacedCone::new(pair.b, pair.b_in_a)];
    let [a, b] = &cones;
    let between = |normal: &Vector3<f64>| b.foremost(&-normal) - a.foremost(normal);
    if are_apart(search, &pair.b_in_a.center, pair.scale.gap, between) {
        return None;
    }
    let found = Test { pair, cones: &cones, axes: &mut search.axes }.run();
    match found {
        Ok(found) => found.take(pair, search, |least, clip| pair.points_of_flanks(least, clip)),
        Err(Separated { normal, distance }) => {
            search.last = Some(Feature::Smooth(AxisCode::of(&normal).0));
            search.apart = distance;
            None
        }
    }
}

/// Apart by more than the gap.
struct Separated {
    normal: Vector3<f64>,
    /// At least, m.
    distance: f64,
}

struct Test<'t> {
    pair: &'t ShapePair<'t, Cone, Cone>,
    cones: &'t [PlacedCone; 2],
    axes: &'t mut u32,
}

/// The normal of least depth so far.
#[derive(Clone, Copy)]
struct Nearest {
    normal: Vector3<f64>,
    depth: f64,
    /// Whether the cones are known to be nowhere farther apart.
    is_distance: bool,
}

impl Test<'_> {
    /// The overlap or separation.
    fn run(&mut self) -> Result<Found, Separated> {
        let scale = self.pair.scale;
        let of_a = self.base(Cone::base_normal(), Feature::FaceOfA(0))?;
        let of_b = self.base(self.pair.out_of_a(Cone::base_normal()), Feature::FaceOfB(0))?;
        let smooth = self.smooth(&of_a, &of_b);
        if scale.separates(smooth.depth) {
            return Err(Separated { normal: smooth.normal, distance: -smooth.depth });
        }
        let Nearest { normal, depth, .. } = smooth;
        let smooth = Least { normal, depth, feature: Feature::Smooth(AxisCode::of(&normal).0) };
        let [of_a, of_b, smooth] = [of_a, of_b, smooth].map(|least| least.rounded(scale));
        let mut found = Found { least: of_a, preferred: of_a };
        for rival in [of_b, smooth] {
            if rival.depth < found.least.depth {
                found.least = rival;
            }
            if rival.depth < scale.limit(found.preferred.depth) {
                found.preferred = rival;
            }
        }
        Ok(found)
    }

    fn base(&mut self, normal: Vector3<f64>, feature: Feature) -> Result<Least, Separated> {
        *self.axes += 1;
        let depth = self.pair.depth_along(&normal);
        if self.pair.scale.separates(depth) {
            return Err(Separated { normal, distance: -depth });
        }
        Ok(Least { normal, depth, feature })
    }

    /// The least of all normals, if that is not a base's; else that.
    fn smooth(&mut self, of_a: &Least, of_b: &Least) -> Nearest {
        let [a, b] = self.cones;
        let mut overlaps = false;
        let mut nearest = Nearest { normal: of_a.normal, depth: f64::INFINITY, is_distance: false };
        for (one, other, least, side) in [(a, b, of_a, 1.0), (b, a, of_b, -1.0)] {
            let deepest = other.foremost(&(least.normal * -side));
            overlaps |= one.holds(&deepest);
            self.take(&mut nearest, one, least.normal, least.depth, &deepest, side);
        }
        self.of_flanks(&mut nearest, &mut overlaps);
        if nearest.is_distance || (nearest.depth >= 0.0 && self.overlap_of_rims(&mut nearest, overlaps)) {
            return nearest;
        }
        if nearest.depth < 0.0 {
            self.at_apices(&mut nearest);
        }
        if !nearest.is_distance {
            self.between_rims(&mut nearest);
        }
        if !nearest.is_distance {
            for start in cone_search::around(&a.rim) {
                if let Some(meet) = cone_rims::settle(&a.rim, &b.rim, start, self.axes) {
                    self.take_rims(&mut nearest, &meet);
                }
            }
        }
        nearest
    }

    /// Takes the least of all normals of either flank, if it is less. Tells of points found in both cones.
    fn of_flanks(&mut self, nearest: &mut Nearest, overlaps: &mut bool) {
        let [a, b] = self.cones;
        // What one flank leaves unknown, the lower limit that the other sets may settle.
        let mut known = [false; 2];
        for of_b in [0, 1, 0, 1] {
            if nearest.is_distance {
                return;
            }
            if known[of_b] {
                continue;
            }
            let (one, other, side) = if of_b == 0 { (a, b, 1.0) } else { (b, a, -1.0) };
            known[of_b] = true;
            match least_of_flank(one, other, nearest.depth, self.pair.scale.tolerance, self.axes) {
                OfFlank::Least { normal, depth, deepest } => {
                    *overlaps |= one.holds(&deepest);
                    self.take(nearest, one, normal * side, depth, &deepest, side);
                }
                OfFlank::Above(deep) => *overlaps |= deep.is_some_and(|point| one.holds(&point)),
                OfFlank::Unknown => known[of_b] = false,
            }
        }
        for (known, (one, other, side)) in known.into_iter().zip([(a, b, 1.0), (b, a, -1.0)]) {
            if !known {
                let (normal, depth) = cone_search::least_of_flank(one, |n| other.reach(n), self.axes);
                let deepest = other.foremost(&-normal);
                self.take(nearest, one, normal * side, depth, &deepest, side);
            }
        }
    }

    /// Takes the depth along a normal of `one`, out of A, if it is less: to the other's deepest point.
    fn take(
        &self,
        nearest: &mut Nearest,
        one: &PlacedCone,
        normal: Vector3<f64>,
        depth: f64,
        deepest: &Vector3<f64>,
        side: f64,
    ) {
        if depth < nearest.depth {
            let foot = deepest + normal * (side * depth);
            let is_distance = depth < 0.0 && one.holds_about(&foot, SADDLE_GAP * self.pair.scale.tolerance);
            *nearest = Nearest { normal, depth, is_distance };
        }
    }

    /// Takes the depth along a normal between two points at some distance, if it is less.
    fn take_between(&mut self, nearest: &mut Nearest, normal: Vector3<f64>, distance: f64) {
        *self.axes += 1;
        let depth = self.pair.depth_along(&normal);
        if depth < nearest.depth || (depth == nearest.depth && !nearest.is_distance) {
            let is_distance = distance + depth <= SADDLE_GAP * self.pair.scale.tolerance;
            *nearest = Nearest { normal, depth, is_distance };
        }
    }

    /// Takes the least along which rims overlap. Whether it is proved that the cones do.
    fn overlap_of_rims(&mut self, nearest: &mut Nearest, mut overlaps: bool) -> bool {
        let [a, b] = self.cones;
        let small = self.pair.scale.tolerance;
        let Some(meets) = cone_rims::overlaps(&a.rim, &b.rim, nearest.depth + small, self.axes) else { return false };
        for meet in meets.iter().flatten() {
            self.take_rims(nearest, meet);
            overlaps = overlaps || meet.dip(&a.rim, b).is_some();
        }
        overlaps || [(a, b), (b, a)].into_iter().any(|(one, other)| other.axis_points().iter().any(|at| one.holds(at)))
    }

    /// Takes the normals from each apex to the nearest point of the other cone.
    fn at_apices(&mut self, nearest: &mut Nearest) {
        let &ShapePair { a, b, b_in_a, scale } = self.pair;
        let place = a.place(&b_in_a.place(&b.apex_point()), scale.size);
        self.take_between(nearest, place.normal, place.height);
        let place = b.place(&b_in_a.inverse().place(&a.apex_point()), scale.size);
        self.take_between(nearest, self.pair.out_of_a(place.normal), place.height);
    }

    /// Takes the normal along which the rims are nearest to each other.
    fn between_rims(&mut self, nearest: &mut Nearest) {
        let [a, b] = self.cones;
        let start = a.rim.direction(&nearest.normal);
        if let Some(meet) = cone_rims::settle(&a.rim, &b.rim, start, self.axes) {
            self.take_rims(nearest, &meet);
        }
    }

    fn take_rims(&mut self, nearest: &mut Nearest, meet: &RimsMeet) {
        if let Some(normal) = meet.normal(self.pair.scale.tolerance) {
            self.take_between(nearest, normal, (meet.on_one - meet.on_other).norm());
        }
    }
}

#[cfg(test)]
impl ShapePair<'_, Cone, Cone> {
    /// The least depth of all normals, its normal, and how many were measured.
    pub fn least(&self) -> (Vector3<f64>, f64, u32) {
        let cones = [PlacedCone::upright(self.a), PlacedCone::new(self.b, self.b_in_a)];
        let mut axes = 0;
        let mut test = Test { pair: self, cones: &cones, axes: &mut axes };
        let bases = [Cone::base_normal(), self.out_of_a(Cone::base_normal())];
        let [of_a, of_b] = [0, 1].map(|face| {
            let normal = bases[face];
            Least { normal, depth: self.depth_along(&normal), feature: Feature::FaceOfA(0) }
        });
        let Nearest { normal, depth, .. } = test.smooth(&of_a, &of_b);
        (normal, depth, axes)
    }
}
