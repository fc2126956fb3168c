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
    /// How many of the charts' methods it compares, from the first.
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

/// Every map.
pub const ATLAS: [MapInfo; 4] = [
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
        series: 4,
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
        series: 4,
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
        series: 4,
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
        series: 3,
    },
];
