//! Time that runs both ways: back to any moment that is kept, on from there, backwards, round and round.

mod ahead;
mod head;
mod looking;
mod plugin;
mod poses;
mod shown;

pub(super) use ahead::{change_places, is_another_future};
pub use head::Timeline;
pub(super) use head::{
    LIMIT, begin, end, go, go_on, go_to_end, head_and_reach, step_back, stop, toggle_backwards, toggle_loop,
    toggle_mark,
};
pub(super) use looking::{arrive, look_at};
pub(super) use plugin::plugin;
pub(super) use poses::PoseTrack;
pub use shown::ShownStep;
