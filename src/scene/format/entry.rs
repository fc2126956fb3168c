//! What stands in a scene file, as it stands there.

use bevy::math::DVec3;
use ron::extensions::Extensions;
use serde::{Deserialize, Serialize};

use super::joint::JointEntry;
use super::probe::ProbeEntry;
use crate::physics::{CollisionLayers, LockedAxes, RigidBody};
use crate::scene::number::{Color, Finite, Fraction, NonNegative, Positive, PositiveVector, Quaternion, Vector};

/// Gravity of a scene that does not say, m/s².
pub(super) const USUAL_GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// `mass: 3.0` for `Some(3.0)`.
pub(super) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Scene", deny_unknown_fields)]
pub(super) struct SceneEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vector>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<ViewEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<ProbeEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Body", deny_unknown_fields)]
pub(super) struct BodyEntry {
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<RigidBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<ShapeEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia: Option<PositiveVector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Quaternion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_degrees: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<Fraction>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<CollisionLayers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub locked: Option<LockedAxes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_scale: Option<Finite>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_damping: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_damping: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Shape", deny_unknown_fields)]
pub(super) enum ShapeEntry {
    HalfSpace,
    Sphere {
        radius: Positive,
    },
    Cuboid {
        size: PositiveVector,
    },
    Capsule {
        radius: Positive,
        length: Positive,
    },
    Cylinder {
        radius: Positive,
        height: Positive,
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
        #[serde(skip_serializing_if = "Option::is_none")]
        pieces: Option<u32>,
    },
    Compound {
        children: Vec<ChildEntry>,
    },
    Heights {
        size: (Positive, Positive),
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        rows: Vec<Vec<Finite>>,
        #[serde(skip_serializing_if = "Option::is_none")]
        file: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        height: Option<(Finite, Finite)>,
    },
    Surface {
        #[serde(skip_serializing_if = "Option::is_none")]
        file: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        scale: Option<Positive>,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        vertices: Vec<Vector>,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        triangles: Vec<(u32, u32, u32)>,
        #[serde(skip_serializing_if = "Option::is_none")]
        two_sided: Option<bool>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Child", deny_unknown_fields)]
pub(super) struct ChildEntry {
    pub shape: ShapeEntry,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Quaternion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_degrees: Option<Vector>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "View", deny_unknown_fields)]
pub(super) struct ViewEntry {
    pub eye: Vector,
    pub target: Vector,
}
