//! Which handles there are, where each is, and which of them the pointer is on.

use std::f64::consts::TAU;

use bevy::math::DVec3;

use super::maths::Ray;
use crate::sandbox::Tool;

/// Length of an arrow and radius of a ring, of the distance from the eye.
const SIZE: f64 = 0.14;
/// How near the pointer is to what it is on: the tangent of the angle that it is seen at.
const NEAR: f64 = 0.011;
/// From where to where a square reaches along both its sides, of an arrow.
const SQUARE: [f64; 2] = [0.3, 0.52];
/// Where arrows begin, and the radius of the middle, of an arrow.
pub const MIDDLE: f64 = 0.12;
/// Lines to a ring.
const RING: usize = 64;

/// What can be dragged; axes by their number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Moves along an axis.
    Axis(usize),
    /// Moves across an axis.
    Plane(usize),
    /// Moves in the plane of the picture.
    Free,
    /// Turns about an axis.
    Ring(usize),
    /// Makes larger along an axis.
    Stretch(usize),
    /// Makes larger.
    Grow,
}

/// Where handles are; world, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub centre: DVec3,
    /// Unit, across each other.
    pub axes: [DVec3; 3],
    /// Length of an arrow.
    pub size: f64,
}

impl Frame {
    /// At a place, as large as it is to look from an eye.
    pub fn new(centre: DVec3, axes: [DVec3; 3], eye: DVec3) -> Self {
        Self { centre, axes, size: SIZE * eye.distance(centre).max(1e-3) }
    }

    /// A point of it, in arrows along each axis.
    fn at(&self, place: DVec3) -> DVec3 {
        self.centre + (0..3).map(|axis| self.axes[axis] * place[axis]).sum::<DVec3>() * self.size
    }
}

impl Handle {
    /// Those of a tool; several bodies are only scaled as a whole.
    pub fn of_tool(tool: Tool, is_one: bool) -> Vec<Self> {
        match tool {
            Tool::Move => {
                let axes = (0..3).map(Self::Axis);
                axes.chain((0..3).map(Self::Plane)).chain([Self::Free]).collect()
            }
            Tool::Turn => (0..3).map(Self::Ring).collect(),
            Tool::Scale if is_one => (0..3).map(Self::Stretch).chain([Self::Grow]).collect(),
            Tool::Scale => vec![Self::Grow],
            _ => Vec::new(),
        }
    }

    /// The axis that it is of.
    pub fn axis(self) -> Option<usize> {
        match self {
            Self::Axis(axis) | Self::Plane(axis) | Self::Ring(axis) | Self::Stretch(axis) => Some(axis),
            Self::Free | Self::Grow => None,
        }
    }

    /// The line that it is drawn as.
    pub fn way(self, frame: &Frame) -> Vec<DVec3> {
        match self {
            Self::Axis(axis) | Self::Stretch(axis) => {
                [MIDDLE, 1.0].map(|share| frame.at(DVec3::AXES[axis] * share)).into()
            }
            Self::Plane(axis) => {
                let [one, other] = [1, 2].map(|next| DVec3::AXES[(axis + next) % 3]);
                let [near, far] = SQUARE;
                let corners = [[near, near], [far, near], [far, far], [near, far], [near, near]];
                corners.map(|[along, across]| frame.at(one * along + other * across)).into()
            }
            Self::Ring(axis) => {
                let [one, other] = [1, 2].map(|next| DVec3::AXES[(axis + next) % 3]);
                let angles = (0..=RING).map(|step| TAU * step as f64 / RING as f64);
                angles.map(|angle| frame.at(one * angle.cos() + other * angle.sin())).collect()
            }
            Self::Free | Self::Grow => vec![frame.centre],
        }
    }

    /// The one that the pointer is on: the middle before a square, and that before the nearest line.
    pub fn at(handles: &[Self], frame: &Frame, ray: &Ray) -> Option<Self> {
        let is_in = |handle: &&Self| match handle {
            Self::Free | Self::Grow => {
                let radius = MIDDLE * frame.size / ray.origin.distance(frame.centre).max(f64::MIN_POSITIVE);
                ray.distance_to(&[frame.centre]) < radius.max(NEAR)
            }
            Self::Plane(axis) => ray.on_plane(frame.centre, frame.axes[*axis]).is_some_and(|place| {
                let along = |next| (place - frame.centre).dot(frame.axes[(axis + next) % 3]) / frame.size;
                [1, 2].into_iter().all(|next| (SQUARE[0]..=SQUARE[1]).contains(&along(next)))
            }),
            _ => false,
        };
        let middle = handles.iter().filter(|handle| handle.axis().is_none()).find(is_in);
        let filled = middle.or_else(|| handles.iter().find(is_in)).copied();
        filled.or_else(|| {
            let lines = handles.iter().filter(|handle| handle.axis().is_some());
            let distances = lines.map(|handle| (*handle, ray.distance_to(&handle.way(frame))));
            let nearest = distances.filter(|(_, far)| *far < NEAR).min_by(|(_, a), (_, b)| a.total_cmp(b));
            nearest.map(|(handle, _)| handle)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pointer_is_on_what_it_seems_to_be_on() {
        let eye = DVec3::new(3.0, 4.0, 10.0);
        let frame = Frame::new(DVec3::Y, DVec3::AXES, eye);
        let at = |handles: &[Handle], place: DVec3| {
            Handle::at(handles, &frame, &Ray { origin: eye, direction: (place - eye).normalize() })
        };
        let moving = Handle::of_tool(Tool::Move, true);
        assert_eq!(at(&moving, frame.at(DVec3::X * 0.8)), Some(Handle::Axis(0)));
        assert_eq!(at(&moving, frame.at(DVec3::new(0.0, 0.4, 0.4))), Some(Handle::Plane(0)));
        assert_eq!(at(&moving, frame.centre), Some(Handle::Free));
        assert_eq!(at(&moving, frame.at(DVec3::new(0.7, -0.7, 0.0))), None);
        let turning = Handle::of_tool(Tool::Turn, true);
        assert_eq!(at(&turning, frame.at(DVec3::new(0.6, 0.8, 0.0))), Some(Handle::Ring(2)));
        assert_eq!(at(&Handle::of_tool(Tool::Scale, false), frame.at(DVec3::X)), None);
        assert_eq!(at(&Handle::of_tool(Tool::Scale, true), frame.at(DVec3::X)), Some(Handle::Stretch(0)));
    }
}
