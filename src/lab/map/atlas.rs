//! The maps that are known by name: which scene, over which two quantities.

use super::plan::MapPlan;
use crate::lab::chart::SERIES;
use crate::lab::vary::{Candidate, Measure, Study, Variation};
use crate::physics::SolverSettings;
use crate::scene;

/// A map.
pub struct MapInfo {
    /// Its name: the scene's, with more where a scene has several.
    pub name: &'static str,
    /// The scene.
    pub scene: &'static str,
    /// Parameters that are not at their defaults and do not vary.
    pub parameters: &'static [(&'static str, f64)],
    /// Time to simulate, s.
    pub seconds: f64,
    /// Across.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// What the border is expected to show, in a sentence.
    pub about: &'static str,
    /// What it compares, a panel each.
    pub compared: Compared,
    /// The measure that is written into the cells; none: a cross where a run fails.
    pub written: Option<&'static str>,
}

/// What varies along a side of a map.
pub struct Axis {
    /// In words, with its unit.
    pub label: &'static str,
    /// What varies and how, as on the command line.
    pub varies: &'static str,
}

/// What a map compares. The last of the charts' methods, the true one, comes beside.
pub enum Compared {
    /// So many of the charts' methods, from the first.
    Methods(usize),
    /// The same settings with each of several values of one of them.
    Each {
        /// The settings.
        of: fn() -> SolverSettings,
        /// The values, as on the command line.
        with: &'static str,
    },
}

impl MapInfo {
    /// The map.
    ///
    /// # Panics
    /// An entry makes no sense; a test draws on all of them.
    pub fn plan(&self) -> MapPlan {
        let info = scene::find(self.scene);
        let read = |text: &str| Variation::parse(text, info).unwrap_or_else(|error| panic!("{}: {error}", self.name));
        let candidates = match &self.compared {
            Compared::Methods(count) => SERIES[..*count].iter().map(Candidate::of).collect::<Vec<_>>(),
            Compared::Each { of, with } => {
                let base = Candidate::new("", of());
                read(with).values().iter().map(|value| base.changed(&[*value])).collect()
            }
        };
        let truth = SERIES.last().map(Candidate::of);
        let study = Study {
            scene: self.scene.to_owned(),
            parameters: self.parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect(),
            seconds: self.seconds,
            candidates: candidates.into_iter().chain(truth).collect(),
        };
        MapPlan {
            name: self.name.to_owned(),
            x_label: self.x.label.to_owned(),
            y_label: self.y.label.to_owned(),
            about: self.about.to_owned(),
            measure: self
                .written
                .map(|name| Measure::find(name).unwrap_or_else(|error| panic!("{}: {error}", self.name))),
            ..MapPlan::new(study, read(self.x.varies), read(self.y.varies))
        }
    }
}

const ITERATIONS: Axis = Axis { label: "iterations", varies: "iterations=1,2,4,10,20,50,100,200" };

const SUBSTEPS: Axis = Axis { label: "substeps", varies: "substeps=1,2,4,8,16" };

const HZ: Axis = Axis { label: "steps per second", varies: "hz=30,60,120,240,480,960" };

/// Every map.
pub const ATLAS: [MapInfo; 15] = [
    MapInfo {
        name: "chain",
        scene: "chain",
        parameters: &[],
        seconds: 4.0,
        x: ITERATIONS,
        y: Axis { label: "mass of the ball over a rod's", varies: "r=1,3,10,30,100,300,1e3,1e4,1e5,1e6" },
        about: "sweeps carry a heavy ball's weight up a light chain link by link: the heavier, the more it takes",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "sandwich",
        scene: "sandwich",
        parameters: &[],
        seconds: 4.0,
        x: ITERATIONS,
        y: Axis { label: "mass of the slab over a cube's", varies: "r=1,3,10,30,100,300,1e3,1e4,1e5,1e6" },
        about: "a heavy slab on light cubes: what the sweeps leave undone pushes the cubes into the ground",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "slab",
        scene: "slab",
        parameters: &[],
        seconds: 3.0,
        x: Axis { label: "height of its fall, m", varies: "drop=0.01,0.03,0.1,0.3,1,2" },
        y: Axis { label: "mass of the slab over a cube's", varies: "r=1,10,100,1e3,1e4,1e5" },
        about: "a slab falls on two cubes: what the sweeps do not stop in time goes into the ground with them",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "column",
        scene: "column",
        parameters: &[],
        seconds: 3.0,
        x: Axis { label: "cubes", varies: "n=2,4,8,12,15,20" },
        y: Axis { label: "mass of every other cube over the first's", varies: "r=1,10,100,1e3,1e4,1e5" },
        about: "light and heavy cubes in turns land on each other: the more, the longer the way of each impact to the ground",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "stack",
        scene: "stack",
        parameters: &[],
        seconds: 5.0,
        x: SUBSTEPS,
        y: Axis { label: "cubes in the column", varies: "n=2,4,6,10,15,20,30" },
        about: "a column settles by what the sweeps leave undone; the higher, the more",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "pyramid",
        scene: "pyramid",
        parameters: &[],
        seconds: 5.0,
        x: SUBSTEPS,
        y: Axis { label: "cubes in the lowest row", varies: "n=2,4,6,10,15,20" },
        about: "a wall spreads its weight, and stands where a column of its height does not",
        compared: Compared::Methods(5),
        written: None,
    },
    MapInfo {
        name: "top",
        scene: "top",
        parameters: &[],
        seconds: 3.0,
        x: HZ,
        y: Axis { label: "spin, rad/s", varies: "spin=1,3,10,30,100,300" },
        about: "a box spinning about its middle axis flips over and over: the faster, the sooner a step turns too far",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "bounce",
        scene: "bounce",
        parameters: &[("e", 1.0)],
        seconds: 5.0,
        x: HZ,
        y: Axis { label: "height of the drop, m", varies: "height=0.5,1,3,10,30,100" },
        about: "balls that bounce for ever: the faster they land, the deeper a step takes them into the ground",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "wall",
        scene: "wall",
        parameters: &[],
        seconds: 1.0,
        x: HZ,
        y: Axis { label: "speed of the ball, m/s", varies: "v=1,3,10,30,100,300,1e3" },
        about: "a ball thrown at a wall as thick as its radius: where a step is longer than both, it may pass unseen",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "far",
        scene: "far",
        parameters: &[],
        seconds: 2.0,
        x: SUBSTEPS,
        y: Axis { label: "distance from the origin, m", varies: "d=1e2,1e4,1e5,1e6,1e7,1e8" },
        about: "a stack and a chain must do far from the origin what they do at it, to 1e-5 m",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "painleve",
        scene: "painleve",
        parameters: &[],
        seconds: 0.5,
        x: Axis { label: "friction", varies: "mu=0,0.3,0.6,0.9,1.2,1.5,2,3" },
        y: Axis { label: "angle of the rod to the ground, degrees", varies: "tilt=20,30,40,50,60,70,80" },
        about: "a rod that slides ahead of its centre: with much friction no rigid motion exists, and none may gain energy",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "card_house",
        scene: "card_house",
        parameters: &[],
        seconds: 5.0,
        x: ITERATIONS,
        y: SUBSTEPS,
        about: "a house of cards stands by friction alone: what the sweeps leave undone lets it slide apart",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "servo",
        scene: "servo",
        parameters: &[],
        seconds: 2.0,
        x: HZ,
        y: Axis { label: "undamped frequency of the servo, Hz", varies: "f=1,3,10,30,100,300,1e3,1e4" },
        about: "a servo that is faster than the steps jerks its rod: sweeps let the hinge part",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "hinge_chain",
        scene: "hinge_chain",
        parameters: &[("limit", 30.0)],
        seconds: 2.0,
        x: Axis { label: "links", varies: "n=2,5,10,20,50,100" },
        y: Axis { label: "mass of the ball over a link's", varies: "r=1,10,100,1e3,1e4,1e6" },
        about: "hinges with limits bear a ball that pulls across their axes too, and tilt where a sweep leaves that undone",
        compared: Compared::Methods(6),
        written: None,
    },
    MapInfo {
        name: "incline",
        scene: "incline",
        parameters: &[("mu", 0.1)],
        seconds: 2.0,
        x: Axis { label: "corners that it stands on", varies: "points=1,2,3,4,5,6,8,12,24" },
        y: Axis { label: "angle of the slope, degrees", varies: "theta=4,8,15,20,30,45,60,75,85" },
        about: "Coulomb's friction knows no number of contact points; a bound of the weight at each of them grows with it",
        compared: Compared::Each { of: SolverSettings::classic, with: "friction=one_tangent,two_tangents" },
        written: Some("drift"),
    },
];
