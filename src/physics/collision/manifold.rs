//! What collision detection finds: pairs, how they overlap, manifolds of contact points.

use bevy::prelude::*;
use nalgebra::Vector3;

/// Two bodies that may touch, as indices into [`crate::physics::body::Bodies`]. A is the half-space if one is, or in a
/// slot what does not move if one does not; else the one of lower index. It is the same from step to step, as normals
/// and feature ids are told from A.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
}

/// Which parts of the two shapes of a pair, by number; 0 of a shape that is not made of parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct PartPair {
    pub a: u32,
    pub b: u32,
}

impl PartPair {
    /// Seen from the other body.
    pub fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }
}

/// By which a pair that is looked at is known: its slot, those of the 2009 way have none, its bodies and their parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PairKey {
    pub slot: Option<u32>,
    pub pair: Pair,
    pub parts: PartPair,
}

/// Identifies a contact point of a pair from one step to the next: which features of A and B
/// (faces, edges, vertices) made it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct FeatureId(pub u64);

impl FeatureId {
    /// A vertex of A, or of B.
    pub fn of_vertex(of_b: bool, vertex: u32) -> Self {
        Self(u64::from(of_b) << 32 | u64::from(vertex))
    }

    /// One end, 0 or 1, of a stretch along which two edges touch.
    pub fn end(self, end: u64) -> Self {
        Self(self.0 | end << 33)
    }

    /// Of the faces of a clipped corner, other sides.
    pub fn with_sides(self, before: u16, after: u16) -> Self {
        Self(self.0 & !0xffff_ffff | u64::from(before) << 16 | u64::from(after))
    }

    /// The crossing of two edges.
    pub fn of_edges(edge_a: u32, edge_b: u32) -> Self {
        Self(1 << 62 | u64::from(edge_a & 0x7fff_ffff) << 31 | u64::from(edge_b & 0x7fff_ffff))
    }

    /// A corner of the incident face clipped to the reference face: the faces, 15 bits each, and
    /// the two sides that meet there.
    pub fn of_clipping(reference_is_b: bool, reference: u32, incident: u32, before: u16, after: u16) -> Self {
        let faces = u64::from(reference & 0x7fff) << 15 | u64::from(incident & 0x7fff);
        let sides = u64::from(before) << 16 | u64::from(after);
        Self((2 | u64::from(reference_is_b)) << 62 | faces << 32 | sides)
    }
}

/// How two shapes overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overlap {
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// How far B must move along the normal to be clear of A, m; negative only where they are apart
    /// by less than the gap that was asked for.
    pub depth: f64,
}

/// One point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPoint {
    /// World position. Clipped points lie half-way between the two surfaces.
    pub point: Vector3<f64>,
    /// Overlap along the manifold's normal, m; negative for a speculative point, that only may touch
    /// within the step: down to the gap that was asked for (see [`contact_gap`](super::gap::contact_gap)).
    pub depth: f64,
    pub feature: FeatureId,
}

/// How two bodies touch: a normal and a run of points in [`Contacts::points`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Manifold {
    /// The pair's slot; those of the 2009 way have none.
    pub slot: Option<u32>,
    pub pair: Pair,
    /// Which parts of their shapes.
    pub parts: PartPair,
    /// Unit, from A to B, world axes.
    pub normal: Vector3<f64>,
    /// Range in [`Contacts::points`].
    pub first_point: u32,
    pub point_count: u32,
    /// μ of the pair.
    pub friction: f64,
    /// e of the pair.
    pub restitution: f64,
}

/// The contacts of one step: those of half-spaces first, then along x, as the 2009 sweep finds them; of impulse methods
/// by slot.
#[derive(Resource, Default, Clone)]
pub(crate) struct Contacts {
    pub manifolds: Vec<Manifold>,
    pub points: Vec<ContactPoint>,
    /// Simulation time of the poses they were found at, s.
    pub time: f64,
}

impl Manifold {
    /// By which its pair is known.
    pub fn key(&self) -> PairKey {
        PairKey { slot: self.slot, pair: self.pair, parts: self.parts }
    }
}

impl Contacts {
    pub fn points_of(&self, manifold: &Manifold) -> &[ContactPoint] {
        let first = manifold.first_point as usize;
        &self.points[first..first + manifold.point_count as usize]
    }
}
