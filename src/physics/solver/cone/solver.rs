//! The methods of the module's docs, one after the other.

use nalgebra::{Matrix3, Vector3};

use super::constants::{ENOUGH_RESIDUAL, FEW_POINTS, FIRST_SOFTNESS, LATE_SWEEPS, SHARE_OF_FEW, WEDGED};
use super::newton::NewtonBuffers;
use super::{
    ConeBody, ConeContact, ConeEnd, ConeJoint, ConeOutcome, ConePoint, Deadline, Elimination, Iterate, PerPoint,
    Velocity, root,
};
use crate::physics::{Refill, Residuals};

/// Solves one island's points. Keeps its buffers and, as long as the same bodies touch, its structure.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConeSolver {
    iterate: Iterate,
    /// The pairs of bodies that the order of elimination is for, ascending,
    edges: Vec<[u32; 2]>,
    /// and those that the points at hand couple.
    coupled: Vec<[u32; 2]>,
    buffers: NewtonBuffers,
}

impl ConeSolver {
    /// Sets bodies and points. Indices of bodies are into `bodies`; the structure is made anew only where their pairs
    /// are others than before.
    pub fn set(&mut self, bodies: &[ConeBody], contacts: &[ConeContact], joints: &[ConeJoint]) {
        let Self { edges, coupled, iterate: Iterate { points, elimination, roots, .. }, .. } = self;
        roots.refill(
            bodies
                .iter()
                .map(|body| [Matrix3::from_diagonal(&body.inverse_mass.map(f64::sqrt)), root(&body.inverse_inertia)]),
        );
        points.refill(contacts.iter().map(|contact| ConePoint::of_contact(contact, roots)));
        points.extend(joints.iter().map(|joint| ConePoint::of_joint(joint, roots)));
        // Whatever the order of the points, and however many a pair has.
        coupled.refill(points.iter().filter_map(ConePoint::edge).map(|[a, b]| [a.min(b), a.max(b)]));
        coupled.dedup();
        coupled.sort_unstable();
        coupled.dedup();
        if elimination.count() != bodies.len() || coupled != edges {
            std::mem::swap(edges, coupled);
            let found = Elimination::new(&vec![6; bodies.len()], edges.iter().copied(), usize::MAX);
            *elimination = found.expect("no bound on the work");
        }
        for point in points {
            point.locate(elimination);
        }
    }

    /// Solves for impulses that bring every point within `tolerance` m/s of its law, relative to the fastest point of
    /// v_free where that is faster than 1 m/s (of few points: than 100 m/s), or within `enough` m/s.
    ///
    /// `velocities` are v_free, one a body, and v on return. `bias` is b, m/s: the motion of an immovable side (its
    /// point's velocity times +1 at B, −1 at A), and along n what the contact is to gain (a contact that may close a
    /// gap g within the step h has +g/h, one that is to bounce −e times its approach). `impulses` (N·s, on B) are the
    /// guess, and the solution on return; zeros if there is none.
    pub fn solve(
        &mut self,
        velocities: &mut [Velocity],
        bias: &PerPoint,
        impulses: &mut PerPoint,
        tolerance: f64,
        enough: f64,
    ) -> ConeOutcome {
        let iterate = &mut self.iterate;
        iterate.free.clear();
        iterate.impulses.clear();
        let biases = bias.contacts.iter().chain(&bias.joints);
        let guesses = impulses.contacts.iter().chain(&impulses.joints);
        let mut fastest: f64 = 0.0;
        for ((point, bias), guess) in iterate.points.iter().zip(biases).zip(guesses) {
            let velocity = point.velocity(velocities);
            fastest = fastest.max(velocity.norm_squared());
            iterate.free.push(point.law.relevant(&point.frame.tr_mul(&(bias + velocity))));
            let guess = point.law.project(&point.frame.tr_mul(guess));
            iterate.impulses.push(if point.is_movable() { guess } else { Vector3::zeros() });
        }
        let share = if iterate.points.len() <= FEW_POINTS { SHARE_OF_FEW } else { 1.0 };
        iterate.tolerance = enough.max(tolerance * (share * fastest.sqrt()).max(1.0));
        self.run();
        let iterate = &self.iterate;
        let results = impulses.contacts.iter_mut().chain(&mut impulses.joints);
        for ((point, impulse), result) in iterate.points.iter().zip(&iterate.impulses).zip(results) {
            *result = point.frame * impulse;
        }
        for (body, (velocity, [linear, angular])) in velocities.iter_mut().zip(&iterate.roots).enumerate() {
            let scaled = &iterate.scaled[iterate.elimination.place(body as u32) as usize];
            velocity[0] += linear * scaled.fixed_rows::<3>(0);
            velocity[1] += angular * scaled.fixed_rows::<3>(3);
        }
        iterate.outcome
    }

    /// Has the next solve end by then, but not before so many iterations.
    pub fn end_by(&mut self, deadline: Deadline, least: u32) {
        (self.iterate.deadline, self.iterate.least) = (deadline, least);
    }

    /// Has the residual of each iteration noted from here on, or not.
    pub fn trace(&mut self, traces: bool) {
        self.iterate.trace = traces.then(Residuals::default);
    }

    /// Those noted since, if any are.
    pub fn residuals(&self) -> Option<&Residuals> {
        self.iterate.trace.as_ref()
    }

    /// The methods of the module's docs, in their order, until one does it.
    fn run(&mut self) {
        let Self { iterate, buffers, .. } = self;
        iterate.outcome = ConeOutcome { tolerance: iterate.tolerance, ..ConeOutcome::default() };
        if let Some(trace) = &mut iterate.trace {
            trace.begin_solve();
        }
        iterate.refresh();
        iterate.best.clone_from(&iterate.impulses);
        iterate.outcome.residual = f64::INFINITY;
        let is_guessed = iterate.impulses.iter().any(|impulse| *impulse != Vector3::zeros());
        let mut done = iterate.note().largest <= iterate.tolerance || iterate.proximal_points(buffers, is_guessed);
        if !done && iterate.outcome.residual > WEDGED && iterate.outcome.end == ConeEnd::Bounded && iterate.may_wedge()
        {
            iterate.wedge(FIRST_SOFTNESS);
            done = iterate.note().largest <= iterate.tolerance || iterate.proximal_points(buffers, false);
        }
        if !done {
            // A guess may be worse than none.
            iterate.impulses.fill(Vector3::zeros());
            iterate.refresh();
            iterate.note();
            iterate.impulses.clone_from(&iterate.best);
            iterate.refresh();
            if iterate.outcome.end == ConeEnd::Late {
                // A Newton iteration on its way may be anywhere.
                iterate.sweep(LATE_SWEEPS);
            }
            iterate.outcome.residual = iterate.residual().largest;
        }
        if iterate.outcome.residual <= iterate.tolerance {
            iterate.outcome.end = ConeEnd::Converged;
        } else if iterate.outcome.residual <= iterate.rounding() {
            iterate.outcome.end = ConeEnd::Rounding;
        } else if iterate.outcome.residual <= ENOUGH_RESIDUAL {
            iterate.outcome.end = ConeEnd::Enough;
        }
    }
}
