//! Debug builds assert that no two threads touch one record: every element of a [`Shared`](super::Shared) remembers
//! who claimed it last.
//!
//! Work is divided on two levels, into blocks ([`super::for_each_block`]) and, within a block, into the chunks of
//! one stage after the other ([`super::Stages`]). Within one division an element that one claimant writes may be
//! touched by no other. That is asserted whatever the order in which claimants happen to run, so also on one thread.
//! In release builds all of it is empty.

use std::cell::Cell;
#[cfg(debug_assertions)]
use std::sync::atomic::AtomicU64;
use std::sync::atomic::{AtomicU32, Ordering};

/// Levels of division: blocks, chunks.
const LEVELS: usize = 2;
/// In the place of a claimant: several claimants read the element.
#[cfg(debug_assertions)]
const READERS: u32 = u32::MAX - 1;

/// Who works in the present division of each level: the division's number, then the claimant's. 0: nobody.
type Claimants = [(u32, u32); LEVELS];

thread_local! {
    static CLAIMANTS: Cell<Claimants> = const { Cell::new([(0, 0); LEVELS]) };
}

/// A division of work among claimants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Division {
    level: usize,
    number: u32,
    /// Claimants on the other levels.
    around: Claimants,
}

impl Division {
    /// Work divided into blocks.
    pub fn of_blocks() -> Self {
        Self::new(0, 1)
    }

    /// The first of so many stages, each divided into chunks.
    pub fn of_stages(stages: usize) -> Self {
        Self::new(1, stages)
    }

    fn new(level: usize, count: usize) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        if !cfg!(debug_assertions) {
            return Self { level, number: 0, around: [(0, 0); LEVELS] };
        }
        Self { level, number: NEXT.fetch_add(count as u32, Ordering::Relaxed), around: CLAIMANTS.get() }
    }

    /// The division that many stages later.
    pub fn stage(self, index: usize) -> Self {
        Self { number: self.number.wrapping_add(index as u32), ..self }
    }

    /// Works as the claimant of that index.
    pub fn work_as<R>(&self, claimant: usize, work: impl FnOnce() -> R) -> R {
        if !cfg!(debug_assertions) {
            return work();
        }
        let mut claimants = self.around;
        claimants[self.level] = (self.number, claimant as u32);
        let _before = Before(CLAIMANTS.replace(claimants));
        work()
    }
}

/// Puts the claimants of a thread back, also where its work panics.
struct Before(Claimants);

impl Drop for Before {
    fn drop(&mut self) {
        CLAIMANTS.set(self.0);
    }
}

/// Of each element of a list, who claimed it last, by level.
#[derive(Debug, Default)]
pub(crate) struct Claims(#[cfg(debug_assertions)] Vec<[AtomicU64; LEVELS]>);

/// As long, and claimed by nobody.
impl Clone for Claims {
    fn clone(&self) -> Self {
        Self(
            #[cfg(debug_assertions)]
            self.0.iter().map(|_| Default::default()).collect(),
        )
    }
}

impl Claims {
    /// Makes room for a list of that length.
    pub fn cover(&mut self, len: usize) {
        #[cfg(debug_assertions)]
        if self.0.len() < len {
            self.0.resize_with(len, Default::default);
        }
        #[cfg(not(debug_assertions))]
        let _ = len;
    }

    /// Takes an element in, to write or to read it.
    ///
    /// # Panics
    /// Where another claimant of the same division has it, and one of the two writes.
    #[cfg(debug_assertions)]
    pub fn claim(&self, index: usize, writes: bool) {
        for (tag, (division, claimant)) in self.0[index].iter().zip(CLAIMANTS.get()) {
            if division == 0 {
                continue;
            }
            let pack = |state: u32| u64::from(division) << 32 | u64::from(state);
            let mine = pack(claimant * 2 + u32::from(writes));
            let next = |seen: u64| match (seen >> 32 == u64::from(division), seen as u32) {
                (false, _) => Some(mine),
                (true, state) if state != READERS && state / 2 == claimant => Some(mine | seen),
                (true, state) if writes || state % 2 == 1 => None,
                (true, _) => Some(pack(READERS)),
            };
            let claimed = tag.fetch_update(Ordering::Relaxed, Ordering::Relaxed, next);
            assert!(claimed.is_ok(), "element {index} is claimed twice in one stage, by {claimant} and by {claimed:?}");
        }
    }
}

#[cfg(all(test, debug_assertions))]
mod tests {
    use super::super::{Shared, Stages, for_each_block};
    use super::{Claims, Division};

    /// What each of two claimants of a stage does with the only element: whether it writes.
    fn two_claimants(writes: [bool; 2]) {
        let (mut list, mut claims) = (vec![0_u32], Claims::default());
        let shared = Shared::new(&mut list, &mut claims);
        let division = Division::of_stages(2);
        for stage in 0..2 {
            let in_order = if stage == 0 { [0, 0] } else { [0, 1] };
            for claimant in in_order {
                // SAFETY: one thread, and no reference outlives its claimant.
                #[allow(unsafe_code)]
                division.stage(stage).work_as(claimant, || unsafe {
                    if writes[claimant] {
                        *shared.element(0) += 1;
                    } else {
                        shared.read(0);
                    }
                });
            }
        }
    }

    #[test]
    fn an_element_may_be_read_by_all_and_written_by_one() {
        two_claimants([false, false]);
    }

    #[test]
    #[should_panic(expected = "claimed twice")]
    fn two_that_write_are_found() {
        two_claimants([true, true]);
    }

    #[test]
    #[should_panic(expected = "claimed twice")]
    fn one_that_writes_what_was_read_is_found() {
        two_claimants([false, true]);
    }

    #[test]
    #[should_panic(expected = "claimed twice")]
    fn one_that_reads_what_was_written_is_found() {
        two_claimants([true, false]);
    }

    #[test]
    #[should_panic(expected = "claimed twice")]
    fn blocks_that_share_an_element_are_found_whatever_their_stages() {
        let (mut list, mut claims) = (vec![0_u32], Claims::default());
        let shared = Shared::new(&mut list, &mut claims);
        for_each_block(1, &mut [Stages::default(), Stages::default()], |stages| {
            let division = Division::of_stages(1);
            stages.walk(1, std::iter::once(1), |stage, chunk| {
                // SAFETY: one thread.
                #[allow(unsafe_code)]
                division.stage(stage).work_as(chunk, || unsafe { *shared.element(0) += 1 });
            });
        });
    }
}
