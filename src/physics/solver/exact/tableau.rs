//! Gauss's and Radau's collocation methods: nodes, weights and matrices.
//!
//! Gauss's nodes are the roots of the shifted Legendre polynomial of degree S; the method has order 2S, is symmetric,
//! symplectic and A-stable. Radau's (IIA) have one at the end; that method has order 2S − 1 and takes the energy of
//! oscillations that are short to the step (Hairer, Nørsett and Wanner 1993, Solving Ordinary Differential Equations I,
//! II.7; Hairer and Wanner 1996, II, IV.5). a_ij = ∫₀^{c_i} ℓ_j, b_j = ∫₀¹ ℓ_j with the Lagrange polynomials ℓ of the
//! nodes.

/// The method of S stages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tableau<const S: usize> {
    /// c.
    pub nodes: [f64; S],
    /// b.
    pub weights: [f64; S],
    /// A.
    pub matrix: [[f64; S]; S],
    /// A², which takes accelerations to places.
    pub squared: [[f64; S]; S],
    /// b A: from accelerations to the place at the end.
    pub last: [f64; S],
    /// L in A² = L U, lower triangular, where U has ones on its diagonal: with it in the place of A², a sweep over the
    /// stages in their order converges whatever the stiffness (van der Houwen and de Swart 1997, "Triangularly implicit
    /// iteration methods for ODE-IVP solvers"): I − (I + zL)⁻¹(I + zA²) of three stages has a spectral radius of 0.42 at
    /// most with Gauss's nodes, of 0.52 with Radau's, and of 0 as z grows.
    pub lower: [[f64; S]; S],
    /// ℓ_j(1 + c_i): from one step's stages to what the next one's may be.
    pub ahead: [[f64; S]; S],
}

impl<const S: usize> Default for Tableau<S> {
    fn default() -> Self {
        Self::gauss()
    }
}

impl<const S: usize> Tableau<S> {
    /// Gauss's, S from 1 to 4.
    pub fn gauss() -> Self {
        Self::of_nodes(gauss_nodes::<S>())
    }

    /// Radau's with a node at the end, S from 1 to 3.
    pub fn radau() -> Self {
        Self::of_nodes(radau_nodes::<S>())
    }

    /// Whether it is one of Radau's.
    pub fn damps(&self) -> bool {
        self.nodes[S - 1] == 1.0
    }

    fn of_nodes(nodes: [f64; S]) -> Self {
        let polynomials: [[f64; S]; S] = std::array::from_fn(|j| lagrange(&nodes, j));
        let integral = |j: usize, to: f64| {
            (0..S).rev().fold(0.0, |sum, power| (sum + polynomials[j][power] / (power + 1) as f64) * to)
        };
        let weights: [f64; S] = std::array::from_fn(|j| integral(j, 1.0));
        let matrix: [[f64; S]; S] = std::array::from_fn(|i| std::array::from_fn(|j| integral(j, nodes[i])));
        let squared: [[f64; S]; S] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..S).map(|k| matrix[i][k] * matrix[k][j]).sum()));
        let last = std::array::from_fn(|j| (0..S).map(|k| weights[k] * matrix[k][j]).sum());
        let mut tableau = Self { nodes, weights, matrix, squared, last, lower: lower_factor(squared), ahead: matrix };
        tableau.ahead = tableau.ahead_by(1.0, 1.0, &nodes);
        tableau
    }

    /// ℓ_j(s + r c_i), for a next step r times as long that starts after the share s of this one, with its own nodes c.
    pub fn ahead_by(&self, start: f64, ratio: f64, nodes: &[f64; S]) -> [[f64; S]; S] {
        let polynomials: [[f64; S]; S] = std::array::from_fn(|j| lagrange(&self.nodes, j));
        let value = |j: usize, at: f64| (0..S).rev().fold(0.0, |sum, power| sum * at + polynomials[j][power]);
        nodes.map(|node| std::array::from_fn(|j| value(j, start + ratio * node)))
    }
}

fn gauss_nodes<const S: usize>() -> [f64; S] {
    let roots: &[f64] = &match S {
        1 => vec![0.0],
        2 => vec![-(1.0_f64 / 3.0).sqrt(), (1.0_f64 / 3.0).sqrt()],
        3 => vec![-(0.6_f64).sqrt(), 0.0, (0.6_f64).sqrt()],
        _ => {
            let root = |sign: f64| (3.0 / 7.0 + sign * 2.0 / 7.0 * 1.2_f64.sqrt()).sqrt();
            vec![-root(1.0), -root(-1.0), root(-1.0), root(1.0)]
        }
    };
    std::array::from_fn(|i| 0.5 + 0.5 * roots[i])
}

fn radau_nodes<const S: usize>() -> [f64; S] {
    let nodes: &[f64] = &match S {
        1 => vec![1.0],
        2 => vec![1.0 / 3.0, 1.0],
        _ => vec![0.4 - 0.06_f64.sqrt(), 0.4 + 0.06_f64.sqrt(), 1.0],
    };
    std::array::from_fn(|i| nodes[i])
}

/// Coefficients of ℓ_j by power.
fn lagrange<const S: usize>(nodes: &[f64; S], j: usize) -> [f64; S] {
    let mut polynomial = [0.0; S];
    polynomial[0] = 1.0;
    for (_, node) in nodes.iter().enumerate().filter(|&(k, _)| k != j) {
        let scale = 1.0 / (nodes[j] - node);
        for power in (0..S).rev() {
            let lower = if power > 0 { polynomial[power - 1] } else { 0.0 };
            polynomial[power] = (lower - node * polynomial[power]) * scale;
        }
    }
    polynomial
}

/// L of Crout's factorisation.
fn lower_factor<const S: usize>(mut m: [[f64; S]; S]) -> [[f64; S]; S] {
    let mut lower = [[0.0; S]; S];
    for k in 0..S {
        let row = m[k];
        for (entry, rest) in lower[k..].iter_mut().zip(&mut m[k..]) {
            entry[k] = rest[k];
            let share = rest[k] / row[k];
            for (rest, above) in rest.iter_mut().zip(&row).skip(k) {
                *rest -= share * above;
            }
        }
    }
    lower
}

#[cfg(test)]
mod tests {
    use nalgebra::{SMatrix, SVector};

    use super::*;

    const STAGES: usize = 3;

    fn matrix(entries: &[[f64; STAGES]; STAGES]) -> SMatrix<f64, STAGES, STAGES> {
        SMatrix::from_fn(|i, j| entries[i][j])
    }

    /// Polynomials up to the order less one are integrated to rounding, and the next is not.
    #[test]
    fn methods_have_their_order() {
        for (tableau, order) in [(Tableau::<STAGES>::gauss(), 6), (Tableau::<STAGES>::radau(), 5)] {
            let off = |power: i32| {
                let sum: f64 = tableau.nodes.iter().zip(&tableau.weights).map(|(c, b)| b * c.powi(power)).sum();
                (sum - 1.0 / f64::from(power + 1)).abs()
            };
            assert!((0..order).all(|power| off(power) < 1e-15));
            assert!(off(order) > 1e-4, "{}", off(order));
        }
    }

    /// R(∞) = 1 − bᵀ A⁻¹ 1.
    #[test]
    fn radau_damps_what_is_stiff_and_gauss_does_not() {
        for (tableau, kept) in [(Tableau::<STAGES>::gauss(), -1.0), (Tableau::<STAGES>::radau(), 0.0)] {
            let inverse = matrix(&tableau.matrix).try_inverse().expect("regular");
            let weights = SVector::<f64, STAGES>::from(tableau.weights);
            let left = 1.0 - (weights.transpose() * inverse).sum();
            assert!((left - kept).abs() < 1e-12, "{left}");
            assert_eq!(tableau.damps(), kept == 0.0);
        }
    }

    #[test]
    fn sweeps_with_the_lower_factor_converge_whatever_the_stiffness() {
        for tableau in [Tableau::<STAGES>::gauss(), Tableau::<STAGES>::radau()] {
            for exponent in -2..=10 {
                let z = 10.0_f64.powi(exponent);
                let one = SMatrix::<f64, STAGES, STAGES>::identity();
                let swept = (one + matrix(&tableau.lower) * z).try_inverse().expect("regular");
                let left = one - swept * (one + matrix(&tableau.squared) * z);
                let after = (0..24).fold(one, |product, _| product * left);
                assert!(after.norm() < 1e-6, "{z}: {}", after.norm());
            }
        }
    }
}
