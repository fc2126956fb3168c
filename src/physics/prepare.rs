//! `Prepare`: from the ECS to packed arrays.
//!
//! 1. Bodies: new ones enter, gone ones leave, poses and velocities are copied, transforms that
//!    the user moved teleport, mass and geometry are computed where they changed, forces summed,
//!    what makes no sense is quarantined.
//! 2. Joints: packed again only when a joint or the set of bodies changed; a joint of a body
//!    that is gone is despawned.

use bevy::ecs::query::QueryData;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::PhysicsSystems;
use super::bodies::{Bodies, Body, Joint, Joints};
use super::body::{
    BirthCounter, BodySlot, CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass,
    Position, QuarantineReason, Quarantined, ReportCollisions, RigidBody, Rotation, SurfaceMaterial, Velocity,
};
use super::collider::{Collider, Shape};

use super::diagnostics::StepStats;
use super::joint::{BallJoint, JoinedPairs, JointSlot, Softness};
use super::messages::BodyQuarantined;
use super::settings::{Gravity, SolverSettings};
use super::solver::{ContactCache, LaggedContacts};
use super::transform::{PoseHistory, RenderOrigin};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Bodies>()
        .init_resource::<Joints>()
        .init_resource::<JoinedPairs>()
        .init_resource::<BirthCounter>()
        .add_systems(super::PhysicsSchedule, (gather_bodies, gather_joints).chain().in_set(PhysicsSystems::Prepare));
}

#[derive(QueryData)]
#[query_data(mutable)]
struct BodyQuery {
    entity: Entity,
    kind: &'static RigidBody,
    slot: &'static mut BodySlot,
    position: &'static mut Position,
    rotation: &'static mut Rotation,
    velocity: &'static mut Velocity,
    transform: &'static Transform,
    history: &'static mut PoseHistory,
    collider: Option<Ref<'static, Collider>>,
    density: Option<Ref<'static, Density>>,
    mass: Option<Ref<'static, Mass>>,
    inertia: Option<Ref<'static, Inertia>>,
    force: Option<&'static ExternalForce>,
    material: Option<&'static SurfaceMaterial>,
    layers: Option<&'static CollisionLayers>,
    locked: Option<&'static LockedAxes>,
    gravity_scale: Option<&'static GravityScale>,
    damping: Option<&'static Damping>,
    reports: Has<ReportCollisions>,
    quarantined: Option<&'static Quarantined>,
    parent: Option<&'static ChildOf>,
}

#[derive(Default)]
struct Gathering {
    seen: Vec<bool>,
    new: Vec<(u64, Entity)>,
}

fn gather_bodies(
    mut query: Query<BodyQuery>,
    mut bodies: ResMut<Bodies>,
    mut lagged: ResMut<LaggedContacts>,
    mut cache: ResMut<ContactCache>,
    gravity: Res<Gravity>,
    settings: Res<SolverSettings>,
    origin: Res<RenderOrigin>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
    mut gathering: Local<Gathering>,
    mut removed_colliders: RemovedComponents<Collider>,
) {
    let Gathering { seen, new } = &mut *gathering;
    seen.clear();
    seen.resize(bodies.list.len(), false);
    new.clear();
    for body in &query {
        match bodies.list.get(body.slot.index as usize) {
            Some(known) if known.entity == body.entity => seen[body.slot.index as usize] = true,
            _ => new.push((body.slot.born, body.entity)),
        }
    }
    if seen.contains(&false) {
        cache.clear();
        drop_gone_bodies(seen, &mut bodies, &mut lagged, &mut query);
    }
    new.sort_unstable();
    for &(_, entity) in new.iter() {
        if let Ok(mut body) = query.get_mut(entity) {
            body.slot.index = bodies.list.len() as u32;
            bodies.list.push(Body::new(entity));
        }
    }
    for entity in removed_colliders.read() {
        if let Ok(body) = query.get(entity)
            && let Some(body) = bodies.list.get_mut(body.slot.index as usize)
        {
            body.geometry = None;
            body.radius = 0.0;
        }
    }
    stats.bodies = bodies.list.len() as u32;
    stats.quarantined = 0;
    for mut item in &mut query {
        let index = item.slot.index;
        let body = &mut bodies.list[index as usize];
        if teleport(&mut item, origin.0) {
            lagged.drop_body(index);
            cache.drop_body(index);
        }
        let verdict = gather_body(&item, body, &gravity, &settings, &mut commands);
        let reason = item.quarantined.map(|known| known.reason).or(verdict.err());
        if let Some(reason) = reason {
            stats.quarantined += 1;
            freeze(&mut item, body);
            if item.quarantined.is_none() {
                commands.entity(body.entity).insert(Quarantined { reason });
                commands.trigger(BodyQuarantined { entity: body.entity, reason });
                quarantine.write(BodyQuarantined { entity: body.entity, reason });
            }
        }
    }
}

/// Packs the living bodies again, in their order.
fn drop_gone_bodies(seen: &[bool], bodies: &mut Bodies, lagged: &mut LaggedContacts, query: &mut Query<BodyQuery>) {
    let mut next = 0;
    let new_index: Vec<Option<u32>> = seen
        .iter()
        .map(|&alive| {
            alive.then(|| {
                next += 1;
                next - 1
            })
        })
        .collect();
    lagged.remap(&new_index);
    let mut alive = seen.iter();
    bodies.list.retain(|_| *alive.next().expect("one flag a body"));
    for (index, body) in bodies.list.iter().enumerate() {
        if let Ok(mut item) = query.get_mut(body.entity) {
            item.slot.index = index as u32;
        }
    }
}

/// Takes over a `Transform` that the user changed. Returns whether there was one.
fn teleport(item: &mut BodyQueryItem, origin: DVec3) -> bool {
    if !item.history.is_foreign(item.transform) {
        return false;
    }
    item.position.0 = item.transform.translation.as_dvec3() + origin;
    item.rotation.0 = item.transform.rotation.as_dquat();
    *item.history = PoseHistory { previous: None, written: Some(*item.transform) };
    true
}

/// Copies one body; says what is wrong with it. What is sane is copied even so: a change is seen
/// only once, and a quarantined body keeps its pose and shape.
fn gather_body(
    item: &BodyQueryItem,
    body: &mut Body,
    gravity: &Gravity,
    settings: &SolverSettings,
    commands: &mut Commands,
) -> Result<(), QuarantineReason> {
    body.kind = *item.kind;
    body.layers = item.layers.copied().unwrap_or_default();
    body.reports = item.reports;
    let verdicts = [
        gather_pose(item, body),
        if item.parent.is_some() { Err(QuarantineReason::HasParent) } else { Ok(()) },
        gather_surface(item, body, settings),
        gather_shape(item, body),
        gather_mass(item, body, commands),
        gather_motion(item, body, gravity),
    ];
    verdicts.into_iter().collect()
}

fn gather_pose(item: &BodyQueryItem, body: &mut Body) -> Result<(), QuarantineReason> {
    if !item.position.is_finite() || !item.rotation.is_finite() || item.rotation.length_squared() <= 1e-12 {
        return Err(QuarantineReason::NotFinite);
    }
    body.position = item.position.0.into();
    body.rotation = unit(item.rotation.0);
    Ok(())
}

/// Velocity and force, once the mass is known.
fn gather_motion(item: &BodyQueryItem, body: &mut Body, gravity: &Gravity) -> Result<(), QuarantineReason> {
    let external = item.force.copied().unwrap_or_default();
    let scale = item.gravity_scale.map_or(1.0, |scale| scale.0);
    let (linear, angular) = (Vector3::from(item.velocity.linear), Vector3::from(item.velocity.angular));
    body.force = Vector3::from(external.force) + Vector3::from(gravity.0) * (body.mass * scale);
    body.torque = external.torque.into();
    if [linear, angular, body.force, body.torque].iter().flatten().any(|value| !value.is_finite()) {
        return Err(QuarantineReason::NotFinite);
    }
    let locked = item.locked.copied().unwrap_or_default();
    (body.linear, body.angular) = match body.kind {
        RigidBody::Static => (Vector3::zeros(), Vector3::zeros()),
        RigidBody::Kinematic => (linear, angular),
        RigidBody::Dynamic => {
            (linear.component_mul(&freedom(locked.translation)), angular.component_mul(&freedom(locked.rotation)))
        }
    };
    Ok(())
}

fn gather_surface(item: &BodyQueryItem, body: &mut Body, settings: &SolverSettings) -> Result<(), QuarantineReason> {
    let material = item.material.copied().unwrap_or_default();
    let damping = item.damping.copied().unwrap_or_default();
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

fn gather_shape(item: &BodyQueryItem, body: &mut Body) -> Result<(), QuarantineReason> {
    let Some(collider) = &item.collider else { return Ok(()) };
    if !collider.is_valid() || (body.kind != RigidBody::Static && *collider.shape() == Shape::HalfSpace) {
        body.geometry = None;
        body.radius = 0.0;
        return Err(QuarantineReason::BadMass);
    }
    if collider.is_changed() || body.geometry.is_none() {
        body.geometry = Some(collider.geometry());
        body.radius = collider.bounding_radius();
    }
    Ok(())
}

/// Mass and inertia: as given, or from the collider, computed once and again when it changes.
fn gather_mass(item: &BodyQueryItem, body: &mut Body, commands: &mut Commands) -> Result<(), QuarantineReason> {
    body.mass = 0.0;
    body.inverse_mass = Vector3::zeros();
    body.inverse_inertia_body = Vector3::zeros();
    body.mass_is_stale |= item.collider.as_ref().is_some_and(|collider| collider.is_changed())
        || item.density.as_ref().is_some_and(|density| density.is_changed())
        || item.mass.as_ref().is_some_and(|mass| mass.is_changed());
    if body.kind != RigidBody::Dynamic {
        body.update_inverse_inertia();
        return Ok(());
    }
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let given_mass = item.mass.as_ref().map(|mass| mass.0).filter(|&mass| body.computed_mass != Some(mass));
    let given_inertia =
        item.inertia.as_ref().map(|inertia| inertia.0.into()).filter(|&inertia| body.computed_inertia != Some(inertia));
    if given_mass.is_some() {
        body.computed_mass = None;
    } else if body.mass_is_stale || body.computed_mass.is_none() {
        let density = item.density.as_ref().map_or(Density::default().0, |density| density.0);
        let collider = item.collider.as_ref().ok_or(QuarantineReason::BadMass)?;
        let mass = collider.mass_properties(density).mass;
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
        let collider = item.collider.as_ref().ok_or(QuarantineReason::BadMass)?;
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
    let locked = item.locked.copied().unwrap_or_default();
    body.mass = mass;
    body.inverse_mass = freedom(locked.translation) / mass;
    body.inverse_inertia_body = inertia.map(f64::recip);
    body.rotation_freedom = freedom(locked.rotation);
    body.update_inverse_inertia();
    Ok(())
}

/// 0 along locked axes, 1 else.
fn freedom(locked: [bool; 3]) -> Vector3<f64> {
    Vector3::from(locked.map(|locked| if locked { 0.0 } else { 1.0 }))
}

/// Puts a body back to its last finite pose, standing still; the solver sees it as static.
fn freeze(item: &mut BodyQueryItem, body: &mut Body) {
    body.kind = RigidBody::Static;
    body.linear = Vector3::zeros();
    body.angular = Vector3::zeros();
    body.force = Vector3::zeros();
    body.torque = Vector3::zeros();
    body.mass = 0.0;
    body.inverse_mass = Vector3::zeros();
    body.inverse_inertia_body = Vector3::zeros();
    body.update_inverse_inertia();
    let pose = (DVec3::from(body.position), DQuat::from(body.rotation));
    if item.position.0 != pose.0 || item.rotation.0 != pose.1 {
        (item.position.0, item.rotation.0) = pose;
        item.history.previous = None;
    }
    if *item.velocity != Velocity::default() {
        *item.velocity = Velocity::default();
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

fn gather_joints(
    query: Query<(Entity, &BallJoint, &JointSlot, Option<&Quarantined>)>,
    changed: Query<(), Changed<BallJoint>>,
    members: Query<(&BodySlot, &RigidBody)>,
    mut removed: RemovedComponents<BallJoint>,
    mut released: RemovedComponents<Quarantined>,
    bodies: Res<Bodies>,
    mut joints: ResMut<Joints>,
    mut joined: ResMut<JoinedPairs>,
    mut stats: ResMut<StepStats>,
    mut quarantine: MessageWriter<BodyQuarantined>,
    mut commands: Commands,
    mut packed_bodies: Local<Vec<(Entity, RigidBody)>>,
) {
    let same_bodies = packed_bodies.iter().copied().eq(bodies.list.iter().map(|body| (body.entity, body.kind)));
    let joints_gone = removed.read().count() + released.read().count() > 0;
    if same_bodies && !joints_gone && changed.is_empty() {
        return;
    }
    packed_bodies.clear();
    packed_bodies.extend(bodies.list.iter().map(|body| (body.entity, body.kind)));

    let member = |entity| {
        members.get(entity).ok().filter(|(slot, _)| slot.index != u32::MAX).map(|(slot, &kind)| (slot.index, kind))
    };
    let mut packed: Vec<(u64, Joint, bool)> = Vec::with_capacity(query.iter().len());
    for (entity, joint, slot, quarantined) in &query {
        let (Some((a, kind_a)), Some((b, kind_b))) = (member(joint.body_a), member(joint.body_b)) else {
            commands.entity(entity).despawn();
            continue;
        };
        if quarantined.is_some() {
            continue;
        }
        if let Err(reason) = check_joint(joint, [kind_a, kind_b]) {
            commands.entity(entity).insert(Quarantined { reason });
            commands.trigger(BodyQuarantined { entity, reason });
            quarantine.write(BodyQuarantined { entity, reason });
            continue;
        }
        let force = Vector3::zeros();
        let (anchor_a, anchor_b) = (joint.anchor_a.into(), joint.anchor_b.into());
        packed.push((
            slot.born,
            Joint { entity, a, b, anchor_a, anchor_b, softness: joint.softness, force },
            joint.collide,
        ));
    }
    packed.sort_unstable_by_key(|&(born, ..)| born);
    joined.rebuild(packed.iter().filter(|(.., collide)| !collide).map(|(_, joint, _)| (joint.a, joint.b)));
    joints.list.clear();
    joints.list.extend(packed.into_iter().map(|(_, joint, _)| joint));
    stats.joints = joints.list.len() as u32;
}

fn check_joint(joint: &BallJoint, kinds: [RigidBody; 2]) -> Result<(), QuarantineReason> {
    let soft_is_sane = joint.softness.is_none_or(|Softness { frequency, damping_ratio, max_force }| {
        frequency > 0.0
            && frequency.is_finite()
            && damping_ratio >= 0.0
            && damping_ratio.is_finite()
            && max_force >= 0.0
    });
    if !joint.anchor_a.is_finite() || !joint.anchor_b.is_finite() || !soft_is_sane {
        return Err(QuarantineReason::NotFinite);
    }
    if joint.body_a == joint.body_b || !kinds.contains(&RigidBody::Dynamic) {
        return Err(QuarantineReason::BadJoint);
    }
    Ok(())
}
