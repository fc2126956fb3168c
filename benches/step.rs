//! What one run of the physics schedule costs, the ECS included.
//!
//! `cargo bench --profile measure --no-default-features --features lab`

use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use plumb::prelude::*;

/// A scene that has run for a second, so that contacts and buffers are those of a settled run.
fn settled(scene: &str, parameters: &[(&str, f64)], settings: SolverSettings) -> App {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let spec = plumb::scene::load(scene, &parameters).expect("a built-in scene");
    let mut app = headless_app();
    app.insert_resource(settings);
    spec.spawn(app.world_mut());
    for _ in 0..60 {
        step(app.world_mut());
    }
    app
}

fn steps(criterion: &mut Criterion) {
    let mut empty = headless_app();
    criterion.bench_function("empty world", |bencher| bencher.iter(|| empty.world_mut().run_schedule(PhysicsSchedule)));
    for (name, scene, parameters) in [
        ("chain", "chain", &[][..]),
        ("limbs", "limbs", &[]),
        ("pyramid 40", "pyramid", &[("n", 40.0)]),
        ("pyramids 8", "pyramids", &[("n", 8.0)]),
        ("joint_grid 100", "joint_grid", &[("n", 100.0)]),
    ] {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(20);
        for (preset, make) in SolverSettings::PRESETS {
            let mut app = settled(scene, parameters, make());
            group.bench_function(preset, |bencher| bencher.iter(|| step(app.world_mut())));
        }
        group.finish();
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
