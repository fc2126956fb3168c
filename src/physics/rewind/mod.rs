//! Going back: the whole state of a world between two steps, kept and brought back bit for bit.
//!
//! **What is kept.** Every module says which of its components and resources the next step depends on ([`Keep`]); a
//! [`Keyframe`] holds a copy of each, hidden ones included: the tree of the broad phase, the order of slots, what
//! contacts and joints carried, islands and their factors, who sleeps and how long others have been calm. So a world
//! that was brought back goes on as it went on the first time, to the last bit. What systems read beside values, which of
//! them are new, is kept as well: whether a component was written by the last step, after it, or before.
//!
//! **Acts.** What others write between two steps (poses, velocities, joints, settings; bodies that come and go) is noted
//! before each step, whoever wrote it: [`History`] runs on from a keyframe by making the same acts before the same steps.
//!
//! **Entities.** One that goes is not despawned while a history is kept, but emptied ([`bury`]), so that it can come back
//! as the one that it was: whoever refers to it refers to it still.

mod acts;
mod branch;
mod bury;
mod history;
mod keyframe;
mod kinds;
mod taking_back;

pub use acts::Deeds;
pub use bury::{bury, is_empty};
pub use history::{GoError, History, Told, begin_anew, go_to, retell};
pub(crate) use history::{note_blank, step_and_note};
pub use kinds::Keep;
pub use taking_back::{Mark, swap_cut, take_back_since, uncut};
