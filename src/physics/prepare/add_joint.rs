//! Makes joints of components.

use bevy::prelude::*;

use super::gather_bodies;
use super::gather_joints::renew_laws;
use crate::physics::joint::{JointKind, define_joints, kind_changed};
use crate::physics::{Constraint, JointDefinition, Keep, PhysicsSchedule, PhysicsSystems};

/// Gives every component of a kind its definition, for as long as it is there.
pub(super) fn add_joint<J: JointKind>(app: &mut App) {
    app.keep_component::<J>();
    app.register_required_components::<J, JointDefinition>();
    app.add_observer(|removed: On<Remove, J>, mut commands: Commands| {
        commands.entity(removed.entity).try_remove::<JointDefinition>();
    });
    let define = define_joints::<J>.after(gather_bodies).before(renew_laws).run_if(kind_changed::<J>);
    app.add_systems(PhysicsSchedule, define.in_set(PhysicsSystems::Prepare));
}

/// Constraints of one's own.
pub trait AddConstraint {
    /// Makes constraints of the components of that type. To be called once, before there are any.
    fn add_constraint<T: Constraint>(&mut self) -> &mut Self;
}

impl AddConstraint for App {
    fn add_constraint<T: Constraint>(&mut self) -> &mut Self {
        add_joint::<T>(self);
        self
    }
}
