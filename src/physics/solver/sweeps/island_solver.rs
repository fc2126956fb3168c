//! One group of islands taken through a step: gather, substeps, scatter.

use bevy::platform::collections::HashMap;
use nalgebra::Vector3;

use super::integrator;
use super::local::{LocalBody, LocalJoint, LocalManifold, LocalPoint};
use super::rows::{body_terms, contact_rows, joint_rows};
use super::step_terms::StepTerms;
use super::sweep_trace::SweepTrace;
use super::{cg_pgs, joint_space, nncg, pgs, projection};
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, Contacts, FeatureId, PairKey};
use crate::physics::constraint::row::{BodyTerms, Row, RowPair, Twist, Wrench};
use crate::physics::contact::KEPT_SHARE;
use crate::physics::island::Islands;
use crate::physics::joint::{Joint, JointRow, Joints};
use crate::physics::scalar::Scalar;
use crate::physics::settings::{Integrator, Method, Precision};
use crate::physics::solve_trace::Residuals;

#[derive(Clone, Default)]
struct Workspace<N> {
    terms: Vec<BodyTerms<N>>,
    rows: Vec<Row<N>>,
    accelerations: Vec<Twist<N>>,
    primer: cg_pgs::Primer<N>,
    directions: nncg::Directions<N>,
    joint_space: joint_space::JointSpace<N>,
}

impl<N: Scalar> Workspace<N> {
    /// Solves the rows by the method; `note` is told the accelerations after each sweep. Returns the passes over them.
    fn solve(&mut self, method: Method, iterations: u32, note: impl FnMut(&[Twist<N>])) -> u32 {
        let Self { rows, accelerations, primer, directions, joint_space, .. } = self;
        match method {
            Method::PrimedGaussSeidel => cg_pgs::solve(rows, accelerations, iterations, primer, note),
            Method::JointSpace => joint_space::solve(rows, accelerations, iterations, joint_space, note),
            Method::NonsmoothConjugateGradient => nncg::solve(rows, accelerations, iterations, directions, note),
            _ => {
                pgs::solve(rows, accelerations, iterations, note);
                iterations
            }
        }
    }
}

/// A group of islands and the buffers to solve it, kept from step to step.
#[derive(Clone, Default)]
pub(crate) struct IslandSolver {
    group: usize,
    bodies: Vec<LocalBody>,
    /// The first so many bodies are the group's own; those after belong to others or to nobody.
    own: usize,
    manifolds: Vec<LocalManifold>,
    points: Vec<LocalPoint>,
    joints: Vec<LocalJoint>,
    joint_rows: Vec<JointRow<f64>>,
    guests: HashMap<u32, u32>,
    single: Workspace<f32>,
    double: Workspace<f64>,
    /// Rows of the last solve, and their updates in the step.
    pub row_count: u32,
    pub row_updates: u64,
    /// Of the step, while somebody reads them.
    pub residuals: Residuals,
    h_total: f64,
}

impl IslandSolver {
    pub fn begin(&mut self, group: usize) {
        self.group = group;
    }

    /// Copies the group's bodies and constraints.
    pub fn gather(
        &mut self,
        islands: &Islands,
        bodies: &Bodies,
        joints: &Joints,
        contacts: &Contacts,
        graph: &ContactGraph,
    ) {
        let group = self.group;
        self.bodies.clear();
        self.bodies.extend(islands.bodies(group).iter().map(|&body| LocalBody::new(body, &bodies.list[body as usize])));
        self.own = self.bodies.len();
        self.guests.clear();
        self.manifolds.clear();
        self.points.clear();
        self.joints.clear();
        for &index in islands.manifolds(group) {
            let manifold = &contacts.manifolds[index as usize];
            let a = self.local(manifold.pair.a, islands, bodies);
            let b = self.local(manifold.pair.b, islands, bodies);
            let first_point = self.points.len();
            let [body_a, body_b] = [a, b].map(|body| &self.bodies[body as usize].body);
            for found in contacts.points_of(manifold) {
                let arm_a = found.point - body_a.position;
                let arm_b = found.point - body_b.position;
                self.points.push(LocalPoint {
                    arm_a,
                    arm_b,
                    depth: found.depth,
                    found_depth: found.depth,
                    body_arm_a: body_a.rotation.inverse() * arm_a,
                    body_arm_b: body_b.rotation.inverse() * arm_b,
                    found_offset: body_b.position - body_a.position + arm_b - arm_a,
                    first_row: 0,
                    force: graph.force(manifold.key(), found.feature),
                    impulse: Vector3::zeros(),
                });
            }
            let points = first_point..self.points.len();
            self.manifolds.push(LocalManifold { place: index, a, b, found: manifold.clone(), points });
        }
        for &index in islands.joints(group) {
            let joint = &joints.list[index as usize];
            let a = self.local(joint.a, islands, bodies);
            let b = self.local(joint.b, islands, bodies);
            let [arm_b, impulse, turn] = [Vector3::zeros(); 3];
            let definition = joint.definition.clone();
            let multipliers = [0.0; 6];
            self.joints.push(LocalJoint {
                global: index,
                a,
                b,
                definition,
                rows: 0..0,
                arm_b,
                impulse,
                turn,
                multipliers,
            });
        }
    }

    /// The local index of a body; one that does not move in this group is copied in as a guest.
    fn local(&mut self, body: u32, islands: &Islands, bodies: &Bodies) -> u32 {
        if let Some(local) = islands.local_of(body, self.group) {
            return local;
        }
        *self.guests.entry(body).or_insert_with(|| {
            self.bodies.push(LocalBody::new(body, &bodies.list[body as usize]));
            self.bodies.len() as u32 - 1
        })
    }

    /// All substeps.
    pub fn step(&mut self, terms: &StepTerms) {
        self.row_updates = 0;
        self.row_count = 0;
        self.residuals.clear();
        self.h_total = terms.h * f64::from(terms.settings.substeps);
        match terms.settings.precision {
            Precision::F32 => {
                let mut work = std::mem::take(&mut self.single);
                self.substeps(terms, &mut work);
                self.single = work;
            }
            Precision::F64 => {
                let mut work = std::mem::take(&mut self.double);
                self.substeps(terms, &mut work);
                self.double = work;
            }
        }
    }

    fn substeps<N: Scalar>(&mut self, terms: &StepTerms, work: &mut Workspace<N>) {
        for index in 0..terms.settings.substeps {
            if index > 0 {
                self.move_points();
            }
            let time = terms.start + f64::from(index) * terms.h;
            let mut island = IslandInStep { solver: self, work, terms, time };
            match terms.settings.sweeps.integrator {
                Integrator::VelocityVerlet => integrator::verlet(&mut island, terms.h),
                Integrator::Euler => integrator::euler(&mut island, terms.h),
            }
        }
    }

    /// Brings depths to the present poses. Normal and arms stay those of the step: the point of a
    /// rolling body that touched is left behind by the place where it touches, and a force on it
    /// there would drive the body on (a ball at 0.3 m/s had twice its speed after 5 s).
    fn move_points(&mut self) {
        for manifold in &self.manifolds {
            let ends = [manifold.a, manifold.b].map(|body| &self.bodies[body as usize].body);
            for point in &mut self.points[manifold.points.clone()] {
                point.depth = point.depth_between(ends, &manifold.found.normal);
            }
        }
    }

    /// Builds rows from the present poses at a time, s, and solves them for forces that act over `h`.
    fn solve<N: Scalar>(&mut self, terms: &StepTerms, work: &mut Workspace<N>, time: f64, h: f64) {
        work.rows.clear();
        work.accelerations.clear();
        work.accelerations.resize(self.bodies.len(), Twist::zero());
        if self.manifolds.is_empty() && self.joints.is_empty() {
            return;
        }
        body_terms(&self.bodies, h, &mut work.terms);
        for manifold in &self.manifolds {
            let points = &mut self.points[manifold.points.clone()];
            contact_rows(&self.bodies, &work.terms, manifold, points, terms, h, &mut work.rows);
        }
        let joints_from = work.rows.len();
        for joint in &mut self.joints {
            joint_rows(&self.bodies, &work.terms, joint, terms, [time, h], &mut self.joint_rows, &mut work.rows);
        }
        if terms.settings.sweeps.warm_starting {
            self.warm_start(&mut work.rows[..joints_from], &mut work.accelerations);
        }
        let own = &self.bodies[..self.own];
        let mut trace = terms.traces.then(|| SweepTrace::begin(own, &work.accelerations, h, &mut self.residuals));
        let passes = work.solve(terms.settings.method, terms.settings.iterations, |accelerations| {
            if let Some(trace) = &mut trace {
                trace.note(accelerations);
            }
        });
        self.row_count = work.rows.len() as u32;
        self.row_updates += u64::from(self.row_count) * u64::from(passes);
        self.keep_forces(&work.rows, joints_from, h, terms);
    }

    /// Starts each contact row from most of the force that its point carried.
    fn warm_start<N: Scalar>(&self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) {
        let mut end = rows.len();
        for point in self.points.iter().rev() {
            for row in &mut rows[point.first_row..end] {
                row.lambda = N::of(KEPT_SHARE * point.force.dot(&row.jacobian.linear_b.map(Scalar::to_f64)));
            }
            rows[point.first_row].lambda = rows[point.first_row].lambda.simd_max(N::zero());
            end = point.first_row;
        }
        for row in rows {
            pgs::add_response(row, row.lambda, accelerations);
        }
    }

    /// Keeps the forces found, which act over `h`, with their joints and, where somebody wants
    /// them, with their contact points.
    fn keep_forces<N: Scalar>(&mut self, rows: &[Row<N>], joints_from: usize, h: f64, terms: &StepTerms) {
        for joint in &mut self.joints {
            let arm = joint.arm_b.map(N::of);
            for (row, multiplier) in rows[joint.rows.clone()].iter().zip(&mut joint.multipliers) {
                *multiplier = row.lambda.to_f64();
                let RowPair { linear_b, angular_b, .. } = row.jacobian;
                let impulse = row.lambda.to_f64() * h;
                joint.impulse += linear_b.map(Scalar::to_f64) * impulse;
                joint.turn += (angular_b - arm.cross(&linear_b)).map(Scalar::to_f64) * impulse;
            }
        }
        if !terms.settings.sweeps.warm_starting && !terms.record_forces {
            return;
        }
        let mut end = joints_from;
        for point in self.points.iter_mut().rev() {
            point.force = rows[point.first_row..end]
                .iter()
                .map(|row| row.jacobian.linear_b.map(Scalar::to_f64) * row.lambda.to_f64())
                .sum();
            point.impulse += point.force * h;
            end = point.first_row;
        }
    }

    /// The bodies that it moves, and how often their rows were solved in the step.
    pub fn solves(&self) -> (impl Iterator<Item = u32>, f64) {
        let times = self.row_updates as f64 / f64::from(self.row_count.max(1));
        (self.bodies[..self.own].iter().map(|local| local.global), times)
    }

    /// The forces of the last substep on each pair's points.
    pub fn forces<'c>(
        &'c self,
        contacts: &'c Contacts,
    ) -> impl Iterator<Item = (PairKey, impl Iterator<Item = (FeatureId, Vector3<f64>)>)> {
        self.manifolds.iter().map(|LocalManifold { found, points, .. }| {
            let features = contacts.points_of(found).iter().map(|point| point.feature);
            (found.key(), features.zip(self.points[points.clone()].iter().map(|point| point.force)))
        })
    }

    fn kick<N: Scalar>(&mut self, work: &Workspace<N>, h: f64) {
        for (body, constraint) in self.bodies.iter_mut().zip(&work.accelerations) {
            let constraint = Twist {
                linear: constraint.linear.map(Scalar::to_f64),
                angular: constraint.angular.map(Scalar::to_f64),
            };
            integrator::kick(body, &constraint, h);
        }
    }

    fn drift(&mut self, h: f64) {
        for body in &mut self.bodies {
            integrator::drift(body, h);
        }
    }

    /// Moves the poses, at a time, s, out of their errors.
    fn project(&mut self, terms: &StepTerms, time: f64) {
        let Self { bodies, manifolds, points, joints, joint_rows, .. } = self;
        self.row_updates += projection::project(bodies, (manifolds, points), joints, terms, time, joint_rows);
    }

    /// Writes the group's own bodies and joint forces back.
    pub fn scatter(&self, bodies: &mut [Body], joints: &mut [Joint]) {
        for local in &self.bodies[..self.own] {
            let (from, to) = (&local.body, &mut bodies[local.global as usize]);
            (to.position, to.rotation, to.linear, to.angular) =
                (from.position, from.rotation, from.linear, from.angular);
        }
        for joint in &self.joints {
            let (linear, angular) = (joint.impulse / self.h_total, joint.turn / self.h_total);
            joints[joint.global as usize].set_load(&Wrench { linear, angular }, joint.multipliers);
        }
    }

    /// The force on B at each contact point, as (manifold, point within it, its mean over the step
    /// and that of the last solve in N).
    pub fn contact_forces(&self) -> impl Iterator<Item = (u32, usize, [Vector3<f64>; 2])> + '_ {
        self.manifolds.iter().flat_map(move |manifold| {
            let points = self.points[manifold.points.clone()].iter().enumerate();
            points.map(move |(index, point)| (manifold.place, index, [point.impulse / self.h_total, point.force]))
        })
    }
}

/// An island within one substep, as an integrator drives it.
struct IslandInStep<'a, N> {
    solver: &'a mut IslandSolver,
    work: &'a mut Workspace<N>,
    terms: &'a StepTerms<'a>,
    /// Of the present poses, s.
    time: f64,
}

impl<N: Scalar> integrator::System for IslandInStep<'_, N> {
    fn solve(&mut self, h: f64) {
        self.solver.solve(self.terms, self.work, self.time, h);
    }

    fn kick(&mut self, h: f64) {
        self.solver.kick(self.work, h);
    }

    fn drift(&mut self, h: f64) {
        self.solver.drift(h);
        self.time += h;
        if self.terms.settings.sweeps.nonlinear_projection {
            self.solver.project(self.terms, self.time);
        }
    }

    fn move_contacts(&mut self) {
        self.solver.move_points();
    }
}
