//! A user's own constraint: a function of two bodies' states and of the time that tells rows.

use std::fmt::{Debug, Formatter, Result};
use std::ops::Deref;
use std::sync::Arc;

use bevy::ecs::component::Mutable;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::body::{Body, RigidBody};

/// Where a body is and how it moves. SI, world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// Of the centre of mass, m.
    pub position: DVec3,
    /// From body axes, which are those that anchors are told in.
    pub rotation: DQuat,
    /// Of the centre of mass, m/s.
    pub linear: DVec3,
    /// rad/s.
    pub angular: DVec3,
}

/// One row of a constraint: what it holds at zero, C(bodies, t), and how that changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintRow {
    /// ∂Ċ/∂v of A and B, linear velocities.
    pub linear: [DVec3; 2],
    /// ∂Ċ/∂ω of A and B, angular velocities in world axes.
    pub angular: [DVec3; 2],
    /// C, m or rad.
    pub error: f64,
    /// ∂C/∂t: its rate while the bodies stand still.
    pub time_rate: f64,
    /// C̈ while nothing accelerates, J̇v + d/dt ∂C/∂t. None: by central differences over ±[`DIFFERENCE`](Self::DIFFERENCE)
    /// of J v + ∂C/∂t.
    pub velocity_term: Option<f64>,
    /// Least and largest λ, N or N·m: (0, ∞) pushes B along its Jacobian only.
    pub bounds: (f64, f64),
    /// e of a row that only pushes: the share of its approach with which C parts again, from 0 to 1.
    pub restitution: f64,
}

/// Up to six rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConstraintRows {
    rows: [ConstraintRow; 6],
    count: usize,
}

/// A component that is a constraint of one's own, on an entity of its own. [`AddConstraint::add_constraint`] makes
/// Plumb hold it; with a [`JointLoad`](super::JointLoad) its force and torque are told, about B's centre of mass.
/// Every method holds it, the exact one (`accurate`) with the order of its integrator. That one takes a row of the bounds
/// (0, ∞) or (−∞, 0) for a limit, at C = 0, which it reaches at its time and where it parts again with
/// [`restitution`](ConstraintRow::restitution) times its approach; any other row with bounds brings Ċ to zero as far as
/// λ may, and returns to C = 0, where that was too little, with a time constant of 0.2 s. Derive `Component` with `map_entities` where scenes are copied.
///
/// A bead on a hoop that turns about the vertical axis. On one of 0.8 m that turns with 6 rad/s it is 0.9 mm off after
/// half a second of `classic`, 0.6 mm of `game`, both at 240 Hz, and 4e-11 m of `accurate` at 60 Hz:
///
/// ```
/// use bevy::math::DVec3;
/// use bevy::prelude::*;
/// use plumb::physics::{AddConstraint, Constraint, BodyState, ConstraintRow, ConstraintRows};
/// use plumb::prelude::*;
///
/// #[derive(Component, Clone)]
/// struct OnHoop { hub: Entity, bead: Entity, radius: f64, speed: f64 }
///
/// impl Constraint for OnHoop {
///     fn bodies(&self) -> [Entity; 2] {
///         [self.hub, self.bead]
///     }
///
///     fn rows(&self, [hub, bead]: &[BodyState; 2], time: f64) -> ConstraintRows {
///         let (sin, cos) = (self.speed * time).sin_cos();
///         let from_hub = bead.position - hub.position;
///         // In the plane of the hoop, whose normal turns, and at its radius.
///         let normal = DVec3::new(-sin, 0.0, cos);
///         let turning = DVec3::new(-cos, 0.0, -sin) * self.speed;
///         let outwards = from_hub.normalize();
///         [
///             ConstraintRow {
///                 linear: [-normal, normal],
///                 error: normal.dot(from_hub),
///                 time_rate: turning.dot(from_hub),
///                 ..default()
///             },
///             ConstraintRow { linear: [-outwards, outwards], error: from_hub.length() - self.radius, ..default() },
///         ]
///         .into()
///     }
/// }
///
/// let mut app = headless_app();
/// app.add_constraint::<OnHoop>().insert_resource(SolverSettings::classic());
/// let world = app.world_mut();
/// let hub = world.spawn((RigidBody::Static, Transform::default())).id();
/// let bead = world.spawn((RigidBody::Dynamic, Mass(1.0), Collider::sphere(0.1), Transform::from_xyz(1., 0., 0.))).id();
/// world.spawn(OnHoop { hub, bead, radius: 1.0, speed: 3.0 });
/// for _ in 0..60 {
///     step(world);
/// }
/// let at = world.get::<Position>(bead).unwrap().0;
/// assert!((at.length() - 1.0).abs() < 0.01);
/// ```
pub trait Constraint: Component<Mutability = Mutable> + Clone {
    /// A and B, two bodies, one of them dynamic at least.
    fn bodies(&self) -> [Entity; 2];

    /// Whether the two collide with each other.
    fn collide(&self) -> bool {
        false
    }

    /// The rows at that state of A and B and that simulation time, s: as many at any, and nothing but a function of
    /// these and of the component.
    fn rows(&self, bodies: &[BodyState; 2], time: f64) -> ConstraintRows;
}

/// What [`Constraint::rows`] is of one component.
#[derive(Clone)]
pub(crate) struct RowFunction(Arc<dyn Fn(&[BodyState; 2], f64) -> ConstraintRows + Send + Sync>);

impl BodyState {
    pub(crate) fn new(
        position: &Vector3<f64>,
        rotation: &UnitQuaternion<f64>,
        [linear, angular]: [&Vector3<f64>; 2],
    ) -> Self {
        let [position, linear, angular] = [position, linear, angular].map(|vector| (*vector).into());
        Self { position, rotation: (*rotation).into(), linear, angular }
    }

    pub(crate) fn of(body: &Body) -> Self {
        let zero = Vector3::zeros();
        let velocities = match body.kind {
            RigidBody::Static => [&zero; 2],
            RigidBody::Dynamic | RigidBody::Kinematic => [&body.linear, &body.angular],
        };
        Self::new(&body.position, &body.rotation, velocities)
    }

    /// Whether all its numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite() && self.linear.is_finite() && self.angular.is_finite()
    }

    /// After so long with its present velocities.
    pub(crate) fn later(&self, time: f64) -> Self {
        Self {
            position: self.position + self.linear * time,
            rotation: DQuat::from_scaled_axis(self.angular * time) * self.rotation,
            ..*self
        }
    }
}

impl Default for ConstraintRow {
    /// Holds nothing, with any force.
    fn default() -> Self {
        let (linear, angular) = ([DVec3::ZERO; 2], [DVec3::ZERO; 2]);
        let bounds = (f64::NEG_INFINITY, f64::INFINITY);
        Self { linear, angular, error: 0.0, time_rate: 0.0, velocity_term: None, bounds, restitution: 0.0 }
    }
}

impl ConstraintRow {
    /// Half of what central differences are taken over, s. Their error is a sixth of its square times the third
    /// derivative of J v + ∂C/∂t, and 1e-11/s of that from rounding.
    pub const DIFFERENCE: f64 = 1e-5;

    /// Ċ.
    pub(super) fn rate(&self, bodies: &[BodyState; 2]) -> f64 {
        let of =
            |body: usize| self.linear[body].dot(bodies[body].linear) + self.angular[body].dot(bodies[body].angular);
        of(0) + of(1) + self.time_rate
    }
}

impl<const N: usize> From<[ConstraintRow; N]> for ConstraintRows {
    /// # Panics
    /// They are more than six.
    fn from(given: [ConstraintRow; N]) -> Self {
        let mut rows = [ConstraintRow::default(); 6];
        rows[..N].copy_from_slice(&given);
        Self { rows, count: N }
    }
}

impl Deref for ConstraintRows {
    type Target = [ConstraintRow];

    fn deref(&self) -> &[ConstraintRow] {
        &self.rows[..self.count]
    }
}

impl RowFunction {
    pub fn new(constraint: &impl Constraint) -> Self {
        let constraint = constraint.clone();
        Self(Arc::new(move |bodies, time| constraint.rows(bodies, time)))
    }

    pub fn at(&self, bodies: &[BodyState; 2], time: f64) -> ConstraintRows {
        (self.0)(bodies, time)
    }
}

impl Debug for RowFunction {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str("RowFunction")
    }
}
