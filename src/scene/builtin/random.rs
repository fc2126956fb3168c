//! Where built-in scenes have their random numbers from.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// Random numbers that are the same on every machine and in every run.
pub fn seeded() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(2009)
}
