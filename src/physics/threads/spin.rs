//! Waiting for another thread that is about to be through.

/// Looks after which a thread lets others have its core in between: the operating system may have more threads than cores.
const EAGER_LOOKS: u32 = 2000;

/// Between two looks, which are counted.
pub(super) fn wait_a_little(looks: &mut u32) {
    *looks = looks.wrapping_add(1);
    if *looks < EAGER_LOOKS {
        std::hint::spin_loop();
    } else {
        std::thread::yield_now();
    }
}
