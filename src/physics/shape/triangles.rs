//! The triangles of a mesh as collision looks at them.
//!
//! The front of a triangle is where its corners go round counter-clockwise. A mesh is the boundary of a solid behind it,
//! as far as can be told from here; what is behind a triangle with its middle does not touch it.
//!
//! **Inner edges.** At a point of the surface, the normals that a contact may have are those along which the surface is
//! foremost there: above a triangle its own, at an edge those between the normals of its two triangles where it is convex
//! and none where it is not, at a vertex v the directions m with m·(w − v) ≤ 0 for all edges from v to w. An edge's normals
//! obey that of both its ends with m·(w − v) = 0 along it. At the border of an open mesh, normals are at most level with the
//! triangle.
//!
//! **Facets.** Triangles in one plane that are neighbors and together a convex polygon are one part: what lies on them has
//! one normal and the contact points of one polygon, however fine it is cut. Such a region is convex where the corners of
//! its triangles at no vertex of its border add up to more than π; at a hole they do.
//!
//! **Clusters.** Where the triangles about all three corners of one look nearly the same way, the surface is smooth there, and no
//! normal of a contact at its sides and corners is far from its own. Smooth triangles that hang together and look nearly the same
//! way are a cluster, at most [`CLUSTER`] of them, grown from the first in breadth: for what meets clusters one part instead of
//! as many as there are triangles.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use nalgebra::Vector3;

use crate::physics::BoundingBox;
use crate::physics::box_tree::BoxTree;

/// Sine of the angle by which a normal may be beyond those of the surface and count as one of them.
const NORMAL_SLACK: f64 = 1e-6;

/// Cosine from which on two directions are one, to 1e-6.
pub(crate) const SAME: f64 = 1.0 - 5e-13;

/// By how much normals, and places as a share of a triangle's radius, may differ in one plane; and angles in a convex
/// polygon be more than they may.
const FLATNESS: f64 = 1e-9;
const ANGLE_SLACK: f64 = 1e-6;

/// Cosine of the angle between the normal of a triangle and the mean of those about a vertex, up to which the surface counts as
/// smooth there: two of them differ by at most 0.4 rad.
const SMOOTH: f64 = 0.98;

/// Cosine of the angle between the normals of the triangles of a cluster and of its first at least: two of them differ by at most
/// 0.6 rad. *speed*, `trees`.
const LEVEL: f64 = 0.955;

/// Most triangles of a cluster. *speed*, `trees`.
const CLUSTER: usize = 1024;

/// Most triangles of a facet that are looked at one by one.
const LIST: usize = 16;

/// Vertices and triangles in body axes, and which vertices are neighbors.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    pub vertices: Vec<Vector3<f64>>,
    pub corners: Vec<[u32; 3]>,
    /// Unit, to the front of each triangle.
    normals: Vec<Vector3<f64>>,
    /// The farthest vertex from the origin, m.
    pub radius: f64,
    /// Where the neighbors of each vertex begin; then the number of all.
    first_neighbor: Vec<u32>,
    neighbors: Vec<u32>,
    /// The lowest triangle at each vertex.
    owners: Vec<u32>,
    /// Of each side, from corner k to the next, the triangle beyond it; u32::MAX at a border.
    beyond: Vec<[u32; 3]>,
    /// Facets, then clusters.
    facets: Facets,
    facet_count: u32,
    /// Those that are in no cluster, and the clusters.
    clustered: Vec<u32>,
}

/// The triangles of each facet, and of each cluster: of most facets but one, so that all are in one list.
#[derive(Clone, Debug, Default)]
struct Facets {
    /// Where the triangles of each begin; then the number of all.
    first: Vec<u32>,
    triangles: Vec<u32>,
    /// Of those of many triangles, ascending, a tree of their boxes.
    trees: Vec<(u32, BoxTree)>,
}

/// A triangle placed in the body's axes, with a pyramid behind it that stands for the inside of the mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle<'t> {
    pub mesh: &'t Triangles,
    pub index: u32,
    /// The middle of the corners, in the body's axes.
    pub middle: Vector3<f64>,
    /// From the middle.
    pub corners: [Vector3<f64>; 3],
    /// Unit, to the front.
    pub normal: Vector3<f64>,
    /// The farthest corner from the middle.
    pub radius: f64,
}

impl Triangles {
    /// Of triangles with an area, given by indices of vertices.
    pub fn new(vertices: Vec<Vector3<f64>>, corners: Vec<[u32; 3]>) -> Self {
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * corners.len());
        let mut owners = vec![u32::MAX; vertices.len()];
        for (index, triangle) in (0..).zip(&corners) {
            for side in 0..3 {
                sides.push(([triangle[side], triangle[(side + 1) % 3]], index));
                owners[triangle[side] as usize] = owners[triangle[side] as usize].min(index);
            }
        }
        sides.sort_unstable();
        let other_side = |[from, to]: [u32; 2]| {
            let place = sides.partition_point(|(known, _)| *known < [to, from]);
            sides.get(place).filter(|(known, _)| *known == [to, from]).map_or(u32::MAX, |&(_, triangle)| triangle)
        };
        let beyond = corners.iter().map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(other_side)).collect();
        let mut ends: Vec<[u32; 2]> = sides.iter().flat_map(|&([from, to], _)| [[from, to], [to, from]]).collect();
        ends.sort_unstable();
        ends.dedup();
        let first = |vertex: u32| ends.partition_point(|[from, _]| *from < vertex) as u32;
        let first_neighbor = (0..=vertices.len() as u32).map(first).collect();
        let neighbors = ends.iter().map(|[_, to]| *to).collect();
        let radius = vertices.iter().map(Vector3::norm).fold(0.0, f64::max);
        let normals = corners.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            (b - a).cross(&(c - a)).normalize()
        });
        let normals = normals.collect();
        let (facets, facet_count, clustered) = (Facets::default(), 0, Vec::new());
        let mut own = Self {
            vertices,
            corners,
            normals,
            radius,
            first_neighbor,
            neighbors,
            owners,
            beyond,
            facets,
            facet_count,
            clustered,
        };
        own.facets = own.find_facets();
        own.facet_count = own.facets.count();
        own.find_clusters();
        own
    }

    /// Of each triangle, whether all about its corners look nearly the same way and none has a border there.
    fn find_smooth(&self) -> Vec<bool> {
        let triangles = || self.corners.iter().zip(&self.normals);
        let mut means = vec![Vector3::zeros(); self.vertices.len()];
        for (corners, normal) in triangles() {
            corners.iter().for_each(|&vertex| means[vertex as usize] += normal);
        }
        means.iter_mut().for_each(|mean| *mean = mean.normalize());
        let mut is_smooth = vec![true; self.vertices.len()];
        for ((corners, normal), beyond) in triangles().zip(&self.beyond) {
            for (at, &vertex) in corners.iter().enumerate() {
                is_smooth[vertex as usize] &= means[vertex as usize].dot(normal) >= SMOOTH;
                if beyond[at] == u32::MAX {
                    is_smooth[vertex as usize] = false;
                    is_smooth[corners[(at + 1) % 3] as usize] = false;
                }
            }
        }
        self.corners.iter().map(|corners| corners.iter().all(|&vertex| is_smooth[vertex as usize])).collect()
    }

    /// Neighbors in one plane where they make a convex polygon, else each triangle alone.
    fn find_facets(&self) -> Facets {
        let normals = &self.normals;
        let mut is_taken = vec![false; self.corners.len()];
        let (mut facets, mut stack) = (Facets::default(), Vec::new());
        facets.first.push(0);
        for first in 0..self.count() {
            if std::mem::replace(&mut is_taken[first as usize], true) {
                continue;
            }
            let normal = normals[first as usize];
            let level = normal.dot(&self.corners_of(first)[0]);
            let slack = FLATNESS * self.get(first).radius;
            let in_plane = |triangle: u32| {
                (normals[triangle as usize] - normal).norm() <= FLATNESS
                    && self.corners_of(triangle).iter().all(|corner| (normal.dot(corner) - level).abs() <= slack)
            };
            let mut triangles = vec![first];
            stack.push(first);
            while let Some(triangle) = stack.pop() {
                for next in self.beyond[triangle as usize].into_iter().filter(|&next| next != u32::MAX) {
                    if !is_taken[next as usize] && in_plane(next) {
                        is_taken[next as usize] = true;
                        triangles.push(next);
                        stack.push(next);
                    }
                }
            }
            if self.is_convex(&triangles) {
                triangles.sort_unstable();
                facets.push(&triangles, self);
            } else {
                triangles.iter().for_each(|&triangle| facets.push(&[triangle], self));
            }
        }
        facets
    }

    /// Whether triangles of one plane that hang together are a convex polygon.
    fn is_convex(&self, triangles: &[u32]) -> bool {
        let mut corners: Vec<(u32, f64)> = Vec::with_capacity(3 * triangles.len());
        for &triangle in triangles {
            let at = self.corners_of(triangle);
            for corner in 0..3 {
                let [u, v] = [1, 2].map(|next| at[(corner + next) % 3] - at[corner]);
                corners.push((self.corners[triangle as usize][corner], u.cross(&v).norm().atan2(u.dot(&v))));
            }
        }
        corners.sort_unstable_by_key(|(vertex, _)| *vertex);
        corners.chunk_by(|one, other| one.0 == other.0).all(|about| {
            let angle: f64 = about.iter().map(|(_, angle)| angle).sum();
            angle <= PI + ANGLE_SLACK || angle >= TAU - ANGLE_SLACK
        })
    }

    /// Puts together what is smooth and level. Triangles that are in a facet with others stay there.
    fn find_clusters(&mut self) {
        let is_smooth = self.find_smooth();
        let alone: Vec<u32> = (0..self.facet_count).filter_map(|facet| self.only_triangle(facet)).collect();
        let mut is_left = vec![false; self.corners.len()];
        alone.iter().for_each(|&triangle| is_left[triangle as usize] = is_smooth[triangle as usize]);
        self.clustered =
            (0..self.facet_count).filter(|&facet| !is_left[self.triangles_of(facet)[0] as usize]).collect();
        let mut cluster: Vec<u32> = Vec::with_capacity(CLUSTER);
        for first in alone {
            if !std::mem::take(&mut is_left[first as usize]) {
                continue;
            }
            cluster.clear();
            cluster.push(first);
            let mut next = 0;
            while let Some(&triangle) = cluster.get(next) {
                next += 1;
                for beyond in self.beyond[triangle as usize] {
                    if cluster.len() < CLUSTER
                        && is_left.get(beyond as usize).is_some_and(|is_left| *is_left)
                        && self.normal(beyond).dot(&self.normal(first)) >= LEVEL
                    {
                        is_left[beyond as usize] = false;
                        cluster.push(beyond);
                    }
                }
            }
            cluster.sort_unstable();
            self.clustered.push(self.facets.count());
            let mut facets = std::mem::take(&mut self.facets);
            facets.push(&cluster, self);
            self.facets = facets;
        }
    }

    /// How many facets there are.
    pub fn facet_count(&self) -> u32 {
        self.facet_count
    }

    /// The clusters, and the facets that are in none: by numbers, of clusters those beyond the facets'.
    pub fn clustered(&self) -> &[u32] {
        &self.clustered
    }

    /// Whether a number is that of a cluster.
    pub fn is_cluster(&self, part: u32) -> bool {
        part >= self.facet_count
    }

    /// The triangles of a facet or cluster.
    pub fn triangles_of(&self, facet: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|next| self.facets.first[facet as usize + next] as usize);
        &self.facets.triangles[first..end]
    }

    /// The box of a facet or cluster.
    pub fn facet_bounds(&self, facet: u32) -> BoundingBox {
        let all = self.triangles_of(facet).iter().map(|&triangle| self.bounds(triangle));
        all.fold(BoundingBox::EMPTY, |all, one| all.union(&one))
    }

    /// Looks at triangles of a facet as [`BoxTree::search`] does at items.
    pub fn search(
        &self,
        facet: u32,
        mut most: f64,
        distance: impl Fn(&BoundingBox) -> f64,
        mut look: impl FnMut(u32, f64) -> f64,
    ) {
        if let Some(tree) = self.tree_of(facet) {
            return tree.search(most, distance, look);
        }
        for &triangle in self.triangles_of(facet) {
            let away = distance(&self.bounds(triangle));
            if away <= most && away < f64::INFINITY {
                most = look(triangle, most);
            }
        }
    }

    /// Hands on the triangles of a facet whose boxes overlap one.
    pub fn in_facet(&self, facet: u32, bounds: &BoundingBox, take: impl FnMut(u32)) {
        self.in_facet_where(facet, bounds, |_| true, take);
    }

    /// The same of those whose boxes, and the boxes around them, are `admitted`.
    pub fn in_facet_where(
        &self,
        facet: u32,
        bounds: &BoundingBox,
        mut admitted: impl FnMut(&BoundingBox) -> bool,
        mut take: impl FnMut(u32),
    ) {
        if let Some(tree) = self.tree_of(facet) {
            tree.overlapping_where(bounds, admitted, |triangle| {
                take(triangle);
                ControlFlow::Continue(())
            });
            return;
        }
        for &triangle in self.triangles_of(facet) {
            let own = self.bounds(triangle);
            if bounds.overlaps(&own) && admitted(&own) {
                take(triangle);
            }
        }
    }

    /// The tree of a facet's triangles, if they are many.
    fn tree_of(&self, facet: u32) -> Option<&BoxTree> {
        if self.triangles_of(facet).len() <= LIST {
            return None;
        }
        let tree = self.facets.trees.binary_search_by_key(&facet, |(of, _)| *of).ok()?;
        Some(&self.facets.trees[tree].1)
    }

    /// The triangle that a facet is, if it is but one.
    pub fn only_triangle(&self, facet: u32) -> Option<u32> {
        match *self.triangles_of(facet) {
            [only] => Some(only),
            _ => None,
        }
    }

    /// How many.
    pub fn count(&self) -> u32 {
        self.corners.len() as u32
    }

    /// The box of one.
    pub fn bounds(&self, triangle: u32) -> BoundingBox {
        let [a, b, c] = self.corners_of(triangle);
        BoundingBox { low: a.inf(&b).inf(&c), high: a.sup(&b).sup(&c) }
    }

    /// Where its corners are.
    pub fn corners_of(&self, triangle: u32) -> [Vector3<f64>; 3] {
        self.corners[triangle as usize].map(|vertex| self.vertices[vertex as usize])
    }

    /// Its unit normal, to the front.
    pub fn normal(&self, triangle: u32) -> Vector3<f64> {
        self.normals[triangle as usize]
    }

    /// The vertex at a corner of a triangle.
    pub fn vertex_of(&self, triangle: u32, corner: usize) -> u32 {
        self.corners[triangle as usize][corner]
    }

    /// Whether a triangle is the first of those that meet at its corner.
    pub fn is_owner(&self, triangle: u32, corner: usize) -> bool {
        self.owners[self.vertex_of(triangle, corner) as usize] == triangle
    }

    /// One of them, placed.
    pub fn get(&self, index: u32) -> Triangle<'_> {
        let corners = self.corners_of(index);
        let [a, b, c] = corners;
        let middle = (a + b + c) / 3.0;
        let corners = corners.map(|corner| corner - middle);
        let radius = corners.iter().map(Vector3::norm).fold(0.0, f64::max);
        Triangle { mesh: self, index, middle, corners, normal: self.normal(index), radius }
    }

    fn neighbors(&self, vertex: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|next| self.first_neighbor[vertex as usize + next] as usize);
        &self.neighbors[first..end]
    }
}

impl Facets {
    fn count(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    fn push(&mut self, triangles: &[u32], mesh: &Triangles) {
        if triangles.len() > LIST {
            let boxes = triangles.iter().map(|&triangle| (triangle, mesh.bounds(triangle))).collect();
            self.trees.push((self.first.len() as u32 - 1, BoxTree::new(boxes)));
        }
        self.triangles.extend_from_slice(triangles);
        self.first.push(self.triangles.len() as u32);
    }
}

impl PartialEq for Triangles {
    /// All else follows from these.
    fn eq(&self, other: &Self) -> bool {
        (&self.vertices, &self.corners) == (&other.vertices, &other.corners)
    }
}

impl Triangle<'_> {
    /// Its vertices in the mesh.
    pub fn vertices(&self) -> [u32; 3] {
        self.mesh.corners[self.index as usize]
    }

    /// Whether the surface is foremost at this triangle along a unit direction, so that a contact may have it for a normal.
    pub fn admits(&self, direction: &Vector3<f64>) -> bool {
        let rise = direction.dot(&self.normal);
        rise >= SAME || rise >= -NORMAL_SLACK && (self.is_at_side(direction) || self.is_at_corner(direction))
    }

    /// Whether all of a side is foremost, of this triangle and the one beyond it.
    fn is_at_side(&self, direction: &Vector3<f64>) -> bool {
        let rises = |way: Vector3<f64>| way.dot(direction) / way.norm();
        (0..3).any(|from| {
            let [at, to, third] = [0, 1, 2].map(|next| self.corners[(from + next) % 3]);
            let is_beyond_lower = || {
                let beyond = self.mesh.beyond[self.index as usize][from];
                // The corner that is not on the side is the lowest, unless all are as high.
                beyond == u32::MAX
                    || self.mesh.corners_of(beyond).iter().all(|corner| {
                        let way = corner - self.middle - at;
                        way.norm_squared() == 0.0 || rises(way) <= NORMAL_SLACK
                    })
            };
            rises(to - at).abs() <= NORMAL_SLACK && rises(third - at) <= NORMAL_SLACK && is_beyond_lower()
        })
    }

    /// Whether the foremost vertex is foremost among its neighbors.
    fn is_at_corner(&self, direction: &Vector3<f64>) -> bool {
        let heights = self.corners.map(|corner| corner.dot(direction));
        let foremost = (0..3).max_by(|&one, &other| heights[one].total_cmp(&heights[other])).unwrap_or(0);
        let vertex = self.vertices()[foremost];
        let at = self.mesh.vertices[vertex as usize];
        self.mesh.neighbors(vertex).iter().all(|&neighbor| {
            let along = self.mesh.vertices[neighbor as usize] - at;
            along.dot(direction) <= NORMAL_SLACK * along.norm()
        })
    }

    /// Whether it is this triangle that has a contact of that normal at a corner of it, or at the side from there to the
    /// next: of those that share it the first, if that looks along the normal at all.
    pub fn owns(&self, corner: usize, is_side: bool, direction: &Vector3<f64>) -> bool {
        let first = if is_side {
            self.index.min(self.mesh.beyond[self.index as usize][corner])
        } else {
            self.mesh.owners[self.vertices()[corner] as usize]
        };
        first == self.index || self.mesh.get(first).normal.dot(direction) < -NORMAL_SLACK
    }
}
