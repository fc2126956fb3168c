//! What probes read that is measured only for whoever reads it.

use bevy::prelude::*;

use crate::scene::{Probe, ProbePlot, ProbeSubject, Probes};

type Subject = ProbeSubject<Entity, Entity>;

fn plots(probes: &Probes) -> impl Iterator<Item = (&Subject, ProbePlot)> {
    probes.0.iter().filter_map(|probe| match probe {
        Probe::Plot(subject, plot) => Some((subject, *plot)),
        Probe::Trail(_) | Probe::Tape(_) => None,
    })
}

/// Whether [`ContactForces`](crate::physics::ContactForces) are read.
pub fn reads_contact_forces(probes: &Probes) -> bool {
    plots(probes).any(|(_, plot)| plot.is_contact_force())
}

/// Whether [`Diagnostics`](crate::physics::Diagnostics) are read.
pub fn reads_diagnostics(probes: &Probes) -> bool {
    let is_measured = |plot: ProbePlot| matches!(plot.unit(), "J" | "m");
    plots(probes).any(|(subject, plot)| *subject == ProbeSubject::Scene && is_measured(plot))
}

/// The joints whose [`JointLoad`](crate::physics::JointLoad) is read.
pub fn read_loads(probes: &Probes) -> impl Iterator<Item = Entity> {
    plots(probes).filter_map(|(subject, plot)| match subject {
        ProbeSubject::Joint(joint) if matches!(plot, ProbePlot::Force | ProbePlot::Torque) => Some(*joint),
        _ => None,
    })
}
