//! The bodies as the last step left them, in a tree of boxes, which is made when somebody first asks.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

use crate::physics::box_tree::BoxTree;
use crate::physics::collision;
use crate::physics::{Body, BoundingBox};

/// Part of its radius by which a body's box is larger than the body, as rounding might else leave something out.
const SLACK: f64 = 1e-9;

/// When the bodies were last changed, how many steps there were, and how many bodies there are.
type Version = (Tick, u64, usize);

/// The index of the bodies as they were at some version.
#[derive(Resource, Default)]
pub(crate) struct QueryIndex(Mutex<Option<(Version, Arc<Index>)>>);

impl QueryIndex {
    /// The index of these bodies, which have that version.
    pub(super) fn of(&self, bodies: &[Body], version: Version) -> Arc<Index> {
        // Nothing is left half done where making one panics.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*known {
            Some((then, index)) if *then == version => index.clone(),
            _ => {
                let index = Arc::new(Index::new(bodies));
                *known = Some((version, index.clone()));
                index
            }
        }
    }
}

/// Bodies with a shape, by their indices.
#[derive(Debug)]
pub(super) struct Index {
    pub tree: BoxTree,
    /// Half-spaces, which no box holds.
    pub unbounded: Vec<u32>,
}

impl Index {
    fn new(bodies: &[Body]) -> Self {
        let mut unbounded = Vec::new();
        let mut boxes = Vec::with_capacity(bodies.len());
        for (index, body) in (0..).zip(bodies) {
            if body.geometry.is_none() || body.is_sensor {
                continue;
            }
            match box_of(body) {
                Some(bounds) => boxes.push((index, bounds)),
                None => unbounded.push(index),
            }
        }
        Self { tree: BoxTree::new(boxes), unbounded }
    }
}

/// A box that holds a body's shape for certain; none of a half-space, and of what has no shape.
pub(super) fn box_of(body: &Body) -> Option<BoundingBox> {
    collision::box_of(body).map(|bounds| bounds.grown(SLACK * body.radius))
}
