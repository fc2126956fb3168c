//! Joints about or along an axis: hinges, sliders, fixed joints, and those whose coordinates one chooses.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::UnitQuaternion;

use super::axes::JointAxes;
use super::definition::{Frame, Hold, JointDefinition, Laws};
use super::kind::JointKind;
use super::law::JointAxis;

/// Locks some of three coordinates.
const fn holding(locked: [bool; 3]) -> Laws {
    let mut hold = [Hold::Free; 3];
    let mut index = 0;
    while index < 3 {
        if locked[index] {
            hold[index] = Hold::Locked;
        }
        index += 1;
    }
    Laws { hold, spring: None }
}

/// A joint with frames: its component with its builder, which all such kinds share.
macro_rules! framed_joint {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty = $default:expr),* }, $holds:expr) => {
        $(#[$doc])*
        #[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
        #[reflect(Component, Debug, PartialEq)]
        #[component(map_entities)]
        pub struct $name {
            /// One body.
            pub body_a: Entity,
            /// The other body.
            pub body_b: Entity,
            /// The joint's point on A: from its centre of mass, body axes, m.
            pub anchor_a: DVec3,
            /// The joint's point on B: from its centre of mass, body axes, m.
            pub anchor_b: DVec3,
            /// The frames, whose x is the joint's axis (default: the world's x).
            pub axes: JointAxes,
            /// Whether the joined bodies collide with each other (default: no).
            pub collide: bool,
            $($(#[$field_doc])* pub $field: $type,)*
        }

        impl $name {
            /// Joins the centres of mass of two bodies.
            pub fn new(body_a: Entity, body_b: Entity) -> Self {
                Self {
                    body_a,
                    body_b,
                    anchor_a: DVec3::ZERO,
                    anchor_b: DVec3::ZERO,
                    axes: JointAxes::World(DVec3::X),
                    collide: false,
                    $($field: $default,)*
                }
            }

            /// Sets the points joined: from each centre of mass, in body axes, m.
            pub fn with_anchors(self, anchor_a: DVec3, anchor_b: DVec3) -> Self {
                Self { anchor_a, anchor_b, ..self }
            }

            /// Sets the axis, in the world's axes at the poses that the bodies have when the joint is first seen.
            pub fn with_axis(self, axis: DVec3) -> Self {
                Self { axes: JointAxes::World(axis), ..self }
            }

            /// Sets the axis in each body's axes.
            pub fn with_axes(self, of_a: DVec3, of_b: DVec3) -> Self {
                Self { axes: JointAxes::Bodies(of_a, of_b), ..self }
            }

            /// Sets the frames: rotations to the axes of A and of B.
            pub fn with_frames(self, of_a: DQuat, of_b: DQuat) -> Self {
                Self { axes: JointAxes::Frames(of_a, of_b), ..self }
            }

            /// Lets the joined bodies collide with each other.
            pub fn with_collision(self) -> Self {
                Self { collide: true, ..self }
            }
        }

        impl MapEntities for $name {
            fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
                self.body_a = mapper.get_mapped(self.body_a);
                self.body_b = mapper.get_mapped(self.body_b);
            }
        }

        impl JointKind for $name {
            fn axes_mut(&mut self) -> Option<&mut JointAxes> {
                Some(&mut self.axes)
            }

            fn definition(&self) -> JointDefinition {
                let holds: fn(&Self) -> ([Laws; 2], Option<JointAxis>) = $holds;
                let ([translation, rotation], axis) = holds(self);
                JointDefinition {
                    bodies: [self.body_a, self.body_b],
                    frames: frames([self.anchor_a, self.anchor_b], &self.axes),
                    translation,
                    rotation,
                    axis,
                    collide: self.collide,
                    ..default()
                }
            }
        }
    };
}

framed_joint! {
    /// Holds a point and an axis of A at a point and an axis of B: one angle is free, right-handed about the axis, of B
    /// against A, and zero where the frames agree. An entity of its own.
    ///
    /// [`JointLimits`](super::JointLimits), [`JointMotor`](super::JointMotor) and [`JointFriction`](super::JointFriction)
    /// beside it act on the angle, which [`JointCoordinate`] tells, over all turns.
    ///
    /// ```
    /// # use plumb::prelude::*;
    /// # use bevy::prelude::*;
    /// # use bevy::math::DVec3;
    /// # fn setup(mut commands: Commands) {
    /// let post = commands.spawn((RigidBody::Static, Transform::from_xyz(0., 2., 0.))).id();
    /// let door = commands
    ///     .spawn((RigidBody::Dynamic, Collider::cuboid(1., 2., 0.1), Transform::from_xyz(0.5, 2., 0.)))
    ///     .id();
    /// commands.spawn((
    ///     HingeJoint::new(post, door).with_anchors(DVec3::ZERO, DVec3::X * -0.5).with_axis(DVec3::Y),
    ///     JointLimits::range(-1.5, 1.5),
    ///     JointMotor::new(MotorTarget::Speed(1.0)).with_max_force(50.0),
    /// ));
    /// # }
    /// ```
    HingeJoint {},
    |_| ([Laws::LOCKED, holding([false, true, true])], Some(JointAxis::Twist))
}

framed_joint! {
    /// Lets B move along an axis of A and holds all else: one distance is free, zero where the anchors agree. An entity
    /// of its own.
    ///
    /// [`JointLimits`](super::JointLimits), [`JointMotor`](super::JointMotor) and [`JointFriction`](super::JointFriction)
    /// beside it act on the distance.
    SliderJoint {},
    |_| ([holding([false, true, true]), Laws::LOCKED], Some(JointAxis::X))
}

framed_joint! {
    /// Holds B as it stands to A. An entity of its own.
    FixedJoint {},
    |_| ([Laws::LOCKED; 2], None)
}

framed_joint! {
    /// Locks those of the six coordinates of B's frame in A's that are chosen. An entity of its own.
    GenericJoint {
        /// Which translations along A's axes are locked (default: none).
        locked_translations: [bool; 3] = [false; 3],
        /// Which of the twist and the swings about y and z are locked (default: none).
        locked_rotations: [bool; 3] = [false; 3],
        /// The coordinate that limits, a motor and friction act on (default: none).
        axis: Option<JointAxis> = None
    },
    |joint| ([holding(joint.locked_translations), holding(joint.locked_rotations)], joint.axis)
}

impl GenericJoint {
    /// Locks translations along A's axes, and the twist and the swings about y and z.
    pub fn with_locked(self, locked_translations: [bool; 3], locked_rotations: [bool; 3]) -> Self {
        Self { locked_translations, locked_rotations, ..self }
    }

    /// Sets the coordinate that limits, a motor and friction act on.
    pub fn with_free_axis(self, axis: JointAxis) -> Self {
        Self { axis: Some(axis), ..self }
    }
}

/// Frames at those anchors; axes that are no frames yet count as the bodies' own, and those without a direction make
/// frames that are no numbers.
fn frames(anchors: [DVec3; 2], axes: &JointAxes) -> [Frame; 2] {
    if !axes.is_valid() {
        return [Frame::at(DVec3::NAN); 2];
    }
    let rotations = match axes {
        JointAxes::Frames(a, b) => [*a, *b].map(|frame| UnitQuaternion::new_normalize(frame.into())),
        JointAxes::World(_) | JointAxes::Bodies(..) => [UnitQuaternion::identity(); 2],
    };
    [0, 1].map(|body| Frame { anchor: anchors[body].into(), rotation: rotations[body] })
}
