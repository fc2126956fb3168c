//! Scenes as data: what is in them, their file format, built-in ones with parameters, spawning.
//!
//! A [`SceneSpec`] is plain data. Built-in scenes are functions from parameters to one
//! ([`catalog`]); a user's own comes from a RON file ([`SceneSpec::from_ron`]); both are checked by
//! [`SceneSpec::validate`] and become entities through [`SceneSpec::spawn`]. Back again:
//! [`SceneSpec::of_world`] and [`SceneSpec::to_ron`].

mod builtin;
mod capture;
mod catalog;
mod error;
mod format;
mod hull;
mod mesh;
mod number;
mod spawn;
mod spec;
mod validate;

pub use catalog::{Parameter, SceneInfo, catalog, find, is_path, load};
pub use error::SceneError;
pub use hull::HullSpec;
pub use mesh::{MAX_MESH_BYTES, MeshError, MeshSpec, PictureMesh, TriangleMesh, builtin_meshes};
pub use spawn::{BodyColor, SceneEntity, SpawnedScene};
pub use spec::{BodySpec, JointSpec, MaterialSpec, SceneSpec, ShapeSpec, ViewSpec};

/// Most bodies that a scene may have.
pub const MAX_BODIES: usize = 100_000;

/// Largest scene file that is read, bytes: several times what [`MAX_BODIES`] take.
pub const MAX_FILE_BYTES: u64 = 64 << 20;
