//! Islands of contacts alone in motion, in which something light bears something heavy.
//!
//! A sweep stops what comes to a light body by as much as the light one weighs. So a load of r times its mass takes r
//! sweeps, and sinks as long: what comes at v sinks by about 0.05 r v h, h the substep, measured with slabs of 5 to 1000
//! times the mass of each of the two cubes that they fall on. An island in which a body bears another [`HEAVY_LOAD`] times
//! heavier is solved directly in motion, substep by substep, if that does not cost too much. A body bears what pushes it if
//! something else pushes it the other way: what is only hit flies off, and sweeps tell how.
//!
//! **Cost.** A factorisation takes some number of products of blocks, about two a body where the island is a tree (a
//! column, a slab on a row), twenty a body in a wall of ten rows. What sweeps would have to do for a body grows with r; so
//! up to [`BODY_PRODUCTS_OF_RATIO`] r products a body are spent, and in all up to [`PRODUCTS_OF_RATIO`] r, and never
//! over [`LOADED_PRODUCTS`]. Trees come to rest so soon that they take less time than by sweeps. What all islands of a world
//! take beyond them comes from a reserve that fills up again ([`LoadAccount`](super::loads::LoadAccount)): enough for what
//! lands now and then, not for a heap of unequal bodies that tumbles, nor for a block of balls, which lands as hundreds of
//! rows: a row of bodies of which none is much heavier than the next takes all it needs from there, many times
//! ([`ROW_COST`]). Heaps of bodies that differ in mass by 8 to 20 hardly
//! ever come here.
//!
//! **Solving.** With the bound of friction of each contact given,
//!
//! φ(v) = ½ (v − v₀)ᵀM(v − v₀) + Σ |λ(v)|²/(2ρ), v₀ the velocities that forces alone give,
//!
//! is strictly convex and has a slope that is continuous (friction at its bound goes on straight, as Huber's function does):
//! Newton's method with the rows that act at the present velocities, and a search for the least along each line, comes
//! down from everywhere. It has ended where momenta balance, M (v − v₀) = Σ Jᵀλ; in many iterations, where they nearly
//! do ([`LATE_SHARE`]). Then the bounds of friction are those of the normal impulses found, and it goes on from there until
//! they stay.
//!
//! Impulses λ are told from λ̂, those of the substep before ([`Rows`]), so that what rests is exact and takes two
//! iterations. After an impact they would say that there is another. So they are taken s times, by as much as they explain of what
//! forces do ([`DirectIsland::expect_what_balances`]), and so they are left to the next step, which may be swept: a ball that has landed on a wall of 55 cubes takes a seventh of
//! the time, and one of 105 comes to an end at all.
//!
//! What it ends with is no more than the bodies brought along: from φ(v) + ½ vᵀMv ≤ φ(0), the energy is less than that of v₀
//! and what the impulses of before may give, Σ λ̂²/(2ρ). Where it does not end, or that does not hold, nothing of the step
//! counts: [`Kept`](super::loads::Kept) has what bodies and contacts were before, the step is for the sweeps, and some after it.
//!
//! **Restitution.** A step in which some contact of the island may bounce is for the sweeps, before which impacts are
//! solved pair by pair; the next, in which nothing comes so fast, is solved here.
//!
//! Rows are stiffer than beside joints, as through a column of n each gives a share: what is left of a speed after a
//! substep is 1/(1 + ρ/(n M)).

use nalgebra::{Matrix3, Vector3};

use super::constants::{
    AGAINST, BALANCE_ROUNDING, BELIEVED_SPEED, BODY_PRODUCTS_OF_RATIO, BOUND_ITERATIONS, DEPTH_CORRECTION,
    DOUBTFUL_STEPS, ENERGY_ROUNDING, HEAVY_LOAD, IMPULSE_TOLERANCE, LATE_ITERATIONS, LATE_SHARE,
    LOADED_CONTACT_PENALTY, LOADED_ITERATIONS, LOADED_LINE_POINTS, LOADED_PRODUCTS, LOADED_WORK, LONGEST_PAUSE,
    MOST_SHARE, PRODUCTS_OF_RATIO, RENEWALS, REST_SPEED, ROW_COST,
};
use super::island::{DirectIsland, apply, energies, level, relative_motion};
use super::loads::Loads;
use super::motion::MotionTerms;
use super::rows::{Correction, Rows, body_vector, halves};
use super::world::World;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::Pair;
use crate::physics::constraint::row::Twist;
use crate::physics::refill::Refill;
use crate::physics::solver::linear::BodyVector;
use crate::physics::solver::substeps::Intervals;

impl DirectIsland {
    /// Whether it is to be tried in a step in motion, if it has no joints.
    pub(super) fn may_set_off_loaded(&mut self, world: &impl World, terms: &MotionTerms) -> bool {
        self.loads.may_spend = terms.may_spend;
        let most = self.loads.mass_ratio.unwrap_or_else(|| {
            let parts = [&self.members[..], &self.contacts];
            let touching = mass_ratio(world, parts, &[]);
            self.loads.is_row = touching < HEAVY_LOAD;
            self.loads.behind = if self.loads.is_row { masses_behind(world, parts) } else { Vec::new() };
            if self.loads.behind.is_empty() { touching } else { mass_ratio(world, parts, &self.loads.behind) }
        });
        self.loads.mass_ratio = Some(most);
        self.loads.ratio = 0.0;
        let is_too_much = self.tree_products() > LOADED_PRODUCTS || self.loads.is_row && !terms.may_spend;
        if most < HEAVY_LOAD || is_too_much {
            return false;
        }
        self.loads.ratio = self.load_ratio(world);
        if self.loads.ratio < HEAVY_LOAD || self.tree_products() > self.loaded_products() {
            return false;
        }
        let may = self.loads.pause_left == 0;
        self.loads.pause_left = self.loads.pause_left.saturating_sub(1);
        may
    }

    /// Products of blocks up to which it is solved in motion, if it has no joints: see above.
    pub(super) fn loaded_products(&self) -> usize {
        let ratio = self.loads.ratio;
        let in_all = LOADED_PRODUCTS.min((PRODUCTS_OF_RATIO * ratio) as usize);
        let by_size = in_all.min((BODY_PRODUCTS_OF_RATIO * ratio * self.members.len() as f64) as usize);
        if self.loads.may_spend { by_size } else { by_size.min(self.tree_products()) }
    }

    /// Products of blocks of a tree of as many members; what is none takes more.
    fn tree_products(&self) -> usize {
        2 * self.members.len()
    }

    /// How many products of blocks it took beyond those of a tree since this was asked for.
    pub fn take_spent(&mut self) -> u64 {
        std::mem::take(&mut self.loads.spent) as u64
    }

    /// The greatest mass of a body over that of one that bears it: that it pushes, and that something else pushes about the
    /// other way.
    fn load_ratio(&mut self, world: &impl World) -> f64 {
        let Self { loads: Loads { heaviest, behind, .. }, members, contacts, .. } = self;
        heaviest.refill(members.iter().map(|_| (0.0, Vector3::zeros())));
        let pushes = contacts.iter().enumerate().flat_map(|(index, &slot)| {
            let Pair { a, b } = world.slot(slot).pair;
            let normal = world.body(a).rotation * world.state(slot).geometry.normal();
            let [on_a, on_b] = behind.get(index).copied().unwrap_or_else(|| masses_before(world, [a, b]));
            [(a, on_a, -normal), (b, on_b, normal)]
        });
        let pushes = pushes.filter_map(|(body, mass, push)| Some((members.binary_search(&body).ok()?, mass, push)));
        for (place, mass, push) in pushes.clone() {
            if mass > heaviest[place].0 {
                heaviest[place] = (mass, push);
            }
        }
        let bearing = pushes.filter(|(place, _, push)| push.dot(&heaviest[*place].1) < -AGAINST);
        bearing.map(|(place, ..)| heaviest[place].0 / world.body(members[place]).mass).fold(0.0, f64::max)
    }

    /// Takes in what a step may have to go back to.
    pub fn keep(&mut self, world: &impl World) {
        let Self { kept, members, contacts, .. } = self;
        kept.bodies.clear();
        kept.bodies.extend(members.iter().map(|&member| world.body(member).clone()));
        kept.impulses.clear();
        kept.impulses.extend(contacts.iter().map(|&slot| world.state(slot).impulses));
    }

    /// Has contacts keep, of the impulses of the last substep, of length `h`, s, what the next may begin with, whoever
    /// solves it: sweeps would have that of an impact throw what is heavy up again.
    pub fn expect_next(&mut self, world: &impl World, h: f64) {
        self.take_momenta(world, h);
        self.take_velocities(world);
        self.expect_what_balances();
        self.contact_rows.iter_mut().for_each(|rows| rows.keep_expected());
    }

    /// Takes in the velocities of members.
    pub(super) fn take_velocities(&mut self, world: &impl World) {
        for (local, &member) in self.members.iter().enumerate() {
            let Body { linear, angular, .. } = world.body(member);
            let place = self.place(local);
            self.velocity[place] = body_vector(linear, angular);
        }
    }

    /// Solves for a substep. Whether what came out is to be believed.
    pub(super) fn substep_loaded(&mut self, world: &impl World, terms: &MotionTerms, is_first: bool) -> bool {
        let Intervals { h, replaces, turns_far, .. } = self.intervals;
        if is_first || turns_far {
            self.make_turned_rows(world, [h, replaces, LOADED_CONTACT_PENALTY], is_first);
        }
        self.take_momenta(world, h);
        self.factored.clear();
        let is_believed = self.find_velocities(world) && self.is_plausible(world);
        if !is_believed {
            self.loads.pause = (2 * self.loads.pause + DOUBTFUL_STEPS).min(LONGEST_PAUSE);
            self.loads.pause_left = self.loads.pause;
            return false;
        }
        if !is_first || self.intervals.count == 1 {
            self.loads.pause = 0;
        }
        if self.factored.is_empty() && !self.factor() {
            self.correction.fill(BodyVector::zeros());
        } else {
            let rates = [DEPTH_CORRECTION / h; 2];
            self.correct(&Correction { rates, speeds: [terms.correction_speed(); 2] });
        }
        true
    }

    /// Finds the least of φ, and the bounds of friction. Whether it did.
    fn find_velocities(&mut self, world: &impl World) -> bool {
        self.take_velocities(world);
        self.expect_what_balances();
        self.contact_rows.iter_mut().for_each(|rows| rows.expect_limit());
        let least = self.rounding();
        let tolerance = self.speed_tolerance();
        let (mut is_renewed, mut renewals) = (false, 0);
        let most = LOADED_ITERATIONS.min(LOADED_WORK / self.elimination.products().max(1));
        let products = self.elimination.products();
        let cost = if self.loads.is_row { ROW_COST * products } else { products.saturating_sub(self.tree_products()) };
        for iteration in 0..most {
            self.loads.spent += cost;
            self.settle();
            self.take_imbalance();
            if self.is_balanced(tolerance, least, missing_share(iteration)) {
                if is_renewed || renewals == RENEWALS || renewals > 0 && iteration > BOUND_ITERATIONS {
                    return true;
                }
                (is_renewed, renewals) = (true, renewals + 1);
                self.contact_rows.iter_mut().for_each(|rows| rows.renew_limit());
                continue;
            }
            is_renewed = false;
            if !self.factor() {
                return false;
            }
            let Self { matrix, elimination, before, .. } = self;
            matrix.solve(elimination, &mut before[..]);
            let share = self.search_descent();
            let pairs = self.velocity.iter_mut().zip(&self.before);
            pairs.for_each(|(velocity, line)| *velocity += line * share);
        }
        false
    }

    /// Takes the impulses expected s times, 0 ≤ s ≤ 1, so that with the present velocities v they leave the least of
    ///
    /// (M (v − v₀) − s q)ᵀ M⁻¹ (M (v − v₀) − s q), q = Σ Jᵀλ̂.
    ///
    /// What rests expects what it takes, s = 1. After an impact contacts would expect another one.
    fn expect_what_balances(&mut self) {
        let Some([_, along, square]) = self.weigh_expected() else { return };
        if square > 0.0 {
            self.expect_share((along / square).clamp(0.0, 1.0));
        }
    }

    /// Has contacts take in the present velocities.
    fn settle(&mut self) {
        let Self { contact_rows, elimination, velocity, .. } = self;
        for rows in contact_rows {
            let motion = relative_motion(elimination, velocity, rows, &rows.prescribed);
            rows.settle(&motion);
        }
    }

    /// Leaves in `before` what impulses give less what the velocities take, M (v₀ − v) + Σ Jᵀλ, N·s.
    fn take_imbalance(&mut self) {
        let Self { contact_rows, elimination, velocity, before, momentum, inertias, loads, .. } = self;
        loads.borne.reset(inertias.len(), 0.0);
        for (local, (mass, inertia)) in inertias.iter().enumerate() {
            let place = elimination.place(local as u32) as usize;
            let (linear, angular) = halves(&velocity[place]);
            before[place] = momentum[place] - body_vector(&(linear * *mass), &(inertia * angular));
        }
        for rows in &*contact_rows {
            let motion = relative_motion(elimination, velocity, rows, &rows.prescribed);
            let impulse = rows.impulse_at(&motion);
            for body in rows.sides.iter().filter_map(|side| side.body) {
                loads.borne[body as usize] += impulse.linear.norm();
            }
            apply(elimination, before, rows, &impulse);
        }
    }

    /// Whether what is left in `before` is, for each body, less than what gives it the speed of `tolerance`, m/s, or less
    /// than `least`, N·s, or than a share of what its contacts give it.
    fn is_balanced(&self, tolerance: f64, least: f64, share: f64) -> bool {
        self.inertias.iter().zip(&self.loads.borne).enumerate().all(|(local, ((mass, inertia), borne))| {
            let (linear, angular) = halves(&self.before[self.place(local)]);
            // Of a moment, over the radius of gyration.
            let about = angular.norm() * (3.0 * mass / inertia.trace()).sqrt();
            linear.norm() + about <= (tolerance * mass).max(least).max(share * borne)
        })
    }

    /// Speed that is too small to iterate again for, m/s.
    fn speed_tolerance(&self) -> f64 {
        let momentum: f64 = self.momentum.iter().map(|vector| vector.fixed_rows::<3>(0).norm()).sum();
        let mass: f64 = self.inertias.iter().map(|(mass, _)| mass).sum();
        IMPULSE_TOLERANCE * momentum / mass
    }

    /// Impulse that is lost in rounding, N·s.
    fn rounding(&self) -> f64 {
        let stiffest = self.contact_rows.iter().map(|rows| rows.penalty).fold(0.0, f64::max);
        BALANCE_ROUNDING * stiffest * self.fastest_before()
    }

    /// The largest speed of a member without the contacts, centre and rim together, m/s.
    fn fastest_before(&self) -> f64 {
        let speeds = self.inertias.iter().enumerate().map(|(local, (mass, inertia))| {
            let (linear, angular) = halves(&self.momentum[self.place(local)]);
            linear.norm() / mass + angular.norm() * (3.0 / (mass * inertia.trace())).sqrt()
        });
        speeds.fold(0.0, f64::max)
    }

    /// How far to go along the line in `before`: to where φ is least.
    fn search_descent(&mut self) -> f64 {
        let (mut start, mut growth) = (0.0, 0.0);
        for (local, (mass, inertia)) in self.inertias.iter().enumerate() {
            let place = self.place(local);
            let line = self.before[place];
            let times = |vector: &BodyVector| {
                let (linear, angular) = halves(vector);
                body_vector(&(linear * *mass), &(inertia * angular))
            };
            start += line.dot(&(times(&self.velocity[place]) - self.momentum[place]));
            growth += line.dot(&times(&line));
        }
        let Self { contact_rows, elimination, velocity, before, loads: Loads { lines, .. }, .. } = self;
        lines.clear();
        lines.extend(contact_rows.iter().map(|rows| {
            let from = relative_motion(elimination, velocity, rows, &rows.prescribed);
            (from, relative_motion(elimination, before, rows, &Twist::zero()))
        }));
        level(LOADED_LINE_POINTS, |share| {
            let given = contact_rows.iter().zip(&*lines);
            let given: f64 =
                given.map(|(rows, (from, line))| line.dot(&rows.impulse_at(&from.plus(line, share)))).sum();
            start + share * growth - given
        })
    }

    /// Whether the velocities found are such as contacts can leave: with no more energy than there was, and no body much
    /// faster than any came.
    fn is_plausible(&self, world: &impl World) -> bool {
        let bodies = || {
            self.inertias.iter().enumerate().map(|(local, inertia)| {
                let place = self.place(local);
                (inertia, &self.velocity[place], &self.momentum[place])
            })
        };
        let [kinetic, free] = energies(bodies());
        let stored: f64 = self.contact_rows.iter().map(|rows| rows.stored()).sum();
        let partners = self.partners.iter().map(|&partner| world.body(partner));
        let mut given = partners.filter(|body| body.kind == RigidBody::Kinematic);
        // What moves as it is told gives energy and speed.
        if given.next().is_some() {
            return kinetic.is_finite();
        }
        let rim = |(mass, inertia): &(f64, Matrix3<f64>), velocity: &BodyVector| {
            let (linear, angular) = halves(velocity);
            linear.norm() + angular.norm() * (inertia.trace() / (3.0 * mass)).sqrt()
        };
        let fastest = bodies().map(|(inertia, velocity, _)| rim(inertia, velocity)).fold(0.0, f64::max);
        kinetic <= ENERGY_ROUNDING * free + stored && fastest <= BELIEVED_SPEED * self.fastest_before() + REST_SPEED
    }
}

/// Share of what its contacts give a body that may be missing to it after so many iterations.
fn missing_share(iteration: usize) -> f64 {
    let late = iteration / LATE_ITERATIONS;
    if late == 0 { 0.0 } else { (LATE_SHARE * 10_f64.powi(late as i32 - 1)).min(MOST_SHARE) }
}

/// The greatest mass that a member touches, or has behind a contact, over its own: no load is a greater one.
fn mass_ratio(world: &impl World, [members, contacts]: [&[u32]; 2], behind: &[[f64; 2]]) -> f64 {
    let ratio = |(index, &slot): (usize, &u32)| {
        let Pair { a, b } = world.slot(slot).pair;
        if members.binary_search(&a).is_err() || members.binary_search(&b).is_err() {
            return 0.0;
        }
        let [on_a, on_b] = behind.get(index).copied().unwrap_or_else(|| masses_before(world, [a, b]));
        (on_a / world.body(a).mass).max(on_b / world.body(b).mass)
    };
    contacts.iter().enumerate().map(ratio).fold(0.0, f64::max)
}

/// The mass that A of a contact touches, and the one that B does; what does not fall has none.
fn masses_before(world: &impl World, [a, b]: [u32; 2]) -> [f64; 2] {
    [b, a].map(|other| world.body(other)).map(|other| if other.is_dynamic() { other.mass } else { 0.0 })
}

/// Of each contact of a row, in which no member touches more than two others, the mass of all members behind it, as A has
/// them before itself, and as B has; else empty.
fn masses_behind(world: &impl World, [members, contacts]: [&[u32]; 2]) -> Vec<[f64; 2]> {
    let place = |body: u32| members.binary_search(&body).ok();
    let ends = contacts.iter().map(|&slot| world.slot(slot).pair).map(|pair| [pair.a, pair.b].map(place));
    let inside = ends.clone().filter(|[a, b]| a.is_some() && b.is_some()).count();
    // A row closes no loop.
    if inside + 1 != members.len() {
        return Vec::new();
    }
    let masses = members.iter().map(|&member| world.body(member).mass);
    let whole: f64 = masses.clone().sum();
    // Most islands are too light to matter.
    if whole < HEAVY_LOAD * masses.clone().fold(f64::INFINITY, f64::min) {
        return Vec::new();
    }
    let ends: Vec<_> = ends.map(|[a, b]| Some([a?, b?])).collect();
    let mut around = vec![Vec::new(); members.len()];
    for (contact, ends) in ends.iter().enumerate() {
        ends.iter().flatten().for_each(|&end| around[end].push(contact));
    }
    let Some(end) = around.iter().position(|contacts| contacts.len() == 1) else { return Vec::new() };
    if around.iter().any(|contacts| contacts.len() > 2) {
        return Vec::new();
    }
    let mut behind = vec![[0.0; 2]; contacts.len()];
    let (mut at, mut last, mut passed) = (end, None, 0.0);
    while let Some(&contact) = around[at].iter().find(|&&contact| Some(contact) != last) {
        passed += world.body(members[at]).mass;
        let Some([a, b]) = ends[contact] else { break };
        behind[contact] = if a == at { [whole - passed, passed] } else { [passed, whole - passed] };
        (at, last) = (if a == at { b } else { a }, Some(contact));
    }
    behind
}
