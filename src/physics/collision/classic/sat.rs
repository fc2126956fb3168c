//! The separating axis test (Gottschalk 1996; Ericson 2005, 5.2.1) as the 2009 engine made it, over
//! a reduced set of axes.
//!
//! Two convex shapes are apart exactly if they are apart along one of the candidate axes: the
//! face normals of A, those of B, and the cross products of their edges. A ball has no faces; it
//! adds the axis to the nearest point of the other shape, which makes its test exact. A
//! half-space has one axis, its normal.
//!
//! Axes are made one at a time, go through the [`VectorSet`], and are tested only if they are
//! new to it; the first along which the shapes are apart ends the test. Leaving out axes never
//! loses a contact, but may report one where the axis left out would have separated, or a depth
//! that is not the least.
//!
//! Depth here is how far B must move along the normal to be clear of A. Depth 0, touching, is a
//! contact, and so is a gap that rounding could have made of it.

use nalgebra::Vector3;

use super::placed::Placed;
use crate::physics::collision::constants::{CONTACT_TOLERANCE, ON_SURFACE};
use crate::physics::collision::manifold::Overlap;
use crate::physics::{Geometry, SweepSettings, VectorSet};

/// Buffers of the test, kept from pair to pair.
#[derive(Default)]
pub(crate) struct AxisBuffers {
    set: VectorSet,
    a: Vec<Vector3<f64>>,
    b: Vec<Vector3<f64>>,
    /// Axes measured so far.
    pub axes: u32,
}

/// Tests two shapes; none if they are apart. Not for two half-spaces.
pub(crate) fn overlap(a: &Placed, b: &Placed, settings: &SweepSettings, buffers: &mut AxisBuffers) -> Option<Overlap> {
    match (a.geometry, b.geometry) {
        (Geometry::HalfSpace, _) => plane_overlap(a, b),
        (_, Geometry::HalfSpace) => plane_overlap(b, a).map(|overlap| Overlap { normal: -overlap.normal, ..overlap }),
        _ => convex_overlap(a, b, settings, buffers),
    }
}

fn plane_overlap(plane: &Placed, body: &Placed) -> Option<Overlap> {
    let normal = plane.plane_normal();
    let depth = plane.center.dot(&normal) - body.project(&normal)[0];
    (depth >= -CONTACT_TOLERANCE * body.radius).then(|| Overlap { normal, depth: depth.max(0.0) })
}

fn convex_overlap(a: &Placed, b: &Placed, settings: &SweepSettings, buffers: &mut AxisBuffers) -> Option<Overlap> {
    buffers.set.reset(settings.axis_epsilon, settings.merge_opposite_axes, 1.0);
    let mut test = AxisTest { a, b, tolerance: CONTACT_TOLERANCE * (a.radius + b.radius), least: None, axes: 0 };
    let touch = test.run(buffers);
    buffers.axes += test.axes;
    touch?;
    // Only two balls with one centre are left without an axis.
    Some(test.least.unwrap_or(Overlap { normal: Vector3::y(), depth: a.radius + b.radius }))
}

/// A test in progress: the least overlap so far.
struct AxisTest<'t> {
    a: &'t Placed<'t>,
    b: &'t Placed<'t>,
    tolerance: f64,
    least: Option<Overlap>,
    axes: u32,
}

impl AxisTest<'_> {
    /// Goes through all candidate axes; none as soon as one separates.
    fn run(&mut self, buffers: &mut AxisBuffers) -> Option<()> {
        let AxisBuffers { set, a, b, .. } = buffers;
        let (one, other) = (self.a, self.b);
        if matches!(other.geometry, Geometry::Sphere { .. }) {
            self.test_nearest(set, other, one)?;
        } else if matches!(one.geometry, Geometry::Sphere { .. }) {
            self.test_nearest(set, one, other)?;
        }
        self.test_faces(set, one, a)?;
        self.test_faces(set, other, b)?;
        one.axes(true, a);
        other.axes(true, b);
        for along_a in &*a {
            for along_b in &*b {
                if let Some(axis) = set.insert_direction(along_a.cross(along_b)) {
                    self.test(axis)?;
                }
            }
        }
        Some(())
    }

    /// The axis from a ball to the nearest point of the other shape, unless its centre is inside.
    fn test_nearest(&mut self, set: &mut VectorSet, ball: &Placed, other: &Placed) -> Option<()> {
        let away = ball.center - other.nearest(&ball.center);
        let distance = away.norm();
        if distance <= ON_SURFACE * ball.radius {
            return Some(());
        }
        let axis = away / distance;
        set.insert(axis);
        self.test(axis)
    }

    fn test_faces(&mut self, set: &mut VectorSet, shape: &Placed, normals: &mut Vec<Vector3<f64>>) -> Option<()> {
        shape.axes(false, normals);
        for &normal in &*normals {
            if set.insert(normal) {
                self.test(normal)?;
            }
            if shape.is_symmetric() {
                // The opposite face: an axis of its own for the set, but the same test.
                set.insert(-normal);
            }
        }
        Some(())
    }

    /// Measures the overlap along an axis both ways; none if it separates.
    #[inline]
    fn test(&mut self, axis: Vector3<f64>) -> Option<()> {
        self.axes += 1;
        let [low_a, high_a] = self.a.project(&axis);
        let [low_b, high_b] = self.b.project(&axis);
        let (forward, backward) = (high_a - low_b, high_b - low_a);
        let (depth, sign) = if forward <= backward { (forward, 1.0) } else { (backward, -1.0) };
        if depth < -self.tolerance {
            return None;
        }
        if self.least.is_none_or(|least| depth.max(0.0) < least.depth) {
            self.least = Some(Overlap { normal: axis * sign, depth: depth.max(0.0) });
        }
        Some(())
    }
}
