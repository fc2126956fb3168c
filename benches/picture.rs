//! What a frame of the sandbox costs beside the steps, without drawing: ten thousand bodies awake, a step each frame.
//!
//! `cargo bench --bench picture`; with a word behind `--`, for as many bodies. Bound to one core (`taskset -c 0`) it tells the
//! time of all threads.
//!
//! A clock is read between the schedules of a frame. The step has a line of its own, and so has what keeps its history.

use std::time::{Duration, Instant};

use bevy::app::{FixedMainScheduleOrder, MainScheduleOrder};
use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;
use plumb::physics::StepStats;
use plumb::sandbox::{CurrentScene, Hands, Page, Playback, SandboxAction, Selection, StepBudget, Tool};

/// Frames that are measured.
const FRAMES: usize = 200;
/// Frames before them: the first ones make what later ones use.
const BEFORE: usize = 30;

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Clock(&'static str);

/// Readings of a frame: what ended, and when.
#[derive(Resource, Default)]
struct Readings(Vec<(&'static str, Instant)>);

fn read(app: &mut App, name: &'static str) -> Clock {
    let record = move |mut readings: ResMut<Readings>| readings.0.push((name, Instant::now()));
    let mut schedule = Schedule::new(Clock(name));
    schedule.add_systems(record);
    app.add_schedule(schedule);
    Clock(name)
}

fn add_clocks(app: &mut App) {
    app.init_resource::<Readings>();
    let begin = read(app, "begin");
    app.world_mut().resource_mut::<MainScheduleOrder>().insert_before(First, begin);
    macro_rules! after {
        ($Order:ty, $($Label:ident),+) => {$(
            let label = read(app, stringify!($Label));
            app.world_mut().resource_mut::<$Order>().insert_after($Label, label);
        )+};
    }
    after!(MainScheduleOrder, First, PreUpdate, RunFixedMainLoop, Update, SpawnScene, PostUpdate, Last);
    after!(FixedMainScheduleOrder, FixedFirst, FixedPreUpdate, FixedUpdate, FixedPostUpdate, FixedLast);
}

/// What each stretch of a frame takes, by the name of what ended it.
fn measure(hands: &mut Hands) -> Vec<(String, Vec<Duration>)> {
    let mut stretches: Vec<(String, Vec<Duration>)> = Vec::new();
    for _ in 0..FRAMES {
        let began = Instant::now();
        hands.frames(1);
        let whole = began.elapsed();
        let readings = std::mem::take(&mut hands.world().resource_mut::<Readings>().0);
        let mut took = vec![("whole frame", whole)];
        took.extend(readings.windows(2).map(|pair| (pair[1].0, pair[1].1 - pair[0].1)));
        let of_steps = took.iter().filter(|(name, _)| ["FixedPostUpdate", "FixedLast"].contains(name));
        let fixed: Duration = of_steps.map(|(_, took)| *took).sum();
        let step = Duration::from_secs_f64(hands.world().resource::<StepStats>().step_seconds).min(fixed);
        took.insert(1, ("without step and history", whole - fixed));
        took.insert(2, ("step", step));
        took.insert(3, ("history of the world", fixed - step));
        for (name, took) in took {
            match stretches.iter_mut().find(|(known, _)| known == name) {
                Some((_, all)) => all.push(took),
                None => stretches.push((name.to_owned(), vec![took])),
            }
        }
    }
    stretches
}

fn report(title: &str, hands: &mut Hands) {
    hands.frames(BEFORE);
    hands.world().resource_mut::<Readings>().0.clear();
    let stretches = measure(hands);
    let stats = *hands.world().resource::<StepStats>();
    println!("{title}: {} bodies, {} asleep", stats.bodies, stats.sleeping);
    println!("{:>28} {:>9} {:>9}", "ms", "median", "least");
    for (name, mut took) in stretches {
        took.sort();
        let ms = |took: Duration| 1e3 * took.as_secs_f64();
        println!("{name:>28} {:>9.3} {:>9.3}", ms(took[took.len() / 2]), ms(took[0]));
    }
}

fn main() {
    let n = std::env::args().skip(1).find_map(|word| word.parse::<f64>().ok()).unwrap_or(10_000.0);
    let mut hands = Hands::open(UVec2::new(1280, 720));
    add_clocks(&mut hands.app);
    let (scene, parameters) = ("heap".into(), vec![("n".to_owned(), n), ("kind".to_owned(), 4.0)]);
    hands.act(SandboxAction::LoadScene { scene, parameters });
    // On the bodies, so that what is under the pointer is looked for.
    hands.jump_to(Vec2::new(470.0, 330.0));
    // One step a frame, as on a machine that is fast enough.
    hands.world().insert_resource(StepBudget { least: Duration::ZERO, of_picture: 0.0 });
    report("heap falls", &mut hands);
    hands.world().insert_resource(Page::Analyse);
    report("the same, page 'Analyse'", &mut hands);
    hands.world().resource_mut::<Playback>().paused = true;
    report("the same, paused", &mut hands);
    let picked = hands.world().resource::<CurrentScene>().entities.bodies[1];
    *hands.world().resource_mut::<Selection>() = Selection::of(picked);
    hands.act(SandboxAction::ChooseTool(Tool::Add));
    *hands.world().resource_mut::<Selection>() = Selection::of(picked);
    report("the same, a body picked, about to add one", &mut hands);
}
