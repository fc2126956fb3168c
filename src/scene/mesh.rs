//! Meshes: a body is the convex hull of one, or of each of its pieces, and looks like it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{DQuat, DVec3, Vec3};
use bevy::prelude::Component;
use xxhash_rust::xxh3::xxh3_64;

use super::pieces::{PiecesError, Whole, in_pieces};
use super::surface::{SurfaceForm, SurfaceSpec};
use crate::physics::{Collider, Compound, ConvexHull, HullError, MeshError, TriangleMesh};

/// Largest mesh file that is read, bytes: some millions of triangles.
pub const MAX_MESH_BYTES: u64 = 256 << 20;

/// What the names of the files that come with Plumb start with, in a scene's `file`.
pub(super) const BUILTIN_PREFIX: &str = "plumb:";

/// The meshes that come with Plumb, by name.
const BUILTIN: [(&str, &str); 6] = [
    ("bone.obj", include_str!("../../assets/meshes/bone.obj")),
    ("bowl.obj", include_str!("../../assets/meshes/bowl.obj")),
    ("dodecahedron.obj", include_str!("../../assets/meshes/dodecahedron.obj")),
    ("gem.obj", include_str!("../../assets/meshes/gem.obj")),
    ("rock.obj", include_str!("../../assets/meshes/rock.obj")),
    ("wedge.obj", include_str!("../../assets/meshes/wedge.obj")),
];

/// What a scene's `file` says for each mesh that comes with Plumb: `plumb:gem.obj` and so on.
pub fn builtin_meshes() -> impl Iterator<Item = String> {
    BUILTIN.iter().map(|(name, _)| format!("{BUILTIN_PREFIX}{name}"))
}

/// Triangles as a mesh file has them.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjMesh {
    /// The vertices that triangles use, m at scale 1.
    pub positions: Vec<DVec3>,
    /// Indices of positions, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One per corner of each triangle; none where the file lacks any: flat triangles.
    pub normals: Vec<[Vec3; 3]>,
    /// Tells meshes of different files apart.
    pub fingerprint: u64,
}

/// A mesh of a scene: which file, how large, its triangles and its hull. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSpec {
    file: Arc<str>,
    path: Option<Arc<Path>>,
    scale: f64,
    mesh: Arc<ObjMesh>,
    hull: ConvexHull,
    /// At most how many, and what they are.
    pieces: Option<(u32, Compound)>,
}

/// What a body looks like, where that is not its collider. In the frame of the mesh file; the
/// [`MeshSpec::center`] and [`MeshSpec::axes`] place the body in it.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct PictureMesh(pub MeshSpec);

/// Why a mesh could not be had. Displays as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjError {
    /// None of that name comes with Plumb.
    #[error("no mesh '{file}' comes with Plumb; there are {}", builtin_meshes().collect::<Vec<_>>().join(", "))]
    UnknownBuiltin {
        /// What was asked for.
        file: String,
    },
    /// The file cannot be read.
    #[error("{} cannot be read: {problem}; a mesh's path is relative to its scene's file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: String,
    },
    /// The file is larger than [`MAX_MESH_BYTES`].
    #[error("{} is larger than {} MiB, the limit for a mesh; export it with fewer triangles", path.display(), MAX_MESH_BYTES >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is no OBJ mesh.
    #[error("{file} is not a Wavefront OBJ text file ({problem}); export the mesh as OBJ")]
    NotObj {
        /// The file.
        file: String,
        /// What the parser stumbled over.
        problem: String,
    },
    /// The file has no faces.
    #[error("{file} has no faces; a mesh needs lines that start with 'f', for points alone use Hull(points: [...])")]
    NoFaces {
        /// The file.
        file: String,
    },
    /// A coordinate is NaN or infinite.
    #[error("{file} has a vertex that is not finite: {vertex}; correct that line")]
    NotFinite {
        /// The file.
        file: String,
        /// The vertex.
        vertex: DVec3,
    },
    /// Its triangles are no surface.
    #[error("{file}: {error}")]
    Surface {
        /// The file.
        file: String,
        /// What is wrong with them.
        error: MeshError,
    },
    /// Its hull has no volume, or too much.
    #[error("{file}: {error}")]
    Hull {
        /// The file.
        file: String,
        /// What is wrong with its vertices.
        error: HullError,
    },
    /// It cannot be cut in pieces.
    #[error("{0}")]
    Pieces(#[from] PiecesError),
}

impl MeshSpec {
    /// Reads a Wavefront OBJ file: all its objects are one mesh. `file` is relative to `folder`,
    /// or the name of one that comes with Plumb ([`builtin_meshes`]); the mesh is made `scale`
    /// times as large, which must be finite and greater than 0.
    ///
    /// # Errors
    /// The file is missing, too large, not an OBJ mesh, or its hull has no volume.
    pub fn load(file: &str, folder: &Path, scale: f64) -> Result<Self, ObjError> {
        Meshes::new(folder).load(file, scale, None)
    }

    /// Of at most so many convex pieces, so that what is hollow can hold something.
    ///
    /// # Errors
    /// There are to be fewer than 2 pieces or more than [`MOST_PIECES`](super::MOST_PIECES), or the mesh is too fine.
    pub fn with_pieces(mut self, most: u32) -> Result<Self, PiecesError> {
        let ObjMesh { positions, triangles, fingerprint, .. } = &*self.mesh;
        let whole = Whole { positions, triangles, fingerprint: *fingerprint };
        self.pieces = Some((most, in_pieces(whole, self.scale, most)?));
        Ok(self)
    }

    /// One that comes with Plumb, by its name without prefix.
    ///
    /// # Panics
    /// None of that name does.
    pub(super) fn builtin(name: &str, scale: f64) -> Self {
        let mesh = Self::load(&format!("{BUILTIN_PREFIX}{name}"), Path::new(""), scale);
        mesh.unwrap_or_else(|error| panic!("{error}"))
    }

    /// As a scene file has it: `rock.obj`, `plumb:gem.obj`.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Where the file is; none for one that comes with Plumb.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Factor on the file's coordinates.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The triangles, at scale 1.
    pub fn mesh(&self) -> &Arc<ObjMesh> {
        &self.mesh
    }

    /// The hull of the whole, scaled.
    pub fn hull(&self) -> &ConvexHull {
        &self.hull
    }

    /// What it is in pieces, if it is, scaled.
    pub fn pieces(&self) -> Option<&Compound> {
        self.pieces.as_ref().map(|(_, compound)| compound)
    }

    /// How many pieces it may have at most, if it has any.
    pub fn most_pieces(&self) -> Option<u32> {
        self.pieces.as_ref().map(|&(most, _)| most)
    }

    /// As a component.
    pub fn collider(&self) -> Collider {
        self.pieces().cloned().map_or_else(|| Collider::hull(self.hull.clone()), Collider::of_compound)
    }

    /// The body's centre of mass, in the file's axes, scaled.
    pub fn center(&self) -> DVec3 {
        self.pieces().map_or_else(|| self.hull.center(), Compound::center)
    }

    /// Turns the body's principal axes into the file's.
    pub fn axes(&self) -> DQuat {
        self.pieces().map_or_else(|| self.hull.axes(), Compound::axes)
    }
}

/// The meshes of one scene: each file is read once, and the hull or pieces of each size built once.
pub(super) struct Meshes {
    folder: PathBuf,
    read: HashMap<String, Arc<ObjMesh>>,
    made: HashMap<(String, u64, Option<u32>), MeshSpec>,
}

impl SurfaceSpec {
    /// The triangles of a Wavefront OBJ file: `file` and `scale` as [`MeshSpec::load`](super::MeshSpec::load) has them.
    ///
    /// # Errors
    /// The file is missing, too large or not an OBJ mesh, or its triangles are no surface.
    pub fn load(file: &str, folder: &Path, scale: f64, two_sided: bool) -> Result<Self, ObjError> {
        Meshes::new(folder).load_surface(file, scale, two_sided)
    }
}

impl Meshes {
    /// Files are relative to `folder`.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), read: HashMap::new(), made: HashMap::new() }
    }

    /// What files are relative to.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// As [`MeshSpec::load`], and [`MeshSpec::with_pieces`] where there are to be some.
    pub fn load(&mut self, file: &str, scale: f64, pieces: Option<u32>) -> Result<MeshSpec, ObjError> {
        let slot = match self.made.entry((file.to_owned(), scale.to_bits(), pieces)) {
            Entry::Occupied(made) => return Ok(made.get().clone()),
            Entry::Vacant(slot) => slot,
        };
        let ReadMesh { mesh, path, shown } = read_once(&mut self.read, &self.folder, file)?;
        let points: Vec<DVec3> = mesh.positions.iter().map(|&position| position * scale).collect();
        let hull = ConvexHull::new(&points).map_err(|error| ObjError::Hull { file: shown, error })?;
        let whole = MeshSpec { file: file.into(), path: path.map(Into::into), scale, mesh, hull, pieces: None };
        let made = match pieces {
            Some(most) => whole.with_pieces(most)?,
            None => whole,
        };
        Ok(slot.insert(made).clone())
    }

    /// The surface that the triangles of a file are, that many times as large.
    pub fn load_surface(&mut self, file: &str, scale: f64, two_sided: bool) -> Result<SurfaceSpec, ObjError> {
        let ReadMesh { mesh, path, shown } = read_once(&mut self.read, &self.folder, file)?;
        let vertices: Vec<DVec3> = mesh.positions.iter().map(|&position| position * scale).collect();
        let form = SurfaceForm::File { file: file.into(), path: path.map(Into::into), scale };
        let made =
            TriangleMesh::new(&vertices, &mesh.triangles).and_then(|mesh| SurfaceSpec::of(form, mesh, two_sided));
        made.map_err(|error| ObjError::Surface { file: shown, error })
    }
}

/// The triangles of a file, and where it is.
struct ReadMesh {
    mesh: Arc<ObjMesh>,
    path: Option<PathBuf>,
    /// As errors name it.
    shown: String,
}

fn read_once(known: &mut HashMap<String, Arc<ObjMesh>>, folder: &Path, file: &str) -> Result<ReadMesh, ObjError> {
    let path = (!file.starts_with(BUILTIN_PREFIX)).then(|| folder.join(file));
    let shown = path.as_ref().map_or(file.to_owned(), |path| path.display().to_string());
    let mesh = match known.entry(file.to_owned()) {
        Entry::Occupied(read) => read.get().clone(),
        Entry::Vacant(slot) => {
            let mesh = match &path {
                Some(path) => parse(&read(path)?, &shown)?,
                None => parse(builtin(file)?.as_bytes(), &shown)?,
            };
            slot.insert(Arc::new(mesh)).clone()
        }
    };
    Ok(ReadMesh { mesh, path, shown })
}

fn builtin(file: &str) -> Result<&'static str, ObjError> {
    let known = BUILTIN.iter().find(|(name, _)| file.strip_prefix(BUILTIN_PREFIX) == Some(name));
    known.map(|&(_, text)| text).ok_or_else(|| ObjError::UnknownBuiltin { file: file.to_owned() })
}

fn read(path: &Path) -> Result<Vec<u8>, ObjError> {
    let unreadable = |error: io::Error| ObjError::Unreadable { path: path.to_owned(), problem: error.to_string() };
    // One byte more than allowed tells a file that is too large from one that just fits.
    let limit = MAX_MESH_BYTES + 1;
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(limit).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 == limit {
        return Err(ObjError::TooLarge { path: path.to_owned() });
    }
    Ok(bytes)
}

fn parse(mut text: &[u8], file: &str) -> Result<ObjMesh, ObjError> {
    let fingerprint = xxh3_64(text);
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // Colours come from the scene: material files are not looked for.
    let no_materials = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut text, &options, no_materials)
        .map_err(|error| ObjError::NotObj { file: file.to_owned(), problem: error.to_string() })?;
    let mut mesh = ObjMesh { positions: Vec::new(), triangles: Vec::new(), normals: Vec::new(), fingerprint };
    let mut has_normals = true;
    for model in models {
        let part = model.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(part.positions.chunks_exact(3).map(DVec3::from_slice));
        mesh.triangles.extend(part.indices.chunks_exact(3).map(|corners| [0, 1, 2].map(|i| first + corners[i])));
        has_normals &= part.normal_indices.len() == part.indices.len() && part.normals.iter().all(|n| n.is_finite());
        let normal = |index: u32| DVec3::from_slice(&part.normals[3 * index as usize..]).as_vec3();
        mesh.normals.extend(part.normal_indices.chunks_exact(3).map(|corners| [0, 1, 2].map(|i| normal(corners[i]))));
    }
    if !has_normals {
        mesh.normals.clear();
    }
    if mesh.triangles.is_empty() {
        return Err(ObjError::NoFaces { file: file.to_owned() });
    }
    match mesh.positions.iter().find(|position| !position.is_finite()) {
        Some(&vertex) => Err(ObjError::NotFinite { file: file.to_owned(), vertex }),
        None => Ok(mesh),
    }
}
