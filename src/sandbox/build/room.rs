//! Room for several bodies at once, among those that are there.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::physics::{Collider, CollisionLayers, PlacedCollider, Position, RigidBody, Rotation, Shape};
use crate::scene::{BodySpec, SceneSpec};

/// Gap to what is there, in mean bounding radii.
const GAP: f64 = 0.02;
/// Least step out of an overlap, in mean bounding radii, and how many are made at most.
const STEP: f64 = 0.1;
const MOST_STEPS: usize = 1000;

/// The bodies of a scene, to be moved as one.
pub struct Crowd {
    bodies: Vec<(Collider, BodySpec)>,
    /// Mean bounding radius, m.
    size: f64,
}

impl Crowd {
    /// Of a scene; what is drawn of it.
    pub fn new(scene: &SceneSpec) -> Self {
        let shaped = scene.bodies.iter().filter_map(|body| Some((body.shape.as_ref()?.collider(), body.clone())));
        let bodies: Vec<(Collider, BodySpec)> = shaped.filter(|(collider, _)| !collider.shape().is_ground()).collect();
        let radii: f64 = bodies.iter().map(|(collider, _)| collider.bounding_radius()).sum();
        Self { size: radii / bodies.len().max(1) as f64, bodies }
    }

    /// The gap that is left to what is there, m.
    pub fn gap(&self) -> f64 {
        GAP * self.size
    }

    /// From where to where it reaches along a unit direction, m.
    pub fn extent(&self, along: DVec3) -> [f64; 2] {
        let ends = self.bodies.iter().map(|(collider, body)| {
            let at = body.position.dot(along);
            let reach = |along: DVec3| reach(collider, body.principal_rotation(), along);
            [at - reach(-along), at + reach(along)]
        });
        ends.reduce(|one, other| [one[0].min(other[0]), one[1].max(other[1])]).unwrap_or([0.0; 2])
    }

    /// The middle of the box that it fills, m.
    pub fn middle(&self) -> DVec3 {
        DVec3::from_array([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let [low, high] = self.extent(axis);
            0.5 * (low + high)
        }))
    }

    /// From that offset on along a unit direction, the first at which it overlaps nothing but `own` bodies; none within reach.
    pub fn room(&self, world: &mut World, own: &[Entity], from: DVec3, along: DVec3) -> Option<DVec3> {
        let mut query =
            world.query::<(Entity, &Collider, &Position, &Rotation, Option<&CollisionLayers>, &RigidBody)>();
        let others: Vec<_> = query.iter(world).filter(|(entity, ..)| !own.contains(entity)).collect();
        let mut offset = from;
        for _ in 0..MOST_STEPS {
            let overlaps = self.bodies.iter().flat_map(|(collider, body)| {
                let place = |position| PlacedCollider {
                    collider,
                    position: Position(position),
                    rotation: Rotation(body.principal_rotation()),
                };
                let (before, now) = (place(body.position), place(body.position + offset));
                others.iter().filter_map(move |(_, other, position, rotation, layers, _)| {
                    if !layers.copied().unwrap_or_default().interact(body.layers) {
                        return None;
                    }
                    let other = PlacedCollider { collider: other, position: **position, rotation: **rotation };
                    let depth = now.overlap(&other)?;
                    // What lies on the ground goes on lying as deep in it.
                    let is_ground = other.collider.shape().is_ground();
                    let deepest = if is_ground { before.overlap(&other).unwrap_or(0.0) + 1e-9 } else { 0.0 };
                    (depth > deepest).then_some(depth)
                })
            });
            let Some(depth) = overlaps.reduce(f64::max) else { return Some(offset) };
            offset += along * (depth + self.gap()).max(STEP * self.size);
        }
        None
    }
}

/// How far a shape of that orientation reaches from its centre of mass along a unit direction, m.
pub fn reach(collider: &Collider, rotation: DQuat, along: DVec3) -> f64 {
    if let Shape::Mesh(mesh) = collider.shape() {
        let along = rotation.inverse() * along;
        return mesh.vertices().map(|vertex| vertex.dot(along)).fold(f64::NEG_INFINITY, f64::max);
    }
    let own = PlacedCollider { collider, position: Position(DVec3::ZERO), rotation: Rotation(rotation) };
    // A plane through the centre whose inside is where it reaches to.
    let plane = PlacedCollider {
        collider: &Collider::half_space(),
        position: Position(DVec3::ZERO),
        rotation: Rotation(DQuat::from_rotation_arc(DVec3::Y, -along)),
    };
    own.overlap(&plane).unwrap_or_else(|| collider.bounding_radius())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ShapeSpec;

    fn two_boxes() -> SceneSpec {
        let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, 2.0, 4.0) };
        let body = |name: &str, x: f64| BodySpec::new(name, shape.clone(), DVec3::new(x, 1.0, 0.0));
        SceneSpec { bodies: vec![body("a", 0.0), body("b", 3.0)], ..SceneSpec::new("two", DVec3::ZERO) }
    }

    #[test]
    fn a_crowd_reaches_from_its_first_face_to_its_last() {
        let crowd = Crowd::new(&two_boxes());
        let [low, high] = crowd.extent(DVec3::X);
        assert!((low + 0.5).abs() < 1e-9 && (high - 3.5).abs() < 1e-9, "{low} {high}");
        assert!(crowd.middle().abs_diff_eq(DVec3::new(1.5, 1.0, 0.0), 1e-9), "{}", crowd.middle());
    }

    #[test]
    fn it_goes_on_until_nothing_is_in_its_way() {
        let mut world = World::new();
        let obstacle = (RigidBody::Static, Collider::cuboid(1.0, 1.0, 1.0));
        world.spawn((obstacle.clone(), Position(DVec3::new(8.0, 1.0, 0.0)), Rotation::default()));
        let crowd = Crowd::new(&two_boxes());
        let offset = crowd.room(&mut world, &[], DVec3::X * 4.2, DVec3::X).expect("room");
        assert!(offset.x > 6.0 && offset.x < 6.5, "it is between the two, free of both: {offset}");
        let free = crowd.room(&mut world, &[], DVec3::X * -4.2, DVec3::X).expect("room");
        assert_eq!(free, DVec3::X * -4.2, "where nothing is, nothing moves it");
    }
}
