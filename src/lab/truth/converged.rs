//! A converged answer, for scenes of which nothing else is known: where the preset `accurate`, at two
//! steps, agrees with itself.
//!
//! With a method of first order, steps h and h/2 differ by as much as h/2 is off; of second order, by
//! three times that. Twice the largest difference of any body so far is taken for the uncertainty of
//! the finer run. The answer ends before that grows past what is useful, which in a scene that
//! collides is soon: motions that start alike part exponentially. It also ends where a run takes
//! too much work. What is wrong alike at both steps is not seen so.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use bevy::math::{DMat3, DQuat, DVec3};
use xxhash_rust::xxh3::xxh3_64;

use super::answer::{ROUNDING, Truth};
use super::bodies::{collider, dynamic, largest_displacement};
use super::instant::{Instant, TIME_TOLERANCE, Table};
use crate::lab::simulation::{Sample, Simulation};
use crate::physics::{Collider, SolverSettings, StepStats};
use crate::scene::SceneSpec;

/// Why nothing is known of a scene's answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unknown(String);

/// Steps per second of the two runs.
const RATES: [f64; 2] = [240.0, 480.0];

/// Time between the poses compared, s.
const INTERVAL: f64 = 0.05;

/// Longest answer, s.
const MOST_SECONDS: f64 = 1.0;

/// Of the uncertainty over the difference of the two runs.
const SAFETY: f64 = 2.0;

/// Share of the smallest body's size beyond which an uncertain place is no answer: half of what
/// fails a run that sinks.
const USEFUL_SHARE: f64 = 0.05;

/// Bodies and joints × steps of both runs: some seconds of work where nothing touches.
const MOST_WORK: f64 = 2.5e5;

/// Row updates of a run: some seconds of work. Where many bodies bounce at once, as when those of `spheres` land, a
/// step takes a second.
const MOST_UPDATES: u64 = 10_000_000;

/// Points of the bodies that move.
struct Reference {
    /// At `INTERVAL`, 2 × `INTERVAL`, …; in the order of [`Marks`].
    points: Vec<Vec<DVec3>>,
    uncertainty: f64,
}

/// Three points of each body, which tell its pose: its centre of mass, and one along each of two of
/// its axes, as far as it reaches.
#[derive(Clone)]
struct Marks {
    points: Vec<(usize, DVec3)>,
    /// Of each body.
    shapes: Vec<Option<Collider>>,
}

impl Marks {
    fn of(scene: &SceneSpec) -> Self {
        let radius = |body: usize| scene.bodies[body].shape.as_ref().map_or(0.0, |shape| shape.bounding_radius());
        let of_body = |body| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|axis| (body, radius(body) * axis));
        let moving = dynamic(scene);
        let shapes = moving.iter().map(|&body| collider(&scene.bodies[body])).collect();
        Self { points: moving.into_iter().flat_map(of_body).collect(), shapes }
    }

    fn instants(&self, sample: &Sample) -> Vec<Instant> {
        let instant = |&(body, mark): &(usize, DVec3)| Instant::of_point(sample.time, &sample.bodies[body], mark);
        self.points.iter().map(instant).collect()
    }

    /// The distance of the farthest material point of any body between two places of the marks.
    fn apart(&self, one: &[DVec3], other: &[DVec3]) -> f64 {
        let bodies = one.chunks_exact(3).zip(other.chunks_exact(3)).zip(&self.shapes);
        let apart = bodies.map(|((one, other), shape)| {
            let rotations = [one, other].map(|marks| rotation(marks[1] - marks[0], marks[2] - marks[0]));
            largest_displacement(shape.as_ref(), other[0] - one[0], rotations)
        });
        apart.fold(0.0, f64::max)
    }
}

/// The rotation that turns x and y, of whatever length, into those directions.
fn rotation(x: DVec3, y: DVec3) -> DQuat {
    let x = x.normalize_or(DVec3::X);
    let y = y.reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

/// The converged answer of a scene for a run of so many seconds. Worked out once a process.
///
/// # Errors
/// The scene is too large, the time too short, or the two runs do not agree.
pub fn converged(scene: &SceneSpec, seconds: f64) -> Result<Truth, Unknown> {
    let reference = known_or_worked_out(scene, seconds.min(MOST_SECONDS))?;
    let marks = Marks::of(scene);
    let uncertainty = reference.uncertainty;
    let times = (1..).map(|n: u32| f64::from(n) * INTERVAL);
    let mut table = Table::new(times.zip(reference.points.iter().cloned()).collect());
    let distance =
        move |sample: &Sample| table.largest(marks.instants(sample), |found, places| marks.apart(places, found));
    Ok(Truth::largest("all bodies, from where fine runs agree", "m", distance).with_uncertainty(uncertainty))
}

/// Whether and how a scene's answer came out, by a hash of the scene and the time.
type Known = Mutex<HashMap<u64, Result<Arc<Reference>, Unknown>>>;

fn known_or_worked_out(scene: &SceneSpec, seconds: f64) -> Result<Arc<Reference>, Unknown> {
    static KNOWN: LazyLock<Known> = LazyLock::new(Known::default);
    let key = xxh3_64(format!("{scene:?} {seconds}").as_bytes());
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(reference) = known().get(&key) {
        return reference.clone();
    }
    // Not under the lock: two threads may do the same work, and neither waits for another's.
    let reference = work_out(scene, seconds).map(Arc::new);
    known().entry(key).or_insert(reference).clone()
}

fn work_out(scene: &SceneSpec, seconds: f64) -> Result<Reference, Unknown> {
    let samples = ((seconds + TIME_TOLERANCE) / INTERVAL).floor() as usize;
    if samples == 0 {
        return Err(Unknown(format!("a converged answer begins at {INTERVAL} s")));
    }
    let moving = dynamic(scene);
    let steps = samples as f64 * INTERVAL * RATES.iter().sum::<f64>();
    if (moving.len() + scene.joints.len()) as f64 * steps > MOST_WORK {
        return Err(Unknown("too large a scene to work out a converged answer".to_owned()));
    }
    let sizes = moving.iter().filter_map(|&body| Some(scene.bodies[body].shape.as_ref()?.smallest_extent()));
    let useful = USEFUL_SHARE * sizes.fold(f64::INFINITY, f64::min);
    let marks = Marks::of(scene);
    let mut runs = RATES.map(|hz| FineRun::new(scene, hz));
    let mut reference = Reference { points: Vec::new(), uncertainty: ROUNDING };
    for _ in 0..samples {
        let [Some(coarse), Some(fine)] = runs.each_mut().map(FineRun::next_points) else { break };
        let uncertainty = reference.uncertainty.max(SAFETY * marks.apart(&coarse, &fine));
        let sound = runs.iter().all(|run| is_sound(run.simulation.world().resource()));
        if !(sound && uncertainty <= useful) {
            break;
        }
        reference.points.push(fine);
        reference.uncertainty = uncertainty;
    }
    if reference.points.is_empty() {
        if runs.iter().any(|run| run.updates > MOST_UPDATES) {
            return Err(Unknown(format!("too much work to find a converged answer for {INTERVAL} s")));
        }
        let [coarse, fine] = RATES;
        return Err(Unknown(format!("runs at {coarse} and {fine} Hz do not agree to {useful:.1e} m for {INTERVAL} s")));
    }
    Ok(reference)
}

/// Whether what two runs agree on is an answer: a body that was set aside agrees with itself, and so does one that
/// nothing touches and whose step did not converge however short, and went by Euler's.
fn is_sound(stats: &StepStats) -> bool {
    stats.quarantined == 0 && (stats.unsettled == 0 || stats.contact_points > 0)
}

/// A run at one of the [`RATES`].
struct FineRun {
    simulation: Simulation,
    marks: Marks,
    steps: u32,
    /// Row updates so far.
    updates: u64,
}

impl FineRun {
    fn new(scene: &SceneSpec, hz: f64) -> Self {
        Self {
            simulation: Simulation::new(scene.clone(), SolverSettings { hz, ..SolverSettings::accurate() }),
            marks: Marks::of(scene),
            steps: (INTERVAL * hz).round() as u32,
            updates: 0,
        }
    }

    /// The marks [`INTERVAL`] later, unless that takes too much work.
    fn next_points(&mut self) -> Option<Vec<DVec3>> {
        for _ in 0..self.steps {
            self.simulation.step();
            self.updates += self.simulation.world().resource::<StepStats>().row_updates;
            if self.updates > MOST_UPDATES {
                return None;
            }
        }
        Some(self.marks.instants(&self.simulation.sample()).into_iter().map(|instant| instant.position).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    fn scene(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
        let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        load(name, &parameters).expect("a scene")
    }

    #[test]
    fn a_converged_answer_is_as_near_to_the_known_one_as_it_says() {
        let table = include_str!("../../../assets/reference/rods-2.csv");
        let reference = work_out(&scene("rods", &[("n", 2.0)]), 1.0).expect("an answer");
        assert!(reference.uncertainty < 1e-3, "{}", reference.uncertainty);
        assert_eq!(reference.points.len(), 20);
        for (row, points) in table.lines().skip(2).zip(reference.points.iter().skip(1).step_by(2)) {
            let row: Vec<f64> = row.split(',').map(|field| field.parse().expect("a number")).collect();
            let [center, along] = [points[3], points[4]];
            let tip = center + 0.5 * (along - center).normalize();
            let error = tip.distance(DVec3::new(row[1], row[2], row[3]));
            // The table has 12 digits.
            let within = reference.uncertainty + 1e-12;
            assert!(error < within, "at {} s: {error:e}, not {within:e}", row[0]);
        }
    }

    /// Euler's equations and q̇ = ½ ω q, in Runge–Kutta steps.
    #[test]
    fn bodies_that_spin_turn_as_euler_says() {
        let scene = scene("top", &[("spin", 5.0)]);
        let reference = work_out(&scene, 1.0).expect("an answer");
        let inertia = DVec3::new(0.40, 1.04, 1.36);
        let slope = |(omega, q): (DVec3, DQuat)| {
            let turn = q * DQuat::from_xyzw(omega.x, omega.y, omega.z, 0.0);
            ((inertia * omega).cross(omega) / inertia, turn * 0.5)
        };
        let along = |at: (DVec3, DQuat), slope: (DVec3, DQuat), by: f64| (at.0 + by * slope.0, at.1 + slope.1 * by);
        let mut state = (5.0 * DVec3::new(1e-3, 1.0, 0.0), DQuat::IDENTITY);
        let step = 1e-4;
        for points in &reference.points {
            for _ in 0..500 {
                let k1 = slope(state);
                let k2 = slope(along(state, k1, 0.5 * step));
                let k3 = slope(along(state, k2, 0.5 * step));
                let k4 = slope(along(state, k3, step));
                for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                    state = along(state, k, weight * step / 6.0);
                }
            }
            for (point, axis) in points[1..].iter().zip([DVec3::X, DVec3::Y]) {
                let error = point.normalize().distance(state.1.normalize() * axis);
                assert!(error < 2.0 * reference.uncertainty + 1e-9, "{error:e} {:e}", reference.uncertainty);
            }
        }
        // It has begun to flip: without the gyroscopic torque it would spin on about y.
        assert!((state.1.normalize() * DVec3::Y).distance(DVec3::Y) > 5e-3);
    }

    #[test]
    fn no_answer_comes_with_its_reason() {
        let refused = |scene: &SceneSpec, seconds| work_out(scene, seconds).err().expect("no answer").to_string();
        assert!(refused(&scene("rods", &[]), 0.04).contains("begins at 0.05 s"));
        assert!(refused(&scene("rods", &[("n", 1000.0)]), 1.0).contains("too large"));
        // Steps are cut into 4096 parts at most, in each of which it turns by some ten radians.
        let mut fast = scene("top", &[("spin", 1e4)]);
        fast.bodies[0].angular_velocity *= 1e3;
        let fast = refused(&fast, 1.0);
        assert!(fast.contains("do not agree to 1.0e-2 m for 0.05 s"), "{fast}");
        // So fast that the step sets it aside at any rate: it agrees with itself.
        let mut lost = scene("top", &[]);
        lost.bodies[0].angular_velocity = DVec3::splat(1e200);
        assert!(refused(&lost, 1.0).contains("do not agree"));
    }

    #[test]
    fn the_answer_ends_where_the_runs_part() {
        // Balls fall half a metre, land after 0.32 s, and bounce into each other.
        let reference = work_out(&scene("spheres", &[("e", 0.5)]), 1.0).expect("an answer");
        assert!((6..10).contains(&reference.points.len()), "{}", reference.points.len());
        assert!(reference.uncertainty <= USEFUL_SHARE * 0.2);
    }
}
