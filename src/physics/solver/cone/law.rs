//! The laws of one point: unilateral contact, with Coulomb friction or without, the ball joint, and a row whose impulse is
//! bounded.
//!
//! In the frame of a contact (normal n from A to B, then two tangents), with λ the impulse on B and u the velocity of
//! B's point relative to A's, Signorini's condition and Coulomb's law say (De Saxcé & Feng 1998)
//!
//! K* ∋ û ⊥ λ ∈ K,  û = u + μ|u_t| n,  K = { |λ_t| ≤ μ λ_n }.
//!
//! The shift μ|u_t| makes of Coulomb's law, whose slip is along the ground, one whose slip û is normal to the cone. A
//! contact without friction has K = { λ_n ≥ 0, λ_t = 0 } and K* = { û_n ≥ 0 }; a joint K = ℝ³ and K* = { 0 }. A row with
//! bounds has an interval for K, which is no cone: u = 0 inside, u ≥ 0 at its lower end, u ≤ 0 at its upper one. For all
//! of them the law holds where the natural map (Acary, Brémond & Huber 2018)
//!
//! r = λ/ρ − P_K(λ/ρ − û)
//!
//! is zero; with ρ the effective mass of the point, |r| is a velocity.

use nalgebra::{Matrix3, Vector3};

/// What an impulse may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// Any: three bilateral rows.
    Joint,
    /// Along the normal, not pulling.
    Frictionless,
    /// In Coulomb's cone of this μ > 0.
    Friction(f64),
    /// Along the first axis, within these, N·s.
    Within(f64, f64),
}

/// Where the projection on K lands, and so what its derivative is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    /// At zero, or at an end of an interval: the points part.
    Open,
    /// Inside: the points stick.
    Stick,
    /// On the cone's side, so high, along (1, μ t); `across` is the derivative along the cone's girth.
    Slip { height: f64, slant: Vector3<f64>, across: f64 },
}

impl Law {
    /// μ; of a joint and where there is none, zero.
    pub fn friction(self) -> f64 {
        match self {
            Self::Friction(friction) => friction,
            Self::Joint | Self::Frictionless | Self::Within(..) => 0.0,
        }
    }

    /// Whether it says something of the first axis alone.
    pub fn is_single(self) -> bool {
        matches!(self, Self::Frictionless | Self::Within(..))
    }

    /// μ|u_t|: how much De Saxcé's velocity is more along the normal.
    pub fn shift(self, velocity: &Vector3<f64>) -> f64 {
        self.friction() * width(velocity)
    }

    /// The part of a velocity that the law says something of.
    pub fn relevant(self, velocity: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Frictionless | Self::Within(..) => Vector3::new(velocity.x, 0.0, 0.0),
            Self::Joint | Self::Friction(_) => *velocity,
        }
    }

    /// û.
    pub fn shifted(self, velocity: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(velocity.x + self.shift(velocity), velocity.y, velocity.z)
    }

    /// Q (1 + μ n tᵀ), t = u_t/|u_t|: a derivative by û as one by u.
    pub fn with_shift(self, stiffness: Matrix3<f64>, velocity: &Vector3<f64>) -> Matrix3<f64> {
        let speed = width(velocity);
        if speed == 0.0 {
            return stiffness;
        }
        let along = Vector3::new(0.0, velocity.y, velocity.z) * (self.friction() / speed);
        stiffness + stiffness.column(0) * along.transpose()
    }

    /// P_K.
    pub fn project(self, vector: &Vector3<f64>) -> Vector3<f64> {
        match (self, self.mode(vector)) {
            (Self::Within(lower, upper), _) => Vector3::new(vector.x.max(lower).min(upper), 0.0, 0.0),
            (_, Mode::Open) => Vector3::zeros(),
            (Self::Frictionless, _) => Vector3::new(vector.x, 0.0, 0.0),
            (_, Mode::Stick) => *vector,
            (_, Mode::Slip { height, across, .. }) => Vector3::new(height, across * vector.y, across * vector.z),
        }
    }

    /// Where P_K lands.
    pub fn mode(self, vector: &Vector3<f64>) -> Mode {
        match self {
            Self::Joint => Mode::Stick,
            Self::Within(lower, upper) if lower < vector.x && vector.x < upper => Mode::Stick,
            Self::Within(..) => Mode::Open,
            Self::Frictionless if vector.x > 0.0 => Mode::Stick,
            Self::Frictionless => Mode::Open,
            Self::Friction(friction) => {
                let width = width(vector);
                if width <= friction * vector.x {
                    Mode::Stick
                } else if friction * width <= -vector.x {
                    Mode::Open
                } else {
                    let height = (vector.x + friction * width) / (1.0 + friction * friction);
                    let slant = Vector3::new(1.0, friction * vector.y / width, friction * vector.z / width);
                    Mode::Slip { height, slant: slant / friction.hypot(1.0), across: friction * height / width }
                }
            }
        }
    }

    /// r: how far an impulse and a velocity are from the law, ρ in kg.
    pub fn natural_map(self, impulse: &Vector3<f64>, velocity: &Vector3<f64>, mass: f64) -> Vector3<f64> {
        match self {
            Self::Joint => *velocity,
            Self::Frictionless => {
                let impulse = impulse.x / mass;
                Vector3::new(impulse - (impulse - velocity.x).max(0.0), 0.0, 0.0)
            }
            Self::Within(..) => (impulse - self.project(&(impulse - velocity * mass))) / mass,
            Self::Friction(_) => {
                let impulse = impulse / mass;
                impulse - self.project(&(impulse - self.shifted(velocity)))
            }
        }
    }
}

/// The length of a vector's last two parts. Not by `hypot`, whose care was a sixth of all time.
pub(super) fn width(vector: &Vector3<f64>) -> f64 {
    (vector.y * vector.y + vector.z * vector.z).sqrt()
}

impl Mode {
    /// Σ f(eigenvalue) e eᵀ over the eigenvectors e of the derivative A of P_K: a function of A.
    /// On the cone's side A is 1 along the slant, `across` along the girth and 0 along the side's normal.
    pub fn function(self, law: Law, of: impl Fn(f64) -> f64) -> Matrix3<f64> {
        let zero = of(0.0);
        match (self, law) {
            (Self::Open, _) => Matrix3::from_diagonal_element(zero),
            (Self::Stick, Law::Frictionless | Law::Within(..)) => {
                Matrix3::from_diagonal(&Vector3::new(of(1.0), zero, zero))
            }
            (Self::Stick, _) => Matrix3::from_diagonal_element(of(1.0)),
            (Self::Slip { slant, across, .. }, _) => {
                let girth = Vector3::new(0.0, -slant.z, slant.y) / width(&slant);
                Matrix3::from_diagonal_element(zero)
                    + (of(1.0) - zero) * slant * slant.transpose()
                    + (of(across) - zero) * girth * girth.transpose()
            }
        }
    }
}
