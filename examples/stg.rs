//! dev
use bevy::prelude::*;
use plumb::prelude::PhysicsSystems::{BroadPhase, Diagnose, Events, Islands, NarrowPhase, Prepare, Solve, WriteBack};
use plumb::prelude::*;
use std::time::Instant;
const PHASES: [&str; 7] = ["gather", "broad", "narrow", "islands", "solve", "write", "events"];
#[derive(Resource)]
struct Marks([Instant; 8]);
fn mark<const INDEX: usize>(mut marks: ResMut<Marks>) {
    marks.0[INDEX] = Instant::now();
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let threads: u32 = args[0].parse().unwrap();
    let steps: usize = args[1].parse().unwrap();
    let scene = &args[2];
    let parameters: Vec<(String, f64)> = args[3..]
        .iter()
        .map(|a| {
            let (n, v) = a.split_once('=').unwrap();
            (n.to_owned(), v.parse().unwrap())
        })
        .collect();
    let mut app = headless_app();
    let mut settings = SolverSettings { threads, ..SolverSettings::game() };
    settings.impulse.sleep_speed = None;
    app.insert_resource(settings);
    app.insert_resource(Marks([Instant::now(); 8]));
    app.add_systems(
        PhysicsSchedule,
        (
            mark::<0>.before(Prepare),
            mark::<1>.after(Prepare).before(BroadPhase),
            mark::<2>.after(BroadPhase).before(NarrowPhase),
            mark::<3>.after(NarrowPhase).before(Islands),
            mark::<4>.after(Islands).before(Solve),
            mark::<5>.after(Solve).before(WriteBack),
            mark::<6>.after(WriteBack).before(Events),
            mark::<7>.after(Events).before(Diagnose),
        ),
    );
    plumb::scene::load(scene, &parameters).expect("a built-in scene").spawn(app.world_mut());
    let mut sums = [0.0f64; 8];
    let (mut pairs, mut manifolds, mut points, mut axes) = (0u64, 0u64, 0u64, 0u64);
    let mut all: Vec<f64> = vec![];
    for _ in 0..steps {
        let start = Instant::now();
        step(app.world_mut());
        let whole = start.elapsed().as_secs_f64() * 1e3;
        all.push(whole);
        sums[7] += whole;
        let m = &app.world().resource::<Marks>().0;
        for p in 0..7 {
            sums[p] += (m[p + 1] - m[p]).as_secs_f64() * 1e3;
        }
        let s = app.world().resource::<StepStats>();
        pairs += u64::from(s.pairs);
        manifolds += u64::from(s.manifolds);
        points += u64::from(s.contact_points);
        axes += s.axes_tested;
    }
    let n = steps as f64;
    all.sort_by(f64::total_cmp);
    print!("whole {:.3} median {:.3} |", sums[7] / n, all[steps / 2]);
    for (p, name) in PHASES.iter().enumerate() {
        print!(" {name} {:.3}", sums[p] / n);
    }
    println!(
        " | pairs {} manifolds {} points {} axes {}",
        pairs / steps as u64,
        manifolds / steps as u64,
        points / steps as u64,
        axes / steps as u64
    );
}
