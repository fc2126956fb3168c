//! What a run did, from the bodies' states alone: the same code for every engine.

use bevy::math::DVec3;
use plumb::lab::truth::{self, EnergyScale, Truth};
use plumb::lab::{BodyState, Sample};
use plumb::physics::SolverSettings;
use plumb::scene::JointKindSpec;

use crate::load::Tree;
use crate::scene::Scene;

/// How far off a run was.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// Distance from the scene's answer, where it is known.
    pub answer: Option<Answer>,
    /// Distance of the tip or ball from the reference trajectory when one second had passed, m.
    pub error_at_1_s: Option<f64>,
    /// Largest distance of the two anchors of a joint from where it holds them, after any step, m.
    pub joint_separation: Option<f64>,
    /// The same after the last step alone, m.
    pub joint_separation_end: Option<f64>,
    /// Largest angle between the axes that a hinge joins after any step, rad.
    pub hinge_tilt: Option<f64>,
    /// Largest angle by which a joint was beyond its limits after any step, rad.
    pub limit_overshoot: Option<f64>,
    /// Largest error of a motor's torque over a step, N·m, where the scene's answer has torques.
    pub torque_error: Option<f64>,
    /// Largest fall of a body below its start after any step, m.
    pub sink: f64,
    /// The same after the last step alone, m.
    pub sink_end: f64,
    /// Largest horizontal move of a body from its start after any step, m.
    pub drift: f64,
    /// (E − E₀)/S at the end; none for a scene that stays put.
    pub energy_change: Option<f64>,
    /// Largest |E − E₀|/S over the run.
    pub energy_drift: Option<f64>,
}

/// Distance from a scene's answer, as `plumb run` says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// What was compared.
    pub name: &'static str,
    /// How far off it was.
    pub error: f64,
    /// In this unit.
    pub unit: &'static str,
}

/// Watches a run and sums it up.
pub struct Meter<'a> {
    scene: &'a Scene,
    start: Vec<BodyState>,
    truth: Option<Truth>,
    tilt: Option<Truth>,
    overshoot: Option<Truth>,
    /// Of what loads are worked out, with the states and the time after the step before.
    carried: Option<Carried>,
    point_at_1_s: Option<(Tracked, DVec3)>,
    error_at_1_s: Option<f64>,
    energy_start: f64,
    energy_end: f64,
    energy_strays: f64,
    kinetic_max: f64,
    joint_separation: Extreme,
    sink: Extreme,
    drift: Extreme,
    finite: bool,
}

/// What the loads of joints are worked out from.
struct Carried {
    tree: Tree,
    before: Vec<BodyState>,
    time: f64,
}

impl<'a> Meter<'a> {
    /// Starts from the states before the first step.
    pub fn new(scene: &'a Scene, start: &[BodyState]) -> Self {
        // The answer of `far` is a run of the same engine at the origin, which only Plumb can make.
        let known = scene.name() != "far";
        let truth = known.then(|| truth::of(&scene.spec, &SolverSettings::default())).flatten();
        let reads_loads = truth.as_ref().is_some_and(|truth| truth.reads_loads);
        let tree = reads_loads.then(|| Tree::of(scene)).flatten();
        let has_hinges = scene.joints.iter().any(|joint| joint.kind == JointKindSpec::Hinge);
        let mut meter = Self {
            scene,
            start: start.to_vec(),
            truth,
            tilt: has_hinges.then(|| truth::hinge_tilt(&scene.spec)),
            overshoot: truth::limit_overshoot(&scene.spec),
            carried: tree.map(|tree| Carried { tree, before: start.to_vec(), time: 0.0 }),
            point_at_1_s: point_at_1_s(scene),
            error_at_1_s: None,
            energy_start: 0.0,
            energy_end: 0.0,
            energy_strays: 0.0,
            kinetic_max: 0.0,
            joint_separation: Extreme::default(),
            sink: Extreme::default(),
            drift: Extreme::default(),
            finite: true,
        };
        meter.observe_truths(&Sample { step: 0, time: 0.0, bodies: start, loads: &[] });
        let (kinetic, potential) = meter.energy(start);
        meter.energy_start = kinetic + potential;
        meter.kinetic_max = kinetic;
        meter
    }

    /// Takes in the state after a step.
    pub fn observe(&mut self, step: u64, time: f64, states: &[BodyState]) {
        self.finite &= states.iter().all(|state| {
            let BodyState { position, rotation, linear, angular } = state;
            position.is_finite() && rotation.is_finite() && linear.is_finite() && angular.is_finite()
        });
        let (kinetic, potential) = self.energy(states);
        self.energy_end = kinetic + potential;
        self.energy_strays = self.energy_strays.max((self.energy_end - self.energy_start).abs());
        self.kinetic_max = self.kinetic_max.max(kinetic);
        self.joint_separation.take(self.scene.joints.iter().map(|joint| joint.separation(states)));
        let moved = || states.iter().zip(&self.start).map(|(state, start)| state.position - start.position);
        self.sink.take(moved().map(|moved| -moved.y));
        self.drift.take(moved().map(|moved| moved.x.hypot(moved.z)));
        let loads = self.carried.as_mut().map_or_else(Vec::new, |carried| {
            let loads = carried.tree.loads(self.scene, [&carried.before, states], time - carried.time);
            (carried.before, carried.time) = (states.to_vec(), time);
            loads
        });
        self.observe_truths(&Sample { step, time, bodies: states, loads: &loads });
        if let Some((tracked, point)) = self.point_at_1_s.filter(|_| (time - 1.0).abs() < 1e-9) {
            self.error_at_1_s = Some(tracked.of(states).distance(point));
        }
    }

    fn observe_truths(&mut self, sample: &Sample) {
        let truths = [&mut self.truth, &mut self.tilt, &mut self.overshoot];
        truths.into_iter().flatten().for_each(|truth| truth.observe(sample));
    }

    /// Kinetic energy, and potential energy relative to the start, J.
    fn energy(&self, states: &[BodyState]) -> (f64, f64) {
        let bodies = self.scene.bodies.iter().zip(states.iter().zip(&self.start));
        bodies.fold((0.0, 0.0), |(kinetic, potential), (body, (state, start))| {
            let Some(mass) = body.mass else { return (kinetic, potential) };
            let spin = state.rotation.inverse() * state.angular;
            let weight = mass.mass * body.gravity_scale * self.scene.spec.gravity;
            (
                kinetic + 0.5 * (mass.mass * state.linear.length_squared() + (mass.inertia * spin).dot(spin)),
                potential - weight.dot(state.position - start.position),
            )
        })
    }

    /// What is known of the run; none if a state was not finite.
    pub fn metrics(&self) -> Option<Metrics> {
        let answer = |truth: &Truth| Some(Answer { name: truth.name, error: truth.error()?, unit: truth.unit });
        let relative = |joules: f64| Some(joules / self.energy_scale()?);
        let joints = !self.scene.joints.is_empty();
        self.finite.then(|| Metrics {
            answer: self.truth.as_ref().and_then(answer),
            error_at_1_s: self.error_at_1_s,
            joint_separation: joints.then_some(self.joint_separation.worst),
            joint_separation_end: joints.then_some(self.joint_separation.last),
            hinge_tilt: self.tilt.as_ref().and_then(Truth::error),
            limit_overshoot: self.overshoot.as_ref().and_then(Truth::error),
            torque_error: self.torque_error(),
            sink: self.sink.worst,
            sink_end: self.sink.last,
            drift: self.drift.worst,
            energy_change: relative(self.energy_end - self.energy_start),
            energy_drift: relative(self.energy_strays),
        })
    }

    fn torque_error(&self) -> Option<f64> {
        let further = self.truth.as_ref().map_or(&[][..], |truth| &truth.further);
        further.iter().find(|truth| truth.reads_loads && truth.unit == "N·m")?.error()
    }

    /// The scene's largest kinetic energy; none for a scene that stays put, or in which motors do work.
    fn energy_scale(&self) -> Option<f64> {
        let scale = match self.truth.as_ref().map_or(EnergyScale::LargestKinetic, |truth| truth.energy_scale) {
            EnergyScale::Known(joules) => joules,
            EnergyScale::LargestKinetic => self.kinetic_max,
            EnergyScale::WeightTimesHeight | EnergyScale::NotKept => 0.0,
        };
        Some(scale).filter(|scale| *scale > 0.0)
    }
}

/// The largest of some numbers, after any step and after the last one; at least 0.
#[derive(Clone, Copy, Debug, Default)]
struct Extreme {
    worst: f64,
    last: f64,
}

impl Extreme {
    fn take(&mut self, values: impl Iterator<Item = f64>) {
        self.last = values.fold(0.0, f64::max);
        self.worst = self.worst.max(self.last);
    }
}

/// A point fixed to a body, from its centre of mass in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tracked {
    body: usize,
    point: DVec3,
}

impl Tracked {
    fn of(self, states: &[BodyState]) -> DVec3 {
        let BodyState { position, rotation, .. } = states[self.body];
        position + rotation * self.point
    }
}

/// The reference trajectories with columns `t_s,x_m,y_m,z_m,uncertainty_m`.
const TRAJECTORIES: [(&str, f64, &str); 7] = [
    ("rods", 1.0, include_str!("../../assets/reference/rods-1.csv")),
    ("rods", 2.0, include_str!("../../assets/reference/rods-2.csv")),
    ("rods", 5.0, include_str!("../../assets/reference/rods-5.csv")),
    ("chain", 1.0, include_str!("../../assets/reference/chain-1.csv")),
    ("chain", 100.0, include_str!("../../assets/reference/chain-100.csv")),
    ("chain", 1000.0, include_str!("../../assets/reference/chain-1000.csv")),
    ("chain", 1e6, include_str!("../../assets/reference/chain-1000000.csv")),
];

/// Where the far end of the last rod, or the centre of the ball, is after one second.
fn point_at_1_s(scene: &Scene) -> Option<(Tracked, DVec3)> {
    let parameter = scene.parameters.first()?.1;
    let is_this = |&&(name, value, _): &&(&str, f64, &str)| name == scene.name() && value == parameter;
    let table = TRAJECTORIES.iter().find(is_this)?.2;
    let row = table.lines().find(|line| line.starts_with("1.0,"))?;
    let numbers: Vec<f64> = row.split(',').filter_map(|field| field.parse().ok()).collect();
    let last = scene.joints.last()?;
    let point = if scene.name() == "rods" { -last.anchor_b } else { DVec3::ZERO };
    Some((Tracked { body: last.b, point }, DVec3::new(*numbers.get(1)?, *numbers.get(2)?, *numbers.get(3)?)))
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;

    use super::*;
    use crate::scene::Body;

    fn start(scene: &Scene) -> Vec<BodyState> {
        let state = |body: &Body| BodyState {
            position: body.position,
            rotation: body.rotation,
            linear: body.velocity.linear,
            angular: body.velocity.angular,
        };
        scene.bodies.iter().map(state).collect()
    }

    #[test]
    fn the_end_of_the_last_rod_is_compared_after_one_second() {
        let scene = Scene::parse("rods 5").unwrap();
        let mut states = start(&scene);
        let (tracked, point) = point_at_1_s(&scene).unwrap();
        // Released horizontal, 5 m long: at 1 s its end is within its length.
        assert!(tracked.of(&states).distance(DVec3::new(5.0, 0.0, 0.0)) < 1e-12);
        assert!(point.length() < 5.0 && point.y < -1.0);
        let mut meter = Meter::new(&scene, &states);
        let off = point - tracked.of(&states) + DVec3::new(0.0, 0.0, 0.25);
        states[5].position += off;
        meter.observe(59, 59.0 / 60.0, &states);
        assert_eq!(meter.metrics().unwrap().error_at_1_s, None);
        meter.observe(60, 1.0, &states);
        let metrics = meter.metrics().unwrap();
        assert!((metrics.error_at_1_s.unwrap() - 0.25).abs() < 1e-12);
        // The scene's own answer was off by more on the way there.
        assert!(metrics.answer.is_some_and(|answer| answer.unit == "m" && answer.error > 1.0));
    }

    #[test]
    fn separation_is_between_turned_anchors() {
        let scene = Scene::parse("rods 1").unwrap();
        let mut states = start(&scene);
        assert!(scene.joints[0].separation(&states) < 1e-12);
        let mut meter = Meter::new(&scene, &states);
        // The rod turned by 90° about its middle: its end is ½√2 m away.
        states[1].rotation = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        meter.observe(1, 0.1, &states);
        meter.observe(2, 0.2, &start(&scene));
        let metrics = meter.metrics().unwrap();
        assert!((metrics.joint_separation.unwrap() - 0.5f64.sqrt()).abs() < 1e-12);
        assert!(metrics.joint_separation_end.unwrap() < 1e-12);
    }

    #[test]
    fn a_hinge_that_leans_tilts_and_one_turned_too_far_is_beyond_its_limit() {
        let scene = Scene::parse("hinge_chain 1 1 45").unwrap();
        let states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        let mut turned = |axis: DVec3, angle: f64| {
            let mut states = states.clone();
            states[2].rotation = DQuat::from_axis_angle(axis, angle);
            meter.observe(1, 0.1, &states);
            let metrics = meter.metrics().unwrap();
            (metrics.hinge_tilt.unwrap(), metrics.limit_overshoot.unwrap())
        };
        let (tilt, overshoot) = turned(DVec3::Z, 0.5);
        assert!(tilt < 1e-12 && overshoot == 0.0);
        let (tilt, overshoot) = turned(DVec3::X, 0.1);
        assert!((tilt - 0.1).abs() < 1e-12 && overshoot == 0.0);
        let (_, overshoot) = turned(DVec3::NEG_Z, 1.0);
        assert!((overshoot - (1.0 - 45f64.to_radians())).abs() < 1e-12);
    }

    #[test]
    fn an_arm_that_stands_still_lacks_torque() {
        let scene = Scene::parse("arm").unwrap();
        let states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        for step in 1..=60 {
            meter.observe(step, step as f64 / 60.0, &states);
        }
        let metrics = meter.metrics().unwrap();
        assert!(metrics.torque_error.unwrap() > 1.0 && metrics.energy_drift.is_none());
        assert!(metrics.hinge_tilt.unwrap() < 1e-12 && metrics.limit_overshoot.is_none());
    }

    #[test]
    fn energy_is_kinetic_and_potential_relative_to_the_truths_scale() {
        let scene = Scene::parse("top").unwrap();
        let mut states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        states[0].angular *= 0.5f64.sqrt();
        meter.observe(1, 1.0, &states);
        assert!((meter.metrics().unwrap().energy_change.unwrap() + 0.5).abs() < 1e-9);
        states[0].angular *= 2.0f64.sqrt();
        meter.observe(2, 2.0, &states);
        let metrics = meter.metrics().unwrap();
        assert!(metrics.energy_change.unwrap().abs() < 1e-9 && (metrics.energy_drift.unwrap() - 0.5).abs() < 1e-9);

        // A rod of 1 kg 1 m lower has lost 10 J, which its kinetic energy of 10 J makes up for.
        let scene = Scene::parse("rods 3").unwrap();
        let mut states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        states[1].position.y -= 1.0;
        states[1].linear.x = 20.0f64.sqrt();
        meter.observe(1, 0.1, &states);
        assert!(meter.metrics().unwrap().energy_drift.unwrap() < 1e-12);
    }

    #[test]
    fn falling_and_moving_aside_are_told_apart() {
        let scene = Scene::parse("stack 2").unwrap();
        let mut states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        states[1].position += DVec3::new(0.03, 1.0, -0.04);
        states[2].position.y -= 0.5;
        meter.observe(1, 0.1, &states);
        states[2].position.y += 0.25;
        meter.observe(2, 0.2, &states);
        let metrics = meter.metrics().unwrap();
        assert!((metrics.sink_end - 0.25).abs() < 1e-12);
        assert!((metrics.sink - 0.5).abs() < 1e-12 && (metrics.drift - 0.05).abs() < 1e-12);
        assert_eq!((metrics.energy_change, metrics.joint_separation), (None, None));
    }

    #[test]
    fn what_is_not_finite_has_no_metrics() {
        let scene = Scene::parse("stack 1").unwrap();
        let mut states = start(&scene);
        let mut meter = Meter::new(&scene, &states);
        states[1].angular.x = f64::NAN;
        meter.observe(1, 0.1, &states);
        meter.observe(2, 0.2, &start(&scene));
        assert_eq!(meter.metrics(), None);
    }
}
