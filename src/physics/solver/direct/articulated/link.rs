//! One link: its inertia and its impulses, from its children to its parent and back.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::inertia::Articulated;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{JointDefinition, JointHolds};

/// A joint as the tree needs it.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct TreeJoint {
    /// Places of both bodies among the states.
    pub ends: [u32; 2],
    pub holds: JointHolds,
    /// Of the frames, in the axes of their bodies.
    pub anchors: [Vector3<f64>; 2],
    pub rotations: [UnitQuaternion<f64>; 2],
}

impl TreeJoint {
    /// Of a joint between those places; none where it holds something else.
    pub fn of(definition: &JointDefinition, ends: [u32; 2]) -> Option<Self> {
        let holds = definition.holds()?;
        let frames = &definition.frames;
        let (anchors, rotations) = ([0, 1].map(|end| frames[end].anchor), [0, 1].map(|end| frames[end].rotation));
        Some(Self { ends, holds, anchors, rotations })
    }
}

/// No link.
pub(super) const NONE: u32 = u32::MAX;

/// One link, with the values of the substep at hand; its pose and what it is to change stand with those of three others
/// ([`LinkFour`](super::fours::LinkFour)).
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// Places among the states.
    pub child: u32,
    pub parent: u32,
    /// The link of the parent to its own parent; [`NONE`] where that does not move.
    pub up: u32,
    /// Whether it is a joint; else it is the root of a tree that nothing holds.
    pub is_joint: bool,
    /// Whether its child is the joint's A.
    pub is_reversed: bool,
    pub holds: JointHolds,
    /// ℓ: from the point of the parent's own link.
    pub lever: Vector3<f64>,
    /// I, then I_a.
    pub inertia: Articulated,
    /// D⁻¹ of a hinge, and J⁻¹ of a point alone.
    inverse: f64,
    inverse_rotation: Matrix3<f64>,
    /// U of a hinge; H J⁻¹ of a point alone.
    along: Twist<f64>,
    across: Matrix3<f64>,
    pub momentum: Wrench<f64>,
    /// D⁻¹(Sᵀp − Uᵀc), or J⁻¹Sᵀp.
    turn: Vector3<f64>,
    pub motion: Twist<f64>,
    /// Force on the child and torque about the point, N and N·m.
    pub load: Wrench<f64>,
}

impl Link {
    /// Of a joint whose side `parent` is nearer to the root; `up` is the parent's own link.
    pub fn of(joint: &TreeJoint, parent: usize, up: u32) -> Self {
        let (child, parent_place) = (joint.ends[1 - parent], joint.ends[parent]);
        let root = Self::root(child);
        Self { parent: parent_place, up, is_joint: true, is_reversed: parent == 1, holds: joint.holds, ..root }
    }

    /// A body that nothing holds.
    pub fn root(body: u32) -> Self {
        Self {
            child: body,
            parent: NONE,
            up: NONE,
            is_joint: false,
            is_reversed: false,
            holds: JointHolds::Point,
            lever: Vector3::zeros(),
            inertia: Articulated::default(),
            inverse: 0.0,
            inverse_rotation: Matrix3::zeros(),
            along: Twist::zero(),
            across: Matrix3::zeros(),
            momentum: Wrench::zero(),
            turn: Vector3::zeros(),
            motion: Twist::zero(),
            load: Wrench::zero(),
        }
    }

    /// Takes in what a child of its child passes on, at that lever.
    #[inline(always)]
    pub fn take(&mut self, passed: &Wrench<f64>, lever: &Vector3<f64>) {
        self.momentum.linear += passed.linear;
        self.momentum.angular += passed.angular + lever.cross(&passed.linear);
    }

    /// I_a from I.
    #[inline(always)]
    pub fn eliminate(&mut self, axis: &Vector3<f64>) {
        let Articulated { mass, mixed, turning } = &mut self.inertia;
        if !self.is_joint {
            return;
        }
        match self.holds {
            JointHolds::Point => {
                let inverse = turning.try_inverse().unwrap_or_else(Matrix3::zeros);
                self.across = *mixed * inverse;
                *mass -= self.across * mixed.transpose();
                (*mixed, *turning) = (Matrix3::zeros(), Matrix3::zeros());
                self.inverse_rotation = inverse;
            }
            JointHolds::Axis => {
                let along = Twist { linear: *mixed * axis, angular: *turning * axis };
                let own = axis.dot(&along.angular);
                self.inverse = if own > 0.0 { 1.0 / own } else { 0.0 };
                let scaled = Twist { linear: along.linear * self.inverse, angular: along.angular * self.inverse };
                *mass -= scaled.linear * along.linear.transpose();
                *mixed -= scaled.linear * along.angular.transpose();
                *turning -= scaled.angular * along.angular.transpose();
                self.along = along;
            }
            JointHolds::All => {}
        }
    }

    /// p_a, with which p is done, for a joint that is to change so much.
    #[inline(always)]
    pub fn pass(&mut self, axis: &Vector3<f64>, bias: &Twist<f64>) -> Wrench<f64> {
        let momentum = std::mem::take(&mut self.momentum);
        let rest = momentum.plus(&self.inertia.of(bias), -1.0);
        match self.holds {
            JointHolds::Point => {
                self.turn = self.inverse_rotation * momentum.angular;
                Wrench { linear: rest.linear - self.across * momentum.angular, angular: Vector3::zeros() }
            }
            JointHolds::Axis => {
                let along = self.inverse * axis.dot(&momentum.angular);
                self.turn.x = along - self.inverse * self.along.dot(bias);
                rest.plus(&self.along, -along)
            }
            JointHolds::All => rest,
        }
    }

    /// x from x_p.
    #[inline(always)]
    pub fn moved(&self, parent: &Twist<f64>, axis: &Vector3<f64>, bias: &Twist<f64>) -> Twist<f64> {
        let held = parent.plus(bias, 1.0);
        match self.holds {
            JointHolds::Point => Twist { linear: held.linear, angular: self.turn - self.across.tr_mul(&held.linear) },
            JointHolds::Axis => {
                let turn = self.turn.x - self.inverse * self.along.dot(parent);
                Twist { linear: held.linear, angular: held.angular + axis * turn }
            }
            JointHolds::All => held,
        }
    }
}
