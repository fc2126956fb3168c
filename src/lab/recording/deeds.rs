//! Acts as text: each value by its type's name, as reflection writes it, entities by their numbers.
//!
//! A collider that is a hull is written as the scene file of that one body: its points, or its mesh.

use std::any::TypeId;

use bevy::prelude::*;
use bevy::reflect::serde::{
    ReflectDeserializerProcessor, ReflectSerializerProcessor, TypedReflectDeserializer, TypedReflectSerializer,
};
use bevy::reflect::{PartialReflect, TypeRegistration, TypeRegistry};
use serde::de::{DeserializeSeed, Error as _};
use serde::{Deserialize, Serialize};

use super::numbers::Numbers;
use crate::physics::{
    BallJoint, BirthCounter, BodySlot, Breakable, BrokenJoint, Collider, CollisionLayers, Damping, Deeds, Density,
    DistanceJoint, ExternalForce, FixedJoint, GenericJoint, Gravity, GravityScale, HingeJoint, Inertia,
    JointCoordinate, JointFriction, JointLimits, JointMotor, JointSlot, LockedAxes, Mass, ObserveContacts, Position,
    Quarantined, ReportCollisions, RigidBody, Rotation, Sensor, Shape, SliderJoint, SolverSettings, SurfaceMaterial,
    Velocity, bury,
};
use crate::scene::{BodyColor, BodySpec, SceneEntity, SceneSpec};

/// What was done, entities by their numbers, types by their names.
#[derive(Serialize, Deserialize, Debug, Default, PartialEq)]
#[serde(deny_unknown_fields, default)]
struct DeedEntry {
    buried: Vec<u32>,
    removed: Vec<(u32, String)>,
    /// The names of those that are new.
    names: Vec<(u32, String)>,
    written: Vec<(u32, Vec<(String, String)>)>,
    /// When those that are bodies or joints since were made, after (before: negative) the last of the scene: the solver
    /// takes them in that order.
    births: Vec<(u32, i64)>,
    resources: Vec<(String, String)>,
}

/// The types that can be told.
pub(super) struct Kinds {
    registry: TypeRegistry,
    gravity: TypeId,
    settings: TypeId,
    /// The last birth of the scene.
    births: u64,
}

impl Kinds {
    /// For a world into which a scene was spawned, and no more.
    pub fn new(world: &World) -> Self {
        let mut registry = TypeRegistry::default();
        macro_rules! register {
            ($($kind:ty),* $(,)?) => { $(registry.register::<$kind>();)* };
        }
        register!(RigidBody, Position, Rotation, Velocity, Collider, Mass, Density, Inertia, ExternalForce, Damping);
        register!(
            SurfaceMaterial,
            CollisionLayers,
            LockedAxes,
            GravityScale,
            ReportCollisions,
            ObserveContacts,
            Sensor
        );
        register!(Quarantined, Transform, BallJoint, HingeJoint, SliderJoint, FixedJoint, DistanceJoint, GenericJoint);
        register!(
            JointLimits,
            JointMotor,
            JointFriction,
            JointCoordinate,
            Breakable,
            BrokenJoint,
            SceneEntity,
            BodyColor
        );
        register!(Gravity, SolverSettings);
        Self {
            registry,
            gravity: TypeId::of::<Gravity>(),
            settings: TypeId::of::<SolverSettings>(),
            births: world.resource::<BirthCounter>().last(),
        }
    }

    /// What was done, to a world as it was left. None if nothing of it can be told, as it is all of what follows from the
    /// rest.
    pub fn write(&self, world: &World, deeds: &Deeds, numbers: &mut Numbers) -> Option<String> {
        let name = |kind: TypeId| Some(self.registry.get_type_info(kind)?.type_path_table().short_path().to_owned());
        let removed = deeds.removed.iter().filter(|(_, entity)| !deeds.buried.contains(entity));
        let mut entry = DeedEntry {
            buried: deeds.buried.iter().filter_map(|&entity| numbers.known(entity)).collect(),
            removed: removed.filter_map(|&(kind, entity)| Some((numbers.known(entity)?, name(kind)?))).collect(),
            ..default()
        };
        let mut entities: Vec<Entity> = deeds.written.iter().map(|&(_, entity)| entity).collect();
        // In the order in which they were made: bodies and joints are numbered so again.
        entities.sort_unstable_by_key(|&entity| (born(world, entity), entity));
        entities.dedup();
        // All have numbers before one refers to another.
        let is_new: Vec<bool> = entities.iter().map(|&entity| numbers.known(entity).is_none()).collect();
        entities.iter().for_each(|&entity| _ = numbers.number(entity));
        for (entity, is_new) in entities.into_iter().zip(is_new) {
            let Ok(whole) = world.get_entity(entity) else { continue };
            let number = numbers.number(entity);
            let mut kinds: Vec<TypeId> =
                deeds.written.iter().filter(|(_, written)| *written == entity).map(|&(kind, _)| kind).collect();
            // It becomes a body with the pose and the transform that it has by then.
            kinds.sort_by_key(|&kind| kind == TypeId::of::<RigidBody>());
            if is_new {
                kinds.extend([TypeId::of::<SceneEntity>(), TypeId::of::<BodyColor>()]);
                let named = whole.get::<Name>().map(|name| (number, name.as_str().to_owned()));
                entry.names.extend(named);
            }
            let values = kinds.into_iter().filter_map(|kind| {
                let component = self.registry.get_type_data::<ReflectComponent>(kind)?;
                let value = component.reflect(whole)?;
                let hull = (kind == TypeId::of::<Collider>()).then(|| shape_text(world, entity)).flatten();
                let text = hull.or_else(|| self.value_text(value.as_partial_reflect(), numbers))?;
                Some((name(kind)?, text))
            });
            let values: Vec<_> = values.collect();
            // One that is new is told even so: numbers are given in turn.
            if is_new || !values.is_empty() {
                entry.written.push((number, values));
            }
            if deeds.written.iter().any(|&(kind, written)| written == entity && Self::is_slot(kind)) {
                let (_, born) = born(world, entity);
                entry.births.push((number, born.wrapping_sub(self.births) as i64));
            }
        }
        let resources = deeds.resources.iter().filter_map(|&kind| {
            let value: &dyn PartialReflect = match kind {
                kind if kind == self.gravity => world.resource::<Gravity>(),
                kind if kind == self.settings => world.resource::<SolverSettings>(),
                _ => return None,
            };
            Some((name(kind)?, self.value_text(value, numbers)?))
        });
        entry.resources = resources.collect();
        (entry != DeedEntry::default()).then(|| ron::to_string(&entry).expect("plain structures"))
    }

    /// Does the same to another world.
    ///
    /// # Errors
    /// What the text has that makes no sense.
    pub fn perform(&self, text: &str, world: &mut World, numbers: &mut Numbers) -> Result<(), String> {
        let entry: DeedEntry = ron::from_str(text).map_err(|error| error.code.to_string())?;
        let known = |numbers: &Numbers, number| numbers.entity(number).ok_or(format!("there is no entity {number}"));
        for number in entry.buried {
            bury(world, known(numbers, number)?);
        }
        for (number, kind) in entry.removed {
            let component = self.component(&kind)?.1;
            if let Ok(mut entity) = world.get_entity_mut(known(numbers, number)?) {
                component.remove(&mut entity);
            }
        }
        for &(number, _) in &entry.written {
            if number as usize == numbers.entities().len() {
                numbers.number(world.spawn_empty().id());
            }
            // Where no history is kept, what was buried is gone for good, and another entity takes its place.
            if world.get_entity(known(numbers, number)?).is_err() {
                numbers.renumber(number, world.spawn_empty().id());
            }
        }
        for (number, name) in entry.names {
            world.entity_mut(known(numbers, number)?).insert(Name::new(name));
        }
        for (number, values) in entry.written {
            let entity = known(numbers, number)?;
            for (kind, text) in values {
                let (registration, component) = self.component(&kind)?;
                let Ok(mut entity) = world.get_entity_mut(entity) else { continue };
                if registration.type_id() == TypeId::of::<Collider>()
                    && let Some(collider) = shape_of(&text)?
                {
                    entity.insert(collider);
                    continue;
                }
                let value = self.value(registration, &text, numbers)?;
                component.insert(&mut entity, value.as_ref(), &self.registry);
            }
        }
        for (number, birth) in entry.births {
            let entity = known(numbers, number)?;
            let birth = self.births.wrapping_add_signed(birth);
            world.resource_mut::<BirthCounter>().give(birth);
            if let Some(mut slot) = world.get_mut::<BodySlot>(entity) {
                slot.born = birth;
            }
            if let Some(mut slot) = world.get_mut::<JointSlot>(entity) {
                slot.born = birth;
            }
        }
        for (kind, text) in entry.resources {
            let registration = self.registration(&kind)?;
            let value = self.value(registration, &text, numbers)?;
            let of_kind = || format!("a {kind} that is none: {text}");
            match registration.type_id() {
                kind if kind == self.gravity => {
                    world.insert_resource(Gravity::from_reflect(value.as_ref()).ok_or_else(of_kind)?);
                }
                kind if kind == self.settings => {
                    let settings = SolverSettings::from_reflect(value.as_ref()).ok_or_else(of_kind)?;
                    settings.validate().map_err(|error| error.to_string())?;
                    world.insert_resource(settings);
                }
                _ => return Err(format!("{kind} is no resource that can be told")),
            }
        }
        Ok(())
    }

    fn is_slot(kind: TypeId) -> bool {
        [TypeId::of::<BodySlot>(), TypeId::of::<JointSlot>()].contains(&kind)
    }

    fn registration(&self, kind: &str) -> Result<&TypeRegistration, String> {
        self.registry.get_with_short_type_path(kind).ok_or_else(|| format!("nothing is called {kind}"))
    }

    fn component(&self, kind: &str) -> Result<(&TypeRegistration, &ReflectComponent), String> {
        let registration = self.registration(kind)?;
        let component = registration.data::<ReflectComponent>().ok_or_else(|| format!("{kind} is no component"))?;
        Ok((registration, component))
    }

    fn value_text(&self, value: &dyn PartialReflect, numbers: &Numbers) -> Option<String> {
        let processor = ByNumber(numbers);
        ron::to_string(&TypedReflectSerializer::with_processor(value, &self.registry, &processor)).ok()
    }

    fn value(
        &self,
        registration: &TypeRegistration,
        text: &str,
        numbers: &Numbers,
    ) -> Result<Box<dyn PartialReflect>, String> {
        let mut parser = ron::Deserializer::from_str(text).map_err(|error| error.code.to_string())?;
        let mut processor = ByNumber(numbers);
        TypedReflectDeserializer::with_processor(registration, &self.registry, &mut processor)
            .deserialize(&mut parser)
            .map_err(|error| format!("{}: {error}", registration.type_info().type_path_table().short_path()))
    }
}

/// When a body or joint was made: bodies come before joints.
fn born(world: &World, entity: Entity) -> (bool, u64) {
    let body = world.get::<BodySlot>(entity).map(|slot| (false, slot.born));
    body.or_else(|| world.get::<JointSlot>(entity).map(|slot| (true, slot.born))).unwrap_or((true, u64::MAX))
}

/// The scene file of a body whose shape is no plain one.
fn shape_text(world: &World, entity: Entity) -> Option<String> {
    if !matches!(world.get::<Collider>(entity)?.shape(), Shape::Hull(_) | Shape::Compound(_) | Shape::Mesh(_)) {
        return None;
    }
    let mut body = BodySpec::of_entity(world, entity)?;
    (body.name, body.mass, body.inertia) = ("hull".to_owned(), None, None);
    let mut scene = SceneSpec::new("hull", Vec3::ZERO.as_dvec3());
    scene.bodies.push(body);
    scene.to_ron(None).ok()
}

/// The collider of such a text; none of another.
fn shape_of(text: &str) -> Result<Option<Collider>, String> {
    if !text.contains("bodies") {
        return Ok(None);
    }
    let scene = SceneSpec::from_ron(text, "a hull").map_err(|error| error.to_string())?;
    Ok(scene.bodies.first().and_then(|body| Some(body.shape.as_ref()?.collider())))
}

/// Writes and reads entities by their numbers.
struct ByNumber<'a>(&'a Numbers);

impl ReflectSerializerProcessor for ByNumber<'_> {
    fn try_serialize<S: serde::Serializer>(
        &self,
        value: &dyn PartialReflect,
        _: &TypeRegistry,
        serializer: S,
    ) -> Result<Result<S::Ok, S>, S::Error> {
        let Some(&entity) = value.try_downcast_ref::<Entity>() else { return Ok(Err(serializer)) };
        let number = self.0.known(entity);
        let number = number.ok_or_else(|| serde::ser::Error::custom("it refers to what is not there"))?;
        serializer.serialize_u32(number).map(Ok)
    }
}

impl ReflectDeserializerProcessor for ByNumber<'_> {
    fn try_deserialize<'de, D: serde::Deserializer<'de>>(
        &mut self,
        registration: &TypeRegistration,
        _: &TypeRegistry,
        deserializer: D,
    ) -> Result<Result<Box<dyn PartialReflect>, D>, D::Error> {
        if registration.type_id() != TypeId::of::<Entity>() {
            return Ok(Err(deserializer));
        }
        let number = u32::deserialize(deserializer)?;
        let entity = self.0.entity(number).ok_or_else(|| D::Error::custom(format!("there is no entity {number}")))?;
        Ok(Ok(Box::new(entity)))
    }
}
