//! Anderson's mixing (1965; Walker and Ni 2011), of depth 1: a fixed point x = x + f(x) by secants.
//!
//! x⁺ = x + f − θ (Δx + Δf), θ = f·Δf/|Δf|², Δ to the iteration before. Where one mode is left, f falls by a factor r from
//! iteration to iteration, θ = −r/(1 − r), and x⁺ = x + f/(1 − r) is where it leads, even where |r| > 1.

use super::super::constants::MOST_MIXED;

/// The iteration before.
#[derive(Clone, Debug, Default)]
pub(super) struct Mixing {
    guess: Vec<f64>,
    error: Vec<f64>,
}

impl Mixing {
    /// Begins anew.
    pub fn forget(&mut self) {
        self.error.clear();
    }

    /// Takes x with its f to the next guess. θ is of those that `counts` names.
    pub fn mix<'x>(&mut self, x: impl Iterator<Item = &'x mut f64>, f: &[f64], counts: &[bool]) {
        let known = self.error.len() == f.len();
        let share = if known { self.share(f, counts) } else { 0.0 };
        if !known {
            self.error.clear();
            self.error.extend_from_slice(f);
            self.guess.clear();
            self.guess.resize(f.len(), 0.0);
        }
        for (((x, f), guess), error) in x.zip(f).zip(&mut self.guess).zip(&mut self.error) {
            let next = *x + f - share * ((*x - *guess) + (f - *error));
            (*guess, *error) = (*x, *f);
            *x = next;
        }
    }

    /// θ.
    fn share(&self, f: &[f64], counts: &[bool]) -> f64 {
        let (mut along, mut square) = (0.0, 0.0);
        for ((f, error), _) in f.iter().zip(&self.error).zip(counts).filter(|(_, counts)| **counts) {
            let change = f - error;
            along += f * change;
            square += change * change;
        }
        if square > 0.0 { (along / square).clamp(-MOST_MIXED, MOST_MIXED) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = (r − 1) x.
    #[test]
    fn one_mode_is_found_in_two_iterations_whether_it_contracts_or_not() {
        for r in [0.32, -0.6, 0.7, -1.5] {
            let (mut mixing, mut x) = (Mixing::default(), [1.0, -2.0]);
            for _ in 0..2 {
                let f = x.map(|x| (r - 1.0) * x);
                mixing.mix(x.iter_mut(), &f, &[true; 2]);
            }
            assert!(x.iter().all(|x| x.abs() < 1e-14), "{r}: {x:?}");
        }
    }
}
