//! What can be wrong with a scene, each in one line that names the place.

/// Why a scene could not be had.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// No built-in scene and no file of that name.
    #[error("no scene '{0}'; 'plumb scenes' lists the built-in ones, a scene of your own is a path to a .ron file")]
    UnknownScene(String),
}
