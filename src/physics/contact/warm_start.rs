//! What contact points take over from one step to the next: the point of the same features carried it before
//! ([`namesake`], [`predecessors`]).
//!
//! Slots have them: impulses of contacts that last, and of others forces, not multipliers, in world axes: they are
//! projected on whatever rows the point has next, so that friction directions may turn. Within a step, points carry
//! their forces from substep to substep.
//!
//! Joints start from zero. Their Baumgarte bias is part of the multiplier, and a bias carried over
//! before the sweeps have converged winds up: warm started, `joint_grid` gained 80 times its
//! energy in two seconds and `chain 100` a third, where from zero both lose a little. Contacts
//! cannot pull, which bounds it.

use crate::physics::collision::FeatureId;

/// Share of a kept force that a row starts from. All of it makes columns tremble (`stack 10` at
/// 0.5 m/s, at 0.002 with this share), none of it makes them creep: what few sweeps put wrong,
/// friction above all, must die away.
pub(crate) const KEPT_SHARE: f64 = 0.8;

/// The index of the point that the same features made.
pub(crate) fn namesake(known: impl IntoIterator<Item = FeatureId>, feature: FeatureId) -> Option<usize> {
    known.into_iter().position(|known| known == feature)
}

/// Of which known point each new one takes over, each known one once. Where edges lie on edges, rounding decides which
/// features a corner is named after: what has no namesake takes over from the nearest point left, of those at less than
/// `reach` by `distance_squared` (of a new and a known point, by index; m²).
pub(crate) fn predecessors<const N: usize>(
    known: &[FeatureId],
    new: impl ExactSizeIterator<Item = FeatureId>,
    distance_squared: impl Fn(usize, usize) -> f64,
    reach: f64,
) -> [Option<usize>; N] {
    let (mut is_free, mut from, count) = ([false; N], [None; N], new.len());
    is_free[..known.len()].fill(true);
    for (from, feature) in from.iter_mut().zip(new) {
        *from = (0..known.len()).find(|&at| is_free[at] && known[at] == feature);
        if let Some(at) = *from {
            is_free[at] = false;
        }
    }
    for (index, from) in from.iter_mut().enumerate().take(count).filter(|(_, from)| from.is_none()) {
        *from = (0..known.len())
            .filter(|&at| is_free[at])
            .min_by(|&one, &other| distance_squared(index, one).total_cmp(&distance_squared(index, other)))
            .filter(|&at| distance_squared(index, at) < reach.powi(2));
        if let Some(at) = *from {
            is_free[at] = false;
        }
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_namesake_takes_over_from_the_nearest_left_within_reach() {
        let (known, new) = ([10, 11, 12].map(FeatureId), [12, 13, 14].map(FeatureId));
        let places = [[0.0, 1.0, 2.0], [2.0, 1.9, 5.0]];
        let apart = |new: usize, known: usize| f64::powi(places[1][new] - places[0][known], 2);
        // The second is nearest to the known point that the first has taken, and next to the one before that.
        assert_eq!(predecessors::<4>(&known, new.into_iter(), apart, 1.0), [Some(2), Some(1), None, None]);
    }
}
