//! A cylinder and another cylinder or a cone: the least overlap over the axes that two smooth solids of revolution have.
//!
//! In the cylinder's axes, with the other's centre d and axis b, the overlap along a unit direction n out of the cylinder is
//! depth(n) = h_A(n) + h_B(−n) − n·d, both support functions exact. Of shapes that overlap it is least, and of shapes apart
//! greatest below zero, along one of these:
//!
//! - the normal of an **end**;
//! - **flank on flank**: a normal that both flanks have, n across the axis of A with −n·b = sin γ of the other: two of them;
//! - **flank on rim**: seen along a cylinder's axis, the other's rim is an ellipse and the axis a point. Where it touches the
//!   flank its distance from that point is stationary: the [`feet`](super::ellipse::feet) of the point on the ellipse. Of a
//!   cone's flank, which is no cylinder's, the least is found by search ([`cone_search`](super::cone_search));
//! - **rim on rim** ([`cone_rims`](super::cone_rims));
//! - from a **tip** to the nearest point of the cylinder.
//!
//! At all other normals two points touch alone that are no minimum. Each of these is measured by both support functions, so
//! none tells less than the true overlap, or more than the true distance.
//!
//! **Apart.** A normal is that of the distance if what is foremost along it of either shape, a point, a generator line or an
//! end, lies over one another. Where no normal is so far, tips are looked at, and rims all round; those that overlap along all
//! normals above may be apart then, too.

use nalgebra::Vector3;

use super::approach::are_apart;
use super::axis_code::AxisCode;
use super::cone_flank::{self, OfFlank};
use super::cone_rims::{self, RimsMeet};
use super::cone_search;
use super::placed_cone::PlacedCone;
use super::revolved::{End, Revolved};
use super::revolved_polyhedron::{flanks_across, rims_across};
use super::{
    Cylinder, Feature, Found, Frame, Least, Overlap, PairSearch, Rim, Segment, ShapePair, edge_contact, unit_across,
};
use crate::physics::collision::constants::SADDLE_GAP;

/// What may lie on a cylinder's flank or rim.
pub(crate) trait BesideCylinder: Revolved {
    /// Where its flank is a cone's, that cone in other axes.
    fn placed_cone(&self, frame: &Frame) -> Option<PlacedCone>;
}

impl BesideCylinder for Cylinder {
    fn placed_cone(&self, _: &Frame) -> Option<PlacedCone> {
        None
    }
}

impl BesideCylinder for super::Cone {
    fn placed_cone(&self, frame: &Frame) -> Option<PlacedCone> {
        Some(PlacedCone::new(self, frame))
    }
}

/// Tests a cylinder and what is given in its axes; what was the last step's axis is tried first and replaced. Contact points
/// are left in the clip buffers, in the cylinder's axes.
pub(crate) fn touch<B: BesideCylinder>(pair: &ShapePair<Cylinder, B>, search: &mut PairSearch) -> Option<Overlap> {
    let &ShapePair { a, b, b_in_a, scale } = pair;
    let foremost = |normal: &Vector3<f64>| b_in_a.place(&b.foremost(&b_in_a.enter(normal)));
    let between = |normal: &Vector3<f64>| foremost(&-normal) - a.foremost(normal);
    if are_apart(search, &b_in_a.center, scale.gap, between) {
        return None;
    }
    let found = Test { pair, a_in_b: b_in_a.inverse(), axes: &mut search.axes }.run();
    if scale.separates(found.least.depth) {
        search.last = Some(Feature::Smooth(AxisCode::of(&found.least.normal).0));
        search.apart = -found.least.depth;
        return None;
    }
    found.take(pair, search, |least, clip| pair.points_of_flanks(least, clip))
}

struct Test<'t, B> {
    pair: &'t ShapePair<'t, Cylinder, B>,
    a_in_b: Frame,
    axes: &'t mut u32,
}

/// The normal of least depth so far.
#[derive(Clone, Copy)]
struct Nearest {
    normal: Vector3<f64>,
    depth: f64,
}

impl<B: BesideCylinder> Test<'_, B> {
    /// The least overlap or the distance.
    fn run(&mut self) -> Found {
        let scale = self.pair.scale;
        let ends_of_a = self.pair.a.ends().into_iter().flatten();
        let ends_of_b = self.pair.b.ends().into_iter().flatten();
        let faces = ends_of_a
            .map(|end| (end.normal(), Feature::FaceOfA(end.face)))
            .chain(ends_of_b.map(|end| (self.pair.out_of_a(end.normal()), Feature::FaceOfB(end.face))));
        let mut found: Option<Found> = None;
        let mut nearest = Nearest { normal: Vector3::y(), depth: f64::INFINITY };
        for (normal, feature) in faces {
            self.take(&mut nearest, normal);
            let least = Least { normal, depth: self.pair.depth_along(&normal), feature }.rounded(scale);
            found = Some(with_rival(found, least, self.pair));
        }
        self.smooth(&mut nearest);
        let Nearest { normal, depth } = nearest;
        let smooth = Least { normal, depth, feature: Feature::Smooth(AxisCode::of(&normal).0) }.rounded(scale);
        with_rival(found, smooth, self.pair)
    }

    /// Measures the overlap along a unit normal out of A, and takes it if it is less.
    fn take(&mut self, nearest: &mut Nearest, normal: Vector3<f64>) {
        *self.axes += 1;
        let depth = self.pair.depth_along(&normal);
        if depth < nearest.depth {
            *nearest = Nearest { normal, depth };
        }
    }

    /// Takes what is less along the normals of flanks, rims and tips.
    fn smooth(&mut self, nearest: &mut Nearest) {
        let &ShapePair { a, b, b_in_a, scale } = self.pair;
        let [sine, _] = b.slant();
        let axis = b_in_a.rotation.column(1).into_owned();
        for normal in flanks_across(a, &axis, -sine).into_iter().flatten() {
            self.take(nearest, normal);
        }
        // A's axis in the axes of B.
        let Frame { center, rotation } = self.a_in_b;
        for end in b.ends().into_iter().flatten() {
            for normal in rims_across(&end, &center, &rotation.column(1).into(), f64::INFINITY).into_iter().flatten() {
                self.take(nearest, self.pair.out_of_a(normal));
            }
        }
        if let Some(tip) = b.tip() {
            let tip = b_in_a.place(&tip);
            self.take(nearest, a.flank_normal(unit_across(&tip)));
        }
        match b.placed_cone(b_in_a) {
            Some(cone) => {
                for rim in a.ends().into_iter().flatten().map(|end| end.rim()) {
                    // A disc is a cone without height.
                    let disc = PlacedCone { apex: rim.center, rim, sine: 1.0, cosine: 0.0 };
                    let limit = nearest.depth;
                    if let OfFlank::Least { normal, .. } =
                        cone_flank::least_of_flank(&cone, &disc, limit, scale.tolerance, self.axes)
                    {
                        self.take(nearest, -normal);
                    }
                }
                let (normal, _) = cone_search::least_of_flank(&cone, |n| super::Convex::reach(a, n), self.axes);
                self.take(nearest, -normal);
            }
            None => {
                for end in a.ends().into_iter().flatten() {
                    for normal in rims_across(&end, &b_in_a.center, &axis, f64::INFINITY).into_iter().flatten() {
                        self.take(nearest, normal);
                    }
                }
            }
        }
        if nearest.depth >= 0.0 {
            self.overlap_of_rims(nearest);
        }
        // Shapes apart may overlap along all of these. What touches is over one another.
        if !self.is_over_one_another(&nearest.normal) {
            if let Some(tip) = b.tip() {
                self.take(nearest, a.place(&b_in_a.place(&tip), scale.size).normal);
            }
            self.between_rims(nearest);
        }
    }

    /// Both rims of each pair of ends.
    fn rims(&self) -> impl Iterator<Item = [Rim; 2]> + use<B> {
        let &ShapePair { a, b, b_in_a, .. } = self.pair;
        let of = |ends: [Option<End>; 2]| ends.map(|end| end.map(|end| end.rim()));
        let (of_a, of_b) = (of(a.ends()), of(b.ends()).map(|rim| rim.map(|rim| rim.placed(b_in_a))));
        let pair = move |one: Option<Rim>, other: Option<Rim>| Some([one?, other?]);
        of_a.into_iter().flat_map(move |one| of_b.map(|other| pair(one, other))).flatten()
    }

    fn overlap_of_rims(&mut self, nearest: &mut Nearest) {
        for [one, other] in self.rims() {
            let limit = nearest.depth + self.pair.scale.tolerance;
            match cone_rims::overlaps(&one, &other, limit, self.axes) {
                Some(meets) => meets.iter().flatten().for_each(|meet| self.take_rims(nearest, meet)),
                None => self.search_rims(nearest, [one, other]),
            }
        }
    }

    /// The distance, where it is between two rims.
    fn between_rims(&mut self, nearest: &mut Nearest) {
        if self.is_over_one_another(&nearest.normal) {
            return;
        }
        let start = nearest.normal;
        for [one, other] in self.rims() {
            if let Some(meet) = cone_rims::settle(&one, &other, one.direction(&start), self.axes) {
                self.take_rims(nearest, &meet);
            }
        }
        if !self.is_over_one_another(&nearest.normal) {
            self.rims().for_each(|pair| self.search_rims(nearest, pair));
        }
    }

    fn search_rims(&mut self, nearest: &mut Nearest, [one, other]: [Rim; 2]) {
        for start in cone_search::around(&one) {
            if let Some(meet) = cone_rims::settle(&one, &other, start, self.axes) {
                self.take_rims(nearest, &meet);
            }
        }
    }

    fn take_rims(&mut self, nearest: &mut Nearest, meet: &RimsMeet) {
        if let Some(normal) = meet.normal(self.pair.scale.tolerance) {
            self.take(nearest, normal);
        }
    }

    /// Whether what is foremost of either shape along a unit normal out of A is over one another: shapes apart are nowhere
    /// farther apart than there.
    fn is_over_one_another(&self, normal: &Vector3<f64>) -> bool {
        let &ShapePair { a, b, b_in_a, scale } = self.pair;
        let of_a = Foremost::of(a, normal);
        let of_b = Foremost::of(b, &-b_in_a.enter(normal)).placed(b_in_a);
        let [one, other] =
            [of_a.core, of_b.core].map(|core| Segment(core.0.map(|end| end - normal * normal.dot(&end))));
        let [on_one, on_other] = nearest_of_segments(&one, &other);
        (on_one - on_other).norm() <= of_a.radius + of_b.radius + SADDLE_GAP * scale.tolerance
    }
}

/// All that is foremost of a shape along a direction: a point, a line, or a disc about one.
struct Foremost {
    core: Segment,
    radius: f64,
}

impl Foremost {
    fn of(shape: &impl Revolved, direction: &Vector3<f64>) -> Self {
        let toward = unit_across(direction);
        if shape.has_on_flank(direction) {
            return Self { core: shape.generator(toward), radius: 0.0 };
        }
        match shape.end_of(direction) {
            Some(end) => Self { core: Segment([end.center(); 2]), radius: end.radius },
            None => Self { core: Segment([shape.foremost(direction); 2]), radius: 0.0 },
        }
    }

    fn placed(self, frame: &Frame) -> Self {
        Self { core: Segment(self.core.0.map(|end| frame.place(&end))), ..self }
    }
}

/// Of segments which may be points.
fn nearest_of_segments(one: &Segment, other: &Segment) -> [Vector3<f64>; 2] {
    let is_point = |segment: &Segment| segment.along() == Vector3::zeros();
    let on = |segment: &Segment, point: &Vector3<f64>| {
        if is_point(segment) { segment.0[0] } else { segment.at(segment.share_of(point).clamp(0.0, 1.0)) }
    };
    if is_point(one) || is_point(other) {
        let [point, other_point] = [one.0[0], other.0[0]];
        return if is_point(one) { [point, on(other, &point)] } else { [on(one, &other_point), other_point] };
    }
    edge_contact::closest(one, other)
}

/// What is less deep, and what is preferred: an end before a flank or rim unless that is less deep by enough.
fn with_rival<A, B>(found: Option<Found>, rival: Least, pair: &ShapePair<A, B>) -> Found {
    let Some(Found { least, preferred }) = found else { return Found { least: rival, preferred: rival } };
    Found {
        least: if rival.depth < least.depth { rival } else { least },
        preferred: if rival.depth < pair.scale.limit(preferred.depth) { rival } else { preferred },
    }
}
