//! A facet of a mesh, a convex polygon cut into triangles, against a convex shape: what its triangles near the shape find,
//! put together.
//!
//! Along the facet's own normal all of them find the same depth, each the contact points over it; together they are those of
//! the polygon. A normal at the border, of an edge or corner that the facet shares with others, takes its place where it is
//! clearly less deep, as between the axes of two solids, or where nothing is over the facet.

use nalgebra::Vector3;

use super::clipping::{MAX_POINTS, keep_touching_spread};
use super::{Cuboid, Frame, Overlap, PairSearch, Scale, cluster, triangle};
use crate::physics::contact::tangents;
use crate::physics::shape::{SAME, Triangle, Triangles};
use crate::physics::{ContactPoint, Geometry};

/// How far a point is beside the line of its neighbors at least to be a corner, as a share of the size.
const OUTLINE_SLACK: f64 = 1e-7;

/// Tests a facet or cluster and a shape of that bounding radius, placed in the mesh's axes, and adds the points where they touch
/// in these axes. The normal points out of the facet.
pub(super) fn touch(
    (mesh, facet): (&Triangles, u32),
    shape: &Geometry,
    radius: f64,
    shape_in_mesh: &Frame,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    if let Some(index) = mesh.only_triangle(facet) {
        return touch_triangle(mesh.get(index), shape, radius, shape_in_mesh, gap, search, points);
    }
    let first = points.len();
    let center = &shape_in_mesh.center;
    let bounds = shape.bounds_at(center, &shape_in_mesh.rotation)?;
    if mesh.is_cluster(facet) {
        let buffers = (&mut search.of_cluster, &mut search.clip);
        let (cluster, placed) = ((mesh, facet), (shape_in_mesh, bounds));
        let found = match shape {
            Geometry::Cuboid { half } => {
                cluster::touch(cluster, (&Cuboid { half: *half }, radius), placed, gap, buffers, points)
            }
            Geometry::Hull(hull) => cluster::touch(cluster, (&**hull, radius), placed, gap, buffers, points),
            _ => unreachable!("others meet facets"),
        };
        return found.map_err(|apart| search.apart = apart).ok();
    }
    let scale = Scale::new(radius, radius, gap);
    let bounds = bounds.grown(scale.gap);
    // What was found along the facet's normal, and along another.
    let (mut flat, mut border): (Option<Overlap>, Option<Overlap>) = (None, None);
    let [mut of_flat, mut of_border, mut outline] = std::mem::take(&mut search.of_facet);
    of_flat.clear();
    let mut apart = f64::INFINITY;
    mesh.in_facet(facet, &bounds, |index| {
        let triangle = mesh.get(index);
        match touch_triangle(triangle, shape, radius, shape_in_mesh, gap, search, points) {
            None => apart = apart.min(search.apart),
            Some(overlap) if overlap.normal.dot(&triangle.normal) >= SAME => {
                of_flat.extend_from_slice(&points[first..]);
                let depth = flat.map_or(overlap.depth, |known| known.depth.max(overlap.depth));
                flat = Some(Overlap { depth, ..overlap });
            }
            Some(overlap) if border.is_none_or(|known| is_before(&overlap, &known)) => {
                of_border.clear();
                of_border.extend_from_slice(&points[first..]);
                border = Some(overlap);
            }
            Some(_) => {}
        }
        points.truncate(first);
    });
    search.apart = if apart.is_finite() { apart } else { gap };
    let takes_border = match (&flat, &border) {
        (flat, None) => flat.is_none(),
        (None, Some(_)) => true,
        (Some(flat), Some(border)) if search.any_normal => border.depth > flat.depth,
        (Some(flat), Some(border)) => border.depth >= 0.0 && border.depth < scale.limit(flat.depth),
    };
    let (overlap, found) = if takes_border { (border, &mut of_border) } else { (flat, &mut of_flat) };
    if let Some(overlap) = overlap {
        keep_outline(found, &overlap.normal, scale.size, &mut outline);
        keep_touching_spread(found, &overlap.normal, scale.size, points);
    }
    search.of_facet = [of_flat, of_border, outline];
    overlap
}

/// Likewise a triangle of the mesh.
fn touch_triangle(
    triangle: Triangle,
    shape: &Geometry,
    radius: f64,
    shape_in_mesh: &Frame,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let first = points.len();
    let placed = Frame { center: shape_in_mesh.center - triangle.middle, ..*shape_in_mesh };
    let overlap = triangle::touch(triangle, shape, radius, &placed, gap, search, points);
    points[first..].iter_mut().for_each(|found| found.point += triangle.middle);
    overlap
}

/// Whether an overlap counts more than another, which is not along the facet's normal either: of what overlaps, the less
/// deep, before what is apart, and of that the nearer.
fn is_before(one: &Overlap, other: &Overlap) -> bool {
    match (one.depth >= 0.0, other.depth >= 0.0) {
        (true, true) => one.depth < other.depth,
        (false, false) => one.depth > other.depth,
        (touches, _) => touches,
    }
}

/// Of more points than a manifold has, keeps those that are corners of their convex hull, seen along the normal: the depth of
/// what is flat is greatest at one of them, and between them lie those where it was cut by sides of triangles (Andrew 1979).
fn keep_outline(found: &mut Vec<ContactPoint>, normal: &Vector3<f64>, size: f64, outline: &mut Vec<ContactPoint>) {
    if found.len() <= MAX_POINTS {
        return;
    }
    let [u, v] = tangents(normal);
    let place = |point: &ContactPoint| [u.dot(&point.point), v.dot(&point.point)];
    found.sort_unstable_by(|one, other| {
        let ([x, y], [other_x, other_y]) = (place(one), place(other));
        x.total_cmp(&other_x).then(y.total_cmp(&other_y))
    });
    let is_left = |from: &ContactPoint, at: &ContactPoint, to: &ContactPoint| {
        let ([fx, fy], [ax, ay], [tx, ty]) = (place(from), place(at), place(to));
        (ax - fx) * (ty - fy) - (ay - fy) * (tx - fx) > OUTLINE_SLACK * size * (tx - fx).hypot(ty - fy)
    };
    outline.clear();
    // One way along the lower side, back along the upper.
    for is_upper in [false, true] {
        let first = outline.len();
        for at in 0..found.len() {
            let next = &found[if is_upper { found.len() - 1 - at } else { at }];
            while outline.len() >= first + 2 && !is_left(&outline[outline.len() - 2], &outline[outline.len() - 1], next)
            {
                outline.pop();
            }
            outline.push(*next);
        }
        outline.pop(); // where the other side begins
    }
    if outline.len() >= 2 {
        std::mem::swap(found, outline);
    }
}
