//! What touches something, exactly: Signorini's condition and Coulomb's cone at the end of each step, in places and in
//! velocities, with joints in the same system; impacts at their times.
//!
//! A step is flown ([`flight`]) with all that does not bounce held. What bounces flies on; where it would have come
//! into something, the step ends at that time instead (to [`LANDED`] of gap), its impacts pass ([`impact`]), and the
//! rest of the step follows. Of bounces that become faster and faster those slower than [`impact::LEAST_BOUNCE`] are
//! none, and after [`MOST_EVENTS`] of them in a step the rest of it is flown without.
//!
//! A flight that does not come true is cut in two, again and again; what still does not, at [`SHORTEST`], is flown
//! roughly, by the forecast at its start alone. So is all that is left of a step that has taken [`kernel::MOST_WORK`].
//! Both are reported.

mod flight;
mod impact;
mod kernel;
mod sites;

use bevy::platform::collections::HashMap;
use nalgebra::Vector3;

use self::flight::{Flight, Given, TOUCHING, place};
use self::impact::{Impacts, LEAST_BOUNCE, approach};
use self::kernel::{Kernel, View};
use self::sites::{Finder, Pairing, Site, Sites};
use super::island::{link_of, member, motion, place_in, put};
use super::mechanism::{Link, Member, Motion};
use super::stepper::Effort;
use crate::physics::body::{Bodies, Body, SurfaceMaterial};
use crate::physics::collision::closing_distance;
use crate::physics::collision::{FeatureId, Pair};
use crate::physics::contact::{ContactCache, surface};
use crate::physics::joint::{Joint, Joints};
use crate::physics::settings::FrictionModel;

/// Overlap within which a landing is found, m.
const LANDED: f64 = 1e-11;
/// Overlap of what should be held, m, for which a flight is cut short.
const MISSED: f64 = 1e-6;
/// Kinetic energy that a flight may have made, as a share of what there is.
const GAINED: f64 = 3e-3;
/// Kinetic energy that is none, J/kg.
const STILL: f64 = 1e-12;
/// Flights are not cut to less than this share of a step for either.
const SHORTEST: f64 = 1.0 / 256.0;
/// A flight that need not come true is no longer than this share of a step.
const ROUGH: f64 = 1.0 / 16.0;
/// How much longer than the one before a flight of a step may be, at first: what could not be foreseen is mostly over
/// after a short flight. Each that has to be cut lowers it to that share, down to the least.
const FIRST_GROWTH: f64 = 64.0;
const OF_GROWTH: f64 = 0.25;
const LEAST_GROWTH: f64 = 1.25;
/// Landings in a step.
const MOST_EVENTS: u32 = 1_000;
/// Flights to find a landing.
const MOST_TRIALS: usize = 80;

/// What each point was pushed by, by pairing.
type Loads = HashMap<(u32, FeatureId), Load>;

/// What a point was pushed by.
#[derive(Clone, Debug)]
struct Load {
    /// Over the step, N·s on B; then its mean, N.
    impulse: Vector3<f64>,
    /// In the last solve that pushed there, N on B.
    last: Vector3<f64>,
    /// Where that was.
    site: Site,
}

/// A contact point with the force through it.
pub(crate) struct PointForce {
    pub pair: Pair,
    /// In the world, m, at the end of the step if it is there then, else where it was pushed last.
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

/// What a step depends on besides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactTerms {
    pub h: f64,
    pub parts: u32,
    /// Fastest way out of an overlap, m/s.
    pub correction_speed: f64,
    /// Approach up to which nothing bounces, m/s.
    pub restitution_speed: f64,
}

/// Bodies in reach of each other, and what joints hold to them.
#[derive(Default)]
pub(crate) struct Touching {
    /// Those that move first.
    bodies: Vec<u32>,
    moving: usize,
    /// Of links, then of springs.
    joints: Vec<u32>,
    links: Vec<Link>,
    springs: Vec<Link>,
    pairings: Vec<Pairing>,
    members: Vec<Member>,
    shapes: Vec<Body>,
    motion: Vec<Motion>,
    sites: Sites,
    finder: Finder,
    flies: Vec<bool>,
    flight: Flight,
    /// Whether it ends where something lands.
    flight_lands: bool,
    impacts: Impacts,
    loads: Loads,
    /// Mean forces of the step, N, on B.
    joint_forces: Vec<Vector3<f64>>,
    pub effort: Effort,
}

/// How long the next flight of a step may be.
struct Stride {
    /// s.
    longest: f64,
    growth: f64,
}

impl Stride {
    /// After a flight of so long, s, that had to be cut, or not.
    fn note(&mut self, flight: f64, is_cut: bool) {
        if is_cut {
            self.growth = (OF_GROWTH * self.growth).max(LEAST_GROWTH);
        }
        self.longest = self.growth * flight;
    }
}

impl Touching {
    /// Of those bodies that move, joints and pairs, by their indices in the world.
    pub fn new(moving: Vec<u32>, joints: Vec<u32>, pairs: &[Pair], all_joints: &Joints) -> Self {
        let mut bodies = moving;
        let moving = bodies.len();
        let mut place = |body: u32| place_in(&mut bodies, moving, body);
        let pairing = |&pair: &Pair| {
            // What their surfaces are like is taken in with the state.
            Pairing { pair, ends: [place(pair.a), place(pair.b)], surface: SurfaceMaterial::default() }
        };
        let pairings = pairs.iter().map(pairing).collect();
        let (rigid, soft): (Vec<u32>, Vec<u32>) =
            joints.into_iter().partition(|&joint| all_joints.list[joint as usize].softness().is_none());
        let mut link = |&joint: &u32| {
            let joint = &all_joints.list[joint as usize];
            link_of(joint, [place(joint.a), place(joint.b)])
        };
        let links = rigid.iter().map(&mut link).collect();
        let springs = soft.iter().map(&mut link).collect();
        Self { bodies, moving, joints: [rigid, soft].concat(), links, springs, pairings, ..Self::default() }
    }

    /// Takes the state in; of either model of friction this method has the cone.
    pub fn gather(&mut self, bodies: &Bodies, joints: &Joints, friction: FrictionModel) {
        let list = || self.bodies.iter().map(|&body| &bodies.list[body as usize]);
        self.members.clear();
        self.members.extend(list().map(member));
        self.motion.clear();
        self.motion.extend(list().map(motion));
        self.shapes.clear();
        self.shapes.extend(list().cloned());
        self.joint_forces.clear();
        self.joint_forces.extend(self.joints.iter().map(|&joint| joints.list[joint as usize].force));
        for pairing in &mut self.pairings {
            let [a, b] = pairing.ends.map(|end| &self.shapes[end as usize]);
            pairing.surface = surface(a, b, friction);
        }
    }

    /// Whether the step has taken all the work that it may.
    fn is_spent(&self) -> bool {
        self.flight.places.is_spent() || self.flight.velocities.is_spent() || self.impacts.kernel.is_spent()
    }

    /// Takes it through a step. `cache` has the forces of the one before.
    pub fn step(&mut self, terms: &ContactTerms, cache: &ContactCache) {
        self.effort = Effort::default();
        self.loads.clear();
        let guesses = std::mem::take(&mut self.joint_forces);
        self.joint_forces.resize(guesses.len(), Vector3::zeros());
        for _ in 0..terms.parts {
            self.advance(terms, cache, &guesses);
        }
        let step = terms.h * f64::from(terms.parts);
        self.joint_forces.iter_mut().for_each(|impulse| *impulse /= step);
        self.loads.values_mut().for_each(|load| load.impulse /= step);
        let kernels = [&mut self.flight.places, &mut self.flight.velocities, &mut self.impacts.kernel];
        for kernel in kernels {
            self.effort.solves += std::mem::take(&mut kernel.steps);
            self.effort.unsettled += std::mem::take(&mut kernel.failures);
            kernel.work = 0;
        }
    }

    fn advance(&mut self, terms: &ContactTerms, cache: &ContactCache, guesses: &[Vector3<f64>]) {
        let least = terms.restitution_speed.max(LEAST_BOUNCE);
        let (mut left, mut stride) = (terms.h, Stride { longest: terms.h, growth: FIRST_GROWTH });
        let mut events = 0;
        while left > 1e-12 * terms.h {
            self.find_sites(left);
            self.pass_impacts(least);
            let may_bounce = events < MOST_EVENTS && !self.is_spent();
            self.flies.clear();
            let sites = &self.sites;
            let flies = |(index, pairing): (usize, &Pairing)| {
                let own = sites.of(index);
                let rests = approach(own, &self.motion).abs() <= least;
                pairing.surface.restitution > 0.0 && may_bounce && !rests
            };
            self.flies.extend(self.pairings.iter().enumerate().map(flies));
            let h = self.fly_until_landing(&mut stride, left, terms, cache, guesses);
            self.commit(h);
            left -= h;
            if self.flight_lands {
                events += 1;
                self.effort.cuts += 1;
            }
        }
        self.effort.unsettled += u32::from(events >= MOST_EVENTS);
    }

    fn find_sites(&mut self, h: f64) {
        let Self { sites, pairings, shapes, motion, finder, .. } = self;
        place(shapes, motion);
        for (shape, motion) in shapes.iter_mut().zip(&*motion) {
            (shape.linear, shape.angular) = (motion.linear, motion.angular);
        }
        let reach = |pairing: &Pairing| {
            let [a, b] = pairing.ends.map(|end| &shapes[end as usize]);
            closing_distance(a, b, h) + TOUCHING
        };
        sites.find(pairings, shapes, reach, finder);
    }

    fn pass_impacts(&mut self, least: f64) {
        let may_bounce = !self.is_spent();
        let Self { members, moving, links, pairings, sites, motion, impacts, loads, joint_forces, .. } = self;
        let view = View { members, moving: *moving, links };
        impacts.pass(view, pairings, sites, least, may_bounce, motion, |held, kernel| {
            add_up(held, kernel, loads, joint_forces, None);
        });
    }

    /// Flies for what is left, s, or as long as a flight comes true, or until something that flies lands, to the end of
    /// the flight. Returns the time, and tells the next how long it may be.
    fn fly_until_landing(
        &mut self,
        stride: &mut Stride,
        left: f64,
        terms: &ContactTerms,
        cache: &ContactCache,
        guesses: &[Vector3<f64>],
    ) -> f64 {
        let mut most = left.min(stride.longest);
        if self.is_spent() {
            most = left.min(ROUGH * terms.h);
            self.fly(most, true, terms, cache, guesses);
            self.flight_lands = false;
            return most;
        }
        let cuts = self.effort.cuts;
        let mut overlap = self.fly(most, false, terms, cache, guesses);
        while !self.flight.is_true || self.missed() > MISSED || self.gains() {
            if most <= terms.h * SHORTEST || self.is_spent() {
                if !self.flight.is_true {
                    most = most.min(ROUGH * terms.h);
                    overlap = self.fly(most, true, terms, cache, guesses);
                }
                break;
            }
            most *= 0.5;
            self.effort.cuts += 1;
            overlap = self.fly(most, false, terms, cache, guesses);
        }
        stride.note(most, self.effort.cuts > cuts);
        self.flight_lands = overlap > LANDED;
        if !self.flight_lands {
            return most;
        }
        // Illinois' rule on the overlap less half of what is allowed; bisection where one end is not known.
        let target = 0.5 * LANDED;
        let (mut low, mut high) = (0.0, most);
        let (mut at_low, mut at_high) = (f64::NEG_INFINITY, overlap - target);
        for trial in 0..MOST_TRIALS {
            let share = if at_low.is_finite() && trial % 8 != 7 { at_low / (at_low - at_high) } else { 0.5 };
            let h = low + (high - low) * share;
            if h <= low || h >= high || self.is_spent() {
                break;
            }
            overlap = self.fly(h, false, terms, cache, guesses);
            if (0.0..=LANDED).contains(&overlap) {
                return h;
            }
            let value = overlap - target;
            if value > 0.0 {
                (high, at_high) = (h, value);
                at_low *= 0.5;
            } else {
                (low, at_low) = (h, value);
                at_high *= 0.5;
            }
        }
        // As near as rounding, or the work that it may take, lets it come, on the far side.
        self.fly(high, false, terms, cache, guesses);
        high
    }

    /// Flies for h, s. The deepest overlap of what flies at the end, m; negative: a gap, of those that are found.
    fn fly(
        &mut self,
        h: f64,
        is_rough: bool,
        terms: &ContactTerms,
        cache: &ContactCache,
        guesses: &[Vector3<f64>],
    ) -> f64 {
        let is_spent = self.is_spent();
        let Self { flight, members, moving, links, springs, pairings, flies, motion, sites, shapes, finder, .. } = self;
        (flight.places.is_rough, flight.velocities.is_rough) = (is_spent, is_spent);
        let view = View { members, moving: *moving, links };
        let (correction_speed, closing) = (terms.correction_speed, terms.h);
        let given = Given { view, springs, pairings, flies, correction_speed, closing, is_rough };
        let guess = |site: &Site| cache.force(pairings[site.pairing as usize].pair, site.feature);
        flight.fly(&given, motion, sites, shapes, finder, guess, &guesses[..links.len()], h);
        let landed = flight.sites.list.iter().filter(|site| flies[site.pairing as usize]);
        landed.map(|site| -site.gap).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How much deeper what is held overlaps at the end of the flight than it did, m: features met that were not seen
    /// to come, however often they were looked for.
    fn missed(&self) -> f64 {
        let deepest =
            |sites: &Sites, pairing: usize| sites.of(pairing).iter().map(|site| -site.gap).fold(0.0, f64::max);
        let held = (0..self.pairings.len()).filter(|&pairing| !self.flies[pairing]);
        held.map(|pairing| deepest(&self.flight.sites, pairing) - deepest(&self.sites, pairing)).fold(0.0, f64::max)
    }

    /// Whether the flight made motion that no force, spring or support gave: its step is too long for how fast
    /// something turns. What closing an overlap lifts is none of that.
    fn gains(&self) -> bool {
        let Self { flight, members, moving, motion, springs, .. } = self;
        let is_driven = !motion[*moving..].iter().all(Motion::is_still);
        if is_driven || !springs.is_empty() {
            return false;
        }
        let kinetic = |motion: &[Motion]| -> f64 {
            members.iter().zip(motion).take(*moving).map(|(member, motion)| member.kinetic_energy(motion)).sum()
        };
        let work: f64 = members
            .iter()
            .zip(motion.iter().zip(&flight.end))
            .take(*moving)
            .map(|(member, (start, end))| member.force.dot(&(end.position - start.position)))
            .sum();
        let (before, after) = (kinetic(motion), kinetic(&flight.end));
        let mass: f64 = members.iter().map(|member| member.mass).sum();
        after - before - work.max(0.0) > GAINED * after + STILL * mass
    }

    /// Makes the end of the flight the state.
    fn commit(&mut self, h: f64) {
        let Self { flight, motion, loads, joint_forces, links, effort, .. } = self;
        effort.jammed += flight.jammed;
        effort.unsettled += u32::from(!flight.is_true);
        motion.clone_from(&flight.end);
        for (kernel, held) in [&flight.places, &flight.velocities].into_iter().zip(&flight.held) {
            add_up(held, kernel, loads, joint_forces, Some(0.5 * h));
        }
        for (sum, force) in joint_forces[links.len()..].iter_mut().zip(&flight.spring_forces) {
            *sum += force * h;
        }
    }

    /// Writes bodies and joint forces back.
    pub fn scatter(&self, bodies: &mut [Body], joints: &mut [Joint]) {
        for (&index, motion) in self.bodies.iter().zip(&self.motion).take(self.moving) {
            put(motion, &mut bodies[index as usize]);
        }
        for (&joint, force) in self.joints.iter().zip(&self.joint_forces) {
            joints[joint as usize].force = *force;
        }
    }

    /// Rows of the last solve.
    pub fn rows(&self) -> u32 {
        3 * (self.links.len() + self.flight.held[1].len()) as u32
    }

    /// The points at the end of the step, then those that were pushed before and are there no more, by pair.
    pub fn point_forces(&self) -> Vec<PointForce> {
        let sites = &self.flight.sites;
        let force = |pairing: u32, site: &Site, load: Option<&Load>, is_last: bool| PointForce {
            pair: self.pairings[pairing as usize].pair,
            point: site.point,
            normal: site.normal,
            depth: -site.gap,
            force: load.map_or_else(Vector3::zeros, |load| load.impulse),
            last_force: is_last.then(|| load.map_or_else(Vector3::zeros, |load| load.last)),
        };
        let is_gone = |&(pairing, feature): &(u32, FeatureId)| sites.position(pairing, feature).is_none();
        let mut gone: Vec<_> = self.loads.iter().filter(|&(at, _)| is_gone(at)).collect();
        gone.sort_unstable_by_key(|(at, _)| **at);
        let mut gone = gone.into_iter().peekable();
        let mut forces = Vec::new();
        for (index, flies) in (0..).zip(&self.flies) {
            for site in sites.of(index as usize) {
                let is_held = !flies && site.gap <= TOUCHING;
                forces.push(force(index, site, self.loads.get(&(index, site.feature)), is_held));
            }
            while let Some((_, load)) = gone.next_if(|((pairing, _), _)| *pairing == index) {
                forces.push(force(index, &load.site, Some(load), false));
            }
        }
        forces
    }

    /// Keeps the forces for the next step.
    pub fn store(&self, cache: &mut ContactCache) {
        for (index, pairing) in self.pairings.iter().enumerate() {
            let last = |site: &Site| self.loads.get(&(index as u32, site.feature)).map(|load| load.last);
            let sites = self.flight.sites.of(index);
            cache.insert(
                pairing.pair,
                sites.iter().map(|site| (site.feature, last(site).unwrap_or_else(Vector3::zeros))),
            );
        }
    }
}

/// Adds what a solve pushed to what was pushed before. Of one that holds for a time, s, the forces are the last ones.
fn add_up(held: &[Site], kernel: &Kernel, loads: &mut Loads, joint_impulses: &mut [Vector3<f64>], time: Option<f64>) {
    for (site, impulse) in held.iter().zip(&kernel.impulses.contacts) {
        let nothing = || Load { impulse: Vector3::zeros(), last: Vector3::zeros(), site: site.clone() };
        let load = loads.entry((site.pairing, site.feature)).or_insert_with(nothing);
        load.impulse += impulse;
        load.site.clone_from(site);
        if let Some(time) = time {
            load.last = impulse / time;
        }
    }
    joint_impulses.iter_mut().zip(&kernel.impulses.joints).for_each(|(sum, impulse)| *sum += impulse);
}
