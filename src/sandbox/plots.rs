//! Live plots of energy, errors and cost over the last ten seconds of simulation time.

use std::collections::VecDeque;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;
use egui_plot::{HoverPosition, Line, Plot, PlotPoints};

use super::CurrentScene;
use super::any_joint::{IsJoint, WholeJoint, noun};
use super::axes::{color32, fifth_seconds, mark_text, round_marks, still};
use super::ghost::{self, Apart, GhostReading, GhostReadings, MOST_GHOSTS};
use super::joint_readings::ReadJoints;
use super::panel::{Quantity, name_of, palette};
use super::probe::offer;
use super::timeline::{change_places, is_another_future};
use crate::physics::{Diagnostics, JointAxis, PhysicsSchedule, PhysicsSystems, Position, Rotation, StepStats};
use crate::scene::{Probe, ProbePlot, ProbeSubject, Probes};

/// Simulation time on view, s.
const WINDOW: f64 = 10.0;
/// Most samples kept. Steps that come faster are merged into one sample.
const CAPACITY: usize = 1200;

/// Rows of plots are as high as this at least, plots too, and what a caption takes of the height, points.
const ROW: f32 = 124.0;
const LOWEST: f32 = 40.0;
const CAPTION: f32 = 38.0;

/// Whether somebody sees the plots. [`Diagnostics`] are measured only while this holds.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Watched(pub bool);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Watched>()
        .init_resource::<History>()
        .add_systems(
            PreUpdate,
            (begin_with_scene, switch_diagnostics, forget_other_joint, forget_ahead.run_if(is_another_future)),
        )
        .add_systems(PhysicsSchedule, record.after(PhysicsSystems::Diagnose).after(ghost::follow));
}

/// What is plotted of one step, or of several that came close together.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    /// Simulation time since the scene started, s.
    time: f64,
    /// J.
    kinetic: f64,
    /// J.
    potential: f64,
    /// m.
    joint_error: f64,
    /// m.
    penetration: f64,
    /// s.
    step_seconds: f64,
    /// Of each ghost, 0 where there is none.
    ghosts: [Apart; MOST_GHOSTS],
    joint: JointSample,
}

/// What is plotted of a joint, where one is: not a number else.
#[derive(Clone, Copy, Debug, PartialEq)]
struct JointSample {
    /// N.
    force: f64,
    /// N·m.
    torque: f64,
    /// Where it stands along its axis, rad or m.
    value: f64,
}

impl JointSample {
    const NONE: Self = Self { force: f64::NAN, torque: f64::NAN, value: f64::NAN };
}

impl Sample {
    /// The newer state, and the larger of each error and cost, so that no peak is lost.
    fn merge(&mut self, newer: Self) {
        *self = Self {
            time: self.time,
            joint_error: self.joint_error.max(newer.joint_error),
            penetration: self.penetration.max(newer.penetration),
            step_seconds: self.step_seconds.max(newer.step_seconds),
            ghosts: std::array::from_fn(|place| {
                let (one, other) = (self.ghosts[place], newer.ghosts[place]);
                Apart { distance: one.distance.max(other.distance), angle: one.angle.max(other.angle) }
            }),
            joint: JointSample {
                force: self.joint.force.max(newer.joint.force),
                torque: self.joint.torque.max(newer.joint.torque),
                ..newer.joint
            },
            ..newer
        };
    }
}

/// The samples of the last [`WINDOW`] seconds.
#[derive(Resource, Default)]
pub(super) struct History {
    samples: VecDeque<Sample>,
    /// Those after the moment that the scene has gone back to, the next last.
    ahead: Vec<Sample>,
    /// Potential energy of the first sample since the scene was loaded: where its plot has 0.
    potential_at_start: Option<f64>,
    /// When the scene started, s, by the world's clock, which runs on when a scene is replaced.
    start: f64,
}

impl History {
    /// Takes in a sample timed by the world's clock.
    fn push(&mut self, sample: Sample) {
        if sample.time < self.start {
            // That clock itself was put back.
            self.begin(0.0);
        }
        let sample = Sample { time: sample.time - self.start, ..sample };
        // The scene went back: what came later is not there until it comes to it again.
        change_places(&mut self.samples, &mut self.ahead, |known| known.time < sample.time);
        // What is read anew takes the place of what was known.
        self.ahead.pop_if(|known| known.time == sample.time);
        self.potential_at_start.get_or_insert(sample.potential);
        // Short of the spacing by a rounding error is not short of it.
        let spacing = WINDOW / CAPACITY as f64 * (1.0 - 1e-6);
        if let Some(last) = self.samples.back_mut().filter(|last| sample.time - last.time < spacing) {
            last.merge(sample);
            return;
        }
        while self.samples.len() >= CAPACITY
            || self.samples.front().is_some_and(|oldest| oldest.time < sample.time - WINDOW)
        {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    fn clear(&mut self) {
        self.begin(self.start);
    }

    /// Forgets all, and counts time from this one on.
    fn begin(&mut self, start: f64) {
        *self = Self { start, ..default() };
    }

    /// Largest magnitude of a plotted value.
    fn largest(&self, value: impl Fn(&Sample) -> f64) -> f64 {
        self.samples.iter().map(|sample| value(sample).abs()).filter(|size| size.is_finite()).fold(0.0, f64::max)
    }
}

/// The joint that is plotted.
#[derive(SystemParam)]
struct PlottedJoint<'w, 's> {
    read: Res<'w, ReadJoints>,
    joints: Query<'w, 's, WholeJoint, IsJoint>,
    poses: Query<'w, 's, (&'static Position, &'static Rotation)>,
}

impl PlottedJoint<'_, '_> {
    fn sample(&self) -> JointSample {
        let Some(joint) = self.read.plotted.and_then(|joint| self.joints.get(joint).ok()) else {
            return JointSample::NONE;
        };
        let poses = joint.joint.component().and_then(|joint| self.poses.get_many(joint.bodies()).ok());
        let value = poses.and_then(|poses| joint.value(poses.map(|(position, rotation)| (position.0, rotation.0))));
        JointSample {
            force: joint.load.map_or(f64::NAN, |load| load.force.length()),
            torque: joint.load.map_or(f64::NAN, |load| load.torque.length()),
            value: value.unwrap_or(f64::NAN),
        }
    }
}

/// Runs in the step itself: one sample per step, however many there are in a frame.
fn record(
    stats: Res<StepStats>,
    diagnostics: Option<Res<Diagnostics>>,
    ghosts: Res<GhostReadings>,
    joint: PlottedJoint,
    mut history: ResMut<History>,
) {
    if let Some(diagnostics) = diagnostics {
        history.push(Sample {
            time: stats.time,
            kinetic: diagnostics.kinetic_energy,
            potential: diagnostics.potential_energy,
            joint_error: diagnostics.joint_error,
            penetration: diagnostics.penetration,
            step_seconds: stats.step_seconds,
            ghosts: std::array::from_fn(|place| {
                ghosts.ghosts.get(place).map_or_else(Apart::default, |ghost| ghost.apart)
            }),
            joint: joint.sample(),
        });
    }
}

/// What was plotted of another joint is not this one's.
fn forget_other_joint(read: Res<ReadJoints>, mut last: Local<Option<Entity>>, mut history: ResMut<History>) {
    if read.plotted != *last {
        *last = read.plotted;
        let History { samples, ahead, .. } = &mut *history;
        samples.iter_mut().chain(ahead).for_each(|sample| sample.joint = JointSample::NONE);
    }
}

/// Forgets what was set aside.
fn forget_ahead(mut history: ResMut<History>) {
    history.ahead.clear();
}

/// At a new scene or a reset.
fn begin_with_scene(scene: Option<Res<CurrentScene>>, stats: Res<StepStats>, mut history: ResMut<History>) {
    if scene.is_some_and(|scene| scene.is_changed()) {
        history.begin(stats.time);
    }
}

/// Nothing is measured that nobody looks at; and a plot with a gap in it would lie.
fn switch_diagnostics(mut commands: Commands, watched: Res<Watched>, mut history: ResMut<History>) {
    if !watched.is_changed() {
        return;
    }
    history.clear();
    if watched.0 {
        commands.init_resource::<Diagnostics>();
    } else {
        commands.remove_resource::<Diagnostics>();
    }
}

/// One curve: its name, color and value in the plain unit.
type Curve<'a> = (&'a str, [u8; 3], &'a dyn Fn(&Sample) -> f64);

/// What one plot shows.
struct Chart<'a> {
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    curves: &'a [Curve<'a>],
    /// What a right click on its title offers to plot.
    offered: Vec<Probe<Entity, Entity>>,
}

/// The plots beside each other, in as many rows as it takes.
pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    history: Res<History>,
    ghosts: Res<GhostReadings>,
    read: Res<ReadJoints>,
    joints: Query<WholeJoint>,
    names: Query<&Name>,
    mut probes: ResMut<Probes>,
) {
    let start = history.potential_at_start.unwrap_or_default();
    let potential = |sample: &Sample| sample.potential - start;
    let total = |sample: &Sample| sample.kinetic + potential(sample);
    let charts = [
        Chart {
            title: "energy",
            unit: "J",
            about: "kinetic, potential (0 at the first sample) and their sum",
            curves: &[
                ("kinetic", palette::SKY, &|sample| sample.kinetic),
                ("potential", palette::ORANGE, &potential),
                ("total", [240; 3], &total),
            ],
            offered: of_scene(&[ProbePlot::KineticEnergy, ProbePlot::PotentialEnergy, ProbePlot::Energy]),
        },
        Chart {
            title: "error",
            unit: "m",
            about: "largest distance between the two points of a joint, and largest depth of a contact",
            curves: &[
                ("joint", palette::PURPLE, &|sample| sample.joint_error),
                ("contact", palette::YELLOW, &|sample| sample.penetration),
            ],
            offered: of_scene(&[ProbePlot::Gap, ProbePlot::Overlap]),
        },
        Chart {
            title: "step time",
            unit: "s",
            about: "wall-clock time of a step",
            curves: &[("step", palette::GREEN, &|sample| sample.step_seconds)],
            offered: of_scene(&[ProbePlot::StepTime]),
        },
    ];
    let distances = std::array::from_fn(|place| move |sample: &Sample| sample.ghosts[place].distance);
    let angles = std::array::from_fn(|place| move |sample: &Sample| sample.ghosts[place].angle.to_degrees());
    let (distances, angles) = (curves_of(&ghosts.ghosts, &distances), curves_of(&ghosts.ghosts, &angles));
    let of_ghosts = [
        Chart {
            title: "ghosts",
            unit: "m",
            about: "largest distance between a body and its ghost: of the point of it that is farthest from its place",
            curves: &distances,
            offered: Vec::new(),
        },
        Chart {
            title: "turned",
            unit: "°",
            about: "largest angle between a body and its ghost",
            curves: &angles,
            offered: Vec::new(),
        },
    ];
    let plotted = read.plotted.and_then(|joint| joints.get(joint).ok());
    let of_joint = plotted.iter().zip(read.plotted).flat_map(|(joint, entity)| joint_charts(joint.axis(), entity));
    let has_ghosts = !ghosts.ghosts.is_empty();
    let charts: Vec<_> = of_joint.chain(of_ghosts.into_iter().filter(|_| has_ghosts)).chain(charts).collect();
    if let Some(component) = plotted.and_then(|joint| joint.joint.component()) {
        let [a, b] = component.bodies().map(|body| name_of(names.get(body).ok(), body));
        ui.weak(format!("{} of {a} and {b}", noun(&component)))
            .on_hover_text("the joint that is plotted: tick it off in the list");
    }
    let rows = ((ui.available_height() / ROW) as usize).clamp(1, charts.len());
    let columns = charts.len().div_ceil(rows);
    let rows = charts.len().div_ceil(columns);
    let height = (ui.available_height() / rows as f32 - CAPTION).max(LOWEST);
    for row in charts.chunks(columns) {
        ui.columns(columns, |columns| {
            for (column, chart) in columns.iter_mut().zip(row) {
                chart.draw(column, height, &history, &mut probes);
            }
        });
    }
}

fn of_scene(plots: &[ProbePlot]) -> Vec<Probe<Entity, Entity>> {
    plots.iter().map(|plot| Probe::Plot(ProbeSubject::Scene, *plot)).collect()
}

/// A curve for each ghost.
fn curves_of<'a, F: Fn(&Sample) -> f64>(ghosts: &'a [GhostReading], values: &'a [F; MOST_GHOSTS]) -> Vec<Curve<'a>> {
    let curve = |(ghost, value): (&'a GhostReading, &'a F)| -> Curve { (ghost.short_name(), ghost.color, value) };
    ghosts.iter().zip(values).map(curve).collect()
}

/// The load of the plotted joint, and where it stands along its axis if it has one.
fn joint_charts<'a>(axis: Option<JointAxis>, joint: Entity) -> impl Iterator<Item = Chart<'a>> {
    let offered = move |plot| vec![Probe::Plot(ProbeSubject::Joint(joint), plot)];
    let force = Chart {
        title: "joint force",
        unit: "N",
        about: "what the plotted joint carries",
        curves: &[("force", palette::VERMILION, &|sample| sample.joint.force)],
        offered: offered(ProbePlot::Force),
    };
    let torque = Chart {
        title: "joint torque",
        unit: "N·m",
        about: "the torque about its point that the plotted joint carries",
        curves: &[("torque", palette::ORANGE, &|sample| sample.joint.torque)],
        offered: offered(ProbePlot::Torque),
    };
    let about = "where the plotted joint stands along its axis";
    let stands = axis.map(move |axis| match axis.is_angle() {
        // In degrees, as the list has it.
        true => Chart {
            title: "joint angle",
            unit: "°",
            about,
            curves: &[("stands at", palette::SKY, &|sample| sample.joint.value.to_degrees())],
            offered: offered(ProbePlot::Coordinate),
        },
        false => Chart {
            title: "joint distance",
            unit: "m",
            about,
            curves: &[("stands at", palette::SKY, &|sample| sample.joint.value)],
            offered: offered(ProbePlot::Coordinate),
        },
    });
    [force, torque].into_iter().chain(stands)
}

impl Chart<'_> {
    /// A caption that is the legend too, with the newest values, and the curves below.
    fn draw(&self, ui: &mut egui::Ui, height: f32, history: &History, probes: &mut ResMut<Probes>) {
        let &Self { title, unit, about, curves, .. } = self;
        let largest = curves.iter().map(|(_, _, value)| history.largest(value)).fold(0.0, f64::max);
        let scale = Quantity::suiting(largest, unit);
        let newest = history.samples.back();
        ui.spacing_mut().item_spacing.y = 1.0;
        let label = egui::Label::new(format!("{title}, {}", scale.unit)).truncate().selectable(false);
        offer(&ui.add(label.sense(egui::Sense::click())).on_hover_text(about), probes, &self.offered);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            for (name, color, value) in curves {
                let text = newest.map_or_else(|| "–".into(), |sample| scale.number(value(sample)));
                let text = egui::RichText::new(format!("{name} {text}")).small().color(color32(*color));
                ui.add(egui::Label::new(text).truncate());
            }
        });
        let end = newest.map_or(WINDOW, |sample| sample.time.max(WINDOW));
        let plot = still(Plot::new(title))
            .height(height)
            .include_y(0.0)
            .include_y(if largest > 0.0 { 0.0 } else { 1.0 })
            .set_margin_fraction(egui::vec2(0.0, 0.08))
            .y_axis_min_width(36.0)
            .y_grid_spacer(round_marks)
            .x_grid_spacer(move |_| fifth_seconds(end - WINDOW, end))
            .y_axis_formatter(|mark, _| mark_text(mark))
            // At the right end a number would be cut off.
            .x_axis_formatter(move |mark, _| match mark.value > end - 0.5 {
                true => String::new(),
                false => format!("{} s", mark.value),
            })
            .label_formatter(|position| match position {
                HoverPosition::NearDataPoint { plot_name, position, .. } => {
                    Some(format!("{plot_name} {:.4}\nat {:.3} s", position.y, position.x))
                }
                HoverPosition::Elsewhere { .. } => None,
            });
        // egui counts the widgets inside a plot anew at each pass; its id keeps the next ones' stable.
        ui.push_id(title, |ui| {
            plot.show(ui, |plot| {
                for (name, color, value) in curves {
                    let points = history.samples.iter().map(|sample| [sample.time, value(sample) * scale.factor]);
                    let points: PlotPoints = points.filter(|[_, value]| value.is_finite()).collect();
                    plot.line(Line::new(*name, points).color(color32(*color)).width(1.5));
                }
                plot.set_plot_bounds_x(end - WINDOW..=end);
            });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64) -> Sample {
        Sample {
            time,
            kinetic: 0.0,
            potential: 0.0,
            joint_error: 0.0,
            penetration: 0.0,
            step_seconds: 0.0,
            ghosts: [Apart::default(); MOST_GHOSTS],
            // Numbers, so that samples can be compared.
            joint: JointSample { force: 0.0, torque: 0.0, value: 0.0 },
        }
    }

    #[test]
    fn ten_seconds_are_kept_at_any_rate_in_bounded_memory() {
        for hz in [30.0, 60.0, 120.0, 1000.0, 50_000.0] {
            let mut history = History::default();
            for step in 0..(25.0 * hz) as usize {
                history.push(at(step as f64 / hz));
                assert!(history.samples.len() <= CAPACITY);
            }
            let span = history.samples.back().unwrap().time - history.samples.front().unwrap().time;
            assert!((span - WINDOW).abs() < 0.1 + 1.0 / hz, "{span} s at {hz} Hz");
        }
    }

    #[test]
    fn merging_keeps_peaks() {
        let mut history = History::default();
        history.push(Sample { penetration: 0.1, ..at(0.0) });
        history.push(Sample { penetration: 0.5, ..at(1e-4) });
        history.push(Sample { penetration: 0.2, kinetic: 3.0, ..at(2e-4) });
        assert_eq!(history.samples.len(), 1);
        assert_eq!(history.samples[0], Sample { penetration: 0.5, kinetic: 3.0, ..at(0.0) });
    }

    #[test]
    fn going_back_in_time_sets_aside_what_came_later() {
        let mut history = History::default();
        history.push(Sample { potential: 7.0, ..at(1.0) });
        history.push(Sample { potential: 6.0, ..at(2.0) });
        history.push(Sample { potential: 2.0, ..at(1.5) });
        let times = |history: &History| history.samples.iter().map(|sample| sample.time).collect::<Vec<_>>();
        assert_eq!(times(&history), [1.0, 1.5]);
        history.push(at(2.5));
        assert_eq!(times(&history), [1.0, 1.5, 2.0, 2.5]);
        assert_eq!(history.potential_at_start, Some(7.0));
    }

    #[test]
    fn time_counts_from_the_start_of_the_scene() {
        let times = |history: &History| history.samples.iter().map(|sample| sample.time).collect::<Vec<_>>();
        let mut history = History::default();
        history.push(at(7.0));
        history.begin(7.0);
        assert!(history.samples.is_empty());
        history.push(at(7.25));
        assert_eq!(times(&history), [0.25]);
        // Looking away and back is no new start.
        history.clear();
        history.push(at(8.0));
        assert_eq!(times(&history), [1.0]);
        history.push(at(0.5));
        assert_eq!(times(&history), [0.5]);
    }

    #[test]
    fn diagnostics_exist_only_while_watched_and_the_history_has_no_gap() {
        let mut app = crate::physics::headless_app();
        app.init_resource::<GhostReadings>().init_resource::<ReadJoints>();
        plugin(&mut app);
        let frame = |app: &mut App| {
            app.world_mut().run_schedule(PreUpdate);
            crate::physics::step(app.world_mut());
        };
        frame(&mut app);
        assert!(!app.world().contains_resource::<Diagnostics>());
        assert!(app.world().resource::<History>().samples.is_empty());

        app.world_mut().resource_mut::<Watched>().0 = true;
        frame(&mut app);
        frame(&mut app);
        assert!(app.world().contains_resource::<Diagnostics>());
        assert_eq!(app.world().resource::<History>().samples.len(), 2);

        app.world_mut().resource_mut::<Watched>().0 = false;
        frame(&mut app);
        assert!(!app.world().contains_resource::<Diagnostics>());
        assert!(app.world().resource::<History>().samples.is_empty());
    }

    #[test]
    fn what_was_set_aside_is_forgotten_when_something_else_is_to_come() {
        use crate::physics::{self, Gravity, go_to, step};

        let mut app = physics::headless_app();
        app.init_resource::<GhostReadings>().init_resource::<ReadJoints>();
        plugin(&mut app);
        app.world_mut().resource_mut::<Watched>().0 = true;
        physics::History::begin(app.world_mut(), 1 << 20);
        let ahead = |app: &App| app.world().resource::<History>().ahead.len();
        let frame = |app: &mut App| {
            app.world_mut().run_schedule(PreUpdate);
            step(app.world_mut());
        };
        (0..10).for_each(|_| frame(&mut app));
        go_to(app.world_mut(), 5).unwrap();
        frame(&mut app);
        assert_eq!(ahead(&app), 4, "of steps that are to come");
        app.world_mut().resource_mut::<Gravity>().0.x = 1.0;
        frame(&mut app);
        app.world_mut().run_schedule(PreUpdate);
        assert_eq!(ahead(&app), 0);
    }
}
