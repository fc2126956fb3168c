//! The contacts that last as [`Contacts`], and their forces, for whoever reads them.

use std::iter::repeat;

use bevy::prelude::*;
use nalgebra::Vector3;

use super::graph::{ContactGraph, Recording};
use super::record::{ContactState, POINTS};
use super::slot::Slot;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::manifold::{ContactPoint, Contacts, Manifold, Pair};
use crate::physics::lanes::Record;
use crate::physics::readings::ContactForces;
use crate::physics::settings::SolverSettings;
use crate::physics::stats::StepStats;

/// Fills [`Contacts`] from the slots, for whoever reads them.
pub(in crate::physics::collision) fn export_contacts(
    bodies: Res<Bodies>,
    mut graph: ResMut<ContactGraph>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    forces: Option<Res<ContactForces>>,
    mut contacts: ResMut<Contacts>,
) {
    let contacts = contacts.bypass_change_detection();
    let graph = graph.bypass_change_detection();
    let mut recording = forces.map(|_| graph.recording.take().unwrap_or_else(|| graph.begin_recording(&settings)));
    if let Some(recording) = &mut recording {
        // What touches and is awake is written over in the solve.
        recording.totals.resize(graph.slots.len(), Record::default());
        recording.tangents.clear();
    }
    contacts.time = stats.time;
    contacts.manifolds.clear();
    contacts.points.clear();
    let slots = graph.slots.iter().zip(&graph.states).enumerate();
    for (index, (slot, state)) in slots.filter(|(_, (slot, _))| slot.touching) {
        let [a, b] = [slot.pair.a, slot.pair.b].map(|body| &bodies.list[body as usize]);
        let normal = a.rotation * state.geometry.normal();
        let first = contacts.points.len();
        contacts.points.extend(points_at(slot, state, [a, b]));
        if let Some(recording) = &mut recording {
            recording.tangents.push(a.rotation * state.geometry.tangent());
        }
        contacts.manifolds.push(Manifold {
            slot: Some(index as u32),
            pair: slot.pair,
            parts: slot.parts,
            normal,
            first_point: first as u32,
            point_count: (contacts.points.len() - first) as u32,
            friction: f64::from(state.geometry.friction()),
            restitution: f64::from(slot.restitution),
        });
    }
    graph.recording = recording;
}

/// The points of a pair where its bodies are.
fn points_at<'a>(
    slot: &'a Slot,
    state: &'a ContactState,
    [a, b]: [&'a Body; 2],
) -> impl Iterator<Item = ContactPoint> + 'a {
    let normal = a.rotation * state.geometry.normal();
    let apart = b.position - a.position + slot.ahead;
    (0..state.geometry.point_count()).map(move |index| {
        let (on_a, on_b) = state.geometry.point(index);
        let (on_a, on_b) = (a.rotation * (on_a + slot.origin), b.rotation * on_b + apart);
        let (point, depth) = (a.position + (on_a + on_b) * 0.5, normal.dot(&(on_a - on_b)));
        ContactPoint { point, depth, feature: slot.features[index] }
    })
}

impl ContactGraph {
    /// The points of all pairs that touch, where their bodies are now, with their slots.
    pub fn points<'a>(&'a self, bodies: &'a Bodies) -> impl Iterator<Item = (u32, Pair, ContactPoint)> + 'a {
        let slots = (0..).zip(self.slots.iter().zip(&self.states)).filter(|(_, (slot, _))| slot.touching);
        slots.flat_map(|(index, (slot, state))| {
            let [a, b] = [slot.pair.a, slot.pair.b].map(|body| bodies.list.get(body as usize));
            let points = a.zip(b).map(|(a, b)| points_at(slot, state, [a, b]));
            points.into_iter().flatten().map(move |point| (index, slot.pair, point))
        })
    }

    /// A recording that begins: of those that sleep already the last substep stands for all.
    fn begin_recording(&self, settings: &SolverSettings) -> Recording {
        let all = |state: &ContactState| Record(state.impulses.0.map(|impulse| impulse * settings.substeps as f32));
        Recording { totals: self.states.iter().map(all).collect(), tangents: Vec::new() }
    }

    /// The force on B at each contact point, as (manifold, point within it, its mean over a step of `h` and that
    /// of its last substep, of `h_last`, N). Friction of a patch is shared out as the points press.
    pub fn contact_forces(
        &self,
        contacts: &Contacts,
        h: f64,
        h_last: f64,
    ) -> impl Iterator<Item = (u32, usize, [Vector3<f64>; 2])> {
        let recording =
            self.recording.iter().flat_map(|Recording { totals, tangents }| tangents.iter().zip(repeat(totals)));
        (0..).zip(&contacts.manifolds).zip(recording).flat_map(move |((index, manifold), (tangent, totals))| {
            let slot = manifold.slot.expect("exported from one") as usize;
            let frame = [manifold.normal, *tangent, manifold.normal.cross(tangent)];
            let forces = [(&totals[slot], h), (&self.states[slot].impulses, h_last)];
            (0..manifold.point_count as usize)
                .map(move |point| (index, point, forces.map(|(impulses, h)| point_force(impulses, &frame, point) / h)))
        })
    }
}

/// What one point of a patch pushes with, N·s.
fn point_force(impulses: &Record<f32>, [normal, x, y]: &[Vector3<f64>; 3], point: usize) -> Vector3<f64> {
    let [push, along_x, along_y] = [point, POINTS, POINTS + 1].map(|index| f64::from(impulses.0[index]));
    let pressed: f64 = impulses.0[..POINTS].iter().map(|&impulse| f64::from(impulse)).sum();
    let share = if pressed > 0.0 { push / pressed } else { 0.0 };
    normal * push + (x * along_x + y * along_y) * share
}
