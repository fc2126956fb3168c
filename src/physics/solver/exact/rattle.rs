//! RATTLE (Andersen 1983): Strang's splitting into kicks by forces and free motion, with joints held exactly in place
//! and velocity; symmetric, of order 2.
//!
//! v½ = v₀ + ½h W₀(F + J₀ᵀλ) with λ such that joints hold after the free motion: C(q₁, t₁) = 0; then
//! v₁ = v½ + ½h W₁(F + J₁ᵀμ) with μ such that J₁ v₁ + ∂C/∂t = 0. λ is found by Newton's method with J₀ W₀ J₀ᵀ in place
//! of J₁ W₁ J₀ᵀ, from the λ that holds accelerations at the start: J M⁻¹ Jᵀ λ = −J M⁻¹(F − (0, ω × I ω)) − J̇ v. Bodies
//! turn freely by the midpoint rule of [`free_rotation`](crate::physics::body::free_rotation); drag takes e^{−ch/2} with each kick.

use super::constants::RATTLE_ITERATIONS;
use super::gauss::StageIterations;
use super::mechanism::{Mechanism, MemberState, RowSpring};
use super::projection::{JointErrors, JointProjection};
use super::rows::{MechanismRows, add_wrenches};
use crate::physics::constraint::row::Wrench;
use crate::physics::joint::JointRow;

/// The rows and the buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rattle {
    /// At the start of the step.
    rows: Vec<JointRow<f64>>,
    system: MechanismRows,
    projection: JointProjection,
    start: Vec<MemberState>,
    /// λ of the first kick, N·s or N·m·s.
    impulses: Vec<f64>,
    /// λ of springs alone, N or N·m.
    pulls: Vec<f64>,
    right: Vec<f64>,
    wrenches: Vec<Wrench<f64>>,
}

impl Rattle {
    /// A step of order 2, of h, s, from that time. Where joints cannot be held the mechanism stays where it was.
    pub fn step(&mut self, mechanism: &mut Mechanism, time: f64, h: f64) -> StageIterations {
        self.start.clone_from(&mechanism.states);
        self.begin(mechanism, time, h);
        let Some(count) = self.hold_places(mechanism, time + h, h) else {
            mechanism.states.clone_from(&self.start);
            return StageIterations { count: RATTLE_ITERATIONS as u32, converged: false };
        };
        self.hold_velocities(mechanism, h);
        StageIterations { count: count + 2, converged: true }
    }

    /// Mean of each link's load over the step.
    pub fn mean_load(&self, mechanism: &Mechanism, link: usize, h: f64) -> Wrench<f64> {
        let link = &mechanism.links[link];
        let impulse = link.load(&link.arm_b(&self.start), &self.rows, &self.impulses);
        Wrench::zero().plus(&impulse, 2.0 / h)
    }

    /// The λ that the iteration starts from, with those of springs.
    fn begin(&mut self, mechanism: &Mechanism, time: f64, h: f64) {
        let Self { rows, system, impulses, pulls, right, wrenches, start, .. } = self;
        mechanism.place_rows(start, time, rows);
        let turn = h * start.iter().fold(0.0, |most: f64, state| most.max(state.angular.norm_squared())).sqrt();
        system.assemble_rigid(mechanism, start, rows, turn);
        system.free_accelerations(mechanism, start, rows, pulls, wrenches);
        right.clear();
        for link in &mechanism.links {
            let [a, b] = link.ends().map(|member| &wrenches[member as usize]);
            right.extend(rows[link.rows.clone()].iter().map(|row| match row.spring {
                None => -(row.jacobian.dot(a, b) + row.velocity_term),
                Some(_) => 0.0,
            }));
        }
        system.given.iter().for_each(|&row| right[row] = 0.0);
        system.solve(mechanism, right, impulses);
        impulses.iter_mut().zip(&*pulls).for_each(|(impulse, pull)| *impulse = (*impulse + pull) * (0.5 * h));
    }

    /// The first kick and the free motion, up to that time.
    fn hold_places(&mut self, mechanism: &mut Mechanism, end: f64, h: f64) -> Option<u32> {
        let Self { rows, system, impulses, right, wrenches, start, projection, .. } = self;
        let mut before = f64::INFINITY;
        for turn in 1..=RATTLE_ITERATIONS {
            wrenches.clear();
            wrenches.resize(start.len(), Wrench::zero());
            add_wrenches(&mechanism.links, rows.iter().map(|row| &row.jacobian), impulses, wrenches);
            for (index, (state, start)) in mechanism.states.iter_mut().zip(&*start).enumerate() {
                let member = &mechanism.members[index];
                *state = *start;
                member.kick(state, &wrenches[index], &system.inverse_masses[index], 0.5 * h);
                member.move_freely(state, h);
            }
            let JointErrors { largest, rounding, .. } = projection.errors_at(mechanism, end);
            if largest <= rounding || largest >= 0.9 * before && largest < 1e-11 {
                return Some(turn as u32);
            }
            if largest.is_nan() || largest > 4.0 * before {
                break;
            }
            before = before.min(largest);
            right.clear();
            right.extend_from_slice(projection.errors());
            system.solve_once(mechanism, right);
            for ((impulse, more), row) in impulses.iter_mut().zip(&*right).zip(&*rows) {
                if row.spring.is_none() {
                    *impulse += more / h;
                }
            }
        }
        None
    }

    /// The second kick, with the rows that the first has led to.
    fn hold_velocities(&mut self, mechanism: &mut Mechanism, h: f64) {
        self.projection.factor(mechanism);
        self.projection.kick(mechanism, 0.5 * h, RowSpring::pull);
        self.projection.project_velocities(mechanism);
    }
}
