//! The types that the state of a world is made of: each is copied and put back by what knows its type.

use std::any::{Any, TypeId};

use bevy::ecs::change_detection::Tick;
use bevy::ecs::component::Mutable;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::query::QueryState;
use bevy::prelude::*;

use crate::physics::body::{Bodies, BodySlot, PoseHistory};
use crate::physics::joint::JointSlot;

/// What is kept is kept of bodies and joints.
pub(super) type IsKept = Or<(With<BodySlot>, With<JointSlot>)>;

/// Says of what types the state of a world is made.
pub trait Keep {
    /// Components of bodies and joints, of that type, which others than the step may write.
    fn keep_component<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
    /// Components of bodies and joints, of that type, which the step writes: others only add and remove them.
    fn keep_result<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
    /// Components of bodies and joints, of that type, on which no step depends: they come back with what they were on,
    /// and are left alone else.
    fn keep_look<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
    /// Components of bodies and joints, of that type, which steps write for whoever wants to know: to put one on is no act.
    fn keep_reading<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
    /// Transforms of bodies: those that others wrote are told by their bits.
    fn keep_transforms(&mut self) -> &mut Self;
    /// A resource that steps write.
    fn keep_resource<R: Resource<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
    /// A resource that others write.
    fn keep_setting<R: Resource<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
}

impl Keep for App {
    fn keep_component<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        keep::<C>(self, Role::Written, None)
    }

    fn keep_result<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        keep::<C>(self, Role::Result, None)
    }

    fn keep_look<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        let mut kinds = self.world_mut().get_resource_or_init::<Kinds>();
        let look = kinds.looks.len();
        kinds.looks.push(|entity, value| {
            if !entity.contains::<C>() {
                entity.insert(value.downcast_ref::<C>().expect("of its own kind").clone());
            }
        });
        let note = move |removed: On<Remove, C>, mut removals: ResMut<Removals>, looks: Query<&C, IsKept>| {
            if removals.is_emptying
                && let Ok(value) = looks.get(removed.entity)
            {
                removals.looks.push((look, removed.entity, Box::new(value.clone())));
            }
        };
        self.init_resource::<Removals>().add_observer(note)
    }

    fn keep_reading<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        keep::<C>(self, Role::Reading, None).keep_look::<C>()
    }

    fn keep_transforms(&mut self) -> &mut Self {
        let is_foreign: IsForeign = |world, body| {
            let history = world.get::<PoseHistory>(body);
            history.zip(world.get::<Transform>(body)).is_some_and(|(history, transform)| history.is_foreign(transform))
        };
        keep::<Transform>(self, Role::Result, Some(is_foreign))
    }

    fn keep_resource<R: Resource<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        keep_value::<R>(self, false)
    }

    fn keep_setting<R: Resource<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        keep_value::<R>(self, true)
    }
}

fn keep_value<R: Resource<Mutability = Mutable> + Clone>(app: &mut App, is_setting: bool) -> &mut App {
    let mut kinds = app.world_mut().get_resource_or_init::<Kinds>();
    kinds.resources.push(ResourceKind::of::<R>(is_setting));
    app
}

fn keep<C: Component<Mutability = Mutable> + Clone>(
    app: &mut App,
    role: Role,
    is_foreign: Option<IsForeign>,
) -> &mut App {
    let world = app.world_mut();
    world.init_resource::<Removals>();
    let mut kinds = world.get_resource_or_init::<Kinds>();
    let kind = kinds.components.len();
    kinds.components.push(Box::new(KindOf::<C> { query: None, role, is_foreign }));
    let note = move |removed: On<Remove, C>, mut removals: ResMut<Removals>, kept: Query<(), IsKept>| {
        if role != Role::Reading && kept.contains(removed.entity) {
            removals.note(kind, removed.entity);
        }
    };
    app.add_observer(note)
}

/// What was taken off bodies and joints, while a history is kept.
#[derive(Resource, Default)]
pub(super) struct Removals {
    /// Since the last step: kinds by their place, and the entities.
    pub list: Vec<(usize, Entity)>,
    /// Entities that were emptied, and may come back.
    pub buried: EntityHashSet,
    /// Whether one is being emptied: its looks are remembered.
    pub is_emptying: bool,
    /// What they looked like: kinds by their place.
    pub looks: Vec<(usize, Entity, AnyValue)>,
    /// Whether a history is kept.
    pub is_read: bool,
}

impl Removals {
    /// Gives those that came back what they looked like.
    pub fn dress(world: &mut World, kinds: &Kinds) {
        if world.resource::<Self>().looks.is_empty() {
            return;
        }
        let looks = std::mem::take(&mut world.resource_mut::<Self>().looks);
        for (look, entity, value) in looks {
            match world.get_entity_mut(entity) {
                Ok(mut entity) if entity.contains::<BodySlot>() || entity.contains::<JointSlot>() => {
                    kinds.looks[look](&mut entity, &value);
                }
                Ok(_) => world.resource_mut::<Self>().looks.push((look, entity, value)),
                Err(_) => {} // gone for good
            }
        }
    }

    fn note(&mut self, kind: usize, entity: Entity) {
        if self.is_read {
            self.list.push((kind, entity));
        }
    }
}

/// All that is kept.
#[derive(Resource, Default)]
pub(super) struct Kinds {
    pub components: Vec<Box<dyn ComponentKind>>,
    /// Gives one of each look to an entity.
    pub looks: Vec<fn(&mut EntityWorldMut, &AnyValue)>,
    pub resources: Vec<ResourceKind>,
    /// What each was in a world without a body; none of those that there were not.
    pub blank: Vec<Option<AnyValue>>,
}

/// By when the last step ended and wrote bodies back it is told how old a value is; none before the first.
#[derive(Clone, Copy)]
pub(super) struct LastStep {
    ended: Option<Tick>,
    wrote_back: Option<Tick>,
    now: Tick,
}

impl LastStep {
    pub fn of(world: &mut World) -> Self {
        let now = world.change_tick();
        let bodies = world.resource::<Bodies>();
        Self { ended: bodies.ended, wrote_back: bodies.written_back, now }
    }

    /// What systems wrote is known to those that look for it. Commands are applied with the tick after that of the last
    /// system, and are news, as is what others write then.
    fn age(&self, tick: Tick) -> Age {
        let is_known = |ended: Tick| !tick.is_newer_than(Tick::new(ended.get().wrapping_sub(1)), self.now);
        match self.ended {
            Some(_) if self.wrote_back == Some(tick) => Age::WrittenBack,
            Some(ended) if is_known(ended) => Age::Known,
            _ => Age::New,
        }
    }
}

/// How old a value is to those that look for new ones in the next step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Age {
    /// They know it.
    Known,
    /// The step itself wrote it back.
    WrittenBack,
    /// It is news.
    New,
}

/// The ticks that stand for ages in a world that is brought back.
#[derive(Clone, Copy)]
pub(super) struct Ticks {
    pub known: Tick,
    pub written_back: Tick,
    pub new: Tick,
}

impl Ticks {
    fn of(&self, age: Age) -> Tick {
        match age {
            Age::Known => self.known,
            Age::WrittenBack => self.written_back,
            Age::New => self.new,
        }
    }
}

/// A type of components.
pub(super) trait ComponentKind: Send + Sync {
    /// Which.
    fn component(&self) -> TypeId;
    /// All of them.
    fn copy(&mut self, world: &mut World, last: &LastStep) -> Box<dyn Column>;
    /// Those that were written, or of results added, since then.
    fn written(&mut self, world: &mut World, since: Tick) -> Option<Box<dyn Column>>;
    /// The entities that have one, and must not where they had none.
    fn holders(&mut self, world: &mut World) -> Vec<Entity>;
    /// Takes it off.
    fn remove(&self, entity: &mut EntityWorldMut);
}

/// Whether somebody else wrote the component of that entity.
type IsForeign = fn(&World, Entity) -> bool;

/// Who writes components of a type.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// The step and others.
    Written,
    /// The step; others add and remove them.
    Result,
    /// The step, for those that want to know.
    Reading,
}

struct KindOf<C: Component> {
    query: Option<QueryState<(Entity, Ref<'static, C>), IsKept>>,
    role: Role,
    /// Of results: tells what others wrote.
    is_foreign: Option<IsForeign>,
}

impl<C: Component> KindOf<C> {
    fn query(&mut self, world: &mut World) -> &mut QueryState<(Entity, Ref<'static, C>), IsKept> {
        self.query.get_or_insert_with(|| world.query_filtered())
    }
}

impl<C: Component<Mutability = Mutable> + Clone> ComponentKind for KindOf<C> {
    fn component(&self) -> TypeId {
        TypeId::of::<C>()
    }

    fn copy(&mut self, world: &mut World, last: &LastStep) -> Box<dyn Column> {
        let all = self.query(world).iter(world);
        let list = all.map(|(entity, value)| Value::<C> {
            entity,
            changed: last.age(value.last_changed()),
            added: last.age(value.added()),
            value: C::clone(&value),
        });
        Values::boxed(list.collect(), self.role)
    }

    fn written(&mut self, world: &mut World, since: Tick) -> Option<Box<dyn Column>> {
        if self.role == Role::Reading {
            return None;
        }
        let (now, role) = (world.change_tick(), self.role);
        let is_foreign = self.is_foreign;
        let all = self.query(world).iter(world);
        let written = all.filter(|(entity, value)| {
            let is_changed = value.last_changed().is_newer_than(since, now);
            let is_added = || value.added().is_newer_than(since, now);
            is_changed && (role == Role::Written || is_added() || is_foreign.is_some_and(|is| is(world, *entity)))
        });
        let list: Vec<_> = written
            .map(|(entity, value)| Value::<C> { entity, changed: Age::New, added: Age::New, value: C::clone(&value) })
            .collect();
        (!list.is_empty()).then(|| Values::boxed(list, role))
    }

    fn holders(&mut self, world: &mut World) -> Vec<Entity> {
        if self.role == Role::Reading {
            return Vec::new();
        }
        self.query(world).iter(world).map(|(entity, _)| entity).collect()
    }

    fn remove(&self, entity: &mut EntityWorldMut) {
        entity.remove::<C>();
    }
}

/// Components of one type.
pub(super) trait Column: Send + Sync {
    /// Which.
    fn component(&self) -> TypeId;
    /// The entities that have one, ascending.
    fn entities(&self) -> Vec<Entity>;
    /// Gives it to those that have none. To be followed by one of the next two: this may change others beside it.
    fn put_on(&self, world: &mut World);
    /// Sets all to what they were, and as old.
    fn set(&self, world: &mut World, ticks: &Ticks);
    /// Writes them as news.
    fn write(&self, world: &mut World);
    /// What they take, bytes, but for what they own elsewhere.
    fn bytes(&self) -> usize;
}

struct Value<C> {
    entity: Entity,
    changed: Age,
    added: Age,
    value: C,
}

struct Values<C> {
    /// By entity, ascending.
    list: Vec<Value<C>>,
    role: Role,
}

impl<C: Component<Mutability = Mutable> + Clone> Values<C> {
    fn boxed(mut list: Vec<Value<C>>, role: Role) -> Box<dyn Column> {
        list.sort_unstable_by_key(|value| value.entity);
        Box::new(Self { list, role })
    }
}

impl<C: Component<Mutability = Mutable> + Clone> Column for Values<C> {
    fn component(&self) -> TypeId {
        TypeId::of::<C>()
    }

    fn entities(&self) -> Vec<Entity> {
        self.list.iter().map(|value| value.entity).collect()
    }

    fn put_on(&self, world: &mut World) {
        if self.role == Role::Reading {
            return;
        }
        for Value { entity, value, .. } in &self.list {
            if let Ok(mut entity) = world.get_entity_mut(*entity)
                && !entity.contains::<C>()
            {
                entity.insert(value.clone());
            }
        }
    }

    fn set(&self, world: &mut World, ticks: &Ticks) {
        for Value { entity, changed, added, value } in &self.list {
            if let Some(mut present) = world.get_mut::<C>(*entity) {
                present.bypass_change_detection().clone_from(value);
                present.set_last_changed(ticks.of(*changed));
                present.set_last_added(ticks.of(*added));
            }
        }
    }

    fn write(&self, world: &mut World) {
        for Value { entity, value, .. } in &self.list {
            if let Some(mut present) = world.get_mut::<C>(*entity) {
                present.clone_from(value);
            }
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Value<C>>() * self.list.len()
    }
}

/// A value of some type.
pub(super) type AnyValue = Box<dyn Any + Send + Sync>;

/// A type of resources.
#[derive(Clone, Copy)]
pub(super) struct ResourceKind {
    /// Which.
    pub resource: fn() -> TypeId,
    /// None where there is none.
    pub copy: fn(&World) -> Option<AnyValue>,
    /// As it was, last written then.
    pub put_back: fn(&mut World, &AnyValue, Tick),
    /// As news.
    pub write: fn(&mut World, &AnyValue),
    /// If others write it, and did since then.
    pub written: fn(&World, Tick) -> Option<AnyValue>,
    /// Whether others write it.
    pub is_setting: bool,
}

impl ResourceKind {
    fn of<R: Resource<Mutability = Mutable> + Clone>(is_setting: bool) -> Self {
        Self {
            resource: TypeId::of::<R>,
            copy: |world| Some(Box::new(world.get_resource::<R>()?.clone())),
            put_back: |world, value, tick| {
                let value = value.downcast_ref::<R>().expect("of its own kind");
                // Readings are there only while somebody wants them.
                if let Some(mut present) = world.get_resource_mut::<R>() {
                    present.bypass_change_detection().clone_from(value);
                    present.set_last_changed(tick);
                }
            },
            write: |world, value| {
                world.insert_resource(value.downcast_ref::<R>().expect("of its own kind").clone());
            },
            written: if is_setting {
                |world, since| {
                    let value = world.get_resource_ref::<R>()?;
                    let is_new = value.last_changed().is_newer_than(since, world.read_change_tick());
                    is_new.then(|| Box::new(R::clone(&value)) as AnyValue)
                }
            } else {
                |_, _| None
            },
            is_setting,
        }
    }
}
