//! Groups in which nothing moves any more.
//!
//! A body at rest trembles by what solves leave, [`TOLERANCE`], and a step that finds this out takes as long as any other.
//! Where all bodies have stayed within [`REST_WAY`] of where they were for [`REST_TIME`], the state is a fixed point of the
//! step to that precision, and from then on exactly: velocities become zero, and each step is the last one again, forces and
//! all, until something that it depends on differs in any bit.
//!
//! A balance that is not stable is told from rest by its growth. What leaves it at a rate σ from a distance δ moves by
//! δ (e^{σT} − 1) within T: a rod of 1 m that stands on its tip, with σ² = 3g/2L, falls if its tip is more than 2e-12 m beside
//! its centre of mass.

use super::super::constants::{REST_TIME, REST_WAY, TOLERANCE};
use super::super::mechanism::MemberState;

/// For how long the bodies of a group have stayed where they are.
#[derive(Clone, Debug, Default)]
pub(super) struct Rest {
    /// The states of those that move when they were seen to come to where they are.
    since: Vec<MemberState>,
    /// How long ago that was, s.
    pub time: f64,
    /// What the step depended on that found them at rest, if they are.
    terms: Option<[f64; 4]>,
}

impl Rest {
    /// Forgets what it has seen.
    pub fn end(&mut self) {
        self.since.clear();
        (self.time, self.terms) = (0.0, None);
    }

    /// Whether the bodies rest.
    pub fn is_on(&self) -> bool {
        self.terms.is_some()
    }

    /// Whether they rest in a step that depends on that, too; if not, they rest no more.
    pub fn goes_on(&mut self, terms: &[f64; 4]) -> bool {
        let goes_on = self.terms.as_ref() == Some(terms);
        if self.is_on() && !goes_on {
            self.end();
        }
        goes_on
    }

    /// Takes in a step of that length, s, that depended on `terms`, which bodies of these radii, m, went through to `states`.
    /// Where they have come to rest, their velocities are zero from here on.
    pub fn watch(&mut self, states: &mut [MemberState], radii: impl Fn(usize) -> f64, step: f64, terms: [f64; 4]) {
        let stayed = |(index, (now, then)): (usize, (&MemberState, &MemberState))| {
            let way = (now.position - then.position).norm();
            let turn = now.rotation.angle_to(&then.rotation);
            way + turn * radii(index) <= REST_WAY
        };
        let stay = self.since.len() == states.len() && states.iter().zip(&self.since).enumerate().all(stayed);
        if !stay {
            self.end();
            self.since.extend_from_slice(states);
            return;
        }
        self.time += step;
        let speed = |(index, state): (usize, &MemberState)| state.linear.norm() + state.angular.norm() * radii(index);
        let fastest = states.iter().enumerate().map(speed).fold(0.0, f64::max);
        if self.time >= REST_TIME && fastest <= TOLERANCE {
            for state in states {
                (state.linear, state.angular) = (Default::default(), Default::default());
            }
            self.terms = Some(terms);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    const STEP: f64 = 1.0 / 60.0;
    const TERMS: [f64; 4] = [STEP, 1.0, 1.0, 1.0];

    /// Watches a body whose place and speed are those functions of time, for a second. When it came to rest, s.
    fn rests_at(place: impl Fn(f64) -> f64, speed: impl Fn(f64) -> f64) -> Option<f64> {
        let mut rest = Rest::default();
        (0..60).map(|step| f64::from(step) * STEP).find(|&time| {
            let (position, linear) = (Vector3::y() * place(time), Vector3::y() * speed(time));
            let mut states = [MemberState { position, linear, ..MemberState::REST }];
            rest.watch(&mut states, |_| 0.5, STEP, TERMS);
            assert!(states[0].is_still() || !rest.is_on());
            rest.is_on()
        })
    }

    #[test]
    fn what_trembles_comes_to_rest_and_what_leaves_does_not() {
        let trembling = |time: f64| 1e-12 * (200.0 * time).sin();
        let at = rests_at(trembling, |_| 5e-11).expect("rest");
        assert!((at - REST_TIME).abs() < 1.5 * STEP, "{at} s");
        assert_eq!(rests_at(trembling, |_| 2e-10), None, "faster than what solves leave");
        assert_eq!(rests_at(|time| 5e-11 * time, |_| 5e-11), None, "creeps");
        // A rod of 1 m on its tip.
        let grows = |start: f64| move |time: f64| start * (3.8 * time).cosh();
        assert_eq!(rests_at(grows(1e-11), |_| 1e-11), None, "falls");
    }

    #[test]
    fn rest_ends_with_the_terms_of_the_step() {
        let mut rest = Rest::default();
        for _ in 0..60 {
            rest.watch(&mut [MemberState::REST], |_| 0.5, STEP, TERMS);
        }
        assert!(rest.goes_on(&TERMS) && rest.is_on());
        assert!(!rest.goes_on(&[0.5 * STEP, 2.0, 1.0, 1.0]) && !rest.is_on());
    }
}
