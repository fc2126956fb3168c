//! Gauss's collocation methods: nodes, weights and matrices.
//!
//! The nodes are the roots of the shifted Legendre polynomial of degree S; the method has order 2S, is symmetric,
//! symplectic and A-stable (Hairer, Nørsett and Wanner 1993, Solving Ordinary Differential Equations I, II.7; Hairer
//! and Wanner 1996, II, IV.5). a_ij = ∫₀^{c_i} ℓ_j, b_j = ∫₀¹ ℓ_j with the Lagrange polynomials ℓ of the nodes.

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
    /// Diagonal of L in A² = L U, L lower triangular and U with ones on its diagonal: what a sweep over the stages in
    /// their order, each with the share L_ii of its own, converges with whatever the stiffness (van der Houwen and de
    /// Swart 1997, "Triangularly implicit iteration methods for ODE-IVP solvers").
    pub pivots: [f64; S],
    /// ℓ_j(1 + c_i): from one step's stages to what the next one's may be.
    pub ahead: [[f64; S]; S],
}

impl<const S: usize> Default for Tableau<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const S: usize> Tableau<S> {
    /// S from 1 to 4.
    pub fn new() -> Self {
        let nodes = nodes::<S>();
        let polynomials: [[f64; S]; S] = std::array::from_fn(|j| lagrange(&nodes, j));
        let integral = |j: usize, to: f64| {
            (0..S).rev().fold(0.0, |sum, power| (sum + polynomials[j][power] / (power + 1) as f64) * to)
        };
        let weights: [f64; S] = std::array::from_fn(|j| integral(j, 1.0));
        let matrix: [[f64; S]; S] = std::array::from_fn(|i| std::array::from_fn(|j| integral(j, nodes[i])));
        let squared: [[f64; S]; S] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..S).map(|k| matrix[i][k] * matrix[k][j]).sum()));
        let last = std::array::from_fn(|j| (0..S).map(|k| weights[k] * matrix[k][j]).sum());
        let mut tableau = Self { nodes, weights, matrix, squared, last, pivots: pivots(squared), ahead: matrix };
        tableau.ahead = tableau.ahead_by(1.0, 1.0);
        tableau
    }

    /// ℓ_j(s + r c_i), for a next step r times as long that starts after the share s of this one.
    pub fn ahead_by(&self, start: f64, ratio: f64) -> [[f64; S]; S] {
        let polynomials: [[f64; S]; S] = std::array::from_fn(|j| lagrange(&self.nodes, j));
        let value = |j: usize, at: f64| (0..S).rev().fold(0.0, |sum, power| sum * at + polynomials[j][power]);
        std::array::from_fn(|i| std::array::from_fn(|j| value(j, start + ratio * self.nodes[i])))
    }
}

fn nodes<const S: usize>() -> [f64; S] {
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

fn pivots<const S: usize>(mut m: [[f64; S]; S]) -> [f64; S] {
    for k in 0..S {
        let row = m[k];
        for lower in &mut m[k + 1..] {
            let share = lower[k] / row[k];
            for (entry, above) in lower.iter_mut().zip(&row).skip(k) {
                *entry -= share * above;
            }
        }
    }
    std::array::from_fn(|i| m[i][i])
}
