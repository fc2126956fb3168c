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

/// Writes one row, made of those numbers, if that changes any bit of it.
#[track_caller]
#[inline]
pub(super) fn set_if_other<T, const N: usize>(
    column: &mut ContiguousMut<T>,
    row: usize,
    value: T,
    numbers: impl Fn(&T) -> [f64; N],
) {
    let (old, new) = (numbers(&column.as_ref()[row]), numbers(&value));
    // Without a branch: the lot is compared in two or three instructions.
    let difference = (0..N).fold(0, |bits, index| bits | (old[index].to_bits() ^ new[index].to_bits()));
    if difference != 0 {
        set(column, row, value);
    }
}
