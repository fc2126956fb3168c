//! Joints of every kind, seen alike.

use bevy::ecs::query::QueryData;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::looked_at::LookedAt;
use crate::physics::{
    BallJoint, Breakable, BrokenJoint, DistanceJoint, DistanceLaw, FixedJoint, GenericJoint, HingeJoint, JointAxes,
    JointAxis, JointCoordinate, JointFriction, JointLimits, JointLoad, JointMotor, LimitRange, SliderJoint, StepStats,
};
use crate::scene::{JointComponent, MotorKeys};

/// What has the component of some kind of joint.
pub type IsJoint = Or<(
    With<BallJoint>,
    With<HingeJoint>,
    With<SliderJoint>,
    With<FixedJoint>,
    With<DistanceJoint>,
    With<GenericJoint>,
)>;

/// A joint's own component, whatever its kind.
#[derive(QueryData)]
pub struct AnyJoint {
    ball: Option<&'static BallJoint>,
    hinge: Option<&'static HingeJoint>,
    slider: Option<&'static SliderJoint>,
    fixed: Option<&'static FixedJoint>,
    distance: Option<&'static DistanceJoint>,
    generic: Option<&'static GenericJoint>,
}

impl AnyJointItem<'_, '_> {
    /// None of what is no joint.
    pub fn component(&self) -> Option<JointComponent> {
        let kinds = [
            self.ball.copied().map(JointComponent::Ball),
            self.hinge.copied().map(JointComponent::Hinge),
            self.slider.copied().map(JointComponent::Slider),
            self.fixed.copied().map(JointComponent::Fixed),
            self.distance.copied().map(JointComponent::Distance),
            self.generic.copied().map(JointComponent::Generic),
        ];
        kinds.into_iter().flatten().next()
    }
}

/// A joint with all that stands beside it.
#[derive(QueryData)]
pub struct WholeJoint {
    pub joint: AnyJoint,
    pub limits: Option<&'static JointLimits>,
    pub motor: Option<&'static JointMotor>,
    pub keys: Option<&'static MotorKeys>,
    pub friction: Option<&'static JointFriction>,
    pub breakable: Option<&'static Breakable>,
    pub broken: Option<&'static BrokenJoint>,
    pub coordinate: Option<&'static JointCoordinate>,
    pub load: Option<&'static JointLoad>,
    looked_at: Option<&'static LookedAt>,
}

/// Where a body stands: its centre of mass, m, and its rotation.
pub type Pose = (DVec3, DQuat);

impl WholeJointItem<'_, '_> {
    /// What it carried in the last step; none where no step has told that yet.
    pub fn known_load(&self, stats: &StepStats) -> Option<&JointLoad> {
        self.load.filter(|_| self.looked_at.is_none_or(|looked| looked.is_told(stats)))
    }

    /// What limits, a motor and friction act on; of a ball joint with limits, its swing.
    pub fn axis(&self) -> Option<JointAxis> {
        match self.joint.component()? {
            JointComponent::Hinge(_) => Some(JointAxis::Twist),
            JointComponent::Slider(_) => Some(JointAxis::X),
            JointComponent::Distance(_) => Some(JointAxis::Distance),
            JointComponent::Generic(joint) => joint.axis,
            JointComponent::Ball(_) => self.swing_axes().map(|_| JointAxis::Swing),
            JointComponent::Fixed(_) => None,
        }
    }

    fn swing_axes(&self) -> Option<JointAxes> {
        match self.limits?.range {
            LimitRange::SwingTwist { axes, .. } => Some(axes),
            LimitRange::Range { .. } => None,
        }
    }

    /// The frames of A and of B in the world, for bodies in those rotations; none of a joint without axes.
    pub fn frames(&self, rotations: [DQuat; 2]) -> Option<[DQuat; 2]> {
        let axes = match self.joint.component()? {
            JointComponent::Hinge(HingeJoint { axes, .. })
            | JointComponent::Slider(SliderJoint { axes, .. })
            | JointComponent::Fixed(FixedJoint { axes, .. })
            | JointComponent::Generic(GenericJoint { axes, .. }) => axes,
            JointComponent::Ball(_) => self.swing_axes()?,
            JointComponent::Distance(_) => return None,
        };
        let [a, b] = axes.frames(rotations);
        axes.is_valid().then(|| [rotations[0] * a, rotations[1] * b])
    }

    /// Where it stands along its axis, rad or m, its bodies standing so.
    pub fn value(&self, poses: [Pose; 2]) -> Option<f64> {
        let axis = self.axis()?;
        if let Some(coordinate) = self.coordinate {
            return Some(coordinate.value);
        }
        let anchors = self.joint.component()?.anchors();
        let [a, b] = [0, 1].map(|end| poses[end].0 + poses[end].1 * anchors[end]);
        let along = |direction: DVec3| Some((b - a).dot(self.frames(poses.map(|pose| pose.1))?[0] * direction));
        match axis {
            JointAxis::X => along(DVec3::X),
            JointAxis::Y => along(DVec3::Y),
            JointAxis::Z => along(DVec3::Z),
            JointAxis::Distance => Some(a.distance(b)),
            JointAxis::Swing => {
                let [a, b] = self.frames(poses.map(|pose| pose.1))?.map(|frame| frame * DVec3::X);
                Some(a.angle_between(b))
            }
            JointAxis::Twist => None,
        }
    }
}

/// What the user knows a kind of joint by.
pub fn noun(joint: &JointComponent) -> &'static str {
    match joint {
        JointComponent::Ball(_) => "ball joint",
        JointComponent::Hinge(_) => "hinge",
        JointComponent::Slider(_) => "slider",
        JointComponent::Fixed(_) => "fixed joint",
        JointComponent::Distance(joint) => match joint.length {
            DistanceLaw::Spring { .. } => "spring",
            DistanceLaw::Range { min, max } if min == max => "rod",
            DistanceLaw::Range { min: 0.0, .. } => "rope",
            DistanceLaw::Range { .. } => "range",
        },
        JointComponent::Generic(_) => "generic joint",
    }
}
