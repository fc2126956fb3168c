//! A step without impacts: RATTLE with contacts.
//!
//! v½ = v₀ + ½h M₀⁻¹F + M₀⁻¹J₀ᵀλ, q₁ = q₀ after free flight over h with v½, v₁ = v½ + ½h M₁⁻¹F + M₁⁻¹J₁ᵀμ.
//!
//! λ is such that places hold: joints closed at q₁, gaps g(q₁) ≥ 0, pushed only where g(q₁) = 0; μ such that velocities
//! do: J₁v₁ = 0, and where g(q₁) = 0 gaps do not close. Both within the cone of friction, against the slip of v½ and of
//! v₁. What neither bounces nor has landed is stopped where the surfaces meet. Both are the cone solver's problem: λ
//! with a linear forecast of places, b = (g − ĝ)/h mended until the forecast is true.
//!
//! Constant forces are followed exactly, sliding and rolling too; all else with an error of second order.

use nalgebra::Vector3;

use super::super::mechanism::{Link, Member, Motion, stretch};
use super::super::rattle::fly;
use super::kernel::{Kernel, View, arms_of, separation_of};
use super::sites::{Finder, Pairing, Site, Sites};
use crate::physics::body::Body;

/// Gap up to which surfaces touch, m.
pub(super) const TOUCHING: f64 = 1e-9;
/// What a forecast may be off by, m.
const FORECAST: f64 = 1e-13;
/// What one may be off by that comes no nearer, m.
const NEARLY: f64 = 1e-10;
/// Overlap at the end of a forecast from which on features that it did not hold are held, m.
const MET: f64 = 1e-7;
/// What a solve may leave, over its time, m, where it comes to an end before it holds.
const UNSOLVED: f64 = 1e-7;
/// Forecasts.
const MOST_TURNS: usize = 12;

/// What does not change in a step.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub view: View<'a>,
    pub springs: &'a [Link],
    pub pairings: &'a [Pairing],
    /// Whether the pairing's bodies fly past each other: what bounces and does not rest.
    pub flies: &'a [bool],
    /// Fastest way out of an overlap, m/s.
    pub correction_speed: f64,
    /// Time over which what is not as it should be is closed, s: a whole step, for the parts of a cut one may be short.
    pub closing: f64,
    /// Whether one forecast has to do: what is left where none comes true.
    pub is_rough: bool,
}

/// The step and its buffers.
#[derive(Default)]
pub(super) struct Flight {
    pub places: Kernel,
    pub velocities: Kernel,
    /// The sites that take part in each: of places first those at the start, in their order, then those met on the way.
    pub held: [Vec<Site>; 2],
    /// How many of places are those at the start.
    known: usize,
    /// Where it ends, and the sites there.
    pub end: Vec<Motion>,
    pub sites: Sites,
    kicked: Vec<Motion>,
    gains: Vec<f64>,
    joint_gains: Vec<Vector3<f64>>,
    /// How fast gaps open and anchors part without what bends their ways, m/s.
    openings: Vec<f64>,
    partings: Vec<Vector3<f64>>,
    /// Whether places came to be as the impulses were to make them.
    pub is_true: bool,
    /// Sliding points at the start without a rigid motion.
    pub jammed: u32,
    /// Mean forces that springs give, N, on B.
    pub spring_forces: Vec<Vector3<f64>>,
}

impl Flight {
    /// Flies from a state for h, s, to [`Self::end`]. `start_sites` are those at the start; `bodies` take the poses of
    /// the end. `guess` is the force that a site may have, N.
    pub fn fly(
        &mut self,
        given: &Given,
        start: &[Motion],
        start_sites: &Sites,
        bodies: &mut [Body],
        finder: &mut Finder,
        guess: impl Fn(&Site) -> Vector3<f64>,
        joint_guess: &[Vector3<f64>],
        h: f64,
    ) {
        self.end.clear();
        self.end.extend_from_slice(start);
        self.spring_forces.clear();
        self.kick(given, h);
        self.kicked.clone_from(&self.end);
        self.hold_places(given, start, start_sites, bodies, finder, guess, joint_guess, h);
        self.kick(given, h);
        self.hold_velocities(given);
        self.is_true &= self.velocities.residual * given.closing <= UNSOLVED;
    }

    /// Half a step of forces, springs and drag.
    fn kick(&mut self, given: &Given, h: f64) {
        for (at, link) in given.springs.iter().enumerate() {
            let force = pull(link, given.view.members, &self.end, 0.5 * h);
            match self.spring_forces.get_mut(at) {
                Some(mean) => *mean = (*mean + force) * 0.5,
                None => self.spring_forces.push(force),
            }
            let arms = arms_of(link, &self.end);
            for (end, arm, sign) in [(link.a, arms[0], -1.0), (link.b, arms[1], 1.0)] {
                let impulse = force * (sign * 0.5 * h);
                push(&given.view.members[end as usize], &mut self.end[end as usize], &impulse, &arm.cross(&impulse));
            }
        }
        for (member, motion) in given.view.members.iter().zip(&mut self.end) {
            motion.linear *= (-member.drag.0 * 0.5 * h).exp();
            motion.angular *= (-member.drag.1 * 0.5 * h).exp();
            push(member, motion, &(member.force * (0.5 * h)), &(member.torque * (0.5 * h)));
        }
    }

    fn hold_places(
        &mut self,
        given: &Given,
        start: &[Motion],
        start_sites: &Sites,
        bodies: &mut [Body],
        finder: &mut Finder,
        guess: impl Fn(&Site) -> Vector3<f64>,
        joint_guess: &[Vector3<f64>],
        h: f64,
    ) {
        let Self { places, held: [held, _], kicked, known, .. } = self;
        held.clear();
        held.extend(start_sites.list.iter().filter(|site| !given.flies[site.pairing as usize]).cloned());
        *known = held.len();
        places.set(given.view, kicked, held.iter());
        let separations: Vec<Vector3<f64>> = given.view.links.iter().map(|link| separation_of(link, start)).collect();
        self.jammed = places.jammed(held.iter().map(|site| (site, site.velocity(start))));
        places.impulses.contacts.clear();
        places.impulses.contacts.extend(held.iter().map(|site| guess(site) * (0.5 * h)));
        places.impulses.joints.clear();
        places.impulses.joints.extend(joint_guess.iter().map(|force| force * (0.5 * h)));
        // What cannot be closed, as of a chain that is stretched too far, is left as it is.
        let is_open = held.iter().any(|site| site.gap < -NEARLY) || separations.iter().any(|gap| gap.amax() > NEARLY);
        self.is_true = self.forecast(given, bodies, finder, &separations, 1.0, h)
            || is_open && !given.is_rough && self.forecast(given, bodies, finder, &separations, 0.0, h);
    }

    /// Solves for places until what the impulses are to do to them is what they do. That share of errors at the start
    /// is closed. Whether it came true.
    fn forecast(
        &mut self,
        given: &Given,
        bodies: &mut [Body],
        finder: &mut Finder,
        separations: &[Vector3<f64>],
        closed: f64,
        h: f64,
    ) -> bool {
        let Self { places, held: [held, _], known, end, sites, kicked, gains, joint_gains, openings, partings, .. } =
            self;
        let first_gain = |site: &Site| {
            if site.gap > 0.0 { site.gap / h } else { (site.gap * closed / given.closing).max(-given.correction_speed) }
        };
        gains.clear();
        gains.extend(held.iter().map(first_gain));
        joint_gains.clear();
        joint_gains.extend(separations.iter().map(|separation| separation * (closed / given.closing)));
        let mut before = f64::INFINITY;
        for _ in 0..MOST_TURNS {
            end.clone_from(kicked);
            places.solve(end, gains, joint_gains);
            if places.residual * h > UNSOLVED && !given.is_rough {
                return false;
            }
            openings.clear();
            openings.extend(held.iter().map(|site| site.opening(end)));
            partings.clear();
            partings.extend(given.view.links.iter().map(|link| stretch(link, &arms_of(link, end), end)[1]));
            for (member, motion) in given.view.members.iter().zip(&mut *end) {
                fly(member, motion, h);
            }
            place(bodies, end);
            sites.find(given.pairings, bodies, |pairing| margin(pairing, bodies), finder);
            if places.is_empty() {
                return true;
            }
            let mut worst: f64 = 0.0;
            for (((site, gain), opening), impulse) in
                held.iter().zip(&mut *gains).zip(&*openings).zip(&places.impulses.contacts)
            {
                let Some(found) = sites.position(site.pairing, site.feature) else { continue };
                let bent = sites.list[found].gap - (site.gap + opening * h);
                let mended = first_gain(site) + bent / h;
                if *impulse != Vector3::zeros() || sites.list[found].gap < -FORECAST {
                    worst = worst.max((mended - *gain).abs() * h);
                    *gain = mended;
                }
            }
            // What nobody saw coming is held from where it came from.
            let count = held.len();
            for site in &sites.list {
                if site.gap < -MET && !given.flies[site.pairing as usize] && find(held, *known, site).is_none() {
                    held.push(Site { gap: site.gap - site.opening(end) * h, ..site.clone() });
                }
            }
            if held.len() > count {
                worst = f64::INFINITY;
                places.set(given.view, kicked, held.iter());
                gains.extend(held[count..].iter().map(first_gain));
                places.impulses.contacts.resize(held.len(), Vector3::zeros());
            }
            for (index, link) in given.view.links.iter().enumerate() {
                let bent = separation_of(link, end) - (separations[index] + partings[index] * h);
                let mended = separations[index] * (closed / given.closing) + bent / h;
                worst = worst.max((mended - joint_gains[index]).amax() * h);
                joint_gains[index] = mended;
            }
            if worst <= FORECAST || worst >= 0.5 * before && worst < NEARLY {
                return true;
            }
            if worst.is_finite() && worst > 2.0 * before || worst.is_nan() {
                return false;
            }
            before = if worst.is_finite() { before.min(worst) } else { f64::INFINITY };
            if given.is_rough || places.is_spent() {
                break;
            }
        }
        before < NEARLY
    }

    fn hold_velocities(&mut self, given: &Given) {
        let Self { velocities, places, held: [before, held], known, end, sites, gains, joint_gains, .. } = self;
        held.clear();
        let is_held = |site: &&Site| !given.flies[site.pairing as usize] && site.gap <= TOUCHING;
        held.extend(sites.list.iter().filter(is_held).cloned());
        velocities.set(given.view, end, held.iter());
        gains.clear();
        gains.resize(held.len(), 0.0);
        joint_gains.clear();
        joint_gains.resize(given.view.links.len(), Vector3::zeros());
        let guess = |site: &Site| {
            find(before, *known, site).map_or_else(Vector3::zeros, |known| places.impulses.contacts[known])
        };
        velocities.impulses.contacts.clear();
        velocities.impulses.contacts.extend(held.iter().map(guess));
        velocities.impulses.joints.clone_from(&places.impulses.joints);
        velocities.solve(end, gains, joint_gains);
    }
}

/// Where the same features are held: in order of pairings among the first so many, in none after them.
fn find(held: &[Site], known: usize, site: &Site) -> Option<usize> {
    let (ordered, met) = held.split_at(known);
    let first = ordered.partition_point(|other| other.pairing < site.pairing);
    let own = ordered[first..].iter().take_while(|other| other.pairing == site.pairing);
    let is_same = |other: &Site| other.pairing == site.pairing && other.feature == site.feature;
    let among_known = own.clone().position(is_same).map(|at| first + at);
    among_known.or_else(|| met.iter().position(is_same).map(|at| known + at))
}

/// How far the ends of a flight are looked at for sites, m.
fn margin(pairing: &Pairing, bodies: &[Body]) -> f64 {
    let smaller = pairing.ends.map(|end| bodies[end as usize].radius);
    1e-2 * smaller[0].min(smaller[1])
}

/// Poses of the motion.
pub(super) fn place(bodies: &mut [Body], motion: &[Motion]) {
    for (body, motion) in bodies.iter_mut().zip(motion) {
        body.position = motion.position;
        body.rotation = motion.rotation;
    }
}

fn push(member: &Member, motion: &mut Motion, impulse: &Vector3<f64>, turning: &Vector3<f64>) {
    if !member.moves() {
        return;
    }
    motion.linear += member.inverse_mass.component_mul(impulse);
    if *turning != Vector3::zeros() {
        let rotation = motion.rotation.to_rotation_matrix().into_inner();
        motion.angular += member.inverse_inertia(&rotation, None) * turning;
    }
}

/// Mean force of a spring on its B over a kick of so long, s, in N, for the masses of its two bodies alone.
fn pull(link: &Link, members: &[Member], motion: &[Motion], time: f64) -> Vector3<f64> {
    let Some(spring) = &link.spring else { return Vector3::zeros() };
    let arms = arms_of(link, motion);
    let mut mobility = Vector3::zeros();
    for (end, arm) in [(link.a, &arms[0]), (link.b, &arms[1])] {
        let member = &members[end as usize];
        let turning = arm.cross_matrix();
        let rotation = motion[end as usize].rotation.to_rotation_matrix().into_inner();
        mobility += member.inverse_mass - (turning * member.inverse_inertia(&rotation, None) * turning).diagonal();
    }
    let [apart, speed] = stretch(link, &arms, motion);
    spring.give(&spring.ask_in_kick(&apart, &speed, time), &mobility)
}
