//! Islands at rest, solved at once: all contacts and joints together, directly, for the whole step.
//!
//! Sweeps pass a load on from contact to contact, and springs that sweeps can follow give under it: a column of 30
//! cubes sinks by centimetres and leans, a light box under a heavy one is crushed. Where all is at rest and the body
//! graph is a tree or nearly one, the step
//!
//! (M + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b)
//!
//! is solved by block LDLᵀ in f64 ([`cholesky`], on the [`pattern`] of the graph), in a time linear in its bodies;
//! rows are those of [`patch`]. Which points push and which patches slide is guessed from the step before and
//! corrected by Newton's method, of which a step at rest takes one iteration. The same factor then closes what is left of
//! depths and gaps, in positions and not in velocities.
//!
//! The factor is kept for as long as the same rows act where they did, so that a wall that stands costs two
//! substitutions a step; and where the step changes nothing any more, it need not be solved for until somebody else
//! changes something.
//!
//! An island that turns out not to rest, or whose rows do not settle, is left as it was, for the sweeps.

mod cholesky;
mod patch;
mod pattern;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::physics::bodies::{Body, Joint};
use crate::physics::collision::{ContactState, Slot};
use crate::physics::lanes::Record;
use cholesky::{BlockMatrix, Part};
use patch::{Link, Motion, Patch, Shape, Side, motion, wrench};
use pattern::Pattern;

/// Speed of a body, centre and rim together, up to which it is at rest, m/s.
const CALM: f64 = 0.05;
/// Products of blocks in a factorisation up to which an island is solved here: a wall of a hundred bodies.
const MOST_PRODUCTS: usize = 4_000;
/// Weight of rows over the mass of the island: what moves in a step then is 1e-6 of what would without the rows.
const WEIGHT: f64 = 1e6;
/// Guesses which rows act.
const ITERATIONS: usize = 12;
/// Where they fail, the next are made after as many steps as last time and as many more, up to this.
const LONGEST_PAUSE: u32 = 64;
/// Speed of a body under which a step counts as having changed nothing, m/s.
const STILL: f64 = 1e-6;
/// Impulse that is too small to solve again for, over the weight of a body in a step.
const SLIGHT: f64 = 1e-3;
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
    pattern: Pattern,
    /// Whether it was solved here in the last step.
    pub rests: bool,
    /// Steps for which no guesses were made after the last that failed, and those left.
    pause: u32,
    pause_left: u32,
    matrix: BlockMatrix,
    /// M v₀ + h f, by place in the pattern, like the next two.
    momentum: Vec<Part>,
    velocity: Vec<Part>,
    correction: Vec<Part>,
    patches: Vec<Patch>,
    links: Vec<Link>,
    /// Whether patches are those of the step before.
    is_going_on: bool,
    /// What the factor was made of, patches first; empty: there is none.
    factored: Vec<Shape>,
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
            pattern: Pattern::default(),
            rests: false,
            pause: 0,
            pause_left: 0,
            matrix: BlockMatrix::default(),
            momentum: Vec::new(),
            velocity: Vec::new(),
            correction: Vec::new(),
            patches: Vec::new(),
            links: Vec::new(),
            is_going_on: false,
            factored: Vec::new(),
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
        let Some(pattern) = Pattern::new(count, edges, MOST_PRODUCTS) else { return Analysis::Unsuitable };
        self.pattern = pattern;
        for parts in [&mut self.momentum, &mut self.velocity, &mut self.correction] {
            parts.resize(count, Part::zeros());
        }
        self.inertias.resize(count, (0.0, Matrix3::zeros()));
        self.patches.resize(self.contacts.len(), Patch::default());
        self.links.resize(self.joints.len(), Link::default());
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
        self.rests = self.is_suitable(world);
        if !self.rests {
            self.is_going_on = false;
            return Outcome::Moves;
        }
        self.gather(world, step, f64::from(substeps));
        self.rests = self.settle(1.0 / step);
        self.pause = if self.rests { 0 } else { (2 * self.pause + 1).min(LONGEST_PAUSE) };
        self.pause_left = self.pause;
        self.rests &= self.fastest(world, &self.velocity) <= CALM;
        if self.rests { Outcome::Rests } else { Outcome::Moves }
    }

    /// Whether it is at rest and can be solved here.
    fn is_suitable(&mut self, world: &impl World) -> bool {
        let is_rigid = |&joint: &u32| world.joint(joint).softness.is_none();
        let is_calm = |&member: &u32| {
            let body = world.body(member);
            let is_free = body.rotation_freedom == Vector3::repeat(1.0)
                && body.inverse_mass.min() > 0.0
                && body.inverse_inertia_body.min() > 0.0;
            is_free && body.linear.norm() + body.angular.norm() * body.radius <= CALM
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
            let inertia = world_inertia(body);
            changed |= known.0 != body.mass || (known.1 - inertia).amax() > INERTIA_MOVED * inertia.amax();
            let linear = body.linear * body.mass + body.force * step;
            let angular = inertia * body.angular + body.torque * step;
            let place = self.pattern.place(local as u32) as usize;
            self.momentum[place] = Part::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
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

    /// Newton's method on which rows act. Whether it found out.
    fn settle(&mut self, per_step: f64) -> bool {
        let weight = WEIGHT * self.inertias.iter().map(|(mass, _)| mass).sum::<f64>();
        let momentum: f64 = self.momentum.iter().map(|part| part.fixed_rows::<3>(0).norm()).sum();
        let slight = SLIGHT * momentum / self.members.len() as f64;
        for _ in 0..ITERATIONS {
            if !self.factor(weight) {
                return false;
            }
            self.velocity.copy_from_slice(&self.momentum);
            let Self { patches, links, pattern, velocity, matrix, .. } = self;
            for patch in patches.iter() {
                push(pattern, velocity, &patch.sides, &patch.impulse_at_rest(weight, per_step));
            }
            for link in links.iter() {
                let linear = link.impulse_at(&link.given, weight);
                push(pattern, velocity, &link.sides, &Motion { linear, ..Motion::default() });
            }
            matrix.solve(pattern, velocity);
            let mut holds = true;
            for patch in patches.iter_mut() {
                let motion = across(pattern, velocity, &patch.sides, &patch.given);
                holds &= patch.take(&motion, weight, per_step, slight);
            }
            if holds {
                for link in links.iter_mut() {
                    let motion = across(pattern, velocity, &link.sides, &link.given);
                    link.impulse = link.impulse_at(&motion, weight);
                }
                self.correct(weight, per_step);
                return true;
            }
        }
        false
    }

    /// Factors the matrix of the rows that act, unless the factor at hand will do.
    fn factor(&mut self, weight: f64) -> bool {
        let Self { matrix, patches, links, pattern, ends, factored, inertias, .. } = self;
        let shapes = patches.iter().map(Patch::shape).chain(links.iter().map(Link::shape));
        if factored.len() == ends.len() && shapes.clone().zip(factored.iter()).all(|(now, then)| now.is_nearly(then)) {
            return true;
        }
        factored.clear();
        factored.extend(shapes);
        matrix.clear(pattern);
        for (body, (mass, inertia)) in inertias.iter().enumerate() {
            let block = matrix.diagonal_mut(pattern, body as u32);
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_diagonal_element(*mass));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
        }
        let stiffnesses = patches.iter().map(|patch| (patch.sides, patch.stiffness(weight)));
        let stiffnesses = stiffnesses.chain(links.iter().map(|link| (link.sides, Link::stiffness(weight))));
        for ([a, b], stiffness) in stiffnesses {
            for side in [a, b] {
                if let Some(body) = side.body {
                    *matrix.diagonal_mut(pattern, body) += stiffness.between(&side.arm, &side.arm);
                }
            }
            if let (Some(body_a), Some(body_b)) = (a.body, b.body) {
                matrix.add(pattern, body_a, body_b, &-stiffness.between(&a.arm, &b.arm));
            }
        }
        let is_positive = matrix.factor(pattern);
        if !is_positive {
            factored.clear();
        }
        is_positive
    }

    /// What closes depths and gaps besides, as a velocity.
    fn correct(&mut self, weight: f64, per_step: f64) {
        let Self { patches, links, pattern, correction, matrix, .. } = self;
        correction.fill(Part::zeros());
        for patch in patches.iter() {
            push(pattern, correction, &patch.sides, &patch.correction(weight, CLOSED * per_step, FASTEST));
        }
        for link in links.iter() {
            let linear = link.separation * (-weight * CLOSED * per_step);
            push(pattern, correction, &link.sides, &Motion { linear, ..Motion::default() });
        }
        if correction.iter().any(|part| *part != Part::zeros()) {
            matrix.solve(pattern, correction);
        }
    }

    /// The state of a member at the end of the step, written to it.
    pub fn scatter(&self, local: usize, body: &mut Body, step: f64) {
        let place = self.pattern.place(local as u32) as usize;
        let part = |part: &Part| (part.fixed_rows::<3>(0).into_owned(), part.fixed_rows::<3>(3).into_owned());
        let (velocity, correction) = (part(&self.velocity[place]), part(&self.correction[place]));
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

fn world_inertia(body: &Body) -> Matrix3<f64> {
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
    let apart = b.position - a.position - origin;
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
    let Joint { a, b, anchor_a, anchor_b, force, .. } = world.joint(joint);
    let bodies = [world.body(*a), world.body(*b)];
    let arms = [bodies[0].rotation * anchor_a, bodies[1].rotation * anchor_b];
    let sides = [0, 1].map(|side| Side { body: ends[side], arm: arms[side] });
    Link {
        sides,
        given: given_across(&sides, bodies, arms),
        separation: bodies[1].position - bodies[0].position + arms[1] - arms[0],
        expected: force * step,
        impulse: Vector3::zeros(),
    }
}

/// Adds an impulse on B, and its reaction on A.
fn push(pattern: &Pattern, parts: &mut [Part], sides: &[Side; 2], impulse: &Motion) {
    let [a, b] = sides;
    if let Some(body) = a.body {
        parts[pattern.place(body) as usize] -= wrench(impulse, &a.arm);
    }
    if let Some(body) = b.body {
        parts[pattern.place(body) as usize] += wrench(impulse, &b.arm);
    }
}

/// B's motion less A's.
fn across(pattern: &Pattern, parts: &[Part], sides: &[Side; 2], given: &Motion) -> Motion {
    let of = |side: &Side| {
        side.body.map_or_else(Motion::default, |body| motion(&parts[pattern.place(body) as usize], &side.arm))
    };
    let [a, b] = sides.each_ref().map(of);
    Motion { linear: given.linear + b.linear - a.linear, angular: given.angular + b.angular - a.angular }
}
