//! What an island of contacts alone keeps from step to step, and from the start of a step on; [`loaded`](super::loaded)
//! tells of what for.

use nalgebra::Vector3;

use crate::physics::body::Body;
use crate::physics::constraint::row::Twist;
use crate::physics::lanes::Record;

/// What is known of an island of contacts alone.
#[derive(Default)]
pub(super) struct Loads {
    /// Mass of a member over that of one that it touches, the greatest; none: not asked for yet.
    pub mass_ratio: Option<f64>,
    /// Mass of a member over that of one that bears it, the greatest, in the step at hand.
    pub ratio: f64,
    /// Steps for which it was swept after the last that failed, and those left.
    pub pause: u32,
    pub pause_left: u32,
    /// Of members: the heaviest body that pushes each, kg, and which way.
    pub heaviest: Vec<(f64, Vector3<f64>)>,
    /// Of members: the impulses of all contacts of each, one with another, N·s.
    pub borne: Vec<f64>,
    /// Of contacts: the relative motion at the present velocities, and how it changes along the line that is searched.
    pub lines: Vec<(Twist<f64>, Twist<f64>)>,
}

/// Members and impulses of contacts as the step found them.
#[derive(Default)]
pub(crate) struct Kept {
    pub bodies: Vec<Body>,
    pub impulses: Vec<Record<f32>>,
}
