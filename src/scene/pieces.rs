//! A mesh in convex pieces, so that what is hollow stays hollow. The cuts are those of V-HACD (Mamou and Ghorbel 2009), as
//! Parry has it; a piece is the hull of that part of the mesh's surface which lies between them.
//!
//! The body weighs as its pieces do, not as the mesh: where its mass is, there it collides, and a mesh that is open has a
//! mass, too. In a bowl the pieces fill what is hollow between their ends, and overlap a little.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use bevy::math::DVec3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

use crate::physics::{Collider, Compound, CompoundChild, ConvexHull};

/// Most pieces that can be asked for: each costs as a body does where it is near something.
pub const MOST_PIECES: u32 = 64;

/// Most triangles of a mesh that is cut: the time goes with them.
const MOST_TRIANGLES: usize = 1 << 18;

/// Voxels along the longest side, which cuts run between; the time goes with their number cubed.
/// `scene_pieces::pieces_cover_the_mesh_and_keep_near_it`.
const VOXELS: u32 = 32;

/// How much of the whole hull's volume a piece may be more than its mesh. It is doubled until there are few enough pieces.
const CONCAVITY: f64 = 0.01;

/// Why a mesh cannot be cut in pieces. Displays as one line.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PiecesError {
    /// Too few or too many are asked for.
    #[error("must be from 2 to {MOST_PIECES}, is {asked}; without it, the body is the hull of the whole mesh")]
    Count {
        /// How many.
        asked: u32,
    },
    /// The mesh is too fine.
    #[error("a mesh of {count} triangles is not cut in pieces; export it with at most {MOST_TRIANGLES}")]
    TooManyTriangles {
        /// Triangles.
        count: usize,
    },
    /// No piece has a volume.
    #[error("no piece of the mesh has a volume; its triangles should enclose one")]
    NoVolume,
}

/// Where the corners of each piece may be, at scale 1.
type Pieces = Arc<Vec<Vec<DVec3>>>;

/// What this process has cut, by fingerprint and number: scenes are loaded anew often.
static KNOWN: LazyLock<Mutex<HashMap<(u64, u32), Pieces>>> = LazyLock::new(Mutex::default);

/// The triangles of a mesh file, and what tells them apart from those of others.
#[derive(Clone, Copy)]
pub(super) struct Whole<'a> {
    pub positions: &'a [DVec3],
    pub triangles: &'a [[u32; 3]],
    pub fingerprint: u64,
}

/// A mesh as a body of at most that many hulls, that many times as large.
pub(super) fn in_pieces(mesh: Whole, scale: f64, most: u32) -> Result<Compound, PiecesError> {
    if !(2..=MOST_PIECES).contains(&most) {
        return Err(PiecesError::Count { asked: most });
    }
    if mesh.triangles.len() > MOST_TRIANGLES {
        return Err(PiecesError::TooManyTriangles { count: mesh.triangles.len() });
    }
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let pieces = known.entry((mesh.fingerprint, most)).or_insert_with(|| Arc::new(cut(mesh, most))).clone();
    drop(known);
    let children = pieces.iter().filter_map(|points| {
        let points: Vec<DVec3> = points.iter().map(|&point| point * scale).collect();
        let hull = ConvexHull::new(&points).ok()?;
        let (position, rotation) = (hull.center(), hull.axes());
        Some(CompoundChild { collider: Collider::hull(hull), position, rotation })
    });
    Compound::new(&children.collect::<Vec<_>>()).map_err(|_| PiecesError::NoVolume)
}

/// The points of each piece.
fn cut(mesh: Whole, most: u32) -> Vec<Vec<DVec3>> {
    let bounds = |(low, high): (DVec3, DVec3), &point: &DVec3| (low.min(point), high.max(point));
    let (low, high) = mesh.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
    // A power of two: scaling by it rounds nothing, and what is very large or small becomes of usual size.
    let unit = (high / 2.0 - low / 2.0).max_element().log2().ceil().exp2();
    let middle = high / 2.0 + low / 2.0;
    let points: Vec<Vector> = mesh.positions.iter().map(|&point| to_parry((point - middle) / unit)).collect();
    let cuts = |concavity: f64| {
        let parameters =
            VHACDParameters { resolution: VOXELS, concavity, max_convex_hulls: most, ..VHACDParameters::default() };
        VHACD::decompose(&parameters, &points, mesh.triangles, true)
    };
    let mut concavity = CONCAVITY;
    let mut parts = cuts(concavity);
    // At 1, the hull of the whole is one piece.
    while parts.voxel_parts().len() > most as usize && concavity < 1.0 {
        concavity *= 2.0;
        parts = cuts(concavity);
    }
    let to_mesh = |&point: &Vector| middle + DVec3::from_array(point.to_array()) * unit;
    let pieces = parts.voxel_parts().iter().filter(|part| !part.voxels().is_empty()).map(|part| {
        let surface: Vec<DVec3> =
            part.compute_primitive_intersections(&points, mesh.triangles).iter().map(to_mesh).collect();
        let corners = if ConvexHull::new(&surface).is_ok() {
            // With the cuts through what is solid, which the surface alone has not.
            part.compute_exact_convex_hull(&points, mesh.triangles).0
        } else {
            // All inside, or a flat piece of an open surface: as thick as its voxels.
            part.compute_convex_hull(1).0
        };
        corners.iter().map(to_mesh).collect()
    });
    pieces.collect()
}

fn to_parry(point: DVec3) -> Vector {
    Vector::from_array(point.to_array())
}
