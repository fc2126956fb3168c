//! A step without impacts: RATTLE with contacts.
//!
//! v½ = v₀ + ½h M₀⁻¹F + M₀⁻¹J₀ᵀλ, q₁ = q₀ after free motion over h with v½, v₁ = v½ + ½h M₁⁻¹F + M₁⁻¹J₁ᵀμ.
//!
//! λ makes positions hold: joints are closed at q₁, gaps g(q₁) ≥ 0, with a normal impulse only where g(q₁) = 0. μ makes
//! velocities hold: J₁v₁ = 0, and where g(q₁) = 0 gaps do not close. Both are within the cone of friction, against the
//! slip of v½ and of v₁. A pair that neither bounces nor has landed is stopped where the surfaces meet. Both impulses are
//! the cone solver's problem: λ with a linear forecast ĝ of the gaps, whose error (g − ĝ)/h corrects the bias until the
//! forecast comes true.
//!
//! Constant forces are followed exactly, sliding and rolling too; all else with an error of second order.

use nalgebra::Vector3;

use super::super::constants::{FORECAST_ERROR, MOST_FORECASTS, STALLED_ERROR, TOUCHING, UNFORESEEN, UNSOLVED};
use super::super::mechanism::{MechanismLink, Member, MemberState, stretch};
use super::super::rattle::move_freely;
use super::gap_points::{GapPoint, GapPoints, PointSearch, ReachablePair};
use super::group_solver::{GroupSolver, GroupView, arms_of, separation_of};
use crate::physics::body::Body;

/// What stays the same in a step.
#[derive(Clone, Copy)]
pub(super) struct SmoothTerms<'a> {
    pub view: GroupView<'a>,
    pub springs: &'a [MechanismLink],
    pub pairs: &'a [ReachablePair],
    /// Whether each pair is left free: it bounces and does not rest.
    pub free: &'a [bool],
    /// Fastest way out of an overlap, m/s.
    pub correction_speed: f64,
    /// Time over which errors of joints and overlaps are closed, s: a whole substep, for a step that is cut may be short.
    pub closing: f64,
    /// Whether one forecast has to do: the last resort where none comes true.
    pub is_rough: bool,
}

/// The step and its buffers.
#[derive(Default)]
pub(super) struct SmoothStep {
    pub positions: GroupSolver,
    pub velocities: GroupSolver,
    /// The points held by each: by positions first those at the start, in their order, then those met on the way.
    pub held: [Vec<GapPoint>; 2],
    /// How many of the former are those at the start.
    known: usize,
    /// The states at the end, and the points there.
    pub end: Vec<MemberState>,
    pub points: GapPoints,
    kicked: Vec<MemberState>,
    gains: Vec<f64>,
    joint_gains: Vec<Vector3<f64>>,
    /// How fast gaps open and anchors part at the start, m/s: the linear part of the forecast.
    openings: Vec<f64>,
    partings: Vec<Vector3<f64>>,
    /// Whether the forecast came true.
    pub is_true: bool,
    /// Sliding points at the start that no rigid motion satisfies.
    pub jammed: u32,
    /// Mean forces of springs, N, on B.
    pub spring_forces: Vec<Vector3<f64>>,
}

impl SmoothStep {
    /// From the states `start` over h, s, to [`Self::end`]. `start_points` are the contact points there; `bodies` take
    /// the poses of the end. `start_force` and `joint_start` are the forces that the iteration starts from, N.
    pub fn step(
        &mut self,
        given: &SmoothTerms,
        start: &[MemberState],
        start_points: &GapPoints,
        bodies: &mut [Body],
        search: &mut PointSearch,
        start_force: impl Fn(&GapPoint) -> Vector3<f64>,
        joint_start: &[Vector3<f64>],
        h: f64,
    ) {
        self.end.clear();
        self.end.extend_from_slice(start);
        self.spring_forces.clear();
        self.kick(given, h);
        self.kicked.clone_from(&self.end);
        self.hold_places(given, start, start_points, bodies, search, start_force, joint_start, h);
        self.kick(given, h);
        self.hold_velocities(given);
        self.is_true &= self.velocities.residual * given.closing <= UNSOLVED;
    }

    /// Half a step of forces, springs and drag.
    fn kick(&mut self, given: &SmoothTerms, h: f64) {
        for (at, link) in given.springs.iter().enumerate() {
            let force = spring_force(link, given.view.members, &self.end, 0.5 * h);
            match self.spring_forces.get_mut(at) {
                Some(mean) => *mean = (*mean + force) * 0.5,
                None => self.spring_forces.push(force),
            }
            let arms = arms_of(link, &self.end);
            for (end, arm, sign) in [(link.a, arms[0], -1.0), (link.b, arms[1], 1.0)] {
                let impulse = force * (sign * 0.5 * h);
                apply(&given.view.members[end as usize], &mut self.end[end as usize], &impulse, &arm.cross(&impulse));
            }
        }
        for (member, state) in given.view.members.iter().zip(&mut self.end) {
            state.linear *= (-member.drag.0 * 0.5 * h).exp();
            state.angular *= (-member.drag.1 * 0.5 * h).exp();
            apply(member, state, &(member.force * (0.5 * h)), &(member.torque * (0.5 * h)));
        }
    }

    fn hold_places(
        &mut self,
        given: &SmoothTerms,
        start: &[MemberState],
        start_points: &GapPoints,
        bodies: &mut [Body],
        search: &mut PointSearch,
        start_force: impl Fn(&GapPoint) -> Vector3<f64>,
        joint_start: &[Vector3<f64>],
        h: f64,
    ) {
        let Self { positions, held: [held, _], kicked, known, .. } = self;
        held.clear();
        held.extend(start_points.list.iter().filter(|point| !given.free[point.pair as usize]).cloned());
        *known = held.len();
        positions.set(given.view, kicked, held.iter());
        let separations: Vec<Vector3<f64>> = given.view.links.iter().map(|link| separation_of(link, start)).collect();
        self.jammed = positions.jammed(held.iter().map(|point| (point, point.velocity(start))));
        positions.impulses.contacts.clear();
        positions.impulses.contacts.extend(held.iter().map(|point| start_force(point) * (0.5 * h)));
        positions.impulses.joints.clear();
        positions.impulses.joints.extend(joint_start.iter().map(|force| force * (0.5 * h)));
        // An error that cannot be closed, as of a chain that is stretched too far, is left as it is.
        let is_open = held.iter().any(|point| point.gap < -STALLED_ERROR)
            || separations.iter().any(|gap| gap.amax() > STALLED_ERROR);
        self.is_true = self.forecast(given, bodies, search, &separations, 1.0, h)
            || is_open && !given.is_rough && self.forecast(given, bodies, search, &separations, 0.0, h);
    }

    /// Solves for positions until the forecast is what free motion makes of it. `closed` is the share of the errors at
    /// the start that is closed. Whether the forecast came true.
    fn forecast(
        &mut self,
        given: &SmoothTerms,
        bodies: &mut [Body],
        search: &mut PointSearch,
        separations: &[Vector3<f64>],
        closed: f64,
        h: f64,
    ) -> bool {
        let Self {
            positions, held: [held, _], known, end, points, kicked, gains, joint_gains, openings, partings, ..
        } = self;
        let first_gain = |point: &GapPoint| {
            if point.gap > 0.0 {
                point.gap / h
            } else {
                (point.gap * closed / given.closing).max(-given.correction_speed)
            }
        };
        gains.clear();
        gains.extend(held.iter().map(first_gain));
        joint_gains.clear();
        joint_gains.extend(separations.iter().map(|separation| separation * (closed / given.closing)));
        let mut before = f64::INFINITY;
        for _ in 0..MOST_FORECASTS {
            end.clone_from(kicked);
            positions.solve(end, gains, joint_gains);
            if positions.residual * h > UNSOLVED && !given.is_rough {
                return false;
            }
            openings.clear();
            openings.extend(held.iter().map(|point| point.opening(end)));
            partings.clear();
            partings.extend(given.view.links.iter().map(|link| stretch(link, &arms_of(link, end), end)[1]));
            for (member, state) in given.view.members.iter().zip(&mut *end) {
                move_freely(member, state, h);
            }
            place(bodies, end);
            points.find(given.pairs, bodies, |pair| margin(pair, bodies), search);
            if positions.is_empty() {
                return true;
            }
            let mut worst: f64 = 0.0;
            for (((point, gain), opening), impulse) in
                held.iter().zip(&mut *gains).zip(&*openings).zip(&positions.impulses.contacts)
            {
                let Some(found) = points.position(point.pair, point.feature) else { continue };
                let bent = points.list[found].gap - (point.gap + opening * h);
                let mended = first_gain(point) + bent / h;
                if *impulse != Vector3::zeros() || points.list[found].gap < -FORECAST_ERROR {
                    worst = worst.max((mended - *gain).abs() * h);
                    *gain = mended;
                }
            }
            // A contact that no forecast had is held from where it came from.
            let count = held.len();
            for point in &points.list {
                if point.gap < -UNFORESEEN && !given.free[point.pair as usize] && find(held, *known, point).is_none() {
                    held.push(GapPoint { gap: point.gap - point.opening(end) * h, ..point.clone() });
                }
            }
            if held.len() > count {
                worst = f64::INFINITY;
                positions.set(given.view, kicked, held.iter());
                gains.extend(held[count..].iter().map(first_gain));
                positions.impulses.contacts.resize(held.len(), Vector3::zeros());
            }
            for (index, link) in given.view.links.iter().enumerate() {
                let bent = separation_of(link, end) - (separations[index] + partings[index] * h);
                let mended = separations[index] * (closed / given.closing) + bent / h;
                worst = worst.max((mended - joint_gains[index]).amax() * h);
                joint_gains[index] = mended;
            }
            if worst <= FORECAST_ERROR || worst >= 0.5 * before && worst < STALLED_ERROR {
                return true;
            }
            if worst.is_finite() && worst > 2.0 * before || worst.is_nan() {
                return false;
            }
            before = if worst.is_finite() { before.min(worst) } else { f64::INFINITY };
            if given.is_rough || positions.is_spent() {
                break;
            }
        }
        before < STALLED_ERROR
    }

    fn hold_velocities(&mut self, given: &SmoothTerms) {
        let Self { velocities, positions, held: [before, held], known, end, points, gains, joint_gains, .. } = self;
        held.clear();
        let is_held = |point: &&GapPoint| !given.free[point.pair as usize] && point.gap <= TOUCHING;
        held.extend(points.list.iter().filter(is_held).cloned());
        velocities.set(given.view, end, held.iter());
        gains.clear();
        gains.resize(held.len(), 0.0);
        joint_gains.clear();
        joint_gains.resize(given.view.links.len(), Vector3::zeros());
        let start_force = |point: &GapPoint| {
            find(before, *known, point).map_or_else(Vector3::zeros, |known| positions.impulses.contacts[known])
        };
        velocities.impulses.contacts.clear();
        velocities.impulses.contacts.extend(held.iter().map(start_force));
        velocities.impulses.joints.clone_from(&positions.impulses.joints);
        velocities.solve(end, gains, joint_gains);
    }
}

/// The index of the same features' point among those held: the first `known` are in the order of pairs.
fn find(held: &[GapPoint], known: usize, point: &GapPoint) -> Option<usize> {
    let (ordered, met) = held.split_at(known);
    let first = ordered.partition_point(|other| other.pair < point.pair);
    let own = ordered[first..].iter().take_while(|other| other.pair == point.pair);
    let is_same = |other: &GapPoint| other.pair == point.pair && other.feature == point.feature;
    let among_known = own.clone().position(is_same).map(|at| first + at);
    among_known.or_else(|| met.iter().position(is_same).map(|at| known + at))
}

/// Gap up to which points are searched for at the end of a step, m.
fn margin(pair: &ReachablePair, bodies: &[Body]) -> f64 {
    let smaller = pair.ends.map(|end| bodies[end as usize].radius);
    1e-2 * smaller[0].min(smaller[1])
}

/// Writes the poses to the bodies.
pub(super) fn place(bodies: &mut [Body], states: &[MemberState]) {
    for (body, state) in bodies.iter_mut().zip(states) {
        body.position = state.position;
        body.rotation = state.rotation;
    }
}

fn apply(member: &Member, state: &mut MemberState, impulse: &Vector3<f64>, turning: &Vector3<f64>) {
    if !member.moves() {
        return;
    }
    state.linear += member.inverse_mass.component_mul(impulse);
    if *turning != Vector3::zeros() {
        let rotation = state.rotation.to_rotation_matrix().into_inner();
        state.angular += member.inverse_inertia(&rotation, None) * turning;
    }
}

/// Mean force of a spring on B over a kick of that time, s, in N, for the masses of its two bodies alone.
fn spring_force(link: &MechanismLink, members: &[Member], states: &[MemberState], time: f64) -> Vector3<f64> {
    let Some(spring) = &link.spring else { return Vector3::zeros() };
    let arms = arms_of(link, states);
    let mut mobility = Vector3::zeros();
    for (end, arm) in [(link.a, &arms[0]), (link.b, &arms[1])] {
        let member = &members[end as usize];
        let turning = arm.cross_matrix();
        let rotation = states[end as usize].rotation.to_rotation_matrix().into_inner();
        mobility += member.inverse_mass - (turning * member.inverse_inertia(&rotation, None) * turning).diagonal();
    }
    let [apart, speed] = stretch(link, &arms, states);
    spring.give(&spring.ask_in_kick(&apart, &speed, time), &mobility)
}
