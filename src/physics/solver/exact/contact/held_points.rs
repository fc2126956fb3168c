//! The contact points that a smooth step holds: those at its start, in the order of their pairs, then those met on the way.
//!
//! A patch is named anew by the features that bound it at the end of the step: as two faces tilt against each other, a
//! corner on a face becomes an edge that crosses another, at the same place; the two ends of the line along which cones
//! touch may change their names. A point whose features are gone, or elsewhere, goes on as the one that has taken its
//! place. Else it would be held where it is no more, and the new one beside it, and forecasts would not come true however
//! short the step. Of points of one name, as on two facets of a mesh, a point goes on as the nearest.

use nalgebra::Vector3;

use super::super::constants::{SAME_NAME, SAME_PLACE, SAME_PLANE, UNFORESEEN};
use super::super::mechanism::MemberState;
use super::gap_points::{GapPoint, GapPoints};

/// The points, and where each is at the end of the step.
#[derive(Clone, Default)]
pub(super) struct HeldPoints {
    pub list: Vec<GapPoint>,
    /// How many of them are of the start.
    known: usize,
    /// The index of each among the points at the end.
    pub at_end: Vec<Option<usize>>,
    /// Which points at the end are one of these.
    taken: Vec<bool>,
}

impl HeldPoints {
    /// Begins with the points at the start.
    pub fn begin<'p>(&mut self, points: impl Iterator<Item = &'p GapPoint>) {
        self.list.clear();
        self.list.extend(points.cloned());
        self.known = self.list.len();
    }

    /// The index of the point of the same features.
    pub fn position(&self, point: &GapPoint) -> Option<usize> {
        self.of(point.pair).find(|&index| self.list[index].feature == point.feature)
    }

    /// The least gap at the start of a pair's points; 0 if none is less.
    fn least_gap(&self, pair: u32) -> f64 {
        self.of(pair).take_while(|&index| index < self.known).map(|index| self.list[index].gap).fold(0.0, f64::min)
    }

    /// The indices of a pair's points.
    pub fn of(&self, pair: u32) -> impl Iterator<Item = usize> {
        let (known, met) = self.list.split_at(self.known);
        let first = known.partition_point(|other| other.pair < pair);
        let own = known[first..].iter().take_while(move |other| other.pair == pair).count();
        let met = met.iter().zip(self.known..).filter(move |(other, _)| other.pair == pair);
        (first..first + own).chain(met.map(|(_, index)| index))
    }

    /// Finds each among the points at the end, after a way from the states `start` to `end`. `radius` is of a body, m.
    pub fn follow(
        &mut self,
        points: &GapPoints,
        start: &[MemberState],
        end: &[MemberState],
        radius: impl Fn(u32) -> f64,
    ) {
        self.taken.clear();
        self.taken.resize(points.list.len(), false);
        self.at_end.clear();
        let square = |held: &GapPoint, index: usize| distance_squared(held, &points.list[index].point, start, end);
        let least_radius = |point: &GapPoint| radius(point.ends[0]).min(radius(point.ends[1]));
        let way = |point: &GapPoint| {
            let [a, b] = point.ends.map(|body| end[body as usize].position - start[body as usize].position);
            (b - a).norm()
        };
        for held in &self.list {
            let most = SAME_NAME * least_radius(held) + way(held);
            let named = points.namesakes(held.pair, held.feature).map(|found| (square(held, found), found));
            let nearest = named.min_by(|one, other| one.0.total_cmp(&other.0));
            self.at_end.push(nearest.filter(|(square, _)| *square <= most * most).map(|(_, found)| found));
        }
        self.at_end.iter().flatten().for_each(|&found| self.taken[found] = true);
        for (index, point) in points.list.iter().enumerate() {
            if self.taken[index] {
                continue;
            }
            let most = (SAME_PLACE * least_radius(point)).powi(2);
            let gone = self.of(point.pair).filter(|&held| self.at_end[held].is_none());
            let places = gone.map(|held| (square(&self.list[held], index), held));
            let nearest = places.filter(|(square, _)| *square < most).min_by(|one, other| one.0.total_cmp(&other.0));
            if let Some((_, held)) = nearest {
                self.list[held].feature = point.feature;
                self.at_end[held] = Some(index);
                self.taken[index] = true;
            }
        }
    }

    /// Takes in the points at the end of a step of h, s, that overlap and were not held, but those of free pairs: held from
    /// where they came from, no deeper than the pair was, whatever the curvature of the way makes of it.
    pub fn meet(
        &mut self,
        points: &GapPoints,
        start: &[MemberState],
        end: &[MemberState],
        h: f64,
        is_free: impl Fn(u32) -> bool,
    ) {
        for (index, point) in points.list.iter().enumerate() {
            if !self.taken[index] && point.gap < -UNFORESEEN && !is_free(point.pair) {
                let mut met = self.at_start(point, start, end);
                met.gap = (point.gap - met.opening(end) * h).max(self.least_gap(point.pair));
                self.list.push(met);
            }
        }
    }

    /// A point at the end as it was at the start, with the plane of its pair's points there: those that stick could not
    /// all stick on planes at an angle that are closing.
    fn at_start(&self, point: &GapPoint, start: &[MemberState], end: &[MemberState]) -> GapPoint {
        let known = self.of(point.pair).filter(|&index| index < self.known).map(|index| &self.list[index]);
        let nearest =
            known.max_by(|one, other| one.normal.dot(&point.normal).total_cmp(&other.normal.dot(&point.normal)));
        let Some(known) = nearest.filter(|known| known.normal.dot(&point.normal) > SAME_PLANE) else {
            return point.clone();
        };
        let [a, b] = point.ends.map(|end| end as usize);
        let place = |body: usize, arm: &Vector3<f64>| {
            start[body].position + start[body].rotation * (end[body].rotation.inverse() * arm)
        };
        let middle = 0.5 * (place(a, &point.arms[0]) + place(b, &point.arms[1]));
        let height = known.normal.dot(&(start[a].position + known.arms[0] - middle));
        let middle = middle + known.normal * height;
        let arms = [middle - start[a].position, middle - start[b].position];
        GapPoint { arms, normal: known.normal, ..point.clone() }
    }
}

/// From where a point of either body has gone, of the two the less: a corner stays where it is on its own body.
fn distance_squared(held: &GapPoint, place: &Vector3<f64>, start: &[MemberState], end: &[MemberState]) -> f64 {
    let gone = [0, 1].map(|side| {
        let body = held.ends[side] as usize;
        let arm = end[body].rotation * (start[body].rotation.inverse() * held.arms[side]);
        (end[body].position + arm - place).norm_squared()
    });
    gone[0].min(gone[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::collision::FeatureId;

    const GROUND: MemberState = MemberState::REST;

    fn point(feature: u64, place: [f64; 3], gap: f64) -> GapPoint {
        let place = Vector3::from(place);
        GapPoint {
            pair: 0,
            feature: FeatureId(feature),
            ends: [0, 1],
            point: place,
            arms: [place; 2],
            normal: Vector3::y(),
            gap,
            friction: 0.5,
        }
    }

    /// Two bodies of 1 m about the origin; the second one moves by `way`.
    fn after(way: [f64; 3], held: &[GapPoint], found: Vec<GapPoint>) -> (HeldPoints, GapPoints) {
        let moved = MemberState { position: Vector3::from(way), ..GROUND };
        let (mut points, found) = (HeldPoints::default(), GapPoints::of_one_pair(found));
        points.begin(held.iter());
        points.follow(&found, &[GROUND; 2], &[GROUND, moved], |_| 1.0);
        (points, found)
    }

    #[test]
    fn points_that_change_their_names_stay_where_they_are() {
        let ends = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
        let held = [point(2, ends[0], 0.0), point(3, ends[1], 0.0)];
        let (points, _) = after([0.01, 0.0, 0.0], &held, vec![point(3, ends[0], -1e-3), point(2, ends[1], -2e-3)]);
        assert_eq!(points.at_end, [Some(0), Some(1)]);
        assert_eq!(points.list.iter().map(|point| point.feature).collect::<Vec<_>>(), [FeatureId(3), FeatureId(2)]);
    }

    #[test]
    fn a_point_whose_name_another_one_took_is_gone() {
        let ends = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
        let held = [point(2, ends[0], 0.0), point(3, ends[1], 0.0)];
        let (points, _) = after([0.01, 0.0, 0.0], &held, vec![point(2, ends[1], -2e-3)]);
        assert_eq!(points.at_end, [None, Some(0)]);
    }

    #[test]
    fn a_point_is_followed_by_its_name_however_far_it_rolls_and_by_its_place_if_the_name_is_gone() {
        let held = [point(2, [0.0; 3], 0.0)];
        let (points, _) = after([0.7, 0.0, 0.0], &held, vec![point(2, [0.35, 0.0, 0.0], 0.0)]);
        assert_eq!(points.at_end, [Some(0)], "rolled");
        let (points, _) = after([0.01, 0.0, 0.0], &held, vec![point(2, [0.35, 0.0, 0.0], 0.0)]);
        assert_eq!(points.at_end, [None], "at the other end");
        let (points, _) = after([0.3, 0.0, 0.0], &held, vec![point(7, [0.302, 0.0, 0.0], 0.0)]);
        assert_eq!((points.at_end[0], points.list[0].feature), (Some(0), FeatureId(7)), "renamed");
        let (points, _) = after([0.3, 0.0, 0.0], &held, vec![point(7, [0.35, 0.0, 0.0], 0.0)]);
        assert_eq!(points.at_end, [None], "another point");
    }

    /// A corner on one facet, and another on the next, where each facet numbers its own.
    #[test]
    fn of_two_points_of_one_name_each_goes_on_as_itself() {
        let held = [point(2, [-0.05, 0.0, 0.0], 0.02), point(2, [0.05, 0.0, 0.0], 0.0)];
        let found = vec![point(2, [-0.05, 0.0, 0.0], 0.02), point(2, [0.05, 0.0, 0.0], -1e-3)];
        let (mut points, found) = after([0.001, 0.0, 0.0], &held, found);
        assert_eq!(points.at_end, [Some(0), Some(1)]);
        points.meet(&found, &[GROUND; 2], &[GROUND; 2], 0.1, |_| false);
        assert_eq!(points.list.len(), 2, "met what it holds");
    }

    /// A plane that has tilted by 0.1 rad on the way.
    #[test]
    fn what_is_met_beside_a_known_point_lies_on_its_plane() {
        let (h, known) = (0.1, point(2, [0.2, 0.0, 0.0], 0.0));
        let normal = Vector3::new(0.1_f64.sin(), 0.1_f64.cos(), 0.0);
        let met = GapPoint { normal, ..point(5, [-0.2, 0.03, 0.0], -1e-3) };
        let (mut points, found) = after([0.0; 3], std::slice::from_ref(&known), vec![known.clone(), met]);
        points.meet(&found, &[GROUND; 2], &[GROUND; 2], h, |_| false);
        let [_, met] = &points.list[..] else { panic!("{} points", points.list.len()) };
        assert_eq!((met.normal, met.arms[0].y, met.arms[1].y), (known.normal, 0.0, 0.0));
        assert!((met.arms[0].x + 0.2).abs() < 1e-15 && met.gap == 0.0);
        points.meet(&found, &[GROUND; 2], &[GROUND; 2], h, |_| true);
        assert_eq!(points.list.len(), 2, "of a free pair");
    }
}
