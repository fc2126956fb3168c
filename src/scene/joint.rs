//! Joints as data, and as the components of an entity.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::{BodySpec, ShapeSpec};
use crate::physics::{
    BallJoint, Breakable, BrokenJoint, DistanceJoint, DistanceLaw, FixedJoint, GenericJoint, HingeJoint, JointAxes,
    JointAxis, JointCoordinate, JointFriction, JointLimits, JointMotor, LimitRange, SliderJoint, Softness,
};

/// A joint between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// Name of body A.
    pub body_a: String,
    /// Name of body B.
    pub body_b: String,
    /// The joint's point from A's centre of mass, in the axes of its [`BodySpec::rotation`], m.
    pub anchor_a: DVec3,
    /// The joint's point from B's centre of mass, in the axes of its [`BodySpec::rotation`], m.
    pub anchor_b: DVec3,
    /// What it holds.
    pub kind: JointKindSpec,
    /// The frames of kinds that have some, and of a ball joint's limits; of bodies, in the axes of
    /// [`BodySpec::rotation`].
    pub axes: JointAxes,
    /// Whether the two collide.
    pub collide: bool,
    /// A damped spring instead of a rigid joint: of a ball joint alone.
    pub softness: Option<Softness>,
    /// How far it may go.
    pub limits: Option<LimitSpec>,
    /// What drives it.
    pub motor: Option<JointMotor>,
    /// Keys that set the motor's target.
    pub keys: Option<MotorKeys>,
    /// Dry friction, N or N·m.
    pub friction: f64,
    /// What it bears.
    pub breakable: Option<Breakable>,
    /// Whether it broke, and if so, whether its bodies have been apart since.
    pub broken: Option<BrokenJoint>,
    /// Its coordinate at the start, rad or m: of a hinge, it says over how many turns.
    pub coordinate: f64,
}

/// What a joint holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKindSpec {
    /// A point at a point.
    Ball,
    /// A point and an axis.
    Hinge,
    /// All but one distance along an axis.
    Slider,
    /// All.
    Fixed,
    /// The distance of two points.
    Distance(DistanceLaw),
    /// What one likes.
    Generic {
        /// Translations along A's axes.
        translations: [bool; 3],
        /// The twist and the swings about y and z.
        rotations: [bool; 3],
        /// What limits, a motor and friction act on.
        axis: Option<JointAxis>,
    },
}

/// How far a joint may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSpec {
    /// Largest swing of a ball joint, rad; then the range is that of its twist.
    pub swing: Option<f64>,
    /// Least, rad or m.
    pub min: f64,
    /// Largest, rad or m.
    pub max: f64,
    /// e, 0 to 1.
    pub restitution: f64,
}

/// Two keys that set a motor's target while they are held, by their names in Bevy's `KeyCode`: `ArrowUp`, `KeyW`.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct MotorKeys {
    /// Forward and back.
    pub keys: [String; 2],
    /// The target, a speed or a position, while each is held.
    pub values: [f64; 2],
    /// The target while none is.
    pub rest: f64,
}

impl LimitSpec {
    /// How far a coordinate is beyond the range, rad or m; negative within it.
    pub fn beyond(&self, coordinate: f64) -> f64 {
        (self.min - coordinate).max(coordinate - self.max)
    }
}

impl JointSpec {
    /// A rigid ball joint of two bodies that holds an anchor of A at an anchor of B.
    pub fn new(a: &BodySpec, anchor_a: DVec3, b: &BodySpec, anchor_b: DVec3) -> Self {
        Self {
            body_a: a.name.clone(),
            body_b: b.name.clone(),
            anchor_a,
            anchor_b,
            kind: JointKindSpec::Ball,
            axes: JointAxes::World(DVec3::X),
            collide: false,
            softness: None,
            limits: None,
            motor: None,
            keys: None,
            friction: 0.0,
            breakable: None,
            broken: None,
            coordinate: 0.0,
        }
    }

    /// A rigid ball joint of two bodies at a point of the world, m.
    pub fn at(a: &BodySpec, b: &BodySpec, point: DVec3) -> Self {
        Self::new(a, a.anchor(point), b, b.anchor(point))
    }

    /// A joint of that kind at a point of the world, m.
    pub fn of_kind(kind: JointKindSpec, a: &BodySpec, b: &BodySpec, point: DVec3) -> Self {
        Self { kind, ..Self::at(a, b, point) }
    }

    /// A hinge at a point of the world, m, about an axis of the world.
    pub fn hinge(a: &BodySpec, b: &BodySpec, point: DVec3, axis: DVec3) -> Self {
        Self { axes: JointAxes::World(axis), ..Self::of_kind(JointKindSpec::Hinge, a, b, point) }
    }

    /// Sets the axis, in the world.
    pub fn with_axis(self, axis: DVec3) -> Self {
        Self { axes: JointAxes::World(axis), ..self }
    }

    /// Limits its angle, rad, or distance, m.
    pub fn with_range(self, min: f64, max: f64) -> Self {
        Self { limits: Some(LimitSpec { swing: None, min, max, restitution: 0.0 }), ..self }
    }

    /// Limits the swing and the twist of a ball joint about an axis of the world, rad.
    pub fn with_swing_twist(self, swing: f64, [min, max]: [f64; 2], axis: DVec3) -> Self {
        let limits = Some(LimitSpec { swing: Some(swing), min, max, restitution: 0.0 });
        Self { limits, axes: JointAxes::World(axis), ..self }
    }

    /// Drives it.
    pub fn with_motor(self, motor: JointMotor) -> Self {
        Self { motor: Some(motor), ..self }
    }

    /// Lets it break.
    pub fn with_strength(self, breakable: Breakable) -> Self {
        Self { breakable: Some(breakable), ..self }
    }

    /// Whether limits, a motor and friction have a coordinate to act on.
    pub(super) fn has_axis(&self) -> bool {
        match self.kind {
            JointKindSpec::Hinge | JointKindSpec::Slider | JointKindSpec::Distance(_) => true,
            JointKindSpec::Generic { axis, .. } => axis.is_some(),
            JointKindSpec::Ball | JointKindSpec::Fixed => false,
        }
    }
}

/// A joint's own component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JointComponent {
    Ball(BallJoint),
    Hinge(HingeJoint),
    Slider(SliderJoint),
    Fixed(FixedJoint),
    Distance(DistanceJoint),
    Generic(GenericJoint),
}

/// Does the same to the component, whatever its kind.
macro_rules! for_kind {
    ($component:expr, |$joint:ident| $work:expr) => {
        match $component {
            JointComponent::Ball($joint) => $work,
            JointComponent::Hinge($joint) => $work,
            JointComponent::Slider($joint) => $work,
            JointComponent::Fixed($joint) => $work,
            JointComponent::Distance($joint) => $work,
            JointComponent::Generic($joint) => $work,
        }
    };
}

/// A joint's component with all that stands beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointParts {
    pub joint: JointComponent,
    pub limits: Option<JointLimits>,
    pub motor: Option<JointMotor>,
    pub keys: Option<MotorKeys>,
    pub friction: Option<JointFriction>,
    pub breakable: Option<Breakable>,
    pub broken: Option<BrokenJoint>,
    pub coordinate: Option<JointCoordinate>,
}

impl JointComponent {
    /// A and B.
    pub fn bodies(&self) -> [Entity; 2] {
        for_kind!(self, |joint| [joint.body_a, joint.body_b])
    }

    /// The joint's points on A and B, in their principal axes, m.
    pub fn anchors(&self) -> [DVec3; 2] {
        for_kind!(self, |joint| [joint.anchor_a, joint.anchor_b])
    }

    /// A and B, each with the joint's point on it, in its principal axes, m.
    #[cfg(feature = "sandbox")]
    pub fn ends(&self) -> [(Entity, DVec3); 2] {
        let ([a, b], [on_a, on_b]) = (self.bodies(), self.anchors());
        [(a, on_a), (b, on_b)]
    }

    /// Puts it on an entity.
    pub fn insert(self, entity: &mut EntityWorldMut) {
        for_kind!(self, |joint| _ = entity.insert(joint));
    }
}

impl JointParts {
    /// Of a joint's entity; none of any other, or of a user's own constraint.
    pub fn of_entity(world: &World, entity: Entity) -> Option<Self> {
        let entity = world.get_entity(entity).ok()?;
        let joint = [
            entity.get().copied().map(JointComponent::Ball),
            entity.get().copied().map(JointComponent::Hinge),
            entity.get().copied().map(JointComponent::Slider),
            entity.get().copied().map(JointComponent::Fixed),
            entity.get().copied().map(JointComponent::Distance),
            entity.get().copied().map(JointComponent::Generic),
        ];
        Some(Self {
            joint: joint.into_iter().flatten().next()?,
            limits: entity.get().copied(),
            motor: entity.get().copied(),
            keys: entity.get().cloned(),
            friction: entity.get().copied(),
            breakable: entity.get().copied(),
            broken: entity.get().copied(),
            coordinate: entity.get().copied(),
        })
    }

    /// Puts them on an entity.
    pub fn insert(self, entity: &mut EntityWorldMut) {
        let Self { joint, limits, motor, keys, friction, breakable, broken, coordinate } = self;
        // What stands beside the joint before the joint: it has a state of its own else.
        coordinate.into_iter().for_each(|part| _ = entity.insert(part));
        limits.into_iter().for_each(|part| _ = entity.insert(part));
        motor.into_iter().for_each(|part| _ = entity.insert(part));
        keys.into_iter().for_each(|part| _ = entity.insert(part));
        friction.into_iter().for_each(|part| _ = entity.insert(part));
        breakable.into_iter().for_each(|part| _ = entity.insert(part));
        broken.into_iter().for_each(|part| _ = entity.insert(part));
        joint.insert(entity);
    }

    /// A and B.
    pub fn bodies(&self) -> [Entity; 2] {
        self.joint.bodies()
    }

    /// The joint's points on A and B, in their principal axes, m.
    pub fn anchors(&self) -> [DVec3; 2] {
        self.joint.anchors()
    }

    /// With its end 0 (A) or 1 (B) on another body, at that point of it, in whose principal axes `turn` is those of the old body.
    #[cfg(feature = "sandbox")]
    pub fn with_end(mut self, end: usize, (body, anchor): (Entity, DVec3), turn: DQuat) -> Self {
        let (is_a, mut turns) = (end == 0, [DQuat::IDENTITY; 2]);
        turns[end] = turn;
        for_kind!(&mut self.joint, |joint| if is_a {
            (joint.body_a, joint.anchor_a) = (body, anchor);
        } else {
            (joint.body_b, joint.anchor_b) = (body, anchor);
        });
        let of_joint = match &mut self.joint {
            JointComponent::Hinge(joint) => Some(&mut joint.axes),
            JointComponent::Slider(joint) => Some(&mut joint.axes),
            JointComponent::Fixed(joint) => Some(&mut joint.axes),
            JointComponent::Generic(joint) => Some(&mut joint.axes),
            JointComponent::Ball(_) | JointComponent::Distance(_) => None,
        };
        let of_limits = match &mut self.limits {
            Some(JointLimits { range: LimitRange::SwingTwist { axes, .. }, .. }) => Some(axes),
            _ => None,
        };
        of_joint.into_iter().chain(of_limits).for_each(|axes| *axes = turned(axes, turns));
        self
    }

    /// As components, of a joint between two bodies.
    pub(super) fn of_spec(spec: &JointSpec, [a, b]: [(Entity, &BodySpec); 2]) -> Self {
        let (body_a, body_b) = (a.0, b.0);
        let anchor_a = in_principal_axes(a.1).inverse() * spec.anchor_a;
        let anchor_b = in_principal_axes(b.1).inverse() * spec.anchor_b;
        let axes = turned(&spec.axes, [a.1, b.1].map(|body| in_principal_axes(body).inverse()));
        let collide = spec.collide;
        let joint = match spec.kind {
            JointKindSpec::Ball => {
                let softness = spec.softness;
                JointComponent::Ball(BallJoint { body_a, body_b, anchor_a, anchor_b, collide, softness })
            }
            JointKindSpec::Hinge => {
                JointComponent::Hinge(HingeJoint { body_a, body_b, anchor_a, anchor_b, axes, collide })
            }
            JointKindSpec::Slider => {
                JointComponent::Slider(SliderJoint { body_a, body_b, anchor_a, anchor_b, axes, collide })
            }
            JointKindSpec::Fixed => {
                JointComponent::Fixed(FixedJoint { body_a, body_b, anchor_a, anchor_b, axes, collide })
            }
            JointKindSpec::Distance(length) => {
                JointComponent::Distance(DistanceJoint { body_a, body_b, anchor_a, anchor_b, length, collide })
            }
            JointKindSpec::Generic { translations, rotations, axis } => JointComponent::Generic(GenericJoint {
                axes,
                axis,
                collide,
                ..GenericJoint::new(body_a, body_b)
                    .with_anchors(anchor_a, anchor_b)
                    .with_locked(translations, rotations)
            }),
        };
        let limits = spec.limits.map(|LimitSpec { swing, min, max, restitution }| {
            let range = match swing {
                Some(swing) => LimitRange::SwingTwist { swing, min, max, axes },
                None => LimitRange::Range { min, max },
            };
            JointLimits { range, restitution }
        });
        let coordinate = JointCoordinate { value: spec.coordinate, rate: 0.0 };
        Self {
            joint,
            limits,
            motor: spec.motor,
            keys: spec.keys.clone(),
            friction: (spec.friction != 0.0).then_some(JointFriction(spec.friction)),
            breakable: spec.breakable,
            broken: spec.broken,
            coordinate: (spec.coordinate != 0.0).then_some(coordinate),
        }
    }

    /// As data, of a joint between two bodies.
    pub(super) fn to_spec(&self, [a, b]: [&BodySpec; 2]) -> JointSpec {
        let [anchor_a, anchor_b] = self.anchors();
        let given = [a, b].map(in_principal_axes);
        let mut spec = JointSpec {
            friction: self.friction.map_or(0.0, |friction| friction.0),
            motor: self.motor,
            keys: self.keys.clone().filter(|_| self.motor.is_some()),
            breakable: self.breakable,
            broken: self.broken,
            coordinate: self.coordinate.map_or(0.0, |coordinate| coordinate.value),
            ..JointSpec::new(a, given[0] * anchor_a, b, given[1] * anchor_b)
        };
        let axes = match self.joint {
            JointComponent::Ball(BallJoint { softness, .. }) => {
                spec.softness = softness;
                None
            }
            JointComponent::Hinge(HingeJoint { axes, .. }) => {
                spec.kind = JointKindSpec::Hinge;
                Some(axes)
            }
            JointComponent::Slider(SliderJoint { axes, .. }) => {
                spec.kind = JointKindSpec::Slider;
                Some(axes)
            }
            JointComponent::Fixed(FixedJoint { axes, .. }) => {
                spec.kind = JointKindSpec::Fixed;
                Some(axes)
            }
            JointComponent::Distance(DistanceJoint { length, .. }) => {
                spec.kind = JointKindSpec::Distance(length);
                None
            }
            JointComponent::Generic(joint) => {
                let (translations, rotations) = (joint.locked_translations, joint.locked_rotations);
                spec.kind = JointKindSpec::Generic { translations, rotations, axis: joint.axis };
                Some(joint.axes)
            }
        };
        spec.collide = for_kind!(self.joint, |joint| joint.collide);
        let mut of_limits = None;
        spec.limits = self.limits.map(|JointLimits { range, restitution }| match range {
            LimitRange::Range { min, max } => LimitSpec { swing: None, min, max, restitution },
            LimitRange::SwingTwist { swing, min, max, axes } => {
                of_limits = Some(axes);
                LimitSpec { swing: Some(swing), min, max, restitution }
            }
        });
        if let Some(axes) = axes.or(of_limits) {
            spec.axes = turned(&axes, given);
        }
        spec
    }
}

/// From the axes that a simulated body has to those that its shape is given in.
pub(super) fn in_principal_axes(body: &BodySpec) -> DQuat {
    body.shape.as_ref().map_or(DQuat::IDENTITY, ShapeSpec::axes)
}

/// Axes of bodies in other axes of theirs.
fn turned(axes: &JointAxes, [a, b]: [DQuat; 2]) -> JointAxes {
    match *axes {
        JointAxes::World(axis) => JointAxes::World(axis),
        JointAxes::Bodies(of_a, of_b) => JointAxes::Bodies(a * of_a, b * of_b),
        JointAxes::Frames(of_a, of_b) => JointAxes::Frames(a * of_a, b * of_b),
    }
}
