//! A scene far from the origin does what it does at the origin: the same scene there, with the
//! same settings, is stepped beside it.

use crate::physics::SolverSettings;
use crate::scene::{self, SceneSpec};

use super::answer::{ROUNDING, Truth};
use super::bodies::{collider, dynamic, largest_displacement};
use crate::lab::simulation::{Sample, Simulation};

/// What a run may differ from the one at the origin, m.
const FAILS_ABOVE: f64 = 1e-5;

pub(super) fn truth(scene: &SceneSpec, settings: &SolverSettings) -> Option<Truth> {
    let near = scene::load(&scene.name, &[("d".to_owned(), 0.0)]).ok()?;
    let offsets: Vec<_> = dynamic(scene)
        .into_iter()
        .map(|index| {
            let offset = scene.bodies[index].position - near.bodies[index].position;
            (index, offset, collider(&scene.bodies[index]))
        })
        .collect();
    let distance = offsets.first()?.1.length();
    if distance == 0.0 {
        return None;
    }
    let mut twin = Simulation::new(near, *settings);
    let differs = move |sample: &Sample| {
        while twin.sample().step < sample.step {
            twin.step();
        }
        let near = twin.sample().bodies;
        let differences = offsets.iter().map(|(index, offset, shape)| {
            let (index, offset) = (*index, *offset);
            // Of like size first: their difference is exact.
            let apart = sample.bodies[index].position - offset - near[index].position;
            let rotations = [near[index].rotation, sample.bodies[index].rotation];
            largest_displacement(shape.as_ref(), apart, rotations)
        });
        Some(differences.fold(0.0, f64::max))
    };
    // A position there is known to half a bit of the distance, and so is what it is compared with.
    let uncertainty = ROUNDING.max(f64::EPSILON * distance);
    let truth = Truth::largest("difference from the scene at the origin", "m", differs);
    Some(truth.with_uncertainty(uncertainty).failing_above(FAILS_ABOVE))
}
