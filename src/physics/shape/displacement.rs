//! How far a body's farthest material point moves between two poses.
//!
//! A point x of the body, from its centre of mass in its first pose, moves by u = d + (Q − 1) x, where d is the centre's
//! displacement and Q the rotation from the first pose to the second. |u|² is convex in x: it is largest at an extreme
//! point of the shape, at a corner of a polyhedron. Of a rotation by φ about a unit axis n, (Q − 1) x is x's part across
//! n, turned and times 2 sin φ/2.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};

use super::{Collider, CompoundChild, Shape};

/// Points of a rim that are looked at first, and how often the interval about the farthest is cut after that: to
/// 1e-9 of a turn.
const RIM: usize = 32;
const CUTS: usize = 40;

impl Collider {
    /// Distance that the farthest material point moves, m, where the centre of mass moves by `centre`, m, and the body
    /// turns from the first rotation to the second. Of a half-space, which reaches without end, only the centre counts.
    pub fn largest_displacement(&self, centre: DVec3, [from, to]: [DQuat; 2]) -> f64 {
        let turn = Turn::between(from, to);
        let moves = |point: DVec3| (centre + turn.displace(from * point)).length();
        let farthest = |points: &mut dyn Iterator<Item = DVec3>| points.map(moves).fold(0.0, f64::max);
        match self.shape() {
            Shape::HalfSpace => centre.length(),
            Shape::Sphere { radius } => turn.moves_ball(centre, *radius),
            // It is the convex hull of two balls.
            Shape::Capsule { radius, length } => {
                let ends = [-0.5, 0.5].map(|end| centre + turn.displace(from * (DVec3::Y * (end * length))));
                ends.map(|end| turn.moves_ball(end, *radius)).into_iter().fold(0.0, f64::max)
            }
            Shape::Cuboid { size } => {
                let signs = (0..8).map(|corner| [1, 2, 4].map(|bit| if corner & bit == 0 { -0.5 } else { 0.5 }));
                farthest(&mut signs.map(|signs| DVec3::from(signs) * *size))
            }
            Shape::Cylinder { radius, height } => {
                let rim =
                    |level: f64| move |angle: f64| moves(DVec3::new(radius * angle.cos(), level, radius * angle.sin()));
                largest_round_a_turn(rim(-0.5 * height)).max(largest_round_a_turn(rim(0.5 * height)))
            }
            Shape::Cone { radius, height } => {
                let apex = moves(DVec3::Y * (0.75 * height));
                let rim = |angle: f64| moves(DVec3::new(radius * angle.cos(), -0.25 * height, radius * angle.sin()));
                apex.max(largest_round_a_turn(rim))
            }
            Shape::Hull(hull) => farthest(&mut hull.vertices()),
            Shape::Mesh(mesh) => farthest(&mut mesh.vertices()),
            Shape::Compound(compound) => {
                let of_child = |child: &CompoundChild| {
                    let moved = centre + turn.displace(from * child.position);
                    child.collider.largest_displacement(moved, [from, to].map(|rotation| rotation * child.rotation))
                };
                compound.children().iter().map(of_child).fold(0.0, f64::max)
            }
        }
    }
}

/// A rotation as its unit quaternion: n sin φ/2 and cos φ/2.
struct Turn {
    vector: DVec3,
    scalar: f64,
}

impl Turn {
    /// How far the farthest point of a ball moves whose centre moves by `centre`, m.
    fn moves_ball(&self, centre: DVec3, radius: f64) -> f64 {
        let axis = self.vector.normalize_or_zero();
        let along = centre.dot(axis);
        let across = (centre - along * axis).length() + 2.0 * self.vector.length() * radius;
        along.hypot(across)
    }

    fn between(from: DQuat, to: DQuat) -> Self {
        if from == to {
            return Self { vector: DVec3::ZERO, scalar: 1.0 }; // without a rounding
        }
        let turn = to * from.inverse();
        Self { vector: turn.xyz(), scalar: turn.w }
    }

    /// (Q − 1) x, which loses no digits however small the turn is.
    fn displace(&self, x: DVec3) -> DVec3 {
        let across = self.vector.cross(x);
        2.0 * (self.scalar * across + self.vector.cross(across))
    }
}

/// The largest value of a function of an angle that has at most two maxima a turn, as the square root of a quadratic
/// form in sine and cosine has.
fn largest_round_a_turn(value: impl Fn(f64) -> f64) -> f64 {
    let spacing = TAU / RIM as f64;
    let angles = (0..RIM).map(|place| spacing * place as f64);
    let Some(best) = angles.max_by(|a, b| value(*a).total_cmp(&value(*b))) else { return 0.0 };
    let (mut low, mut high) = (best - spacing, best + spacing);
    for _ in 0..CUTS {
        let third = (high - low) / 3.0;
        if value(low + third) < value(high - third) { low += third } else { high -= third }
    }
    value(0.5 * (low + high)).max(value(best))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::ConvexHull;

    /// Points all over the surface, or near it.
    fn surface(collider: &Collider) -> Vec<DVec3> {
        let directions = (0..40_000).map(|i| {
            // Spread evenly: a golden spiral.
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / 40_000.0;
            let angle = i as f64 * 2.399_963_229_728_653;
            let ring = (1.0 - z * z).sqrt();
            DVec3::new(ring * angle.cos(), z, ring * angle.sin())
        });
        let point = |direction: DVec3| match collider.shape() {
            Shape::Sphere { radius } => direction * *radius,
            Shape::Cuboid { size } => direction.signum() * 0.5 * *size,
            Shape::Cylinder { radius, height } => {
                let rim = DVec3::new(direction.x, 0.0, direction.z).normalize() * *radius;
                rim + DVec3::Y * (0.5 * height).copysign(direction.y)
            }
            Shape::Cone { radius, height } if direction.y < 0.9 => {
                let rim = DVec3::new(direction.x, 0.0, direction.z).normalize() * *radius;
                rim - DVec3::Y * (0.25 * height)
            }
            Shape::Cone { height, .. } => DVec3::Y * (0.75 * height),
            shape => panic!("{shape:?}"),
        };
        directions.map(point).collect()
    }

    #[test]
    fn no_point_moves_farther_and_some_point_as_far() {
        let rotation = |x: f64, y: f64, z: f64| DQuat::from_scaled_axis(DVec3::new(x, y, z));
        let moves = [
            (DVec3::new(0.3, -0.2, 0.1), rotation(0.1, 0.2, 0.3), rotation(-0.4, 0.9, 0.3)),
            (DVec3::ZERO, rotation(0.0, 0.0, 0.0), rotation(0.0, 3.0, 0.0)),
            (DVec3::X, rotation(1.0, 0.0, 0.0), rotation(1.0, 0.0, 1e-3)),
        ];
        let colliders = [
            Collider::sphere(0.4),
            Collider::cuboid(1.0, 0.2, 0.5),
            Collider::cone(0.5, 1.2),
            Collider::cylinder(0.5, 1.2),
        ];
        for collider in colliders {
            for (centre, from, to) in moves {
                let told = collider.largest_displacement(centre, [from, to]);
                let moved = |point: DVec3| (centre + to * point - from * point).length();
                let found = surface(&collider).into_iter().map(moved).fold(0.0, f64::max);
                let gap = told - found;
                assert!((-1e-12..1e-4 * told).contains(&gap), "{collider:?}: {told} is told, {found} found");
            }
        }
    }

    #[test]
    fn what_turns_about_its_middle_moves() {
        // Half a turn carries the farthest edge of the box across.
        let half_a_turn = [DQuat::IDENTITY, DQuat::from_rotation_y(std::f64::consts::PI)];
        let told = Collider::cuboid(0.6, 9.0, 0.8).largest_displacement(DVec3::ZERO, half_a_turn);
        assert!((told - 1.0).abs() < 1e-12, "{told}");
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let hull = ConvexHull::new(&corners).unwrap();
        let arm = hull.vertices().map(|corner| corner.x.hypot(corner.z)).fold(0.0, f64::max);
        let told = Collider::hull(hull).largest_displacement(DVec3::ZERO, half_a_turn);
        assert!((told - 2.0 * arm).abs() < 1e-12, "{told} of {arm}");
    }

    #[test]
    fn the_smallest_turn_is_seen_and_none_is_none() {
        let start = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let body = Collider::cuboid(2.0, 2.0, 2.0);
        assert_eq!(body.largest_displacement(DVec3::ZERO, [start; 2]), 0.0);
        let turned = DQuat::from_rotation_z(1e-12) * DQuat::IDENTITY;
        let told = body.largest_displacement(DVec3::ZERO, [DQuat::IDENTITY, turned]);
        assert!((told - 2_f64.sqrt() * 1e-12).abs() < 1e-20, "{told:e}");
    }
}
