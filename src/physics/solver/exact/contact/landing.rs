//! The time at which the first of what is left free lands within a smooth step.
//!
//! The overlap of a free pair, or of a free limit, at the end of a smooth step is a function of its length that is smooth but
//! where features change, and so is its rate. Between the longest step known to be free of landings and the shortest with
//! some, the cubic with the overlaps and rates at both ends (Hermite) says when each lands; the first of those times is tried
//! next. Where that does not come nearer, as where the motion itself jumps at a landing, the step between is tried.

use super::super::constants::{LANDED, NO_TIME};
use super::super::mechanism::MemberState;
use super::gap_points::GapPoints;
use super::limit_rows::LimitRows;

/// What may land.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lander {
    /// By its index.
    Pair(usize),
    /// By its row.
    Limit(usize),
}

/// How it stands at the end of a smooth step.
#[derive(Clone, Copy, Debug)]
struct Standing {
    lander: Lander,
    /// m or rad; negative: a gap.
    overlap: f64,
    /// How fast that grows, m/s or rad/s.
    closing: f64,
}

/// All that is known of at the end of a smooth step.
#[derive(Clone, Default)]
pub(super) struct Standings {
    list: Vec<Standing>,
}

/// The bracket that a landing lies in, with what stands how at its ends.
#[derive(Clone, Default)]
pub(super) struct LandingSearch {
    low: f64,
    high: f64,
    /// Of the step of length `low`; at first, of the start.
    pub at_low: Standings,
    at_high: Standings,
    /// Width of the bracket before the last trial, if that went by a cubic.
    guessed: Option<f64>,
    /// Trials in the middle that are to follow guesses which did not halve the bracket: each time twice as many, and how many
    /// are left.
    halvings: [u32; 2],
}

/// Overlap that is aimed at, m: within [`LANDED`] on both sides.
const AIM: f64 = 0.5 * LANDED;
/// Places between the ends where the cubic is looked at for its last sign change.
const LOOKS: u32 = 16;
/// Halvings of a range of a cubic: to the last bit.
const HALVINGS: u32 = 60;

impl Standings {
    /// Of what is left free at some states: the deepest point of each pair, of those `now`, and limits. Overlaps of pairs
    /// `before`, beyond [`LANDED`], are none: what overlapped at the start opens, or has just bounced.
    pub fn find(
        &mut self,
        [before, now]: [&GapPoints; 2],
        states: &[MemberState],
        free: &[bool],
        limits: &LimitRows,
        free_rows: &[bool],
    ) {
        self.list.clear();
        for pair in (0..free.len()).filter(|pair| free[*pair]) {
            let deepest = now.of(pair).iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
            let Some(point) = deepest else { continue };
            let at_start = before.of(pair).iter().map(|point| -point.gap);
            let at_start = at_start.filter(|overlap| *overlap > LANDED).fold(0.0, f64::max);
            let (lander, overlap) = (Lander::Pair(pair), -point.gap - at_start);
            self.list.push(Standing { lander, overlap, closing: -point.opening(states) });
        }
        for limit in limits.list.iter().filter(|limit| free_rows[limit.row]) {
            let (lander, overlap) = (Lander::Limit(limit.row), -limit.gap);
            self.list.push(Standing { lander, overlap, closing: -limit.opening });
        }
    }

    /// The deepest overlap, m or rad; negative: the least gap of those known.
    pub fn deepest(&self) -> f64 {
        self.list.iter().map(|standing| standing.overlap).fold(f64::NEG_INFINITY, f64::max)
    }

    fn of(&self, lander: Lander) -> Option<&Standing> {
        self.list.iter().find(|standing| standing.lander == lander)
    }
}

impl LandingSearch {
    /// Between a step of no length, for which [`Self::at_low`] is to be found, and one of `high`, s.
    pub fn begin(&mut self, high: f64, at_high: &Standings) {
        (self.low, self.high, self.guessed, self.halvings) = (0.0, high, None, [1, 0]);
        self.at_high.list.clone_from(&at_high.list);
    }

    /// The longest step, s, known to be free of landings, and the shortest known with one.
    pub fn bracket(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// The length to try next, s; none where the ends are as near to each other as a share [`NO_TIME`] of a substep of that
    /// length, s, or as rounding lets them be.
    pub fn next(&mut self, substep: f64) -> Option<f64> {
        let width = self.high - self.low;
        let middle = self.low + 0.5 * width;
        if width <= NO_TIME * substep || middle <= self.low || middle >= self.high {
            return None;
        }
        if self.guessed.take().is_some_and(|before| width > 0.5 * before) {
            self.halvings = [2 * self.halvings[0], self.halvings[0]];
        }
        if self.halvings[1] > 0 {
            self.halvings[1] -= 1;
            return Some(middle);
        }
        let landed = self.at_high.list.iter().filter(|standing| standing.overlap > AIM);
        let first = landed.filter_map(|end| self.time_before_end(end)).fold(0.0, f64::max);
        let guess = self.high - first;
        if self.low < guess && guess < self.high {
            self.guessed = Some(width);
            return Some(guess);
        }
        Some(middle)
    }

    /// Takes in how all stood after a step of that length, s.
    pub fn note(&mut self, h: f64, standings: &Standings) {
        let (end, at_end) = if standings.deepest() > AIM {
            (&mut self.high, &mut self.at_high)
        } else {
            (&mut self.low, &mut self.at_low)
        };
        *end = h;
        at_end.list.clone_from(&standings.list);
    }

    /// How long before the upper end of the bracket that lands, s.
    fn time_before_end(&self, end: &Standing) -> Option<f64> {
        let width = self.high - self.low;
        let Some(start) = self.at_low.of(end.lander) else {
            // Out of reach there.
            return Some((end.overlap - AIM) / end.closing).filter(|time| 0.0 < *time && *time < width);
        };
        let (from, to) = (start.overlap - AIM, end.overlap - AIM);
        let rates = [start.closing * width, end.closing * width];
        // Over shares of the bracket, from its upper end.
        let value = |share: f64| hermite(share, [to, from], [-rates[1], -rates[0]]);
        let looks = (1..=LOOKS).map(|look| f64::from(look) / f64::from(LOOKS));
        let (mut open, mut landed) = (looks.into_iter().find(|share| value(*share) < 0.0)?, 0.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (open + landed);
            *(if value(middle) < 0.0 { &mut open } else { &mut landed }) = middle;
        }
        Some(landed * width)
    }
}

/// The cubic with those values and slopes at 0 and 1.
fn hermite(at: f64, [from, to]: [f64; 2], [from_slope, to_slope]: [f64; 2]) -> f64 {
    let rise = to - from;
    let square = 3.0 * rise - 2.0 * from_slope - to_slope;
    let cube = from_slope + to_slope - 2.0 * rise;
    from + at * (from_slope + at * (square + at * cube))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of each lander the overlap and its rate at a time.
    type Motion = fn(f64) -> (f64, f64);

    fn standings(motions: &[Motion], time: f64) -> Standings {
        let of = |(pair, motion): (usize, &Motion)| {
            let (overlap, closing) = motion(time);
            Standing { lander: Lander::Pair(pair), overlap, closing }
        };
        Standings { list: motions.iter().enumerate().map(of).collect() }
    }

    /// The time that is found between 0 and one second, and in how many trials; what is known at the start is `at_low`.
    fn search(motions: &[Motion], at_low: Standings) -> (f64, u32) {
        let mut search = LandingSearch::default();
        search.begin(1.0, &standings(motions, 1.0));
        search.at_low = at_low;
        let mut trials = 0;
        while let Some(h) = search.next(1.0) {
            trials += 1;
            let found = standings(motions, h);
            if (0.0..=LANDED).contains(&found.deepest()) {
                return (h, trials);
            }
            search.note(h, &found);
        }
        (search.bracket().1, trials)
    }

    /// A bounce at the start, and the next one after 0.6 s: a parabola, which a cubic is.
    #[test]
    fn the_end_of_a_hop_is_found_at_once() {
        let hop: Motion = |time| (5.0 * time * (time - 0.6), 10.0 * time - 3.0);
        let (time, trials) = search(&[hop], standings(&[hop], 0.0));
        assert!((time - 0.6).abs() < 1e-11 && trials == 1, "{time} s, {trials} trials");
    }

    /// Of two that overlap at the end the one that did so first, which is the less deep.
    #[test]
    fn the_first_of_those_that_land_is_found() {
        let motions: [Motion; 2] =
            [|time| (20.0 * (time - 0.7), 20.0), |time| ((0.8 * time).sin() - 0.2, 0.8 * (0.8 * time).cos())];
        let (time, trials) = search(&motions, standings(&motions, 0.0));
        assert!((time - 0.2_f64.asin() / 0.8).abs() < 1e-10, "{time} s");
        assert!(trials <= 5, "{trials} trials");
    }

    /// Out of reach at the start, so that nothing is known but the end of its way.
    #[test]
    fn what_comes_from_afar_is_followed_back_from_where_it_is_found() {
        let fall: Motion = |time| (5.0 * time * time - 2.0, 10.0 * time);
        let (time, trials) = search(&[fall], Standings::default());
        assert!((time - 0.4_f64.sqrt()).abs() < 1e-11 && trials <= 6, "{time} s, {trials} trials");
    }

    /// No step ends within the overlap that is allowed.
    #[test]
    fn a_jump_is_closed_in_by_halves() {
        let jump: Motion = |time| if time < 0.3 { (-1.0 + time, 1.0) } else { (0.006, 1.0) };
        let (time, trials) = search(&[jump], standings(&[jump], 0.0));
        assert!((0.3..0.3 + 2e-12).contains(&time) && trials < 60, "{time} s, {trials} trials");
    }
}
