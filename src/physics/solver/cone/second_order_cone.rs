//! The cone Q = { x₀ ≥ |x₁| } of three dimensions: its product, and the scaling of Nesterov & Todd (1997) by which
//! interior points step (formulas as in Vandenberghe, *The CVXOPT linear and quadratic cone program solvers*, 2010).

use nalgebra::{Matrix3, Vector3};

use super::law::width;

/// x₀² − |x₁|².
pub(super) fn determinant(x: &Vector3<f64>) -> f64 {
    let across = width(x);
    (x.x - across) * (x.x + across)
}

/// x ∘ y.
pub(super) fn product(x: &Vector3<f64>, y: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(x.dot(y), x.x * y.y + y.x * x.y, x.x * y.z + y.x * x.z)
}

/// y of x ∘ y = z.
pub(super) fn quotient(x: &Vector3<f64>, z: &Vector3<f64>) -> Vector3<f64> {
    let determinant = determinant(x);
    let across = x.y * z.y + x.z * z.z;
    let share = (across / x.x - z.x) / determinant;
    Vector3::new((x.x * z.x - across) / determinant, share * x.y + z.y / x.x, share * x.z + z.z / x.x)
}

/// The largest a for which x + a d is still in Q, x being inside.
pub(super) fn reach(x: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
    // det(x + a d) = det x + 2 b a + (d₀² − |d₁|²) a².
    let square = determinant(d);
    let half = x.x * d.x - x.y * d.y - x.z * d.z;
    let constant = determinant(x);
    let mut reach = if d.x < 0.0 { -x.x / d.x } else { f64::INFINITY };
    let discriminant = half * half - square * constant;
    if discriminant >= 0.0 {
        let sum = -(half + half.signum() * discriminant.sqrt());
        for root in [sum / square, constant / sum] {
            if root > 0.0 {
                reach = reach.min(root);
            }
        }
    }
    reach
}

/// W with W y = W⁻¹ x: W = η B(w), det w = 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaling {
    /// η².
    square: f64,
    w: Vector3<f64>,
}

impl Scaling {
    /// Of two points inside Q.
    pub fn new(x: &Vector3<f64>, y: &Vector3<f64>) -> Self {
        let [of_x, of_y] = [x, y].map(|point| determinant(point).max(f64::MIN_POSITIVE).sqrt());
        let (x, y) = (x / of_x, y / of_y);
        let half = (0.5 * (1.0 + x.dot(&y))).sqrt();
        Self { square: of_x / of_y, w: (x + Vector3::new(y.x, -y.y, -y.z)) / (2.0 * half) }
    }

    /// W².
    pub fn squared(&self) -> Matrix3<f64> {
        let reflection = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
        self.square * (2.0 * self.w * self.w.transpose() - reflection)
    }

    /// W v.
    pub fn times(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.square.sqrt() * boost(&self.w, v)
    }

    /// W⁻¹ v.
    pub fn under(&self, v: &Vector3<f64>) -> Vector3<f64> {
        boost(&Vector3::new(self.w.x, -self.w.y, -self.w.z), v) / self.square.sqrt()
    }
}

/// B(w) v.
fn boost(w: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let across = w.y * v.y + w.z * v.z;
    let share = v.x + across / (1.0 + w.x);
    Vector3::new(w.x * v.x + across, v.y + share * w.y, v.z + share * w.z)
}
