//! The bodies as the last step left them, in a tree of boxes, which is made when somebody first asks.

use std::ops::Deref;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

use super::solid::{At, axes_of};
use crate::physics::box_tree::BoxTree;
use crate::physics::{Body, BoundingBox, Geometry};

/// Part of its radius by which a body's box is larger than the body, as rounding might else leave something out.
const SLACK: f64 = 1e-9;

/// When the bodies were last changed, how many steps there were, and how many bodies there are.
type Version = (Tick, u64, usize);

/// The index of the bodies as they were at some version.
#[derive(Resource, Default)]
pub(crate) struct QueryIndex(RwLock<Option<(Version, Index)>>);

impl QueryIndex {
    /// The index of these bodies, which have that version, for reading. While somebody reads it none else has another version:
    /// the bodies are lent to all who ask. So no closure of a filter that asks on waits for itself.
    #[inline]
    pub(super) fn of(&self, bodies: &[Body], version: Version) -> IndexGuard<'_> {
        // Nothing is left half done where making one panics.
        let known = self.0.read().unwrap_or_else(PoisonError::into_inner);
        if known.as_ref().is_some_and(|(then, _)| *then == version) {
            return IndexGuard(known);
        }
        drop(known);
        self.made(bodies, version)
    }

    /// The same, made anew unless another thread did.
    #[cold]
    fn made(&self, bodies: &[Body], version: Version) -> IndexGuard<'_> {
        let mut known = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if known.as_ref().is_none_or(|(then, _)| *then != version) {
            *known = Some((version, Index::new(bodies)));
        }
        IndexGuard(RwLockWriteGuard::downgrade(known))
    }
}

/// An index that is lent for reading.
pub(super) struct IndexGuard<'i>(RwLockReadGuard<'i, Option<(Version, Index)>>);

impl Deref for IndexGuard<'_> {
    type Target = Index;

    fn deref(&self) -> &Index {
        &self.0.as_ref().expect("it was made before it was lent").1
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
fn box_of(body: &Body) -> Option<BoundingBox> {
    let geometry = body.geometry.as_ref()?;
    box_at(geometry, (body.position, axes_of(geometry, &body.rotation)), body.radius)
}

/// The same of a shape where it is, its axes as columns, of that bounding radius.
pub(super) fn box_at(geometry: &Geometry, (position, axes): At, radius: f64) -> Option<BoundingBox> {
    geometry.bounds_at(&position, &axes).map(|bounds| bounds.grown(SLACK * radius))
}
