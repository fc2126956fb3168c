//! A monkey's play from its first bout to its last.

use std::collections::{BTreeMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::checks::{
    Check, count_entities, fastest, goes_back_and_on, is_a_recording, is_finite, joints_hold, record, saves_and_loads,
    step,
};
use super::deeds::{SIZE, do_something, pause};
use crate::lab::command::MonkeyRun;
use crate::lab::recording::Recording;
use crate::physics::{RigidBody, SolverSettings};
use crate::sandbox::{CurrentScene, Hands, Notice, SandboxAction};

/// Steps after which the scene begins again: what goes wrong is found again in a recording of a minute at most.
const BOUT: u64 = 3600;
/// Deeds from check to check, and checks from one that takes long to the next.
const DEEDS: usize = 5;
const CHECKS: u64 = 6;
/// Speed from which on a body has been thrown, m/s or rad/s: hands lend no tenth of it.
const THROWN: f64 = 1e3;
/// Deeds that are told of a failure.
const TOLD: usize = 12;

/// How a monkey's play went.
#[derive(Clone, Debug, Default)]
pub struct Played {
    /// Steps that the world made in it, those that were made again not counted.
    pub steps: u64,
    /// How often each thing was done.
    pub deeds: BTreeMap<String, u64>,
    /// How often all was checked.
    pub checks: u64,
    /// How many bodies were set aside that sweeps by forces had thrown.
    pub thrown: usize,
    /// Most bodies that there were at a check.
    pub most_bodies: usize,
    /// What went wrong, and ended it.
    pub failure: Option<Failure>,
}

/// What went wrong.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The bout, from 1, and the step in it.
    pub place: (u64, u64),
    /// With which that bout is the first.
    pub seed: u64,
    /// In words.
    pub problem: String,
    /// The last things that were done.
    pub deeds: Vec<String>,
    /// What happened in the bout, or why that cannot be told.
    pub recording: Result<Recording, String>,
}

/// Lets a monkey play with a scene. `watch` is told how many steps are made.
///
/// # Errors
/// The scene cannot be had.
pub fn play(run: &MonkeyRun, mut watch: impl FnMut(u64)) -> Result<Played, String> {
    let mut bouts = Bouts {
        hands: Hands::open(SIZE),
        random: Pcg64Mcg::seed_from_u64(run.seed),
        own: run.settings,
        entities: 0,
        aside: HashSet::new(),
        whole: None,
        rounds: 0,
        flies: false,
        played: Played::default(),
        told: Vec::new(),
    };
    let mut bout = 0;
    while bouts.played.steps < run.steps {
        bout += 1;
        let seed = run.seed.wrapping_add(bout - 1);
        bouts.begin(run, seed)?;
        let before = bouts.played.steps;
        let wanted = (run.steps - before).min(BOUT);
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            while bouts.played.steps - before < wanted {
                bouts.round()?;
                watch(bouts.played.steps.min(run.steps));
            }
            bouts.end(run)
        }));
        let problem = match outcome {
            Ok(Ok(())) => continue,
            Ok(Err(problem)) => problem,
            Err(panic) => {
                let said = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
                format!("it panicked: {}", said.unwrap_or("for no reason given"))
            }
        };
        let place = (bout, step(&bouts.hands));
        let recording =
            catch_unwind(AssertUnwindSafe(|| bouts.whole.take().map_or_else(|| record(&mut bouts.hands), Ok)));
        let recording = recording.unwrap_or_else(|_| Err("it cannot be recorded after a panic".into()));
        let deeds = bouts.told.split_off(bouts.told.len().saturating_sub(TOLD));
        bouts.played.failure = Some(Failure { place, seed, problem, deeds, recording });
        break;
    }
    Ok(bouts.played)
}

struct Bouts {
    hands: Hands,
    random: Pcg64Mcg,
    /// The settings that the scene is played with.
    own: SolverSettings,
    /// How many entities there were at the start of the bout.
    entities: usize,
    /// Bodies that were set aside and might be.
    aside: HashSet<Entity>,
    /// What happened in this bout, once it is over.
    whole: Option<Recording>,
    /// Rounds of this bout.
    rounds: u64,
    /// Whether something flies that sweeps by forces have thrown: whoever takes it over is not to blame.
    flies: bool,
    played: Played,
    /// What was done in this bout, and when.
    told: Vec<String>,
}

impl Bouts {
    /// The sandbox anew, with a seed of its own: a bout can be played again alone.
    fn begin(&mut self, run: &MonkeyRun, seed: u64) -> Result<(), String> {
        self.hands = Hands::open(SIZE);
        let Self { random, told, aside, whole, rounds, flies, .. } = self;
        *random = Pcg64Mcg::seed_from_u64(seed);
        told.clear();
        aside.clear();
        (*rounds, *flies, *whole) = (0, false, None);
        self.load_scene(run)?;
        self.entities = count_entities(&mut self.hands);
        Ok(())
    }

    fn load_scene(&mut self, run: &MonkeyRun) -> Result<(), String> {
        let Self { hands, own, .. } = self;
        hands.world().insert_resource(*own);
        let (scene, parameters) = (run.scene.clone(), run.parameters.clone());
        hands.act(SandboxAction::LoadScene { scene, parameters });
        if let (Notice::Error(problem), false) =
            (hands.app.world().resource::<Notice>().clone(), hands.app.world().contains_resource::<CurrentScene>())
        {
            return Err(problem);
        }
        pause(hands, false);
        hands.frames(3);
        Ok(())
    }

    /// Some deeds, and a check.
    fn round(&mut self) -> Check {
        let Self { hands, random, own, aside, rounds, flies, played, told, .. } = self;
        // By forces from sweeps what is tangled may fly apart, as their maps show.
        let mut may_fly = *flies;
        for _ in 0..DEEDS {
            let before = step(hands);
            let mut methods = Vec::new();
            let done = do_something(hands, random, own, &mut methods);
            methods.push(hands.app.world().resource::<SolverSettings>().method);
            let kind = done.split(' ').next().unwrap_or_default().to_owned();
            *played.deeds.entry(kind).or_default() += 1;
            told.push(format!("{before}: {done}"));
            may_fly |= methods.iter().any(|method| method.is_force_level());
            hands.frames(random.random_range(1..12));
            played.steps += step(hands).abs_diff(before).max(1);
        }
        hands.release();
        played.checks += 1;
        *rounds += 1;
        let world = hands.world();
        played.most_bodies = played.most_bodies.max(world.query::<&RigidBody>().iter(world).count());
        let before = aside.len();
        is_finite(hands, aside, may_fly)?;
        played.thrown += aside.len() - before;
        *flies = may_fly && fastest(hands) > THROWN;
        goes_back_and_on(hands, random)?;
        if rounds.is_multiple_of(CHECKS) {
            saves_and_loads(hands, own)?;
            let before = step(hands);
            joints_hold(hands, own)?;
            played.steps += step(hands).abs_diff(before);
            told.push("waited for joints to come to rest".into());
        }
        Ok(())
    }

    /// The end of a bout: what happened can be told, and nothing of it is left where the scene begins again.
    fn end(&mut self, run: &MonkeyRun) -> Check {
        self.hands.release();
        self.hands.frames(1);
        self.whole = Some(is_a_recording(&mut self.hands)?);
        self.load_scene(run)?;
        let (now, before) = (count_entities(&mut self.hands), self.entities);
        if now != before {
            return Err(format!(
                "there are {now} entities where the scene begins again, and were {before} the first time"
            ));
        }
        Ok(())
    }
}
