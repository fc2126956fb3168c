//! Reference answers: what is known of a built-in scene, and how far a run is from it.
//!
//! One file an answer: a function from the scene to a [`Truth`], or none where the answer is not
//! known for those parameters. Constants (masses, lengths, gravity, friction) are read from the
//! scene, so that an answer follows its parameters.

mod andrews;
mod answer;
mod arm;
mod bodies;
mod bounce;
mod bricard;
mod bridge;
mod car;
mod converged;
mod cradle;
mod dominoes;
mod elliptic;
mod far;
mod four_bar;
mod heavy_top;
mod hinge_chain;
mod hinges;
mod incline;
mod instant;
mod landing;
mod limits;
mod painleve;
mod pendulum;
mod ragdolls;
mod rolling;
mod servo;
mod slide_roll;
mod spheres;
mod statics;
mod stays_put;
mod stop;
mod table;
mod top;
mod tower;
mod trajectory;
mod wall;
mod wrecking_ball;

use crate::physics::{Method, SolverSettings};
use crate::scene::SceneSpec;

pub use answer::{EnergyScale, Poses, Truth};
pub use converged::{Unknown, converged};
pub use hinges::tilt as hinge_tilt;
pub use limits::overshoot as limit_overshoot;
pub use statics::Statics;

/// The scenes that stay as they are.
const STAY: [&str; 8] = ["hanging", "joint_grid", "stack", "pyramid", "pyramids", "sandwich", "arch", "card_house"];

/// What is known of a built-in scene with these parameters, for a run with these settings.
pub fn of(scene: &SceneSpec, settings: &SolverSettings) -> Option<Truth> {
    match scene.name.as_str() {
        "pendulum" => pendulum::truth(scene),
        "rods" | "chain" => trajectory::truth(scene),
        name if STAY.contains(&name) => stays_put::truth(scene),
        "top" => top::truth(scene),
        "heavy_top" => heavy_top::truth(scene),
        "incline" => incline::truth(scene),
        "slide_roll" => slide_roll::truth(scene),
        "rolling" => rolling::truth(scene),
        "painleve" => painleve::truth(scene),
        "bounce" => bounce::truth(scene),
        "spheres" => spheres::truth(scene),
        "cradle" => cradle::truth(scene),
        "dominoes" => dominoes::truth(scene),
        "wall" => wall::truth(scene),
        "slab" | "column" | "boulder" => landing::truth(scene),
        "wrecking_ball" => wrecking_ball::truth(scene),
        "four_bar" => four_bar::truth(scene),
        "bricard" => bricard::truth(scene),
        "andrews" => andrews::truth(scene),
        "arm" => arm::truth(scene, settings.method == Method::Exact),
        "servo" => servo::truth(scene),
        "stop" => stop::truth(scene),
        "hinge_chain" => hinge_chain::truth(scene),
        "bridge" => bridge::truth(scene),
        "tower" => tower::truth(scene),
        "car" => car::truth(scene),
        "ragdolls" => ragdolls::truth(scene),
        "far" => far::truth(scene, settings),
        _ => None,
    }
}

/// The whole motion of a built-in scene, where the answer gives it.
pub fn poses(scene: &SceneSpec) -> Option<Poses> {
    match scene.name.as_str() {
        "pendulum" => pendulum::poses(scene),
        "heavy_top" => heavy_top::poses(scene),
        "incline" => incline::poses(scene),
        "bounce" => bounce::poses(scene),
        name if STAY.contains(&name) => stays_put::truth(scene).map(|_| stays_put::poses(scene)),
        _ => None,
    }
}
