//! One body from its components.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::table::{BodyTable, Components};
use crate::physics::{
    Body, Gravity, Inertia, Mass, PoseHistory, Position, QuarantineReason, RigidBody, Rotation, Shape, SolverSettings,
    Velocity, columns,
};

/// Takes over a `Transform` that the user changed. Returns whether there was one.
pub(super) fn teleport(table: &mut BodyTable, row: usize, origin: DVec3) -> bool {
    let transform = table.transform[row];
    let history = &mut table.history.bypass_change_detection()[row];
    if !history.is_foreign(&transform) {
        return false;
    }
    *history = PoseHistory { previous: None, written: Some(transform) };
    columns::set(&mut table.position, row, Position(transform.translation.as_dvec3() + origin));
    columns::set(&mut table.rotation, row, Rotation(transform.rotation.as_dquat()));
    true
}

/// Copies one body; says what is wrong with it. What is sane is copied even so: a change is seen
/// only once, and a quarantined body keeps its pose and shape.
pub(super) fn gather_body(
    item: &Components,
    body: &mut Body,
    gravity: &Gravity,
    settings: &SolverSettings,
    commands: &mut Commands,
) -> Result<(), QuarantineReason> {
    body.kind = item.kind;
    body.layers = item.layers;
    body.reports = item.reports;
    let verdicts = [
        gather_pose(item, body),
        if item.has_parent { Err(QuarantineReason::HasParent) } else { Ok(()) },
        gather_surface(item, body, settings),
        gather_shape(item, body),
        gather_mass(item, body, commands),
        gather_motion(item, body, gravity),
    ];
    verdicts.into_iter().collect()
}

fn gather_pose(item: &Components, body: &mut Body) -> Result<(), QuarantineReason> {
    if !item.position.is_finite() || !item.rotation.is_finite() || item.rotation.length_squared() <= 1e-12 {
        return Err(QuarantineReason::NotFinite);
    }
    body.position = item.position.0.into();
    body.rotation = unit(item.rotation.0);
    Ok(())
}

/// Velocity and force, once the mass is known.
fn gather_motion(item: &Components, body: &mut Body, gravity: &Gravity) -> Result<(), QuarantineReason> {
    let (linear, angular) = (Vector3::from(item.velocity.linear), Vector3::from(item.velocity.angular));
    body.force = Vector3::from(item.force.force) + Vector3::from(gravity.0) * (body.mass * item.gravity_scale.0);
    body.torque = item.force.torque.into();
    if [linear, angular, body.force, body.torque].iter().flatten().any(|value| !value.is_finite()) {
        return Err(QuarantineReason::NotFinite);
    }
    (body.linear, body.angular) = match body.kind {
        RigidBody::Static => (Vector3::zeros(), Vector3::zeros()),
        RigidBody::Kinematic => (linear, angular),
        RigidBody::Dynamic => (
            linear.component_mul(&freedom(item.locked.translation)),
            angular.component_mul(&freedom(item.locked.rotation)),
        ),
    };
    Ok(())
}

fn gather_surface(item: &Components, body: &mut Body, settings: &SolverSettings) -> Result<(), QuarantineReason> {
    let (material, damping) = (item.material, item.damping);
    let sane = material.friction >= 0.0
        && material.friction.is_finite()
        && (0.0..=1.0).contains(&material.restitution)
        && damping.linear >= 0.0
        && damping.angular >= 0.0
        && damping.linear.is_finite()
        && damping.angular.is_finite();
    if !sane {
        return Err(QuarantineReason::BadMaterial);
    }
    body.material = material;
    body.drag = match body.kind {
        RigidBody::Dynamic => (settings.drag + damping.linear, settings.drag + damping.angular),
        // Its own velocity alone moves it.
        RigidBody::Kinematic | RigidBody::Static => (0.0, 0.0),
    };
    Ok(())
}

fn gather_shape(item: &Components, body: &mut Body) -> Result<(), QuarantineReason> {
    let Some(collider) = item.collider else {
        body.changes += u32::from(body.geometry.is_some());
        body.geometry = None;
        body.radius = 0.0;
        return Ok(());
    };
    if !collider.is_valid() || (body.kind != RigidBody::Static && *collider.shape() == Shape::HalfSpace) {
        body.changes += u32::from(body.geometry.is_some());
        body.geometry = None;
        body.radius = 0.0;
        return Err(QuarantineReason::BadMass);
    }
    if item.collider_changed || body.geometry.is_none() {
        body.changes += 1;
        body.geometry = Some(collider.geometry());
        body.radius = collider.bounding_radius();
    }
    Ok(())
}

/// Mass and inertia: as given, or from the collider, computed once and again when it changes.
fn gather_mass(item: &Components, body: &mut Body, commands: &mut Commands) -> Result<(), QuarantineReason> {
    body.mass = 0.0;
    body.inverse_mass = Vector3::zeros();
    body.inverse_inertia_body = Vector3::zeros();
    body.mass_is_stale |= item.collider_changed || item.density_or_mass_changed;
    if body.kind != RigidBody::Dynamic {
        return Ok(());
    }
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let given_mass = item.mass.map(|mass| mass.0).filter(|&mass| body.computed_mass != Some(mass));
    let given_inertia =
        item.inertia.map(|inertia| inertia.0.into()).filter(|&inertia| body.computed_inertia != Some(inertia));
    if given_mass.is_some() {
        body.computed_mass = None;
    } else if body.mass_is_stale || body.computed_mass.is_none() {
        let collider = item.collider.ok_or(QuarantineReason::BadMass)?;
        let mass = collider.mass_properties(item.density.0).mass;
        if positive(mass) && body.computed_mass != Some(mass) {
            commands.entity(body.entity).insert(Mass(mass));
        }
        body.computed_mass = Some(mass);
    }
    let mass = given_mass.or(body.computed_mass).ok_or(QuarantineReason::BadMass)?;
    if !positive(mass) {
        return Err(QuarantineReason::BadMass);
    }
    if given_inertia.is_some() {
        body.computed_inertia = None;
    } else if body.mass_is_stale || body.computed_inertia.is_none() {
        let collider = item.collider.ok_or(QuarantineReason::BadMass)?;
        let inertia = collider.mass_properties_of_mass(mass).inertia;
        if body.computed_inertia != Some(inertia.into()) {
            commands.entity(body.entity).insert(Inertia(inertia));
        }
        body.computed_inertia = Some(inertia.into());
    }
    let inertia = given_inertia.or(body.computed_inertia).ok_or(QuarantineReason::BadMass)?;
    if !inertia.iter().copied().all(positive) {
        return Err(QuarantineReason::BadMass);
    }
    body.mass_is_stale = false;
    body.mass = mass;
    body.inverse_mass = freedom(item.locked.translation) / mass;
    body.inverse_inertia_body = inertia.map(f64::recip);
    body.rotation_freedom = freedom(item.locked.rotation);
    Ok(())
}

/// 0 along locked axes, 1 else.
fn freedom(locked: [bool; 3]) -> Vector3<f64> {
    Vector3::from(locked.map(|locked| if locked { 0.0 } else { 1.0 }))
}

/// Puts a body back to its last finite pose, standing still; the solver sees it as static.
pub(super) fn freeze(table: &mut BodyTable, row: usize, body: &mut Body) {
    body.kind = RigidBody::Static;
    body.linear = Vector3::zeros();
    body.angular = Vector3::zeros();
    body.force = Vector3::zeros();
    body.torque = Vector3::zeros();
    body.mass = 0.0;
    body.inverse_mass = Vector3::zeros();
    body.inverse_inertia_body = Vector3::zeros();
    let pose = (Position(body.position.into()), Rotation(DQuat::from(body.rotation)));
    if table.position.as_ref()[row] != pose.0 || table.rotation.as_ref()[row] != pose.1 {
        columns::set(&mut table.position, row, pose.0);
        columns::set(&mut table.rotation, row, pose.1);
    }
    if table.velocity.as_ref()[row] != Velocity::default() {
        columns::set(&mut table.velocity, row, Velocity::default());
    }
}

/// Unit to rounding already when the step wrote it; a user's may need normalizing.
fn unit(rotation: DQuat) -> UnitQuaternion<f64> {
    let quaternion = Quaternion::from(rotation);
    if (quaternion.norm_squared() - 1.0).abs() < 1e-12 {
        Unit::new_unchecked(quaternion)
    } else {
        UnitQuaternion::new_normalize(quaternion)
    }
}
