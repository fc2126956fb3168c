//! A compact track of where bodies were, for drawing: a moment can be looked at before the world has gone there.
//!
//! A frame of it has those that moved since the last; every 64th, and where one came or went, has all. A pose takes 24
//! bytes: positions in `f32` from the picture's origin of the beginning, rotations in four times 15 bits and a sign.

use std::collections::VecDeque;

use bevy::ecs::entity::EntityHashMap;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::physics::{History, Position, RenderOrigin, RigidBody, Rotation, StepStats};

/// What the track of a scene may take, bytes.
pub const LIMIT: usize = 128 << 20;
/// Frames from one that has all bodies to the next at most.
const INTERVAL: usize = 64;
/// Of a component of a quaternion.
const SCALE: f64 = i16::MAX as f64;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Pose {
    /// Place among the bodies of the track.
    body: u32,
    position: [f32; 3],
    rotation: [i16; 4],
}

impl Pose {
    fn new(body: u32, position: DVec3, rotation: DQuat) -> Self {
        let rotation = rotation.to_array().map(|component| (component * SCALE).round_ties_even() as i16);
        Self { body, position: position.as_vec3().to_array(), rotation }
    }

    fn rotation(&self) -> DQuat {
        DQuat::from_array(self.rotation.map(|component| f64::from(component) / SCALE)).normalize()
    }
}

/// The moment after a step.
#[derive(Clone, Debug)]
struct Frame {
    step: u64,
    /// Of the simulation, s.
    time: f64,
    has_all: bool,
    moved: Box<[Pose]>,
}

/// Where bodies were after each of the last steps.
#[derive(Resource, Clone, Debug, Default)]
pub struct PoseTrack {
    origin: DVec3,
    /// Its bodies, and the place of each.
    bodies: Vec<Entity>,
    place_of: EntityHashMap<u32>,
    /// Where each was in the last frame; none: it was not there.
    last: Vec<Option<Pose>>,
    /// By step, ascending.
    frames: VecDeque<Frame>,
    /// Poses in all frames.
    poses: usize,
    /// Frames since the last that has all.
    since: usize,
    /// [`History::cuts`] of the last.
    cuts: u64,
}

impl PoseTrack {
    /// A new one; the picture has that origin.
    pub fn new(origin: DVec3) -> Self {
        Self { origin, ..Self::default() }
    }

    /// Takes in the moment after a step: its number, its time, s, and where bodies are.
    fn record(&mut self, step: u64, time: f64, bodies: impl Iterator<Item = (Entity, DVec3, DQuat)> + Clone) {
        let mut there = 0;
        let mut moved = Vec::with_capacity(self.last.len());
        let mut is_new = false;
        let mut next = 0;
        for (entity, position, rotation) in bodies.clone() {
            let place = self.place_after(next, entity);
            next = place + 1;
            let pose = Pose::new(place, position - self.origin, rotation);
            there += 1;
            is_new |= self.last[place as usize].is_none();
            if self.last[place as usize] != Some(pose) {
                moved.push(pose);
            }
        }
        let known = self.last.iter().flatten().count();
        let has_all = is_new || there != known || self.frames.is_empty() || self.since >= INTERVAL;
        if has_all {
            self.last.fill(None);
            moved.clear();
            moved.extend(bodies.map(|(entity, position, rotation)| {
                Pose::new(self.place_of[&entity], position - self.origin, rotation)
            }));
        }
        for pose in &moved {
            self.last[pose.body as usize] = Some(*pose);
        }
        self.since = if has_all { 1 } else { self.since + 1 };
        self.poses += moved.len();
        self.frames.push_back(Frame { step, time, has_all, moved: moved.into() });
        while self.bytes() > LIMIT && self.frames.len() > 1 {
            self.drop_first();
        }
    }

    /// The place of a body, which is a new one if it has none; bodies come in nearly the same order each time, and there first.
    fn place_after(&mut self, likely: u32, entity: Entity) -> u32 {
        if self.bodies.get(likely as usize) == Some(&entity) {
            return likely;
        }
        *self.place_of.entry(entity).or_insert_with(|| {
            self.bodies.push(entity);
            self.last.push(None);
            self.bodies.len() as u32 - 1
        })
    }

    /// Drops all frames before the second that has all bodies.
    fn drop_first(&mut self) {
        while let Some(frame) = self.frames.pop_front() {
            self.poses -= frame.moved.len();
            if self.frames.front().is_none_or(|next| next.has_all) {
                break;
            }
        }
    }

    /// Drops that step and all after it.
    fn forget_from(&mut self, step: u64) {
        while let Some(frame) = self.frames.pop_back_if(|frame| frame.step >= step) {
            self.poses -= frame.moved.len();
            // What the last frame has is not known any more: the next has all.
            self.since = INTERVAL;
        }
    }

    /// About what it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.poses * size_of::<Pose>()
    }

    /// The time of the moment after that step, s, if it is in it.
    pub fn time(&self, step: u64) -> Option<f64> {
        Some(self.frames[self.place(step)?].time)
    }

    /// Whether the moment after that step is in it.
    pub fn has(&self, step: u64) -> bool {
        self.place(step).is_some()
    }

    fn place(&self, step: u64) -> Option<usize> {
        self.frames.binary_search_by_key(&step, |frame| frame.step).ok()
    }

    /// Where bodies were after that step, less the picture's origin; none of those that were not there.
    pub fn at(&self, step: u64, origin: DVec3) -> EntityHashMap<(DVec3, DQuat)> {
        let Some(place) = self.place(step) else { return default() };
        let first = (0..=place).rev().find(|&place| self.frames[place].has_all).unwrap_or(place);
        let mut found = EntityHashMap::default();
        // The last word first.
        for pose in self.frames.range(first..=place).rev().flat_map(|frame| &frame.moved) {
            found.entry(self.bodies[pose.body as usize]).or_insert_with(|| {
                let position = DVec3::from_array(pose.position.map(f64::from));
                (self.origin + position - origin, pose.rotation())
            });
        }
        found
    }
}

/// Takes in the step that was made, unless it was made before and is as it was.
pub fn record(
    mut track: ResMut<PoseTrack>,
    stats: Res<StepStats>,
    history: Option<Res<History>>,
    bodies: Query<(Entity, &Position, &Rotation), With<RigidBody>>,
) {
    let Some(history) = history else { return };
    let (step, track) = (stats.steps, track.bypass_change_detection());
    if std::mem::replace(&mut track.cuts, history.cuts()) != history.cuts() {
        track.forget_from(step);
    }
    if track.frames.back().is_none_or(|last| last.step < step) {
        let bodies = bodies.iter().map(|(entity, position, rotation)| (entity, position.0, rotation.0));
        track.record(step, stats.time, bodies);
    }
}

/// Empties it: a scene begins.
pub fn begin(world: &mut World) {
    let origin = world.get_resource::<RenderOrigin>().map_or(DVec3::ZERO, |origin| origin.0);
    world.insert_resource(PoseTrack::new(origin));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entity(index: u32) -> Entity {
        Entity::from_raw_u32(index).unwrap()
    }

    /// One body that moves, one that does so now and then, one that comes later.
    fn bodies(step: u64) -> Vec<(Entity, DVec3, DQuat)> {
        let turn = DQuat::from_rotation_y(0.01 * step as f64);
        let mut all = vec![
            (entity(1), DVec3::new(1.0, 0.1 * step as f64, 0.0), turn),
            (entity(2), DVec3::X * (step / 10) as f64, DQuat::IDENTITY),
        ];
        if step >= 100 {
            all.push((entity(3), DVec3::Z, turn));
        }
        all
    }

    fn track(steps: u64) -> PoseTrack {
        let mut track = PoseTrack::new(DVec3::Y);
        (1..=steps).for_each(|step| track.record(step, 0.5 * step as f64, bodies(step).into_iter()));
        track
    }

    fn assert_is(track: &PoseTrack, step: u64, expected: &[(Entity, DVec3, DQuat)]) {
        let found = track.at(step, DVec3::X);
        assert_eq!(found.len(), expected.len(), "step {step}");
        for (entity, position, rotation) in expected {
            let (there, turned) = found[entity];
            assert!((there + DVec3::X - position).length() < 1e-5, "step {step}: {there}");
            assert!(turned.angle_between(*rotation) < 2e-4, "step {step}: {turned}");
        }
    }

    #[test]
    fn each_moment_is_as_it_was() {
        let track = track(200);
        for step in 1..=200 {
            assert_is(&track, step, &bodies(step));
        }
        assert_eq!([track.time(0), track.time(1), track.time(200)], [None, Some(0.5), Some(100.0)]);
        assert!(!track.has(0) && !track.has(201) && track.at(201, DVec3::ZERO).is_empty());
        let all: usize = (1..=200).map(|step| bodies(step).len()).sum();
        assert!(track.poses < all * 7 / 10, "what lies still is not told again: {} of {all}", track.poses);
    }

    #[test]
    fn what_was_to_come_is_forgotten() {
        let mut track = track(150);
        track.forget_from(90);
        assert!(track.has(89) && !track.has(90));
        let elsewhere: Vec<_> =
            bodies(90).into_iter().map(|(entity, position, turn)| (entity, position + DVec3::Z, turn)).collect();
        track.record(90, 45.0, elsewhere.iter().copied());
        assert_is(&track, 90, &elsewhere);
        assert_is(&track, 89, &bodies(89));
    }

    #[test]
    fn the_oldest_goes_first_and_leaves_whole_moments() {
        let mut track = track(300);
        let frames = track.frames.len();
        track.drop_first();
        let first = track.frames[0].step;
        assert!(track.frames.len() < frames && track.frames[0].has_all);
        assert_eq!(track.poses, track.frames.iter().map(|frame| frame.moved.len()).sum::<usize>());
        for step in first..=300 {
            assert_is(&track, step, &bodies(step));
        }
    }
}
