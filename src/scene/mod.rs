//! Scenes as data: what is in them, their file format, built-in ones with parameters, spawning.
//!
//! A [`SceneSpec`] is plain data. Built-in scenes are functions from parameters to one
//! ([`catalog`]); a user's own comes from a RON file ([`SceneSpec::from_ron`]); both are checked by
//! [`SceneSpec::validate`] and become entities through [`SceneSpec::spawn`]. Back again:
//! [`SceneSpec::of_world`] and [`SceneSpec::to_ron`].

mod body;
mod builtin;
mod capture;
mod catalog;
mod error;
mod format;
mod height_picture;
mod hull;
mod info;
mod joint;
mod mesh;
mod number;
mod pieces;
mod probe;
mod shape;
mod spawn;
mod spec;
mod surface;
mod validate;

pub use body::{BodySpec, MaterialSpec};
pub use catalog::{catalog, find, is_path, load};
pub use error::SceneError;
pub use format::MAX_FILE_BYTES;
pub use height_picture::{HeightPictureError, builtin_height_pictures};
pub use hull::HullSpec;
pub use info::{Parameter, SceneInfo, Subject};
#[cfg(feature = "sandbox")]
pub(crate) use joint::JointComponent;
pub(crate) use joint::JointParts;
pub use joint::{JointKindSpec, JointSpec, LimitSpec, MotorKeys};
pub use mesh::{MAX_MESH_BYTES, MeshSpec, ObjError, ObjMesh, PictureMesh, builtin_meshes};
pub use pieces::{MOST_PIECES, PiecesError};
pub use probe::{MAX_PROBES, Probe, ProbePlot, ProbePoint, ProbeSpec, ProbeSubject, Probes};
pub use shape::{ChildSpec, CompoundSpec, ShapeSpec};
pub use spawn::{BodyColor, SceneEntity, SpawnedScene, keep_scene};
pub use spec::{MAX_BODIES, SceneSpec, ViewSpec};
pub use surface::{SurfaceError, SurfaceForm, SurfaceSpec};
#[cfg(feature = "sandbox")]
pub(crate) use validate::check_parts;
