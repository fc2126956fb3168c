//! Surfaces of triangles as shapes of a scene: grounds that are not flat, and what a mesh file has.

use std::path::Path;
use std::sync::Arc;

use bevy::math::DVec3;

use crate::physics::{MeshError, TriangleMesh};

/// A surface, and what it was made from. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSpec(Arc<Inner>);

#[derive(Debug, PartialEq)]
struct Inner {
    form: SurfaceForm,
    two_sided: bool,
    mesh: TriangleMesh,
}

/// What a surface is made from.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceForm {
    /// Heights over a rectangle about the body's position.
    Heights {
        /// Along x and z, m.
        size: [f64; 2],
        /// m, row by row along z, each along x.
        rows: Vec<Vec<f64>>,
    },
    /// Heights over a rectangle about the body's position, from a picture.
    Picture {
        /// As the scene has it.
        file: Arc<str>,
        /// Where it is; none for one that comes with Plumb.
        path: Option<Arc<Path>>,
        /// Along x and z, m.
        size: [f64; 2],
        /// Of black and of white, m.
        height: [f64; 2],
    },
    /// The triangles of a mesh file.
    File {
        /// As the scene has it.
        file: Arc<str>,
        /// Where it is; none for one that comes with Plumb.
        path: Option<Arc<Path>>,
        /// Factor on its coordinates.
        scale: f64,
    },
    /// Vertices, m, and triangles by the indices of their corners.
    Triangles {
        /// In the body's axes.
        vertices: Vec<DVec3>,
        /// Counter-clockwise seen from the front.
        triangles: Vec<[u32; 3]>,
    },
}

/// Why heights or triangles are no surface. Displays as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Too few.
    #[error("{rows} rows of {columns} heights; give at least 2 rows of at least 2")]
    TooFew {
        /// Rows.
        rows: usize,
        /// Heights in the first.
        columns: usize,
    },
    /// Rows of different lengths.
    #[error("row {row} (counted from 0) has {count} heights and the first {first}; give all as many")]
    Ragged {
        /// Which.
        row: usize,
        /// What it has.
        count: usize,
        /// What the first has.
        first: usize,
    },
    /// They are no mesh.
    #[error("{0}")]
    Mesh(#[from] MeshError),
}

impl SurfaceSpec {
    /// A ground over a rectangle of that size along x and z, m, about the body's position: rows of heights in m along z, each
    /// along x.
    ///
    /// # Errors
    /// Rows are too few or too short or differ in length, or a number is not finite.
    pub fn heights(size: [f64; 2], rows: Vec<Vec<f64>>) -> Result<Self, SurfaceError> {
        let columns = rows.first().map_or(0, Vec::len);
        if rows.len() < 2 || columns < 2 {
            return Err(SurfaceError::TooFew { rows: rows.len(), columns });
        }
        if let Some((row, wrong)) = rows.iter().enumerate().find(|(_, row)| row.len() != columns) {
            return Err(SurfaceError::Ragged { row, count: wrong.len(), first: columns });
        }
        let [nx, nz] = [columns, rows.len()].map(|count| count as u32 - 1);
        let mesh = TriangleMesh::grid(size, [nx, nz], |[i, k], _| rows[k as usize][i as usize])?;
        Ok(Self::of(SurfaceForm::Heights { size, rows }, mesh, false)?)
    }

    /// Any triangles.
    ///
    /// # Errors
    /// They are no mesh.
    pub fn triangles(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>, two_sided: bool) -> Result<Self, MeshError> {
        let mesh = TriangleMesh::new(&vertices, &triangles)?;
        Self::of(SurfaceForm::Triangles { vertices, triangles }, mesh, two_sided)
    }

    /// A mesh that was made from something.
    pub(super) fn of(form: SurfaceForm, mesh: TriangleMesh, two_sided: bool) -> Result<Self, MeshError> {
        let mesh = if two_sided { mesh.two_sided()? } else { mesh };
        Ok(Self(Arc::new(Inner { form, two_sided, mesh })))
    }

    /// What it was made from.
    pub fn form(&self) -> &SurfaceForm {
        &self.0.form
    }

    /// Whether its back is a surface, too.
    pub fn is_two_sided(&self) -> bool {
        self.0.two_sided
    }

    /// The triangles.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.0.mesh
    }
}

impl From<&TriangleMesh> for SurfaceSpec {
    /// That very mesh.
    fn from(mesh: &TriangleMesh) -> Self {
        let form = SurfaceForm::Triangles { vertices: mesh.vertices().collect(), triangles: mesh.triangles().to_vec() };
        Self(Arc::new(Inner { form, two_sided: false, mesh: mesh.clone() }))
    }
}
