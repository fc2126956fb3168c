//! What each phase of a step costs, on three scenes that have settled and on heaps that fall, hit and settle, sleeping
//! off. Of a heap, the time is that of all steps of 5 s.
//!
//! `cargo bench --profile measure --no-default-features --features lab --bench stages`
//!
//! Whole steps run, with a clock read between the sets of the schedule: a phase alone would find
//! its data in other caches than it does in a step. A reading takes some 30 ns.

use std::time::Duration;

use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use plumb::physics::PhaseTimes;
use plumb::prelude::*;

/// Steps in which a heap falls, hits and settles: 5 s.
const HEAP_STEPS: u64 = 300;

/// A scene with a clock in its schedule.
fn timed(scene: &str, parameters: &[(&str, f64)], threads: u32) -> App {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let mut app = headless_app();
    let mut settings = SolverSettings { threads, ..SolverSettings::game() };
    settings.impulse.sleep_speed = None;
    app.insert_resource(settings);
    app.init_resource::<PhaseTimes>();
    plumb::scene::load(scene, &parameters).expect("a built-in scene").spawn(app.world_mut());
    app
}

/// One that has run for a second.
fn settled(scene: &str, parameters: &[(&str, f64)], threads: u32) -> App {
    let mut app = timed(scene, parameters, threads);
    for _ in 0..60 {
        step(app.world_mut());
    }
    app
}

/// What a phase takes in so many steps.
fn spent(world: &mut World, phase: usize, steps: u64) -> Duration {
    let one_step = |_| {
        step(world);
        Duration::from_secs_f64(world.resource::<PhaseTimes>().seconds[phase])
    };
    (0..steps).map(one_step).sum()
}

fn phases_of_heaps(criterion: &mut Criterion) {
    for (kind, what) in ["boxes", "balls", "hulls", "cones", "mixed"].into_iter().enumerate() {
        for threads in [1, 2] {
            let mut group = criterion.benchmark_group(format!("heap of 1000 {what}, threads {threads}"));
            group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
            for (phase, name) in PhaseTimes::NAMES.into_iter().enumerate() {
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|runs| {
                        let run = |_| {
                            let mut app = timed("heap", &[("kind", kind as f64), ("n", 1000.0)], threads);
                            spent(app.world_mut(), phase, HEAP_STEPS)
                        };
                        (0..runs).map(run).sum()
                    });
                });
            }
            group.finish();
        }
    }
}

fn phases(criterion: &mut Criterion) {
    for (scene, parameters) in [("pyramid", [("n", 40.0)]), ("pyramids", [("n", 8.0)]), ("joint_grid", [("n", 100.0)])]
    {
        for threads in [1, 2] {
            let mut app = settled(scene, &parameters, threads);
            let mut group = criterion.benchmark_group(format!("{scene} {}, threads {threads}", parameters[0].1));
            group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
            for (phase, name) in PhaseTimes::NAMES.into_iter().enumerate() {
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|steps| spent(app.world_mut(), phase, steps));
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, phases, phases_of_heaps);
criterion_main!(benches);
