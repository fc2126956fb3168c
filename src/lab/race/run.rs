//! Running a race.

use bevy::math::{DQuat, DVec3};

use super::limits::Limits;
use super::outcome::{Course, Moment, Outcome, Race, Runner};
use crate::lab::angle::turn_between;
use crate::lab::simulation::Simulation;
use crate::lab::truth;
use crate::physics::{Collider, Diagnostics, RigidBody, StepStats};
use crate::scene::SceneSpec;

/// Samples a second.
const RATE: f64 = 60.0;

/// A body that moves: its place in the scene and what tells how far it is from another place.
struct Body {
    index: usize,
    collider: Option<Collider>,
}

type Poses = Vec<(DVec3, DQuat)>;

impl Race {
    /// Runs them all, side by side. `watch` is told how much is done, 0 to 1.
    pub fn run(&self, mut watch: impl FnMut(f64)) -> Outcome {
        let scene = self.scene_then();
        let bodies: Vec<Body> = (0..)
            .zip(&scene.bodies)
            .filter(|(_, body)| body.kind == RigidBody::Dynamic)
            .map(|(index, body)| Body { index, collider: body.shape.as_ref().map(|shape| shape.collider()) })
            .collect();
        let limits = Limits::of(&scene);
        let mut answer = (self.built_in && self.from == 0.0).then(|| truth::poses(&self.scene)).flatten();
        let mut lanes: Vec<Lane> = self.runners.iter().map(|runner| Lane::new(runner, &scene, self.from)).collect();
        let count = (self.seconds * RATE).round().max(1.0) as u64;
        let base = if answer.is_some() { "the answer".to_owned() } else { self.runners[0].name.clone() };
        for sample in 0..=count {
            let time = sample as f64 / RATE;
            lanes.iter_mut().for_each(|lane| lane.go_to(self.from + time));
            let first = lanes[0].poses();
            for lane in &mut lanes {
                let base = match &mut answer {
                    Some(poses) => {
                        // At the very time of its steps.
                        let mut all = vec![(DVec3::ZERO, DQuat::IDENTITY); scene.bodies.len()];
                        let there = poses(lane.simulation.sample().time);
                        there.into_iter().for_each(|(index, position, rotation)| all[index] = (position, rotation));
                        all
                    }
                    None => first.clone(),
                };
                lane.note(time, &bodies, &base, &limits, self.apart, answer.is_some());
            }
            watch(sample as f64 / count as f64);
        }
        Outcome { base, courses: lanes.into_iter().map(|lane| lane.course).collect() }
    }

    /// The scene at the start of the race.
    fn scene_then(&self) -> SceneSpec {
        let first = &self.runners[0].settings;
        let steps = (self.from * first.hz).round() as u64;
        if steps == 0 {
            return self.scene.clone();
        }
        let mut simulation = Simulation::new(self.scene.clone(), *first);
        (0..steps).for_each(|_| simulation.step());
        SceneSpec::of_world(simulation.world_mut(), self.scene.name.clone())
    }
}

/// A runner on its way.
struct Lane {
    simulation: Simulation,
    energy_at_start: Option<f64>,
    /// Steps since the last moment, and what they took, s.
    taken: (u32, f64),
    course: Course,
}

impl Lane {
    fn new(runner: &Runner, scene: &SceneSpec, from: f64) -> Self {
        let mut simulation = Simulation::new(scene.clone(), runner.settings);
        simulation.set_clock(from);
        simulation.world_mut().init_resource::<Diagnostics>();
        let course = Course { name: runner.name.clone(), moments: Vec::new(), parted: None, failed: None };
        Self { simulation, energy_at_start: None, taken: (0, 0.0), course }
    }

    /// As near to that time as whole steps come.
    fn go_to(&mut self, time: f64) {
        let (steps, seconds) = &mut self.taken;
        self.simulation.step_to(time, |simulation| {
            *steps += 1;
            *seconds += simulation.world().resource::<StepStats>().step_seconds;
        });
    }

    fn poses(&self) -> Poses {
        self.simulation.sample().bodies.iter().map(|body| (body.position, body.rotation)).collect()
    }

    fn note(&mut self, time: f64, bodies: &[Body], base: &Poses, limits: &Limits, apart: f64, is_answer: bool) {
        let measured = *self.simulation.world().resource::<Diagnostics>();
        let energy = measured.kinetic_energy + measured.potential_energy;
        // Nothing is measured before the first step.
        let start = match self.course.moments.is_empty() {
            true => energy,
            false => *self.energy_at_start.get_or_insert(energy),
        };
        let (mut distance, mut angle) = (0.0_f64, 0.0_f64);
        for body in bodies {
            let (now, there) = (self.simulation.sample().bodies[body.index], base[body.index]);
            let shift = now.position - there.0;
            let own = match &body.collider {
                Some(collider) => collider.largest_displacement(shift, [there.1, now.rotation]),
                None => shift.length(),
            };
            distance = larger(distance, own);
            angle = larger(angle, turn_between(there.1, now.rotation));
        }
        let (steps, seconds) = std::mem::take(&mut self.taken);
        let moment = Moment {
            time,
            distance,
            angle,
            energy: energy - start,
            joint_gap: measured.joint_error,
            overlap: measured.penetration,
            ms_per_step: if steps > 0 { 1e3 * seconds / f64::from(steps) } else { 0.0 },
        };
        let Course { moments, parted, failed, .. } = &mut self.course;
        if parted.is_none() && (distance > apart || distance.is_nan()) {
            *parted = Some(time);
        }
        if failed.is_none() {
            let frozen = self.simulation.quarantined();
            let set_aside = frozen.first().map(|body| format!("{} was set aside: {}", body.body, body.reason));
            let from_answer = || limits.far_from_answer(distance).filter(|_| is_answer);
            let reason = set_aside.or_else(|| limits.failure(&measured)).or_else(from_answer);
            *failed = reason.map(|reason| (time, reason));
        }
        moments.push(moment);
    }
}

/// Not a number where one of them is none.
fn larger(one: f64, other: f64) -> f64 {
    if one >= other || one.is_nan() { one } else { other }
}
