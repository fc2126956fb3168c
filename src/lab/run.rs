//! Running a plan without a window and measuring what it does.

use bevy::prelude::World;

use super::metrics::{Meter, Metrics};
use super::plan::Plan;
use super::simulation::{Sample, Simulation};
use super::truth;

/// Runs a plan and measures it. `watch` sees the state at the start and after each step and
/// ends the run with its first error.
///
/// # Errors
/// Those of `watch`.
pub fn measure<E>(plan: &Plan, mut watch: impl FnMut(&Sample) -> Result<(), E>) -> Result<Metrics, E> {
    measure_world(plan, |_| {}, |simulation| watch(&simulation.sample()))
}

/// The same; `begin` sees the world before the first step, `watch` all of it.
pub(super) fn measure_world<E>(
    plan: &Plan,
    begin: impl FnOnce(&mut World),
    mut watch: impl FnMut(&Simulation) -> Result<(), E>,
) -> Result<Metrics, E> {
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    begin(simulation.world_mut());
    let known = plan.built_in.then(|| truth::of(&plan.scene, &plan.settings)).flatten();
    let truth = known
        .map(Ok)
        .or_else(|| plan.converge.then(|| truth::converged(&plan.scene, plan.steps as f64 / plan.settings.hz)));
    let mut meter = Meter::new(plan, &mut simulation, truth);
    watch(&simulation)?;
    for _ in 0..plan.steps {
        simulation.step();
        meter.observe(&simulation);
        watch(&simulation)?;
    }
    Ok(meter.finish(plan, &simulation))
}
