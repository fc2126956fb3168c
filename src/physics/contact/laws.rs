//! What two surfaces do to each other: Coulomb's friction and Newton's restitution, for every method.

use nalgebra::SimdRealField;

use crate::physics::body::{Body, SurfaceMaterial};
use crate::physics::settings::{FrictionModel, SolverSettings};

/// μ and e of a pair: none of the friction where it is switched off.
pub(crate) fn surface(a: &Body, b: &Body, friction: FrictionModel) -> SurfaceMaterial {
    let pair = a.material.pair(b.material);
    if friction == FrictionModel::Off { SurfaceMaterial { friction: 0.0, ..pair } } else { pair }
}

/// Whether a pair has any restitution.
pub(crate) fn may_bounce(a: &Body, b: &Body) -> bool {
    a.material.pair(b.material).restitution > 0.0
}

/// The approach above which contacts bounce, m/s; infinite where none does.
pub(crate) fn restitution_threshold(settings: &SolverSettings) -> f64 {
    settings.restitution_speed.unwrap_or(f64::INFINITY)
}

/// Newton's law at one point: the speed at which it is to part after it came at `approach`, m/s; zero where that is not
/// above the threshold. It is a lower bound of what other laws ask of the point, not an addition to it.
pub(crate) fn rebound<N: SimdRealField + Copy>(restitution: N, approach: N, threshold: N) -> N {
    (restitution * approach).select(approach.simd_gt(threshold), N::zero())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_fast_parts_at_its_share_and_what_comes_slowly_does_not() {
        assert_eq!(rebound(0.5, 2.0, 0.5), 1.0);
        assert_eq!(rebound(0.5, 0.5, 0.5), 0.0);
        assert_eq!(rebound(1.0, -2.0, 0.0), 0.0);
        assert_eq!(rebound(0.5, 2.0, f64::INFINITY), 0.0);
    }
}
