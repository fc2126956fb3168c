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

/// A component made of numbers.
pub(super) trait Numbers<const N: usize>: Copy {
    fn numbers(self) -> [f64; N];
}

/// Writes one row if that changes any bit of it.
#[track_caller]
#[inline]
pub(super) fn set_if_other<T: Numbers<N>, const N: usize>(column: &mut ContiguousMut<T>, row: usize, value: T) {
    let present: &[T] = column.as_ref();
    let (old, new) = (present[row].numbers(), value.numbers());
    // Without a branch: the lot is compared in two or three instructions.
    let difference = (0..N).fold(0, |bits, index| bits | (old[index].to_bits() ^ new[index].to_bits()));
    if difference != 0 {
        set(column, row, value);
    }
}
