//! What a body is of its mesh.

use std::path::Path;

use crate::scene::{MeshSpec, ShapeSpec, SurfaceForm, SurfaceSpec, builtin_meshes};

/// What a body is of its mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshForm {
    /// Its convex hull.
    #[default]
    Hull,
    /// The hulls of its convex pieces, at most so many.
    Pieces(u32),
    /// Its triangles, of a body that is fixed.
    Surface {
        /// Whether their backs are solid, too.
        two_sided: bool,
    },
}

impl MeshForm {
    /// How many pieces a mesh has at most where nobody says.
    pub const USUAL_PIECES: u32 = 16;

    /// What a shape is of which file at which scale, if it is of one.
    pub fn of(shape: &ShapeSpec) -> Option<(&str, f64, Self)> {
        match shape {
            ShapeSpec::Mesh(mesh) => {
                Some((mesh.file(), mesh.scale(), mesh.most_pieces().map_or(Self::Hull, Self::Pieces)))
            }
            ShapeSpec::Surface(surface) => match surface.form() {
                SurfaceForm::File { file, scale, .. } => {
                    Some((file, *scale, Self::Surface { two_sided: surface.is_two_sided() }))
                }
                SurfaceForm::Heights { .. } | SurfaceForm::Picture { .. } | SurfaceForm::Triangles { .. } => None,
            },
            _ => None,
        }
    }

    /// The shape that it is of a file. The error is one line that names the file.
    pub(super) fn load(self, file: &str, scale: f64) -> Result<ShapeSpec, String> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(format!("{file}: a scale must be greater than 0, is {scale}"));
        }
        let is_builtin = builtin_meshes().any(|name| name == file);
        // A scene that is saved elsewhere still finds it.
        let path =
            if is_builtin { file.into() } else { std::path::absolute(file).map_err(|error| error.to_string())? };
        let (path, folder) = (path.to_string_lossy(), Path::new(""));
        let mesh = || MeshSpec::load(&path, folder, scale).map_err(|error| error.to_string());
        match self {
            Self::Hull => mesh().map(ShapeSpec::Mesh),
            Self::Pieces(most) => {
                mesh()?.with_pieces(most).map(ShapeSpec::Mesh).map_err(|error| format!("{file}: pieces: {error}"))
            }
            Self::Surface { two_sided } => SurfaceSpec::load(&path, folder, scale, two_sided)
                .map(ShapeSpec::Surface)
                .map_err(|error| error.to_string()),
        }
    }
}
