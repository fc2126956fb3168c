//! Jacobi's elliptic functions and the complete integral K, from the arithmetic–geometric mean
//! (Abramowitz and Stegun 1964, 16.4 and 17.6).
//!
//! The modulus is given by its complement k′ = √(1 − k²), 0 < k′ ≤ 1: near k = 1, where periods
//! grow like ln(4/k′), k itself no longer tells one modulus from another.

use std::f64::consts::FRAC_PI_2;

/// sn, cn and dn at one argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jacobi {
    pub sn: f64,
    pub cn: f64,
    pub dn: f64,
}

/// A mean settles to the last bit in 5 halvings for moderate k′, in 8 for k′ = 1e-15.
const MOST_STEPS: usize = 12;

/// One step of the descending Landen transformation: a and c/a of the mean.
struct Landen {
    a: [f64; MOST_STEPS],
    ratio: [f64; MOST_STEPS],
    last: usize,
}

impl Landen {
    fn new(complement: f64) -> Self {
        debug_assert!(0.0 < complement && complement <= 1.0, "k' = {complement}");
        let mut landen = Self { a: [1.0; MOST_STEPS], ratio: [0.0; MOST_STEPS], last: 0 };
        let (mut a, mut b) = (1.0, complement);
        for step in 1..MOST_STEPS {
            let half_difference = 0.5 * (a - b);
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
            landen.a[step] = a;
            landen.ratio[step] = half_difference / a;
            landen.last = step;
            if half_difference.abs() <= f64::EPSILON * a {
                break;
            }
        }
        landen
    }

    fn mean(&self) -> f64 {
        self.a[self.last]
    }
}

/// K, the quarter period of sn and cn.
pub(super) fn quarter_period(complement: f64) -> f64 {
    FRAC_PI_2 / Landen::new(complement).mean()
}

/// sn, cn and dn at `u`.
pub(super) fn jacobi(u: f64, complement: f64) -> Jacobi {
    let landen = Landen::new(complement);
    let mut phi = landen.mean() * u * (1_u64 << landen.last) as f64;
    for step in (1..=landen.last).rev() {
        phi = 0.5 * (phi + (landen.ratio[step] * phi.sin()).asin());
    }
    let (sn, cn) = phi.sin_cos();
    // dn² = 1 − k² sn² without the cancellation near sn = 1.
    let dn = (complement * complement * sn * sn + cn * cn).sqrt();
    Jacobi { sn, cn, dn }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPLEMENTS: [f64; 6] = [1.0, 0.9, std::f64::consts::FRAC_1_SQRT_2, 0.3, 1e-2, 1e-4];

    /// ∫₀^φ dθ/√(1 − k² sin²θ) by Simpson's rule; 1 − k² sin²θ as k′² sin²θ + cos²θ.
    fn incomplete_integral(phi: f64, complement: f64) -> f64 {
        let integrand = |theta: f64| (complement * theta.sin()).hypot(theta.cos()).recip();
        let parts = 2_000_000;
        let width = phi / f64::from(parts);
        let inner: f64 = (1..parts).map(|i| if i % 2 == 0 { 2.0 } else { 4.0 } * integrand(f64::from(i) * width)).sum();
        (integrand(0.0) + inner + integrand(phi)) * width / 3.0
    }

    #[test]
    fn quarter_period_matches_quadrature_and_known_values() {
        for complement in COMPLEMENTS {
            let expected = incomplete_integral(FRAC_PI_2, complement);
            let relative = quarter_period(complement) / expected - 1.0;
            assert!(relative.abs() < 1e-11, "k' = {complement}: {relative:e}");
        }
        assert_eq!(quarter_period(1.0), FRAC_PI_2);
        // Γ(1/4)²/(4√π)
        let lemniscatic = 1.854_074_677_301_371_9;
        assert!((quarter_period(std::f64::consts::FRAC_1_SQRT_2) - lemniscatic).abs() < 1e-15 * 4.0);
    }

    #[test]
    fn functions_invert_the_integral() {
        for complement in COMPLEMENTS {
            for phi in [0.1, 0.7, 1.3, 1.55] {
                let u = incomplete_integral(phi, complement);
                let Jacobi { sn, cn, dn } = jacobi(u, complement);
                let expected_dn = (complement * phi.sin()).hypot(phi.cos());
                // Quadrature holds 1e-11 of u; du/dφ reaches 1/dn.
                for (value, expected) in [(sn, phi.sin()), (cn, phi.cos()), (dn, expected_dn)] {
                    assert!((value - expected).abs() < 1e-10, "k' = {complement}, φ = {phi}: {value} {expected}");
                }
            }
        }
    }

    #[test]
    fn functions_take_their_special_values() {
        for complement in COMPLEMENTS {
            let quarter = quarter_period(complement);
            let at = |quarters: f64| jacobi(quarters * quarter, complement);
            let close = |value: f64, expected: f64, what: &str| {
                assert!((value - expected).abs() < 1e-11, "k' = {complement}, {what}: {value}, not {expected}");
            };
            close(at(0.0).sn, 0.0, "sn 0");
            close(at(0.0).cn, 1.0, "cn 0");
            close(at(0.0).dn, 1.0, "dn 0");
            close(at(1.0).sn, 1.0, "sn K");
            close(at(1.0).cn, 0.0, "cn K");
            close(at(1.0).dn, complement, "dn K");
            close(at(0.5).sn, (1.0 + complement).sqrt().recip(), "sn K/2");
            close(at(0.5).dn, complement.sqrt(), "dn K/2");
            close(at(2.0).cn, -1.0, "cn 2K");
            close(at(3.0).sn, -1.0, "sn 3K");
            close(at(41.0).sn, 1.0, "sn 41K");
            close(at(-1.0).sn, -1.0, "sn −K");
        }
    }
}
