//! Names: both preludes side by side, components that reflect.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::reflect::{GetTypeRegistration, TypeRegistry};
use plumb::prelude::*;

/// Every name of Plumb's prelude next to all of Bevy's: an ambiguous one would not compile.
#[test]
fn both_preludes_can_be_glob_imported() {
    fn named<T>() -> usize {
        std::mem::size_of::<T>()
    }
    let sizes = [
        named::<(BallJoint, BodyQuarantined, Collider, Collision, CollisionLayers, ContactEnded)>(),
        named::<(ContactModel, ContactStarted, ConvexHull, Damping, Density, ExternalForce, FrictionModel, Gravity)>(),
        named::<(GravityScale, Inertia, Integrator, JointLoad, LockedAxes, Mass, Method, ObserveContacts)>(),
        named::<(Position, Precision, Quarantined, RenderOrigin, ReportCollisions, RigidBody, Rotation)>(),
        named::<(Sleeping, Softness, SolverSettings, StepStats, SurfaceMaterial, Velocity, PhysicsPlugin)>(),
        named::<(PhysicsSchedule, PhysicsSystems, PhysicsQuery, PlacedCollider, QueryFilter, Ray, RayHit)>(),
        named::<(CastHit, PointHit, Sensor, SensorStarted, SensorEnded)>(),
        named::<(App, Entity, Transform, Vec3, Quat, Time<Fixed>, World, Name, GlobalTransform)>(),
    ];
    assert!(sizes.iter().sum::<usize>() > 0);
}

#[test]
fn components_and_resources_reflect() {
    fn is_component<T: GetTypeRegistration>(registry: &mut TypeRegistry) -> bool {
        registry.register::<T>();
        registry.get_type_data::<ReflectComponent>(std::any::TypeId::of::<T>()).is_some()
    }
    let registry = &mut TypeRegistry::default();
    for (name, is_component) in [
        ("BallJoint", is_component::<BallJoint>(registry)),
        ("Collider", is_component::<Collider>(registry)),
        ("CollisionLayers", is_component::<CollisionLayers>(registry)),
        ("Damping", is_component::<Damping>(registry)),
        ("Density", is_component::<Density>(registry)),
        ("ExternalForce", is_component::<ExternalForce>(registry)),
        ("GravityScale", is_component::<GravityScale>(registry)),
        ("Inertia", is_component::<Inertia>(registry)),
        ("JointLoad", is_component::<JointLoad>(registry)),
        ("LockedAxes", is_component::<LockedAxes>(registry)),
        ("Mass", is_component::<Mass>(registry)),
        ("ObserveContacts", is_component::<ObserveContacts>(registry)),
        ("Position", is_component::<Position>(registry)),
        ("Quarantined", is_component::<Quarantined>(registry)),
        ("ReportCollisions", is_component::<ReportCollisions>(registry)),
        ("Sensor", is_component::<Sensor>(registry)),
        ("RigidBody", is_component::<RigidBody>(registry)),
        ("Rotation", is_component::<Rotation>(registry)),
        ("Sleeping", is_component::<Sleeping>(registry)),
        ("SurfaceMaterial", is_component::<SurfaceMaterial>(registry)),
        ("Velocity", is_component::<Velocity>(registry)),
    ] {
        assert!(is_component, "{name} does not reflect as a component");
    }
    for id in [
        std::any::TypeId::of::<Gravity>(),
        std::any::TypeId::of::<RenderOrigin>(),
        std::any::TypeId::of::<SolverSettings>(),
        std::any::TypeId::of::<StepStats>(),
    ] {
        registry.register::<Gravity>();
        registry.register::<RenderOrigin>();
        registry.register::<SolverSettings>();
        registry.register::<StepStats>();
        assert!(registry.get_type_data::<ReflectResource>(id).is_some());
    }
}

#[test]
fn a_joint_follows_its_entities_into_another_world() {
    use bevy::ecs::entity::{EntityHashMap, MapEntities};
    let mut world = World::new();
    let [a, b, a_there, b_there] = std::array::from_fn(|_| world.spawn_empty().id());
    let mut joint = BallJoint::new(a, b).with_anchors(DVec3::X, DVec3::Y);
    let mut map: EntityHashMap<Entity> = [(a, a_there), (b, b_there)].into_iter().collect();
    joint.map_entities(&mut map);
    assert_eq!(joint, BallJoint::new(a_there, b_there).with_anchors(DVec3::X, DVec3::Y));
}

#[test]
fn a_world_without_bodies_steps() {
    crate::rig::start_pool();
    let mut app = headless_app();
    for _ in 0..3 {
        step(app.world_mut());
    }
    assert_eq!(app.world().resource::<StepStats>().steps, 3);
}
