//! Sweeps: many runs of scenes with many settings, measured one after the other and kept in a
//! file that survives interrupts.
//!
//! A [`Point`] says what to run, a [`Record`] what came of it, a [`Store`] keeps records in an
//! append-only CSV with a key per point. Resuming, sharding over machines and merging are then one
//! thing: points whose key is in the file are not run again, and files are merged by concatenation.

mod point;
mod record;
mod runner;
mod store;

pub use point::{Point, Shard};
pub use record::Record;
pub use runner::{Budget, Progress, run};
pub use store::{Store, StoreError, read_records};
