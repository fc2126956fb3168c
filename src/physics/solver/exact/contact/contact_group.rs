//! Bodies in reach of each other, with what joints hold to them, taken through a step.
//!
//! A smooth step ([`SmoothStep`]) holds all contact points but those of pairs that are bouncing, which it leaves free.
//! Where such a pair would come to overlap, the smooth step ends at that time instead (to [`LANDED`] of overlap), the
//! impacts that are due pass ([`Impacts`]), and another smooth step follows. Bounces slower than [`LEAST_BOUNCE`] are
//! none, and after [`MOST_LANDINGS`] in a substep nothing bounces for the rest of it.
//!
//! A smooth step whose forecast does not come true is halved, again and again. What still does not come true at
//! [`SHORTEST_STEP`] goes by the forecast at its start alone, and so does all that is left of a step that has taken its
//! share of work ([`GroupSolver::is_spent`]), or has come to its deadline. All are reported.

use nalgebra::Vector3;

use super::super::bodies::{links_of, member, place_in, put, state_of};
use super::super::constants::{
    ENERGY_GAINED, FIRST_GROWTH, GROWTH_AFTER_CUT, LANDED, LEAST_BOUNCE, LEAST_GROWTH, MISSED, MOST_LANDINGS,
    MOST_TRIALS, NO_ENERGY, NO_TIME, ROUGH_STEP, ROUGH_TOLERANCE, SHORTEST_STEP, TOLERANCE, TOUCHING,
};
use super::super::mechanism::{MechanismLink, Member, MemberState, kinetic_energies, number_rows, only_forces_work};
use super::super::stepper::StepEffort;
use super::crossings::{Crossings, Passage};
use super::gap_points::{GapPoint, GapPoints, PointSearch, ReachablePair};
use super::group_solver::{GroupSolver, GroupView};
use super::impacts::{Impacts, approach};
use super::joint_gaps::JointGaps;
use super::landing::{LandingSearch, Standings};
use super::limit_rows::LimitRows;
use super::point_loads::{PointLoad, PointLoads};
use super::rest::Rest;
use super::smooth_step::{SmoothStep, SmoothTerms, place};
use crate::physics::HardProblem;
use crate::physics::body::{Bodies, Body, SurfaceMaterial};
use crate::physics::collision::{ContactGraph, FeatureId, Pair, PairKey, closing_distance};
use crate::physics::constraint::row::Wrench;
use crate::physics::contact::surface;
use crate::physics::joint::{Joint, Joints};
use crate::physics::settings::FrictionModel;
use crate::physics::solve_trace::Residuals;
use crate::physics::solver::cone::Deadline;

/// A contact point with the force through it.
pub(crate) struct PointForce {
    pub pair: Pair,
    /// In the world, m: at the end of the step, or where it carried something last.
    pub point: Vector3<f64>,
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// m; negative: a gap.
    pub depth: f64,
    /// Mean over the step, N on B.
    pub force: Vector3<f64>,
    /// Of the step's last solve, N on B; none where that was not of this point.
    pub last_force: Option<Vector3<f64>>,
}

/// The settings that a step depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactTerms {
    /// At the start, s.
    pub time: f64,
    /// Length of a substep, s.
    pub h: f64,
    pub parts: u32,
    /// Fastest closing of an overlap, m/s.
    pub correction_speed: f64,
    /// Approach up to which nothing bounces, m/s.
    pub restitution_speed: f64,
    /// Whether somebody reads what joints carry.
    pub reads_loads: bool,
    /// Whether somebody reads the residuals of iterations.
    pub traces: bool,
    /// Whether somebody wants the hardest solves.
    pub keeps_hardest: bool,
    /// When solves are to end.
    pub deadline: Deadline,
}

/// Bodies in reach of each other, and what joints hold to them.
#[derive(Clone, Default)]
pub(crate) struct ContactGroup {
    /// Those that move first.
    bodies: Vec<u32>,
    moving: usize,
    /// The joint of each link.
    joints: Vec<u32>,
    links: Vec<MechanismLink>,
    pairs: Vec<ReachablePair>,
    members: Vec<Member>,
    shapes: Vec<Body>,
    states: Vec<MemberState>,
    points: GapPoints,
    search: PointSearch,
    gaps: JointGaps,
    free: Vec<bool>,
    /// The limits of joints, and which rows are some that are left free.
    limits: LimitRows,
    free_rows: Vec<bool>,
    smooth: SmoothStep,
    /// How what is left free stands at the end of the smooth step.
    standings: Standings,
    /// Whether the smooth step ends where something lands.
    lands: bool,
    landing: LandingSearch,
    crossings: Crossings,
    impacts: Impacts,
    loads: PointLoads,
    /// Mean of each link over the step: force on B, and torque about its anchor.
    joint_loads: Vec<Wrench<f64>>,
    rest: Rest,
    pub effort: StepEffort,
    /// Of the step, while somebody reads them: of positions, of velocities, then of impacts.
    pub residuals: Residuals,
}

/// What a step starts from.
struct StepStart<'a> {
    terms: ContactTerms,
    /// Contact forces of the step before.
    graph: &'a ContactGraph,
    /// Loads of the links in the step before.
    loads: &'a [Wrench<f64>],
}

/// How long the next smooth step may be.
struct Stride {
    /// s.
    longest: f64,
    growth: f64,
}

impl Stride {
    /// Takes in how long a smooth step was, s, and whether it had to be cut.
    fn note(&mut self, length: f64, is_cut: bool) {
        if is_cut {
            self.growth = (GROWTH_AFTER_CUT * self.growth).max(LEAST_GROWTH);
        }
        self.longest = self.growth * length;
    }
}

impl ContactGroup {
    /// Of those bodies that move, joints and pairs, by their indices in the world; with the buffers of another, and where that
    /// was of the same bodies its order of elimination.
    pub fn plan(
        mut self,
        moving: Vec<u32>,
        joints: &[u32],
        pairs: &[PairKey],
        all_bodies: &Bodies,
        all_joints: &Joints,
        time: f64,
    ) -> Self {
        self.bodies = moving;
        let moving = self.bodies.len();
        self.moving = moving;
        let mut place = |body: u32| place_in(&mut self.bodies, moving, body);
        let pair = |&key: &PairKey| {
            // What their surfaces are like is taken in with the state.
            let ends = [place(key.pair.a), place(key.pair.b)];
            ReachablePair { key, ends, surface: SurfaceMaterial::default() }
        };
        self.pairs.clear();
        self.pairs.extend(pairs.iter().map(pair));
        (self.joints, self.links) = links_of(joints, all_joints, all_bodies, time, place);
        number_rows(&mut self.links);
        // Of other joints and points these say nothing.
        self.rest.end();
        self.gaps = JointGaps::default();
        (self.smooth.velocities.stalled, self.impacts.solver.stalled) = (0.0, 0.0);
        self
    }

    /// Whether it was planned for those bodies that move, joints and pairs. One with joints that have no rows is of no others.
    pub fn is_of(&self, moving: &[u32], joints: &[u32], pairs: &[PairKey]) -> bool {
        self.moving() == moving && self.joints == joints && self.pairs.iter().map(|pair| &pair.key).eq(pairs)
    }

    /// Residual, m/s, that its solves for positions lately could not get below.
    pub fn stalled(&self) -> f64 {
        self.smooth.positions.stalled
    }

    /// The same, where solves of the same bodies could not get below that.
    pub fn after_stalled(mut self, residual: f64) -> Self {
        self.smooth.positions.stalled = residual;
        self
    }

    /// Takes the state in; of either model of friction this method has the cone.
    pub fn gather(&mut self, bodies: &Bodies, joints: &Joints, friction: FrictionModel) {
        if self.rest.is_on() {
            if self.is_as_left(bodies, joints, friction) {
                return;
            }
            self.rest.end();
        }
        let list = || self.bodies.iter().map(|&body| &bodies.list[body as usize]);
        self.members.clear();
        self.members.extend(list().map(member));
        self.states.clear();
        self.states.extend(list().map(state_of));
        self.shapes.clear();
        self.shapes.extend(list().cloned());
        let joint = |&joint: &u32| &joints.list[joint as usize];
        self.links.iter_mut().zip(&self.joints).for_each(|(link, index)| {
            link.renew(&joint(index).definition);
        });
        self.joint_loads.clear();
        let loads = self.joints.iter().map(joint).map(|joint| Wrench { linear: joint.force, angular: joint.torque });
        self.joint_loads.extend(loads);
        for pair in &mut self.pairs {
            let [a, b] = pair.ends.map(|end| &self.shapes[end as usize]);
            pair.surface = surface(a, b, friction);
        }
    }

    /// Whether nobody has changed anything since the last step.
    fn is_as_left(&mut self, bodies: &Bodies, joints: &Joints, friction: FrictionModel) -> bool {
        let Self { members, states, shapes, pairs, links, .. } = self;
        let list = || self.bodies.iter().map(|&body| &bodies.list[body as usize]);
        let body_is = |(body, index): (&Body, usize)| {
            state_of(body) == states[index] && member(body) == members[index] && body.changes == shapes[index].changes
        };
        let pair_is = |pair: &ReachablePair| {
            let [a, b] = pair.ends.map(|end| &bodies.list[self.bodies[end as usize] as usize]);
            pair.surface == surface(a, b, friction)
        };
        let link_is = |(link, &joint): (&mut MechanismLink, &u32)| !link.renew(&joints.list[joint as usize].definition);
        list().zip(0..).all(body_is) && pairs.iter().all(pair_is) && links.iter_mut().zip(&self.joints).all(link_is)
    }

    /// Whether it would stay as it is if nothing moved: no body beside it moves, nor anything by itself.
    fn may_rest(&self) -> bool {
        let is_plain = |link: &MechanismLink| !link.gives() && !link.is_driven();
        self.states[self.moving..].iter().all(MemberState::is_still) && self.links.iter().all(is_plain)
    }

    /// Whether the step has taken all the work that it may.
    fn is_spent(&self) -> bool {
        self.smooth.positions.is_spent() || self.smooth.velocities.is_spent() || self.impacts.solver.is_spent()
    }

    /// Takes the group through a step. `graph` has the forces of the step before.
    pub fn step(&mut self, terms: &ContactTerms, graph: &ContactGraph) {
        self.effort = StepEffort::default();
        let solvers = [&mut self.smooth.positions, &mut self.smooth.velocities, &mut self.impacts.solver];
        for solver in solvers {
            solver.trace(terms.traces);
            solver.keep_hardest(terms.keeps_hardest);
            solver.end_by(terms.deadline);
        }
        let matters = [terms.h, f64::from(terms.parts), terms.correction_speed, terms.restitution_speed];
        if self.rest.goes_on(&matters) {
            self.residuals.clear();
            return;
        }
        self.loads.clear(self.pairs.len());
        let last_loads = std::mem::take(&mut self.joint_loads);
        self.joint_loads.resize(last_loads.len(), Wrench::zero());
        for part in 0..terms.parts {
            let time = terms.time + terms.h * f64::from(part);
            self.advance(&StepStart { terms: ContactTerms { time, ..*terms }, graph, loads: &last_loads });
        }
        let step = terms.h * f64::from(terms.parts);
        self.joint_loads.iter_mut().for_each(|load| *load = Wrench::zero().plus(load, 1.0 / step));
        self.loads.list.iter_mut().for_each(|load| load.impulse /= step);
        let Self { smooth, impacts, residuals, effort, .. } = self;
        residuals.clear();
        effort.unsettled += std::mem::take(&mut impacts.failures);
        for solver in [&mut smooth.positions, &mut smooth.velocities, &mut impacts.solver] {
            if let Some(found) = solver.residuals() {
                residuals.append(found);
            }
            effort.solves += std::mem::take(&mut solver.steps);
            solver.work = 0;
        }
        if effort.unsettled == 0 && self.may_rest() {
            let Self { rest, states, shapes, moving, .. } = self;
            rest.watch(&mut states[..*moving], |index| shapes[index].radius, step, matters);
        } else {
            self.rest.end();
        }
    }

    /// How many of its bodies rest.
    pub fn resting(&self) -> usize {
        if self.rest.is_on() { self.moving } else { 0 }
    }

    /// For how long it has stayed where it is, s.
    pub fn stayed(&self) -> f64 {
        self.rest.time
    }

    /// The hardest solves of the step, if they are kept.
    pub fn hardest(&self) -> impl Iterator<Item = &HardProblem> {
        let solvers = [&self.smooth.positions, &self.smooth.velocities, &self.impacts.solver];
        solvers.into_iter().filter_map(GroupSolver::hardest)
    }

    /// Its bodies that move.
    pub fn moving(&self) -> &[u32] {
        &self.bodies[..self.moving]
    }

    /// Where they are at the end of the step.
    pub fn ends(&self) -> impl Iterator<Item = (u32, &MemberState)> + Clone {
        self.moving().iter().copied().zip(&self.states)
    }

    /// Takes the group through a substep, which `terms` are of.
    fn advance(&mut self, start: &StepStart) {
        let terms = &start.terms;
        let least = terms.restitution_speed.max(LEAST_BOUNCE);
        let view = GroupView { members: &self.members, moving: self.moving, links: &self.links };
        self.gaps.close(view, &mut self.states, terms.time);
        let (mut left, mut stride) = (terms.h, Stride { longest: terms.h, growth: FIRST_GROWTH });
        let mut events = 0;
        while left > NO_TIME * terms.h {
            let now = terms.time + (terms.h - left);
            self.find_points(left);
            self.pass_impacts(now, least);
            let may_bounce = events < MOST_LANDINGS && !self.is_spent();
            self.free.clear();
            let points = &self.points;
            let free = |(index, pair): (usize, &ReachablePair)| {
                let own = points.of(index);
                let rests = approach(own, &self.states).abs() <= least;
                pair.surface.restitution > 0.0 && may_bounce && !rests
            };
            self.free.extend(self.pairs.iter().enumerate().map(free));
            self.limits.find(&self.links, &self.states, now);
            self.free_rows.clear();
            self.free_rows.resize(self.links.last().map_or(0, |link| link.rows.end), false);
            for limit in &self.limits.list {
                let rests = limit.approach().abs() <= least;
                self.free_rows[limit.row] = limit.restitution > 0.0 && may_bounce && !rests;
            }
            let h = self.step_until_landing(&mut stride, left, now, start);
            self.commit(h);
            left -= h;
            if self.lands {
                events += 1;
                self.effort.cuts += 1;
            }
        }
        self.effort.unsettled += u32::from(events >= MOST_LANDINGS);
    }

    /// Longest share of a substep that goes by one forecast alone: where time is over, all of it.
    fn rough_step(&self) -> f64 {
        if self.smooth.positions.is_late() { 1.0 } else { ROUGH_STEP }
    }

    fn find_points(&mut self, h: f64) {
        let Self { points, pairs, shapes, states, search, .. } = self;
        place(shapes, states);
        for (shape, state) in shapes.iter_mut().zip(&*states) {
            (shape.linear, shape.angular) = (state.linear, state.angular);
        }
        let reach = |pair: &ReachablePair| {
            let [a, b] = pair.ends.map(|end| &shapes[end as usize]);
            closing_distance(a, b, h) + TOUCHING
        };
        points.find(pairs, shapes, reach, |_| 0, search);
    }

    fn pass_impacts(&mut self, time: f64, least: f64) {
        let may_bounce = !self.is_spent();
        let Self { members, moving, links, pairs, points, states, impacts, loads, joint_loads, .. } = self;
        let view = GroupView { members, moving: *moving, links };
        impacts.pass(view, time, pairs, points, least, may_bounce, states, |held, solver| {
            add_up(links, held, solver, loads, joint_loads, |_, _| None);
        });
    }

    /// A smooth step from `now`, s, over the time left, s, or as long as a forecast comes true, or until a free pair
    /// lands. Returns its length, and notes how long the next may be.
    fn step_until_landing(&mut self, stride: &mut Stride, left: f64, now: f64, start: &StepStart) -> f64 {
        let terms = &start.terms;
        let mut most = left.min(stride.longest);
        if self.is_spent() {
            most = left.min(self.rough_step() * terms.h);
            self.smooth_step(most, true, now, start);
            self.lose_gain();
            self.lands = false;
            return most;
        }
        let cuts = self.effort.cuts;
        loop {
            let overlap = self.true_step(&mut most, now, start);
            stride.note(most, self.effort.cuts > cuts);
            self.lands = overlap > LANDED;
            if !self.lands {
                return most;
            }
            let h = self.land_within(most, now, start);
            if self.smooth.is_true || h <= terms.h * SHORTEST_STEP || self.is_spent() {
                // In next to no time solves may come to anything.
                self.lose_gain();
                return h;
            }
            // Of a step up to there no forecast comes true, though that of a longer one did.
            most = 0.5 * h;
            self.effort.cuts += 1;
        }
    }

    /// A smooth step from `now`, s, of that length, s, or as long as a forecast comes true. The deepest overlap at its end, m.
    fn true_step(&mut self, most: &mut f64, now: f64, start: &StepStart) -> f64 {
        let shortest = start.terms.h * SHORTEST_STEP;
        loop {
            let overlap = self.smooth_step(*most, false, now, start);
            if self.smooth.is_true && self.missed() <= MISSED && self.exceeded_energy().is_none() {
                let Some(half_through) = self.half_through(*most) else { return overlap };
                *most = half_through;
            } else if *most <= shortest || self.is_spent() {
                if self.smooth.is_true {
                    self.lose_gain();
                    return overlap;
                }
                *most = most.min(self.rough_step() * start.terms.h);
                let overlap = self.smooth_step(*most, true, now, start);
                self.lose_gain();
                return overlap;
            } else {
                *most *= 0.5;
            }
            self.effort.cuts += 1;
        }
    }

    /// A smooth step up to the first landing within h, s, which was tried. Returns its length.
    fn land_within(&mut self, h: f64, now: f64, start: &StepStart) -> f64 {
        let Self { limits, links, states, free, free_rows, points, .. } = self;
        limits.find(links, states, now);
        self.landing.begin(h, &self.standings);
        self.landing.at_low.find([points, points], states, free, limits, free_rows);
        for _ in 0..MOST_TRIALS {
            let Some(h) = self.landing.next(start.terms.h).filter(|_| !self.is_spent()) else { break };
            let overlap = self.smooth_step(h, false, now, start);
            if (0.0..=LANDED).contains(&overlap) {
                return h;
            }
            self.landing.note(h, &self.standings);
        }
        // As near as rounding, or the work that it may take, lets it come: on the far side, but before it where the motion jumps, as
        // where something else is met as well.
        let (low, high) = self.landing.bracket();
        if self.smooth_step(high, false, now, start) > MISSED && low > NO_TIME * start.terms.h {
            self.smooth_step(low, false, now, start);
            return low;
        }
        high
    }

    /// A smooth step of h, s, from `now`, s. The deepest overlap of free pairs and limits at its end, m, of pairs beyond that at the
    /// start, which opens or has just bounced; negative: the least gap of those found.
    fn smooth_step(&mut self, h: f64, is_rough: bool, now: f64, start: &StepStart) -> f64 {
        let StepStart { terms, graph, loads } = start;
        let is_spent = self.is_spent();
        let Self { smooth, members, moving, links, pairs, free, free_rows, states, points, shapes, search, .. } = self;
        let view = GroupView { members, moving: *moving, links };
        let given = SmoothTerms {
            view,
            time: now,
            h,
            loads,
            gives: links.iter().any(MechanismLink::gives),
            pairs,
            free,
            free_rows,
            correction_speed: terms.correction_speed,
            closing: terms.h,
            is_rough,
            tolerance: if is_spent { ROUGH_TOLERANCE } else { TOLERANCE },
        };
        let start_force = |point: &GapPoint| {
            let pair = &pairs[point.pair as usize];
            graph.force(pair.key, point.feature)
        };
        smooth.step(&given, states, points, shapes, search, start_force);
        let Self { limits, standings, .. } = self;
        limits.find(links, &smooth.end, now + h);
        standings.find([points, &smooth.points], &smooth.end, free, limits, free_rows);
        standings.deepest()
    }

    /// The time, s, at which a pair that has passed through within the smooth step of h, s, is half through, if there is one.
    fn half_through(&mut self, h: f64) -> Option<f64> {
        let Self { crossings, pairs, free, shapes, states, smooth, points, .. } = self;
        let passage = Passage { h, states: [states, &smooth.end], points: [points, &smooth.points] };
        crossings.first(pairs, free, shapes, &passage)
    }

    /// How much deeper held pairs overlap at the end of the smooth step than before, m: contacts that no forecast had.
    fn missed(&self) -> f64 {
        let deepest =
            |points: &GapPoints, pair: usize| points.of(pair).iter().map(|point| -point.gap).fold(0.0, f64::max);
        let held = (0..self.pairs.len()).filter(|&pair| !self.free[pair]);
        held.map(|pair| deepest(&self.smooth.points, pair) - deepest(&self.points, pair)).fold(0.0, f64::max)
    }

    /// The kinetic energy that forces and supports let the smooth step come to, J, if it came to more: it is too long for how
    /// fast something turns. None where springs or motors may have given it. What bodies lose that are lifted out of an
    /// overlap is no loss of those that fall.
    fn exceeded_energy(&self) -> Option<f64> {
        let Self { smooth, members, moving, states, links, .. } = self;
        if !only_forces_work(members, *moving, states, links) {
            return None;
        }
        let work: f64 = members
            .iter()
            .zip(states.iter().zip(&smooth.end))
            .take(*moving)
            .map(|(member, (start, end))| member.force.dot(&(end.position - start.position)).max(0.0))
            .sum();
        let [before, after] = [states, &smooth.end].map(|states| self.kinetic_energies(states).sum::<f64>());
        let mass: f64 = members.iter().map(|member| member.mass).sum();
        let given = before + work;
        (after - given > ENERGY_GAINED * after + NO_ENERGY * mass).then_some(given)
    }

    /// Of each body that moves, J.
    fn kinetic_energies<'a>(&'a self, states: &'a [MemberState]) -> impl Iterator<Item = f64> + 'a {
        kinetic_energies(&self.members[..self.moving], states)
    }

    /// The last resort may be a solve that came to nothing, whose impulses fling bodies away. What a step gains it loses
    /// again: the fastest bodies go no further and no faster than the energy that there was lets them.
    fn lose_gain(&mut self) {
        let Some(given) = self.exceeded_energy() else { return };
        let energies: Vec<f64> = self.kinetic_energies(&self.smooth.end).collect();
        let most = highest_level(&energies, given);
        for ((end, start), energy) in self.smooth.end.iter_mut().zip(&self.states).zip(energies) {
            if energy > most {
                let share = (most / energy).sqrt();
                end.linear *= share;
                end.angular *= share;
                end.position = start.position.lerp(&end.position, share);
                end.rotation = start.rotation.nlerp(&end.rotation, share);
            }
        }
    }

    /// Makes the end of the smooth step the state.
    fn commit(&mut self, h: f64) {
        let Self { smooth, states, loads, joint_loads, links, effort, .. } = self;
        effort.jammed += smooth.jammed;
        effort.unsettled += u32::from(!smooth.is_settled());
        states.clone_from(&smooth.end);
        let (rate, SmoothStep { positions, held, .. }) = (2.0 / h, &*smooth);
        add_up(links, &held.list, positions, loads, joint_loads, |_, impulse| Some([impulse * rate; 2]));
        add_up(links, &smooth.held_at_end, &smooth.velocities, loads, joint_loads, |point, impulse| {
            let first =
                held.position(point).filter(|_| smooth.is_still).map(|known| &positions.impulses.contacts[known]);
            Some([impulse * rate, first.map_or(*impulse, |first| (first + impulse) * 0.5) * rate])
        });
        for (sum, load) in joint_loads.iter_mut().zip(&smooth.spring_loads) {
            *sum = sum.plus(load, h);
        }
    }

    /// Writes bodies and joint forces back.
    pub fn scatter(&self, bodies: &mut [Body], joints: &mut [Joint]) {
        for (&index, state) in self.bodies.iter().zip(&self.states).take(self.moving) {
            put(state, &mut bodies[index as usize]);
        }
        for (&joint, load) in self.joints.iter().zip(&self.joint_loads) {
            let joint = &mut joints[joint as usize];
            joint.set_load(load, [0.0; 6]);
            // Another method is not to start from it.
            joint.is_doubtful = self.effort.unsettled > 0;
        }
    }

    /// Rows of the last solve.
    pub fn rows(&self) -> u32 {
        (self.smooth.velocities.rows.len() + 3 * self.smooth.held_at_end.len()) as u32
    }

    /// Deepest overlap at the end of the step, m; 0 if there is none.
    pub fn overlap(&self) -> f64 {
        self.smooth.points.list.iter().map(|point| -point.gap).fold(0.0, f64::max)
    }

    /// By pair: the points at the end of the step, then those that carried something in it and are gone.
    pub fn point_forces(&self) -> Vec<PointForce> {
        let points = &self.smooth.points;
        let force = |pair: u32, point: &GapPoint, load: Option<&PointLoad>, is_last: bool| PointForce {
            pair: self.pairs[pair as usize].key.pair,
            point: point.point,
            normal: point.normal,
            depth: -point.gap,
            force: load.map_or_else(Vector3::zeros, |load| load.impulse),
            last_force: is_last.then(|| load.map_or_else(Vector3::zeros, |load| load.last)),
        };
        let is_gone = |load: &&PointLoad| points.position(load.point.pair, load.point.feature).is_none();
        let mut gone: Vec<_> = self.loads.list.iter().filter(is_gone).collect();
        gone.sort_unstable_by_key(|load| (load.point.pair, load.point.feature));
        let mut gone = gone.into_iter().peekable();
        let mut forces = Vec::new();
        for (index, free) in (0..).zip(&self.free) {
            for point in points.of(index as usize) {
                let is_held = !free && point.gap <= TOUCHING;
                forces.push(force(index, point, self.loads.get(index, point.feature), is_held));
            }
            while let Some(load) = gone.next_if(|load| load.point.pair == index) {
                forces.push(force(index, &load.point, Some(load), false));
            }
        }
        forces
    }

    /// The forces on each pair's points that the next step starts from.
    pub fn next_forces(&self) -> impl Iterator<Item = (PairKey, impl Iterator<Item = (FeatureId, Vector3<f64>)>)> {
        self.pairs.iter().enumerate().map(move |(index, pair)| {
            let next = move |point: &GapPoint| self.loads.get(index as u32, point.feature).map(|load| load.next);
            let points = self.smooth.points.of(index).iter();
            let points = points.map(move |point| (point.feature, next(point).unwrap_or_else(Vector3::zeros)));
            (pair.key, points)
        })
    }
}

/// Adds the impulses of a solve to the loads. Of a solve over a time `forces` are the last, and what the next step starts
/// from, N.
fn add_up(
    links: &[MechanismLink],
    held: &[GapPoint],
    solver: &GroupSolver,
    loads: &mut PointLoads,
    joint_impulses: &mut [Wrench<f64>],
    forces: impl Fn(&GapPoint, &Vector3<f64>) -> Option<[Vector3<f64>; 2]>,
) {
    for (point, impulse) in held.iter().zip(&solver.impulses.contacts) {
        loads.add(point, impulse, forces(point, impulse));
    }
    joint_impulses.iter_mut().zip(solver.loads(links)).for_each(|(sum, impulse)| *sum = sum.plus(&impulse, 1.0));
}

/// The level to which the highest of some energies are to be cut for their sum to be that given; the highest if it is less.
fn highest_level(energies: &[f64], given: f64) -> f64 {
    let mut sorted = energies.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (mut left, mut count) = (given.max(0.0), sorted.len() as f64);
    for &energy in &sorted {
        if energy * count >= left {
            return left / count;
        }
        (left, count) = (left - energy, count - 1.0);
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two balls at 1 m/s one is flung at 130 m/s.
    #[test]
    fn what_the_last_resort_gains_the_fastest_lose() {
        let ball = Member { mass: 2.0, inertia: Vector3::repeat(1.0), ..Member::FIXED };
        let at_speed = |speed: f64| MemberState {
            linear: Vector3::x() * speed,
            position: Vector3::x() * (0.01 * speed),
            ..MemberState::REST
        };
        let mut group = ContactGroup { moving: 2, members: vec![ball; 2], ..ContactGroup::default() };
        group.states = [MemberState { position: Vector3::zeros(), ..at_speed(1.0) }; 2].to_vec();
        group.smooth.end = vec![at_speed(130.0), at_speed(0.5)];
        group.lose_gain();
        let [flung, slow] = &group.smooth.end[..] else { panic!("two balls") };
        let given = 1.0 + 1.0 - 0.25;
        assert!((flung.linear.norm_squared() - given).abs() < 1e-12, "{}", flung.linear);
        assert!((flung.position.x - 0.01 * flung.linear.x).abs() < 1e-15);
        assert_eq!(*slow, at_speed(0.5));
    }

    #[test]
    fn the_highest_energies_are_cut_to_the_sum() {
        let energies = [5.0, 1.0, 100.0, 2.0];
        for (given, level) in [(200.0, f64::INFINITY), (13.0, 5.0), (10.0, 3.5), (4.0, 1.0), (2.0, 0.5), (-1.0, 0.0)] {
            assert_eq!(highest_level(&energies, given), level, "{given} J");
        }
    }
}
