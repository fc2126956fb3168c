//! The linear equations of all stages together.
//!
//! A sweep over the stages in their order solves them with L in the place of A². It leaves h² K Σ_j (L_ij − A²_ij) δa_j of
//! the balance of forces of stage i, and nothing of its joints. Further sweeps bring that in, with the same factors: at
//! most some half of it is left by each.

use nalgebra::Vector3;

use super::super::constants::{COUPLED, COUPLING_SWEEPS};
use super::super::mechanism::Mechanism;
use super::{Gauss, GaussStage};
use crate::physics::constraint::row::Wrench;

impl<const S: usize> Gauss<S> {
    /// Continues from a first sweep whose largest change of an acceleration was `first`.
    pub(super) fn couple_stages(&mut self, mechanism: &Mechanism, h: f64, first: f64) {
        for _ in 0..COUPLING_SWEEPS {
            self.find_coupling(mechanism, h);
            let mut change: f64 = 0.0;
            for stage in 0..S {
                self.balance_coupling(mechanism, h, stage);
                change = change.max(self.correct(mechanism, stage, false));
            }
            if change <= first * COUPLED {
                return;
            }
        }
    }

    /// The torques that the last sweep left of each stage.
    fn find_coupling(&mut self, mechanism: &Mechanism, h: f64) {
        for i in 0..S {
            let mut coupling = std::mem::take(&mut self.stages[i].coupling);
            coupling.clear();
            coupling.extend((0..mechanism.moving).map(|member| {
                let left = self.combined_change(member, S, |j| self.tableau.lower[i][j] - self.tableau.squared[i][j]);
                self.stages[i].stiffness[member] * left * (h * h)
            }));
            self.stages[i].coupling = coupling;
        }
    }

    /// Those of a stage, less what this sweep has changed of the stages before it, into `wrenches`; what they do to its
    /// joints into `unknowns`.
    fn balance_coupling(&mut self, mechanism: &Mechanism, h: f64, stage: usize) {
        let mut wrenches = std::mem::take(&mut self.wrenches);
        wrenches.clear();
        wrenches.resize(mechanism.members.len(), Wrench::zero());
        let GaussStage { stiffness, coupling, system, .. } = &self.stages[stage];
        for (member, wrench) in wrenches.iter_mut().enumerate().take(mechanism.moving) {
            let before = self.combined_change(member, stage, |j| self.tableau.lower[stage][j]);
            wrench.angular = coupling[member] - stiffness[member] * before * (h * h);
        }
        self.unknowns.clear();
        for link in &mechanism.links {
            let [a, b] = link.ends().map(|member| {
                let member = member as usize;
                system.inverse_masses[member].of(&wrenches[member])
            });
            let jacobians = &system.jacobians[link.rows.clone()];
            self.unknowns.extend(jacobians.iter().map(|jacobian| -jacobian.dot(&a, &b)));
        }
        self.wrenches = wrenches;
    }

    /// Σ of so many stages' last changes of a member's angular acceleration, each by its share.
    fn combined_change(&self, member: usize, stages: usize, share: impl Fn(usize) -> f64) -> Vector3<f64> {
        let changes = self.stages[..stages].iter().map(|stage| stage.changes[member].angular);
        changes.enumerate().fold(Vector3::zeros(), |sum, (j, change)| sum + change * share(j))
    }
}
