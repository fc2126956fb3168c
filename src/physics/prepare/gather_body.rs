//! One body from its components.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::table::{BodyTable, Watch, optional, or_default, value};
use crate::physics::{
    Body, Collider, Damping, ExternalForce, Inertia, Mass, PoseHistory, Position, QuarantineReason, RigidBody,
    Rotation, Shape, SurfaceMaterial, Velocity, columns,
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

/// What goes into the forces and drags of all bodies.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Terms {
    pub gravity: DVec3,
    pub drag: f64,
}

/// What is wrong with a body, if something is.
type Verdict = Result<(), QuarantineReason>;

/// Copies one body; says what is wrong with it. What is sane is copied even so: a change is seen
/// only once, and a quarantined body keeps its pose and shape.
pub(super) fn gather_body(
    table: &BodyTable,
    row: usize,
    watch: &Watch,
    body: &mut Body,
    terms: Terms,
    commands: &mut Commands,
) -> Verdict {
    body.kind = table.kind[row];
    body.layers = or_default(&table.layers, row);
    body.reports = table.reports;
    body.is_sensor = table.sensor;
    let collider = table.collider.as_ref().map(|column| &column[row]);
    let is_collider_new = table.is_collider_new(row, watch);
    body.mass_is_stale |= is_collider_new || table.is_density_or_mass_new(row, watch);
    let verdicts = [
        gather_pose(&value(&table.position, row), &value(&table.rotation, row), body),
        if table.parent { Err(QuarantineReason::HasParent) } else { Ok(()) },
        gather_surface(or_default(&table.material, row), or_default(&table.damping, row), body, terms.drag),
        gather_shape(collider, is_collider_new, body),
        gather_mass(table, row, collider, body, commands),
        gather_motion(table, row, body, terms.gravity),
    ];
    verdicts.into_iter().collect()
}

fn gather_pose(position: &Position, rotation: &Rotation, body: &mut Body) -> Verdict {
    if !position.is_finite() || !rotation.is_finite() || rotation.length_squared() <= 1e-12 {
        return Err(QuarantineReason::NotFinite);
    }
    body.position = position.0.into();
    body.rotation = unit(rotation.0);
    Ok(())
}

/// Velocity and force, once the mass is known.
fn gather_motion(table: &BodyTable, row: usize, body: &mut Body, gravity: DVec3) -> Verdict {
    let (velocity, locked) = (value(&table.velocity, row), or_default(&table.locked, row));
    let ExternalForce { force, torque } = or_default(&table.force, row);
    let scale = or_default(&table.gravity_scale, row).0;
    let (linear, angular) = (Vector3::from(velocity.linear), Vector3::from(velocity.angular));
    body.force = Vector3::from(force) + Vector3::from(gravity) * (body.mass * scale);
    body.torque = torque.into();
    if [linear, angular, body.force, body.torque].iter().flatten().any(|value| !value.is_finite()) {
        return Err(QuarantineReason::NotFinite);
    }
    (body.linear, body.angular) = match body.kind {
        RigidBody::Static => (Vector3::zeros(), Vector3::zeros()),
        RigidBody::Kinematic => (linear, angular),
        RigidBody::Dynamic => {
            (linear.component_mul(&freedom(locked.translation)), angular.component_mul(&freedom(locked.rotation)))
        }
    };
    Ok(())
}

fn gather_surface(material: SurfaceMaterial, damping: Damping, body: &mut Body, drag: f64) -> Verdict {
    let not_negative = |value: f64| value >= 0.0 && value.is_finite();
    if ![material.friction, damping.linear, damping.angular].into_iter().all(not_negative)
        || !(0.0..=1.0).contains(&material.restitution)
    {
        return Err(QuarantineReason::BadMaterial);
    }
    body.material = material;
    body.drag = match body.kind {
        RigidBody::Dynamic => (drag + damping.linear, drag + damping.angular),
        // Its own velocity alone moves it.
        RigidBody::Kinematic | RigidBody::Static => (0.0, 0.0),
    };
    Ok(())
}

fn gather_shape(collider: Option<&Collider>, is_new: bool, body: &mut Body) -> Verdict {
    let can_have = |collider: &&Collider| {
        let is_for = match collider.shape() {
            Shape::HalfSpace => body.kind == RigidBody::Static,
            Shape::Mesh(_) => body.kind != RigidBody::Dynamic,
            _ => true,
        };
        is_for && collider.is_valid()
    };
    match collider.filter(can_have) {
        None => {
            body.changes += u32::from(body.geometry.take().is_some());
            body.radius = 0.0;
            return if collider.is_some() { Err(QuarantineReason::BadMass) } else { Ok(()) };
        }
        Some(collider) if is_new || body.geometry.is_none() => {
            body.changes += 1;
            body.geometry = Some(collider.geometry());
            body.radius = collider.bounding_radius();
        }
        Some(_) => {}
    }
    Ok(())
}

/// Mass and inertia: as given, or from the collider, computed once and again when it changes.
fn gather_mass(
    table: &BodyTable,
    row: usize,
    collider: Option<&Collider>,
    body: &mut Body,
    commands: &mut Commands,
) -> Verdict {
    fix(body);
    if body.kind != RigidBody::Dynamic {
        return Ok(());
    }
    let collider = collider.ok_or(QuarantineReason::BadMass);
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let given_mass = optional(&table.mass, row).map(|mass| mass.0).filter(|&mass| body.computed_mass != Some(mass));
    let given_inertia = optional(&table.inertia, row).map(|inertia| inertia.0.into());
    let given_inertia = given_inertia.filter(|&inertia| body.computed_inertia != Some(inertia));
    if given_mass.is_some() {
        body.computed_mass = None;
    } else if body.mass_is_stale || body.computed_mass.is_none() {
        let mass = collider?.mass_properties(or_default(&table.density, row).0).mass;
        if positive(mass) && body.computed_mass != Some(mass) {
            commands.entity(body.entity).insert(Mass(mass));
        }
        body.computed_mass = Some(mass);
    }
    let mass = given_mass.or(body.computed_mass).filter(|&mass| positive(mass)).ok_or(QuarantineReason::BadMass)?;
    if given_inertia.is_some() {
        body.computed_inertia = None;
    } else if body.mass_is_stale || body.computed_inertia.is_none() {
        let inertia = collider?.mass_properties_of_mass(mass).inertia;
        if body.computed_inertia != Some(inertia.into()) {
            commands.entity(body.entity).insert(Inertia(inertia));
        }
        body.computed_inertia = Some(inertia.into());
    }
    let inertia = given_inertia.or(body.computed_inertia).ok_or(QuarantineReason::BadMass)?;
    if !inertia.iter().copied().all(positive) {
        return Err(QuarantineReason::BadMass);
    }
    let locked = or_default(&table.locked, row);
    body.mass_is_stale = false;
    body.mass = mass;
    body.inverse_mass = freedom(locked.translation) / mass;
    body.inverse_inertia_body = inertia.map(f64::recip);
    body.rotation_freedom = freedom(locked.rotation);
    Ok(())
}

/// Makes a body one that nothing moves.
fn fix(body: &mut Body) {
    body.mass = 0.0;
    body.inverse_mass = Vector3::zeros();
    body.inverse_inertia_body = Vector3::zeros();
}

/// 0 along locked axes, 1 else.
fn freedom(locked: [bool; 3]) -> Vector3<f64> {
    Vector3::from(locked.map(|locked| if locked { 0.0 } else { 1.0 }))
}

/// Puts a body back to its last finite pose, standing still; the solver sees it as static.
pub(super) fn freeze(table: &mut BodyTable, row: usize, body: &mut Body) {
    body.kind = RigidBody::Static;
    (body.linear, body.angular) = (Vector3::zeros(), Vector3::zeros());
    (body.force, body.torque) = (Vector3::zeros(), Vector3::zeros());
    fix(body);
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
