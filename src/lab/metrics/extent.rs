//! How far bodies reach.

use bevy::math::DVec3;

use crate::physics::ConvexHull;
use crate::scene::{BodySpec, ChildSpec, SceneSpec, ShapeSpec};

/// Extent of some bodies at their start along gravity, m.
pub(super) fn height<'a>(scene: &SceneSpec, bodies: impl Iterator<Item = &'a BodySpec>) -> f64 {
    let Some(down) = scene.gravity.try_normalize() else { return 0.0 };
    let (lowest, highest) = bodies.fold((f64::NEG_INFINITY, f64::INFINITY), |(lowest, highest), body| {
        let depth = body.position.dot(down);
        (lowest.max(depth + reach(body, down)), highest.min(depth - reach(body, -down)))
    });
    (lowest - highest).max(0.0)
}

/// How far a body reaches from its centre of mass along a unit direction.
fn reach(body: &BodySpec, direction: DVec3) -> f64 {
    body.shape.as_ref().map_or(0.0, |shape| reach_of(shape, body.rotation.inverse() * direction))
}

/// Likewise, of a shape in the axes that it is given in.
fn reach_of(shape: &ShapeSpec, direction: DVec3) -> f64 {
    match shape {
        ShapeSpec::HalfSpace => 0.0,
        ShapeSpec::Sphere { radius } => *radius,
        ShapeSpec::Cuboid { size } => (0.5 * *size).dot(direction.abs()),
        ShapeSpec::Capsule { radius, length } => radius + 0.5 * length * direction.y.abs(),
        ShapeSpec::Cylinder { radius, height } => {
            radius * direction.x.hypot(direction.z) + 0.5 * height * direction.y.abs()
        }
        ShapeSpec::Cone { radius, height } => {
            let apex = 0.75 * height * direction.y;
            let rim = radius * direction.x.hypot(direction.z) - 0.25 * height * direction.y;
            apex.max(rim)
        }
        // The hull of pieces is that of the whole.
        ShapeSpec::Mesh(mesh) if mesh.pieces().is_some() => {
            let places = mesh.mesh().positions.iter().map(|&place| place * mesh.scale() - mesh.center());
            places.map(|place| place.dot(direction)).fold(0.0, f64::max)
        }
        ShapeSpec::Hull(_) | ShapeSpec::Mesh(_) => {
            let direction = shape.axes().inverse() * direction;
            let vertices = shape.convex_hull().into_iter().flat_map(ConvexHull::vertices);
            vertices.map(|vertex| vertex.dot(direction)).fold(0.0, f64::max)
        }
        ShapeSpec::Compound(compound) => {
            let center = compound.compound().center();
            let children = compound.children().iter().map(|ChildSpec { shape, position, rotation }| {
                (*position - center).dot(direction) + reach_of(shape, rotation.inverse() * direction)
            });
            children.fold(0.0, f64::max)
        }
        ShapeSpec::Surface(surface) => {
            surface.mesh().vertices().map(|vertex| vertex.dot(direction)).fold(0.0, f64::max)
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;

    use super::*;

    #[test]
    fn height_is_the_extent_along_gravity() {
        let cuboid = ShapeSpec::Cuboid { size: DVec3::new(2.0, 4.0, 6.0) };
        let mut upright = BodySpec::new("a", cuboid, DVec3::new(0.0, 2.0, 0.0));
        let cone = BodySpec::new("b", ShapeSpec::Cone { radius: 1.0, height: 4.0 }, DVec3::new(0.0, 10.0, 0.0));
        let scene = |gravity| SceneSpec::new("height", gravity);
        let down = scene(DVec3::NEG_Y * 9.81);
        assert_eq!(height(&down, [&upright, &cone].into_iter()), 13.0);
        assert_eq!(height(&down, [&upright].into_iter()), 4.0);
        assert_eq!(height(&scene(DVec3::Z), [&upright].into_iter()), 6.0);
        assert_eq!(height(&scene(DVec3::ZERO), [&upright].into_iter()), 0.0);
        upright.rotation = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        assert!((height(&down, [&upright].into_iter()) - 6.0).abs() < 1e-12);
    }
}
