//! Contact exactly: impulses λ that obey Signorini's condition, Coulomb's cone and the joints of one island to
//! rounding, not to a number of iterations. No components here: bodies, points and numbers.
//!
//! # The problem
//! v = v_free + M⁻¹Jᵀλ, u = J v + b at each point; joints: u = 0; contacts: K* ∋ u + μ|u_t| n ⊥ λ ∈ K ([`law`]). This
//! is Coulomb's law itself, not the associated one that a quadratic program gives, whose sliding bodies take off at the
//! angle atan μ.
//!
//! # Unknowns
//! With L Lᵀ = M⁻¹ by body, Ĵ = J L and z = Ĵᵀλ: v = v_free + L z, u = Ĵ z + c, c = J v_free + b. Locked axes are zero
//! columns of L, mass ratios stay out of the scale, and every linear system is (1 + ĴᵀD Ĵ) x = r with one 3×3 block D a
//! point: sparse as the graph of the bodies, however many points two of them share ([`linear`]). z is summed anew from
//! λ at each step, so that the residual reported is that of λ alone.
//!
//! # The way to λ
//! 1. Semismooth Newton steps on the natural map ([`newton`]): from the last step's λ, two or three do (Alart &
//!    Curnier 1991; the map as in Acary, Brémond & Huber 2018).
//! 2. If they do not: proximal points ([`proximal`]). A compliance ε/ρ is given to each point about its present λ: the
//!    problem of the compliant points is well conditioned and unique, redundant points or not; Newton's method finds
//!    its λ, from which the next starts, with less compliance (Le Lidec, Montaut & Carpentier 2024 take the same way
//!    with ADMM).
//! 3. From no guess, or if that stalls: an interior point ([`interior`]), which tells touching from parting points in
//!    twenty or so steps whatever the size (as Acary, Armand, Nguyen & Shpakovych 2023), then 1 and 2.
//!
//! All are bounded. What is best when the bounds are met is what is returned, with its residual.

mod interior;
mod law;
mod linear;
mod newton;
mod point;
mod proximal;
mod second_order_cone;

#[cfg(test)]
pub(crate) mod problems;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

use super::linear::{BodyVector as Part, Elimination};
use linear::LinearSystem;
use point::{Point, root};

/// A body that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeBody {
    /// Along the world's axes, 1/kg; zero along those it cannot move along.
    pub inverse_mass: Vector3<f64>,
    /// About the centre of mass, in the world's axes, 1/(kg m²); positive semi-definite.
    pub inverse_inertia: Matrix3<f64>,
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeContact {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// From the centres of mass of A and B to the point, m; an immovable side's is not read.
    pub arms: [Vector3<f64>; 2],
    /// n: unit, from A to B.
    pub normal: Vector3<f64>,
    /// μ ≥ 0; at 0 the contact has one unknown.
    pub friction: f64,
}

/// A ball joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeJoint {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// From the centres of mass of A and B to the joint, m; an immovable side's is not read.
    pub arms: [Vector3<f64>; 2],
}

/// Linear, m/s, and angular, rad/s.
pub(crate) type Motion = [Vector3<f64>; 2];

/// What is known at contacts and at joints: a bias or an impulse of each, in the world's axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PerPoint {
    pub contacts: Vec<Vector3<f64>>,
    pub joints: Vec<Vector3<f64>>,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The residual is within the tolerance.
    Converged,
    /// The residual is what rounding of impulses as large as these makes of it: |λ|/ρ is some 10⁵ m/s or more.
    Rounding,
    /// The bounds are met; the residual is what was reached.
    Bounded,
    /// The impulses grow without an effect on the motion: most likely no motion obeys all points.
    NoRigidSolution,
}

/// What a solve reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outcome {
    pub end: End,
    /// Largest |r| of a point, the natural map's at contacts and |u| at joints, m/s.
    pub residual: f64,
    /// Factorisations: Newton steps of all kinds.
    pub steps: u32,
    /// Of these, those of the interior point.
    pub interior: u32,
    /// Proximal points.
    pub stages: u32,
}

/// Solves one island's points. Keeps its buffers and, as long as the same bodies touch, its structure.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConeSolver {
    /// Contacts, then joints.
    points: Vec<Point>,
    contacts: usize,
    elimination: Elimination,
    edges: Vec<[u32; 2]>,
    /// L of each body, linear and angular.
    roots: Vec<[Matrix3<f64>; 2]>,
    linear: LinearSystem,
    /// c, in the frame of each point, as are the next four.
    free: Vec<Vector3<f64>>,
    /// λ.
    impulses: Vec<Vector3<f64>>,
    /// u.
    velocities: Vec<Vector3<f64>>,
    /// λ to go back to.
    kept: Vec<Vector3<f64>>,
    /// λ of the least residual so far.
    best: Vec<Vector3<f64>>,
    /// z, by place in the order of elimination.
    motion: Vec<Part>,
    proximal: proximal::Buffers,
    interior: interior::Buffers,
}

/// Largest and root of the sum of squares of |r|, m/s; infinite where a number is not.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Residual {
    largest: f64,
    norm: f64,
}

/// Most proximal points from a guess before the interior point is asked, and after it.
const STAGES: [u32; 2] = [12, 100];
/// Compliance the proximal points begin with, as a share of 1/ρ.
const FIRST_SOFTNESS: f64 = 0.1;
/// A residual of so many roundings of the largest |λ|/ρ may be nothing else.
const ROUNDINGS: f64 = 16.0;

impl ConeSolver {
    /// Sets bodies and points. Indices of bodies are into `bodies`; the structure is made anew only where their pairs
    /// are others than before.
    pub fn set(&mut self, bodies: &[ConeBody], contacts: &[ConeContact], joints: &[ConeJoint]) {
        let Self { points, elimination, edges, roots, .. } = self;
        roots.clear();
        roots.extend(
            bodies
                .iter()
                .map(|body| [Matrix3::from_diagonal(&body.inverse_mass.map(f64::sqrt)), root(&body.inverse_inertia)]),
        );
        self.contacts = contacts.len();
        points.clear();
        points.extend(contacts.iter().map(|contact| Point::of_contact(contact, roots)));
        points.extend(joints.iter().map(|joint| Point::of_joint(joint, roots)));
        if elimination.count() != bodies.len() || !points.iter().filter_map(Point::edge).eq(edges.iter().copied()) {
            edges.clear();
            edges.extend(points.iter().filter_map(Point::edge));
            let most = usize::MAX;
            *elimination = Elimination::new(&vec![6; bodies.len()], edges.iter().copied(), most)
                .expect("a pattern without a bound");
        }
        for point in points {
            point.place(elimination);
        }
    }

    /// Solves for impulses that bring every point within `tolerance` m/s of its law, relative to the fastest point
    /// where that is faster than 1 m/s.
    ///
    /// `velocities` are v_free, one a body, and v on return. `bias` is b, m/s: the motion of an immovable side (its
    /// point's velocity times +1 at B, −1 at A), and along n what the contact is to gain (a contact that may close a
    /// gap g within the step h has +g/h, one that is to bounce −e times its approach). `impulses` (N·s, on B) are the
    /// guess, and the solution on return; zeros if there is none.
    pub fn solve(
        &mut self,
        velocities: &mut [Motion],
        bias: &PerPoint,
        impulses: &mut PerPoint,
        tolerance: f64,
    ) -> Outcome {
        self.free.clear();
        self.impulses.clear();
        let biases = bias.contacts.iter().chain(&bias.joints);
        let guesses = impulses.contacts.iter().chain(&impulses.joints);
        for ((point, bias), guess) in self.points.iter().zip(biases).zip(guesses) {
            self.free.push(point.law.relevant(&point.frame.tr_mul(&(bias + point.velocity(velocities)))));
            self.impulses.push(point.allowed(&point.frame.tr_mul(guess)));
        }
        let fastest = self.free.iter().map(Vector3::norm_squared).fold(1.0, f64::max).sqrt();
        let outcome = self.iterate(tolerance * fastest);
        let results = impulses.contacts.iter_mut().chain(&mut impulses.joints);
        for ((point, impulse), result) in self.points.iter().zip(&self.impulses).zip(results) {
            *result = point.frame * impulse;
        }
        for (body, (velocity, [linear, angular])) in velocities.iter_mut().zip(&self.roots).enumerate() {
            let part = &self.motion[self.elimination.place(body as u32) as usize];
            velocity[0] += linear * part.fixed_rows::<3>(0);
            velocity[1] += angular * part.fixed_rows::<3>(3);
        }
        outcome
    }

    /// The steps of the module's docs, in their order, until one does it.
    fn iterate(&mut self, tolerance: f64) -> Outcome {
        let mut outcome = Outcome { end: End::Bounded, residual: f64::INFINITY, steps: 0, interior: 0, stages: 0 };
        let is_guessed = self.impulses.iter().any(|impulse| *impulse != Vector3::zeros());
        self.refresh();
        self.best.clone_from(&self.impulses);
        outcome.residual = self.residual().largest;
        let has_contacts = self.contacts > 0;
        let done = self.polish(tolerance, &mut outcome)
            || (is_guessed && self.approach(FIRST_SOFTNESS, STAGES[0], tolerance, &mut outcome))
            || (has_contacts && self.walk_inside(tolerance, &mut outcome))
            || self.approach(FIRST_SOFTNESS, STAGES[1], tolerance, &mut outcome);
        if !done {
            // A guess may be worse than none.
            self.impulses.fill(Vector3::zeros());
            self.refresh();
            let none = self.residual();
            self.note(none, &mut outcome);
            self.impulses.clone_from(&self.best);
            self.refresh();
            outcome.residual = self.residual().largest;
        }
        if outcome.residual <= tolerance {
            outcome.end = End::Converged;
        } else if outcome.residual <= self.rounding() {
            outcome.end = End::Rounding;
        }
        outcome
    }

    /// z = Ĵᵀλ, then u = Ĵ z + c.
    fn refresh(&mut self) {
        self.motion.clear();
        self.motion.resize(self.elimination.count(), Part::zeros());
        for (point, impulse) in self.points.iter().zip(&self.impulses) {
            point.push(&mut self.motion, impulse);
        }
        self.velocities.clear();
        self.velocities
            .extend(self.points.iter().zip(&self.free).map(|(point, free)| free + point.across(&self.motion)));
    }

    /// How far λ and u are from the laws.
    fn residual(&self) -> Residual {
        let (mut largest, mut sum) = (0.0, 0.0);
        for ((point, impulse), velocity) in self.points.iter().zip(&self.impulses).zip(&self.velocities) {
            if point.is_movable() {
                let square = point.law.natural_map(impulse, velocity, point.mass).norm_squared();
                largest = f64::max(largest, square);
                sum += square;
            }
        }
        if f64::is_finite(sum) {
            Residual { largest: largest.sqrt(), norm: sum.sqrt() }
        } else {
            Residual { largest: f64::INFINITY, norm: f64::INFINITY }
        }
    }

    /// Notes λ if it is the best so far.
    fn note(&mut self, residual: Residual, outcome: &mut Outcome) {
        if residual.largest < outcome.residual {
            outcome.residual = residual.largest;
            self.best.clone_from(&self.impulses);
        }
    }

    /// What rounding makes of a residual, m/s.
    fn rounding(&self) -> f64 {
        let movable = self.points.iter().zip(&self.impulses).filter(|(point, _)| point.is_movable());
        ROUNDINGS * f64::EPSILON * movable.map(|(point, impulse)| impulse.norm() / point.mass).fold(0.0, f64::max)
    }

    /// Whether λ says that no motion obeys the points: with λ ∈ K, λ·û ≥ 0 for all û ∈ K*, so that −λ·c ≤ z·Ĵᵀλ + Σ
    /// μ|u_t| λ_n for the z sought; impulses that press (λ·c < 0) and yet move nothing (Ĵᵀλ ≈ 0) leave none (Farkas).
    fn is_jammed(&self) -> bool {
        let mut pressing = 0.0;
        for (((point, impulse), free), velocity) in
            self.points.iter().zip(&self.impulses).zip(&self.free).zip(&self.velocities)
        {
            pressing -= impulse.dot(free) + point.law.shift(velocity) * impulse.x;
        }
        pressing > 1e4 * self.motion.iter().map(Part::norm_squared).sum::<f64>()
    }
}
