//! Rows of component columns, written with change detection row by row.

use std::panic::Location;

use bevy::ecs::change_detection::ContiguousMut;

/// Writes one row and marks it changed. (Dereferencing a column mutably would mark all of it.)
#[track_caller]
#[inline]
pub(super) fn set<T>(column: &mut ContiguousMut<T>, row: usize, value: T) {
    let caller = Location::caller();
    let this_run = column.this_run_tick();
    column.bypass_change_detection()[row] = value;
    column.changed_ticks_slice_mut()[row] = this_run;
    column.changed_by_ticks_slice_mut().map(|changed_by| changed_by[row] = caller);
}
