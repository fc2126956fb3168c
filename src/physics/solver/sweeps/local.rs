//! Bodies, contacts and joints as the substeps of their island see them.

use std::ops::Range;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::constraint::row::Twist;
use crate::physics::joint::JointDefinition;

/// A body as its island's substeps see it.
#[derive(Clone, Debug)]
pub(crate) struct LocalBody {
    pub global: u32,
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
    pub mass: f64,
    pub inverse_mass: Vector3<f64>,
    pub inverse_inertia_body: Vector3<f64>,
    pub inverse_inertia: Matrix3<f64>,
    pub rotation_freedom: Vector3<f64>,
    pub drag: (f64, f64),
}

impl LocalBody {
    pub fn new(global: u32, body: &Body) -> Self {
        let inverse_inertia = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
        Self {
            global,
            position: body.position,
            rotation: body.rotation,
            linear: body.linear,
            angular: body.angular,
            force: body.force,
            torque: body.torque,
            mass: body.mass,
            inverse_mass: body.inverse_mass,
            inverse_inertia_body: body.inverse_inertia_body,
            inverse_inertia,
            rotation_freedom: body.rotation_freedom,
            drag: body.drag,
        }
    }

    pub fn point_velocity(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(arm)
    }

    /// M⁻¹ F_ext. No gyroscopic torque, as in the 2009 engine.
    pub fn free_acceleration(&self) -> Twist<f64> {
        Twist { linear: self.inverse_mass.component_mul(&self.force), angular: self.inverse_inertia * self.torque }
    }

    pub fn update_inverse_inertia(&mut self) {
        self.inverse_inertia =
            world_inverse_inertia(&self.inverse_inertia_body, &self.rotation, &self.rotation_freedom);
    }
}

/// A manifold between two local bodies, with a run of the island's points.
#[derive(Clone, Debug)]
pub(crate) struct LocalManifold {
    pub a: u32,
    pub b: u32,
    pub normal: Vector3<f64>,
    pub friction: f64,
    pub restitution: f64,
    pub first_point: usize,
    pub end_point: usize,
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
}
