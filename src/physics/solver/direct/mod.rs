//! Islands solved at once, all contacts and joints together, directly: at rest, for the whole step; in motion, where
//! there are joints, substep by substep ([`motion`]).
//!
//! Sweeps pass a load on from contact to contact, and springs that sweeps can follow give under it: a column of 30
//! cubes sinks by centimetres and leans, a light box under a heavy one is crushed. Where all is at rest and the body
//! graph is a tree or nearly one, the step
//!
//! (M + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b)
//!
//! is solved by block LDLᵀ in f64 ([`linear`](super::linear), on the graph of the bodies), in a time linear in its bodies;
//! rows are those of [`patch`]. Which points push and which patches slide is guessed from the step before and
//! corrected by Newton's method, of which a step at rest takes one iteration. The same factor then closes what is left
//! of depths and gaps, in positions and not in velocities.
//!
//! The factor is kept for as long as the same rows act where they did, so that a wall that stands costs two
//! substitutions a step; and where the step changes nothing any more, it need not be solved for until somebody else
//! changes something.
//!
//! An island that turns out not to rest, or whose rows do not settle, is left as it was, for the sweeps.

mod motion;
mod patch;
#[cfg(test)]
mod tests;

use std::ops::RangeInclusive;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::linear::{BlockLdl, BodyVector as Part, Elimination, Inverse};
use super::soft_terms::{SoftTerms, UNLIMITED};
use crate::physics::body::Body;
use crate::physics::body::world_inverse_inertia;
use crate::physics::collision::{ContactState, Slot};
use crate::physics::joint::Joint;
use crate::physics::joint::Softness;
use crate::physics::lanes::Record;
use crate::physics::solver::substeps::Parts;
pub(crate) use motion::MotionTerms;
use patch::{Blocks, Link, Motion, Patch, Shape, Side, Spring, motion, wrench};

/// Speed of a body, centre and rim together, up to which it is at rest, m/s.
const CALM: f64 = 0.05;
/// Products of blocks in a factorisation up to which an island is solved here: a wall of a hundred bodies.
const MOST_PRODUCTS: usize = 4_000;
/// Weight of rows of contacts over the mass of the island, at rest: what moves in a step then is 1e-4 of what would
/// without the rows, and nothing once they push what they must. What is left of a body when its contacts are eliminated
/// has lost the square of that, over its share of the mass, in digits: with 1e6 a house of cards cannot be factored.
const WEIGHT: f64 = 1e4;
/// Weight of rows of joints over the mass of the lighter body. What is left of that body when its joints are eliminated
/// has lost the square of that in digits.
const WEIGHT_OF_JOINTS: f64 = 1e5;
/// Guesses which rows act.
const ITERATIONS: usize = 12;
/// Where they fail, the next are made after as many steps as last time and as many more, up to this.
const LONGEST_PAUSE: u32 = 64;
/// Speed of a body under which a step counts as having changed nothing, m/s.
const STILL: f64 = 1e-6;
/// Impulse that is too small to solve again for, over the weight of a body in a step.
const SLIGHT: f64 = 1e-3;
/// Share of the slope at its start at which a line is level.
const FLAT: f64 = 0.01;
/// Places at which a line is looked at for where it is level.
const LOOKS: usize = 8;
/// Kinetic energy over that without rows which rounding does not explain.
const GAINED: f64 = 1.001;
/// Change of a world inertia over its size that a factor bears.
const INERTIA_MOVED: f64 = 1e-3;
/// Share of depths and gaps that is closed in a step.
const CLOSED: f64 = 0.1;
/// Fastest way out of a depth, m/s.
const FASTEST: f64 = 0.2;

/// The world as an island reads and writes it.
pub(crate) trait World {
    fn body(&self, index: u32) -> &Body;
    fn slot(&self, index: u32) -> &Slot;
    fn state(&self, slot: u32) -> &ContactState;
    fn joint(&self, index: u32) -> &Joint;
}

/// What is known of how an island can be factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Analysis {
    /// It was never at rest so far.
    Due,
    /// There is a pattern.
    Done,
    /// It is for the sweeps.
    Unsuitable,
}

/// What became of an island in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It is for the sweeps.
    Moves,
    /// It was solved: its bodies, contacts and joints are to be written.
    Rests,
    /// Nothing changes.
    Still,
}

/// A body as a step found or left it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    mass: f64,
    inverse_inertia_body: Vector3<f64>,
}

impl Seen {
    fn of(body: &Body) -> Self {
        let &Body { position, rotation, linear, angular, force, torque, mass, inverse_inertia_body, .. } = body;
        Self { position, rotation, linear, angular, force, torque, mass, inverse_inertia_body }
    }
}

/// An island and its factor.
pub(crate) struct DirectIsland {
    /// Global indices.
    members: Vec<u32>,
    contacts: Vec<u32>,
    joints: Vec<u32>,
    /// Of contacts, then joints: both bodies' places among the members.
    ends: Vec<[Option<u32>; 2]>,
    analysis: Analysis,
    pattern: Elimination,
    /// Whether it was solved here in the last step, at rest or in motion.
    pub is_solved: bool,
    /// Weight of the rows of contacts over the mass of the island.
    hardness: f64,
    /// Whether the guesses of the last substep in motion came to an end.
    has_settled: bool,
    /// Into what the step is cut; contacts follow who turns far within it.
    parts: Parts,
    /// What joints stiffen each member by.
    stiffnesses: Vec<Matrix3<f64>>,
    /// Steps for which no guesses were made after the last that failed, and those left.
    pause: u32,
    pause_left: u32,
    matrix: BlockLdl<f64, Inverse>,
    /// M v₀ + h f, by place in the pattern, like the next two.
    momentum: Vec<Part>,
    velocity: Vec<Part>,
    /// Of the guess before.
    before: Vec<Part>,
    correction: Vec<Part>,
    /// Of patches, then links: the motion before, and how far to the one at hand.
    ways: Vec<(Motion, Motion)>,
    patches: Vec<Patch>,
    links: Vec<Link>,
    /// Whether patches are those of the step before.
    is_going_on: bool,
    /// What the factor was made of, patches first; empty: there is none.
    factored: Vec<Shape>,
    /// What each adds to the matrix.
    blocks: Vec<Blocks>,
    /// Of the members, what the factor was made of.
    inertias: Vec<(f64, Matrix3<f64>)>,
    /// What does not move here but touches or holds it.
    partners: Vec<u32>,
    /// Members, then partners, after a step that changed nothing; else empty.
    seen: Vec<Seen>,
    /// Step, and the sum of when the manifolds were found.
    seen_with: (f64, u64),
}

impl DirectIsland {
    /// Of bodies that move, contacts by slot and joints, all ascending.
    pub fn new(members: Vec<u32>, contacts: Vec<u32>, joints: Vec<u32>) -> Self {
        Self {
            members,
            contacts,
            joints,
            ends: Vec::new(),
            analysis: Analysis::Due,
            pattern: Elimination::default(),
            is_solved: false,
            hardness: WEIGHT,
            has_settled: true,
            parts: Parts::default(),
            stiffnesses: Vec::new(),
            pause: 0,
            pause_left: 0,
            matrix: BlockLdl::default(),
            momentum: Vec::new(),
            velocity: Vec::new(),
            before: Vec::new(),
            correction: Vec::new(),
            ways: Vec::new(),
            patches: Vec::new(),
            links: Vec::new(),
            is_going_on: false,
            factored: Vec::new(),
            blocks: Vec::new(),
            inertias: Vec::new(),
            partners: Vec::new(),
            seen: Vec::new(),
            seen_with: (0.0, 0),
        }
    }

    fn analyse(&mut self, world: &impl World) -> Analysis {
        let local = |body: u32| self.members.binary_search(&body).ok().map(|local| local as u32);
        let of_contacts = self.contacts.iter().map(|&slot| world.slot(slot).pair).map(|pair| [pair.a, pair.b]);
        let of_joints = self.joints.iter().map(|&joint| world.joint(joint)).map(|joint| [joint.a, joint.b]);
        let pairs = of_contacts.chain(of_joints);
        self.ends = pairs.clone().map(|pair| pair.map(local)).collect();
        self.partners = pairs.flatten().filter(|&body| local(body).is_none()).collect();
        self.partners.sort_unstable();
        self.partners.dedup();
        let edges = self.ends.iter().filter_map(|[a, b]| Some([(*a)?, (*b)?]));
        let count = self.members.len();
        let Some(pattern) = Elimination::new(&vec![6; count], edges, MOST_PRODUCTS) else {
            return Analysis::Unsuitable;
        };
        self.pattern = pattern;
        for parts in [&mut self.momentum, &mut self.velocity, &mut self.before, &mut self.correction] {
            parts.resize(count, Part::zeros());
        }
        self.inertias.resize(count, (0.0, Matrix3::zeros()));
        self.patches.resize(self.contacts.len(), Patch::default());
        self.links.resize(self.joints.len(), Link::default());
        self.blocks.resize(self.ends.len(), Blocks::default());
        Analysis::Done
    }

    /// The bodies that move, global indices, ascending.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Its contacts, by slot.
    pub fn contacts(&self) -> &[u32] {
        &self.contacts
    }

    /// Its joints, global indices.
    pub fn joints(&self) -> &[u32] {
        &self.joints
    }

    /// Scalar rows: of each contact its points and three of friction, three of each joint.
    pub fn rows(&self) -> u32 {
        let of_contacts: usize = self.patches.iter().map(|patch| patch.points() + 3).sum();
        (of_contacts + 3 * self.joints.len()) as u32
    }

    /// Whether it is of these bodies, contacts and joints.
    pub fn is_of(&self, members: &[u32], contacts: &[u32], joints: &[u32]) -> bool {
        self.members == members && self.contacts == contacts && self.joints == joints
    }

    /// Tries a step of length `step`, s, of which the impulses of contacts are kept for `substeps` parts.
    /// `may_skip`: nobody wants to know what pushes where nothing changes.
    pub fn solve(&mut self, world: &impl World, step: f64, substeps: u32, may_skip: bool) -> Outcome {
        let seen_with = (step * f64::from(substeps), self.found_in(world));
        if may_skip && self.seen_with == seen_with && self.is_as_seen(world) {
            return Outcome::Still;
        }
        self.seen.clear();
        self.seen_with = seen_with;
        if !self.is_suitable(world) {
            self.is_going_on = false;
            return Outcome::Moves;
        }
        self.gather(world, step, f64::from(substeps));
        self.hardness = WEIGHT;
        let settles = self.settle(1.0 / step, ITERATIONS..=ITERATIONS);
        if settles {
            let share_per_step = CLOSED / step;
            self.correct([
                Closing { share_per_step, fastest: FASTEST },
                Closing { share_per_step, fastest: f64::INFINITY },
            ]);
        }
        self.pause = if settles { 0 } else { (2 * self.pause + 1).min(LONGEST_PAUSE) };
        self.pause_left = self.pause;
        let rests = settles && self.fastest(world, &self.velocity) <= CALM;
        if rests { Outcome::Rests } else { Outcome::Moves }
    }

    /// Whether it is at rest and can be solved here.
    fn is_suitable(&mut self, world: &impl World) -> bool {
        let is_rigid = |&joint: &u32| world.joint(joint).softness().is_none();
        let is_calm = |&member: &u32| {
            let body = world.body(member);
            moves_freely(body) && body.linear.norm() + body.angular.norm() * body.radius <= CALM
        };
        if !self.members.iter().all(is_calm) || !self.joints.iter().all(is_rigid) {
            return false;
        }
        // One that meets something fast within the step has its points where they will be then.
        if self.contacts.iter().any(|&slot| world.slot(slot).ahead != Vector3::zeros()) {
            return false;
        }
        if self.pause_left > 0 {
            self.pause_left -= 1;
            return false;
        }
        self.is_analysed(world)
    }

    fn is_analysed(&mut self, world: &impl World) -> bool {
        if self.analysis == Analysis::Due {
            self.analysis = self.analyse(world);
        }
        self.analysis == Analysis::Done
    }

    fn found_in(&self, world: &impl World) -> u64 {
        self.contacts.iter().map(|&slot| world.slot(slot).found_in).sum()
    }

    /// Whether the last step changed nothing, nor anybody since. Joints are not looked at, so with them it is not.
    fn is_as_seen(&self, world: &impl World) -> bool {
        let bodies = self.members.iter().chain(&self.partners);
        !self.seen.is_empty() && bodies.zip(&self.seen).all(|(&body, seen)| Seen::of(world.body(body)) == *seen)
    }

    /// Takes in what the step left, if it was so little that the next need not be solved for.
    pub fn remember(&mut self, world: &impl World) {
        let moved = self.fastest(world, &self.velocity).max(self.fastest(world, &self.correction));
        if moved <= STILL && self.joints.is_empty() {
            let bodies = self.members.iter().chain(&self.partners);
            self.seen.extend(bodies.map(|&body| Seen::of(world.body(body))));
        }
    }

    /// The largest speed of a body, centre and rim together.
    fn fastest(&self, world: &impl World, parts: &[Part]) -> f64 {
        let speeds = self.members.iter().enumerate().map(|(local, &member)| {
            let part = &parts[self.pattern.place(local as u32) as usize];
            part.fixed_rows::<3>(0).norm() + part.fixed_rows::<3>(3).norm() * world.body(member).radius
        });
        speeds.fold(0.0, f64::max)
    }

    fn gather(&mut self, world: &impl World, step: f64, substeps: f64) {
        let mut changed = false;
        for (local, (&member, known)) in self.members.iter().zip(&mut self.inertias).enumerate() {
            let body = world.body(member);
            let inertia = inertia_of_spin(body);
            changed |= known.0 != body.mass || (known.1 - inertia).amax() > INERTIA_MOVED * inertia.amax();
            self.momentum[self.pattern.place(local as u32) as usize] = momentum_of(body, &inertia, step);
            if changed {
                *known = (body.mass, inertia);
            }
        }
        if changed {
            self.factored.clear();
        }
        let (of_contacts, of_joints) = self.ends.split_at(self.contacts.len());
        for ((patch, &slot), ends) in self.patches.iter_mut().zip(&self.contacts).zip(of_contacts) {
            let before = std::mem::replace(patch, patch_of(world, slot, ends, substeps));
            if self.is_going_on {
                patch.resume(&before);
            }
        }
        self.is_going_on = true;
        for ((link, &joint), ends) in self.links.iter_mut().zip(&self.joints).zip(of_joints) {
            *link = link_of(world, joint, ends, step);
        }
    }

    /// See [`has_gained`]; the velocity is that of the guess at hand.
    fn has_gained(&self) -> bool {
        let placed = self.inertias.iter().enumerate().map(|(local, inertia)| {
            let place = self.pattern.place(local as u32) as usize;
            (inertia, &self.velocity[place], &self.momentum[place])
        });
        has_gained(placed)
    }

    /// Weight of the rows of contacts.
    fn weight(&self) -> f64 {
        self.hardness * self.inertias.iter().map(|(mass, _)| mass).sum::<f64>()
    }

    /// Newton's method on which rows act. Whether it found out within so many guesses: the fewer where what they end
    /// with can be gone on from.
    fn settle(&mut self, per_step: f64, guesses: RangeInclusive<usize>) -> bool {
        let weight = self.weight();
        let momentum: f64 = self.momentum.iter().map(|part| part.fixed_rows::<3>(0).norm()).sum();
        let slight = SLIGHT * momentum / self.members.len() as f64;
        for guess in 0..*guesses.end() {
            if !self.factor(weight) {
                self.velocity.iter_mut().for_each(|part| part.fill(0.0));
                return false;
            }
            std::mem::swap(&mut self.velocity, &mut self.before);
            self.velocity.copy_from_slice(&self.momentum);
            let Self { patches, links, pattern, velocity, matrix, .. } = self;
            for patch in patches.iter() {
                push(pattern, velocity, &patch.sides, &patch.impulse_at_rest(weight, per_step));
            }
            for link in links.iter() {
                let linear = link.impulse_at(&link.given);
                push(pattern, velocity, &link.sides, &Motion { linear, ..Motion::default() });
            }
            matrix.solve(pattern, &mut velocity[..]);
            let share = if guess == 0 { 1.0 } else { self.search_line(weight, per_step) };
            let Self { patches, links, pattern, velocity, before, .. } = self;
            if share < 1.0 {
                velocity.iter_mut().zip(&*before).for_each(|(part, before)| *part = before + (*part - before) * share);
            }
            let mut holds = share == 1.0;
            for patch in patches.iter_mut() {
                let motion = across(pattern, velocity, &patch.sides, &patch.given);
                holds &= patch.take(&motion, weight, per_step, slight);
            }
            for link in links.iter_mut() {
                let motion = across(pattern, velocity, &link.sides, &link.given);
                holds &= link.take(&motion, slight);
            }
            if holds {
                return true;
            }
            if guess + 1 >= *guesses.start() && !self.has_gained() {
                return false;
            }
        }
        false
    }

    /// Which share of the way from the velocity before to the one at hand to go. Rows that act as they must make
    ///
    /// φ(v) = ½ (v − v₀)ᵀM(v − v₀) + Σ |λ(v)|²/(2ρ)
    ///
    /// least, which is convex where friction has its limit: on a way down that ends in a climb, to where it is least.
    fn search_line(&mut self, weight: f64, per_step: f64) -> f64 {
        let Self { patches, links, pattern, velocity, before, momentum, inertias, ways, .. } = self;
        let (mut start, mut growth) = (0.0, 0.0);
        for (local, (mass, inertia)) in inertias.iter().enumerate() {
            let place = pattern.place(local as u32) as usize;
            let way = velocity[place] - before[place];
            let times = |part: &Part| {
                let (linear, angular) = halves(part);
                part_of(&(linear * *mass), &(inertia * angular))
            };
            start += way.dot(&(times(&before[place]) - momentum[place]));
            growth += way.dot(&times(&way));
        }
        let way = |sides, given| {
            let [from, to] = [&*before, &*velocity].map(|parts| across(pattern, parts, sides, given));
            (from, to.plus(&from, -1.0))
        };
        ways.clear();
        ways.extend(patches.iter().map(|patch| way(&patch.sides, &patch.given)));
        ways.extend(links.iter().map(|link| way(&link.sides, &link.given)));
        let (of_patches, of_links) = ways.split_at(patches.len());
        let slope = |share: f64| {
            let along_patches = patches
                .iter()
                .zip(of_patches)
                .map(|(patch, (from, way))| way.dot(&patch.impulse_at(&from.plus(way, share), weight, per_step)));
            let along_links =
                links.iter().zip(of_links).map(|(link, (from, way))| way.dot(&link.bounded_at(&from.plus(way, share))));
            start + share * growth - along_patches.chain(along_links).sum::<f64>()
        };
        level(slope)
    }

    /// Factors the matrix of the rows that act, unless the factor at hand will do.
    fn factor(&mut self, weight: f64) -> bool {
        let Self { matrix, patches, links, pattern, ends, factored, inertias, blocks, .. } = self;
        let shapes = patches.iter().map(Patch::shape).chain(links.iter().map(Link::shape));
        if factored.len() == ends.len() && shapes.clone().zip(factored.iter()).all(|(now, then)| now.is_nearly(then)) {
            return true;
        }
        factored.clear();
        factored.extend(shapes);
        matrix.clear(pattern);
        for (body, (mass, inertia)) in inertias.iter().enumerate() {
            let mut block = matrix.diagonal_mut::<6>(pattern.place(body as u32) as usize);
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_diagonal_element(*mass));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
        }
        let (of_patches, of_links) = blocks.split_at_mut(patches.len());
        let (shapes_of_patches, shapes_of_links) = factored.split_at(patches.len());
        for ((held, patch), shape) in of_patches.iter_mut().zip(patches.iter()).zip(shapes_of_patches) {
            held.update(shape, weight, || patch.blocks(weight));
        }
        for ((held, link), shape) in of_links.iter_mut().zip(links.iter()).zip(shapes_of_links) {
            held.update(shape, link.weight, || link.blocks());
        }
        for (held, [a, b]) in blocks.iter().zip(&*ends) {
            for (body, block) in [(a, &held.own[0]), (b, &held.own[1])] {
                if let Some(body) = *body {
                    let mut own = matrix.diagonal_mut::<6>(pattern.place(body) as usize);
                    own += block;
                }
            }
            if let (Some(a), Some(b)) = (*a, *b) {
                matrix.add(pattern.block(a, b), &held.across);
            }
        }
        let is_positive = matrix.factor(pattern);
        if !is_positive {
            factored.clear();
        }
        is_positive
    }

    /// What closes depths and gaps besides, as a velocity.
    fn correct(&mut self, [depths, gaps]: [Closing; 2]) {
        let weight = self.weight();
        let Self { patches, links, pattern, correction, matrix, factored, .. } = self;
        correction.fill(Part::zeros());
        // What closes a row must be in the factor.
        for (patch, shape) in patches.iter().zip(&*factored) {
            push(pattern, correction, &patch.sides, &patch.correction(shape, weight, &depths));
        }
        for link in links.iter().filter(|link| link.spring.is_none()) {
            let linear = link.separation * (-link.weight * gaps.rate(link.separation.norm()));
            push(pattern, correction, &link.sides, &Motion { linear, ..Motion::default() });
        }
        if correction.iter().any(|part| *part != Part::zeros()) {
            matrix.solve(pattern, &mut correction[..]);
        }
    }

    /// The state of a member at the end of the step, written to it.
    pub fn scatter(&self, local: usize, body: &mut Body, step: f64) {
        let place = self.pattern.place(local as u32) as usize;
        let (velocity, correction) = (halves(&self.velocity[place]), halves(&self.correction[place]));
        body.linear = velocity.0 / (1.0 + body.drag.0 * step);
        body.angular = velocity.1 / (1.0 + body.drag.1 * step);
        body.has_stepped = true;
        body.advance(&((velocity.0 + correction.0) * step), &((velocity.1 + correction.1) * step));
    }

    /// What a contact pushed, divided by `scale`, N·s.
    pub fn impulses(&self, contact: usize, scale: f64) -> Record<f32> {
        self.patches[contact].impulses(scale)
    }

    /// Impulse on B of a joint, N·s.
    pub fn joint_impulse(&self, joint: usize) -> Vector3<f64> {
        self.links[joint].impulse
    }
}

/// How fast errors are closed.
#[derive(Clone, Copy, Debug)]
struct Closing {
    /// 1/s.
    share_per_step: f64,
    /// m/s.
    fastest: f64,
}

impl Closing {
    /// Speed over an error of that size, 1/s.
    fn rate(&self, error: f64) -> f64 {
        if error * self.share_per_step > self.fastest { self.fastest / error } else { self.share_per_step }
    }
}

/// Where a slope that starts negative and only grows is level, or 1 if it still falls there.
fn level(slope: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let flat = FLAT * low.1.abs();
    if high.1 <= flat || low.1 >= 0.0 {
        return 1.0;
    }
    for _ in 0..LOOKS {
        // By the secant, but not too near the ends.
        let (width, secant) = (high.0 - low.0, low.1 / (low.1 - high.1));
        let share = low.0 + width * secant.clamp(0.1, 0.9);
        let now = (share, slope(share));
        if now.1.abs() <= flat {
            return share;
        }
        if now.1 > 0.0 { high = now } else { low = now }
    }
    if low.0 > 0.0 { low.0 } else { high.0 }
}

fn part_of(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Part {
    Part::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// Linear and angular.
fn halves(part: &Part) -> (Vector3<f64>, Vector3<f64>) {
    (part.fixed_rows::<3>(0).into_owned(), part.fixed_rows::<3>(3).into_owned())
}

/// M v + h f.
fn momentum_of(body: &Body, inertia: &Matrix3<f64>, h: f64) -> Part {
    let linear = body.linear * body.mass + body.force * h;
    let angular = inertia * body.angular + body.torque * h;
    part_of(&linear, &angular)
}

/// Whether bodies of these masses and inertias have more kinetic energy at a velocity than with their momentum, each
/// given so, alone: contacts and joints only take, so that some row pushes what another guess had it push. (A support
/// that moves gives, and costs a guess more.)
fn has_gained<'p>(bodies: impl Iterator<Item = (&'p (f64, Matrix3<f64>), &'p Part, &'p Part)>) -> bool {
    let (mut kinetic, mut free) = (0.0, 0.0);
    for ((mass, inertia), velocity, momentum) in bodies {
        let (linear, angular) = halves(velocity);
        kinetic += mass * linear.norm_squared() + angular.dot(&(inertia * angular));
        let (linear, angular) = halves(momentum);
        let spin = inertia.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&angular));
        free += linear.norm_squared() / mass + angular.dot(&spin);
    }
    kinetic > GAINED * free
}

/// Whether nothing of it is locked.
fn moves_freely(body: &Body) -> bool {
    body.rotation_freedom == Vector3::repeat(1.0)
        && body.inverse_mass.min() > 0.0
        && body.inverse_inertia_body.min() > 0.0
}

/// World axes.
fn inertia_of_spin(body: &Body) -> Matrix3<f64> {
    let principal = body.inverse_inertia_body.map(f64::recip);
    if principal.x == principal.y && principal.y == principal.z {
        return Matrix3::from_diagonal(&principal);
    }
    let axes = body.rotation.to_rotation_matrix().into_inner();
    axes * Matrix3::from_diagonal(&principal) * axes.transpose()
}

/// Motion at an arm of a body that does not move here.
fn given(body: &Body, arm: &Vector3<f64>) -> Motion {
    Motion { linear: body.point_velocity(arm), angular: body.angular }
}

/// The motion that sides without a member give: B's less A's.
fn given_across(sides: &[Side; 2], [a, b]: [&Body; 2], arms: [Vector3<f64>; 2]) -> Motion {
    let of = |side: &Side, body, arm| if side.body.is_some() { Motion::default() } else { given(body, &arm) };
    let (a, b) = (of(&sides[0], a, arms[0]), of(&sides[1], b, arms[1]));
    Motion { linear: b.linear - a.linear, angular: b.angular - a.angular }
}

fn patch_of(world: &impl World, slot: u32, ends: &[Option<u32>; 2], substeps: f64) -> Patch {
    let (state, slot) = (world.state(slot), world.slot(slot));
    let bodies = [slot.pair.a, slot.pair.b].map(|body| world.body(body));
    let [a, b] = bodies;
    let origin = slot.origin_in_world(a);
    let apart = b.position - a.position + slot.ahead - origin;
    let turns = bodies.map(|body| body.rotation.to_rotation_matrix().into_inner());
    let mut patch = Patch::new(state, &turns, &apart, substeps);
    patch.sides[0].arm += origin;
    for (side, body) in patch.sides.iter_mut().zip(ends) {
        side.body = *body;
    }
    patch.given = given_across(&patch.sides, bodies, patch.sides.map(|side| side.arm));
    patch
}

fn link_of(world: &impl World, joint: u32, ends: &[Option<u32>; 2], step: f64) -> Link {
    let joint = world.joint(joint);
    let bodies = [world.body(joint.a), world.body(joint.b)];
    let [anchor_a, anchor_b] = joint.anchors();
    let arms = [bodies[0].rotation * anchor_a, bodies[1].rotation * anchor_b];
    let sides = [0, 1].map(|side| Side { body: ends[side], arm: arms[side] });
    let separation = bodies[1].position - bodies[0].position + arms[1] - arms[0];
    let spring = joint.softness().map(|Softness { frequency, damping_ratio, max_force }| {
        // As sweeps take it: of the pair's own mass.
        let terms = SoftTerms::<f64>::new(frequency, damping_ratio, UNLIMITED, 0.0, step);
        let give: Matrix3<f64> = (0..2).map(|side| give(bodies[side], &sides[side])).sum();
        let mass = give.try_inverse().unwrap_or_else(Matrix3::zeros);
        Spring::new(mass * (terms.mass / terms.impulse), separation * terms.rate, max_force * step)
    });
    let masses = (0..2).filter(|&side| sides[side].body.is_some()).map(|side| bodies[side].mass);
    Link {
        weight: WEIGHT_OF_JOINTS * masses.fold(f64::INFINITY, f64::min),
        spring,
        sides,
        given: given_across(&sides, bodies, arms),
        separation,
        expected: joint.force * step,
        impulse: Vector3::zeros(),
    }
}

/// Velocity at the arm of a body for an impulse there.
fn give(body: &Body, side: &Side) -> Matrix3<f64> {
    if side.body.is_none() {
        return Matrix3::zeros();
    }
    let arm = side.arm.cross_matrix();
    let inverse_inertia = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
    Matrix3::from_diagonal(&body.inverse_mass) - arm * inverse_inertia * arm
}

/// Adds an impulse on B, and its reaction on A.
fn push(pattern: &Elimination, parts: &mut [Part], sides: &[Side; 2], impulse: &Motion) {
    let [a, b] = sides;
    if let Some(body) = a.body {
        parts[pattern.place(body) as usize] -= wrench(impulse, &a.arm);
    }
    if let Some(body) = b.body {
        parts[pattern.place(body) as usize] += wrench(impulse, &b.arm);
    }
}

/// B's motion less A's.
fn across(pattern: &Elimination, parts: &[Part], sides: &[Side; 2], given: &Motion) -> Motion {
    let of = |side: &Side| {
        side.body.map_or_else(Motion::default, |body| motion(&parts[pattern.place(body) as usize], &side.arm))
    };
    let [a, b] = sides.each_ref().map(of);
    Motion { linear: given.linear + b.linear - a.linear, angular: given.angular + b.angular - a.angular }
}
