//! How far a shape goes before it can touch another, in a few cheap steps: what passes by is mostly told at once.
//!
//! With w(n) the vector from the foremost point of the mover along n to that of the other along −n, n·w(n) is at most their
//! distance, and along d the way is clear for n·w/(n·d), for ever where n·d ≤ 0. From some direction on, v goes to the nearest
//! point to the origin of the segment from v to w(v/|v|) (Gilbert 1966): |v| is never less than the distance. While the
//! mover goes on, all of these vectors go along (van den Bergen 2004).

use nalgebra::Vector3;

use super::solid::Solid;

/// A share of the sizes that is more than rounding.
const SLACK: f64 = 1e-9;

/// Distance, as a share of the way there, from which on the exact look is better.
const CLOSE: f64 = 0.02;

/// What is known before an exact look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clear {
    /// How far the way is clear, m.
    pub distance: f64,
    /// How far apart the shapes are there at most, m.
    pub within: f64,
}

/// How far a mover on its way along a unit direction certainly touches nothing of the other; none: not within `most`. Takes up
/// to so many steps.
pub(super) fn clear_way(
    mover: &Solid,
    other: &Solid,
    direction: &Vector3<f64>,
    most: f64,
    most_steps: u32,
) -> Option<Clear> {
    let mut clear = Clear { distance: 0.0, within: f64::INFINITY };
    let between = other.position - mover.position;
    let size = mover.radius + other.radius;
    let slack = SLACK * (size + between.norm());
    // Before the balls about the two meet they do not.
    let along = between.dot(direction);
    let half_squared = (size + slack).powi(2) - (between - direction * along).norm_squared();
    if half_squared < 0.0 || along + half_squared.sqrt() < 0.0 || along - half_squared.sqrt() > most {
        return None;
    }
    clear.distance = (along - half_squared.sqrt()).max(0.0);
    let Some(mut normal) = (between - direction * clear.distance).try_normalize(slack) else { return Some(clear) };
    let look = |normal: &Vector3<f64>, distance: f64| {
        let ((from, around), (to, around_other)) = (mover.farthest(normal)?, other.farthest(&-normal)?);
        Some((to - from - direction * distance, around + around_other))
    };
    let mut nearest: Option<Vector3<f64>> = None;
    for _ in 0..most_steps {
        let Some((mut next, around)) = look(&normal, clear.distance) else { return Some(clear) };
        let gap = normal.dot(&next) - around - slack;
        if gap > 0.0 {
            let approach = normal.dot(direction);
            if approach <= 0.0 {
                return None;
            }
            let step = gap / approach;
            clear.distance += step;
            if clear.distance > most {
                return None;
            }
            next -= direction * step;
            nearest = nearest.map(|nearest| nearest - direction * step);
        }
        let toward = match nearest {
            None => next,
            Some(from) => {
                let way = next - from;
                let share = -from.dot(&way) / way.norm_squared();
                if share.is_nan() { from } else { from + way * share.clamp(0.0, 1.0) }
            }
        };
        nearest = Some(toward);
        let length = toward.norm();
        clear.within = (length - around).max(0.0) + slack;
        if length <= around + CLOSE * size {
            break;
        }
        normal = toward / length;
    }
    Some(clear)
}
