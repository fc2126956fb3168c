//! What belongs to moments that the scene has gone back from: set aside, the next last, until it comes to them again.

use std::collections::VecDeque;

use bevy::prelude::*;

use crate::physics::History;

/// Moves what is past to the one list, the oldest first, and what is not to the other.
pub fn change_places<T>(past: &mut VecDeque<T>, ahead: &mut Vec<T>, is_past: impl Fn(&T) -> bool) {
    while let Some(later) = past.pop_back_if(|last| !is_past(last)) {
        ahead.push(later);
    }
    while let Some(earlier) = ahead.pop_if(|next| is_past(next)) {
        past.push_back(earlier);
    }
}

/// A run condition: what is to come has become something else, so that what was set aside is not of it.
pub fn is_another_future(history: Option<Res<History>>, mut seen: Local<u64>) -> bool {
    let turns = history.map_or(0, |history| history.turns());
    std::mem::replace(&mut *seen, turns) != turns
}
