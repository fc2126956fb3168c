//! Islands of contacts alone in motion, in which something light bears something heavy.
//!
//! A sweep stops what comes to a light body by as much as the light one weighs: a load of r times its mass takes r
//! sweeps, and sinks as long. So an island in which a body bears another [`HEAVY_LOAD`] times heavier is solved directly in
//! motion, substep by substep, where its factorisation takes no more than [`PRODUCTS_OF_RATIO`] times r products of blocks:
//! what sweeps would have to do grows with r, too. With the bound of friction of each contact given,
//!
//! φ(v) = ½ (v − v₀)ᵀM(v − v₀) + Σ |λ(v)|²/(2ρ), v₀ the velocities that forces alone give,
//!
//! is strictly convex and has a slope that is continuous (friction at its bound goes on straight, as Huber's function does):
//! Newton's method with the rows that act at the present velocities, and a search for the least along each line, comes
//! down from everywhere. It has ended where momenta balance, M (v − v₀) = Σ Jᵀλ. Then the bounds of friction are those of the
//! normal impulses found, and it goes on from there until they stay.
//!
//! What it ends with is no more than the bodies brought along: from φ(v) + ½ vᵀMv ≤ φ(0), the energy is less than that of v₀
//! and what the impulses of before may give, Σ λ̂²/(2ρ). Where it does not end, or that does not hold, nothing of the step
//! counts: [`Kept`](super::loads::Kept) has what bodies and contacts were before, the step is for the sweeps, and some after it.
//!
//! Rows are stiffer than beside joints, as through a column of n each gives a share: what is left of a speed after a
//! substep is 1/(1 + ρ/(n M)).

use nalgebra::Matrix3;

use super::constants::{
    BALANCE_ROUNDING, BELIEVED_SPEED, BOUND_ITERATIONS, DEPTH_CORRECTION, DOUBTFUL_STEPS, ENERGY_ROUNDING, HEAVY_LOAD,
    IMPULSE_TOLERANCE, LOADED_CONTACT_PENALTY, LOADED_ITERATIONS, LOADED_LINE_POINTS, LOADED_PRODUCTS, LOADED_WORK,
    LONGEST_PAUSE, PRODUCTS_OF_RATIO, RENEWALS, REST_SPEED,
};
use super::island::{DirectIsland, apply, energies, level, relative_motion};
use super::loads::Loads;
use super::motion::MotionTerms;
use super::rows::{Correction, Rows, body_vector, halves};
use super::world::World;
use crate::physics::body::{Body, RigidBody};
use crate::physics::constraint::row::Twist;
use crate::physics::solver::linear::BodyVector;
use crate::physics::solver::substeps::Intervals;

impl DirectIsland {
    /// Whether it is to be tried in a step in motion, if it has no joints.
    pub(super) fn may_set_off_loaded(&mut self, world: &impl World) -> bool {
        let ratio = self.loads.ratio.unwrap_or_else(|| self.load_ratio(world));
        self.loads.ratio = Some(ratio);
        // A tree takes two products a body, whatever is not one more.
        if ratio < HEAVY_LOAD || 2 * self.members.len() > self.loaded_products() {
            return false;
        }
        let may = self.loads.pause_left == 0;
        self.loads.pause_left = self.loads.pause_left.saturating_sub(1);
        may
    }

    /// Products of blocks up to which it is solved in motion, if it has no joints.
    pub(super) fn loaded_products(&self) -> usize {
        let ratio = self.loads.ratio.unwrap_or(0.0);
        LOADED_PRODUCTS.min((PRODUCTS_OF_RATIO * ratio) as usize)
    }

    /// The greatest mass of a body over that of one under it: that it touches, and that something else touches, too.
    fn load_ratio(&self, world: &impl World) -> f64 {
        let mut touched = vec![(0, 0.0_f64); self.members.len()];
        for &slot in &self.contacts {
            let pair = world.slot(slot).pair;
            for (body, other) in [(pair.a, pair.b), (pair.b, pair.a)] {
                if let Ok(place) = self.members.binary_search(&body) {
                    let (count, heaviest) = &mut touched[place];
                    *count += 1;
                    *heaviest = heaviest.max(world.body(other).mass);
                }
            }
        }
        let under = self.members.iter().zip(&touched).filter(|(_, (count, _))| *count > 1);
        under.map(|(&member, (_, heaviest))| heaviest / world.body(member).mass).fold(0.0, f64::max)
    }

    /// Takes in what a step may have to go back to.
    pub fn keep(&mut self, world: &impl World) {
        let Self { kept, members, contacts, .. } = self;
        kept.bodies.clear();
        kept.bodies.extend(members.iter().map(|&member| world.body(member).clone()));
        kept.impulses.clear();
        kept.impulses.extend(contacts.iter().map(|&slot| world.state(slot).impulses));
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
        for (local, &member) in self.members.iter().enumerate() {
            let Body { linear, angular, .. } = world.body(member);
            let place = self.place(local);
            self.velocity[place] = body_vector(linear, angular);
        }
        self.contact_rows.iter_mut().for_each(|rows| rows.expect_limit());
        let least = self.rounding();
        let tolerance = self.speed_tolerance();
        let (mut is_renewed, mut renewals) = (false, 0);
        let most = LOADED_ITERATIONS.min(LOADED_WORK / self.elimination.products().max(1));
        for iteration in 0..most {
            self.settle();
            let is_balanced = self.is_balanced(tolerance, least);
            if is_balanced {
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

    /// Has contacts take in the present velocities.
    fn settle(&mut self) {
        let Self { contact_rows, elimination, velocity, .. } = self;
        for rows in contact_rows {
            let motion = relative_motion(elimination, velocity, rows, &rows.prescribed);
            rows.settle(&motion);
        }
    }

    /// Leaves in `before` what impulses give less what the velocities take, M (v₀ − v) + Σ Jᵀλ, N·s. Whether that is, for
    /// each body, less than what gives it the speed of `tolerance`, m/s, or less than `least`, N·s.
    fn is_balanced(&mut self, tolerance: f64, least: f64) -> bool {
        let Self { contact_rows, elimination, velocity, before, momentum, inertias, .. } = self;
        for (local, (mass, inertia)) in inertias.iter().enumerate() {
            let place = elimination.place(local as u32) as usize;
            let (linear, angular) = halves(&velocity[place]);
            before[place] = momentum[place] - body_vector(&(linear * *mass), &(inertia * angular));
        }
        for rows in &*contact_rows {
            let motion = relative_motion(elimination, velocity, rows, &rows.prescribed);
            apply(elimination, before, rows, &rows.impulse_at(&motion));
        }
        inertias.iter().enumerate().all(|(local, (mass, inertia))| {
            let (linear, angular) = halves(&before[elimination.place(local as u32) as usize]);
            // Of a moment, over the radius of gyration.
            let about = angular.norm() * (3.0 * mass / inertia.trace()).sqrt();
            linear.norm() + about <= (tolerance * mass).max(least)
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
