//! Reference answers against motions found in another way: equations of motion in as few
//! coordinates as there are, integrated here in small steps.

use bevy::math::{DQuat, DVec3};
use nalgebra::{DMatrix, DVector};
use plumb::lab::truth::{self, Truth};
use plumb::lab::{BodyState, Sample};
use plumb::physics::SolverSettings;
use plumb::scene::{SceneSpec, load};

fn scene(name: &str, parameters: &[(&str, f64)]) -> SceneSpec {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    load(name, &parameters).unwrap()
}

fn known(scene: &SceneSpec) -> Truth {
    truth::of(scene, &SolverSettings::default()).expect("an answer")
}

/// Feeds an answer with a motion: `at` edits the start states to those of a time.
fn follow(scene: &SceneSpec, times: impl Iterator<Item = f64>, mut at: impl FnMut(f64, &mut [BodyState])) -> Truth {
    let mut truth = known(scene);
    let start: Vec<BodyState> = scene
        .bodies
        .iter()
        .map(|body| BodyState {
            position: body.position,
            rotation: body.rotation,
            linear: body.linear_velocity,
            angular: body.angular_velocity,
        })
        .collect();
    for (step, time) in (0..).zip(times) {
        let mut bodies = start.clone();
        at(time, &mut bodies);
        truth.observe(&Sample { step, time, bodies: &bodies, loads: &[] });
    }
    truth
}

/// One step of the classical Runge–Kutta method.
fn runge_kutta(state: &mut DVector<f64>, step: f64, slope: impl Fn(&DVector<f64>) -> DVector<f64>) {
    let k1 = slope(state);
    let k2 = slope(&(&*state + 0.5 * step * &k1));
    let k3 = slope(&(&*state + 0.5 * step * &k2));
    let k4 = slope(&(&*state + step * &k3));
    *state += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

/// A body of a chain that hangs in the plane from the origin.
#[derive(Clone, Copy)]
struct Link {
    mass: f64,
    /// About its centre of mass, kg·m².
    inertia: f64,
    /// From its upper joint to its centre of mass and to its lower joint, m.
    center: f64,
    length: f64,
}

/// Links by their angles θ to the x axis. With a_ij the lever of angle j on centre i (its length
/// above, the distance of its own centre for i = j), Lagrange's equations are
/// Σ_k C_jk cos(θ_j − θ_k) θ̈_k + I_j θ̈_j = −Σ_k C_jk sin(θ_j − θ_k) θ̇_k² − g Σ_i m_i a_ij cos θ_j,
/// C_jk = Σ_i m_i a_ij a_ik.
struct PlanarChain {
    coupling: DMatrix<f64>,
    inertia: DVector<f64>,
    pull: DVector<f64>,
    lengths: Vec<f64>,
    tracked: f64,
}

impl PlanarChain {
    /// `tracked`: the point of the last link, from its upper joint.
    fn new(links: &[Link], gravity: f64, tracked: f64) -> Self {
        let n = links.len();
        let lever = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Greater => links[j].length,
            std::cmp::Ordering::Equal => links[j].center,
            std::cmp::Ordering::Less => 0.0,
        });
        let masses = DMatrix::from_diagonal(&DVector::from_iterator(n, links.iter().map(|link| link.mass)));
        Self {
            coupling: lever.transpose() * &masses * &lever,
            inertia: DVector::from_iterator(n, links.iter().map(|link| link.inertia)),
            pull: gravity * lever.transpose() * masses * DVector::repeat(n, 1.0),
            lengths: links.iter().map(|link| link.length).collect(),
            tracked,
        }
    }

    /// Rates of angles and of their rates, one below the other.
    fn slope(&self, state: &DVector<f64>) -> DVector<f64> {
        let n = self.inertia.len();
        let (angle, rate) = (state.rows(0, n), state.rows(n, n));
        let mass = DMatrix::from_fn(n, n, |j, k| {
            let own = if j == k { self.inertia[j] } else { 0.0 };
            own + self.coupling[(j, k)] * (angle[j] - angle[k]).cos()
        });
        let force = DVector::from_fn(n, |j, _| {
            let turning = |k: usize| self.coupling[(j, k)] * (angle[j] - angle[k]).sin() * rate[k] * rate[k];
            -(0..n).map(turning).sum::<f64>() - self.pull[j] * angle[j].cos()
        });
        let acceleration = mass.cholesky().expect("a mass matrix is positive").solve(&force);
        DVector::from_iterator(2 * n, rate.iter().chain(acceleration.iter()).copied())
    }

    fn tracked_point(&self, state: &DVector<f64>) -> DVec3 {
        let last = self.lengths.len() - 1;
        let along = |(link, length): (usize, f64)| length * DVec3::new(state[link].cos(), state[link].sin(), 0.0);
        (0..last).map(|link| (link, self.lengths[link])).chain([(last, self.tracked)]).map(along).sum()
    }

    /// The tracked point every tenth of a second up to 2 s, released at rest along +x.
    fn points(&self, step: f64) -> Vec<DVec3> {
        let mut state = DVector::zeros(2 * self.lengths.len());
        let steps = (0.1 / step).round() as u32;
        (0..20)
            .map(|_| {
                (0..steps).for_each(|_| runge_kutta(&mut state, step, |state| self.slope(state)));
                self.tracked_point(&state)
            })
            .collect()
    }
}

/// 1 kg, 1 m, square.
fn rod(thickness: f64) -> Link {
    Link { mass: 1.0, inertia: (1.0 + thickness * thickness) / 12.0, center: 0.5, length: 1.0 }
}

fn table(text: &str) -> Vec<DVec3> {
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        DVec3::new(numbers[1], numbers[2], numbers[3])
    };
    text.lines().skip(2).map(row).collect()
}

fn agree(name: &str, chain: &PlanarChain, step: f64, text: &str) {
    let points = chain.points(step);
    let expected = table(text);
    assert_eq!(points.len(), expected.len());
    for (n, (point, expected)) in points.iter().zip(&expected).enumerate() {
        let error = point.distance(*expected);
        assert!(error < 1e-9, "{name} at {:.1} s: {error:e}", 0.1 * (n + 1) as f64);
    }
}

#[test]
fn tables_of_rods_are_what_their_angles_equations_give() {
    for (n, text) in [
        (1, include_str!("../../assets/reference/rods-1.csv")),
        (2, include_str!("../../assets/reference/rods-2.csv")),
        (5, include_str!("../../assets/reference/rods-5.csv")),
    ] {
        let chain = PlanarChain::new(&vec![rod(0.1); n], 10.0, 1.0);
        agree(&format!("rods {n}"), &chain, 2e-4, text);
    }
}

#[test]
fn tables_of_chains_are_what_their_angles_equations_give() {
    // The heavier the ball, the faster the rods tremble between it and the pivot.
    for (mass, step, text) in [
        (1.0, 1e-4, include_str!("../../assets/reference/chain-1.csv")),
        (100.0, 1e-4, include_str!("../../assets/reference/chain-100.csv")),
        (1e3, 5e-5, include_str!("../../assets/reference/chain-1000.csv")),
        (1e6, 1e-5, include_str!("../../assets/reference/chain-1000000.csv")),
    ] {
        // A ball of radius 1 m held at its surface.
        let ball = Link { mass, inertia: 0.4 * mass, center: 1.0, length: 0.0 };
        let mut links = vec![rod(0.2); 10];
        links.push(ball);
        agree(&format!("chain {mass}"), &PlanarChain::new(&links, 10.0, 1.0), step, text);
    }
}

/// The symmetric top in Euler's angles: tilt α, azimuth φ, with the momenta about the vertical and
/// the axis constant (Landau and Lifshitz, Mechanics, §35, problem 1).
#[test]
fn the_heavy_top_follows_eulers_angles() {
    let (radius, height): (f64, f64) = (0.4, 0.6);
    let (axial, transverse) = (0.3 * radius * radius, 0.6 * (height * height + 0.25 * radius * radius));
    let (torque, spin) = (9.81 * 0.75 * height, 60.0);
    let scene = scene("heavy_top", &[]);
    let top = &scene.bodies[1];
    let start_axis = top.position.normalize();
    let tilt = 30_f64.to_radians();
    // φ̇ as the scene starts: what of ω is across the axis.
    let rate = (top.angular_velocity - top.angular_velocity.dot(start_axis) * start_axis).length() / tilt.sin();
    let vertical_momentum = transverse * tilt.sin().powi(2) * rate + axial * spin * tilt.cos();
    let azimuth_rate = |tilt: f64| (vertical_momentum - axial * spin * tilt.cos()) / (transverse * tilt.sin().powi(2));
    let slope = |state: &DVector<f64>| {
        let (tilt, turning) = (state[0], azimuth_rate(state[0]));
        let (sin, cos) = tilt.sin_cos();
        let fall = turning * turning * sin * cos + (torque * sin - axial * spin * turning * sin) / transverse;
        DVector::from_vec(vec![state[2], turning, fall])
    };
    let step = 1e-4;
    let mut state = DVector::from_vec(vec![tilt, 0.0, 0.0]);
    let mut now = 0.0;
    let body_axis = top.rotation.inverse() * start_axis;
    let truth = follow(&scene, (0..=100).map(|n| 0.1 * f64::from(n)), |time, bodies| {
        while now < time - 0.5 * step {
            runge_kutta(&mut state, step, slope);
            now += step;
        }
        // The scene's axis starts toward +x; the azimuth turns from +x toward −z, about +y.
        let axis = DQuat::from_rotation_y(state[1]) * DQuat::from_rotation_z(-state[0]) * DVec3::Y;
        let rotation = DQuat::from_rotation_arc(body_axis, axis);
        let turning = azimuth_rate(state[0]);
        let angular =
            turning * DVec3::Y + (spin - turning * state[0].cos()) * axis + state[2] * DVec3::Y.cross(axis).normalize();
        let position = top.position.length() * axis;
        bodies[1] = BodyState { position, rotation, linear: angular.cross(position), angular };
    });
    assert!(truth.error().unwrap() < 1e-9, "axis {:e}", truth.error().unwrap());
    let further = |place: usize| truth.further[place].error().unwrap();
    assert!(further(0) < 1e-9, "azimuth {:e}", further(0));
    // Angular momentum is kept, whatever the motion: to rounding.
    assert!(further(1) < 1e-12 && further(2) < 1e-12, "{:e} {:e}", further(1), further(2));
}

/// What the further truths of the heavy top are for: a top that spins up is on its way all the same.
#[test]
fn a_heavy_top_that_gains_spin_shows_in_its_momentum() {
    let scene = scene("heavy_top", &[]);
    let axis = scene.bodies[1].position.normalize();
    let truth = follow(&scene, [0.0, 0.0].into_iter(), |_, bodies| bodies[1].angular += 0.6 * axis);
    assert!(truth.error().unwrap() < 1e-12);
    // Nearly all its momentum is spin: a hundredth more.
    for place in [1, 2] {
        let drift = truth.further[place].error().unwrap();
        assert!((0.006..0.011).contains(&drift), "{drift}");
    }
}

/// Gravity, a floor and restitution in steps of 10 µs, landings found by bisection.
#[test]
fn bounces_are_those_of_a_ball_dropped_in_small_steps() {
    for (e, height) in [(0.5, 5.0), (0.8, 2.0), (1.0, 5.0)] {
        let scene = scene("bounce", &[("e", e), ("height", height)]);
        let (mut y, mut speed, mut now) = (height, 0.0, 0.0);
        let g = 9.81;
        let truth = follow(&scene, (0..=500).map(|n| 0.01 * f64::from(n)), |time, bodies| {
            while time - now > 1e-12 {
                let step = (time - now).min(1e-5);
                let fallen = |step: f64| y + speed * step - 0.5 * g * step * step;
                if fallen(step) >= 0.1 {
                    (y, speed) = (fallen(step), speed - g * step);
                    now += step;
                    continue;
                }
                let (mut above, mut below) = (0.0, step);
                for _ in 0..60 {
                    let middle = 0.5 * (above + below);
                    if fallen(middle) >= 0.1 { above = middle } else { below = middle }
                }
                (y, speed) = (0.1, -e * (speed - g * above));
                // A bounce this low is over within the step.
                if speed < 1e-4 {
                    (speed, above) = (0.0, step);
                    y = 0.1 + 1e-15;
                }
                now += above.max(1e-15);
                if speed == 0.0 {
                    now = time;
                }
            }
            bodies[1..].iter_mut().for_each(|ball| ball.position.y = y);
        });
        assert!(truth.error().unwrap() < 1e-7, "e = {e}: {:e}", truth.error().unwrap());
    }
}

/// A box under gravity, the ground's push and friction that opposes its slip, in small steps.
#[test]
fn a_box_on_a_slope_does_what_coulombs_law_makes_of_it() {
    for (theta, mu) in [(30.0_f64, 0.4), (45.0, 0.1), (20.0, 0.4)] {
        let scene = scene("incline", &[("theta", theta), ("mu", mu)]);
        let (sin, cos) = theta.to_radians().sin_cos();
        let (mut x, mut speed, mut now, step) = (0.0, 0.0_f64, 0.0, 1e-5);
        let truth = follow(&scene, (0..=20).map(|n| 0.1 * f64::from(n)), |time, bodies| {
            while now < time - 0.5 * step {
                let drive = 9.81 * sin;
                let most = mu * 9.81 * cos;
                let friction = if speed == 0.0 { -drive.clamp(-most, most) } else { -most * speed.signum() };
                let gained = step * (drive + friction);
                x += step * (speed + 0.5 * gained);
                speed += gained;
                now += step;
            }
            bodies[1].position.x = x;
        });
        assert!(truth.error().unwrap() < 1e-9, "{theta}°, {mu}: {:e}", truth.error().unwrap());
    }
}

/// A ball whose rim slips over the ground, in small steps of force and torque.
#[test]
fn a_thrown_ball_rolls_when_its_rim_has_stopped_slipping() {
    let scene = scene("slide_roll", &[]);
    let (mass, radius, mu, g) = (7.0, 0.5, 0.3, 9.81);
    let inertia = 0.4 * mass * radius * radius;
    let (mut speed, mut spin, mut now, step) = (5.0, 0.0, 0.0, 1e-6);
    let truth = follow(&scene, (0..=20).map(|n| 0.1 * f64::from(n)), |time, bodies| {
        while now < time - 0.5 * step {
            let slip: f64 = speed - radius * spin;
            // No more than stops the slip within the step.
            let stopping = slip / (step * (1.0 / mass + radius * radius / inertia));
            let friction = stopping.clamp(-mu * mass * g, mu * mass * g);
            speed -= step * friction / mass;
            spin += step * friction * radius / inertia;
            now += step;
        }
        bodies[1].linear = speed * DVec3::X;
        bodies[1].angular = -spin * DVec3::Z;
    });
    // It goes over to rolling within a step: μ g h.
    assert!(truth.error().unwrap() < 1e-5, "{:e}", truth.error().unwrap());
}

/// A slab and the balls on it: forces between them such that the balls' rims follow the slab.
#[test]
fn a_slab_and_its_balls_gain_what_newton_and_euler_say() {
    let scene = scene("rolling", &[]);
    let (slab, ball, balls, radius, push, g) = (10.0, 1.0, 25.0, 0.5, 150.0, 9.81);
    let inertia = 0.4 * ball * radius * radius;
    // Unknown: the slab's gain a, a ball's gain b, its spin's gain s, the force f on a ball.
    // 10 a + 25 f = 150 − 0.4 · 35 g;  b = f;  I s = f r;  a = b + r s.
    #[rustfmt::skip]
    let equations = DMatrix::from_row_slice(4, 4, &[
        slab, 0.0, 0.0, balls,
        0.0, ball, 0.0, -1.0,
        0.0, 0.0, inertia, -radius,
        1.0, -1.0, -radius, 0.0,
    ]);
    let drive = push - 0.4 * (slab + balls * ball) * g;
    let gains = equations.lu().solve(&DVector::from_vec(vec![drive, 0.0, 0.0, 0.0])).unwrap();
    let truth = follow(&scene, (0..=40).map(|n| 0.1 * f64::from(n)), |time, bodies| {
        bodies[1].linear = gains[0] * time * DVec3::X;
        bodies[2..].iter_mut().for_each(|body| body.linear = gains[1] * time * DVec3::X);
    });
    assert!(truth.error().unwrap() < 1e-24, "{:e}", truth.error().unwrap());
}
