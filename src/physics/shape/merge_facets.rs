//! Merges the near-coplanar facets of a triangulated hull into polygons (after Gregorius, GDC
//! 2014, but once the hull is built).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::quick_hull::{Triangulation, edges, spread};

/// The loops of the faces of a hull, counter-clockwise seen from outside. A face is flat and
/// convex up to the flatness; a vertex that only two faces are left around is dropped.
pub(super) fn merge(points: &[Vector3<f64>], hull: &Triangulation) -> Vec<Vec<u32>> {
    let mut patches = Patches::new(points, hull);
    let joints = patches.joints();
    // A merge may make room for one that was refused.
    while joints.iter().fold(false, |merged, &[a, b]| patches.merge(a, b) || merged) {}
    let mut loops: Vec<Vec<u32>> = patches.list.into_iter().flatten().map(|patch| patch.outline).collect();
    drop_vertices_between_two(&mut loops);
    for corners in &mut loops {
        let first = (0..corners.len()).min_by_key(|&index| corners[index]).unwrap_or(0);
        corners.rotate_left(first);
    }
    loops
}

/// Triangles that make one face.
struct Patch {
    triangles: Vec<u32>,
    /// Sum of the vectors along the triangles' normals, as long as twice their areas.
    area: Vector3<f64>,
    outline: Vec<u32>,
}

struct Patches<'a> {
    points: &'a [Vector3<f64>],
    triangles: &'a [[u32; 3]],
    flatness: f64,
    /// None: has become part of another.
    list: Vec<Option<Patch>>,
    /// Of each triangle.
    patch_of: Vec<usize>,
}

impl<'a> Patches<'a> {
    fn new(points: &'a [Vector3<f64>], hull: &'a Triangulation) -> Self {
        let patch = |(index, &corners): (usize, &[u32; 3])| {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            Some(Patch { triangles: vec![index as u32], area: (b - a).cross(&(c - a)), outline: corners.to_vec() })
        };
        Self {
            points,
            triangles: &hull.triangles,
            flatness: hull.flatness,
            list: hull.triangles.iter().enumerate().map(patch).collect(),
            patch_of: (0..hull.triangles.len()).collect(),
        }
    }

    /// Pairs of triangles that share an edge, those that bend least there first.
    fn joints(&self) -> Vec<[usize; 2]> {
        let mut owners = BTreeMap::new();
        let mut joints = Vec::new();
        for (index, &corners) in self.triangles.iter().enumerate() {
            for [from, to] in edges(corners) {
                owners.insert([from, to], index);
                if let Some(&other) = owners.get(&[to, from]) {
                    joints.push((self.bend(index, other), [other, index]));
                }
            }
        }
        joints.sort_by(|a, b| a.0.total_cmp(&b.0));
        joints.into_iter().map(|(_, pair)| pair).collect()
    }

    /// How far the one reaches behind the plane of the other, whichever is more.
    fn bend(&self, a: usize, b: usize) -> f64 {
        let depth = |plane: usize, other: usize| {
            let [p, q, r] = self.triangles[plane].map(|corner| self.points[corner as usize]);
            let normal = (q - p).cross(&(r - p)).normalize();
            self.triangles[other]
                .map(|corner| (p - self.points[corner as usize]).dot(&normal))
                .into_iter()
                .fold(0.0, f64::max)
        };
        f64::max(depth(a, b), depth(b, a))
    }

    /// Makes one patch of those of two triangles, if that is flat and convex.
    fn merge(&mut self, a: usize, b: usize) -> bool {
        let (into, from) = (self.patch_of[a], self.patch_of[b]);
        if into == from {
            return false;
        }
        let (Some(one), Some(other)) = (&self.list[into], &self.list[from]) else { return false };
        let triangles: Vec<u32> = one.triangles.iter().chain(&other.triangles).copied().collect();
        let area = one.area + other.area;
        let Some(outline) = self.outline(&triangles) else { return false };
        let corners: Vec<[u32; 3]> = triangles.iter().map(|&triangle| self.triangles[triangle as usize]).collect();
        if spread(self.points, &corners) > self.flatness || !self.is_convex(&outline, &area.normalize()) {
            return false;
        }
        for &triangle in &triangles {
            self.patch_of[triangle as usize] = into;
        }
        self.list[from] = None;
        self.list[into] = Some(Patch { triangles, area, outline });
        true
    }

    /// The loop around triangles, if it is a single one that passes no vertex twice.
    fn outline(&self, triangles: &[u32]) -> Option<Vec<u32>> {
        let sides: BTreeSet<[u32; 2]> =
            triangles.iter().flat_map(|&triangle| edges(self.triangles[triangle as usize])).collect();
        let outer: Vec<[u32; 2]> = sides.iter().copied().filter(|&[from, to]| !sides.contains(&[to, from])).collect();
        let next: BTreeMap<u32, u32> = outer.iter().map(|&[from, to]| (from, to)).collect();
        let start = outer.first()?[0];
        if next.len() < outer.len() {
            return None;
        }
        let mut outline = vec![start];
        let mut corner = next[&start];
        while corner != start {
            outline.push(corner);
            corner = next[&corner];
        }
        (outline.len() == outer.len()).then_some(outline)
    }

    /// Whether no corner lies inside the line between its neighbors.
    fn is_convex(&self, outline: &[u32], normal: &Vector3<f64>) -> bool {
        let at = |index: usize| self.points[outline[index % outline.len()] as usize];
        (0..outline.len()).all(|index| {
            let [before, corner, after] = [at(index), at(index + 1), at(index + 2)];
            let across = normal.cross(&(after - before));
            across.dot(&(before - corner)) >= -self.flatness * across.norm()
        })
    }
}

/// A vertex between two faces lies on their common edge. A triangle keeps its corners.
fn drop_vertices_between_two(loops: &mut [Vec<u32>]) {
    let mut faces_of: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (face, corners) in loops.iter().enumerate() {
        for &corner in corners {
            faces_of.entry(corner).or_default().push(face);
        }
    }
    for (vertex, faces) in faces_of {
        if faces.len() == 2 && faces.iter().all(|&face| loops[face].len() > 3) {
            for face in faces {
                loops[face].retain(|&corner| corner != vertex);
            }
        }
    }
}
