//! The maps: which scene, over which two quantities.

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
    /// How many of the charts' methods it compares, from the first; the last comes beside.
    pub series: usize,
}

/// What varies along a side of a map.
pub struct Axis {
    /// In words, with its unit.
    pub label: &'static str,
    /// What it sets.
    pub quantity: Quantity,
    /// Its values.
    pub values: &'static [f64],
}

/// A number that a map varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A parameter of the scene.
    Parameter(&'static str),
    /// Steps per second.
    Hz,
    /// Substeps of a step.
    Substeps,
    /// Sweeps of a substep.
    Iterations,
}

const ITERATIONS: Axis = Axis {
    label: "iterations",
    quantity: Quantity::Iterations,
    values: &[1.0, 2.0, 4.0, 10.0, 20.0, 50.0, 100.0, 200.0],
};

const SUBSTEPS: Axis = Axis { label: "substeps", quantity: Quantity::Substeps, values: &[1.0, 2.0, 4.0, 8.0, 16.0] };

const HZ: Axis =
    Axis { label: "steps per second", quantity: Quantity::Hz, values: &[30.0, 60.0, 120.0, 240.0, 480.0, 960.0] };

/// Every map.
pub const ATLAS: [MapInfo; 12] = [
    MapInfo {
        name: "chain",
        scene: "chain",
        parameters: &[],
        seconds: 4.0,
        x: ITERATIONS,
        y: Axis {
            label: "mass of the ball over a rod's",
            quantity: Quantity::Parameter("r"),
            values: &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 1e6],
        },
        about: "sweeps carry a heavy ball's weight up a light chain link by link: the heavier, the more it takes",
        series: 6,
    },
    MapInfo {
        name: "sandwich",
        scene: "sandwich",
        parameters: &[],
        seconds: 4.0,
        x: ITERATIONS,
        y: Axis {
            label: "mass of the slab over a cube's",
            quantity: Quantity::Parameter("r"),
            values: &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 1e6],
        },
        about: "a heavy slab on light cubes: what the sweeps leave undone pushes the cubes into the ground",
        series: 6,
    },
    MapInfo {
        name: "stack",
        scene: "stack",
        parameters: &[],
        seconds: 5.0,
        x: SUBSTEPS,
        y: Axis {
            label: "cubes in the column",
            quantity: Quantity::Parameter("n"),
            values: &[2.0, 4.0, 6.0, 10.0, 15.0, 20.0, 30.0],
        },
        about: "a column settles by what the sweeps leave undone; the higher, the more",
        series: 6,
    },
    MapInfo {
        name: "pyramid",
        scene: "pyramid",
        parameters: &[],
        seconds: 5.0,
        x: SUBSTEPS,
        y: Axis {
            label: "cubes in the lowest row",
            quantity: Quantity::Parameter("n"),
            values: &[2.0, 4.0, 6.0, 10.0, 15.0, 20.0],
        },
        about: "a wall spreads its weight, and stands where a column of its height does not",
        series: 5,
    },
    MapInfo {
        name: "top",
        scene: "top",
        parameters: &[],
        seconds: 3.0,
        x: HZ,
        y: Axis {
            label: "spin, rad/s",
            quantity: Quantity::Parameter("spin"),
            values: &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0],
        },
        about: "a box spinning about its middle axis flips over and over: the faster, the sooner a step turns too far",
        series: 6,
    },
    MapInfo {
        name: "bounce",
        scene: "bounce",
        parameters: &[("e", 1.0)],
        seconds: 5.0,
        x: HZ,
        y: Axis {
            label: "height of the drop, m",
            quantity: Quantity::Parameter("height"),
            values: &[0.5, 1.0, 3.0, 10.0, 30.0, 100.0],
        },
        about: "balls that bounce for ever: the faster they land, the deeper a step takes them into the ground",
        series: 6,
    },
    MapInfo {
        name: "wall",
        scene: "wall",
        parameters: &[],
        seconds: 1.0,
        x: HZ,
        y: Axis {
            label: "speed of the ball, m/s",
            quantity: Quantity::Parameter("v"),
            values: &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3],
        },
        about: "a ball thrown at a wall as thick as its radius: where a step is longer than both, it may pass unseen",
        series: 6,
    },
    MapInfo {
        name: "far",
        scene: "far",
        parameters: &[],
        seconds: 2.0,
        x: SUBSTEPS,
        y: Axis {
            label: "distance from the origin, m",
            quantity: Quantity::Parameter("d"),
            values: &[1e2, 1e4, 1e5, 1e6, 1e7, 1e8],
        },
        about: "a stack and a chain must do far from the origin what they do at it, to 1e-5 m",
        series: 6,
    },
    MapInfo {
        name: "painleve",
        scene: "painleve",
        parameters: &[],
        seconds: 0.5,
        x: Axis {
            label: "friction",
            quantity: Quantity::Parameter("mu"),
            values: &[0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 2.0, 3.0],
        },
        y: Axis {
            label: "angle of the rod to the ground, degrees",
            quantity: Quantity::Parameter("tilt"),
            values: &[20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0],
        },
        about: "a rod that slides ahead of its centre: with much friction no rigid motion exists, and none may gain energy",
        series: 6,
    },
    MapInfo {
        name: "card_house",
        scene: "card_house",
        parameters: &[],
        seconds: 5.0,
        x: ITERATIONS,
        y: SUBSTEPS,
        about: "a house of cards stands by friction alone: what the sweeps leave undone lets it slide apart",
        series: 6,
    },
    MapInfo {
        name: "servo",
        scene: "servo",
        parameters: &[],
        seconds: 2.0,
        x: HZ,
        y: Axis {
            label: "undamped frequency of the servo, Hz",
            quantity: Quantity::Parameter("f"),
            values: &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4],
        },
        about: "a servo that is faster than the steps jerks its rod: sweeps let the hinge part",
        series: 6,
    },
    MapInfo {
        name: "hinge_chain",
        scene: "hinge_chain",
        parameters: &[("limit", 30.0)],
        seconds: 2.0,
        x: Axis { label: "links", quantity: Quantity::Parameter("n"), values: &[2.0, 5.0, 10.0, 20.0, 50.0, 100.0] },
        y: Axis {
            label: "mass of the ball over a link's",
            quantity: Quantity::Parameter("r"),
            values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        },
        about: "hinges with limits bear a ball that pulls across their axes too, and tilt where a sweep leaves that undone",
        series: 6,
    },
];
