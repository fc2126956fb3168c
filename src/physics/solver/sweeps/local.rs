//! Bodies, contacts and joints as the substeps of their island see them.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::collision::Manifold;
use crate::physics::constraint::row::Twist;
use crate::physics::joint::JointDefinition;

/// A body as its island's substeps move it.
#[derive(Clone, Debug)]
pub(crate) struct LocalBody {
    pub global: u32,
    pub body: Body,
    /// World axes.
    pub inverse_inertia: Matrix3<f64>,
}

impl LocalBody {
    pub fn new(global: u32, body: &Body) -> Self {
        let mut local = Self { global, body: body.clone(), inverse_inertia: Matrix3::zeros() };
        local.update_inverse_inertia();
        local
    }

    /// M⁻¹ F_ext. No gyroscopic torque, as in the 2009 engine.
    pub fn free_acceleration(&self) -> Twist<f64> {
        let Body { inverse_mass, force, torque, .. } = &self.body;
        Twist { linear: inverse_mass.component_mul(force), angular: self.inverse_inertia * torque }
    }

    pub fn update_inverse_inertia(&mut self) {
        let Body { inverse_inertia_body, rotation, rotation_freedom, .. } = &self.body;
        self.inverse_inertia = world_inverse_inertia(inverse_inertia_body, rotation, rotation_freedom);
    }
}

/// A manifold between two local bodies, with a run of the island's points.
#[derive(Clone, Debug)]
pub(crate) struct LocalManifold {
    /// Its place among the step's contacts.
    pub place: u32,
    pub a: u32,
    pub b: u32,
    pub found: Manifold,
    pub points: Range<usize>,
}

/// A contact point that moves along with its bodies through the substeps.
#[derive(Clone, Debug)]
pub(crate) struct LocalPoint {
    /// From the centres of mass, world axes, where the contact was found.
    pub arm_a: Vector3<f64>,
    pub arm_b: Vector3<f64>,
    /// Overlap at the present poses; negative where a gap opened.
    pub depth: f64,
    pub found_depth: f64,
    pub body_arm_a: Vector3<f64>,
    pub body_arm_b: Vector3<f64>,
    /// Distance between the centres when the contact was found, B less A.
    pub found_offset: Vector3<f64>,
    /// Index of its normal row in the present solve; its friction rows follow.
    pub first_row: usize,
    /// Force on B in the last solve, N.
    pub force: Vector3<f64>,
    /// Impulse on B in this step so far, N·s.
    pub impulse: Vector3<f64>,
}

impl LocalPoint {
    /// Overlap at the poses that A and B have by now, along the normal with which it was found.
    pub fn depth_between(&self, [a, b]: [&Body; 2], normal: &Vector3<f64>) -> f64 {
        let turned = b.rotation * self.body_arm_b - a.rotation * self.body_arm_a;
        let offset = b.position - a.position + turned;
        self.found_depth - normal.dot(&(offset - self.found_offset))
    }
}

/// A joint between two local bodies.
#[derive(Clone, Debug)]
pub(crate) struct LocalJoint {
    pub global: u32,
    pub a: u32,
    pub b: u32,
    pub definition: JointDefinition,
    /// Its rows in the present solve.
    pub rows: Range<usize>,
    /// From B's centre of mass to its anchor, world axes.
    pub arm_b: Vector3<f64>,
    /// Impulse on B in this step so far, N·s, and its moment about B's anchor, N·m·s.
    pub impulse: Vector3<f64>,
    pub turn: Vector3<f64>,
    /// What each row carried in the last solve, N or N·m.
    pub multipliers: [f64; 6],
}
