//! The scene file: RON, with a default for whatever a scene does not say. Its entries are here; how
//! they become a scene is in `read`, how a scene becomes entries in `write`.
//!
//! What a number may be is held by the types it is read through (`number.rs`), so that the parser
//! names line and column; what only the whole scene shows is named by its path in it.

mod read;
mod write;

use std::ops::Not;

use bevy::math::DVec3;
use ron::extensions::Extensions;
use serde::{Deserialize, Serialize};

use super::number::{Color, Finite, Fraction, NonNegative, Positive, PositiveVector, Quaternion, Vector};
use crate::physics::{CollisionLayers, LockedAxes, RigidBody};

pub(super) use read::read;

/// What joints call the fixed world.
pub(super) const WORLD: &str = "world";

/// What the names of the bodies start with that joints to the world are made to.
pub(super) const WORLD_PREFIX: &str = "world:";

/// Gravity of a scene that does not say, m/s².
const USUAL_GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// Of a soft joint that does not say: critical.
const USUAL_DAMPING_RATIO: f64 = 1.0;

/// `mass: 3.0` for `Some(3.0)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Scene", deny_unknown_fields)]
struct SceneEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    gravity: Option<Vector>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    bodies: Vec<BodyEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    joints: Vec<JointEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    view: Option<ViewEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Body", deny_unknown_fields)]
struct BodyEntry {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<RigidBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<ShapeEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    density: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mass: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inertia: Option<PositiveVector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<Quaternion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation_degrees: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    angular_velocity: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    force: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    torque: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    restitution: Option<Fraction>,
    #[serde(skip_serializing_if = "Option::is_none")]
    layers: Option<CollisionLayers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    locked: Option<LockedAxes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gravity_scale: Option<Finite>,
    #[serde(skip_serializing_if = "Option::is_none")]
    linear_damping: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    angular_damping: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    color: Option<Color>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Shape", deny_unknown_fields)]
enum ShapeEntry {
    HalfSpace,
    Sphere {
        radius: Positive,
    },
    Cuboid {
        size: PositiveVector,
    },
    Cone {
        radius: Positive,
        height: Positive,
    },
    Hull {
        points: Vec<Vector>,
    },
    Mesh {
        file: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        scale: Option<Positive>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Joint", deny_unknown_fields)]
struct JointEntry {
    body_a: String,
    body_b: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    anchor_a: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    anchor_b: Option<Vector>,
    #[serde(default, skip_serializing_if = "Not::not")]
    collide: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    softness: Option<SoftnessEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Softness", deny_unknown_fields)]
struct SoftnessEntry {
    frequency: Positive,
    #[serde(skip_serializing_if = "Option::is_none")]
    damping_ratio: Option<NonNegative>,
    max_force: Positive,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "View", deny_unknown_fields)]
struct ViewEntry {
    eye: Vector,
    target: Vector,
}
