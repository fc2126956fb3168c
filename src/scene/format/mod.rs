//! The scene file: RON, with a default for whatever a scene does not say. Its entries are in `entry`; how
//! they become a scene is in `read`, how a scene becomes entries in `write`.
//!
//! What a number may be is held by the types it is read through (`number.rs`), so that the parser
//! names line and column; what only the whole scene shows is named by its path in it.

mod entry;
mod joint;
mod probe;
mod read;
mod usual;
mod write;

pub use read::MAX_FILE_BYTES;
pub(super) use read::read;
