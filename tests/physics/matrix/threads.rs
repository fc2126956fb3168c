//! The number of threads does not change a bit.

use bevy::tasks::ComputeTaskPool;
use plumb::prelude::*;

use super::ENGINES;
use crate::determinism::heap;
use crate::rig::*;

/// Expected of all methods alike: the same bits.
#[test]
fn threads_do_not_change_a_bit() {
    for engine in ENGINES {
        for precision in [Precision::F32, Precision::F64] {
            let hashes: Vec<Vec<u64>> = [1, 2, 4, 1]
                .into_iter()
                .map(|threads| {
                    let mut world = heap(SolverSettings { threads, precision, ..engine.settings() });
                    (0..3)
                        .map(|_| {
                            steps(&mut world, 12);
                            state_hash(&world)
                        })
                        .collect()
                })
                .collect();
            assert!(ComputeTaskPool::get().thread_num() >= 4, "the pool has too few threads to prove it");
            assert!(hashes.iter().all(|of_run| *of_run == hashes[0]), "{engine:?} {precision:?}: {hashes:?}");
            let of_run = &hashes[0];
            assert!(of_run[0] != of_run[1] && of_run[1] != of_run[2], "{engine:?}: the hash sees no motion");
        }
    }
}
