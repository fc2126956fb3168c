//! Threads of the pool that stay awake from one phase of a step to the next.
//!
//! To wake a thread takes some 60 µs, and a step of a thousand bodies has half a dozen phases of a tenth of a
//! millisecond: with a scope of the pool for each, the second thread came when the first was through. So a helper that
//! has come looks out for the next work for [`PATIENCE`] before it goes back to the pool.
//!
//! Each thread that asks for help has a crew of its own. A piece of work is *open* while there are places left. A helper
//! takes a place and is *inside* until it comes back; who asked for help does its share, takes the places that are left
//! away, and waits for those inside. So nobody waits for a helper that comes late or never.
//!
//! Places, how many are inside, and the number of the piece of work are one atomic word: who takes a place of one piece
//! cannot get into the next. The work itself is written before places are given out (release) and read by those who took one
//! (acquire); it is not written again before the last has left (release, acquire). The thread sanitizer finds nothing in
//! this module, and the race where one of these is relaxed.
#![allow(unsafe_code)]

use std::cell::{Cell, UnsafeCell};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use bevy::tasks::TaskPool;

use super::spin::wait_a_little;

/// How long a helper looks out for work: longer than the phases of a step that one thread does alone, and a small part of
/// a frame.
const PATIENCE: Duration = Duration::from_micros(300);
/// Looks between two readings of the clock.
const LOOKS: u32 = 64;

/// One who is inside.
const INSIDE: u64 = 1;
/// One place.
const PLACE: u64 = 1 << 16;
/// One piece of work.
const NUMBER: u64 = 1 << 32;

type Work<'a> = dyn Fn(usize) + Sync + 'a;

/// Those who help one thread.
struct Crew {
    /// The number of the piece of work, places left, how many are inside.
    state: AtomicU64,
    work: UnsafeCell<Option<&'static Work<'static>>>,
    /// Helpers that are here, or called and not yet here.
    helpers: AtomicUsize,
}

// SAFETY: `work` is written by the thread that the crew helps while nobody is inside and no place is left, and read by
// those inside alone, see the module's documentation; what it refers to is `Sync`.
unsafe impl Sync for Crew {}
// SAFETY: as above.
unsafe impl Send for Crew {}

thread_local! {
    static CREW: Arc<Crew> = Arc::new(Crew {
        state: AtomicU64::new(0),
        work: UnsafeCell::new(None),
        helpers: AtomicUsize::new(0),
    });
    static IS_HELPED: Cell<bool> = const { Cell::new(false) };
}

/// Calls `work` with 0 on this thread and with other numbers below `workers` on threads of the pool that come before it
/// is through; comes back when all have. `work` must not panic, and must not ask for help: then it gets none.
pub(super) fn help(pool: &TaskPool, workers: usize, work: &Work) {
    if IS_HELPED.replace(true) {
        work(0);
        return;
    }
    CREW.with(|crew| crew.work_on(pool, workers, work));
    IS_HELPED.set(false);
}

fn places(state: u64) -> usize {
    (state / PLACE % (NUMBER / PLACE)) as usize
}

fn inside(state: u64) -> u64 {
    state % PLACE
}

fn number(state: u64) -> u64 {
    state / NUMBER
}

/// Takes the places that are left away and waits for those inside.
struct Open<'a>(&'a Crew);

impl Drop for Open<'_> {
    fn drop(&mut self) {
        let Self(crew) = self;
        crew.state.fetch_and(!(NUMBER - PLACE), Ordering::Relaxed);
        let mut looks = 0;
        while inside(crew.state.load(Ordering::Acquire)) > 0 {
            wait_a_little(&mut looks);
        }
    }
}

impl Crew {
    fn work_on(self: &Arc<Self>, pool: &TaskPool, workers: usize, work: &Work) {
        let wanted = (workers - 1).min((NUMBER / PLACE - 1) as usize);
        for _ in self.helpers.load(Ordering::Relaxed)..wanted {
            self.helpers.fetch_add(1, Ordering::Relaxed);
            let crew = Arc::clone(self);
            pool.spawn(async move { crew.look_out() }).detach();
        }
        // SAFETY: `open` is dropped before this function is left, also by a panic; from then on nobody inside has the
        // work, and nobody can get in.
        let forever = unsafe { std::mem::transmute::<&Work<'_>, &'static Work<'static>>(work) };
        // SAFETY: no place is left and nobody is inside, as the last `Open` has seen to.
        unsafe { *self.work.get() = Some(forever) };
        let next = number(self.state.load(Ordering::Relaxed)).wrapping_add(1);
        self.state.store(next * NUMBER + wanted as u64 * PLACE, Ordering::Release);
        let open = Open(self);
        work(0);
        drop(open);
    }

    /// A helper's stay.
    fn look_out(&self) {
        let (mut done, mut looks, mut since) = (None, 0, Instant::now());
        loop {
            let state = self.state.load(Ordering::Relaxed);
            if places(state) > 0 && done != Some(number(state)) {
                let taken = state - PLACE + INSIDE;
                if self.state.compare_exchange(state, taken, Ordering::Acquire, Ordering::Relaxed).is_ok() {
                    // SAFETY: it is not written while somebody is inside.
                    if let Some(work) = unsafe { *self.work.get() } {
                        work(places(state));
                    }
                    self.state.fetch_sub(INSIDE, Ordering::Release);
                    (done, looks, since) = (Some(number(state)), 0, Instant::now());
                }
                continue;
            }
            wait_a_little(&mut looks);
            if looks.is_multiple_of(LOOKS) && since.elapsed() > PATIENCE {
                break;
            }
        }
        self.helpers.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    use bevy::tasks::{TaskPool, TaskPoolBuilder};

    use super::help;

    fn pool(threads: usize) -> TaskPool {
        TaskPoolBuilder::new().num_threads(threads).build()
    }

    /// On what each caller has on its stack: it is right only if nobody is late or comes twice. On a busy machine the
    /// rounds may be over before a helper has woken, so they go on until one has come.
    #[test]
    fn all_that_came_are_done_when_the_work_is() {
        let (pool, helped, since) = (pool(3), AtomicU32::new(0), Instant::now());
        let is_enough = |round: usize| {
            round >= 20_000 && (helped.load(Ordering::Relaxed) > 0 || since.elapsed() > Duration::from_secs(60))
        };
        std::thread::scope(|scope| {
            for seed in 0..3 {
                let (pool, helped, is_enough) = (&pool, &helped, &is_enough);
                scope.spawn(move || {
                    for round in (0..).take_while(|&round| !is_enough(round)) {
                        let workers = 1 + (round + seed) % 4;
                        let came: [AtomicU32; 4] = Default::default();
                        let left = AtomicU64::new(50);
                        help(pool, workers, &|worker| {
                            came[worker].fetch_add(1, Ordering::Relaxed);
                            while left
                                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1))
                                .is_ok()
                            {}
                        });
                        let came = came.map(AtomicU32::into_inner);
                        assert_eq!(left.into_inner(), 0);
                        assert_eq!(came[0], 1, "the caller");
                        assert!(came[1..workers].iter().all(|&times| times <= 1), "{came:?}");
                        assert!(came[workers..].iter().all(|&times| times == 0), "{came:?} for {workers}");
                        helped.fetch_add(came[1..].iter().sum(), Ordering::Relaxed);
                    }
                });
            }
        });
        assert!(helped.into_inner() > 0, "nobody ever came");
    }

    #[test]
    fn work_within_work_gets_no_help_and_is_done() {
        let pool = pool(1);
        let (outer, inner) = (AtomicU32::new(0), AtomicU32::new(0));
        help(&pool, 2, &|worker| {
            outer.fetch_add(1, Ordering::Relaxed);
            if worker == 0 {
                help(&pool, 2, &|worker| {
                    inner.fetch_add(1 + worker as u32, Ordering::Relaxed);
                });
            }
        });
        assert!((1..=2).contains(&outer.into_inner()));
        assert_eq!(inner.into_inner(), 1);
    }

    /// The only thread of the pool has come to help, and does what else the pool is given.
    #[test]
    fn helpers_go_back_to_the_pool() {
        let pool = pool(1);
        let (came, has_come) = channel();
        let has_come = Mutex::new(has_come);
        help(&pool, 2, &|worker| match worker {
            0 => has_come.lock().unwrap().recv_timeout(Duration::from_secs(20)).expect("a helper comes"),
            _ => came.send(()).unwrap(),
        });
        let (done, is_done) = channel();
        pool.spawn(async move { done.send(()).unwrap() }).detach();
        is_done.recv_timeout(Duration::from_secs(20)).expect("the pool has its thread back");
    }
}
