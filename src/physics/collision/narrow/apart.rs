//! Shapes apart by less than the gap whose nearest features no axis of the separating axis test
//! belongs to: vertices and edges that are beside, not over, the other shape's features.
//!
//! That test finds the greatest separation s along faces' normals and across edges, which is the
//! distance of the shapes only where a face lies over what is nearest, or edges cross. Cubes corner
//! to corner are √3 s apart, and a body that passes beside another's face would be stopped by that
//! face's plane. So where the sides of the reference face cut off all of the incident face, or
//! edges do not cross over each other, the direction between the nearest points of the two outlines
//! is measured as well, by the support functions:
//!
//!   s(n) = n·d − h_A(n) − h_B(−n) ≤ distance, for any unit n,
//!
//! and taken if it separates more. It is the distance itself if these points are the nearest of
//! the shapes. The normal turns continuously: where the incident face leaves the reference face
//! their nearest points still are one over the other.
//!
//! It remains that a plane between two bodies is no more than that: a body about to pass beside
//! a corner may be slowed by up to the speed that would take it beyond the plane within the step.

use nalgebra::Vector3;

use super::clipping::REFERENCE_SIDE;
use super::{
    ClipBuffers, ContactPoint, Convex, FeatureId, Overlap, Polyhedron, Segment, ShapePair, closest, edge_contact,
    middle,
};
use crate::physics::collision::constants::{CROSSING_PENALTY, SAME_DISTANCE, SIDE_MARGIN};

impl<A: Convex, B: Convex> ShapePair<'_, A, B> {
    /// The separation along two near points of the shapes if that is greater than the one found; none
    /// if it is beyond the gap. Overlaps stay as they are.
    fn along(&self, [on_a, on_b]: [Vector3<f64>; 2], overlap: &Overlap) -> Option<Overlap> {
        let between = on_b - on_a;
        let distance = between.norm();
        if overlap.depth >= 0.0 || distance <= -overlap.depth * (1.0 + SAME_DISTANCE) {
            return Some(*overlap);
        }
        let normal = between / distance;
        let depth = self.depth_along(&normal);
        if depth >= overlap.depth {
            return Some(*overlap);
        }
        (!self.scale.separates(depth)).then_some(Overlap { normal, depth })
    }

    /// Shapes apart, of which nothing is over the reference face within the gap. Its outline, in the
    /// axes of its own shape, the incident one's, and the corner that stands for that, in A's axes, come
    /// and what touches beside the faces goes in the buffers; all of it is A's axes then.
    pub fn beside(&self, reference_is_b: bool, overlap: &Overlap, buffers: &mut ClipBuffers) -> Option<Overlap> {
        let ClipBuffers { reference, incident, found, .. } = buffers;
        if reference_is_b {
            for corner in reference.iter_mut().chain(&mut *incident) {
                *corner = self.b_in_a.place(corner);
            }
        }
        let Some(([side, incident_side], [on_reference, on_incident])) = nearest_sides(reference, incident) else {
            return Some(*overlap);
        };
        let (on_a, on_b) = if reference_is_b { (on_incident, on_reference) } else { (on_reference, on_incident) };
        let nearer = self.along(closest(&on_a, &on_b), overlap)?;
        if nearer.depth < overlap.depth {
            let feature = found[0].feature;
            found.clear();
            edge_contact::touch(&on_a, &on_b, &nearer, feature, self.scale, found);
            if let [first, second] = found[..]
                && (first.point - second.point).norm() <= SIDE_MARGIN * self.scale.size
            {
                found.truncate(1); // corner to corner
            }
            let names = [side as u16 | REFERENCE_SIDE, incident_side as u16];
            for (end, found) in found.iter_mut().enumerate() {
                found.feature = feature.with_sides(names[end], names[1 - end]);
            }
        }
        Some(nearer)
    }
}

impl<A: Polyhedron, B: Polyhedron> ShapePair<'_, A, B> {
    /// An edge of A and one of B that cross: leaves the point half-way between their closest points in the buffers.
    pub fn crossing(&self, edges: [usize; 2], overlap: &Overlap, buffers: &mut ClipBuffers) -> Option<Overlap> {
        let (on_a, on_b) = (self.a.edge(edges[0]), self.b.edge(edges[1]).placed(self.b_in_a, false));
        let ends = closest(&on_a.segment(), &on_b.segment());
        let overlap = self.along(ends, overlap)?;
        let feature = FeatureId::of_edges(on_a.index, on_b.index);
        buffers.found.clear();
        buffers.found.push(ContactPoint { point: middle(ends), depth: overlap.depth, feature });
        Some(overlap)
    }
}

/// The sides of two outlines that are nearest to each other, by number and place.
fn nearest_sides(one: &[Vector3<f64>], other: &[Vector3<f64>]) -> Option<([usize; 2], [Segment; 2])> {
    let mut nearest = (f64::INFINITY, None);
    for (index, side) in sides(one) {
        for (other_index, other_side) in sides(other) {
            let [from, to] = closest(&side, &other_side);
            let rank = (to - from).norm_squared() * (1.0 + CROSSING_PENALTY * side.squared_sine(&other_side));
            if rank < nearest.0 {
                nearest = (rank, Some(([index, other_index], [side, other_side])));
            }
        }
    }
    nearest.1
}

/// The sides of a polygon, or of a segment, which is not closed.
fn sides(corners: &[Vector3<f64>]) -> impl Iterator<Item = (usize, Segment)> {
    let count = if corners.len() > 2 { corners.len() } else { corners.len().saturating_sub(1) };
    (0..count).map(|index| (index, Segment([corners[index], corners[(index + 1) % corners.len()]])))
}
