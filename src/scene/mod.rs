//! Scenes as data: what is in them, their file format, built-in ones with parameters, spawning.
//!
//! A [`SceneSpec`] is plain data. Built-in scenes are functions from parameters to one
//! ([`catalog`]); a user's own comes from a RON file ([`SceneSpec::from_ron`]); both are checked by
//! [`SceneSpec::validate`] and become entities through [`SceneSpec::spawn`].

mod catalog;
mod error;
mod spawn;
mod spec;

pub use catalog::{Parameter, SceneInfo, catalog, find, load};
pub use error::SceneError;
pub use spawn::{SceneEntity, SpawnedScene};
pub use spec::{BodySpec, JointSpec, MaterialSpec, SceneSpec, ShapeSpec, ViewSpec};
