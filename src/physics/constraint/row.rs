//! The scalar constraint row of Catto (2005): a sparse pair of 1×6 Jacobian blocks with bounds
//! and a velocity bias.
//!
//! With V the velocities, F_ext the external forces and λ a force, each row asks for
//!
//! J M⁻¹ Jᵀ λ = bias/h − J (V₀/h + M⁻¹ F_ext),  λmin ≤ λ ≤ λmax.
//!
//! A soft row adds γ λ on the left (Catto 2011): with γ = 1/(h (h k + c)) and bias
//! −k C/(h k + c) it is the implicit Euler step of a spring k with damper c.
//!
//! Everything is generic over nalgebra's `SimdRealField`: one system in `f32` or `f64`, or as many
//! as there are lanes.

use nalgebra::{Matrix3, SimdRealField, Vector3};

/// A 1×12 row as two 1×6 blocks, linear and angular: J of one constraint (`Jsp`), or the columns
/// of M⁻¹Jᵀ (`Bsp`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowPair<N> {
    pub linear_a: Vector3<N>,
    pub angular_a: Vector3<N>,
    pub linear_b: Vector3<N>,
    pub angular_b: Vector3<N>,
}

/// Linear and angular velocity (or acceleration) of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Twist<N> {
    pub linear: Vector3<N>,
    pub angular: Vector3<N>,
}

/// Force and torque, or linear and angular impulse, on one body: what is dual to a twist.
pub(crate) type Wrench<N> = Twist<N>;

/// What a row needs to know of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyTerms<N> {
    /// Per world axis.
    pub inverse_mass: Vector3<N>,
    /// World axes.
    pub inverse_inertia: Matrix3<N>,
    /// V₀/h + M⁻¹ F_ext.
    pub free: Twist<N>,
}

/// Limits of a row's multiplier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bounds<N> {
    /// λmin ≤ λ ≤ λmax.
    Fixed(N, N),
    /// |λ| ≤ μ λ_n with λ_n the present multiplier of the row that many rows before.
    Friction { coefficient: N, normal_rows_back: u32 },
    /// √(Σλ²) ≤ `most` over `count` rows, at most 3, that stand together, of which this is number `place`, from 0.
    Norm { most: N, place: u32, count: u32 },
}

/// The force, or where it is larger than `most`, ≥ 0, the one of that Euclidean norm along it.
pub(crate) fn bounded<N: SimdRealField + Copy>(force: Vector3<N>, most: N) -> Vector3<N> {
    // As multiples of the largest component, whose square could be too much for `f32`.
    let largest = force.x.simd_abs().simd_max(force.y.simd_abs()).simd_max(force.z.simd_abs());
    let unit = largest.select(largest.simd_gt(N::zero()), N::one());
    let scaled = force.map(|along| along / unit);
    let size = unit * scaled.dot(&scaled).simd_sqrt();
    let share = (most / size).select(size.simd_gt(most), N::one());
    force * share
}

/// One scalar constraint between two bodies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<N> {
    /// Indices of the bodies.
    pub a: u32,
    pub b: u32,
    pub jacobian: RowPair<N>,
    /// M⁻¹Jᵀ.
    pub response: RowPair<N>,
    /// bias/h − J (V₀/h + M⁻¹ F_ext).
    pub target: N,
    /// γ; zero for a rigid row.
    pub softness: N,
    /// 1/(J M⁻¹Jᵀ + γ); zero where nothing can move.
    pub inverse_diagonal: N,
    pub bounds: Bounds<N>,
    pub lambda: N,
}

impl<N: SimdRealField + Copy> Twist<N> {
    pub fn zero() -> Self {
        Self { linear: Vector3::zeros(), angular: Vector3::zeros() }
    }

    /// The power of a wrench along it.
    pub fn dot(&self, wrench: &Wrench<N>) -> N {
        self.linear.dot(&wrench.linear) + self.angular.dot(&wrench.angular)
    }

    /// It and a share of another.
    pub fn plus(&self, other: &Self, share: N) -> Self {
        Self { linear: self.linear + other.linear * share, angular: self.angular + other.angular * share }
    }
}

impl<N: SimdRealField + Copy> Default for Twist<N> {
    fn default() -> Self {
        Self::zero()
    }
}

impl<N: SimdRealField + Copy> RowPair<N> {
    /// Of A (0) or of B (1).
    #[inline]
    pub fn of(&self, end: usize) -> Twist<N> {
        if end == 0 { self.of_a() } else { self.of_b() }
    }

    /// In another scalar.
    pub fn map<M: SimdRealField + Copy>(&self, of: impl Fn(N) -> M) -> RowPair<M> {
        let [linear_a, angular_a, linear_b, angular_b] =
            [self.linear_a, self.angular_a, self.linear_b, self.angular_b].map(|block| block.map(&of));
        RowPair { linear_a, angular_a, linear_b, angular_b }
    }

    /// Of the rows of A and of B.
    pub fn new(a: Twist<N>, b: Twist<N>) -> Self {
        Self { linear_a: a.linear, angular_a: a.angular, linear_b: b.linear, angular_b: b.angular }
    }

    pub fn of_a(&self) -> Twist<N> {
        Twist { linear: self.linear_a, angular: self.angular_a }
    }

    pub fn of_b(&self) -> Twist<N> {
        Twist { linear: self.linear_b, angular: self.angular_b }
    }

    /// J V.
    pub fn dot(&self, a: &Twist<N>, b: &Twist<N>) -> N {
        self.linear_a.dot(&a.linear)
            + self.angular_a.dot(&a.angular)
            + self.linear_b.dot(&b.linear)
            + self.angular_b.dot(&b.angular)
    }

    /// The row of a point constraint along `direction`: the velocity of B's point less that of
    /// A's. `arm_*` go from the centres of mass to the point.
    pub fn along(direction: Vector3<N>, arm_a: Vector3<N>, arm_b: Vector3<N>) -> Self {
        Self {
            linear_a: -direction,
            angular_a: -arm_a.cross(&direction),
            linear_b: direction,
            angular_b: arm_b.cross(&direction),
        }
    }

    /// M⁻¹Jᵀ.
    pub fn response(&self, a: &BodyTerms<N>, b: &BodyTerms<N>) -> Self {
        Self {
            linear_a: a.inverse_mass.component_mul(&self.linear_a),
            angular_a: a.inverse_inertia * self.angular_a,
            linear_b: b.inverse_mass.component_mul(&self.linear_b),
            angular_b: b.inverse_inertia * self.angular_b,
        }
    }

    /// J M⁻¹Jᵀ, given M⁻¹Jᵀ.
    pub fn diagonal(&self, response: &Self) -> N {
        self.linear_a.dot(&response.linear_a)
            + self.angular_a.dot(&response.angular_a)
            + self.linear_b.dot(&response.linear_b)
            + self.angular_b.dot(&response.angular_b)
    }
}

/// A damped spring as a row: stiffness and damping per effective mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring<N> {
    /// ω² = k/m, 1/s².
    pub stiffness: N,
    /// 2ζω = c/m, 1/s.
    pub damping: N,
    /// C, m.
    pub error: N,
}

impl<N: SimdRealField + Copy> Row<N> {
    /// A rigid row with a velocity bias, m/s; `h` is the time over which its force acts, s.
    pub fn rigid(
        (a, body_a): (u32, &BodyTerms<N>),
        (b, body_b): (u32, &BodyTerms<N>),
        jacobian: RowPair<N>,
        bias: N,
        h: N,
        bounds: Bounds<N>,
    ) -> Self {
        let response = jacobian.response(body_a, body_b);
        let diagonal = jacobian.diagonal(&response);
        let target = bias / h - jacobian.dot(&body_a.free, &body_b.free);
        let inverse_diagonal = reciprocal_or_zero(diagonal);
        Self { a, b, jacobian, response, target, softness: N::zero(), inverse_diagonal, bounds, lambda: N::zero() }
    }

    /// A spring along the row.
    pub fn soft(
        (a, body_a): (u32, &BodyTerms<N>),
        (b, body_b): (u32, &BodyTerms<N>),
        jacobian: RowPair<N>,
        spring: Spring<N>,
        h: N,
        bounds: Bounds<N>,
    ) -> Self {
        let mut row = Self::rigid((a, body_a), (b, body_b), jacobian, N::zero(), h, bounds);
        let diagonal = row.jacobian.diagonal(&row.response);
        let per_mass = h * spring.stiffness + spring.damping;
        // k and c are per effective mass 1/diagonal, so γ carries a factor diagonal.
        row.softness = diagonal * reciprocal_or_zero(h * per_mass);
        row.target -= spring.stiffness * spring.error * reciprocal_or_zero(per_mass) / h;
        row.inverse_diagonal = reciprocal_or_zero(diagonal + row.softness);
        row
    }
}

fn reciprocal_or_zero<N: SimdRealField + Copy>(value: N) -> N {
    let positive = value.simd_gt(N::zero());
    let safe = value.select(positive, N::one());
    safe.simd_recip().select(positive, N::zero())
}
