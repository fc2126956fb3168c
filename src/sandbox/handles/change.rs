//! What a handle that is dragged makes of what is picked.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::handle::{Frame, Handle};
use super::maths::{Ray, angle_about};
use crate::sandbox::{Placement, Snap};
use crate::scene::ShapeSpec;

/// Factors that one drag can scale by, and sizes that it can make, m.
const FACTORS: [f64; 2] = [0.01, 100.0];
const SIZES: [f64; 2] = [0.01, 100.0];
/// Cosine between the eye's direction and a ring's axis under which its plane is seen too much from the side to be met: then
/// the pointer goes along the ring's tangent.
const FROM_THE_SIDE: f64 = 0.2;

/// A change of all that is picked, about one centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Everything goes that way, m.
    Move(DVec3),
    /// Everything turns about the centre: a unit axis, and an angle, rad.
    Turn(DVec3, f64),
    /// Factors along the axes of one body, or the same thrice.
    Scale(DVec3),
}

/// A handle in hand: where it was grabbed.
#[derive(Clone, Copy, Debug)]
pub struct Grip {
    pub handle: Handle,
    pub frame: Frame,
    /// Towards what one looks, and to the right and up in the picture; unit.
    view: [DVec3; 3],
    /// Along its axis, m, where it has one that is gone along.
    along: f64,
    /// The place of its plane that was grabbed.
    place: DVec3,
    /// How far it has been turned, rad.
    turned: f64,
    /// From the centre to where the pointer was last on its plane.
    last: DVec3,
}

impl Grip {
    /// Grabs a handle. None: it is seen from where it cannot be dragged.
    pub fn new(handle: Handle, frame: Frame, ray: &Ray, view: [DVec3; 3]) -> Option<Self> {
        let mut grip = Self { handle, frame, view, along: 0.0, place: frame.centre, turned: 0.0, last: DVec3::ZERO };
        match handle {
            Handle::Axis(axis) | Handle::Stretch(axis) => {
                grip.along = ray.along_axis(frame.centre, frame.axes[axis])?;
            }
            Handle::Ring(axis) if grip.is_from_the_side(axis) => {
                // On this side of the ring.
                let points = handle.way(&frame).into_iter();
                let near = points.filter(|point| (*point - frame.centre).dot(view[0]) <= 0.0);
                let distances = near.map(|point| (ray.distance_to(&[point]), point));
                let (_, nearest) = distances.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
                grip.place = nearest;
                let tangent = frame.axes[axis].cross(nearest - frame.centre).normalize_or(view[1]);
                grip.along = ray.along_axis(nearest, tangent)?;
            }
            _ => grip.place = ray.on_plane(frame.centre, grip.normal())?,
        }
        grip.last = grip.place - frame.centre;
        Some(grip)
    }

    fn is_from_the_side(&self, axis: usize) -> bool {
        self.frame.axes[axis].dot(self.view[0]).abs() < FROM_THE_SIDE
    }

    /// Of the plane in which the pointer goes.
    fn normal(&self) -> DVec3 {
        match self.handle {
            Handle::Plane(axis) | Handle::Ring(axis) => self.frame.axes[axis],
            _ => -self.view[0],
        }
    }

    /// What the pointer makes of it where it is now; none where that cannot be told.
    pub fn change(&mut self, ray: &Ray, snap: Option<Snap>) -> Option<Change> {
        let Frame { centre, axes, size } = self.frame;
        Some(match self.handle {
            Handle::Axis(axis) => {
                let way = axes[axis] * (ray.along_axis(centre, axes[axis])? - self.along);
                Change::Move(snapped(centre, way, |own| own == axis, snap))
            }
            Handle::Plane(across) => {
                let way = ray.on_plane(self.place, self.normal())? - self.place;
                Change::Move(snapped(centre, way, |own| own != across, snap))
            }
            Handle::Free => {
                let way = ray.on_plane(self.place, self.normal())? - self.place;
                Change::Move(snapped(centre, way, |_| true, snap))
            }
            Handle::Ring(axis) => {
                self.turn(axis, ray)?;
                let angle = snap.map_or(self.turned, |snap| snap.angle(self.turned));
                Change::Turn(axes[axis], angle)
            }
            Handle::Stretch(axis) => {
                let now = ray.along_axis(centre, axes[axis])?;
                let factor = (now / self.along).clamp(FACTORS[0], FACTORS[1]);
                Change::Scale(DVec3::ONE + DVec3::AXES[axis] * (factor - 1.0))
            }
            Handle::Grow => {
                let way = ray.on_plane(self.place, self.normal())? - self.place;
                let way = way.dot(self.view[1] + self.view[2]) / size;
                Change::Scale(DVec3::splat(way.exp().clamp(FACTORS[0], FACTORS[1])))
            }
        })
    }

    /// Takes in where the pointer is: a ring can be turned more than once.
    fn turn(&mut self, axis: usize, ray: &Ray) -> Option<()> {
        let Frame { centre, axes, size } = self.frame;
        if self.is_from_the_side(axis) {
            let tangent = axes[axis].cross(self.place - centre).normalize_or(self.view[1]);
            self.turned = (ray.along_axis(self.place, tangent)? - self.along) / size;
            return Some(());
        }
        let now = ray.on_plane(centre, axes[axis])? - centre;
        self.turned += angle_about(axes[axis], self.last, now);
        self.last = now;
        Some(())
    }
}

/// A way that takes the centre to the grid along those axes of the world.
fn snapped(centre: DVec3, way: DVec3, goes: impl Fn(usize) -> bool, snap: Option<Snap>) -> DVec3 {
    let Some(snap) = snap else { return way };
    let to = snap.place(centre + way);
    DVec3::from_array([0, 1, 2].map(|axis| if goes(axis) { to[axis] - centre[axis] } else { way[axis] }))
}

/// A body as it was when the handle was grabbed.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    pub body: Entity,
    pub position: DVec3,
    pub rotation: DQuat,
    /// Its shape, where that can be scaled.
    pub shape: Option<ShapeSpec>,
}

impl Start {
    /// Where a change about a centre puts it.
    pub fn changed(&self, change: Change, centre: DVec3, snap: Option<Snap>) -> Placement {
        let arm = self.position - centre;
        let (position, rotation, shape) = match change {
            Change::Move(way) => (self.position + way, self.rotation, None),
            Change::Turn(axis, angle) => {
                let turn = DQuat::from_axis_angle(axis, angle);
                (centre + turn * arm, (turn * self.rotation).normalize(), None)
            }
            Change::Scale(factors) => {
                let shape = self.shape.as_ref().and_then(|shape| scaled(shape, factors, snap));
                (centre + arm * uniform(factors), self.rotation, shape)
            }
        };
        Placement { body: self.body, position, rotation, shape }
    }
}

/// What is round about y grows across it by either of two handles.
fn across(factors: DVec3) -> f64 {
    if factors == DVec3::splat(factors.x) { factors.x } else { factors.x * factors.z }
}

/// One factor for what cannot be stretched.
fn uniform(factors: DVec3) -> f64 {
    if factors == DVec3::splat(factors.x) { factors.x } else { factors.element_product() }
}

/// Whether a shape can be made larger.
pub fn is_scalable(shape: &ShapeSpec) -> bool {
    scaled(shape, DVec3::ONE, None).is_some()
}

/// The shape, that much larger along its axes, what is round or a hull along all; on the grid, its sizes are multiples of it.
fn scaled(shape: &ShapeSpec, factors: DVec3, snap: Option<Snap>) -> Option<ShapeSpec> {
    let length = |length: f64, factor: f64| {
        let scaled = length * factor;
        match snap.filter(|_| factor != 1.0) {
            Some(snap) => snap.length(scaled).max(snap.grid),
            None => scaled,
        }
        .clamp(SIZES[0].min(length), SIZES[1].max(length))
    };
    Some(match shape {
        ShapeSpec::Sphere { radius } => ShapeSpec::Sphere { radius: length(*radius, uniform(factors)) },
        ShapeSpec::Cuboid { size } => {
            let size = [0, 1, 2].map(|axis| length(size[axis], factors[axis]));
            ShapeSpec::Cuboid { size: size.into() }
        }
        ShapeSpec::Capsule { radius, length: cylinder } => {
            ShapeSpec::Capsule { radius: length(*radius, across(factors)), length: length(*cylinder, factors.y) }
        }
        ShapeSpec::Cylinder { radius, height } => {
            ShapeSpec::Cylinder { radius: length(*radius, across(factors)), height: length(*height, factors.y) }
        }
        ShapeSpec::Cone { radius, height } => {
            ShapeSpec::Cone { radius: length(*radius, across(factors)), height: length(*height, factors.y) }
        }
        ShapeSpec::Hull(hull) => {
            let factor = uniform(factors);
            ShapeSpec::hull(hull.points().iter().map(|point| *point * factor).collect::<Vec<_>>())
        }
        // Its picture is the file's, or its parts would have to grow with their places.
        ShapeSpec::Mesh(_) | ShapeSpec::HalfSpace | ShapeSpec::Compound(_) | ShapeSpec::Surface(_) => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    const EYE: DVec3 = DVec3::new(0.0, 0.0, 10.0);
    const VIEW: [DVec3; 3] = [DVec3::NEG_Z, DVec3::X, DVec3::Y];

    fn ray(to: DVec3) -> Ray {
        Ray { origin: EYE, direction: (to - EYE).normalize() }
    }

    fn pulled(handle: Handle, from: DVec3, ways: &[DVec3], snap: Option<Snap>) -> Change {
        let frame = Frame::new(DVec3::new(0.03, 0.0, 0.0), DVec3::AXES, EYE);
        let mut grip = Grip::new(handle, frame, &ray(from), VIEW).expect("a handle that can be dragged");
        ways.iter().map(|to| grip.change(&ray(*to), snap).expect("a change")).last().expect("a way")
    }

    #[test]
    fn an_arrow_goes_along_its_axis_alone_and_to_the_grid() {
        let to = [DVec3::new(1.5, 0.7, 0.0)];
        let Change::Move(way) = pulled(Handle::Axis(0), DVec3::X, &to, None) else { panic!("a move") };
        // One points above the axis: to its nearest point.
        assert!(way.abs_diff_eq(DVec3::X * 0.5, 0.01) && way.y == 0.0 && way.z == 0.0, "{way}");
        let snap = Some(Snap { grid: 0.2, ..default() });
        let Change::Move(way) = pulled(Handle::Axis(0), DVec3::X, &to, snap) else { panic!("a move") };
        // The centre is at 0.03: it comes to 0.6, not half a metre on.
        assert!(way.abs_diff_eq(DVec3::X * 0.57, 1e-9), "{way}");
        let Change::Move(way) = pulled(Handle::Free, DVec3::ZERO, &to, None) else { panic!("a move") };
        assert!(way.abs_diff_eq(to[0], 1e-9), "{way}");
    }

    #[test]
    fn a_ring_turns_more_than_once_and_from_the_side_too() {
        let round: Vec<DVec3> =
            (1..=12).map(|step| DQuat::from_rotation_z(step as f64 * FRAC_PI_2) * DVec3::X).collect();
        let frame = Frame::new(DVec3::ZERO, DVec3::AXES, EYE);
        let mut grip = Grip::new(Handle::Ring(2), frame, &ray(DVec3::X), VIEW).expect("a ring");
        let mut angle = 0.0;
        for to in &round {
            let Some(Change::Turn(axis, now)) = grip.change(&ray(*to), None) else { panic!("a turn") };
            assert_eq!(axis, DVec3::Z);
            angle = now;
        }
        assert!((angle - 6.0 * PI).abs() < 1e-9, "three turns: {angle}");
        // About y, seen from its side: its near point is before the centre, and goes to the right.
        let size = frame.size;
        let mut grip = Grip::new(Handle::Ring(1), frame, &ray(DVec3::Z * size), VIEW).expect("a ring");
        let to = ray(DVec3::new(0.3 * size, 0.0, size));
        let Some(Change::Turn(_, angle)) = grip.change(&to, None) else { panic!("a turn") };
        assert!((angle - 0.3).abs() < 0.02, "{angle}");
        let snap = Some(Snap { degrees: 15.0, ..default() });
        let Some(Change::Turn(_, angle)) = grip.change(&to, snap) else { panic!("a turn") };
        assert!((angle - PI / 12.0).abs() < 1e-12, "{angle}");
    }

    #[test]
    fn what_is_turned_or_scaled_keeps_the_centre_of_all() {
        let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, 2.0, 3.0) };
        let start = Start {
            body: Entity::PLACEHOLDER,
            position: DVec3::X * 2.0,
            rotation: DQuat::IDENTITY,
            shape: Some(shape),
        };
        let placed = start.changed(Change::Turn(DVec3::Z, FRAC_PI_2), DVec3::X, None);
        assert!(placed.position.abs_diff_eq(DVec3::new(1.0, 1.0, 0.0), 1e-12), "{}", placed.position);
        assert!((placed.rotation * DVec3::X).abs_diff_eq(DVec3::Y, 1e-12));
        let placed = start.changed(Change::Scale(DVec3::splat(2.0)), DVec3::X, None);
        assert_eq!(placed.position, DVec3::X * 3.0);
        assert_eq!(placed.shape, Some(ShapeSpec::Cuboid { size: DVec3::new(2.0, 4.0, 6.0) }));
        let snap = Some(Snap { grid: 0.5, ..default() });
        let placed = start.changed(Change::Scale(DVec3::new(1.0, 1.1, 1.0)), DVec3::X * 2.0, snap);
        assert_eq!(placed.position, DVec3::X * 2.0);
        assert_eq!(placed.shape, Some(ShapeSpec::Cuboid { size: DVec3::new(1.0, 2.0, 3.0) }), "2.2 is nearest to 2");
    }

    #[test]
    fn a_box_that_is_pulled_out_stretches() {
        let to = [DVec3::new(2.03, 0.0, 0.0)];
        let Change::Scale(factors) = pulled(Handle::Stretch(0), DVec3::new(1.03, 0.0, 0.0), &to, None) else {
            panic!("a scale")
        };
        assert!(factors.abs_diff_eq(DVec3::new(2.0, 1.0, 1.0), 1e-9), "{factors}");
    }
}
